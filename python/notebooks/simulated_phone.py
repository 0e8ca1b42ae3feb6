"""Simulates a drive as the phone of phone.ipynb would have logged it, for readers without the recording."""

from pathlib import Path

import numpy as np
import piste

BOOT = 473_995_000_000_000  # ns on the phone's clock when the recording begins
WEEK, START = 2130, 289_069  # GPS: 2020-11-04
LEAP = 18  # s between GPS time and UTC then
UNIX_OF_GPS = 315_964_800  # s


def write(folder: Path) -> Path:
    """Writes the three logs into a folder, which is returned."""
    drive = piste.simulate(
        Path(piste.share) / "scenarios/bicycle.yaml",
        seed=1,
        start=f"{START} s",
        motion={
            "rest_before": "30 s",
            "run": "240 s",
            "rest_after": "10 s",
            "speed": "14 m/s",
            "cycle": "30 s",
            "lean": 0,
        },
        mounting="0 0 0 deg",
        vehicle={"kind": "car"},
        imus=[{"name": "phone", "sensor": "xsens_mt9a", "rate": "50 Hz"}],
        gnss=[{"name": "gnss", "rate": "1 Hz", "position_noise": "2 2 4 m", "velocity_noise": "0.3 0.3 0.5 m/s"}],
        attitude=[],
    )
    imu, gnss = drive.imus["phone.csv"], drive.gnss["gnss.csv"]

    def stamps(times):
        return np.round(BOOT + (times - START) * 1e9).astype(np.int64)

    def log(name, header, columns, digits):
        rows = [
            ";".join(f"{x:.{d}f}" if d else str(int(x)) for x, d in zip(row, digits, strict=True))
            for row in zip(*columns, strict=True)
        ]
        (folder / name).write_text("\n".join([*header, *rows]) + "\n")

    for name, kind, unit in (("Gyro", "gyro", "rad_s"), ("Acc", "accel", "m_s2")):
        forward, right, down = (imu[f"{kind}_{axis}_{unit}"] for axis in "xyz")
        header = ["Sensor: simulated", "Vendor: piste", f"Timestamp{name} [ns]; {name}X; {name}Y; {name}Z"]
        log(f"{name}.csv", header, [stamps(imu["time_s"]), right, -down, -forward], [0, 4, 4, 4])

    late = np.random.default_rng(1).uniform(0.05, 0.4, gnss.rows)  # s
    north, east = gnss["velocity_north_m_s"], gnss["velocity_east_m_s"]
    columns = {
        "TimestampGNSS [ns]": (stamps(gnss["time_s"] + late), 0),
        "UTC time [ms]": (1e3 * (UNIX_OF_GPS + WEEK * 604_800 - LEAP + gnss["time_s"]), 0),
        "Lat [deg]": (gnss["latitude_deg"], 7),
        "Lon [deg]": (gnss["longitude_deg"], 7),
        "Height [m]": (gnss["height_m"], 1),
        "Speed [m/s]": (np.hypot(north, east), 2),
        "Heading [deg]": (np.degrees(np.arctan2(east, north)) % 360, 1),
        "Hor Acc [m]": (np.full(gnss.rows, 3.0), 1),
        "Vert Acc [m]": (np.full(gnss.rows, 6.0), 1),
    }
    log("GNSS.csv", ["; ".join(columns)], [c for c, _ in columns.values()], [d for _, d in columns.values()])
    return folder
