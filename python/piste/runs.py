"""Replays: from logs to a trajectory with its errors."""

import json
import os
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _piste
from .configuration import configuration
from .errors import ConfigError
from .progress import Progress, told
from .tables import Table, column_of, rows_of

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

Path = str | os.PathLike[str]
Three = Sequence[float] | np.ndarray

OUTCOMES = np.array(["used", "rejected", "readmitted", "disputed", "repeated"])


class Solution:
    """The estimates of a filter or a smoother with their sigmas, a row for each epoch of the IMU.

    `solution["v_wb"]` is a column as the library stores it, without a copy. It is in SI and radians, with the frames
    and symbols of piste.h. `navigation` and `biases` are tables in the units of the files.
    """

    def __init__(self, solution: _piste.Solution, week: int | None):
        self._solution = solution
        self._stored = solution.stored()
        self.week = week

    def __len__(self) -> int:
        return len(self._solution)

    def __getitem__(self, name: str) -> np.ndarray:
        return column_of(self._stored, name)

    def __contains__(self, name: object) -> bool:
        return name in self._stored

    def __iter__(self) -> Iterator[str]:
        return iter(self._stored)

    def __repr__(self) -> str:
        span = f", {self.time[0]:.2f} to {self.time[-1]:.2f} s" if len(self) else ""
        return f"<piste.Solution of {len(self)} epochs{span}: {', '.join(self.names)}>"

    @property
    def names(self) -> list[str]:
        """The names of the stored columns."""
        return list(self._stored)

    @property
    def time(self) -> np.ndarray:
        """GPS seconds of week."""
        return self._stored["time"]

    @cached_property
    def navigation(self) -> Table:
        """Position, velocity, attitude and their sigmas: the columns of smoothed.csv."""
        return rows_of(*self._solution.navigation(), week=self.week)

    @cached_property
    def biases(self) -> Table:
        """All other estimates and their sigmas: the columns of biases.csv, at the rate of the IMU."""
        return rows_of(*self._solution.biases(), week=self.week)

    @cached_property
    def innovations(self) -> Table:
        """Every measurement against its prediction: the columns of innovations.csv, SI; NaN for its empty cells."""
        raw = self._solution.innovations()
        table: dict[str, np.ndarray] = {
            "time_s": raw["time_s"],
            "source": np.asarray(self._solution.sources)[raw["source"]],
        }
        rows = np.where(OUTCOMES[raw["outcome"]] == "repeated", 0, raw["dof"])
        for name in ("residual", "sigma"):
            table |= {f"{name}_{i + 1}": np.where(rows > i, raw[name][:, i], np.nan) for i in range(3)}
        table |= {"nis": raw["nis"], "gate": raw["gate"], "outcome": OUTCOMES[raw["outcome"]]}
        return Table(table, week=self.week)

    def to_pandas(self, week: int | None = None) -> "pandas.DataFrame":
        """`navigation` as a pandas.DataFrame, indexed by UTC if the GPS week is known, else by GPS seconds of week."""
        return self.navigation.to_pandas(week)


