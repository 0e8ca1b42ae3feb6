"""A simulator of recordings as strangers have them, by other hands than piste's own `simulate`.

Motions are splines and bands of noise on a fine grid, in a frame that turns with the Earth. IMUs have the errors of
what is sold: cross-axis terms, sensitivity to g, warming up, rounding. Receivers have slow errors, state too much or
too little, come late, and smooth their velocities. `record` writes two tables and the truth.
"""

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

DEGREE = np.pi / 180
SEMI_MAJOR, FLATTENING, GM, EARTH_RATE = 6378137.0, 1 / 298.257223563, 3.986004418e14, 7.292115e-5  # WGS84
E2 = FLATTENING * (2 - FLATTENING)


@dataclass(frozen=True)
class Imu:
    """1-sigma of errors: deg/s and m/s², noise per √Hz, scales and cross-axis terms in ppm."""

    gyro_noise: float
    accel_noise: float
    gyro_bias: float
    accel_bias: float
    gyro_drift: float
    accel_drift: float
    drift_time: float  # s
    gyro_scale: float
    accel_scale: float
    cross_axis: float
    g_sensitivity: float  # deg/s/g
    warming: float  # deg/s, dying out over 150 s
    gyro_step: float = 0  # rounding, deg/s
    accel_step: float = 0  # m/s²


IMUS = {
    "phone": Imu(0.008, 0.002, 0.3, 0.08, 0.012, 0.006, 250, 8000, 6000, 3000, 0.03, 0.08, 0.06 / 16, 0.0024),
    "hobby": Imu(0.005, 0.0015, 0.8, 0.15, 0.01, 0.005, 200, 12000, 10000, 4000, 0.05, 0.15, 0.0305, 0.0012),
    "industrial": Imu(0.003, 0.0006, 0.1, 0.02, 0.003, 0.002, 400, 1500, 1000, 800, 0.01, 0.01),
    "tactical": Imu(0.001, 0.0003, 0.01, 0.01, 0.0005, 0.0005, 1000, 300, 300, 200, 0.001, 0.0),
}


@dataclass(frozen=True)
class Receiver:
    """1-sigma of errors in m along the horizontal; `up` times those of heights. What it states is `stated` times all."""

    white: float
    slow: float
    slow_time: float  # s
    up: float
    velocity: float | None  # m/s; None: it gives none
    rate: float  # Hz
    stated: float = 1
    late: float = 0  # s, of all
    smoothing: float = 0  # s: 1-sigma of the window of its velocities
    velocity_late: float = 0  # s besides


RECEIVERS = {
    "rtk": Receiver(0.008, 0.006, 60, 1.7, 0.03, 5),
    "rtk too sure": Receiver(0.01, 0.012, 90, 2, 0.05, 10, stated=0.7, late=0.06),
    "single": Receiver(0.35, 0.8, 120, 1.7, 0.06, 5),
    "navigator": Receiver(0.08, 1.1, 150, 1.6, 0.07, 5, stated=1.5, late=0.1, smoothing=0.1, velocity_late=0.12),
    "phone": Receiver(0.5, 2.2, 60, 1.8, 0.2, 1, late=0.12, smoothing=0.2, velocity_late=0.3),
    "positions": Receiver(0.4, 0.7, 100, 1.6, None, 1, late=0.05),
}


# ---- The Earth ----


def ecef(latitude, longitude, height):
    """Places in the frame of the Earth [m]."""
    n = SEMI_MAJOR / np.sqrt(1 - E2 * np.sin(latitude) ** 2)
    across = (n + height) * np.cos(latitude)
    up = (n * (1 - E2) + height) * np.sin(latitude)
    return np.stack([across * np.cos(longitude), across * np.sin(longitude), up], -1)


