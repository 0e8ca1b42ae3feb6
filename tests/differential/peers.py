"""Another filter on a configuration of replay: same logs, same noises, its solution in our columns.

usage: PYTHON peers.py PEER CONFIGURATION START --output FOLDER
       PYTHON peers.py --installed           the peers that are there, and a line on standard error for each that is not

PEER: inslib    (github.com/jnz/INSLIB, AGPL: run as a process, by the `inslib-run` beside PYTHON)
      sidereon  (MIT: imported, from the packages of PYTHON)
      turned    (sidereon, the sign of its corrections of the gyro's bias turned after each fix)
START: the folder of a replay. The peer is given the first row of its smoothed.csv: position and velocity to .1 m and .1 m/s, roll
and pitch to 2 deg, and the heading as the configuration says; and its lever arm, where it estimated one. PYTHON needs NumPy and
PyYAML.

A step of the IMU that has a fix in it is split there, so that the fix is used at its time. Drifts become random walks of the
same density. Scales are not estimated. With a car as vehicle the peer has its own constraint of a car.
Writes FOLDER/filtered.csv, 20 rows a second. Exit 0: done; 1: the peer failed or is not installed.
"""

import csv
import importlib.util
import json
import math
import pathlib
import subprocess
import sys

try:
    import numpy as np
    import yaml
except ImportError:  # `missing` says so
    pass

AXES, NED = "xyz", ("north", "east", "down")
DEGREE, G = math.pi / 180, 9.80665
UNITS = {"": 1, "deg": DEGREE, "deg/s": DEGREE, "rad/s": 1, "m/s^2": 1, "mg": 1e-3 * G, "ug": 1e-6 * G, "g": G, "s": 1, "m": 1, "ms": 1e-3}
RATE = 20  # Hz, of the output
PLACE, SPEED, LEVEL = 0.1, 0.1, 2 * DEGREE  # what is known of the start
# m/s across a car, for each peer the best of some on the drive of docs/anchors.md; while it turns by less than that in a second
SLIP, CURVE = {"inslib": 0.05, "sidereon": 0.2}, 25 * DEGREE
A, E2 = 6378137.0, 0.00669437999014
COLUMNS = ["time_s", "latitude_deg", "longitude_deg", "height_m", *(f"velocity_{a}_m_s" for a in NED), "roll_deg", "pitch_deg",
           "heading_deg", *(f"sigma_{a}_m" for a in NED), *(f"sigma_velocity_{a}_m_s" for a in NED), *(f"sigma_about_{a}_deg" for a in NED)]


def missing():
    """What is not installed, by peer."""
    python = pathlib.Path(sys.executable)
    absent = {"inslib": None if (python.parent / "inslib-run").exists() else "there is no inslib-run beside the interpreter",
              "sidereon": None if importlib.util.find_spec("sidereon") else "the interpreter has no sidereon"}
    for needed in ("numpy", "yaml"):
        if not importlib.util.find_spec(needed):
            absent = {peer: why or f"the interpreter has no {needed}" for peer, why in absent.items()}
    return {**absent, "turned": absent["sidereon"]}


def three(text):
    """Numbers and a unit, as in a configuration, in SI; one number counts for three axes."""
    words = str(text).split()
    unit = words.pop() if words[-1][0].isalpha() else ""
    values = [float(word) * UNITS[unit.removesuffix("/sqrt(Hz)")] for word in words]
    return np.array(values if len(values) == 3 else values * 3)


def load(file):
    """A configuration with its bases; files that it names count from its folder."""
    own = yaml.safe_load(file.read_text())
    for part, key in (("imu", "file"), ("imu", "accel_file"), ("imu", "sensor"), ("gnss", "file")):
        section = own.get(part)
        section = section[0] if isinstance(section, list) else section
        if section and key in section:
            section[key] = file.parent / section[key]
            own[part] = section
    return {**load(file.parent / own["base"]), **own} if "base" in own else own


def columns(file):
    with open(file, newline="") as rows:
        return [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(rows)]


