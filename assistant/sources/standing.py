"""The surroundings of a process, as they are asked by what moves in a frame with a tool."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.program.expressions import Apply, Expression, Name, Number
from assistant.program.geometry import BASE, FLANGE, Frame, Pose, Tool
from assistant.program.statements import Motion, Move, Statement, Travel
from assistant.sources.process import Process
from assistant.sources.surroundings import Surroundings, WayIn


@dataclass(frozen=True, slots=True)
class FramedSurroundings:
    """frame: in the base of the robot. tool: its tip in the flange."""

    around: Surroundings
    frame: Pose
    tool: Pose

    @staticmethod
    def of(process: Process, motion: Motion) -> FramedSurroundings | None:
        """None where nobody knows what is around, or work or tool move."""
        frames = {BASE: Frame(), **process.frames}
        tools = {FLANGE: Tool(), **process.tools}
        frame, tool = frames.get(motion.frame), tools.get(motion.tool)
        if process.around is None or frame is None or tool is None:
            return None
        if frame.held or frame.mechanism or not tool.held:
            return None
        return FramedSurroundings(process.around, frame.pose, tool.tip)

    def places(self, positions: Floats, quaternions: Floats) -> Floats | None:
        """As of `Surroundings`, in the frame; one quaternion (4,) may be that of all."""
        turn = self.frame.quaternion
        turned = rotations.multiply(np.array(turn), np.atleast_2d(quaternions))
        return self.around.places(
            rotations.rotate(turn, positions) + self.frame.position,
            np.broadcast_to(turned, (len(positions), 4)),
            self.tool,
        )

    def way_in(self, pose: Pose, distance: float, place: str) -> WayIn:
        return self.around.way_in(self.frame @ pose, self.tool, distance, place)


def approach_of(
    standing: FramedSurroundings | None, pose: Pose, distance: float, place: str
) -> WayIn:
    """Along the tool where nobody knows what is around."""
    return WayIn() if standing is None or not distance else standing.way_in(pose, distance, place)


def backed_off_target(target: str, distance: float, way: WayIn) -> Expression:
    """Mm away from a named target, in the direction of a way."""
    numbers = (
        _number_expression(round(part * distance, BACKED_OFF_DECIMALS)) for part in way.direction
    )
    return Apply("relative", (Name(target), *numbers))


def move_to(
    kind: Literal["joint", "linear", "travel"], target: Expression, motion: Motion
) -> Statement:
    return Travel(target, motion) if kind == "travel" else Move(kind, target, motion)


def _number_expression(value: float) -> Number:
    return Number(int(value) if value == int(value) else value)


BACKED_OFF_DECIMALS: Final = 3
"""Decimals of mm that a place is backed off by."""
