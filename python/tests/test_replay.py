"""A replay from Python equals the program's, and its arrays are the library's memory."""

import csv
import json
import threading
import time

import numpy as np
import pandas
import piste
import pytest


def columns(file) -> dict[str, list[str]]:
    with open(file) as text:
        rows = list(csv.reader(text))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def test_tables_are_the_files(run, tmp_path):
    run.write(tmp_path)
    for name, frame in {"smoothed.csv": run.smoothed.to_pandas(), "filtered.csv": run.filtered.to_pandas()}.items():
        written = columns(tmp_path / name)
        assert list(frame.columns) == list(written)
        assert len(frame) == len(written["time_s"])
        for column, texts in written.items():
            decimals = len(texts[0].partition(".")[2])
            np.testing.assert_allclose(frame[column], np.array(texts, float), rtol=0, atol=0.51 * 10.0**-decimals)
    assert list(run.biases) == list(columns(tmp_path / "biases_smoothed.csv"))
    innovations = columns(tmp_path / "innovations.csv")
    assert list(run.innovations) == list(innovations)
    assert list(run.innovations["source"]) == innovations["source"]
    assert list(run.innovations["outcome"]) == innovations["outcome"]
    for column in ("residual_1", "residual_3", "sigma_3"):
        written = np.array([float(text or "nan") for text in innovations[column]])
        np.testing.assert_allclose(run.innovations[column], written, rtol=1e-5)
    assert json.loads((tmp_path / "summary.json").read_text()) == run.summary
    assert (tmp_path / "report.html").read_text() == run.report()


def test_verdict_is_that_of_the_summary(run):
    assert run.verdict == run.summary["verdict"]
    assert run.verdict["consistent"] is True  # the shipped run holds
    assert run.verdict["findings"] == []
    assert {"nis", "rejected"} <= set(run.verdict["sources"]["gnss[0].position"])


def test_index_is_time(run):
    frame = run.smoothed.to_pandas()
    assert frame.index.name == "gps_time"
    assert (frame.index == frame["time_s"]).all()
    dated = run.smoothed.to_pandas(week=2086)  # from 2019-12-29 on; GPS was then 18 s ahead of UTC
    expected = pandas.Timestamp("2019-12-29", tz="UTC") + pandas.Timedelta(seconds=frame["time_s"].iloc[0] - 18)
    assert abs(dated.index[0] - expected) < pandas.Timedelta(microseconds=1)


def test_arrays_are_shared(run):
    solution = run.smoothed
    first = {name: solution[name].__array_interface__["data"][0] for name in solution.names}
    # The rows of a block follow one another: the columns start within its first row.
    assert 0 < max(first.values()) - min(first.values()) < solution["time"].strides[0]
    again = run._run.smoothed.stored()
    assert all(again[name].__array_interface__["data"][0] == first[name] for name in first)
    assert not solution["v_wb"].flags.owndata
    with pytest.raises(ValueError):
        solution["v_wb"][0] = 0


def test_arrays_outlive_the_run(config):
    velocity = piste.replay(config, judged=False, smoother="none").filtered["v_wb"]
    assert np.isfinite(velocity).all()


def test_tables_in_place_of_files(run, imu, gnss):
    keys = {"estimate": ["gyro_bias", "accel_bias"], "smoother": "none"}
    lever_arm = "-0.06 0.03 -0.42 m"
    by_frames = piste.replay(
        imu=imu.to_pandas(), gnss=gnss.to_pandas(), sensor="xsens_mt9a", lever_arm=lever_arm, judged=False, **keys
    )
    arrays = {"imu": {"file": dict(imu), "sensor": "xsens_mt9a"}, "gnss": {"file": gnss, "lever_arm": lever_arm}}
    by_arrays = piste.replay(**arrays, judged=False, **keys)
    for name in by_frames.filtered.names:
        np.testing.assert_array_equal(by_frames.filtered[name], by_arrays.filtered[name])
    assert len(by_frames.filtered) == len(run.filtered)


def test_index_of_utc_tells_the_week(imu, gnss):
    def dated(table):
        frame = table.to_pandas(week=2086)
        return frame.drop(columns="time_s")

    keys = {"sensor": "xsens_mt9a", "lever_arm": "-0.06 0.03 -0.42 m", "smoother": "none", "judged": False}
    run = piste.replay(imu=dated(imu), gnss=dated(gnss), **keys)
    assert run.week == 2086
    assert str(run.filtered.to_pandas().index.tz) == "UTC"
    np.testing.assert_allclose(run.filtered.time[0], imu["time_s"][0], atol=0.1)


