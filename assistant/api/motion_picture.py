"""A simulation as a picture of a notebook: joints and speed of the tool over time."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Refused
from assistant.report.figures import new_figure, picture
from assistant.robots.timing import Simulation

MOST_PICTURE_ROWS: Final = 4000
"""Of samples that are drawn; of more, every second, third …"""


def motion_png(simulation: Simulation) -> bytes | None:
    """None without matplotlib, which the extra `plot` brings."""
    try:
        drawn = new_figure(7.0, 3.5)
    except Refused:
        return None
    samples, robot = simulation.samples, simulation.robot
    every = slice(None, None, max(1, len(samples) // MOST_PICTURE_ROWS))
    upper, lower = drawn.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for name, unit, joint in zip(robot.axes, robot.units, samples.joints.T, strict=True):
        upper.plot(samples.t[every], joint[every], label=f"{name}, {unit}", lw=1.2)
    lower.plot(samples.t[every], samples.tcp_speed[every], color="0.3", lw=1.2)
    lower.set(xlabel="seconds", ylabel="tool, mm/s")
    upper.set_ylabel("joints")
    upper.legend(fontsize=7, ncols=3)
    for axes in (upper, lower):
        axes.grid(alpha=0.3)
    return picture(drawn)
