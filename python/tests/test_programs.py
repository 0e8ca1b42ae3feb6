"""Each function writes what its program writes."""

import json
import os
import signal
import subprocess
import sys

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
        with pytest.raises(piste.ConfigError):
            piste.inspect(*files)


def test_tune(config, tmp_path):
    part = tmp_path / "part.yaml"
    part.write_text(f"base: {config}\nspan: {{start: 302490 s, end: 302550 s}}\n")
    found = piste.tune(part, output=tmp_path)
    assert "noises" in found
    assert json.loads((tmp_path / "tune.json").read_text())["noises"] == found["noises"]
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


def test_interrupt_ends_the_work(scenario):
    tell = "progress=lambda *_: print('on', flush=True)"
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"  # a job of the background is deaf
    code = f"{heard}; import piste; piste.montecarlo({str(scenario)!r}, 100000, jobs=2, {tell})"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode != 0
    assert b"KeyboardInterrupt" in errors
