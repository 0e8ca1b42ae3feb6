"""The other programs of piste as functions. `output`: a folder for the output files of the program."""

import io
import json
import operator
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import _piste
from .configuration import configuration
from .errors import ConfigError
from .progress import Progress, told
from .runs import Page, Path
from .tables import WEEK, Table, columns_of, csv_of, is_table


def _folder(output: Path | None) -> str | None:
    return None if output is None else os.fspath(output)


def _files(files: Sequence[Path]) -> list[str]:
    if not files:
        raise ConfigError("no log is named", "files")
    for file in files:
        if not isinstance(file, str | os.PathLike):
            raise ConfigError(f"the path of a log is expected, not a {type(file).__name__}", "files")
        if not os.path.exists(file):
            raise ConfigError(f"{os.fspath(file)}: there is no such file", os.fspath(file))
    return [os.fspath(file) for file in files]


def whole(name: str, value: Any, least: int) -> int:
    """A whole number, or a ConfigError that states what is expected."""
    try:
        number = operator.index(value)
    except TypeError:
        raise ConfigError(f"{name}: {value!r} is no whole number", name) from None
    if number < least:
        raise ConfigError(f"{name}: {number} is too few; at least {least} is expected", name)
    return number


def read(*files: Path) -> Table:
    """Reads a log of any format that piste knows; the format is guessed. Two files: gyroscopes and accelerometers.

    The columns are named as those of csv, so that replay() accepts the table instead of a file. `kind` is imu, gnss or
    attitude.
    """
    kind, columns = _piste.read(_files(files))
    return Table(columns, kind)


class Inspection:
    """The contents of logs, and their faults."""

    def __init__(self, inspected: _piste.Inspected):
        self._inspected = inspected

    def __str__(self) -> str:
        return self._inspected.text()

    def __repr__(self) -> str:
        """The worst fault; print() shows all."""
        found = self.suspicions
        return f"<piste.Inspection: {len(found)} things look wrong{f', the worst: {found[0]}' if found else ''}>"

    @property
    def suspicions(self) -> list[str]:
        """The faults, the worst first."""
        return self._inspected.suspicions()

    def report(self) -> Page:
        return Page(self._inspected.page())

    def write(self, folder: Path) -> None:
        """Writes inspection.txt and .html, and if the logs suffice replay.yaml and sensor.yaml, for replay().

        Logs that were tables are written as csv, too.
        """
        self._inspected.write(os.fspath(folder))


def _sources(logs: Sequence[Any]) -> tuple[list[str], list[str | None]]:
    """The names of logs, and for tables the content of their csv."""
    if not logs:
        raise ConfigError("no log is named", "files")
    names: list[str] = []
    contents: list[str | None] = []
    first = None
    for i, log in enumerate(logs):
        if not is_table(log):
            names += _files([log])
            contents.append(None)
            continue
        names.append(f"table_{i + 1}.csv")
        columns, week = columns_of(log, names[-1])
        first = week if first is None else first
        if week is not None and first is not None and "time_s" in columns:  # all times count from the week of the first
            columns["time_s"] = columns["time_s"] + (week - first) * WEEK
        contents.append(csv_of(columns, names[-1]))
    return names, contents


def inspect(*logs: Path | Any, output: Path | None = None, progress: Progress | bool | None = None) -> Inspection:
    """Inspects logs before anything else runs: files, or tables such as a pandas.DataFrame, as replay() accepts them.

    Tables are called table_1.csv and so on, by their positions; `output` and write() write them next to the
    configuration.
    """
    inspection = Inspection(_piste.inspect(*_sources(logs), told(progress)))
    if output is not None:
        inspection.write(output)
    return inspection


def align(
    config: Path | None = None, /, *, output: Path | None = None, progress: Progress | bool | None = None, **keys: Any
) -> dict[str, dict[str, Any]]:
    """Clock, boresight and lever arm between two IMUs on one plate: alignment.json of each IMU by its name."""
    parsed, _ = configuration(config, keys)
    return {name: json.loads(found) for name, found, _ in _piste.align(parsed, False, _folder(output), told(progress))}


