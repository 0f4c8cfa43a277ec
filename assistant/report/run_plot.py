"""A run over time, drawn: the tool, the axes, and the signals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from assistant.base.arrays import evenly_spaced
from assistant.report import figures
from assistant.robots import Robot

MOST_CURVE_POINTS: Final = 4000
"""Points of a curve that are drawn."""
SIGNAL_SPACING: Final = 1.5
"""Of the curves of signals, each between 0 and 1 of its largest value."""


def run_plot(
    columns: Mapping[str, np.ndarray], robot: Robot, title: str, format: str = "png"
) -> bytes:
    """Four diagrams over the time in seconds, as `png` or `svg`. columns: of the samples of a run:
    t, position, joints, speed, inputs and outputs with their names.
    """
    some = evenly_spaced(len(columns["t"]), MOST_CURVE_POINTS)
    t = columns["t"][some]
    figure = figures.new_figure(9.0, 10.0)
    place, speed, joints, signals = figure.subplots(4, 1, sharex=True)
    for axis, label in enumerate("xyz"):
        place.plot(t, columns["position"][some, axis], label=label)
    speed.plot(t, columns["speed"][some], label="TCP")
    low, high = robot.limits.T
    for axis, label in enumerate(robot.axes):
        part = (columns["joints"][some, axis] - low[axis]) / (high[axis] - low[axis])
        joints.plot(t, 100.0 * part, label=label)
    for limit in (0.0, 100.0):
        joints.axhline(limit, color="red", linestyle="--", linewidth=1.0)
    joints.set_ylim(-5.0, 105.0)
    names: list[str] = []
    for kind in ("input", "output"):
        for column, name in enumerate(columns[f"{kind}_names"].tolist()):
            values = columns[f"{kind}s"][:, column]
            most = float(np.abs(values).max(initial=0.0)) or 1.0
            level = SIGNAL_SPACING * len(names)
            signals.step(columns["t"], values / most + level, where="post", linewidth=1.0)
            names.append(f"{kind} {name}")
    signals.set_yticks([SIGNAL_SPACING * level for level in range(len(names))], names, fontsize=7)
    place.set(title=title, ylabel="position in mm")
    speed.set(ylabel="speed of the tool in mm/s")
    joints.set(ylabel="joints, % of their range")
    signals.set(xlabel="seconds")
    for axes in (place, speed, joints, signals):
        axes.grid(visible=True, alpha=0.3)
    for axes in (place, speed, joints):
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figures.picture(figure, format)
