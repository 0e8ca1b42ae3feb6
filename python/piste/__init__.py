"""piste: from the raw logs of a body-worn IMU and a GNSS receiver to a trajectory, the IMU's errors, and their sigmas.

    import piste

    run = piste.replay("run.yaml")            # or piste.replay(imu=frame, gnss=frame, sensor="xsens_mt9a", …)
    run.smoothed.to_pandas()                  # the columns of smoothed.csv
    run.verdict                               # whether the sigmas hold
    run.report()                              # the page, in a notebook

docs/python.md is the manual.
"""

import os as _os

_os.environ.setdefault("PISTE_SHARE", _os.path.join(_os.path.dirname(__file__), "share"))

from . import _piste
from .errors import ConfigError, DataError, Error
from .programs import (
    Inspection,
    Simulation,
    align,
    allan,
    compare,
    descents,
    evaluate,
    export,
    inspect,
    montecarlo,
    read,
    simulate,
    study,
    tune,
)
from .runs import Filter, Live, Page, Run, Solution, filter_of, replay
from .tables import Table

__version__ = _piste.version
share = _os.environ["PISTE_SHARE"]
"""The folder with `sensors/`, `scenarios/` and `articles/`."""

__all__ = [
    "ConfigError", "DataError", "Error", "Filter", "Inspection", "Live", "Page", "Run", "Simulation", "Solution", "Table",
    "align", "allan", "compare", "descents", "evaluate", "export", "filter_of", "inspect", "montecarlo", "read", "replay", "share", "simulate", "study", "tune",
]  # fmt: skip