def geodetic(place):
    """The inverse of ecef(), by fixed-point iteration."""
    r = np.hypot(place[..., 0], place[..., 1])
    latitude = np.arctan2(place[..., 2], r * (1 - E2))
    height = np.zeros_like(r)
    for _ in range(6):
        n = SEMI_MAJOR / np.sqrt(1 - E2 * np.sin(latitude) ** 2)
        height = r / np.cos(latitude) - n
        latitude = np.arctan2(place[..., 2], r * (1 - E2 * n / (n + height)))
    return latitude, np.arctan2(place[..., 1], place[..., 0]), height


def north_east_down(latitude, longitude):
    """Columns: north, east and down in the frame of the Earth."""
    sl, cl, so, co = np.sin(latitude), np.cos(latitude), np.sin(longitude), np.cos(longitude)
    columns = [[-sl * co, -sl * so, cl], [-so, co, np.zeros_like(sl)], [-cl * co, -cl * so, -sl]]
    return np.stack([np.stack(c, -1) for c in columns], -1)


def gravity(latitude, height):
    """Somigliana's normal gravity, to second order in height [m/s²]."""
    s2 = np.sin(latitude) ** 2
    at_sea = 9.7803253359 * (1 + 0.00193185265241 * s2) / np.sqrt(1 - E2 * s2)
    m = EARTH_RATE**2 * SEMI_MAJOR**3 * (1 - FLATTENING) / GM
    relative = height / SEMI_MAJOR
    return at_sea * (1 - 2 * (1 + FLATTENING + m - 2 * FLATTENING * s2) * relative + 3 * relative**2)


def rotation(axis, angle):
    """About x, y or z (0, 1, 2)."""
    c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    rows = {0: [i, o, o, o, c, -s, o, s, c], 1: [c, o, s, o, i, o, -s, o, c], 2: [c, -s, o, s, c, o, o, o, i]}
    return np.stack(rows[axis], -1).reshape((*np.shape(angle), 3, 3))


def euler(roll, pitch, yaw):
    """Body to level."""
    return rotation(2, np.asarray(yaw)) @ rotation(1, np.asarray(pitch)) @ rotation(0, np.asarray(roll))


# ---- Random functions of time ----


def smooth(values, time, dt):
    """Values averaged by a Gaussian window of this 1-sigma."""
    pad = int(6 * time / dt) + 1
    padded = np.concatenate([np.full(pad, values[0]), values, np.full(pad, values[-1])])
    f = np.fft.rfftfreq(len(padded), dt)
    return np.fft.irfft(np.fft.rfft(padded) * np.exp(-0.5 * (2 * np.pi * f * time) ** 2), len(padded))[pad : pad + len(values)]


def band(rng, n, dt, rms, low, high, order=0):
    """Noise between two frequencies, the derivative of which of that order has this rms."""
    f = np.fft.rfftfreq(n, dt)
    spectrum = np.fft.rfft(rng.standard_normal(n)) * ((f > low) & (f < high))
    scale = rms / (np.std(np.fft.irfft(spectrum, n)) + 1e-12)
    return np.fft.irfft(spectrum * scale / np.where(f > low, 2 * np.pi * np.maximum(f, 1e-6), 1) ** order, n)


def gauss_markov(rng, n, dt, sigma, time):
    """A process of first order."""
    decay = np.exp(-dt / time)
    noise = rng.standard_normal(n) * sigma * np.sqrt(1 - decay**2)
    out = np.empty(n)
    x = sigma * rng.standard_normal()
    for i in range(n):
        x = decay * x + noise[i]
        out[i] = x
    return out


def steps(rng, t, every, low, high):
    """Values that change evenly from one to the next."""
    k = np.arange(0, t[-1] + 2 * every, every)
    return np.interp(t, k, rng.uniform(low, high, len(k)))


# ---- Motions ----


@dataclass
class Motion:
    """Place along north, east, down [m], roll, pitch, yaw [rad], and how loud its vibration is."""

    place: np.ndarray
    roll: np.ndarray
    pitch: np.ndarray
    yaw: np.ndarray
    shaking: np.ndarray


