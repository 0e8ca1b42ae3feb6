#!/usr/bin/env python3
"""Holds `evaluate` against evo: APE and RPE of 100 m and 1 s, aligned by nothing, SE(3), Umeyama with scale.

usage: evo_oracle.py EVALUATE REPLAY SIMULATE SOURCE WORK [DATASETS]

Places are taken into east, north, up by formulas of this file, so that nothing of piste is in the reference. The run is
simulated; with DATASETS, the recorded drive is compared too (filtered against smoothed). Exit 1: a difference of more
than 1e-9 relative plus 1e-8 m (or deg).
"""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
from evo.core import metrics
from evo.core.trajectory import PoseTrajectory3D

A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)


def ecef(lat, lon, h):
    n = A / np.sqrt(1 - E2 * np.sin(lat) ** 2)
    return np.stack([(n + h) * np.cos(lat) * np.cos(lon), (n + h) * np.cos(lat) * np.sin(lon),
                     (n * (1 - E2) + h) * np.sin(lat)], axis=-1)


def ned_axes(lat, lon):
    """R_en: columns are north, east, down in ECEF."""
    sl, cl, so, co = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    return np.stack([np.stack([-sl * co, -sl * so, cl], -1), np.stack([-so, co, 0 * so], -1),
                     np.stack([-cl * co, -cl * so, -sl], -1)], axis=-1)


def euler(roll, pitch, heading):
    cr, sr, cp, sp, ch, sh = (f(a) for a in (roll, pitch, heading) for f in (np.cos, np.sin))
    return np.stack([np.stack([cp * ch, sr * sp * ch - cr * sh, cr * sp * ch + sr * sh], -1),
                     np.stack([cp * sh, sr * sp * sh + cr * ch, cr * sp * sh - sr * ch], -1),
                     np.stack([-sp, sr * cp, cr * cp], -1)], axis=-2)


def table(file):
    with open(file) as f:
        names = f.readline().strip().split(",")
    data = np.loadtxt(file, delimiter=",", skiprows=1)
    return {name: data[:, i] for i, name in enumerate(names)}


def poses(track, origin):
    """R and p in east, north, up at the origin."""
    lat, lon, h = np.radians(track["latitude_deg"]), np.radians(track["longitude_deg"]), track["height_m"]
    to_enu = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]]) @ ned_axes(*origin[:2]).T
    p = (ecef(lat, lon, h) - ecef(*origin)) @ to_enu.T
    R = euler(*(np.radians(track[k]) for k in ("roll_deg", "pitch_deg", "heading_deg")))
    return np.einsum("ij,njk,nkl->nil", to_enu, ned_axes(lat, lon), R), p


def evo_track(track, rows, origin):
    R, p = poses({k: v[rows] for k, v in track.items()}, origin)
    se3 = np.tile(np.eye(4), (len(p), 1, 1))
    se3[:, :3, :3], se3[:, :3, 3] = R, p
    return PoseTrajectory3D(poses_se3=list(se3), timestamps=track["time_s"][rows])


def differs(what, ours, evo):
    if abs(ours - evo) <= 1e-9 * abs(evo) + 1e-8:
        return 0
    print(f"{what}: {ours!r}, evo {evo!r}")
    return 1


def compare(evaluate, a, b, work, name):
    ta, tb = table(a), table(b)
    micro = [np.round(1e6 * t["time_s"]).astype(np.int64) for t in (ta, tb)]
    _, rows_a, rows_b = np.intersect1d(*micro, return_indices=True)
    origin = (math.radians(tb["latitude_deg"][0]), math.radians(tb["longitude_deg"][0]), tb["height_m"][0])
    rate = round(1 / np.median(np.diff(ta["time_s"][rows_a])))
    even = np.ptp(np.diff(ta["time_s"][rows_a])) < 1e-5
    wrong = 0
    for kind in ("none", "se3", "sim3"):
        est, ref = evo_track(ta, rows_a, origin), evo_track(tb, rows_b, origin)
        if kind != "none":
            est.align(ref, correct_scale=kind == "sim3")
        out = work / f"{name}_{kind}"
        subprocess.run([evaluate, a, b, "--align", kind, "--rpe", "100m", "--rpe", "1s", "--output", out, "--quiet"],
                       check=True)
        found = json.loads((out / "evaluation.json").read_text())
        wrong += differs(f"{name} {kind} epochs", found["epochs"], len(rows_a))
        steps = [(None, found["ape"]), ("100 m", found["rpe"]["100 m"])]
        if even:
            steps.append(("1 s", found["rpe"]["1 s"]))
        for step, ours in steps:
            for relation, values in ((metrics.PoseRelation.translation_part, ours),
                                     (metrics.PoseRelation.rotation_angle_deg, ours["rotation"])):
                unit = "m" if values is ours else "deg"
                if step is None:
                    metric = metrics.APE(relation)
                elif step == "1 s":
                    metric = metrics.RPE(relation, rate, metrics.Unit.frames, pairs_from_reference=True)
                else:
                    metric = metrics.RPE(relation, 100.0, metrics.Unit.meters, pairs_from_reference=True)
                metric.process_data((ref, est))
                for key, value in metric.get_all_statistics().items():
                    if key != "sse":
                        wrong += differs(f"{name} {kind} {step or 'ape'} {key} {unit}", values[f"{key}_{unit}"], value)
    print(f"{name}: {len(rows_a)} epochs, {'1 s compared' if even else 'uneven: 1 s not compared'}")
    return wrong


def replayed(replay, config, out):
    subprocess.run([replay, config, "--output", out, "--quiet"], check=True)
    return out


def main():
    evaluate, replay, simulate, source, work = (Path(a).resolve() for a in sys.argv[1:6])
    work.mkdir(parents=True, exist_ok=True)
    run = work / "run"
    (work / "scenario.yaml").write_text(
        f"base: {source}/config/scenarios/ski_run.yaml\n"
        "motion: {rest_before: 10 s, run: 60 s, rest_after: 5 s, net_turn: 160 deg}\n")
    subprocess.run([simulate, work / "scenario.yaml", "--output", run, "--quiet"], check=True)
    (work / "run.yaml").write_text(
        f"imu: {{file: run/mt9a_1.csv, sensor: {source}/config/sensors/xsens_mt9a.yaml}}\n"
        "gnss: {file: run/gnss.csv, lever_arm: -0.06 0.03 -0.42 m}\n")
    out = replayed(replay, work / "run.yaml", work / "replayed")
    wrong = compare(evaluate, out / "smoothed.csv", run / "truth.csv", work, "simulated")
    if len(sys.argv) > 6 and Path(sys.argv[6], "drive").is_dir():
        drive = Path(sys.argv[6]).resolve() / "drive"
        (work / "drive.yaml").write_text(
            f"imu: {{file: {drive}/imu.txt, format: kf_gins, sensor: {source}/config/sensors/mems_car.yaml}}\n"
            f"gnss: {{file: {drive}/gnss.txt, format: kf_gins, lever_arm: 0 -0.05 0 m, use: position}}\n")
        out = replayed(replay, work / "drive.yaml", work / "drive")
        wrong += compare(evaluate, out / "filtered.csv", out / "smoothed.csv", work, "drive")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
