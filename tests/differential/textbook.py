"""A textbook filter in fifty lines, and filters of others, beside replay: the same simulated logs and noises, errors and sigmas.

usage: textbook.py APPS SOURCE WORK [RUNS]

The filter is that of Groves 2013, 14.2: fifteen states (attitude, velocity, position in a local level that does not turn, biases),
Euler steps, positions and velocities of a receiver at the IMU. The sensor of the logs has white noise and constant biases alone, so
that both filters know all there is. Their errors may differ by what the steps of the textbook cost, and their sigmas by a part.
INSLIB and sidereon run where this interpreter has them (peers.py), from the same wrong level and heading. Errors of
replay may not be larger than theirs by more than that part either.
Exit 0: they agree; 1: they do not; 77: NumPy is missing.
"""

import csv
import math
import pathlib
import subprocess
import sys

try:
    import numpy as np
except ImportError:
    print("skipped: NumPy is missing")
    sys.exit(77)

GYRO_NOISE, ACCEL_NOISE, GYRO_BIAS, ACCEL_BIAS = math.radians(0.05), 0.002, math.radians(0.5), 0.05
EARTH_RATE, DEGREE = 7.292115e-5, math.pi / 180
TILT, HEADING = 2 * DEGREE, 0.5 * DEGREE  # of the start: a level that is hardly known, and a heading that is
SETTLED = 20  # s, in which the level is found
WORSE, OTHER, APART = 0.05, 0.03, 0.3  # of an error; of a sigma; sigmas


def skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def rotation(v):
    angle = np.linalg.norm(v)
    if angle < 1e-12:
        return np.eye(3) + skew(v)
    K = skew(v / angle)
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K


def textbook(imu, fixes, start, gravity, latitude):
    """Rows (time, position, velocity, attitude, covariance) at the fixes. `start`: (time, p, v, R)."""
    time, p, v, R = start
    earth = EARTH_RATE * np.array([math.cos(latitude), 0, -math.sin(latitude)])
    bias_g, bias_a = np.zeros(3), np.zeros(3)
    P = np.diag(np.concatenate([(TILT**2, TILT**2, HEADING**2), np.full(3, 0.1**2), np.full(3, 0.1**2), np.full(3, GYRO_BIAS**2), np.full(3, ACCEL_BIAS**2)]))
    rows, due = [], 0
    while due < len(fixes) and fixes[due][0] <= time:
        due += 1
    for t, rate, force in imu:
        if t <= time:
            continue
        dt, time = t - time, t
        w, f = (rate - bias_g) - R.T @ earth, force - bias_a
        middle = R @ rotation(0.5 * dt * w)
        a = middle @ f + np.array([0, 0, gravity]) - 2 * np.cross(earth, v)
        p, v, R = p + dt * v + 0.5 * dt * dt * a, v + dt * a, R @ rotation(dt * w)
        F = np.eye(15)
        F[0:3, 9:12], F[3:6, 0:3], F[3:6, 12:15], F[6:9, 3:6] = -dt * middle, -dt * skew(middle @ f), -dt * middle, dt * np.eye(3)
        F[0:3, 0:3] -= dt * skew(earth)
        P = F @ P @ F.T
        P[0:3, 0:3] += GYRO_NOISE**2 * dt * np.eye(3)
        P[3:6, 3:6] += ACCEL_NOISE**2 * dt * np.eye(3)
        while due < len(fixes) and fixes[due][0] <= time + 1e-6:
            _, place, velocity, sigma = fixes[due]
            due += 1
            H = np.zeros((6, 15))
            H[0:3, 6:9], H[3:6, 3:6] = np.eye(3), np.eye(3)
            K = np.linalg.solve(H @ P @ H.T + np.diag(sigma**2), H @ P).T
            x = K @ np.concatenate([place - p, velocity - v])
            P = (np.eye(15) - K @ H) @ P @ (np.eye(15) - K @ H).T + K @ np.diag(sigma**2) @ K.T
            R, v, p, bias_g, bias_a = rotation(x[0:3]) @ R, v + x[3:6], p + x[6:9], bias_g + x[9:12], bias_a + x[12:15]
            rows.append((time, p, v, R, P))
    return rows


def table(file):
    with open(file, newline="") as rows:
        return [{k: float(c) for k, c in row.items()} for row in csv.DictReader(rows)]


def triple(row, *names):
    return np.array([row[name] for name in names])


def sigmas(row, places, unit):
    return triple(row, *(f"sigma_{place}_{unit}" for place in places))


def attitude(row):
    r, p, h = (row[f"{a}_deg"] * DEGREE for a in ("roll", "pitch", "heading"))
    return rotation([0, 0, h]) @ rotation([0, p, 0]) @ rotation([r, 0, 0])


def angles_of(R):
    """Roll, pitch, heading."""
    return np.array([math.atan2(R[2, 1], R[2, 2]), -math.asin(R[2, 0]), math.atan2(R[1, 0], R[0, 0])])


