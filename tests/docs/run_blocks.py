#!/usr/bin/env python3
"""Runs the shell blocks of README.md, CONTRIBUTING.md and docs/*.md as a reader would: those of a page one after the other, in a
folder in which the sources and the build stand as they do in a checkout.

usage: run_blocks.py SOURCE BUILD WORK

A block that is not run says why, in an HTML comment on the line before: <!-- not run: it takes an hour -->. A block that shows what
a program wrote says where, <!-- from: out/run/replay.yaml -->: its lines must stand in that file, in that order, comments and blanks
at their ends left aside; of a block <!-- said by: COMMAND --> in what that command prints. Any other language
than those known here is an error: a block is run (sh; python, by python/tests/test_docs.py), compiled (cpp, by
tests/consumer/docs.cmake), or data (yaml, json, cmake,
text). Exit 1: a block failed.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

FENCE = re.compile(r"(?:<!-- (?P<mark>(?:(?!-->).)*?) -->\n+)?^```(?P<language>[a-z]*)\n(?P<text>.*?)^```$", re.S | re.M)
DATA = {"cpp", "python", "yaml", "json", "cmake", ""}


def prepare(source, build, work):
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    for name in ("config", "data", "docs", "scripts", "examples"):
        (work / name).symlink_to(source / name)
    (work / "build").mkdir()
    (work / "build" / "release").symlink_to(build)


def bare_lines(text):
    """Lines without comments and without blanks around them; none that are empty."""
    stripped = (re.sub(r"(^|\s)#.*", "", line).strip() for line in text.splitlines())
    return [line for line in stripped if line]


def missing_line(block, shown):
    """The first line of the block that the text it shows does not have behind the one before; None where it has all."""
    there = iter(bare_lines(shown))
    return next((line for line in bare_lines(block) if line not in there), None)


def run_in(place, command):
    return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=place, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def what_is_shown(mark, place):
    """What a block says that it shows: of a file, or of a command; None where it says no such thing."""
    if mark.startswith("from: "):
        return (place / mark.removeprefix("from: ")).read_text(encoding="utf-8")
    if mark.startswith("said by: "):
        return run_in(place, mark.removeprefix("said by: ")).stdout
    return None


def main():
    source, build, work = (Path(a).resolve() for a in sys.argv[1:4])
    pages = [source / "README.md", source / "CONTRIBUTING.md", *sorted((source / "docs").glob("*.md"))]
    run = left = failed = compared = 0
    for page in pages:
        place, text = work / page.stem, page.read_text(encoding="utf-8")
        for block in FENCE.finditer(text):
            where = f"{page.relative_to(source)}:{text.count(chr(10), 0, block.start('language')) + 1}"
            if not block["language"] and re.search(r"^(build/release|scripts|pip|python3?) ?/?", block["text"], re.M):
                print(f"{where}: a command in a block without a language; right would be sh")
                failed += 1
            mark = block["mark"] or ""
            if mark.startswith(("from: ", "said by: ")) and not place.exists():
                prepare(source, build, place)
            shown = what_is_shown(mark, place)
            if shown is not None:
                compared += 1
                lost = missing_line(block["text"], shown)
                if lost is not None:
                    failed += 1
                    print(f"{where}: `{lost}` is not what is printed today:\n{shown}")
            if block["language"] in DATA:
                continue
            if block["language"] != "sh":
                print(f"{where}: a block of `{block['language']}`; right would be sh, cpp, yaml, json or cmake")
                failed += 1
                continue
            if mark.startswith("not run: "):
                left += 1
                continue
            if not place.exists():
                prepare(source, build, place)
            done = run_in(place, block["text"])
            run += 1
            print(f"{where}: {'run' if done.returncode == 0 else 'FAILED'}")
            if done.returncode != 0:
                failed += 1
                print(done.stdout)
    shutil.rmtree(work, ignore_errors=True)
    print(f"{run} blocks run, {left} said why they are not, {compared} compared with what is printed, {failed} failed")
    return 1 if failed or not run else 0


if __name__ == "__main__":
    sys.exit(main())