def named(file):
    """Columns of a phone's log by name, times in s: semicolons, a header with units, and lines before it."""
    lines = [line.rstrip("; ").split(";") for line in file.read_text().splitlines() if line.count(";") > 1]
    heads = [head.strip().removesuffix("]").split(" [") for head in lines[0]]
    table = np.array(lines[1:], dtype=float)
    return {name: table[:, k] * {"ns": 1e-9, "ms": 1e-3}.get(unit, 1) for k, (name, unit) in enumerate(heads)}


def seconds_of_week(utc):
    """GPS time of times since 1970, in the 18 leap seconds since 2017."""
    return (utc - 315964800 + 18) % 604800


def read_imu(section):
    """Rows (time, rate, force): means over the step before, forward, right and down."""
    axes = section.get("axes", "+x +y +z").split()
    turn = np.array([[(axis[1] == a) * (-1 if axis[0] == "-" else 1) for a in AXES] for axis in axes])
    if section.get("format") == "kf_gins":
        table = np.loadtxt(section["file"])
        step = np.diff(table[:, 0])[:, None]
        rows = zip(table[1:, 0], table[1:, 1:4] / step, table[1:, 4:7] / step)
    elif section.get("format") == "columns":  # gyroscopes and accelerometers, each at their own times
        gyro, accel, names = named(section["file"]), named(section["accel_file"]), section["columns"]
        time, own = gyro[names["time"]["name"]], accel[names["accel"]["time"]["name"]]
        force = np.column_stack([np.interp(time, own, accel[name]) for name in names["accel"]["names"]])
        rows = zip(time - three(section["clock"]["offset"])[0], np.column_stack([gyro[name] for name in names["gyro"]["names"]]), force)
    else:
        table = columns(section["file"])
        unit, scale = ("deg_s", DEGREE) if "gyro_x_deg_s" in table[0] else ("rad_s", 1)
        rows = ((r["time_s"], scale * np.array([r[f"gyro_{a}_{unit}"] for a in AXES]), np.array([r[f"accel_{a}_m_s2"] for a in AXES]))
                for r in table)
    return [(t, turn @ rate, turn @ force) for t, rate, force in rows]


def read_fixes(section, outages):
    """Rows (time, latitude, longitude [rad], height, sigmas, velocity and its sigmas, or None)."""
    if section.get("format") == "kf_gins":
        table = np.loadtxt(section["file"])
    elif section.get("format") == "columns":
        log, names = named(section["file"]), {key: value["name"] for key, value in section["columns"].items()}
        radius = log[names["horizontal_accuracy"]] / math.sqrt(-2 * math.log(1 - 0.68))  # of 68 %, to a sigma of one axis
        table = np.column_stack([seconds_of_week(log[names["time"]]), *(log[names[key]] for key in ("latitude", "longitude", "height")),
                                 radius, radius, log[names["vertical_accuracy"]]])
    else:
        names = COLUMNS[:4] + [f"sigma_{a}_m" for a in NED] + COLUMNS[4:7] + [f"sigma_velocity_{a}_m_s" for a in NED]
        table = np.array([[row.get(name, math.nan) for name in names] for row in columns(section["file"])])
    delay = three(section.get("delay", "0 s"))[0]
    fast = table.shape[1] >= 13 and "velocity" in section.get("use", "velocity") and not np.isnan(table[0, 7])
    fixes = []
    for row in table:
        time = row[0] - delay
        if not any(a <= time <= a + length for a, length in outages):
            fixes.append((time, *(row[1:3] * DEGREE), row[3], row[4:7], (row[7:10], row[10:13]) if fast else None))
    return fixes


