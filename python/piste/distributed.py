"""Monte Carlo campaigns and studies on a Dask cluster.

The runs of a Monte Carlo are cut into parts of at least a second. Parts return in any order and are merged in the order
of their seeds, by sums that do not depend on how the runs were cut (C++: piste/consistency/range_sums.h). So the files
have the bytes that the program `montecarlo` writes. Neither the workers, nor their order, nor repeated parts change
them.
"""

import json
import os
import tempfile
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _piste, programs
from .errors import ConfigError
from .programs import finished
from .progress import Progress, told
from .runs import Path

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

# s: least work of a part, or for many workers this many seconds for each worker. A part costs client and scheduler half
# of it (docs/python.md).
SHORTEST, FOR_EACH_WORKER = 1.0, 0.01
SAVE_EVERY = 5.0  # s
STATE = "ensemble.state"


def part(scenario: str, first: int, runs: int) -> bytes:
    """The sums of some runs, on one core."""
    ensemble = _piste.Ensemble.begin(_piste.Configuration.load(scenario), first)
    ensemble.run(runs, 1)
    return ensemble.save()


def local_cluster(workers: int = _piste.cores) -> "LocalCluster":
    """A cluster of this machine's cores, whose own processes hardly load the cores.

    Workers keep freed memory and are not profiled, because profiling would cost a run 5 %. All processes poll about
    once a second. By default Dask polls every 20 to 500 ms, which takes 9 % of a core.
    """
    import dask
    from distributed import LocalCluster

    lean = {
        "distributed.nanny.pre-spawn-environ": {"OMP_NUM_THREADS": 1},
        "distributed.worker.profile.enabled": False,
        "distributed.worker.memory.monitor-interval": "1s",
        "distributed.admin.tick.interval": "1s",
        "distributed.admin.system-monitor.interval": "5s",
        "distributed.scheduler.work-stealing-interval": "1s",
    }
    with dask.config.set(lean):
        return LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)


def montecarlo(
    scenario: Path,
    runs: int,
    output: Path | None = None,
    client: "Client | None" = None,
    *,
    until: float | None = None,
    progress: Progress | bool | None = None,
) -> dict[str, Any]:
    """Simulates and replays a scenario `runs` times on a cluster, and writes the files of the program into `output`.

    `client`: of any cluster whose workers have piste and see the scenario's file at the same path; without one, a
    cluster of this machine's cores. The parts of a killed worker are repeated by others. With `output`, a stopped
    campaign continues. `until`: stops at the number of runs with which the band of the mean NEES of all states at one
    epoch is as narrow as 1 ± `until`. Returns consistency.json.
    """
    if client is None:
        with local_cluster() as cluster, cluster.get_client() as local:
            return montecarlo(scenario, runs, output, local, until=until, progress=progress)

    path = os.path.abspath(os.fspath(scenario))
    configuration = _piste.Configuration.load(path)
    ensemble = _piste.Ensemble.begin(configuration)
    state = None if output is None else os.path.join(os.fspath(output), STATE)
    if state is not None and os.path.exists(state):
        with open(state, "rb") as file:
            ensemble.resume(file.read())
        if len(ensemble) > runs:
            ensemble = _piste.Ensemble.begin(configuration)

    started = time.process_time()  # CPU time measures the work on a busy machine, too
    if len(ensemble) < runs:  # one local run measures the time of a run
        ensemble.append(part(path, len(ensemble), 1))
    worth = max(SHORTEST, FOR_EACH_WORKER * sum(client.nthreads().values()))
    chunk = max(1, round(worth / max(time.process_time() - started, 1e-3)))
    if until is not None:
        runs = max(len(ensemble), min(runs, ensemble.runs_within(until)))
    _run_parts(ensemble, path, runs, chunk, client, state, told(progress))
    return finished(ensemble, path, output)


def study(
    campaigns: Sequence[Path],
    output: Path | None = None,
    client: "Client | None" = None,
    *,
    progress: Progress | bool | None = None,
) -> list[dict[str, Any]]:
    """Studies several campaigns on a cluster, each in its own task: summary.json of each, in their order.

    With `output`, each writes the files of the program `study` into a folder there with the name of its file. A
    campaign whose summary exists there is not studied again. `client` as for montecarlo(): its workers see the
    campaigns, and `output`, at the same paths. The campaigns of a killed worker are repeated by others. One campaign is
    not cut, because its tables need all of its runs: piste.study() uses several cores for it.
    """
    names = [os.path.splitext(os.path.basename(os.fspath(campaign)))[0] for campaign in campaigns]
    if len(set(names)) < len(names):
        raise ConfigError("two campaigns have the same name, and would have the same folder", "campaigns")
    if client is None:
        with local_cluster() as cluster, cluster.get_client() as local:
            return study(campaigns, output, local, progress=progress)

    from distributed import as_completed

    tell = told(progress)
    found: dict[int, dict[str, Any]] = {}
    places: dict[Future, int] = {}
    for place, (campaign, name) in enumerate(zip(campaigns, names, strict=True)):
        folder = None if output is None else os.path.abspath(os.path.join(os.fspath(output), name))
        if folder is not None and os.path.exists(os.path.join(folder, "summary.json")):
            with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
                found[place] = json.load(file)
            continue
        path = os.path.abspath(os.fspath(campaign))
        places[client.submit(_studied, path, folder, pure=False, retries=5)] = place
    for future, summary in as_completed(list(places), with_results=True):
        found[places[future]] = summary
        if tell is not None:
            tell("study", len(found) / len(names))
    return [found[place] for place in range(len(names))]


def _studied(campaign: str, folder: str | None) -> dict[str, Any]:
    """summary.json of a campaign, on one core."""
    summary = programs.study(campaign, jobs=1, output=folder)
    del summary["report"]
    return summary


def _run_parts(
    ensemble: _piste.Ensemble,
    scenario: str,
    runs: int,
    chunk: int,
    client: "Client",
    state: str | None,
    progress: Progress | None,
) -> None:
    """Fills the ensemble up to `runs`, and saves it in the file `state` now and then."""
    from distributed import as_completed

    workers = max(1, sum(client.nthreads().values()))
    ahead = 100 * workers * chunk  # runs that may wait for an earlier one: their sums are kept here
    following = len(ensemble)
    first_of: dict[Future, int] = {}
    waiting: dict[int, bytes] = {}  # by first run
    running = as_completed(with_results=True)
    saved = time.monotonic()

    def submit() -> None:
        nonlocal following
        while following < min(runs, len(ensemble) + ahead) and running.count() < 3 * workers:
            size = min(chunk, runs - following)
            future = client.submit(part, scenario, following, size, pure=False, retries=5)
            first_of[future] = following
            running.add(future)
            following += size

    submit()
    for future, sums in running:
        waiting[first_of.pop(future)] = sums
        while (due := waiting.pop(len(ensemble), None)) is not None:
            ensemble.append(due)
        if progress is not None:
            progress("montecarlo", len(ensemble) / runs)
        if state is not None and time.monotonic() - saved > SAVE_EVERY:
            _save(state, ensemble.save())
            saved = time.monotonic()
        submit()


def _save(file: str, content: bytes) -> None:
    """Writes a file whole or not at all."""
    folder = os.path.dirname(file) or "."
    os.makedirs(folder, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=folder, delete=False) as beside:
        beside.write(content)
    os.replace(beside.name, file)