def stops(rng, t, first, every, longest=20):
    """1 while it moves."""
    moving = (t > first).astype(float)
    at = first + rng.uniform(0.5, 1.5) * every
    while at < t[-1] - 30:
        stop = rng.uniform(longest / 4, longest)
        moving[(t > at) & (t < at + stop)] = 0
        at += stop + rng.uniform(0.5, 1.5) * every
    return moving


@dataclass
class Ride:
    """Speed, course and place of what rolls or walks."""

    speed: np.ndarray
    course: np.ndarray
    place: np.ndarray
    pace: np.ndarray  # 0 at rest, 1 from `full` m/s on


def ride(rng, t, dt, *, first, every, longest, speed, change, ease, turn_change, turning, full):
    """Changes of speed each `change` s and of turn rate each `turn_change` s."""
    v = smooth(steps(rng, t, change, *speed) * stops(rng, t, first, every, longest), ease, dt)
    v = smooth(np.maximum(v - 0.005 * full, 0), 0.15, dt)
    turns = smooth(steps(rng, t, turn_change, -1, 1) ** 3 * turning, 0.8, dt)
    course = np.cumsum(turns * np.minimum(1, v / full)) * dt + rng.uniform(-3, 3)
    place = np.stack([np.cumsum(v * np.cos(course)), np.cumsum(v * np.sin(course)), np.zeros_like(v)], -1) * dt
    return Ride(v, course, place, smooth(np.minimum(1, v / full), 0.15, dt))


def car(rng, t, dt):
    r = ride(rng, t, dt, first=40, every=70, longest=20, speed=(6, 18), change=20, ease=1.6, turn_change=9, turning=0.45, full=6)
    way = np.cumsum(r.speed) * dt
    grade = 0.04 * np.sin(way / 300 + rng.uniform(0, 6)) + 0.02 * np.sin(way / 110)
    lean = 0.004 * r.speed * np.gradient(r.course, dt)
    r.place[:, 2] = -np.cumsum(r.speed * np.tan(grade)) * dt + r.pace * band(rng, len(t), dt, 0.5, 0.8, 10, 2)
    roll = lean + r.pace * band(rng, len(t), dt, 0.04, 0.3, 8, 1)
    pitch = grade - 0.008 * np.gradient(r.speed, dt) + r.pace * band(rng, len(t), dt, 0.03, 0.3, 8, 1)
    return Motion(r.place, roll, pitch, r.course, r.pace)


def bicycle(rng, t, dt):
    r = ride(rng, t, dt, first=30, every=120, longest=20, speed=(3, 9), change=15, ease=1.2, turn_change=7, turning=0.5, full=4)
    way = np.cumsum(r.speed) * dt
    grade = 0.05 * np.sin(way / 200 + rng.uniform(0, 6))
    r.place[:, 2] = -np.cumsum(r.speed * np.tan(grade)) * dt + r.pace * band(rng, len(t), dt, 1.5, 1, 12, 2)
    pedal = 2 * np.pi * 1.2 * t
    roll = np.arctan(r.speed * np.gradient(r.course, dt) / 9.81) + 0.03 * r.pace * np.sin(pedal)
    pitch = grade + r.pace * band(rng, len(t), dt, 0.08, 0.3, 8, 1)
    return Motion(r.place, roll, pitch, r.course + 0.02 * r.pace * np.sin(pedal + 1), r.pace)


def walk(rng, t, dt):
    r = ride(rng, t, dt, first=20, every=90, longest=12, speed=(1.0, 1.7), change=12, ease=0.5, turn_change=6, turning=1.1, full=0.8)
    step = 2 * np.pi * np.cumsum(0.9 + 0.07 * r.speed) * dt
    side = 0.02 * r.pace * np.sin(step)
    r.place[:, 0] -= side * np.sin(r.course)
    r.place[:, 1] += side * np.cos(r.course)
    r.place[:, 2] = -0.02 * np.cumsum(r.speed * np.sin(np.cumsum(r.speed) * dt / 90)) * dt - 0.025 * r.pace * np.sin(2 * step)
    sway = [band(rng, len(t), dt, 0.004, 0.05, 0.8) for _ in range(3)]
    roll = 0.05 * r.pace * np.sin(step + 0.5) + sway[0]
    pitch = 0.08 + 0.03 * r.pace * np.sin(2 * step + 1) + sway[1]
    yaw = r.course + 0.06 * r.pace * np.sin(step + 2) + sway[2]
    return Motion(r.place, roll, pitch, yaw, 0.5 * r.pace)


