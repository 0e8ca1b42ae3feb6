"""Runs the Python of the manual."""

import contextlib
import io
import re

import pytest
from conftest import SOURCE

pytest.importorskip("distributed")


def test_blocks_of_the_page(monkeypatch, tmp_path):
    for name in ("config", "data"):
        (tmp_path / name).symlink_to(SOURCE / name)
    monkeypatch.chdir(tmp_path)
    others = sorted(page for page in (SOURCE / "docs").glob("*.md") if page.name != "python.md")
    pages = "".join(page.read_text() for page in (SOURCE / "README.md", SOURCE / "docs/python.md", *others))
    blocks = re.findall(r"```python\n(.*?)```", pages, re.DOTALL)
    assert len(blocks) >= 8
    names = {"__name__": "__main__"}
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        for block in blocks:
            exec(compile(block, "docs/python.md", "exec"), names)
    assert "perhaps `smoother`" in said.getvalue()
    assert (tmp_path / "out/campaign/consistency.json").exists()