def sigma_of_heading(R, P):
    """A rotation about the level turns the heading as well, where the body is tilted."""
    _, pitch, heading = angles_of(R)
    J = np.array([math.tan(pitch) * math.cos(heading), math.tan(pitch) * math.sin(heading), 1])
    return math.sqrt(J @ P[0:3, 0:3] @ J)


def tilt_and_heading(R, true_R):
    """Error: rotation about north and east, and of the heading."""
    M = R @ true_R.T
    turn = angles_of(R)[2] - angles_of(true_R)[2]
    return np.array([(M[2, 1] - M[1, 2]) / 2, (M[0, 2] - M[2, 0]) / 2, math.atan2(math.sin(turn), math.cos(turn))])


class Level:
    """North, east, down of a place, by the radii of curvature there; good to a millimetre over some hundred metres."""

    def __init__(self, row):
        self.latitude, self.longitude, self.height = row["latitude_deg"] * DEGREE, row["longitude_deg"] * DEGREE, row["height_m"]
        w = 1 - 0.00669437999014 * math.sin(self.latitude) ** 2
        self.prime = 6378137.0 / math.sqrt(w) + self.height
        self.meridian = 6378137.0 * (1 - 0.00669437999014) / w**1.5 + self.height

    def place(self, row):
        return np.array([(row["latitude_deg"] * DEGREE - self.latitude) * self.meridian,
                         (row["longitude_deg"] * DEGREE - self.longitude) * self.prime * math.cos(self.latitude), self.height - row["height_m"]])


NED = ("north", "east", "down")
PROGRAM = pathlib.Path(__file__).with_name("peers.py")
PEERS = ("inslib", "sidereon", "turned")
PARTS = ((slice(0, 3), 1), (slice(3, 6), 1), (slice(6, 8), 1 / DEGREE), (slice(8, 9), 1 / DEGREE))  # of errors, and their units
SPEEDS = [f"velocity_{a}" for a in NED]
VELOCITY = [f"{speed}_m_s" for speed in SPEEDS]


def one_run(apps, source, work, seed):
    work.mkdir(parents=True, exist_ok=True)
    (work / "sensor.yaml").write_text(
        "name: white noise and constant biases\ngyro: {noise: 0.05 deg/s/sqrt(Hz), bias: 0.5 deg/s, cross_axis: 0 ppm, g_sensitivity: 0 deg/s/g}\n"
        "accel: {noise: 0.002 m/s^2/sqrt(Hz), bias: 0.05 m/s^2, cross_axis: 0 ppm}\n")
    (work / "scenario.yaml").write_text(
        f"base: {source}/config/scenarios/ski.yaml\nseed: {seed}\nmotion: {{rest_before: 0 s, run: 60 s, rest_after: 0 s}}\nattitude: []\n"
        "imus:\n  - {name: imu, sensor: sensor.yaml}\n"
        "gnss:\n  - {name: gnss, rate: 5 Hz, position_noise: 0.02 0.02 0.04 m, velocity_noise: 0.03 0.03 0.05 m/s, lever_arm: 0 0 0 m}\n")

    def run(name, *words):
        subprocess.run([apps / name, *map(str, words), "--quiet"], check=True, cwd=work)

    run("simulate", "scenario.yaml", "--output", "logs")
    truth = {round(r["time_s"], 4): r for r in table(work / "logs/truth.csv")}
    imu = [(r["time_s"], triple(r, *(f"gyro_{a}_rad_s" for a in "xyz")), triple(r, *(f"accel_{a}_m_s2" for a in "xyz"))) for r in table(work / "logs/imu.csv")]
    raw = table(work / "logs/gnss.csv")
    begin = raw[5]["time_s"]
    first = truth[round(begin, 4)]
    level = Level(first)
    fixes = [(r["time_s"], level.place(r), triple(r, *VELOCITY), np.concatenate([sigmas(r, NED, "m"), sigmas(r, SPEEDS, "m_s")])) for r in raw]
    sin2 = math.sin(level.latitude) ** 2
    gravity = 9.7803253359 * (1 + 0.001931853 * sin2) / math.sqrt(1 - 0.00669438 * sin2) - 3.086e-6 * level.height
    random = np.random.default_rng(seed)
    R = rotation(np.array([TILT, TILT, HEADING]) * random.standard_normal(3)) @ attitude(first)
    rows = textbook(imu, fixes, (begin, 0.1 * random.standard_normal(3), triple(first, *VELOCITY) + 0.1 * random.standard_normal(3), R), gravity, level.latitude)
    (work / "run.yaml").write_text(
        "imu: {file: logs/imu.csv, sensor: sensor.yaml, sampling: mean}\ngnss: {file: logs/gnss.csv, lever_arm: 0 0 0 m}\n"
        f"initial: {{heading: {first['heading_deg']:.4f} deg, sigma: {HEADING / DEGREE:.3f} deg}}\nestimate: [gyro_bias, accel_bias]\nrest: {{detect: false}}\nsmoother: none\n"
        f"output: {{rate: imu}}\n")
    run("replay", "run.yaml", "--output", "result")
    ours = {round(r["time_s"], 4): r for r in table(work / "result/filtered.csv")}
    theirs = peers(work, begin, R, first)
    out = []
    for time, p, v, R, P in rows:
        key = round(time, 4)
        if key not in truth or key not in ours or time < begin + SETTLED:
            continue
        true, o, sigma = truth[key], ours[key], np.sqrt(np.diag(P))
        place, velocity, true_R = level.place(true), triple(true, *VELOCITY), attitude(true)

        def errors(row):
            return np.concatenate([level.place(row) - place, triple(row, *VELOCITY) - velocity, tilt_and_heading(attitude(row), true_R)])

        out.append({
            "textbook": (np.concatenate([p - place, v - velocity, tilt_and_heading(R, true_R)]),
                         np.concatenate([sigma[6:9], sigma[3:6], sigma[0:2], [sigma_of_heading(R, P)]])),
            "replay": (errors(o), np.concatenate([sigmas(o, NED, "m"), sigmas(o, SPEEDS, "m_s"),
                                                  [math.nan, math.nan, o["sigma_heading_deg"] * DEGREE]])),
            **{peer: (errors(row), np.concatenate([sigmas(row, NED, "m"), sigmas(row, SPEEDS, "m_s"),
                                                   sigmas(row, (f"about_{a}" for a in NED), "deg") * DEGREE]))
               for peer, table_of in theirs.items() if (row := table_of.get(key))}})
    return out


