"""What Python costs beside C++: python bench/python_costs.py CONFIG [TIMES]

A replay with its verdict and without its outputs, and a sample in Filter.add in batches, in CPU time: the least of TIMES (9) new
processes of each kind, which take turns. The C++ is build/release/bench/python_costs (scripts/setup python_costs).
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import piste

PROGRAM = Path(__file__).parents[1] / "build/release/bench/python_costs"


def measure(config: str) -> None:
    """Prints seconds of a replay, and microseconds of a sample."""
    started = time.process_time()
    run = piste.replay(config)
    replayed = time.process_time() - started
    columns = [run.samples[name] for name in ("time", "interval", "dtheta", "dvel")]
    navigation = piste.filter_of(run)
    first = int(np.searchsorted(columns[0], navigation.time, side="right"))
    started = time.process_time()
    navigation.add(*(column[first:] for column in columns))
    print(replayed, 1e6 * (time.process_time() - started) / (len(columns[0]) - first))


def least(commands: dict[str, list[str]], times: int) -> dict[str, np.ndarray]:
    found: dict[str, list[list[float]]] = {name: [] for name in commands}
    for _ in range(times):
        for name, command in commands.items():
            said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            found[name].append([float(word) for word in said.split()])
    return {name: np.min(values, axis=0) for name, values in found.items()}


def main() -> None:
    config, times = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 9
    if times == 0:
        measure(config)
        return
    commands = {"C++": [str(PROGRAM), config], "Python": [sys.executable, __file__, config, "0"]}
    found = least(commands, times)
    for name, (replay, add) in found.items():
        print(f"{name:<7} replay {replay:.3f} s, Filter.add {add:.3f} µs a sample")
    ratio = found["Python"] / found["C++"]
    print(f"ratio   replay {ratio[0]:.3f}, Filter.add {ratio[1]:.3f}")


if __name__ == "__main__":
    main()
