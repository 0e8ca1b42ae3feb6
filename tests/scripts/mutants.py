#!/usr/bin/env python3
"""Tests of scripts/mutants: what it changes, and how it judges. usage: mutants.py SOURCE"""

import contextlib
import importlib.machinery
import importlib.util
import io
import sys
import tempfile
import types
import unittest
import unittest.mock
from pathlib import Path

SOURCE = Path(sys.argv.pop(1)).resolve()
loader = importlib.machinery.SourceFileLoader("mutants", str(SOURCE / "scripts" / "mutants"))
spec = importlib.util.spec_from_loader("mutants", loader)
mutants = sys.modules["mutants"] = importlib.util.module_from_spec(spec)
loader.exec_module(mutants)


def changes(line):
    return [(m.old, m.new) for m in mutants.mutants_of_line("src/math/a.cpp", 1, line, 0)]


class Changes(unittest.TestCase):
    def test_operators_and_constants(self):
        self.assertEqual(changes("  if (a < b && c == 2.5) return x * 1;"),
                         [("<", "<="), ("&&", "||"), ("==", "!="), ("*", "/"), ("2.5", "3.75"), ("1", "0")])
        self.assertEqual(changes("  if (a < b && c > d) return;"), [("<", "<="), ("&&", "||"), (">", ">=")])
        self.assertEqual(changes("  y = std::max(x, 0.0);"), [("std::max", "std::min"), ("0.0", "1.0")])

    def test_a_line_is_changed_in_one_place(self):
        first, *_ = mutants.mutants_of_line("src/math/a.cpp", 1, "  y = a + b + c;", 0)
        self.assertEqual(first.changed(), "  y = a - b + c;")

    def test_other_than_code_is_left_alone(self):
        for line in ("// a < b", "#include <vector>", '  const char* text = "a < 1";', "  Matrix<double, 3, 3> A;",
                     "  const Vector3d& x = y;", '  throw DataError(file, "1 < 2");', "  double* p;", "  x_1 = kValue2;"):
            self.assertEqual(changes(line), [], line)

    def test_every_number_changes(self):
        for text in ("0", "1", "0.0", "1.0", "10", "0.5", "1e-9", "1e3"):
            self.assertNotEqual(float(mutants.other_number(text)), float(text))

    def test_equal_lines_are_told_apart(self):
        keys = [m.key() for nth in (0, 1) for m in mutants.mutants_of_line("src/math/a.cpp", 1 + nth, "  i += 2;", nth)]
        self.assertEqual(len(set(keys)), 4)


class Judgement(unittest.TestCase):
    def setUp(self):
        self.drawn = list(mutants.mutants_of_line("src/math/a.cpp", 7, "  y = a + b + c + d + e + f + g + h + i + j + k;", 0))

    def good(self, survived, floor=0.9):
        results = {m.key(): "survived" if i < survived else "killed" for i, m in enumerate(self.drawn)}
        return mutants.report(self.drawn, results, floor)

    def test_nine_in_ten_are_to_be_killed(self):
        self.assertEqual(len(self.drawn), 10)
        self.assertTrue(self.good(0))
        self.assertTrue(self.good(1))
        self.assertFalse(self.good(2))

    def test_what_does_not_compile_does_not_count(self):
        self.assertTrue(mutants.report(self.drawn, {m.key(): "invalid" for m in self.drawn}, 0.9))


class Run(unittest.TestCase):
    """With a build and tests that are played: they notice a changed `*`, and not a changed `+`."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        top = Path(self.folder.name)
        self.source = top / "src" / "math" / "a.cpp"
        self.source.parent.mkdir(parents=True)
        self.text = "  y = a + b;\n  z = a * b;\n"
        self.source.write_text(self.text)
        self.built = []
        played = {"ROOT": top, "COPY": top, "RESULTS": top / "out" / "mutants.jsonl", "EXPLAINED": top / "mutants.txt",
                  "checkout": lambda preset: None, "build": self.build, "tests_pass": self.passes}
        for name, value in played.items():
            patch = unittest.mock.patch.object(mutants, name, value)
            patch.start()
            self.addCleanup(patch.stop)
        self.drawn = mutants.mutants_of("math")

    def build(self, room, preset):
        self.built.append(self.source.read_text())
        return True

    def passes(self, room, preset):
        return "a * b" in self.source.read_text()

    def try_all(self, minutes=1.0):
        results = mutants.known_results()
        mutants.try_all(self.drawn, results, types.SimpleNamespace(minutes=minutes, preset="release"))
        return results

    def test_finds_the_survivor_and_leaves_the_code_as_it_was(self):
        results = self.try_all()
        self.assertEqual([results[m.key()] for m in self.drawn], ["survived", "killed"])
        self.assertEqual(self.source.read_text(), self.text)
        self.assertFalse(mutants.report(self.drawn, results, 0.9))

    def test_goes_on_where_it_was(self):
        self.try_all(minutes=0)
        self.assertEqual(self.built, [])
        self.try_all()
        self.assertEqual(len(self.built), 3)  # as it is, and each mutant
        self.try_all()
        self.assertEqual(len(self.built), 3)

    def test_a_survivor_may_be_explained(self):
        mutants.EXPLAINED.write_text("# none\nsrc/math/a.cpp | y = a + b; | + -> - | nobody reads y\n")
        results = self.try_all()
        with contextlib.redirect_stdout(io.StringIO()) as said:
            mutants.report(self.drawn, results, 0.9)
        self.assertIn("1 killed, 0 survived, 1 explained", said.getvalue())
        mutants.EXPLAINED.write_text("src/math/a.cpp | y = a + b;\n")
        with self.assertRaises(SystemExit):
            mutants.explanations()

    def test_tests_that_fail_anyway_kill_nobody(self):
        self.source.write_text("  y = a + b;\n")
        with self.assertRaises(SystemExit):
            self.try_all()


if __name__ == "__main__":
    unittest.main()
