"""The filter and the live session from Python."""

import threading
import time

import numpy as np
import piste
import pytest


def triple(table, pattern, axes, i):
    return [table[pattern.format(axis)][i] for axis in axes]


NED = ("north", "east", "down")


def add_fix(target, gnss, i):
    target.add_gnss(
        gnss["time_s"][i],
        [gnss["latitude_deg"][i], gnss["longitude_deg"][i], gnss["height_m"][i]],
        triple(gnss, "sigma_{}_m", NED, i),
        triple(gnss, "velocity_{}_m_s", NED, i),
        triple(gnss, "sigma_velocity_{}_m_s", NED, i),
    )


def test_filter_in_batches_is_the_filter_one_by_one(run, gnss):
    samples = run.samples
    start = run._run.filtered.stored()["time"][0]
    rows = np.flatnonzero(samples["time"] > start)[:2000]
    filters = [piste.filter_of(run) for _ in range(2)]
    for f in filters:
        for i in np.flatnonzero(gnss["time_s"] < samples["time"][rows[-1]]):
            add_fix(f, gnss, i)
    columns = [samples[name] for name in ("time", "interval", "dtheta", "dvel")]
    filters[0].add(*(c[rows[0] : rows[-1] + 1] for c in columns))
    for i in rows:
        filters[1].add(*(c[i : i + 1] for c in columns))
    a, b = (f.state() for f in filters)
    for name in a:
        np.testing.assert_array_equal(a[name], b[name])
    np.testing.assert_array_equal(filters[0].covariance, filters[1].covariance)
    n = sum(3 if name not in ("gnss_delay",) else 1 for name in filters[0].blocks)
    assert filters[0].covariance.shape == (n, n)
    assert filters[0].late == 0


def test_filter_from_a_start(config, run):
    at = {name: column[0] for name, column in run.filtered.navigation.items()}
    f = piste.Filter(
        config,
        time=at["time_s"],
        position=[at["latitude_deg"], at["longitude_deg"], at["height_m"]],
        velocity=[0, 0, 0],
        euler=[at["roll_deg"], at["pitch_deg"], at["heading_deg"]],
        sigma_position=[1, 1, 2],
        sigma_velocity=[0.1, 0.1, 0.1],
        sigma_euler=[1, 1, 3],
    )
    state = f.state()
    assert abs(state["latitude_deg"] - at["latitude_deg"]) < 1e-9
    np.testing.assert_allclose(state["sigma_euler_deg"], [1, 1, 3], rtol=0.1)


def test_live(config, imu, gnss):
    live = piste.Live(config)
    gyro = np.column_stack([imu[f"gyro_{a}_rad_s"] for a in "xyz"])
    accel = np.column_stack([imu[f"accel_{a}_m_s2"] for a in "xyz"])
    edges = np.searchsorted(imu["time_s"], gnss["time_s"])
    last = 0
    for i, edge in enumerate(edges[:400]):
        live.add(imu["time_s"][last:edge], gyro[last:edge], accel[last:edge])
        last = max(last, edge)
        add_fix(live, gnss, i)
    state = live.now()
    assert state is not None
    assert abs(state["latitude_deg"] - gnss["latitude_deg"][min(399, len(edges) - 1)]) < 1e-3


START = {
    "time": 0.0,
    "position": [46, 7, 2500],
    "velocity": [0, 0, 0],
    "euler": [0, 0, 0],
    "sigma_position": [1, 1, 1],
    "sigma_velocity": [0.1, 0.1, 0.1],
    "sigma_euler": [1, 1, 1],
}
NONE = float("nan")


def test_a_start_that_cannot_be_is_refused(config):
    piste.Filter(config, **START)
    for wrong in (
        {"time": NONE},
        {"position": [100, 7, 0]},
        {"position": [NONE, 7, 0]},
        {"velocity": [NONE, 0, 0]},
        {"euler": [0, NONE, 0]},
        {"sigma_position": [0, 1, 1]},
        {"sigma_velocity": [-1, 1, 1]},
        {"sigma_euler": [NONE, 1, 1]},
    ):
        with pytest.raises(piste.ConfigError, match=next(iter(wrong)).split("_")[0]):
            piste.Filter(config, **{**START, **wrong})


def test_what_cannot_be_is_refused_and_the_filter_goes_on(config):
    filters = [piste.Filter(config, **START) for _ in range(2)]
    time, interval = np.array([0.01, 0.02]), np.full(2, 0.01)
    turn, force = np.zeros((2, 3)), np.tile([0, 0, -0.0981], (2, 1))
    for f in filters:
        f.add(time, interval, turn, force)
        f.add_gnss(0.025, [46, 7, 2500], [1, 1, 1])
    wrong = filters[0]
    for change in (
        {"time": NONE},
        {"position": [NONE, 7, 0]},
        {"position": [200, 7, 0]},
        {"sigma": [0, 1, 1]},
        {"receiver": 5},
    ):
        with pytest.raises(piste.DataError):
            wrong.add_gnss(**{"time": 0.025, "position": [46, 7, 2500], "sigma": [1, 1, 1], **change})
    with pytest.raises(piste.DataError, match="no receiver -1"):
        wrong.add_gnss(0.025, [46, 7, 2500], [1, 1, 1], receiver=-1)
    for rows in (
        (time, interval, turn, force),
        (time + 0.02, interval, turn + NONE, force),
        (time + 0.02, 0 * interval, turn, force),
    ):
        with pytest.raises(piste.DataError, match="a sample must be finite"):
            wrong.add(*rows)
    with pytest.raises(piste.DataError, match="float32, which tells times of a week to 0.03 s"):
        wrong.add(time.astype(np.float32), interval, turn, force)
    with pytest.raises(piste.DataError, match="`dtheta`: three numbers"):
        wrong.add(time + 0.02, interval, turn[:, :2], force)
    with pytest.raises(piste.DataError, match="another array 1"):
        wrong.add(time + 0.02, interval[:1], turn, force)
    for f in filters:
        f.add(time + 0.02, interval, turn, force)
        f.finish()
    a, b = (f.state() for f in filters)
    for name in a:
        np.testing.assert_array_equal(a[name], b[name])


