#!/usr/bin/env python3
"""Compares the numbers of two builds, in sigmas of the first. usage: compare.py WANTED IS     (files of `numbers`)

Prints one row. Exit 0: values differ by no more than 1e-6 of their sigma, those of the batch by 1e-3, and all that is
chosen is the same; 1: not so.
"""

import math
import sys
from pathlib import Path

BOUNDS = {"filter": 1e-6, "smoother": 1e-6, "batch": 1e-3}


def read(path):
    """Values and sigmas by kind, time and name; and what was chosen."""
    values, chosen = {}, []
    for line in Path(path).read_text(encoding="utf-8").splitlines():
        kind, *rest = line.split(" ")
        if kind == "=":
            chosen.append(line)
        else:
            time, name, value, sigma = rest
            values[kind, time, name] = float(value), float(sigma)
    return values, chosen


def apart(wanted, found):
    """The largest difference of a kind in sigmas, and where it is. Sigmas are compared likewise, as shares of themselves."""
    worst = {}
    for key, (value, sigma) in wanted.items():
        other, other_sigma = found[key]
        difference = value - other
        if "euler" in key[2]:
            difference = math.remainder(difference, 2 * math.pi)
        change = max(abs(difference) / sigma, abs(other_sigma / sigma - 1))
        worst[key[0]] = max(worst.get(key[0], (0.0, "")), (change, f"{key[2]} at {key[1]} s"))
    return worst


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    (wanted, chosen), (found, other) = read(sys.argv[1]), read(sys.argv[2])
    kinds = {kind for kind, *_ in found}  # a build may lack the batch
    wanted = {key: pair for key, pair in wanted.items() if key[0] in kinds}
    good, notes = True, []
    if wanted.keys() != found.keys():
        good, notes = False, ["other rows"]
    else:
        for kind, (change, where) in apart(wanted, found).items():
            notes.append(f"{kind} {change:.1e} sigma" + (f" ({where})" if change > BOUNDS[kind] else ""))
            good = good and change <= BOUNDS[kind]
    moved = sum(a != b for a, b in zip(chosen, other)) + abs(len(chosen) - len(other))
    if moved:
        good = False
        notes.append(f"{moved} of {len(chosen)} outcomes")
    print(f"{Path(sys.argv[2]).stem:9} {'same ' if good else 'OTHER'}  {', '.join(notes)}", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
