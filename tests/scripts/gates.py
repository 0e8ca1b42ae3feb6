#!/usr/bin/env python3
"""Do the gates of scripts/nightly close? A seeded fault for coverage, for the numbers of other builds, and the rota.

usage: gates.py SOURCE
"""

import contextlib
import importlib.machinery
import importlib.util
import io
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(sys.argv.pop(1)).resolve()


def loaded(name):
    loader = importlib.machinery.SourceFileLoader(name, str(SOURCE / "scripts" / name))
    module = sys.modules[name] = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


coverage, rota = loaded("coverage"), loaded("rota")


def line(number, count, branches=(), conditions=()):
    return {"line_number": number, "count": count,
            "branches": [{"count": c, "throw": throw} for c, throw in branches],
            "conditions": [{"count": total, "not_covered_true": list(true), "not_covered_false": list(false)}
                           for total, true, false in conditions]}


class Coverage(unittest.TestCase):
    SOURCE_LINES = ["if (a && b) {", "  f();  // if so", "}"]

    def counted(self, *lines):
        file = coverage.File()
        for entry in lines:
            file.add(entry)
        return file.count(self.SOURCE_LINES)

    def tables(self, row, name="src/math/a.cpp"):
        with contextlib.redirect_stdout(io.StringIO()):
            return coverage.print_tables({name: row})

    def test_units_that_hold_a_line_are_taken_together(self):
        row = self.counted(line(1, 0, [(0, False), (0, False)]), line(2, 0), line(1, 3, [(3, False), (0, False)]), line(2, 0))
        self.assertEqual(row, {"lines": (1, 2), "branches": (1, 2), "conditions": (0, 0)})

    def test_exceptions_and_lines_without_a_decision_have_no_branches(self):
        row = self.counted(line(1, 1, [(1, False), (0, True)]), line(2, 1, [(0, False)]), line(3, 1, [(0, False), (1, False)]))
        self.assertEqual(row["branches"], (1, 1))

    def test_copies_of_a_loop_are_one(self):
        copies = line(1, 1, [(1, False), (0, False), (0, False), (0, False), (0, False), (1, False), (1, False), (1, False)])
        self.assertEqual(self.counted(copies)["branches"], (4, 4))
        self.assertEqual(coverage.terms_of("for (int i = 0; i < n; ++i) {"), 1)
        self.assertEqual(coverage.terms_of("if (a && b || c) {"), 3)
        self.assertEqual(coverage.terms_of("return a && b;"), 2)
        self.assertEqual(coverage.terms_of("x = a ? 1 : 2;"), 1)
        self.assertEqual(coverage.terms_of("switch (a) {"), 0)

    def test_a_branch_that_no_test_takes_closes_the_gate(self):
        whole = {"lines": (100, 100), "branches": (90, 100), "conditions": (0, 0)}
        self.assertEqual(self.tables(whole), [])
        self.assertEqual(len(self.tables(whole | {"branches": (89, 100)})), 1)
        self.assertEqual(len(self.tables(whole | {"lines": (97, 100)})), 1)
        self.assertEqual(self.tables(whole | {"lines": (0, 100)}, "src/plot/a.cpp"), [], "not of the core")

    def test_a_condition_that_no_test_shows_closes_the_gate(self):
        row = {"lines": (100, 100), "branches": (100, 100), "conditions": (89, 100)}
        self.assertEqual(len(self.tables(row, "src/filter/fault_detection.cpp")), 1)
        self.assertEqual(self.tables(row, "src/filter/update.cpp"), [])
        one, other = line(1, 1, conditions=[(4, [0], [1])]), line(1, 1, conditions=[(4, [], [0, 1])])
        self.assertEqual(self.counted(one)["conditions"], (2, 4))
        self.assertEqual(self.counted(one, other)["conditions"], (3, 4), "what one unit shows is shown")


class SameNumbers(unittest.TestCase):
    ROWS = "filter 1.000000 position_0 10.0 0.01\nbatch 1.000000 euler_2 3.1415926535 0.001\n= innovation 1.000000 0 0\n"

    def code(self, text):
        with tempfile.TemporaryDirectory() as folder:
            paths = [Path(folder, name) for name in ("O3.txt", "other.txt")]
            for path, content in zip(paths, (self.ROWS, text), strict=True):
                path.write_text(content, encoding="utf-8")
            script = SOURCE / "tests" / "numbers" / "compare.py"
            return subprocess.run([sys.executable, script, *paths], capture_output=True, check=False).returncode

    def test_rounding_is_the_same(self):
        self.assertEqual(self.code(self.ROWS.replace("10.0 ", "10.000000009 ")), 0)
        self.assertEqual(self.code(self.ROWS.replace(" 3.1415926535", " -3.1415926535")), 0, "headings wrap")

    def test_a_moved_number_closes_the_gate(self):
        self.assertEqual(self.code(self.ROWS.replace("10.0 ", "10.00000002 ")), 1)
        self.assertEqual(self.code(self.ROWS.replace("0.01", "0.01000002")), 1, "a sigma")
        self.assertEqual(self.code(self.ROWS.replace("3.1415926535", "3.1415946535")), 1)

    def test_another_outcome_closes_the_gate(self):
        self.assertEqual(self.code(self.ROWS.replace("0 0\n", "0 1\n")), 1)
        self.assertEqual(self.code(self.ROWS.replace("filter 1.000000", "filter 2.000000")), 1)


class Rota(unittest.TestCase):
    PAGE = "before\n" + rota.HEAD + "\nafter\n"

    def page(self):
        page = rota.with_row(self.PAGE, "tests", "1 of 1", 3600, "2026-01-03", "abc")
        page = rota.with_row(page, "fuzz", "none found", 7260, "2026-01-01", "abc")
        return rota.with_row(page, "soak", "100 h", 60, "2026-01-02", "abc")

    def test_rows_are_replaced(self):
        page = rota.with_row(self.page(), "fuzz", "FAILED: one", 120, "2026-01-09", "def")
        self.assertEqual(page.count("| `fuzz` | FAILED: one | 2 min | 2026-01-09 | `def` |\n"), 1)
        self.assertEqual(page.count("`fuzz`"), 1)
        self.assertTrue(page.startswith("before\n") and page.endswith("\nafter\n"))

    def test_the_longest_ago_is_first(self):
        stages = ("tests", "fuzz", "soak", "mutants")
        self.assertEqual(rota.due(self.page(), 24, stages), ["mutants", "fuzz", "soak", "tests"])
        self.assertEqual(rota.due(self.page(), 2, stages), ["mutants", "soak"])
        self.assertEqual(rota.due(self.page(), 0.1, ("fuzz",)), ["fuzz"])

    def test_the_last_figure_counts(self):
        self.assertEqual(rota.figure_of("figure: a\nb\nfigure: 5 | 6\n100% tests passed\n"), "5 / 6")
        self.assertEqual(rota.figure_of("x\n100% tests passed, 0 tests failed out of 7\n"),
                         "100% tests passed, 0 tests failed out of 7")


if __name__ == "__main__":
    unittest.main()
