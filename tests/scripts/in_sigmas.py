#!/usr/bin/env python3
"""Tests of scripts/in_sigmas.py and scripts/same_outputs --outputs, on folders that are written here. in_sigmas.py SOURCE"""

import json
import math
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / "scripts"))
import in_sigmas  # noqa: E402

NAMES = "time_s,latitude_deg,longitude_deg,height_m,heading_deg,sigma_north_m,sigma_east_m,sigma_down_m,sigma_heading_deg"
ROW = [100.0, 60.0, 8.0, 0.0, 359.9, 0.5, 0.5, 2.0, 0.1]


def navigation(*rows):
    return "\n".join([NAMES, *(",".join(f"{cell:.10f}" for cell in row) for row in rows)]) + "\n"


def moved(row=ROW, **changes):
    return [changes.get(name, cell) for name, cell in zip(NAMES.split(","), row, strict=True)]


class InSigmas(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.sides = [Path(self.folder.name) / side for side in ("before", "after")]

    def tearDown(self):
        self.folder.cleanup()

    def compare(self, name, before, after):
        for side, text in zip(self.sides, (before, after), strict=True):
            side.mkdir(exist_ok=True)
            (side / name).write_text(text, encoding="utf-8")
        return in_sigmas.compare(*self.sides)

    def columns(self, name, before, after):
        (file,) = self.compare(name, before, after)
        return file, {column.name: column for column in file.columns}

    def later_rows(self, **changes):
        """A change in a row two seconds after the first."""
        second = moved(time_s=102.0)
        return self.columns("smoothed.csv", navigation(ROW, second), navigation(ROW, moved(second, **changes)))

    def test_nothing_changed(self):
        self.assertEqual(self.compare("smoothed.csv", navigation(ROW), navigation(ROW)), [])
        self.assertEqual(in_sigmas.table([]), ["no value that has a sigma changed"])

    def test_a_change_is_divided_by_the_sigma_of_its_row(self):
        _, columns = self.later_rows(height_m=1.0)
        self.assertAlmostEqual(columns["height_m"].later.change, 0.5)
        self.assertTrue(columns["height_m"].later.at.startswith("102.0"))
        self.assertEqual(columns["height_m"].start.change, 0)

    def test_degrees_are_metres_along_the_meridian_and_the_parallel(self):
        # At 60 degrees of latitude a degree is 111.412 km to the north and 55.800 km to the east (WGS84).
        _, columns = self.later_rows(latitude_deg=60 + 1e-5, longitude_deg=8 + 1e-5)
        self.assertAlmostEqual(columns["latitude_deg"].later.change, 1.11412 / 0.5, places=4)
        self.assertAlmostEqual(columns["longitude_deg"].later.change, 0.55800 / 0.5, places=4)

    def test_angles_wrap(self):
        _, columns = self.later_rows(heading_deg=0.1)
        self.assertAlmostEqual(columns["heading_deg"].later.change, 2, places=6)

    def test_the_first_second_counts_apart(self):
        rows = [moved(time_s=t) for t in (100.0, 101.0, 101.01)]
        after = [moved(row, height_m=h) for row, h in zip(rows, (8.0, 4.0, 1.0), strict=True)]
        _, columns = self.columns("filtered.csv", navigation(*rows), navigation(*after))
        self.assertAlmostEqual(columns["height_m"].start.change, 4)
        self.assertAlmostEqual(columns["height_m"].later.change, 0.5)

    def test_rows_are_matched_by_time(self):
        rows = [moved(time_s=t, height_m=t) for t in (100.0, 102.0, 103.0)]
        file, columns = self.columns("smoothed.csv", navigation(*rows), navigation(*rows[1:], moved(time_s=104.0)))
        self.assertEqual((file.both, file.only_before, file.only_after), (2, 1, 1))
        self.assertFalse(columns["height_m"].changed())
        self.assertIn("smoothed.csv: 2 rows in both, 1 only before, 1 only after", in_sigmas.table([file]))

    def test_sigmas_themselves_are_compared_as_a_ratio(self):
        _, columns = self.later_rows(sigma_heading_deg=0.12)
        self.assertAlmostEqual(columns["heading_deg"].high, 1.2)
        self.assertEqual(columns["heading_deg"].low, 1)
        self.assertEqual(columns["heading_deg"].later.change, 0)

    def test_a_change_without_a_sigma_is_infinite(self):
        row = moved(time_s=102.0, sigma_down_m=0.0)
        _, columns = self.columns("smoothed.csv", navigation(ROW, row), navigation(ROW, moved(row, height_m=1e-6)))
        self.assertEqual(columns["height_m"].later.change, math.inf)
        self.assertEqual(columns["latitude_deg"].later.change, 0)

    def test_a_cell_that_only_one_has_is_a_change(self):
        head = "time_s,gyro_bias_x_deg_s,sigma_gyro_bias_x_deg_s\n"
        _, columns = self.columns("biases.csv", head + "1,0.5,0.1\n5,0.5,0.1\n", head + "1,0.5,0.1\n5,,0.1\n")
        self.assertEqual(columns["gyro_bias_x_deg_s"].later.change, math.inf)

    def test_columns_that_only_one_has_are_named(self):
        file, _ = self.columns("biases.csv", "time_s,a,sigma_a\n1,2,3\n", "time_s,a,sigma_a,b,sigma_b\n1,2,3,4,5\n")
        self.assertEqual(file.missing, ["b"])

    def test_innovations_of_one_time_are_told_apart_by_their_source(self):
        head = "time_s,source,residual_1,sigma_1\n"
        before = head + "1,gnss[0].position,0.1,1\n5,gnss[0].position,0.1,1\n5,gnss[1].position,0.2,2\n"
        after = head + "1,gnss[0].position,0.1,1\n5,gnss[1].position,1.2,2\n5,gnss[0].position,0.1,1\n"
        file, columns = self.columns("innovations.csv", before, after)
        self.assertEqual(file.both, 3)
        self.assertAlmostEqual(columns["residual_1"].later.change, 0.5)
        self.assertEqual(columns["residual_1"].later.at, "5 gnss[1].position")

    def test_a_study_has_rows_without_time(self):
        head = "run,sensor,axis,unit,method,quantity,value,sigma,standard_error\n"
        before, after = (head + f"ski-1,one,x,deg/s,rest,bias,{v},0.5,0.1\n" for v in (1, 2))
        _, columns = self.columns("estimates.csv", before, after)
        self.assertAlmostEqual(columns["value"].later.change, 2)

    def test_json_has_values_beside_their_sigmas(self):
        def text(v):
            group = {"nees": 1.0 + v, "standard_error": 0.2}
            return json.dumps({"a_deg": [1, 2 + v], "sigma_a_deg": [1, 2], "b": {"unit": "m", "value": v, "sigma": 4},
                               "groups": {"whole": group}, "none": None, "sigma_none": 1})

        file, columns = self.columns("summary.json", text(0), text(1))
        self.assertAlmostEqual(columns["a_deg"].later.change, 0.5)
        self.assertEqual(columns["a_deg"].later.at, "[1]")
        self.assertAlmostEqual(columns["b.value"].later.change, 0.25)
        self.assertAlmostEqual(columns["groups.whole.nees"].later.change, 5)
        self.assertIn("groups.whole.nees", in_sigmas.table([file])[1])

    def test_files_without_sigmas_are_left_aside(self):
        self.assertEqual(self.compare("aligned.csv", "time_s,a\n1,2\n", "time_s,a\n1,3\n"), [])

    def test_a_change_needs_a_line_in_the_changelog(self):
        file, _ = self.columns("smoothed.csv", navigation(ROW), navigation(moved(height_m=1.0)))
        changelog = "# Changes\n\n## Unreleased\n\n{}\n## 0.1.0 - 2026-11-30\n\n{}\n"
        said = in_sigmas.unexplained([file], changelog.format("", "- `smoothed.csv`"), 0.05)
        self.assertEqual(len(said), 1)
        self.assertIn("smoothed.csv: height_m changed by 0.5 sigma", said[0])
        self.assertEqual(in_sigmas.unexplained([file], changelog.format("- `smoothed.csv`: higher.", ""), 0.05), [])
        self.assertEqual(in_sigmas.unexplained([file], changelog.format("", ""), 0.6), [])

    def test_same_outputs_compares_two_folders(self):
        self.compare("smoothed.csv", navigation(ROW), navigation(ROW))
        script = [sys.executable, SOURCE / "scripts" / "same_outputs", "--outputs", "--sigmas", *self.sides]
        same = subprocess.run(script, capture_output=True, text=True)
        self.assertEqual((same.returncode, same.stderr), (0, ""))
        self.assertIn("1 files, 0 differ", same.stdout)
        self.compare("smoothed.csv", navigation(ROW), navigation(moved(height_m=1.0)))
        other = subprocess.run(script, capture_output=True, text=True)
        self.assertEqual(other.returncode, 1)
        self.assertRegex(other.stdout, r"smoothed.csv +height_m +0 +- +0\.5 +100\.0")
        for most, code in (("0.05", 1), ("0.6", 0)):
            explained = subprocess.run([*script, "--explained", most], capture_output=True, text=True)
            self.assertEqual(explained.returncode, code, explained.stdout)
        wrong = subprocess.run([*script[:-1], self.sides[0] / "nowhere"], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 2)


if __name__ == "__main__":
    unittest.main()