def test_columns_are_not_copied(monkeypatch, imu):
    taken = {}
    real = piste._piste.Configuration.parse

    def parse(text, name, tables, spelled):
        taken.update(tables)
        return real(text, name, tables, spelled)

    monkeypatch.setattr(piste.configuration._piste.Configuration, "parse", staticmethod(parse))
    with pytest.raises(piste.ConfigError):
        piste.replay(imu=imu, sensor="xsens_mt9a")
    for name, column in imu.items():
        assert taken["imu"][name].__array_interface__["data"] == column.__array_interface__["data"]


def test_errors_say_where(tmp_path, config):
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(f"base: {config}\nsmother: rts\n")
    with pytest.raises(piste.ConfigError, match="smoother") as raised:
        piste.replay(wrong)
    assert isinstance(raised.value, ValueError)
    assert (raised.value.file, raised.value.line) == (str(wrong), 2)

    table = {"time_s": np.array([0.0, np.nan])} | {
        f"{kind}_{axis}_{unit}": np.zeros(2) for kind, unit in (("gyro", "rad_s"), ("accel", "m_s2")) for axis in "xyz"
    }
    with pytest.raises(piste.DataError, match="time_s") as row:
        piste.replay(config, imu={"file": table, "sensor": "xsens_mt9a"})
    assert (row.value.file, row.value.line) == ("imu", 1)
    with pytest.raises(piste.ConfigError, match="give a configuration file"):
        piste.replay()
    with pytest.raises(piste.ConfigError, match="there is no file `nowhere.csv`"):
        piste.replay(imu="nowhere.csv", sensor="xsens_mt9a", span=None)
    with pytest.raises(piste.ConfigError, match="tables go by keyword"):
        piste.replay(pandas.DataFrame({"time_s": [0.0]}))
    with pytest.raises(piste.ConfigError, match="belongs to `imu`"):
        piste.replay(sensor="xsens_mt9a")
    with pytest.raises(piste.ConfigError, match="perhaps `lever_arm`"):
        piste.replay(config, gnss={"file": config.parent / "../data/ski_run/gnss.csv", "leverarm": "0 0 0 m"})


def test_errors_name_the_keyword(config, imu, gnss):
    """And no line of text from nobody."""
    tables = {"imu": imu, "gnss": gnss, "sensor": "xsens_mt9a"}
    for where, keys in (
        ("sensor=", {"sensor": "xsens_mt9"}),
        ("lever_arm=", {"lever_arm": "1 2 3"}),
        ("imu=", {"imu": "nowhere.csv"}),
        ("estimate=", {"estimate": ["gyro_bais"]}),
        ("smoother=", {"smoother": "rst"}),
        ("smother=", {"smother": "rts"}),
        ("gate=", {"gate": "high"}),
        ("initial.heading", {"initial": {"heading": "north"}}),
        ("gnss[1].file", {"gnss": [{"file": gnss}, {"file": "nowhere.csv"}]}),
    ):
        with pytest.raises(piste.ConfigError) as raised:
            piste.replay(**{**tables, **keys})
        assert str(raised.value).startswith(where + ": "), raised.value
        assert (raised.value.where, raised.value.file, raised.value.line) == (where, where, None)
        assert "keywords:" not in str(raised.value)


def test_a_unit_that_is_not_known_is_named(imu, gnss):
    frame = imu.to_pandas().rename(columns={f"gyro_{a}_rad_s": f"gyro_{a}_rpm" for a in "xyz"})
    with pytest.raises(piste.DataError) as raised:
        piste.replay(imu=frame, gnss=gnss, sensor="xsens_mt9a")
    for part in (
        "gyro_x_rad_s",
        "gyro_x_deg_s",
        "`gyro_x_rpm` is in a unit that is not known",
        "gyro_z_rpm, accel_x_m_s2",
    ):
        assert part in str(raised.value)


def test_exchanged_columns_are_asked_for(imu, gnss):
    frame = gnss.to_pandas()
    frame["latitude_deg"], frame["longitude_deg"] = frame["longitude_deg"] + 100, frame["latitude_deg"]
    with pytest.raises(piste.DataError, match="beyond 90 deg; are latitude and longitude exchanged"):
        piste.replay(imu=imu, gnss=frame, sensor="xsens_mt9a")


