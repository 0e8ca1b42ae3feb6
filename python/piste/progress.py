"""Progress of work: a function of the caller, or a bar."""

import sys
import time
from collections.abc import Callable
from typing import TextIO

Progress = Callable[[str, float], object]
"""Called some times a second with the stage and the part of it that is done, 0 to 1. Of inspect() it gets the part of the
whole work, which does not go back from stage to stage. An exception that it raises ends the work."""


class Bar:
    """A bar with the time left, on standard error."""

    WIDTH = 30

    def __init__(self, out: TextIO | None = None):
        self._out = out or sys.stderr
        self._stage = ""
        self._part = self._started = 0.0

    def __call__(self, stage: str, part: float) -> None:
        now = time.monotonic()
        if not self._stage or part < self._part:  # else another stage of the same work
            if self._stage:
                self._out.write("\n")
            self._started = now
        self._stage, self._part = stage, part
        left = (now - self._started) * (1 / part - 1) if part > 0 else 0
        filled = round(self.WIDTH * part)
        self._out.write(f"\r{stage:<19} [{'=' * filled:<{self.WIDTH}}] {part:4.0%}  {left:.0f} s left ")
        self._out.flush()

    def __del__(self) -> None:
        if self._stage:
            self._out.write("\n")


def told(progress: Progress | bool | None) -> Progress | None:
    """The callback for the bindings: a bar for True, nothing for False and None."""
    return Bar() if progress is True else progress or None
