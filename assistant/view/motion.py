"""The way that a page plays: samples of the arm over time, and how near it comes to its limits."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, norms
from assistant.cell.scene import PlacedRobot
from assistant.program.geometry import Pose
from assistant.robots.robot import Robot
from assistant.robots.timing import Simulation
from assistant.robots.timing.course import Mount
from assistant.robots.timing.simulation import SAMPLE_PERIOD, samples_of

MOST_SAMPLES: Final = 20_000
"""Places of the arm that a page holds."""
COARSEST: Final = 0.1
"""Seconds between them at most; a page plays no more of a program than that allows."""
NEAR_JOINTS: Final = 0.5
"""Degrees (mm) that a place on the time line is away from joints that it stands for, at most."""
NEAR_PATH: Final = 1.0
"""mm of a place from the path of the tool, by which the tool comes to it."""

Record = dict[str, Any]


def column_text(values: NDArray[Any]) -> str:
    """An array as base64 of its little-endian numbers: float32, or uint32 if it holds integers."""
    kind = "<u4" if np.issubdtype(values.dtype, np.integer) else "<f4"
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


class Motion:
    """The way that the page plays: k samples of time, joints and the tool.

    held: whether the tool is at the arm for all of it; else its path is that of the flange.
    whole: seconds of the program.
    """

    def __init__(self, simulation: Simulation, placed: PlacedRobot) -> None:
        self.whole = simulation.seconds
        seconds = min(self.whole, COARSEST * (MOST_SAMPLES - 1))
        period = max(SAMPLE_PERIOD, seconds / (MOST_SAMPLES - 1))
        robot, start = simulation.robot, simulation.start
        samples = samples_of(simulation.history, seconds, period, robot, start)
        self.robot = placed.robot
        self.times, self.joints, self.speeds = samples.t, samples.joints, samples.tcp_speed
        self.held = tool_held(simulation)
        places = samples.position
        if not self.held:
            places = self.robot.link_frames(self.joints)[0][:, -1]
        self.places = placed.base.moved(places)

    def record(self) -> Record:
        room, axis = room_left(self.robot, self.joints)
        return {
            "times": column_text(self.times),
            "joints": column_text(self.robot.chained(self.joints)),
            "places": column_text(self.places),
            "speeds": column_text(self.speeds),
            "room": column_text(room),
            "nearest": column_text(axis),
            "axes": len(self.robot.axes),
            "names": list(self.robot.axes),
            "held": self.held,
            "whole": self.whole,
        }

    @property
    def until(self) -> float:
        """Seconds up to which it is played."""
        return float(self.times[-1])

    def passing(self, place: Floats) -> float | None:
        """Seconds at which the path comes to a place (3,) in the world, None if it never does."""
        start = self.places[:-1]
        if not len(start):
            return None
        step = np.diff(self.places, axis=0)
        square = np.einsum("ij,ij->i", step, step)
        along = np.einsum("ij,ij->i", place - start, step)
        part = np.clip(along / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        off = norms(start + part[:, None] * step - place)
        if off.min() > NEAR_PATH:
            return None
        at = int(np.flatnonzero(off <= off.min() + NEAR_PATH / 10.0)[0])
        return float(self.times[at] + part[at] * (self.times[at + 1] - self.times[at]))

    def when(self, joints: Floats) -> float | None:
        """Seconds at which joints (a,) are first passed, None if they are not on this way."""
        start = self.joints[:-1]
        if not len(start):
            return None
        step = np.diff(self.joints, axis=0)
        square = np.einsum("ij,ij->i", step, step)
        along = np.einsum("ij,ij->i", joints - start, step)
        part = np.clip(along / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        off = np.abs(start + part[:, None] * step - joints).max(axis=1)
        if off.min() > NEAR_JOINTS:
            return None
        at = int(np.flatnonzero(off <= off.min() + NEAR_JOINTS / 10.0)[0])
        return float(self.times[at] + part[at] * (self.times[at + 1] - self.times[at]))


def room_left(robot: Robot, joints: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """(k, a) joints → (k,) how near they are to a limit, and (k,) of which axis.

    0 at a limit, 1 in the middle between both, of the axis that has the least: so degrees and mm
    of axes with wide and narrow ranges are compared.
    """
    low, high = robot.limits.T
    half = (high - low) / 2.0
    least = np.minimum(joints - low, high - joints)
    part = np.where(np.isfinite(half) & (half > 0.0), least / np.where(half > 0.0, half, 1.0), 1.0)
    axis = part.argmin(axis=1)
    return np.clip(part[np.arange(len(part)), axis], 0.0, 1.0), axis


def tool_held(simulation: Simulation) -> bool:
    """Whether the tool is at the arm, and no work piece, for all of the program."""
    return all(mount.tool.held and not mount.frame.held for mount in _tool_mounts(simulation))


def tool_tips(simulation: Simulation) -> list[Pose]:
    """Tips of the tools that the arm carries, without the bare flange."""
    found = {mount.tool.tip: None for mount in _tool_mounts(simulation) if mount.tool.held}
    return [tip for tip in found if tip != Pose()]


def _tool_mounts(simulation: Simulation) -> Iterator[Mount]:
    for passed in simulation.passed:
        for piece in passed.pieces:
            yield from piece.moves.mounts