def test_a_run_without_smoother_says_so(config):
    run = piste.replay(config, smoother="none", judged=False)
    assert not run.has_smoothed and len(run.solution) == len(run.filtered)
    with pytest.raises(piste.ConfigError, match="was not smoothed"):
        run.smoothed  # noqa: B018


def test_frames_that_cannot_be_read_say_why(imu, gnss):
    frame = imu.to_pandas()
    keys = {"gnss": gnss, "sensor": "xsens_mt9a"}
    with pytest.raises(piste.DataError, match="imu: column `note` holds other things than numbers"):
        piste.replay(imu=frame.assign(note="x"), **keys)
    with pytest.raises(piste.DataError, match="imu: `time_s` is float32"):
        piste.replay(imu=frame.astype("float32"), **keys)
    with pytest.raises(piste.DataError, match="imu: no gyroscope"):
        piste.replay(imu=frame.rename(columns={"gyro_x_rad_s": "GyroX"}), **keys)


def test_names_that_are_not_there_say_which_are(run):
    for table, there in (
        (run.smoothed, "v_wb"),
        (run.biases, "gyro_bias_x_deg_s"),
        (run.smoothed.navigation, "height_m"),
    ):
        with pytest.raises(KeyError, match=there):
            table["heigth"]
        assert there in repr(table)
    with pytest.raises(piste.ConfigError, match="height_m"):
        run.plot(["heigth"])


def test_bar(config, capsys):
    piste.replay(config, judged=False, progress=True)
    said = capsys.readouterr().err
    assert "[==" in said and "%" in said and said.endswith("\n")


def test_progress_and_what_it_raises(config):
    stages = []
    piste.replay(config, progress=lambda stage, part: stages.append((stage, part)))
    assert all(0 <= part <= 1 for _, part in stages)
    assert len({stage for stage, _ in stages}) >= 2

    class Enough(Exception):
        pass

    def stop(stage, part):
        raise Enough

    started = time.perf_counter()
    with pytest.raises(Enough):
        piste.montecarlo(piste.share + "/scenarios/montecarlo/ski_l1l2.yaml", 1000, jobs=1, progress=stop)
    assert time.perf_counter() - started < 60


def test_other_threads_run_meanwhile(config):
    ticks = 0
    done = threading.Event()

    def count():
        nonlocal ticks
        while not done.wait(0.01):
            ticks += 1

    thread = threading.Thread(target=count)
    thread.start()
    started = time.perf_counter()
    piste.replay(config, judged=False)
    elapsed = time.perf_counter() - started
    done.set()
    thread.join()
    assert ticks > 0.3 * elapsed / 0.01


def test_plot(run):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    figure = run.plot(["height_m", "gyro_bias_x_deg_s"], sigmas=3)
    assert len(figure.axes) == 3
    assert all(axes.has_data() for axes in figure.axes)
    assert figure.axes[2].collections  # the band
    assert [axes.get_ylabel() for axes in figure.axes[1:]] == ["height [m]", "gyro bias x [deg/s]"]
    heading = run.plot(["heading_deg"]).axes[1].lines[0].get_ydata()
    steps = np.abs(np.diff(heading))
    assert np.isnan(heading).any() and np.nanmax(steps) < 180  # no stroke from 180° to -180°


def part_of(table, start, seconds):
    """A frame of some seconds of a log."""
    frame = table.to_pandas()
    start += frame["time_s"].iloc[0]
    return frame[(frame["time_s"] >= start) & (frame["time_s"] < start + seconds)]


