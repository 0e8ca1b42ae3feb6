#!/usr/bin/env python3
"""Reads every format of `export` back with a tool that is not ours, and compares it with smoothed.csv.

usage: read_back.py EXPORT RUN WORK [--strict]

RUN is a replay's folder; its places, heights and times must come back within a millimetre and a microsecond (a
millisecond where the tool keeps no more). A tool that is not there is said and skipped; with --strict that is an error.
"""

import csv
import datetime
import importlib
import json
import math
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

WEEK = 2200
GPS_EPOCH = datetime.datetime(1980, 1, 6)
LEAP = 18
skipped = []


def utc(seconds):
    micro = round(seconds * 1e6)
    return GPS_EPOCH + datetime.timedelta(weeks=WEEK, microseconds=micro) - datetime.timedelta(seconds=LEAP)


def module(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        skipped.append(name)
        return None


def program(name):
    if shutil.which(name):
        return True
    skipped.append(name)
    return False


class Reader:
    def __init__(self, export, run, work):
        self.export, self.run, self.work = export, run, work
        with open(run / "smoothed.csv") as f:
            self.rows = [{k: float(v) for k, v in row.items() if k != "time_utc"} for row in csv.DictReader(f)]

    def write(self, name, file):
        out = self.work / file
        subprocess.run([self.export, self.run, "--to", name, "--week", str(WEEK), "--output", out, "--quiet"], check=True)
        return out

    def same(self, what, lat, lon, height, seconds=None, tolerance=1e-6):
        assert len(lat) == len(self.rows), f"{what}: {len(lat)} rows of {len(self.rows)}"
        for i, row in enumerate(self.rows):
            scale = 111320.0
            north = scale * (lat[i] - row["latitude_deg"])
            east = scale * (lon[i] - row["longitude_deg"]) * math.cos(math.radians(lat[i]))
            up = height[i] - row["height_m"] if height is not None else 0
            off = max(abs(north), abs(east), abs(up))
            assert off < 1e-3, f"{what}: row {i} is {off} m off"
            if seconds is not None:
                late = abs(seconds[i] - row["time_s"])
                assert late < tolerance + 1e-7, f"{what}: row {i} is {late} s off"
        print(f"{what}: {len(self.rows)} rows come back")

    def since(self, when):
        return (when - utc(0)).total_seconds()

    def gpx(self):
        file = self.write("gpx", "run.gpx")
        ns = {"g": "http://www.topografix.com/GPX/1/1"}
        points = ElementTree.parse(file).getroot().findall(".//g:trkpt", ns)
        value = lambda p, tag: float(p.find(f"g:{tag}", ns).text)  # noqa: E731
        times = [self.since(datetime.datetime.strptime(p.find("g:time", ns).text, "%Y-%m-%dT%H:%M:%S.%fZ")) for p in points]
        self.same("gpx, an XML parser", [float(p.get("lat")) for p in points], [float(p.get("lon")) for p in points],
                  [value(p, "ele") + value(p, "geoidheight") for p in points], times)
        undulation = self.undulation = [value(p, "geoidheight") for p in points]
        if program("ogr2ogr"):
            self.gdal("gpx, GDAL", file, "track_points", undulation)
        if program("gpsbabel"):
            self.gpsbabel("gpx, gpsbabel", "gpx", file, undulation)

    def gdal(self, what, file, layer, undulation):
        out = self.work / "gdal.geojson"
        out.unlink(missing_ok=True)
        subprocess.run(["ogr2ogr", "-f", "GeoJSON", "-lco", "COORDINATE_PRECISION=10", out, file, layer], check=True,
                       stderr=subprocess.DEVNULL)
        features = json.loads(out.read_text())["features"]
        places = [f["geometry"]["coordinates"] for f in features]
        self.same(what, [p[1] for p in places], [p[0] for p in places],
                  [(p[2] if len(p) > 2 else f["properties"]["ele"]) + n
                   for p, f, n in zip(places, features, undulation, strict=True)])

    def gpsbabel(self, what, kind, file, undulation):
        out = self.work / "babel.csv"
        subprocess.run(["gpsbabel", "-t", "-i", kind, "-f", file, "-o", "unicsv,utc=0", "-F", out], check=True)
        with open(out) as f:
            rows = list(csv.DictReader(f))
        # unicsv has 6 decimals, 0.11 m, and 0.1 m of height: whether all rows are there, and about where.
        assert len(rows) == len(self.rows), f"{what}: {len(rows)} rows"
        for row, ours, n in zip(rows, self.rows, undulation, strict=True):
            assert abs(float(row["Latitude"]) - ours["latitude_deg"]) < 1e-6
            assert abs(float(row["Longitude"]) - ours["longitude_deg"]) < 1e-6
            assert abs(float(row["Altitude"]) + n - ours["height_m"]) < 0.06
        print(f"{what}: {len(rows)} rows come back")

    def kml(self):
        """The map of the run itself, by GDAL: its track is that of the rows, at their heights less the geoid's."""
        if not program("ogr2ogr"):
            return
        out = self.work / "kml.geojson"
        out.unlink(missing_ok=True)
        subprocess.run(["ogr2ogr", "-f", "GeoJSON", "-lco", "COORDINATE_PRECISION=10", out, self.run / "trajectory.kml"], check=True,
                       stderr=subprocess.DEVNULL)
        lines = []

        def collect(geometry):
            if geometry["type"] == "GeometryCollection":
                for part in geometry["geometries"]:
                    collect(part)
            elif geometry["type"].endswith("LineString"):
                lines.extend(geometry["coordinates"] if geometry["type"].startswith("Multi") else [geometry["coordinates"]])

        for feature in json.loads(out.read_text())["features"]:
            collect(feature["geometry"])
        count = 0
        for line in lines:
            row = 0
            for lon, lat, height in line:  # in the order of the rows
                while row < len(self.rows) and not (abs(self.rows[row]["latitude_deg"] - lat) < 3e-7 and abs(self.rows[row]["longitude_deg"] - lon) < 5e-7):
                    row += 1
                assert row < len(self.rows), f"kml: {lat} {lon} is no row of the run"
                off = abs(self.rows[row]["height_m"] - self.undulation[row] - height)
                assert off < 1, f"kml: the height of {lat} {lon} is {off} m off"
                count += 1
        assert count > 100, f"kml: {count} places"
        print(f"kml, GDAL: {count} places of {len(lines)} lines are rows of the run")

    def geojson(self):
        file = self.write("geojson", "run.geojson")
        feature = json.loads(file.read_text())
        places = feature["geometry"]["coordinates"]
        times = [self.since(datetime.datetime.strptime(t, "%Y-%m-%dT%H:%M:%S.%fZ")) for t in feature["properties"]["coordTimes"]]
        self.same("geojson, a JSON parser", [p[1] for p in places], [p[0] for p in places], [p[2] for p in places], times)
        if program("ogrinfo"):
            said = subprocess.run(["ogrinfo", "-al", "-so", file], capture_output=True, text=True, check=True).stdout
            assert "Line String" in said and "Feature Count: 1" in said, said
            print("geojson, GDAL: one line")

    def nmea(self):
        file = self.write("nmea", "run.nmea")
        if pynmea2 := module("pynmea2"):
            gga, rmc = [], []
            for line in file.read_text().splitlines():
                sentence = pynmea2.parse(line, check=True)
                (gga if sentence.sentence_type == "GGA" else rmc).append(sentence)
            times = [self.since(datetime.datetime.combine(r.datestamp, r.timestamp.replace(tzinfo=None))) for r in rmc]
            self.same("nmea, pynmea2", [g.latitude for g in gga], [g.longitude for g in gga],
                      [float(g.altitude) + float(g.geo_sep) for g in gga], times)
            for sentence, row in zip(rmc, self.rows, strict=True):
                speed = math.hypot(row["velocity_north_m_s"], row["velocity_east_m_s"])
                assert abs(sentence.spd_over_grnd * 1852 / 3600 - speed) < 1e-4
        if program("gpsbabel"):
            undulation = [0.0] * len(self.rows)
            for i, line in enumerate(x for x in file.read_text().splitlines() if "GGA" in x):
                undulation[i] = float(line.split(",")[11])
            self.gpsbabel("nmea, gpsbabel", "nmea", file, undulation)

    def poses(self):
        tum, kitti, euroc = self.write("tum", "run.tum"), self.write("kitti", "poses.txt"), self.write("euroc", "run.csv")
        if not module("evo") or not module("pyproj"):
            return
        import numpy as np
        import pyproj
        from evo.tools import file_interface

        first = self.rows[0]
        enu = pyproj.Transformer.from_pipeline(
            f"+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 +step "
            f"+proj=topocentric +ellps=WGS84 +lon_0={first['longitude_deg']} +lat_0={first['latitude_deg']} "
            f"+h_0={first['height_m']}")
        columns = {k: np.array([r[k] for r in self.rows]) for k in first}
        expected = np.stack(enu.transform(columns["longitude_deg"], columns["latitude_deg"], columns["height_m"]), axis=1)
        tracks = {"tum": file_interface.read_tum_trajectory_file(tum),
                  "euroc": file_interface.read_euroc_csv_trajectory(euroc),
                  "kitti": file_interface.read_kitti_poses_file(kitti)}
        times = np.loadtxt(self.work / "poses_times.txt")
        heading = np.radians(columns["heading_deg"])
        for name, track in tracks.items():
            off = np.abs(track.positions_xyz - expected).max()
            assert off < 1e-3, f"{name}: {off} m off"
            stamps = times if name == "kitti" else track.timestamps
            assert np.abs(stamps - columns["time_s"]).max() < 1.1e-6, name
            R = np.array(track.poses_se3)[:, :3, :3]
            forward = np.arctan2(R[:, 0, 0], R[:, 1, 0])  # azimuth of the body's forward axis, at the origin's level
            assert np.abs(np.angle(np.exp(1j * (forward - heading)))).max() < 1e-3, name
            assert np.degrees(np.arccos(np.clip(-R[0, 2, 2], -1, 1))) < 90, name  # down is down
            print(f"{name}, evo: {len(R)} rows come back")

    def sbet(self):
        file = self.write("sbet", "sbet.out")
        rows = list(struct.iter_unpack("<17d", file.read_bytes()))
        self.same("sbet, its published layout", [math.degrees(r[1]) for r in rows], [math.degrees(r[2]) for r in rows],
                  [r[3] for r in rows], [r[0] for r in rows])
        accuracy = list(struct.iter_unpack("<10d", (self.work / "sbet_smrmsg.out").read_bytes()))
        for r, a, row in zip(rows, accuracy, self.rows, strict=True):
            close = [(r[4], row["velocity_north_m_s"]), (r[6], row["velocity_down_m_s"]),
                     (math.degrees(r[7]), row["roll_deg"]), (math.degrees(r[9]), row["heading_deg"]), (r[10], 0),
                     (a[0], row["time_s"]), (a[1], row["sigma_north_m"]), (a[6], row["sigma_velocity_down_m_s"]),
                     (a[9] / 60, row["sigma_heading_deg"])]
            assert all(abs(x - y) < 1e-6 for x, y in close), close

    def rtklib(self):
        file = self.write("rtklib", "run.pos")
        rows = [line.split() for line in file.read_text().splitlines() if not line.startswith("%")]
        times = [(datetime.datetime.strptime(f"{r[0]} {r[1]}", "%Y/%m/%d %H:%M:%S.%f") - GPS_EPOCH
                  - datetime.timedelta(weeks=WEEK)).total_seconds() for r in rows]
        self.same("rtklib, its published layout", [float(r[2]) for r in rows], [float(r[3]) for r in rows],
                  [float(r[4]) for r in rows], times)

    def numpy(self):
        file = self.write("numpy", "run.npz")
        if np := module("numpy"):
            arrays = np.load(file)
            assert list(arrays) == list(self.rows[0])
            for name in arrays:
                assert arrays[name].tolist() == [row[name] for row in self.rows], name
            print(f"numpy: {len(arrays)} columns come back")


def main():
    reader = Reader(*(Path(a).resolve() for a in sys.argv[1:4]))
    reader.work.mkdir(parents=True, exist_ok=True)
    for part in (reader.gpx, reader.kml, reader.geojson, reader.nmea, reader.poses, reader.sbet, reader.rtklib, reader.numpy):
        part()
    for name in sorted(set(skipped)):
        print(f"skipped: {name} is not here")
    return 1 if skipped and "--strict" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
