"""Tables of numbers: numpy arrays by the names of their columns."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _piste
from .errors import DataError

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
        return column_of(self._columns, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """The number of columns; `rows` is the number of rows."""
        return len(self._columns)

    @property
    def rows(self) -> int:
        return len(next(iter(self._columns.values()), ()))

    def __repr__(self) -> str:
        kind = f" {self.kind}" if self.kind else ""
        return f"<piste.Table{kind} of {self.rows} rows: {', '.join(self)}>"

    def to_pandas(self, week: int | None = None) -> "pandas.DataFrame":
        """A pandas.DataFrame, whose index is time: UTC if the GPS `week` is known, else GPS seconds of the week."""
        import pandas

        frame = pandas.DataFrame(self._columns)
        week = self.week if week is None else week
        if "time_s" in frame:
            if week is None:
                frame.index = pandas.Index(frame["time_s"].to_numpy(), name="gps_time")
            else:
                frame.index = pandas.DatetimeIndex(utc(self["time_s"], week), tz="UTC", name="time")
        return frame


def column_of(columns: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """A column, or a KeyError that lists the existing columns."""
    try:
        return columns[name]
    except KeyError:
        raise KeyError(f"there is no column `{name}`; there are {', '.join(columns)}") from None


def rows_of(names: list[str], rows: np.ndarray, week: int | None = None) -> Table:
    """A table whose columns are views of `rows`."""
    return Table({name: rows[:, i] for i, name in enumerate(names)}, week=week)


def gps_seconds(times: Any) -> tuple[int, np.ndarray]:
    """GPS week of the first of some UTC times (numpy.datetime64, or convertible to it), and seconds of that week."""
    stamps = np.asarray(times, dtype="datetime64[ns]").astype(np.int64)
    first = int(stamps[0]) if len(stamps) else GPS_EPOCH * 10**9
    week, seconds = _piste.gps_time(first // 10**9)
    return week, seconds + (stamps - first // 10**9 * 10**9) * 1e-9


def utc(seconds: np.ndarray, week: int) -> np.ndarray:
    """UTC as numpy.datetime64[ns], from seconds of a GPS week."""
    start = GPS_EPOCH + week * WEEK
    of_week, first = _piste.gps_time(start)
    leap = round(of_week * WEEK + first - week * WEEK)
    nanoseconds = np.round(np.asarray(seconds) * 1e9).astype(np.int64)
    return (nanoseconds + (start - leap) * 10**9).astype("datetime64[ns]")


def is_table(value: Any) -> bool:
    """Whether a value holds rows: a table, a pandas.DataFrame, a mapping of arrays, or a structured array."""
    if hasattr(value, "columns") and hasattr(value, "index"):
        return True
    if isinstance(value, np.ndarray):
        return value.dtype.names is not None
    if isinstance(value, Mapping) and "file" not in value:
        return "time_s" in value or any(isinstance(column, np.ndarray) for column in value.values())
    return isinstance(value, Table)


def numbers_of(table: str, name: str, values: Any) -> np.ndarray:
    """A column as float64, without a copy if it is float64 already."""
    if isinstance(values, np.ma.MaskedArray) and np.issubdtype(values.dtype, np.floating):
        values = values.filled(np.nan)  # masked values are missing
    column = np.asarray(values)
    if column.ndim != 1:
        raise DataError(
            f"{table}: column `{name}` has {column.ndim} dimensions; one is expected, of a name of its own", table
        )
    if column.dtype.kind in "mM":
        raise DataError(
            f"{table}: column `{name}` holds dates; make them the index (set_index), or seconds of the GPS week", table
        )
    if column.dtype.kind == "c":
        raise DataError(f"{table}: column `{name}` holds complex numbers; real ones are expected", table)
    if name == "time_s" and column.dtype == np.float32:
        raise DataError(f"{table}: `time_s` is float32, which tells times of a week to 0.03 s; make it float64", table)
    try:
        return np.asarray(column, dtype=np.float64)
    except (TypeError, ValueError):
        raise DataError(
            f"{table}: column `{name}` holds other things than numbers; convert it, or drop it", table
        ) from None


def csv_of(columns: Mapping[str, np.ndarray], table: str) -> str:
    """Columns as the text of a csv, with all their digits."""
    if len({len(column) for column in columns.values()}) > 1:
        raise DataError(f"{table}: the columns are of different lengths", table)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return "\n".join((",".join(columns), *(",".join(map(repr, row)) for row in rows), ""))


def columns_of(value: Any, table: str) -> tuple[dict[str, np.ndarray], int | None]:
    """The columns of a table as arrays, without a copy if they are float64, and its GPS week if it is known."""
    week = getattr(value, "week", None)
    if isinstance(value, np.ndarray):
        names: list[Any] = list(value.dtype.names or ())
    else:
        names = list(value.columns) if hasattr(value, "columns") else list(value)
    columns = {str(name): numbers_of(table, str(name), value[name]) for name in names}
    index = getattr(value, "index", None)
    if index is not None and "time_s" not in columns and str(getattr(index, "dtype", "")).startswith("datetime64"):
        stamps = index.tz_convert("UTC").tz_localize(None) if getattr(index, "tz", None) else index
        missing = np.flatnonzero(np.isnat(stamps.to_numpy()))
        if len(missing):
            raise DataError(f"{table}: row {missing[0]}: the index has no time there", f"{table}: row {missing[0]}")
        week, columns["time_s"] = gps_seconds(stamps.to_numpy())
    return columns, week if isinstance(week, int) else None
