"""A campaign on a cluster has the bytes of one process, whatever happens to its workers."""

import os
import threading
import time

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


def test_goes_on_where_it_was_stopped(scenario, tmp_path, client, expected):
    piste.distributed.montecarlo(scenario, 23, tmp_path, client)
    piste.distributed.montecarlo(scenario, RUNS, tmp_path, client)
    assert same(tmp_path, expected)


def test_stops_when_the_band_is_narrow(scenario, client):
    report = piste.distributed.montecarlo(scenario, RUNS, None, client, until=0.3)
    assert 1 < report["runs"] < RUNS