def peers(work, begin, R, first):
    """Solutions of the peers of this interpreter, from the textbook's start, by time."""
    start = work / "start"
    start.mkdir(exist_ok=True)
    angles = dict(zip(("roll_deg", "pitch_deg", "heading_deg"), angles_of(R) / DEGREE))
    names = ("latitude_deg", "longitude_deg", "height_m", *VELOCITY)
    with open(start / "smoothed.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, ["time_s", *names, *angles])
        writer.writeheader()
        writer.writerow({"time_s": begin, **{name: first[name] for name in names}, **angles})
    found = {}
    for peer in subprocess.run([sys.executable, PROGRAM, "--installed"], capture_output=True, text=True, check=True).stdout.split():
        words = [PROGRAM, peer, work / "run.yaml", start, "--output", work / peer]
        subprocess.run([sys.executable, *words], check=True, stdout=subprocess.DEVNULL)
        found[peer] = {round(row["time_s"], 4): row for row in table(work / peer / "filtered.csv")}
    return found


def main():
    apps, source, work = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
    runs = int(sys.argv[4]) if len(sys.argv) > 4 else 4
    subprocess.run([sys.executable, PROGRAM, "--installed"], check=True, stdout=subprocess.DEVNULL)  # says which are not there
    rows = [row for seed in range(1, runs + 1) for row in one_run(apps, source, work / str(seed), seed)]
    errors, sigma = (np.array([row["textbook"][k] for row in rows]) for k in (0, 1))
    our_errors, our_sigma = (np.array([row["replay"][k] for row in rows]) for k in (0, 1))

    def rms(values):
        return np.sqrt(np.mean(np.square(values), axis=0))

    table_of = (rms(errors), rms(sigma), rms(our_errors), rms(our_sigma), rms((our_errors - errors) / sigma))
    print(f"{runs} runs, {len(rows)} fixes\n| quantity | textbook: error | sigma | replay: error | sigma | apart, in sigmas |\n|---|---|---|---|---|---|")
    agree, k = True, 0
    for what, unit, names in (("position", "m", NED), ("velocity", "m/s", NED), ("attitude", "rad", ("about north", "about east", "heading"))):
        for axis in names:
            theirs, their_sigma, replayed, replayed_sigma, apart = (column[k] for column in table_of)
            print(f"| {what} {axis} [{unit}] | {theirs:.6f} | {their_sigma:.6f} | {replayed:.6f} | {replayed_sigma:.6f} | {apart:.3f} |")
            agree &= replayed < (1 + WORSE) * theirs and apart < APART and not abs(replayed_sigma / their_sigma - 1) > OTHER
            k += 1
    print("\n| filter | fixes | position: error [m] | sigma | velocity: error [m/s] | sigma "
          "| tilt: error [deg] | sigma | heading: error [deg] | sigma | in 3 sigma [%] |\n|---|---|---|---|---|---|---|---|---|---|---|")
    for name in ["replay", "textbook", *(peer for peer in PEERS if any(peer in row for row in rows))]:
        e, s = (np.array([row[name][k] for row in rows if name in row]) for k in (0, 1))
        cells = [f"{rms(values[:, part].ravel()) * unit:.4g}" for part, unit in PARTS for values in (e, s)]
        known = ~np.isnan(s)
        print(f"| {name} | {len(e)} | {' | '.join(cells)} | {100 * np.mean(np.abs(e[known]) < 3 * s[known]):.1f} |")
        agree &= all(rms(our_errors[:, part].ravel()) < (1 + WORSE) * rms(e[:, part].ravel()) for part, _ in PARTS)
    print(f"figure: they {'' if agree else 'do not '}agree: errors larger by less than {100 * WORSE:.0f} %, sigmas alike to {100 * OTHER:.0f} %")
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