def rover(rng, t, dt):
    r = ride(rng, t, dt, first=25, every=60, longest=15, speed=(0.3, 0.8), change=15, ease=0.4, turn_change=8, turning=0.6, full=0.35)
    way = np.cumsum(r.speed) * dt
    r.place[:, 2] = 0.1 * np.sin(way / 9) + r.pace * band(rng, len(t), dt, 0.5, 1, 15, 2)
    roll = 0.04 * np.sin(way / 2.3) + r.pace * band(rng, len(t), dt, 0.05, 1, 15, 1)
    pitch = 0.03 * np.sin(way / 3.1 + 1) + r.pace * band(rng, len(t), dt, 0.05, 1, 15, 1)
    return Motion(r.place, roll, pitch, r.course, r.pace)


def drone(rng, t, dt):
    flies = smooth(((t > 25) & (t < t[-1] - 15)).astype(float), 1.0, dt)
    level = np.stack([smooth(steps(rng, t, 8, -60, 60), 2.0, dt) for _ in range(2)], -1)
    level = (level - level[0]) * smooth((t > 31).astype(float), 2.0, dt)[:, None]
    down = -flies * (25 + smooth(steps(rng, t, 12, -8, 8), 2.0, dt))
    yaw = rng.uniform(-3, 3) + smooth(steps(rng, t, 14, -2, 2), 1.5, dt) * flies
    a = np.gradient(np.gradient(level, dt, axis=0), dt, axis=0)
    a[:4], a[-4:] = a[4], a[-5]
    ahead = a[:, 0] * np.cos(yaw) + a[:, 1] * np.sin(yaw)
    right = -a[:, 0] * np.sin(yaw) + a[:, 1] * np.cos(yaw)
    pitch = -np.arctan(ahead / 9.81) + flies * band(rng, len(t), dt, 0.1, 0.3, 6, 1)
    roll = np.arctan(right / 9.81) + flies * band(rng, len(t), dt, 0.1, 0.3, 6, 1)
    return Motion(np.column_stack([level, down]), roll, pitch, yaw, 3 * flies)


def boat(rng, t, dt):
    v = smooth(steps(rng, t, 30, 2, 5) * (t > 60), 4, dt)
    course = np.cumsum(smooth(steps(rng, t, 20, -1, 1) ** 3 * 0.2, 3, dt) * np.minimum(1, v / 2)) * dt + rng.uniform(-3, 3)
    leeway = smooth(steps(rng, t, 60, -0.4, 0.4), 8, dt)
    north = np.cumsum(v * np.cos(course) - leeway * np.sin(course)) * dt
    east = np.cumsum(v * np.sin(course) + leeway * np.cos(course)) * dt
    wave = band(rng, len(t), dt, 1, 0.1, 0.35)
    later = lambda seconds: np.roll(wave, int(seconds / dt))
    place = np.stack([north, east, 0.2 * later(2.1)], -1)
    return Motion(place, 0.06 * wave, 0.03 * later(1.3), course + 0.02 * later(0.7), 0.3 * np.minimum(1, v / 2))


MOTIONS = {"car": car, "bicycle": bicycle, "walk": walk, "rover": rover, "drone": drone, "boat": boat}


# ---- Recordings ----


@dataclass
class Truth:
    """What a recording is of, at the ends of the IMU's intervals. `own`: the time that the IMU's clock shows."""

    t: np.ndarray
    latitude: np.ndarray
    longitude: np.ndarray
    height: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray  # level to sensor axes
    accel_axes: np.ndarray  # rows: the accelerometers' axes in the sensor's
    late: float
    withheld: np.ndarray  # true times of the fixes that were left out
    made: dict = field(default_factory=dict)


