"""Monte Carlo campaigns on a Dask cluster.

The runs are cut into parts of at least a second. Parts come back in any order and are merged in the order of their
seeds, by sums that do not depend on how the runs were cut (C++: piste/consistency/range_sums.h). So the files have the
bytes that the program `montecarlo` writes, whatever the workers, their order, and how often a part was tried again.
"""

import os
import tempfile
import time
from typing import TYPE_CHECKING, Any

from . import _piste
from .programs import Path, finished
from .runs import Progress

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

SHORTEST = 1.0  # s of work that a part should be worth
SAVE_EVERY = 5.0  # s
STATE = "ensemble.state"


def part(scenario: str, first: int, runs: int) -> bytes:
    """The sums of some runs, on one core."""
    ensemble = _piste.Ensemble.begin(_piste.Configuration.load(scenario), first)
    ensemble.run(runs, 1)
    return ensemble.save()


def local_cluster(workers: int = _piste.cores) -> "LocalCluster":
    """A cluster of this machine's cores. Its workers keep freed memory and are not profiled, which would cost a run 5 %."""
    import dask
    from distributed import LocalCluster

    lean = {"distributed.nanny.pre-spawn-environ": {"OMP_NUM_THREADS": 1}, "distributed.worker.profile.enabled": False}
    with dask.config.set(lean):
        return LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)


def montecarlo(
    scenario: Path,
    runs: int,
    output: Path | None = None,
    client: "Client | None" = None,
    *,
    until: float | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Simulates and replays a scenario `runs` times on a cluster, and writes the files of the program into `output`.

    `client`: of any cluster whose workers have piste and see the scenario's file at the same path; without one, a
    cluster of this machine's cores. A killed worker costs the parts that it was at, which others do again. With `output`
    a campaign that was stopped goes on where it was. `until`: no more runs than make the band, in which the mean NEES of
    all states at one epoch must lie, as narrow as 1 ± `until`.
    Returns consistency.json.
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

    started = time.perf_counter()
    if len(ensemble) == 0:  # one here tells how long a run is
        ensemble.append(part(path, 0, 1))
    chunk = max(1, round(SHORTEST / max(time.perf_counter() - started, 1e-3)))
    if until is not None:
        runs = max(len(ensemble), min(runs, ensemble.runs_within(until)))
    _run_parts(ensemble, path, runs, chunk, client, state, progress)
    return finished(ensemble, path, output)


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
    ahead = 100 * workers * chunk  # runs that may wait for one before them: what they hold is kept here
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
    """So that the file is whole or not there."""
    folder = os.path.dirname(file) or "."
    os.makedirs(folder, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=folder, delete=False) as beside:
        beside.write(content)
    os.replace(beside.name, file)