def test_tables_of_wrong_shapes_say_which_column(imu, gnss):
    keys = {"gnss": gnss, "sensor": "xsens_mt9a"}
    columns = dict(imu)
    x = columns["gyro_x_rad_s"]
    for wrong, why in (
        ({"gyro_x_rad_s": x[:, None]}, "`gyro_x_rad_s` has 2 dimensions"),
        ({"gyro_x_rad_s": 1.0}, "`gyro_x_rad_s` has 0 dimensions"),
        ({"gyro_x_rad_s": x.astype(complex)}, "complex"),
        ({"time_s": columns["time_s"].astype("datetime64[s]")}, "holds dates"),
        ({"gyro_x_rad_s": np.ma.masked_array(x, np.arange(len(x)) == 5)}, "row 5: column `gyro_x_rad_s`"),
    ):
        with pytest.raises(piste.DataError, match=why):
            piste.replay(imu={**columns, **wrong}, **keys)
    frame = imu.to_pandas()
    with pytest.raises(piste.DataError, match="`gyro_x_rad_s` has 2 dimensions"):
        piste.replay(imu=pandas.concat([frame, frame[["gyro_x_rad_s"]]], axis=1), **keys)
    with pytest.raises(piste.DataError, match="column `time_s` is missing"):
        piste.replay(imu={("t" if name == "time_s" else name): column for name, column in columns.items()}, **keys)
    with pytest.raises(piste.ConfigError, match="whose columns have names"):
        piste.replay(imu=frame.to_numpy(), **keys)


def test_a_structured_array_is_a_table(imu, gnss):
    rows = part_of(imu, 50, 30)
    keys = {"gnss": part_of(gnss, 50, 30), "sensor": "xsens_mt9a", "judged": False}
    frame, records = piste.replay(imu=rows, **keys), piste.replay(imu=rows.to_records(index=False), **keys)
    np.testing.assert_array_equal(frame.smoothed["v_wb"], records.smoothed["v_wb"])


def test_dates(imu, gnss):
    """Tables with dates on each side of the end of a GPS week, without a row, and without dates."""
    end_of_week = pandas.Timestamp("2020-01-04T23:59:42")
    rows, fixes = part_of(imu, 50, 40), part_of(gnss, 50, 40)

    def dated(frame):
        passed = pandas.to_timedelta(frame["time_s"].to_numpy() - rows["time_s"].iloc[0] - 10, unit="s")
        return frame.drop(columns="time_s").set_index(end_of_week + passed)

    keys = {"sensor": "xsens_mt9a", "judged": False}
    run = piste.replay(imu=dated(rows), gnss=dated(fixes[fixes["time_s"] > rows["time_s"].iloc[0] + 12]), **keys)
    index = run.smoothed.to_pandas().index
    assert abs(index[-1] - dated(rows).index[-1].tz_localize("UTC")) < pandas.Timedelta(milliseconds=1)
    with pytest.raises(piste.DataError, match="fewer than two"):
        piste.replay(imu=dated(rows).iloc[:0], gnss=dated(fixes), **keys)
    none = dated(rows)
    none.index = none.index.where(np.arange(len(none)) != 9)
    with pytest.raises(piste.DataError, match="no time there") as raised:
        piste.replay(imu=none, gnss=dated(fixes), **keys)
    assert (raised.value.file, raised.value.line) == ("imu", 9)


def test_several_logs_and_their_names(config, imu, gnss, tmp_path):
    folder = tmp_path / "ä ✓ 🎿"
    folder.mkdir()
    keys = {"sensor": "xsens_mt9a", "judged": False}
    part_of(imu, 50, 30).to_csv(folder / "imu, #1: a.csv", index=False, float_format="%.9f")
    part_of(gnss, 50, 30).to_csv(folder / 'gnss\'s "own".csv', index=False, float_format="%.10f")
    log, fixes = folder / "imu, #1: a.csv", str(folder / 'gnss\'s "own".csv')
    piste.replay(imu=log, gnss=fixes, **keys)
    piste.replay(imu=log, gnss=[fixes], **keys)
    second = config.parent / "../data/ski_run/gnss_l1.csv"
    two = piste.replay(imu=log, gnss=[fixes, {"file": second}], **keys)
    assert set(two.innovations["source"]) >= {"gnss[0].position", "gnss[1].position"}
    with pytest.raises(piste.ConfigError, match="state it for each"):
        piste.replay(imu=log, gnss=[fixes, second], lever_arm="0 0 0 m", **keys)
    with pytest.raises(piste.ConfigError, match="mappings are expected"):
        piste.replay(config, gnss=[{"file": fixes}], vehicle=[{"kind": "car"}, 3])
    with pytest.raises(piste.ConfigError, match="odometer"):
        piste.replay(config, odometer=log)
    with pytest.raises(piste.ConfigError, match="unknown key `a: b`"):
        piste.replay(config, **{"a: b": 1})


def test_names_of_a_solution(run):
    assert "v_wb" in run.smoothed and "heigth" not in run.smoothed
    assert list(run.smoothed) == run.smoothed.names