class Run:
    """A replay. `filtered` and `smoothed` are solutions; `summary` and `verdict` are those of summary.json."""

    def __init__(self, run: _piste.Run, week: int | None):
        self._run = run
        self.week = week

    @cached_property
    def filtered(self) -> Solution:
        return Solution(self._run.filtered, self.week)

    @cached_property
    def smoothed(self) -> Solution:
        """The smoothed solution. A ConfigError with `smoother: none`; see `has_smoothed`. `solution` always exists."""
        smoothed = self._run.smoothed
        if smoothed is None:
            raise ConfigError("the run was not smoothed (`smoother: none`); take `filtered`, or `solution`", "smoother")
        return Solution(smoothed, self.week)

    @property
    def has_smoothed(self) -> bool:
        """Whether the run was smoothed."""
        return self._run.smoothed is not None

    @property
    def solution(self) -> Solution:
        """The smoothed solution, or the filtered one if there is none."""
        return self.smoothed if self.has_smoothed else self.filtered

    @property
    def biases(self) -> Table:
        return self.solution.biases

    @property
    def innovations(self) -> Table:
        return self.filtered.innovations

    @cached_property
    def summary(self) -> dict[str, Any]:
        return json.loads(self._run.summary())

    @property
    def verdict(self) -> dict[str, Any]:
        return self.summary["verdict"]

    @property
    def how(self) -> str:
        """How the start was estimated."""
        return self._run.how

    @property
    def warnings(self) -> list[str]:
        return self._run.warnings()

    @cached_property
    def samples(self) -> Table:
        """The filter's IMU input: `time`, `interval`, `dtheta` and `dvel`, body axes, shared memory."""
        return Table(self._run.samples())

    def report(self) -> "Page":
        """The page report.html; a notebook shows it."""
        return Page(self._run.page())

    def write(self, folder: Path, progress: Progress | bool | None = None) -> None:
        """Writes the files of the program `replay`."""
        self._run.write(os.fspath(folder), told(progress))

    def plot(self, names: list[str] | None = None, sigmas: float = 1) -> "Figure":
        """Plots columns of `solution` with bands of some sigmas (matplotlib). Returns the figure."""
        from .plot import plot_run

        return plot_run(self, names, sigmas)

    def __repr__(self) -> str:
        return f"<piste.Run of {len(self.filtered)} epochs: {self._run.verdict_line}>"


class Page(str):
    """An HTML page without network, which a notebook shows."""

    def _repr_html_(self) -> str:
        import html

        return f'<iframe srcdoc="{html.escape(self)}" width="100%" height="700" style="border:0"></iframe>'


def replay(
    config: Path | None = None,
    /,
    *,
    judged: bool = True,
    progress: Progress | bool | None = None,
    **keys: Any,
) -> Run:
    """Computes trajectory and errors of the IMU from logs.

    `config`: a configuration file of the program `replay`; or none, and its keys as keywords. Instead of a file, a
    pandas.DataFrame or a mapping of arrays may be given, with columns named as those of csv logs (docs/formats.md):

        replay(imu=imu, gnss=gnss, sensor="xsens_mt9a", lever_arm="-0.06 0.03 -0.42 m", estimate=["gyro_bias"])

    With both, the keywords replace keys of the file. `judged`: whether to search the causes of inconsistent sigmas,
    which filters the run several times. `progress`: True draws a bar on standard error. A function is called some times
    a second with the stage and the part that is done. Raises ConfigError and DataError.
    """
    parsed, week = configuration(config, keys)
    return Run(_piste.replay(parsed, judged, told(progress)), week)


class Filter(_piste.Filter):
    """The navigation filter, sample by sample or in batches (C++: piste/filter/filter.h).

    `config` and `keys`: as of replay(); the logs named there are not read. The start: GPS seconds of week, degrees and
    metres (latitude, longitude, height), m/s (north, east, down), degrees (roll, pitch, heading), and their sigmas.
    """

    def __init__(
        self,
        config: Path | None = None,
        *,
        time: float,
        position: Three,
        velocity: Three,
        euler: Three,
        sigma_position: Three,
        sigma_velocity: Three,
        sigma_euler: Three,
        **keys: Any,
    ):
        parsed, _ = configuration(config, keys)
        start = (position, velocity, euler, sigma_position, sigma_velocity, sigma_euler)
        super().__init__(parsed, time, *(list(map(float, values)) for values in start))


class Live(_piste.Live):
    """Real-time navigation: raw rows and fixes in; standstill, start and filter inside (C++: piste/live/live.h).

    `config` and `keys`: as of replay(); the logs named there are not read.
    """

    def __init__(self, config: Path | None = None, **keys: Any):
        parsed, _ = configuration(config, keys)
        super().__init__(parsed)


def filter_of(run: Run) -> _piste.Filter:
    """A filter at the start of a run, with its options."""
    return _piste.Filter.of(run._run)
