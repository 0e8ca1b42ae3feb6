"""Tables of numbers: numpy arrays by the names of their columns."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _piste

if TYPE_CHECKING:
    import pandas

GPS_EPOCH = 315964800  # 1980-01-06 in seconds since 1970
WEEK = 604800  # s


class Table(Mapping[str, np.ndarray]):
    """Columns of numbers by name. The names carry the units, as in the files of piste: `gyro_x_rad_s`."""

    def __init__(self, columns: Mapping[str, np.ndarray], kind: str = "", week: int | None = None):
        self._columns = dict(columns)
        self.kind = kind
        self.week = week

    def __getitem__(self, name: str) -> np.ndarray:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """The number of columns; `rows` is that of rows."""
        return len(self._columns)

    @property
    def rows(self) -> int:
        return len(next(iter(self._columns.values()), ()))

    def __repr__(self) -> str:
        return f"<piste.Table {self.kind} of {self.rows} rows: {', '.join(self)}>"

    def to_pandas(self, week: int | None = None) -> "pandas.DataFrame":
        """A pandas.DataFrame, whose index is time: UTC where the GPS `week` is known, else GPS seconds of the week."""
        import pandas

        frame = pandas.DataFrame(self._columns)
        week = self.week if week is None else week
        if "time_s" in frame and week is None:
            frame.index = pandas.Index(frame["time_s"].to_numpy(), name="gps_time")
        elif "time_s" in frame:
            frame.index = pandas.DatetimeIndex(utc(self["time_s"], week), tz="UTC", name="time")
        return frame


def rows_of(names: list[str], rows: np.ndarray, week: int | None = None) -> Table:
    """A table whose columns are views of `rows`."""
    return Table({name: rows[:, i] for i, name in enumerate(names)}, week=week)


def gps_seconds(times: Any) -> tuple[int, np.ndarray]:
    """GPS week of the first of some UTC times (numpy.datetime64, or what becomes it), and seconds of that week."""
    stamps = np.asarray(times, dtype="datetime64[ns]").astype(np.int64)
    first = int(stamps[0])
    week, seconds = _piste.gps_time(first // 10**9)
    return week, seconds + (stamps - first // 10**9 * 10**9) * 1e-9


def utc(seconds: np.ndarray, week: int) -> np.ndarray:
    """UTC as numpy.datetime64[ns], of seconds of a GPS week."""
    start = GPS_EPOCH + week * WEEK
    of_week, first = _piste.gps_time(start)
    leap = round(of_week * WEEK + first - week * WEEK)
    nanoseconds = np.round(np.asarray(seconds) * 1e9).astype(np.int64)
    return (nanoseconds + (start - leap) * 10**9).astype("datetime64[ns]")


def is_table(value: Any) -> bool:
    """Whether a value holds rows: a table, a pandas.DataFrame, or a mapping with a column of times."""
    if hasattr(value, "columns") and hasattr(value, "index"):
        return True
    return isinstance(value, Table) or (isinstance(value, Mapping) and "time_s" in value)


def columns_of(value: Any) -> tuple[dict[str, np.ndarray], int | None]:
    """The columns of a table as arrays, without a copy where they are float64, and its GPS week if it is known."""
    week = getattr(value, "week", None)
    names = list(value.columns) if hasattr(value, "columns") else list(value)
    columns = {str(name): np.asarray(value[name], dtype=np.float64) for name in names}
    index = getattr(value, "index", None)
    if "time_s" not in columns and str(getattr(index, "dtype", "")).startswith("datetime64"):
        stamps = index.tz_convert("UTC").tz_localize(None) if getattr(index, "tz", None) else index
        week, columns["time_s"] = gps_seconds(stamps.to_numpy())
    return columns, week if isinstance(week, int) else None
