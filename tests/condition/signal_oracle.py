#!/usr/bin/env python3
"""What scipy makes of test signals: signal_oracle.csv, which tests/condition/signal.cpp reads.

    signal_oracle.py FILE           writes it
    signal_oracle.py --check FILE   fails unless scipy says the same again
"""

import csv
import math
import sys

import numpy
from scipy import signal

COLUMNS = ["case", "order", "cutoff_hz", "rate_hz", "extension", "input", "causal", "zero_phase"]

# order, cut-off [Hz], rate [Hz], samples
CASES = [
    (1, 3, 100, 100), (1, 12, 100, 1), (1, 45, 100, 30), (2, 0.5, 100, 300), (2, 12, 100, 2), (3, 12, 100, 3),
    (3, 20, 512, 200), (4, 0.5, 100, 300), (4, 12, 100, 1), (4, 12, 100, 2), (4, 12, 100, 7), (4, 12, 100, 60),
    (4, 12, 100, 400), (4, 45, 100, 100), (5, 12, 100, 40), (6, 30, 200, 150), (7, 10, 100, 100), (8, 0.1, 100, 300),
    (8, 12, 100, 300), (9, 5, 400, 120), (10, 12, 100, 120), (11, 49, 100, 120), (12, 12, 100, 300), (12, 40, 100, 100),
]


def test_signal(count):
    """Tones, a ramp, a step and noise of a linear congruential generator."""
    state, values = 1 + count, []
    for k in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(round(math.sin(0.31 * k) + 0.4 * math.cos(1.7 * k) + 0.01 * k + (k > count // 2)
                            + state / 2**31, 6))
    return numpy.array(values)


def rows():
    for case, (order, cutoff, rate, count) in enumerate(CASES):
        sections = signal.butter(order, cutoff, fs=rate, output="sos")
        values = test_signal(count)
        causal, _ = signal.sosfilt(sections, values, zi=signal.sosfilt_zi(sections) * values[0])
        # Until 1e-9 of a disturbance is left.
        radius = max(abs(signal.butter(order, cutoff, fs=rate, output="zpk")[1]))
        extension = min(math.ceil(order + math.log(1e-9) / math.log(radius)), count - 1)
        both = signal.sosfiltfilt(sections, values, padtype="odd", padlen=extension)
        for value in zip(values.tolist(), causal.tolist(), both.tolist()):
            yield [case, order, cutoff, rate, extension, *value]


def check(file):
    with open(file, newline="") as stream:
        header, *old = csv.reader(stream)
    new = list(rows())
    if header != COLUMNS or len(old) != len(new):
        sys.exit(f"{file}: not what this script writes; write it again")
    for line, (was, now) in enumerate(zip(old, new), start=2):
        if any(abs(float(a) - b) > 1e-9 * max(1, abs(b)) for a, b in zip(was, now)):
            sys.exit(f"{file}:{line}: {was}, but scipy says {now}")


def write(file):
    with open(file, "w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows())


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--check", file]:
            check(file)
        case [file]:
            write(file)
        case _:
            sys.exit(__doc__)
