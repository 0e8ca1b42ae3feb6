"""What a campaign on Dask costs beside the program: python bench/campaign.py [RUNS [TIMES]]

RUNS (10000) runs of a ride of six seconds by `montecarlo --jobs 2`, and by piste.distributed.montecarlo on a local cluster of two
workers, of which one is killed at a third of the way (with TIMES, both are done so often, in turns, and none is killed). Compares
the bytes of the files, and prints wall and CPU time of all processes of each.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import piste.distributed

SOURCE = Path(__file__).parents[1]
PROGRAM = SOURCE / "build/release/apps/montecarlo"
SCENARIO = """base: {base}
motion: {{rest_before: 1 s, run: 5 s, start_time: 1 s, stop_time: 1 s, rest_after: 0 s}}
"""
FILES = ("consistency.json", "consistency.html", "consistency.md", "ensemble.state")


class Cost:
    """Wall and CPU seconds of this process and its children since it was made."""

    def __init__(self) -> None:
        self._start = self._now()

    def taken(self) -> tuple[float, float]:
        wall, cpu = self._now()
        return wall - self._start[0], cpu - self._start[1]

    @staticmethod
    def _now() -> tuple[float, float]:
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return time.monotonic(), sum(u.ru_utime + u.ru_stime for u in used)


def by_program(scenario: Path, runs: int, folder: Path) -> tuple[float, float]:
    cost = Cost()
    command = [PROGRAM, scenario, "--runs", str(runs), "--jobs", "2", "--quiet", "--output", folder]
    subprocess.run(command, check=True)
    return cost.taken()


def by_dask(scenario: Path, runs: int, folder: Path, kills: bool) -> tuple[float, float]:
    with piste.distributed.local_cluster(2) as cluster, cluster.get_client() as client:
        client.run(_ready)
        killed = []

        def tell(_: str, part: float) -> None:
            if kills and not killed and part > 1 / 3:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], 9)
                print(f"worker {killed[0]} killed at {part:.0%}", flush=True)

        before = Cost()
        busy = sum(client.run(_cpu).values())
        piste.distributed.montecarlo(scenario, runs, folder, client, progress=tell)
        wall, cpu = before.taken()
        cpu += sum(client.run(_cpu).values()) - busy
    return wall, cpu


def _ready() -> None:
    import piste.distributed  # noqa: F401


def _cpu() -> float:
    return time.process_time()


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    times = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    costs: dict[str, list[tuple[float, float]]] = {"program": [], "Dask": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenario = folder / "short.yaml"
        scenario.write_text(SCENARIO.format(base=SOURCE / "config/scenarios/montecarlo/bicycle_l1l2.yaml"))
        for turn in range(max(times, 1)):
            ours, theirs = folder / f"program_{turn}", folder / f"dask_{turn}"
            costs["program"].append(by_program(scenario, runs, ours))
            costs["Dask"].append(by_dask(scenario, runs, theirs, times == 0))
            differ = [file for file in FILES if (ours / file).read_bytes() != (theirs / file).read_bytes()]
            print(f"{runs} runs: {'the same bytes' if not differ else f'other bytes in {differ}'}", flush=True)
            for who, cost in costs.items():
                print(f"  {who:<8} wall {cost[-1][0]:7.1f} s, CPU {cost[-1][1]:7.1f} s", flush=True)
    if times:
        wall, cpu = (min(c[i] for c in costs["program"]) / min(c[i] for c in costs["Dask"]) for i in (0, 1))
        print(f"efficiency of Dask beside the program, the least of {times}: wall {wall:.1%}, CPU {cpu:.1%}")


if __name__ == "__main__":
    main()