def compare(
    config: Path | None = None, /, *, output: Path | None = None, progress: Progress | bool | None = None, **keys: Any
) -> dict[str, dict[str, Any]]:
    """Biases and scales of IMUs, by comparison with a better one: `alignment` and `findings` of each by its name."""
    parsed, _ = configuration(config, keys)
    return {
        name: {"alignment": json.loads(alignment), "findings": json.loads(findings)}
        for name, alignment, findings in _piste.align(parsed, True, _folder(output), told(progress))
    }


def evaluate(
    estimate: Path,
    reference: Path,
    /,
    *,
    align: str = "none",
    rpe: Sequence[str] = ("100m", "1s"),
    at: str = "",
    time_offset: float | str = 0,
    output: Path | None = None,
) -> dict[str, Any]:
    """How far a trajectory is from a reference: evaluation.json, and `text` and `report`.

    Both are files of any format that the program `evaluate` reads, or folders of replays. `align` is none, position,
    yaw, se3 or sim3; `rpe` has the steps of the relative error; `at` takes the estimate at this point of its
    `output: {at}`; `time_offset` is added to its times [s], "auto" estimates it.
    """
    found = dict(
        _piste.evaluate(
            os.fspath(estimate), os.fspath(reference), align, list(rpe), at, str(time_offset), _folder(output)
        )
    )
    return {**json.loads(found["json"]), "text": found["text"], "report": Page(found["page"])}


def export(folder: Path, to: str, /, *, week: int | None = None, output: Path | None = None) -> str:
    """Writes the trajectory of a replay's folder for other programs, and returns the path of the file.

    `to`: gpx, geojson, nmea, tum, kitti, euroc, sbet, rtklib, numpy; and from Python alone parquet (by pandas and
    pyarrow) and rosbag (a ROS 2 bag, by rosbags). `week`: the GPS week, if the logs do not state it.
    """
    place = os.fspath(folder)
    if to in ("parquet", "rosbag"):
        from . import exports

        file = os.path.join(place, "trajectory" + exports.ENDINGS[to]) if output is None else os.fspath(output)
        exports.WRITERS[to](place, file, week)
        return file
    file = os.path.join(place, "trajectory" + _piste.export_extension(to)) if output is None else os.fspath(output)
    _piste.export(place, to, week, file)
    return file


def descents(
    *runs: Path,
    gates: Path | None = None,
    line: str = "",
    common: float = 0,
    at: str = "",
    output: Path | None = None,
    **named: Path,
) -> dict[str, Any]:
    """Runs of one course compared: descents.json, and `sections`, `gained` (both csv), `text` and `report`.

    Runs are configurations, which are replayed, or folders of replays; `descents(gates=…, anna="a.yaml", ben="b.yaml")`
    names them. `common`: 1-sigma along the line that all runs share [m].
    """
    all_runs = [("", os.fspath(run)) for run in runs] + [(name, os.fspath(run)) for name, run in named.items()]
    found = dict(
        _piste.descents(all_runs, "" if gates is None else os.fspath(gates), line, common, at, _folder(output))
    )
    report = {"sections": found["sections"], "gained": found["gained"], "text": found["text"]}
    return {**json.loads(found["json"]), **report, "report": Page(found["page"])}


class Simulation:
    """Simulated logs with their truth. `imus`, `gnss` and `attitude` are tables by the names of their files."""

    def __init__(self, simulated: _piste.Simulated):
        self._simulated = simulated
        self.seed: int = simulated.seed
        self.imus = {name: Table(columns, "imu") for name, columns in simulated.imus().items()}
        self.gnss = {name: Table(columns, "gnss") for name, columns in simulated.gnss().items()}
        self.attitude = {name: Table(columns, "attitude") for name, columns in simulated.attitude().items()}

    def __repr__(self) -> str:
        return f"<piste.Simulation with seed {self.seed}: {', '.join((*self.imus, *self.gnss, *self.attitude))}>"

    def truth(self, imu: int = 0) -> Table:
        """truth.csv of the IMU with that number."""
        if whole("imu", imu, 0) >= len(self.imus):
            raise ConfigError(f"imu: there is no IMU {imu}; there are {len(self.imus)}, the first of which is 0", "imu")
        text = self._simulated.truth(imu)
        names = text.split("\n", 1)[0].split(",")
        rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)
        return Table(dict(zip(names, rows.T, strict=True)), "truth")

    @property
    def errors(self) -> dict[str, Any]:
        """truth.json: every error that was added."""
        return json.loads(self._simulated.errors())

    def write(self, folder: Path) -> None:
        self._simulated.write(os.fspath(folder))


