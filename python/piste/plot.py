"""Plots with bands of sigmas."""

from typing import TYPE_CHECKING

import numpy as np

from .errors import ConfigError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .runs import Run

PANELS = ["height_m", "velocity_north_m_s", "velocity_east_m_s", "roll_deg", "pitch_deg", "heading_deg"]
UNITS = {
    "_m_s2": "m/s²",
    "_deg_s": "deg/s",
    "_m_s": "m/s",
    "_ppm": "ppm",
    "_deg": "deg",
    "_uT": "µT",
    "_m": "m",
    "_s": "s",
}
SIGMAS = {"latitude_deg": None, "longitude_deg": None, "height_m": "sigma_down_m"}


def label(name: str) -> str:
    """The readable name of a column: `velocity_north_m_s` is velocity north [m/s]."""
    for suffix, unit in UNITS.items():
        if name.endswith(suffix):
            return f"{name.removesuffix(suffix).replace('_', ' ')} [{unit}]"
    return name.replace("_", " ")


def without_wraps(name: str, value: np.ndarray) -> np.ndarray:
    """An angle with breaks instead of lines from +180° to −180°."""
    if not name.endswith("_deg"):
        return value
    wraps = np.flatnonzero(np.abs(np.diff(value)) > 180)
    broken = np.array(value)
    broken[wraps] = np.nan
    return broken


def plot_run(run: "Run", names: list[str] | None = None, sigmas: float = 1) -> "Figure":
    """The plan view of a run, and columns of its navigation or biases over time with bands of some sigmas."""
    import matplotlib.pyplot as plt

    navigation = run.solution.navigation
    names = PANELS if names is None else names
    figure = plt.figure(figsize=(11, 2.0 + 1.3 * len(names)), layout="constrained")
    figure.suptitle(f"bands: ± {sigmas:g} sigma", x=1, ha="right", fontsize=8)
    grid = figure.add_gridspec(len(names), 2, width_ratios=[1, 2])
    plan = figure.add_subplot(grid[:, 0])
    latitude, longitude = navigation["latitude_deg"], navigation["longitude_deg"]
    plan.plot(longitude, latitude, linewidth=1)
    plan.set(xlabel="longitude [deg]", ylabel="latitude [deg]", aspect=1 / np.cos(np.radians(latitude[0])))
    plan.ticklabel_format(useOffset=False)
    plan.tick_params(axis="x", rotation=30)
    time = navigation["time_s"] - navigation["time_s"][0]
    first = None
    for i, name in enumerate(names):
        axes = figure.add_subplot(grid[i, 1], sharex=first)
        first = first or axes
        table = navigation if name in navigation else run.biases
        if name not in table:
            known = ", ".join(n for n in (*navigation, *run.biases) if n != "time_s" and not n.startswith("sigma_"))
            raise ConfigError(f"there is no column `{name}`; there are {known}", "names")
        value = without_wraps(name, table[name])
        of_name = SIGMAS.get(name, f"sigma_{name}")
        sigma = None if of_name is None else table.get(of_name)
        axes.plot(time, value, linewidth=0.8)
        if sigma is not None:
            axes.fill_between(time, value - sigmas * sigma, value + sigmas * sigma, alpha=0.3, linewidth=0)
        axes.set_ylabel(label(name), rotation=0, ha="right", va="center", fontsize=8)
        axes.tick_params(labelbottom=i + 1 == len(names))
    if first is not None:
        figure.axes[-1].set_xlabel("s after the first epoch")
    return figure