def mounted(rng, motion):
    """Sensor to body: as it comes."""
    turns = rng.integers(0, 4) * np.pi / 2
    tilt, roll = (rng.uniform(-1.2, 1.2), rng.uniform(-0.4, 0.4)) if motion == "walk" else rng.normal(0, 0.05, 2)
    R = euler(np.array(roll), np.array(tilt), np.array(turns + rng.normal(0, 0.1)))
    return R @ np.diag([1, -1, -1]) if rng.random() < 0.5 else R


def record(folder: Path, seed: int, motion: str, imu: str, receiver: str, rate: int, seconds: float = 420) -> Truth:
    """Writes imu.csv and gnss.csv. Fixes of 15 s each 75 s are left out of the second half."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    fine = max(1, round(1000 / rate))
    dt, period = 1 / (rate * fine), 1 / rate
    t = np.arange(0, seconds, dt)
    m = MOTIONS[motion](rng, t, dt)
    latitude, longitude, height = rng.uniform(-60, 60) * DEGREE, rng.uniform(-170, 170) * DEGREE, rng.uniform(10, 800)
    origin, level = ecef(np.array(latitude), np.array(longitude), np.array(height)), north_east_down(np.array(latitude), np.array(longitude))
    places = geodetic(origin + m.place @ level.T)
    to_local = north_east_down(places[0], places[1])
    C = euler(m.roll, m.pitch, m.yaw) @ mounted(rng, motion)
    v = np.gradient(m.place, dt, axis=0)
    earth = level.T @ np.array([0, 0, EARTH_RATE])
    down = np.einsum("ij,nj->ni", level.T, to_local[:, :, 2])
    force = np.gradient(v, dt, axis=0) + 2 * np.cross(earth, v) - gravity(places[0], places[2])[:, None] * down
    dC = np.einsum("nji,njk->nik", C[:-1], C[1:])
    w = 0.5 / dt * np.stack([dC[:, 2, 1] - dC[:, 1, 2], dC[:, 0, 2] - dC[:, 2, 0], dC[:, 1, 0] - dC[:, 0, 1]], -1)
    w = np.concatenate([w, w[-1:]]) + np.einsum("nji,j->ni", C, earth)
    f = np.einsum("nji,nj->ni", C, force)
    f += m.shaking[:, None] * np.stack([band(rng, len(t), dt, 0.25, 20, min(90, 0.4 / dt)) for _ in range(3)], -1)
    f = 0.5 * (f + np.concatenate([f[1:], f[-1:]]))
    n = len(t) // fine
    w, f = (x[: n * fine].reshape(n, fine, 3).mean(1) for x in (w, f))
    ends = (np.arange(n) + 1) * period
    s = IMUS[imu]
    crossed = lambda: s.cross_axis * 1e-6 * rng.standard_normal((3, 3)) * (1 - np.eye(3))
    drift = lambda sigma: np.stack([gauss_markov(rng, n, period, sigma, s.drift_time) for _ in range(3)], -1)
    rates = np.eye(3) + np.diag(s.gyro_scale * 1e-6 * rng.standard_normal(3)) + crossed()
    forces = np.eye(3) + np.diag(s.accel_scale * 1e-6 * rng.standard_normal(3)) + np.tril(crossed(), -1)
    by_force = s.g_sensitivity * DEGREE * rng.standard_normal((3, 3))
    warming = s.warming * DEGREE * rng.standard_normal(3) * np.exp(-ends / 150)[:, None]
    gyro = w @ rates.T + s.gyro_bias * DEGREE * rng.standard_normal(3) + drift(s.gyro_drift * DEGREE) + warming + f / 9.8 @ by_force.T
    accel = f @ forces.T + s.accel_bias * rng.standard_normal(3) + drift(s.accel_drift)
    gyro += s.gyro_noise * DEGREE / np.sqrt(period) * rng.standard_normal((n, 3))
    accel += s.accel_noise / np.sqrt(period) * rng.standard_normal((n, 3))
    rounded = lambda x, step: np.round(x / step) * step if step else x
    gyro, accel = rounded(gyro, s.gyro_step * DEGREE), rounded(accel, s.accel_step)
    clock, drift_of_clock, start = rng.choice([0.0, 0.35, -1.2]), rng.normal(0, 20e-6), 1.0e5
    own = ends * (1 + drift_of_clock) + clock + start
    names = "gyro x [rad/s],gyro y [rad/s],gyro z [rad/s],acc x [m/s^2],acc y [m/s^2],acc z [m/s^2]"
    write(folder / "imu.csv", "timestamp [s]," + names, [own[:, None], gyro, accel], ["%.6f"] + ["%.7f"] * 6)

    g = RECEIVERS[receiver]
    arm = rng.normal(0, 0.03 if imu == "phone" else 0.4, 3)
    every = round(1 / (g.rate * dt))
    k = np.arange(int(rng.integers(0, every)) + round(1 / dt), len(t), every)
    up = np.array([1, 1, g.up])
    antenna = m.place + np.einsum("nij,j->ni", C, arm)
    slow = np.stack([gauss_markov(rng, len(k), 1 / g.rate, g.slow, g.slow_time) for _ in range(3)], -1)
    fixes = geodetic(origin + (antenna[k] + up * (slow + g.white * rng.standard_normal((len(k), 3)))) @ level.T)
    sigma = g.stated * np.hypot(g.white, g.slow)
    radius = 1.515 * sigma  # that holds 68 % of the plane, as receivers state it
    columns = [(t[k] + g.late + start)[:, None], np.degrees(fixes[0])[:, None], np.degrees(fixes[1])[:, None], fixes[2][:, None],
               np.full((len(k), 1), radius), np.full((len(k), 1), sigma * g.up)]
    header, formats = "timestamp [s],lat [deg],lon [deg],alt [m],hAcc [m],vAcc [m]", ["%.4f", "%.9f", "%.9f", "%.4f", "%.3f", "%.3f"]
    if g.velocity is not None:
        speed = np.gradient(antenna, dt, axis=0)
        if g.smoothing:
            speed = np.stack([smooth(speed[:, i], g.smoothing, dt) for i in range(3)], -1)
        then = np.clip(k - round(g.velocity_late / dt), 0, None)
        local = np.einsum("nji,jk,nk->ni", to_local[k], level, speed[then])
        columns += [local + g.velocity * np.array([1, 1, 1.5]) * rng.standard_normal((len(k), 3)), np.full((len(k), 1), g.velocity)]
        header += ",velN [m/s],velE [m/s],velD [m/s],sAcc [m/s]"
        formats += ["%.3f"] * 4
    used = np.ones(len(k), bool)
    for begin in np.arange(0.4 * seconds, seconds - 45, 75):
        used &= ~((t[k] > begin) & (t[k] < begin + 15))
    write(folder / "gnss.csv", header, [c[used] for c in columns], formats)
    i = np.minimum((np.arange(n) + 1) * fine, len(t) - 1)
    velocity = np.einsum("nji,jk,nk->ni", to_local[i], level, v[i])
    attitude = np.einsum("nji,jk,nkl->nil", to_local[i], level, C[i])
    made = {"seed": seed, "motion": motion, "imu": imu, "receiver": receiver, "clock": float(clock), "late": g.late}
    (folder / "made.json").write_text(json.dumps(made))
    return Truth(ends + start, places[0][i], places[1][i], places[2][i], velocity, attitude, forces, g.late, t[k][~used] + start, made)


def write(file: Path, header: str, columns, formats):
    """A table."""
    np.savetxt(file, np.column_stack(columns), delimiter=",", header=header, comments="", fmt=formats)