class Job:
    """What a peer is given."""

    def __init__(self, configuration, start):
        config = load(configuration)
        sensor = yaml.safe_load(config["imu"]["sensor"].read_text())
        first = columns(start / "smoothed.csv")[0]
        self.time = first["time_s"]
        self.place = np.array([first["latitude_deg"] * DEGREE, first["longitude_deg"] * DEGREE, first["height_m"]])
        self.velocity = np.array([first[f"velocity_{a}_m_s"] for a in NED])
        self.angles = np.array([first[f"{a}_deg"] for a in ("roll", "pitch", "heading")]) * DEGREE
        heading = three(config["initial"]["sigma"])[0] if "sigma" in config.get("initial", {}) else LEVEL
        self.angle_sigmas = np.array([LEVEL, LEVEL, heading])
        self.noise, self.bias, self.walk = {}, {}, {}
        for name in ("gyro", "accel"):
            part = sensor[name]
            drift = part.get("drift", {"sigma": 0, "correlation_time": 1})
            sigma, tau = three(drift["sigma"])[0], three(drift["correlation_time"])[0]
            self.noise[name], self.walk[name] = three(part["noise"]), sigma * math.sqrt(2 / tau)
            self.bias[name] = math.hypot(three(part["bias"])[0], sigma)
        summary = start / "summary.json"
        estimates = json.loads(summary.read_text())["estimates"] if summary.exists() else {}
        self.lever_arm = np.array(estimates["lever_arm"]["value"]) if "lever_arm" in estimates else three(config["gnss"].get("lever_arm", "0 m"))
        self.car = config.get("vehicle", {}).get("kind") == "car"
        self.steps = list(self._steps(read_imu(config["imu"]), read_fixes(config["gnss"], config.get("outages", []))))

    def _steps(self, imu, fixes):
        """(time, step, rate, force, fix at its end or None)."""
        now, fixes = self.time, [fix for fix in fixes if fix[0] > self.time]
        for end, rate, force in imu:
            while fixes and now < fixes[0][0] <= end:
                yield fixes[0][0], fixes[0][0] - now, rate, force, fixes[0]
                now = fixes.pop(0)[0]
            if end > now + 1e-6:
                yield end, end - now, rate, force, None
                now = end


