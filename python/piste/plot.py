"""Plots with bands of sigmas."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .runs import Run

PANELS = ["height_m", "velocity_north_m_s", "velocity_east_m_s", "roll_deg", "pitch_deg", "heading_deg"]
SIGMAS = {"latitude_deg": None, "longitude_deg": None, "height_m": "sigma_down_m"}


def plot_run(run: "Run", names: list[str] | None = None, sigmas: float = 1) -> "Figure":
    """The plan view of a run, and columns of its navigation or biases over time with bands of some sigmas."""
    import matplotlib.pyplot as plt

    navigation = run.solution.navigation
    names = PANELS if names is None else names
    figure = plt.figure(figsize=(11, 2.0 + 1.3 * len(names)), layout="constrained")
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
        value = table[name]
        sigma = table.get(SIGMAS.get(name, f"sigma_{name}"))
        axes.plot(time, value, linewidth=0.8)
        if sigma is not None:
            axes.fill_between(time, value - sigmas * sigma, value + sigmas * sigma, alpha=0.3, linewidth=0)
        axes.set_ylabel(name, rotation=0, ha="right", fontsize=8)
        axes.tick_params(labelbottom=i + 1 == len(names))
    if first is not None:
        figure.axes[-1].set_xlabel("s after the first epoch")
    return figure
