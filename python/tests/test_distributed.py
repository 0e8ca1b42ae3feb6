"""A campaign on a cluster has the bytes of one process, whatever happens to its workers."""

import os
import threading
import time

import numpy as np
import piste
import pytest

distributed = pytest.importorskip("distributed")
import piste.distributed  # noqa: E402

RUNS = 60


@pytest.fixture(scope="module")
def expected(scenario, tmp_path_factory):
    folder = tmp_path_factory.mktemp("alone")
    piste.montecarlo(scenario, RUNS, jobs=2, output=folder)
    return folder


@pytest.fixture(scope="module")
def client():
    with piste.distributed.local_cluster(2) as cluster, cluster.get_client() as client:
        yield client


def same(folder, expected):
    return all(
        (folder / name).read_bytes() == (expected / name).read_bytes()
        for name in ("consistency.json", "consistency.html", "consistency.md", "ensemble.state")
    )


def test_same_bytes_with_a_worker_killed(scenario, tmp_path, client, expected, monkeypatch):
    monkeypatch.setattr(piste.distributed, "SHORTEST", 0.2)
    killed = []

    def kill():
        time.sleep(1)
        process = next(iter(client.run(os.getpid).items()))
        os.kill(process[1], 9)
        killed.append(process[1])

    thread = threading.Thread(target=kill)
    thread.start()
    piste.distributed.montecarlo(scenario, RUNS, tmp_path, client)
    thread.join()
    assert killed
    assert same(tmp_path, expected)


def test_goes_on_where_it_was_stopped(scenario, tmp_path, client, expected, monkeypatch):
    piste.distributed.montecarlo(scenario, 23, tmp_path, client)
    monkeypatch.setattr(piste.distributed, "SHORTEST", 0.2)
    sizes = []
    submit = client.submit
    monkeypatch.setattr(client, "submit", lambda *args, **keys: [sizes.append(args[3]), submit(*args, **keys)][1])
    piste.distributed.montecarlo(scenario, RUNS, tmp_path, client)
    assert same(tmp_path, expected)
    assert sum(sizes) == RUNS - 24  # one was run here, to measure the time of a run
    assert len(sizes) > 1
    piste.distributed.montecarlo(scenario, RUNS, tmp_path, client)
    assert same(tmp_path, expected) and sum(sizes) == RUNS - 24


def test_stops_when_the_band_is_narrow(scenario, client):
    report = piste.distributed.montecarlo(scenario, RUNS, None, client, until=0.3)
    assert 1 < report["runs"] < RUNS


@pytest.fixture(scope="module")
def campaigns(scenario, tmp_path_factory):
    """Two campaigns of one short run each, whose reference is the IMU itself with other noise."""
    folder = tmp_path_factory.mktemp("campaigns")
    simulation = piste.simulate(scenario, output=folder)
    imu, gnss = next(iter(simulation.imus)), next(iter(simulation.gnss))
    table = simulation.imus[imu]
    rows = np.column_stack([table[name] for name in table])
    rows[:, 1:] += np.random.default_rng(1).normal(0, 1e-3, rows[:, 1:].shape)
    np.savetxt(folder / "reference.csv", rows, delimiter=",", header=",".join(table), comments="", fmt="%.9g")
    sensor = f"sensor: {piste.share}/sensors/xsens_mt9a.yaml"
    files = []
    for name in ("first", "second"):
        file = folder / f"{name}.yaml"
        file.write_text(
            f"runs:\n  - name: {name}\n    activity: bicycle\n    reference: {{file: reference.csv, {sensor}}}\n"
            f"    gnss: {{file: {gnss}}}\n    mems: [{{name: MT-9A, file: {imu}, {sensor}}}]\n"
        )
        files.append(file)
    return files


def test_campaigns_are_studied_as_by_one_process(campaigns, tmp_path, client):
    told = []
    found = piste.distributed.study(campaigns, tmp_path, client, progress=lambda stage, part: told.append(part))
    assert sorted(told)[-1] == 1
    for campaign, summary in zip(campaigns, found, strict=True):
        alone = piste.study(campaign, output=tmp_path / "alone")
        assert "table_1.csv" in os.listdir(tmp_path / campaign.stem)
        assert (tmp_path / campaign.stem / "summary.json").read_bytes() == (
            tmp_path / "alone/summary.json"
        ).read_bytes()
        assert {**summary, "report": None} == {**alone, "report": None}

    written = (tmp_path / "first/summary.json").stat().st_mtime_ns
    assert piste.distributed.study(campaigns, tmp_path, client) == found
    assert (tmp_path / "first/summary.json").stat().st_mtime_ns == written
    with pytest.raises(piste.ConfigError, match="same name"):
        piste.distributed.study([campaigns[0], campaigns[0]], tmp_path, client)