def simulate(
    scenario: Path | None = None,
    /,
    *,
    seed: int | None = None,
    output: Path | None = None,
    progress: Progress | bool | None = None,
    **keys: Any,
) -> Simulation:
    """Simulates all sensors of a scenario. The same seed gives the same numbers to the last bit."""
    if seed is not None:
        seed = whole("seed", seed, 0)
    parsed, _ = configuration(scenario, keys)
    simulation = Simulation(_piste.simulate(parsed, seed, told(progress)))
    if output is not None:
        simulation.write(output)
    return simulation


def tune(
    config: Path | None = None,
    /,
    *,
    jobs: int = _piste.cores,
    hold_out: float = 0,
    output: Path | None = None,
    progress: Progress | bool | None = None,
    **keys: Any,
) -> dict[str, Any]:
    """The maximum-likelihood noise, from the innovations of a replay: tune.json, and `text` and `report`, its page.

    Of each two stretches of `hold_out` seconds the second is held out from the fit, and `nis` is computed there; 0:
    none is.

    `output` needs a configuration file, which is the base of the replay.yaml there.
    """
    if keys and output is not None:
        raise ConfigError("the replay.yaml in `output` builds on a file; leave the keywords out, or `output`", "output")
    parsed, _ = configuration(config, keys)
    found = dict(_piste.tune(parsed, whole("jobs", jobs, 1), hold_out, _folder(output), told(progress)))
    return {**json.loads(found["json"]), "text": found["text"], "report": Page(found["page"])}


def study(
    config: Path, /, *, jobs: int = _piste.cores, output: Path | None = None, progress: Progress | bool | None = None
) -> dict[str, Any]:
    """A campaign of IMUs with a reference: summary.json, and `report`, its page."""
    parsed, _ = configuration(config, {})
    found, page = _piste.study(parsed, whole("jobs", jobs, 1), _folder(output), told(progress))
    return {**json.loads(found), "report": Page(page)}


def allan(
    *logs: Path,
    robust: bool = False,
    at_rest: bool = False,
    jobs: int = _piste.cores,
    output: Path | None = None,
    progress: Progress | bool | None = None,
) -> dict[str, Any]:
    """The noise of an IMU from logs at rest: allan.json, and `text`, `sensor` (a sensor file) and `report`."""
    found = dict(_piste.allan(_files(logs), robust, at_rest, whole("jobs", jobs, 1), _folder(output), told(progress)))
    return {
        **json.loads(found["json"]),
        "text": found["text"],
        "sensor": found["sensor"],
        "report": Page(found["page"]),
    }


def montecarlo(
    scenario: Path,
    /,
    runs: int = 100,
    *,
    jobs: int = _piste.cores,
    output: Path | None = None,
    progress: Progress | bool | None = None,
) -> dict[str, Any]:
    """Simulates and replays a scenario many times: consistency.json. On several machines: piste.distributed."""
    runs, jobs = whole("runs", runs, 1), whole("jobs", jobs, 1)
    parsed, _ = configuration(scenario, {})
    ensemble = _piste.Ensemble.begin(parsed)
    ensemble.run(runs, jobs, told(progress))
    return finished(ensemble, scenario, output)


def finished(ensemble: _piste.Ensemble, scenario: Path, output: Path | None) -> dict[str, Any]:
    """consistency.json of an ensemble, which is written into `output`."""
    title = os.path.splitext(os.path.basename(os.fspath(scenario)))[0]
    if output is not None:
        ensemble.write(_piste.Configuration.load(os.fspath(scenario)), os.fspath(output), title)
    return json.loads(ensemble.report(title))
