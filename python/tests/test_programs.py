"""Each function writes what its program writes."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import piste
import pytest

SHARE = piste.share


def test_simulate_inspect_replay(tmp_path):
    simulation = piste.simulate(SHARE + "/scenarios/ski_run.yaml", seed=7, output=tmp_path / "logs")
    again = piste.simulate(SHARE + "/scenarios/ski_run.yaml", seed=7)
    name = next(iter(simulation.imus))
    np.testing.assert_array_equal(simulation.imus[name]["gyro_x_rad_s"], again.imus[name]["gyro_x_rad_s"])
    truth = simulation.truth()
    assert truth.rows > 1000
    assert simulation.errors["seed"] == 7
    with pytest.raises(piste.ConfigError, match="there is no IMU 9"):
        simulation.truth(9)
    with pytest.raises(piste.ConfigError, match="seed: -1 is too few"):
        piste.simulate(SHARE + "/scenarios/ski_run.yaml", seed=-1)
    assert name in repr(simulation) and "seed 7" in repr(simulation)

    logs = [tmp_path / "logs" / name, tmp_path / "logs" / next(iter(simulation.gnss))]
    inspection = piste.inspect(*logs, output=tmp_path / "inspection")
    assert "looks wrong" in str(inspection) or inspection.suspicions is not None
    assert inspection.report().startswith("<!")
    assert f"{len(inspection.suspicions)} things look wrong" in repr(inspection)
    run = piste.replay(tmp_path / "inspection/replay.yaml", judged=False)
    found = run.smoothed.navigation
    last = np.searchsorted(truth["time_s"], found["time_s"][-1]) - 1
    row = np.searchsorted(found["time_s"], truth["time_s"][last])
    assert abs(found["height_m"][row] - truth["height_m"][last]) < 10


def test_read_says_what_a_log_is(imu):
    assert imu.kind == "imu"
    assert "gyro_x_rad_s" in imu
    with pytest.raises(piste.DataError) as raised:
        piste.read(__file__)
    assert (raised.value.file, raised.value.line) == (__file__, 1)
    assert str(raised.value).count(__file__) == 1
    for files in ((), ("nowhere.csv",), (imu,), (5,)):
        with pytest.raises(piste.ConfigError):
            piste.read(*files)
    for files in ((), ("nowhere.csv",), (5,)):
        with pytest.raises(piste.ConfigError):
            piste.inspect(*files)


def test_tune(config, tmp_path):
    part = tmp_path / "part.yaml"
    part.write_text(f"base: {config}\nspan: {{start: 302490 s, end: 302550 s}}\n")
    found = piste.tune(part, output=tmp_path)
    assert "noises" in found
    assert json.loads((tmp_path / "tune.json").read_text())["noises"] == found["noises"]
    page = (tmp_path / "tune.html").read_text()
    assert str(found["report"]) == page and "Likelihood gained" in page
    with pytest.raises(piste.ConfigError, match="builds on a file"):
        piste.tune(config, output=tmp_path, smoother="none")


def test_allan(tmp_path):
    random = np.random.default_rng(1)
    gyro, accel = random.normal(0, 0.1, (30000, 3)), random.normal(0, 0.02, (30000, 3)) - [0, 0, 9.81]
    rows = np.column_stack([np.arange(30000) / 100, gyro, accel])
    log = tmp_path / "rest.csv"
    header = "time_s," + ",".join(f"gyro_{a}_deg_s" for a in "xyz") + "," + ",".join(f"accel_{a}_m_s2" for a in "xyz")
    np.savetxt(log, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    found = piste.allan(log, output=tmp_path / "allan")
    assert found["sensor"] == (tmp_path / "allan/sensor.yaml").read_text()
    assert "gyro" in found["sensor"]


def test_montecarlo_is_the_program(scenario, tmp_path):
    for wrong in ({"runs": 0}, {"runs": 2, "jobs": 0}, {"runs": 2, "jobs": -1}):
        with pytest.raises(piste.ConfigError, match="at least 1"):
            piste.montecarlo(scenario, **wrong)
    with pytest.raises(piste.ConfigError, match="2.5 is no whole number"):
        piste.montecarlo(scenario, 2.5)
    report = piste.montecarlo(scenario, 3, jobs=2, output=tmp_path)
    assert json.loads((tmp_path / "consistency.json").read_text()) == report
    assert {"ensemble.state", "consistency.md", "consistency.html"} <= set(os.listdir(tmp_path))
    program = os.environ.get("PISTE_PROGRAMS")
    if program is None:
        pytest.skip("PISTE_PROGRAMS does not name the folder of the programs")
    subprocess.run(
        [f"{program}/montecarlo", scenario, "--runs", "3", "--quiet", "--output", tmp_path / "program"], check=True
    )
    for name in ("consistency.json", "consistency.html", "ensemble.state"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "program" / name).read_bytes()


@pytest.fixture(scope="module")
def long_run(tmp_path_factory):
    """Logs of 25 minutes of skiing with a reference IMU, for long work."""
    folder = tmp_path_factory.mktemp("long")
    scenario = folder / "scenario.yaml"
    sensors = f"{SHARE}/sensors"
    scenario.write_text(
        f"base: {SHARE}/scenarios/ski_run.yaml\n"
        "motion: {run: 1500 s}\n"
        "imus:\n"
        f"  - {{name: mt9a, sensor: {sensors}/xsens_mt9a.yaml, boresight: 1.9 -2.4 2.1 deg, rate: 100 Hz}}\n"
        f"  - {{name: ln200, sensor: {sensors}/ln200.yaml, position: -0.06 -0.05 0.03 m, rate: 200 Hz}}\n"
    )
    piste.simulate(scenario, output=folder)
    (folder / "campaign.yaml").write_text(
        "runs:\n"
        "  - name: one\n"
        "    activity: ski\n"
        f"    reference: {{file: ln200.csv, sensor: {sensors}/ln200.yaml}}\n"
        "    gnss: {file: gnss.csv, lever_arm: 0.07 0.13 -0.48 m}\n"
        f"    mems: [{{name: MT-9A, file: mt9a.csv, sensor: {sensors}/xsens_mt9a.yaml}}]\n"
    )
    return folder


def work_of(name, long_run, scenario):
    """A call that takes some seconds."""
    imu, gnss, reference = (str(long_run / log) for log in ("mt9a.csv", "gnss.csv", "ln200.csv"))
    pair = f"imu={{'file': {imu!r}, 'sensor': 'xsens_mt9a'}}, reference={{'file': {reference!r}, 'sensor': 'ln200'}}"
    replayed = f"imu={imu!r}, gnss={gnss!r}, sensor='xsens_mt9a', estimate=['gyro_bias', 'accel_bias']"
    return {
        "inspect": f"piste.inspect({imu!r}, {gnss!r})",
        "replay": f"piste.replay({replayed})",
        "batch": f"piste.replay({replayed}, smoother='batch')",
        "tune": f"piste.tune({replayed})",
        "align": f"piste.align({pair})",
        "compare": f"piste.compare({pair})",
        "study": f"piste.study({str(long_run / 'campaign.yaml')!r})",
        "montecarlo": f"piste.montecarlo({str(scenario)!r}, 100000, jobs=2)",
        "allan": f"piste.allan({imu!r}, robust=True)",
        "simulate": f"piste.simulate({SHARE + '/scenarios/ski_run.yaml'!r}, motion={{'run': '20000 s'}})",
    }[name]


@pytest.mark.parametrize(
    "name", ["inspect", "replay", "batch", "tune", "align", "compare", "study", "montecarlo", "allan", "simulate"]
)
def test_ctrl_c_ends_the_work_within_a_second(name, long_run, scenario):
    code = f"""
import signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job of the background is deaf
import piste
print("on", flush=True)
try:
    while True:  # a fast machine is soon done
        {work_of(name, long_run, scenario)}
except KeyboardInterrupt:
    print(time.monotonic())
"""
    for after in (0.1, 0.9, 3.0):
        with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stdout.readline()
            time.sleep(after)
            asked = time.monotonic()  # the same clock in all processes
            process.send_signal(signal.SIGINT)
            said, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors.decode()
        print(f"{name}, after {after} s: {float(said) - asked:.3f} s")
        assert float(said) - asked < 1


def test_interrupt_ends_the_program(scenario):
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); import piste; print('on', flush=True);"
    code += f" piste.montecarlo({str(scenario)!r}, 100000, jobs=2)"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.readline()
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode != 0
    assert b"KeyboardInterrupt" in errors


def test_inspect_takes_frames(imu, gnss, tmp_path):
    """As replay does: with the columns of csv, or with others. It writes them next to the configuration."""
    told = []
    frames = [imu.to_pandas(), gnss.to_pandas().rename(columns={"latitude_deg": "Lat", "longitude_deg": "Lon"})]
    inspection = piste.inspect(*frames, output=tmp_path / "found", progress=lambda *now: told.append(now))
    assert "table_1.csv: IMU" in str(inspection) and "table_2.csv: GNSS" in str(inspection)
    assert json.loads((tmp_path / "found/inspection.json").read_text())["rounds"], "its loop is closed as that of files"
    run = piste.replay(tmp_path / "found/replay.yaml", judged=False)
    assert run.summary["imu"]["epochs"] > 20000
    np.testing.assert_array_equal(piste.read(tmp_path / "found/table_1.csv")["gyro_x_rad_s"], imu["gyro_x_rad_s"])
    parts = [part for _, part in told]
    assert parts == sorted(parts) and len({stage for stage, _ in told}) > 2 and parts[-1] > 0.5
    with pytest.raises(piste.DataError, match="holds other things than numbers"):
        piste.inspect(frames[0].assign(note="x"))
    mixed = piste.inspect(imu, os.path.join(os.path.dirname(__file__), "../../data/ski_run/gnss.csv"))
    assert "table_1.csv compared with" in str(mixed)


def test_evaluate(tmp_path, config):
    track = os.path.join(os.path.dirname(config), "../data/ski_run/truth.csv")
    if not os.path.exists(track):
        pytest.skip("the shipped run is not beside its configuration")
    found = piste.evaluate(track, track, align="se3", rpe=["50m"], output=tmp_path / "out")
    assert found["ape"]["max_m"] < 1e-9
    assert found["rpe"]["50 m"]["pairs"] > 5
    assert json.loads((tmp_path / "out/evaluation.json").read_text())["epochs"] == found["epochs"]
    with pytest.raises(piste.ConfigError, match="se4"):
        piste.evaluate(track, track, align="se4")


def test_export(tmp_path, config):
    run = piste.replay(config, judged=False)
    run.write(tmp_path / "run")
    file = piste.export(tmp_path / "run", "numpy")
    arrays = np.load(file)
    np.testing.assert_allclose(arrays["time_s"], run.smoothed.navigation["time_s"], atol=1e-6)
    with pytest.raises(piste.DataError, match="week"):
        piste.export(tmp_path / "run", "gpx")
    assert piste.export(tmp_path / "run", "gpx", week=2200, output=tmp_path / "run.gpx").endswith("run.gpx")
    with pytest.raises(piste.ConfigError, match="shapefile"):
        piste.export(tmp_path / "run", "shapefile")
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        with pytest.raises(piste.ConfigError, match="pyarrow"):
            piste.export(tmp_path / "run", "parquet")
    try:
        import rosbags  # noqa: F401
    except ImportError:
        with pytest.raises(piste.ConfigError, match="rosbags"):
            piste.export(tmp_path / "run", "rosbag", week=2200)
