"""How far the values of two folders of outputs differ, in units of their own sigmas. scripts/same_outputs --sigmas prints it.

A change of 0.01 sigma is no change for a user, however many digits of the value differ. A value has a sigma if its
table has a column for it (`heading_deg` and `sigma_heading_deg`), or its JSON object a key. The sigma is taken from
BEFORE, in the same row.
"""

import csv
import io
import json
import math
from collections import Counter
from dataclasses import dataclass, field

EQUATOR = 6378137.0  # m, WGS84
ECCENTRICITY_2 = 6.69437999014e-3
START = 1.0  # s: the first rows, in which the filter settles and changes are larger than later
KEYS = ("time_s", "source", "run", "sensor", "axis", "unit", "method", "quantity")  # these columns identify a row
# Sigmas whose names differ from the names of their values.
PARTNERS = {
    "sigma_north_m": "latitude_deg",
    "sigma_east_m": "longitude_deg",
    "sigma_down_m": "height_m",
    "sigma_1": "residual_1",
    "sigma_2": "residual_2",
    "sigma_3": "residual_3",
    "sigma": "value",
    "standard_error": "bias",
}
MOST = 10  # values of one JSON document that are listed; one of compare has hundreds
# JSON keys: the uncertainty of the mean NEES of an ensemble.
JSON_PARTNERS = {"sigma": "value", "standard_error": "nees"}


@dataclass
class Worst:
    """The largest change of a value, in sigmas, and its row."""

    change: float = 0.0
    at: str = ""

    def see(self, change, at):
        if change > self.change:
            self.change, self.at = change, at


@dataclass
class Column:
    """The changes of one value of a file."""

    name: str
    later: Worst = field(default_factory=Worst)  # all rows but those of the start
    start: Worst = field(default_factory=Worst)
    low: float = math.inf  # sigma of AFTER over that of BEFORE: smallest and largest
    high: float = -math.inf

    def see(self, change, ratio, at, in_start):
        (self.start if in_start else self.later).see(change, at)
        self.low, self.high = min(self.low, ratio), max(self.high, ratio)

    def changed(self):
        return self.later.change > 0 or self.start.change > 0 or self.low < 1 or self.high > 1


@dataclass
class File:
    """The columns of a file, the number of rows in both folders, and of those in only one of them."""

    name: str
    columns: list
    both: int = 0
    only_before: int = 0
    only_after: int = 0
    missing: list = field(default_factory=list)  # values that have a sigma in only one of the two


def number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return math.nan


def metres_per_degree(latitude, height):
    """Metres per degree to the north and to the east on the WGS84 ellipsoid, by its radii of curvature."""
    phi = math.radians(latitude)
    root = math.sqrt(1 - ECCENTRICITY_2 * math.sin(phi) ** 2)
    north = EQUATOR * (1 - ECCENTRICITY_2) / root**3 + height
    east = (EQUATOR / root + height) * math.cos(phi)
    return math.radians(north), math.radians(east)


def in_sigmas(difference, sigma):
    """A change in sigmas. It is infinite without a sigma, and from or to an empty cell (not a number)."""
    if math.isnan(difference):
        return math.inf
    if difference == 0:
        return 0.0
    return abs(difference) / sigma if sigma > 0 else math.inf


def ratio(before, after):
    if before == after or (math.isnan(before) and math.isnan(after)):
        return 1.0
    return after / before if before > 0 else math.inf


def difference(name, before, after):
    if math.isnan(before) and math.isnan(after):
        return 0.0
    # 359.9 and 0.1 degrees are 0.2 degrees apart.
    return math.remainder(after - before, 360) if name.endswith("_deg") else after - before


class Rows:
    """A table with its rows indexed by their time and other identifying columns."""

    def __init__(self, text):
        reader = csv.reader(io.StringIO(text))
        self.names = next(reader, [])
        self.at = {name: i for i, name in enumerate(self.names)}
        keys = [self.at[name] for name in KEYS if name in self.at]
        self.rows, seen = {}, Counter()
        for cells in reader:
            key = tuple(cells[i] for i in keys)
            seen[key] += 1  # rows of equal keys keep their order in both
            self.rows[(*key, seen[key])] = cells
        first = next(iter(self.rows.values()), None)
        self.start = number(first[self.at["time_s"]]) + START if first and "time_s" in self.at else -math.inf

    def pairs(self):
        """Values and their sigmas."""
        named = [(PARTNERS.get(s) or s.removeprefix("sigma_"), s)
                 for s in self.names if s in PARTNERS or s.startswith("sigma_")]
        return [(value, sigma) for value, sigma in named if value in self.at]

    def cell(self, row, name):
        return number(row[self.at[name]])


def change_of_row(value, sigma, sides, rows):
    (before, after), (row, other) = sides, rows
    u, v = before.cell(row, value), after.cell(other, value)
    moved = difference(value, u, v)
    if value in ("latitude_deg", "longitude_deg") and sigma.endswith("_m"):
        height = before.cell(row, "height_m") if "height_m" in before.at else 0.0
        moved *= metres_per_degree(before.cell(row, "latitude_deg"), height)[value == "longitude_deg"]
    s, t = before.cell(row, sigma), after.cell(other, sigma)
    return in_sigmas(moved, s), ratio(s, t)