def inslib(job, work):
    _, _, rate, force, _ = job.steps[0]
    steps = [(job.time, 0, rate, force, None), *job.steps]
    micro = {t: round(1e6 * t) for t, *_ in steps}
    with open(work / "imu.csv", "w", newline="") as file:
        csv.writer(file).writerows([micro[t], *rate, *force] for t, _, rate, force, _ in steps)
    fixes = [fix for *_, fix in steps if fix]
    fast = fixes[0][5] is not None
    with open(work / "gnss.csv", "w", newline="") as file:
        csv.writer(file).writerows(
            [micro[t], f"{latitude / DEGREE:.10f}", f"{longitude / DEGREE:.10f}", height, *sigma,
             *(np.concatenate(velocity) if fast else ())]
            for t, latitude, longitude, height, sigma, velocity in fixes)
    tiny = 1e-9  # of its noises beyond those of the IMU, which a zero would leave at their defaults
    filter_of = {
        "auto_init": False, "lat_deg": job.place[0] / DEGREE, "lon_deg": job.place[1] / DEGREE, "h_m": job.place[2],
        "init_vel_ned": job.velocity.tolist(), "rpy_init_rad": job.angles.tolist(), "rpy_init_stddev_rad": job.angle_sigmas.tolist(),
        "pos_init_stddev_m": PLACE, "vel_init_stddev_mps": SPEED,
        "acc_bias_init_stddev_mps2": job.bias["accel"], "gyr_bias_init_stddev_rps": job.bias["gyro"],
        "acc_bias_pred_stddev_mps2_sqrts": job.walk["accel"] or tiny, "gyr_bias_pred_stddev_rps_sqrts": job.walk["gyro"] or tiny,
        "pos_pred_stddev_m_sqrts": tiny, "vel_pred_stddev_mps_sqrts": tiny, "rpy_pred_stddev_rad_sqrts": tiny,
        # The receiver's sigmas as they are: its defaults are floors of .5 m and .3 m/s, and more, for receivers without RTK.
        **{f"gnss_{floor}": -1 for floor in ("pos_stddev_floor_hor_m", "pos_stddev_floor_ver_m", "vel_stddev_floor_hor_mps",
                                             "vel_stddev_floor_ver_mps")},
        "gnss_vel_noise_acc_scale_hor": -1, "gnss_vel_noise_acc_scale_ver": -1, "gnss_acc_envelope_tau_sec": -1, "gnss_pos_decimation": -1,
        "gnss_min_delay_ms": -1, "gnss_stop_disable": True, "max_deadreckoning_sec": 600, "kalman_update_dt_sec": 0.001}
    if job.car:
        filter_of |= {"automotive_mode": True, "automotive_lateral_constraint": True, "automotive_lateral_after_sec": -1,
                      "automotive_lateral_stddev_mps": SLIP["inslib"], "automotive_lateral_max_yaw_rate": CURVE}
    time = {"col": 0, "unit": "us"}
    gnss = {"file": "gnss.csv", "time": time, "pos": {"cols": [1, 2, 3]}, "stddev_ned": {"cols": [4, 5, 6]},
            "leverarm_frd": job.lever_arm.tolist()}
    if fast:
        gnss |= {"vel_ned": {"cols": [7, 8, 9]}, "vel_stddev_ned": {"cols": [10, 11, 12]}}
    imu = {"file": "imu.csv", "time": time, "gyr_var": (job.noise["gyro"] ** 2).tolist(), "acc_var": (job.noise["accel"] ** 2).tolist()}
    output = {"csv": "solution.csv", "csv_hz": RATE, "flight_log": "sigmas.ndjson", "telemetry_hz": RATE}
    plain = json.loads(json.dumps({"imu": imu, "gnss": gnss, "filter": filter_of, "output": output}))  # no numbers of NumPy
    (work / "run.yaml").write_text(yaml.safe_dump(plain))
    (work / "sigmas.ndjson").unlink(missing_ok=True)  # it is appended to
    done = subprocess.run([pathlib.Path(sys.executable).parent / "inslib-run", "run.yaml"], cwd=work, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    print(done.stdout.strip())
    # Its solution has times and no sigmas; its telemetry, of the same epochs, sigmas and no times.
    with open(work / "solution.csv", newline="") as solution, open(work / "sigmas.ndjson") as telemetry:
        for row, line in zip(csv.DictReader(solution), telemetry):
            tree = json.loads(line)["INSLIB"]
            if row["ready"] == "1" and "full3d" in tree:
                sigma = tree["full3d"]["sigma"]
                yield [int(row["t_us"]) * 1e-6, tree["global"]["lat_deg"], tree["global"]["lon_deg"], float(row["h_ell_m"]),
                       *tree["vel_ned"].values(), *tree["att_deg"].values(),
                       *sigma["pos_ned_m"].values(), *sigma["vel_ned_mps"].values(), *sigma["att_deg"].values()]


def ned_to_ecef(latitude, longitude):
    sa, ca, so, co = math.sin(latitude), math.cos(latitude), math.sin(longitude), math.cos(longitude)
    return np.array([[-sa * co, -so, -ca * co], [-sa * so, co, -ca * so], [ca, 0, -sa]])


def ecef(latitude, longitude, height):
    prime = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
    across = (prime + height) * math.cos(latitude)
    return np.array([across * math.cos(longitude), across * math.sin(longitude), (prime * (1 - E2) + height) * math.sin(latitude)])


def geodetic(p):
    across = math.hypot(p[0], p[1])
    latitude = math.atan2(p[2], across * (1 - E2))
    for _ in range(5):  # the error falls by E2 each time
        prime = A / math.sqrt(1 - E2 * math.sin(latitude) ** 2)
        latitude = math.atan2(p[2] + E2 * prime * math.sin(latitude), across)
    height = across * math.cos(latitude) + p[2] * math.sin(latitude) - A * math.sqrt(1 - E2 * math.sin(latitude) ** 2)
    return latitude, math.atan2(p[1], p[0]), height


def attitude(roll, pitch, heading):
    sr, cr, sp, cp, sh, ch = (f(a) for a in (roll, pitch, heading) for f in (math.sin, math.cos))
    return np.array([[ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr], [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
                     [-sp, cp * sr, cp * cr]])


def sidereon_row(time, state):
    nominal, latitude, longitude, height = state.nominal, *geodetic(state.nominal.position_ecef_m)
    C = ned_to_ecef(latitude, longitude)
    R = C.T @ nominal.attitude_body_to_ecef
    angles = math.atan2(R[2, 1], R[2, 2]), -math.asin(R[2, 0]), math.atan2(R[1, 0], R[0, 0])
    sigmas = [np.sqrt(np.diag(C.T @ state.covariance[i:i + 3, i:i + 3] @ C)) for i in (0, 3, 6)]
    return [time, latitude / DEGREE, longitude / DEGREE, height, *(C.T @ nominal.velocity_ecef_mps), *(a / DEGREE for a in angles),
            *sigmas[0], *sigmas[1], *(sigmas[2] / DEGREE)]


def sidereon(job, _work, turned=False):
    import sidereon as s
    C = ned_to_ecef(*job.place[:2])
    start = s.NavState(job.time, ecef(*job.place), C @ job.velocity, C @ attitude(*job.angles))
    P = np.zeros((15, 15))  # position, velocity, attitude in ECEF, biases
    for at, sigma in ((0, np.full(3, PLACE)), (3, np.full(3, SPEED)), (6, job.angle_sigmas)):
        P[at:at + 3, at:at + 3] = C @ np.diag(sigma**2) @ C.T
    P[9:12, 9:12], P[12:15, 12:15] = job.bias["accel"] ** 2 * np.eye(3), job.bias["gyro"] ** 2 * np.eye(3)
    forever = 1e6  # s: its Gauss-Markov bias is a random walk with that
    one = {name: math.sqrt(np.mean(noise**2)) for name, noise in job.noise.items()}  # it takes one noise for three axes
    walk = {name: max(density, 1e-9) * math.sqrt(forever / 2) for name, density in job.walk.items()}
    spec = s.ImuSpec(one["accel"], one["gyro"], walk["accel"], walk["gyro"], forever, forever)
    car = s.NonHolonomicConstraintConfig(SLIP["sidereon"], SLIP["sidereon"], 1.0, CURVE) if job.car else None
    config = s.InertialFilterConfig(spec, loose=s.LooseCouplingConfig(lever_arm_body_m=job.lever_arm.tolist(), non_holonomic=car))
    filter_of = s.InertialFilter.with_config(s.InsFilterState.from_covariance(start, s.ErrorStateLayout.FIFTEEN, P), config)
    shown = job.time
    for k, (time, step, rate, force, fix) in enumerate(job.steps):
        state = filter_of.propagate(s.ImuSample.increment(time, (step * force).tolist(), (step * rate).tolist(), step))
        before = state.nominal.gyro_bias_rps
        if fix:
            _, latitude, longitude, height, sigma, velocity = fix
            C, place = ned_to_ecef(latitude, longitude), ecef(latitude, longitude, height)
            R = C @ np.diag(sigma**2) @ C.T
            if velocity is None:
                measured = s.GnssFixMeasurement.position(time, place, R, 10, fix_status=s.GnssFixStatus.FIXED)
            else:
                R = np.block([[R, np.zeros((3, 3))], [np.zeros((3, 3)), C @ np.diag(velocity[1] ** 2) @ C.T]])
                measured = s.GnssFixMeasurement.position_velocity(time, place, C @ velocity[0], R, 10, fix_status=s.GnssFixStatus.FIXED)
            filter_of.update_loose(measured)
        if job.car and k % 10 == 0:
            filter_of.update_non_holonomic()
        if turned and (fix or job.car and k % 10 == 0):
            state = filter_of.state
            nominal = state.nominal.with_biases(state.nominal.accel_bias_mps2, 2 * before - state.nominal.gyro_bias_rps)
            filter_of = s.InertialFilter.with_config(s.InsFilterState.from_covariance(nominal, state.layout, state.covariance), config)
        if time - shown > 1 / RATE - 1e-3:
            shown = time
            yield sidereon_row(time, filter_of.state)


PEERS = {"inslib": inslib, "sidereon": sidereon, "turned": lambda job, work: sidereon(job, work, turned=True)}


def main():
    absent = missing()
    if sys.argv[1:] == ["--installed"]:
        for peer, why in absent.items():
            print(*(["skipped", f"{peer}:", why] if why else [peer]), file=sys.stderr if why else sys.stdout)
        return 0
    peer, configuration, start, _, folder = sys.argv[1:]
    if absent[peer]:
        print(f"{peer}: {absent[peer]}", file=sys.stderr)
        return 1
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rows = PEERS[peer](Job(pathlib.Path(configuration), pathlib.Path(start)), folder)
    with open(folder / "filtered.csv", "w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    return 0


if __name__ == "__main__":
    sys.exit(main())