def test_a_row_may_be_numbers(config, imu, gnss):
    """A row given as scalars and triples of any type equals the row of an array."""
    rows, pieces = piste.Live(config), piste.Live(config)
    gyro = np.column_stack([imu[f"gyro_{a}_rad_s"] for a in "xyz"])
    accel = np.column_stack([imu[f"accel_{a}_m_s2"] for a in "xyz"])
    last = np.searchsorted(imu["time_s"], gnss["time_s"][60])
    following = 0
    for i in range(last):
        while gnss["time_s"][following] <= imu["time_s"][i]:
            for live in (rows, pieces):
                add_fix(live, gnss, following)
            following += 1
        pieces.add(imu["time_s"][i : i + 1], gyro[i : i + 1], accel[i : i + 1])
        kinds = (list, tuple, np.asarray)
        rows.add(float(imu["time_s"][i]) if i % 2 else imu["time_s"][i], kinds[i % 3](gyro[i]), kinds[i % 2](accel[i]))
    a, b = rows.now(), pieces.now()
    assert a is not None
    for name in a:
        np.testing.assert_array_equal(a[name], b[name])
    assert abs(a["time_s"] - imu["time_s"][last - 1]) < 1e-6  # the newest row, independent of the last pass
    f = piste.Filter(config, **START)
    f.add(0.01, 0.01, [0, 0, 0], (0, 0, -0.0981))
    f.add(np.array([0.02]), np.array([0.01]), np.zeros((1, 3)), np.array([[0, 0, -0.0981]]))
    assert f.finish()


def test_wrong_rows_are_errors_of_piste(config):
    live = piste.Live(config)
    live.add(1, [0, 0, 0], [0, 0, -9.81])
    up = [0, 0, -9.81]
    for what, row in (
        ("`time`", ("now", [0, 0, 0], up)),
        ("`time`", (None, [0, 0, 0], up)),
        ("`gyro`", (2, [0, 0], up)),
        ("`gyro`", (2, 0.0, up)),
        ("`gyro`", (2, ["a", "b", "c"], up)),
        ("`accel`", (2, [0, 0, 0], None)),
        ("`gyro`", (np.array([2.0, 3.0]), np.zeros((2, 2)), np.zeros((2, 3)))),
        ("`accel`", (np.array([2.0, 3.0]), np.zeros((2, 3)), [[1, 2, 3], [1, 2]])),
        ("2 rows", (np.array([2.0, 3.0]), np.zeros((3, 3)), np.zeros((2, 3)))),
        ("`time` is float32", (np.array([2.0, 3.0], dtype=np.float32), np.zeros((2, 3)), np.zeros((2, 3)))),
        ("does not increase", (1, [0, 0, 0], up)),
        ("must be finite", (2, [0, NONE, 0], up)),
    ):
        with pytest.raises(piste.DataError, match=what):
            live.add(*row)
    fix = {"time": 0.025, "position": [46, 7, 2500], "sigma": [1, 1, 1]}
    for what, change in (
        ("`time`", {"time": "now"}),
        ("`position`", {"position": [46, 7]}),
        ("`sigma`", {"sigma": 1}),
        ("`velocity`", {"velocity": "fast", "sigma_velocity": [1, 1, 1]}),
        ("needs its sigma", {"velocity": [0, 0, 0]}),
        ("exchanged", {"position": [107, 46, 2500]}),
    ):
        with pytest.raises(piste.DataError, match=what):
            live.add_gnss(**{**fix, **change})
    with pytest.raises(piste.ConfigError, match="^smother=: unknown key"):
        piste.Live(config, smother="rts")


def test_threads_share_a_session(config, imu, gnss):
    """One thread adds the rows of the IMU, another the fixes, and a third reads."""
    live = piste.Live(config)
    gyro = np.column_stack([imu[f"gyro_{a}_rad_s"] for a in "xyz"])
    accel = np.column_stack([imu[f"accel_{a}_m_s2"] for a in "xyz"])
    newest, given, done, failed = [imu["time_s"][0]], [gnss["time_s"][0]], threading.Event(), []

    def rows():
        for i in range(0, 8000, 50):
            live.add(imu["time_s"][i : i + 50], gyro[i : i + 50], accel[i : i + 50])
            newest[0] = imu["time_s"][i + 49]
            while given[0] < newest[0] - 0.5 and not failed:  # no receiver is later than that
                time.sleep(0)

    def fixes():
        i = 0
        while not done.is_set():
            while gnss["time_s"][i] <= newest[0]:
                add_fix(live, gnss, i)
                given[0] = gnss["time_s"][i]
                i += 1

    def looks():
        while not done.is_set():
            live.now()

    def guarded(work):
        try:
            work()
        except Exception as error:
            failed.append(error)

    others = [threading.Thread(target=guarded, args=(work,)) for work in (fixes, looks)]
    for thread in others:
        thread.start()
    guarded(rows)
    done.set()
    for thread in others:
        thread.join()
    assert not failed
    assert live.late == 0
    assert abs(live.now()["height_m"] - gnss["height_m"][np.searchsorted(gnss["time_s"], newest[0]) - 1]) < 10
