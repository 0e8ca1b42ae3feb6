"""Do the sigmas hold where nothing is stated? Recordings by an independent simulator, `inspect`, `replay`, the truth.

usage: strangers.py PROGRAMS FOLDER [--seed N] [--only WORD] [--least SHARE]

PROGRAMS: the folder of piste's programs. Recordings and results go to FOLDER, the table to standard output: the share
of errors inside 3 sigma, the rms of error over sigma, and the rms error, each filtered | smoothed, under way, of places,
velocities (means over 0.2 s), tilt and heading. A row holds where at least 95 % of its places are inside 3 sigma,
filtered and smoothed, of all and of the 15 s that were withheld, and their rms over sigma is 0.4 to 2; less where the
receiver itself states too much.
Exit 0: at least SHARE of the recordings hold, 0.8 unless stated; 1: fewer do.
"""

import argparse
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from simulator import DEGREE, RECEIVERS, Truth, ecef, euler, north_east_down, record, rotation

PLAN = [
    ("car", "phone", "phone", 50),
    ("car", "hobby", "navigator", 100),
    ("car", "industrial", "rtk too sure", 100),
    ("car", "tactical", "rtk", 200),
    ("bicycle", "phone", "navigator", 100),
    ("bicycle", "industrial", "single", 100),
    ("bicycle", "hobby", "positions", 50),
    ("walk", "phone", "phone", 100),
    ("walk", "industrial", "rtk", 100),
    ("walk", "hobby", "navigator", 50),
    ("rover", "hobby", "single", 100),
    ("rover", "industrial", "rtk too sure", 100),
    ("rover", "industrial", "positions", 50),
    ("drone", "hobby", "navigator", 200),
    ("drone", "industrial", "rtk", 200),
    ("drone", "phone", "single", 100),
    ("boat", "industrial", "navigator", 50),
    ("boat", "tactical", "rtk", 100),
    ("boat", "hobby", "phone", 50),
]


@dataclass
class Errors:
    """Of one quantity: [rows × axes], with sigmas."""

    error: np.ndarray
    sigma: np.ndarray

    def within(self) -> float:
        return float(np.mean(np.abs(self.error) < 3 * self.sigma))

    def normalised(self) -> float:
        return float(np.sqrt(np.mean((self.error / self.sigma) ** 2)))

    def size(self) -> float:
        return float(np.sqrt(np.mean(np.sum(self.error**2, 1))))

    def at(self, rows) -> "Errors":
        return Errors(self.error[rows], self.sigma[rows])


def table(file: Path) -> dict[str, np.ndarray]:
    with file.open() as stream:
        names = stream.readline().strip().split(",")
    return dict(zip(names, np.genfromtxt(file, delimiter=",", skip_header=1).T))


def columns(rows, *names):
    return np.stack([rows[name] for name in names], -1)


def axes_of(config: str) -> np.ndarray:
    """Rows: forward, right and down in the sensor's axes, as `axes: -y +x +z` has them."""
    found = re.search(r"^\s*axes:\s*([^#\n]+)", config, re.M)
    axes = np.zeros((3, 3))
    for row, word in zip(axes, found.group(1).split() if found else ["x", "y", "z"]):
        row["xyz".index(word[-1])] = -1 if word[0] == "-" else 1
    return axes


def body_axes(accelerometers: np.ndarray) -> np.ndarray:
    """Columns: x along the first accelerometer, y in the plane of the first two."""
    x = accelerometers[0] / np.linalg.norm(accelerometers[0])
    y = accelerometers[1] - (accelerometers[1] @ x) * x
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


def vector_of(R):
    return 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], -1)


def attitude_at(truth: Truth, t):
    k = np.clip(np.searchsorted(truth.t, t) - 1, 0, len(truth.t) - 2)
    part = (t - truth.t[k]) / (truth.t[k + 1] - truth.t[k])
    turn = part[:, None] * vector_of(np.swapaxes(truth.attitude[k], 1, 2) @ truth.attitude[k + 1])
    return truth.attitude[k] @ rotation(2, turn[:, 2]) @ rotation(1, turn[:, 1]) @ rotation(0, turn[:, 0])