def compared_tables(name, before, after):
    """Compares two tables; None if they have no sigmas."""
    sides = Rows(before), Rows(after)
    pairs = [[tuple(pair) for pair in side.pairs()] for side in sides]
    common = [pair for pair in pairs[0] if pair in pairs[1]]
    if not pairs[0] and not pairs[1]:
        return None
    file = File(name, [Column(value) for value, _ in common])
    file.missing = [value for value, _ in sorted(set(pairs[0]) ^ set(pairs[1]))]
    same_columns = sides[0].names == sides[1].names
    for key, row in sides[0].rows.items():
        other = sides[1].rows.get(key)
        if other is None:
            file.only_before += 1
            continue
        file.both += 1
        at = " ".join(key[:-1])
        in_start = "time_s" in sides[0].at and sides[0].cell(row, "time_s") <= sides[0].start
        for column, (value, sigma) in zip(file.columns, common, strict=True):
            change, of_sigma = (0.0, 1.0) if same_columns and row == other else change_of_row(value, sigma, sides, (row, other))
            column.see(change, of_sigma, at, in_start)
    file.only_after = len(sides[1].rows) - file.both
    return file


def numbers(value):
    """A number or a list of numbers, as a list; None for anything else."""
    values = value if isinstance(value, list) else [value]
    if not all(v is None or (isinstance(v, int | float) and not isinstance(v, bool)) for v in values):
        return None
    return [math.nan if v is None else float(v) for v in values]


def walk(node, path=""):
    """All values of a JSON document that have a sigma: path, name, values, sigmas."""
    if isinstance(node, list):
        for i, item in enumerate(node):
            name = item.get("name", item.get("method", i)) if isinstance(item, dict) else i
            yield from walk(item, f"{path}[{name}]")
    if not isinstance(node, dict):
        return
    for key, item in node.items():
        yield from walk(item, f"{path}.{key}" if path else key)
        value = JSON_PARTNERS.get(key) or (key.removeprefix("sigma_") if key.startswith("sigma_") else None)
        if value in node:
            values, sigmas = numbers(node[value]), numbers(item)
            if values and sigmas and len(values) == len(sigmas):
                # The unit is a key next to `value`, or part of other names.
                unit = "_deg" if node.get("unit") == "deg" else ""
                yield f"{path}.{value}" if path else value, value + unit, values, sigmas


def compared_documents(name, before, after):
    """Compares two JSON documents; None if they have no sigmas. Each value counts as a row."""
    found = [{path: rest for path, *rest in walk(json.loads(text))} for text in (before, after)]
    if not found[0] and not found[1]:
        return None
    file = File(name, [])
    file.only_before, file.only_after = len(found[0].keys() - found[1].keys()), len(found[1].keys() - found[0].keys())
    for path, (value, values, sigmas) in found[0].items():
        if path not in found[1]:
            continue
        file.both += 1
        _, others, other_sigmas = found[1][path]
        column = Column(path)
        if len(values) != len(others):
            column.see(math.inf, 1.0, "", False)
        for i, (u, v, s, t) in enumerate(zip(values, others, sigmas, other_sigmas, strict=False)):
            at = f"[{i}]" if len(values) > 1 else ""
            column.see(in_sigmas(difference(value, u, v), s), ratio(s, t), at, False)
        file.columns.append(column)
    return file


def compare(before, after):
    """Compares the files with sigmas that both folders have."""
    compared = {".csv": compared_tables, ".json": compared_documents}
    files = []
    for path in sorted(p for p in before.rglob("*") if p.suffix in compared and (after / p.relative_to(before)).is_file()):
        other, name = after / path.relative_to(before), path.relative_to(before).as_posix()
        if path.read_bytes() == other.read_bytes():
            continue
        file = compared[path.suffix](name, path.read_text(encoding="utf-8"), other.read_text(encoding="utf-8"))
        if file:
            files.append(file)
    return files


def unexplained(files, changelog, most):
    """Of the values that changed by more than `most` sigmas those whose file the section "Unreleased" of the changelog
    does not name, as `WORK/FILE`: a line each."""
    unreleased = changelog.partition("## Unreleased")[2].partition("\n## ")[0]
    lines = []
    for file in files:
        if f"`{file.name}`" in unreleased:
            continue
        for column in file.columns:
            change = max(column.later.change, column.start.change)
            if change > most:
                lines.append(f"{file.name}: {column.name} changed by {change:.2g} sigma; CHANGELOG.md does not name `{file.name}`")
    return lines


def table(files):
    """The lines to print: the changes of each file, the worst column first."""
    rows, notes = [], []
    for file in files:
        changed = [column for column in file.columns if column.changed()]
        changed.sort(key=lambda column: max(column.later.change, column.start.change), reverse=True)
        listed = changed[:MOST] if file.name.endswith(".json") else changed
        if len(listed) < len(changed):
            notes.append(f"{file.name}: {len(changed) - len(listed)} more values changed less")
        for c in listed:
            rows.append((file.name, c.name, f"{c.later.change:.2g}", c.later.at or "-", f"{c.start.change:.2g}",
                         c.start.at or "-", f"{c.low:.4g} to {c.high:.4g}"))
        if file.only_before or file.only_after:
            notes.append(f"{file.name}: {file.both} rows in both, {file.only_before} only before, {file.only_after} only after")
        if file.missing:
            notes.append(f"{file.name}: only one of both has {', '.join(file.missing)}")
    if not rows:
        return [*notes, "no value that has a sigma changed"]
    head = ("file", "value", "sigmas", "at", f"first {START:.0f} s", "at", "sigma after/before")
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in [head, *rows]]
    return lines + notes
