"""The motion of a simulation over time, drawn: pose, speed, and axes against their limits."""

from __future__ import annotations

from typing import Final

from assistant.base.arrays import evenly_spaced
from assistant.report import figures
from assistant.robots.timing import Simulation

MOST_CURVE_POINTS: Final = 4000
"""Points of a curve that are drawn."""


def motion_plot(simulation: Simulation, title: str, format: str = "png") -> bytes:
    """Five diagrams over the time in seconds, as `png` or `svg`."""
    robot, samples = simulation.robot, simulation.samples
    some = evenly_spaced(len(samples), MOST_CURVE_POINTS)
    t = samples.t[some]
    figure = figures.new_figure(9.0, 11.0)
    place, turn, speed, joints, velocity = figure.subplots(5, 1, sharex=True)
    for axis, label in enumerate("xyz"):
        place.plot(t, samples.position[some, axis], label=label)
    for part, label in enumerate(("q1 (w)", "q2 (x)", "q3 (y)", "q4 (z)")):
        turn.plot(t, samples.quaternion[some, part], label=label)
    speed.plot(t, samples.tcp_speed[some], label="TCP")
    low, high = robot.limits.T
    for axis, label in enumerate(robot.axes):
        part = (samples.joints[some, axis] - low[axis]) / (high[axis] - low[axis])
        joints.plot(t, 100.0 * part, label=label)
        share = samples.joint_velocity[some, axis] / robot.speeds[axis]
        velocity.plot(t, 100.0 * share, label=label)
    for axes, limits in ((joints, (0.0, 100.0)), (velocity, (-100.0, 100.0))):
        for limit in limits:
            axes.axhline(limit, color="red", linestyle="--", linewidth=1.0)
    joints.set_ylim(-5.0, 105.0)
    velocity.set_ylim(-110.0, 110.0)
    place.set(title=title, ylabel="position in mm")
    turn.set(ylabel="orientation")
    speed.set(ylabel="speed of the tool in mm/s")
    joints.set(ylabel="joints, % of their range")
    velocity.set(ylabel="joint speeds, % of the most", xlabel="seconds")
    for axes in (place, turn, speed, joints, velocity):
        axes.grid(visible=True, alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figures.picture(figure, format)