def errors_of(file: Path, truth: Truth, axes: np.ndarray) -> tuple[dict[str, Errors], np.ndarray]:
    """Five rows a second under way, and which of them have no fix. Times are the receiver's, which are late."""
    rows = table(file)
    t = rows["time_s"] - truth.late
    between = lambda values: np.stack([np.interp(t, truth.t, v) for v in np.atleast_2d(values.T)], -1)
    velocity = columns(rows, *(f"velocity_{a}_m_s" for a in ("north", "east", "down"))) - between(truth.velocity)
    interval = float(np.median(np.diff(t)))
    box = np.ones(max(1, round(0.2 / interval)))
    velocity = np.stack([np.convolve(v, box / box.size, "same") for v in velocity.T], -1)
    latitude, longitude, height = (between(x)[:, 0] for x in (truth.latitude, truth.longitude, truth.height))
    place = ecef(rows["latitude_deg"] * DEGREE, rows["longitude_deg"] * DEGREE, rows["height_m"]) - ecef(latitude, longitude, height)
    place = np.einsum("nji,nj->ni", north_east_down(latitude, longitude), place)
    attitude = euler(*(rows[f"{a}_deg"] * DEGREE for a in ("roll", "pitch", "heading")))
    turned = vector_of(attitude @ np.swapaxes(attitude_at(truth, t) @ body_axes(axes @ truth.accel_axes), 1, 2)) / DEGREE
    of_attitude = columns(rows, "sigma_roll_deg", "sigma_pitch_deg", "sigma_heading_deg")
    tilt = np.sqrt(0.5 * np.sum(of_attitude[:, :2] ** 2, 1, keepdims=True)) * np.ones((1, 2))
    counted = (t > truth.t[0]) & (t < truth.t[-1]) & (np.linalg.norm(between(truth.velocity), axis=1) > 0.1)
    counted &= np.arange(len(t)) % max(1, round(0.2 / interval)) == 0
    counted &= np.abs(rows["pitch_deg"]) < 70  # beyond, roll and heading are one
    alone = np.any(np.abs(t[counted, None] - truth.withheld[None, :]) < 0.6, axis=1) if truth.withheld.size else np.zeros(counted.sum(), bool)
    errors = {
        "place": Errors(place, columns(rows, *(f"sigma_{a}_m" for a in ("north", "east", "down")))),
        "velocity": Errors(velocity, columns(rows, *(f"sigma_velocity_{a}_m_s" for a in ("north", "east", "down")))),
        "tilt": Errors(turned[:, :2], tilt),
        "heading": Errors(turned[:, 2:], of_attitude[:, 2:]),
    }
    return {name: e.at(counted) for name, e in errors.items()}, alone


def holds(places: Errors, stated: float) -> bool:
    return places.within() >= 0.95 and 0.4 / max(1, stated) <= places.normalised() <= 2


def run(program: Path, words: list[str], folder: Path) -> None:
    done = subprocess.run([program, *words, "--quiet"], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{program.name} ended with {done.returncode}: {done.stderr.strip()[-200:]}")


def judged(programs: Path, folder: Path, truth: Truth) -> tuple[str, bool]:
    """The cells of a row, and whether it holds."""
    run(programs / "inspect", ["imu.csv", "gnss.csv", "--output", "found"], folder)
    run(programs / "replay", ["found/replay.yaml", "--output", "out"], folder)
    axes = axes_of((folder / "found/replay.yaml").read_text())
    (filtered, alone), (smoothed, alone_smoothed) = (errors_of(folder / "out" / f"{name}.csv", truth, axes) for name in ("filtered", "smoothed"))
    cells = []
    for name, unit in (("place", "m"), ("velocity", "m/s"), ("tilt", "deg"), ("heading", "deg")):
        f, s = filtered[name], smoothed[name]
        cells.append(f"{f.within():.3f} \\| {s.within():.3f}, {f.normalised():.2f} \\| {s.normalised():.2f}, {f.size():.3g} \\| {s.size():.3g} {unit}")
    whole = [filtered["place"], smoothed["place"]]
    gaps = [filtered["place"].at(alone), smoothed["place"].at(alone_smoothed)]
    stated = RECEIVERS[truth.made["receiver"]].stated
    return " | ".join(cells), all(holds(e, stated) for e in whole) and all(e.within() >= 0.95 for e in gaps if e.error.size)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=300)
    parser.add_argument("--only", default="")
    parser.add_argument("--least", type=float, default=0.8)
    options = parser.parse_args()
    print("| motion, IMU, receiver | place | velocity | tilt | heading | holds |\n|---|---|---|---|---|---|")
    outcomes = []
    for i, (motion, imu, receiver, rate) in enumerate(PLAN):
        name = f"{motion}, {imu}, {receiver}"
        if options.only not in name:
            continue
        folder = options.folder / name.replace(", ", "_").replace(" ", "_")
        truth = record(folder, options.seed + i, motion, imu, receiver, rate)
        try:
            cells, good = judged(options.programs.resolve(), folder, truth)
        except RuntimeError as error:
            cells, good = f"{error} | | | ", False
        outcomes.append(good)
        print(f"| {name} | {cells} | {'yes' if good else 'no'} |", flush=True)
    print(f"figure: places hold in {sum(outcomes)} of {len(outcomes)} recordings with nothing stated")
    return 0 if sum(outcomes) >= options.least * len(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
