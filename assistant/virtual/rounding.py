"""How far two runs may be apart because the text of one of them prints so many decimals.

A text holds constants: targets, frames, tools. Each value of one is off by half of its last decimal
at most, three values of a place by √3 of that; an orientation is off by an angle, which moves what
is told in it by the angle times its lever. Where a robot goes hangs on few of them:

- the target; a place that is a constant of the text hangs on no other one but its frame;
- the frame that it is told in: its angle counts with the distance from the frame to the tip;
- where the target is worked out, what it is moved by or was read from, and the tool: when a place
  is read, that of the flange follows from both, so that its angle counts with the tool's length.

A frame or a tool that is none of its own (the base, the flange) is no constant. Joint values are
off by half of their last decimal each; how far that moves the tip is at most the sum of them times
how far the arm reaches.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.events import Moved

CALCULATION_ERROR: Final = 1e-6
"""mm and degrees that working numbers out may add."""
KEY_DECIMALS: Final = 4
"""Decimals of mm by which a place is known again."""


@dataclass(frozen=True, slots=True)
class Allowed:
    """Mm and degrees that the tips, and the tools on their flanges, may be apart."""

    tip: float
    angle: float
    tool: float
    tool_angle: float


@dataclass(frozen=True, slots=True)
class Printed:
    """What the text prints of one constant, if that is not what it prints of most.

    value: mm, half of the last decimal of a coordinate. angle: degrees, of the orientation, whose
    three angles are off by half of their last decimal each.
    """

    value: float
    angle: float


@dataclass(frozen=True, slots=True)
class Rounding:
    """What a text prints of any constant. joint: degrees, of a joint value.

    constants: what it prints of those that it holds, by their place. A frame may stand as its
    inverse.
    """

    value: float
    angle: float
    joint: float
    constants: dict[tuple[float, ...], Printed] = field(default_factory=dict)

    def of(self, poses: Iterable[tuple[Pose, Printed]]) -> Rounding:
        """With the constants that a text holds."""
        found = dict(self.constants)
        for pose, printed in poses:
            found |= {_position_key(pose): printed, _position_key(pose.inverse()): printed}
        return Rounding(self.value, self.angle, self.joint, found)

    def allowed(self, move: Moved, reach: float) -> Allowed:
        """How far a motion may be from what was meant. reach: mm, the farthest of all tips."""
        far, turned, tip = CALCULATION_ERROR, CALCULATION_ERROR, tip_of(move)
        target = None if tip is None else move.frame.inverse() @ tip
        known = None if target is None else self.constants.get(_position_key(target))
        for printed in (known or self._any, self._any):  # the target, and what may turn it
            turned += printed.angle
        far += _position_error(known or self._any)
        if known is None:
            far += _position_error(self._any)
            if move.tool != IDENTITY:
                printed = self._printed(move.tool)
                turned += printed.angle
                length = math.hypot(*move.tool.position)
                far += _position_error(printed) + math.radians(printed.angle) * length
        if move.frame != IDENTITY and tip is not None:
            printed = self._printed(move.frame)
            turned += printed.angle
            lever = math.dist(tip.position, move.frame.position)
            far += _position_error(printed) + math.radians(printed.angle) * lever
        if move.joints is not None:
            joints = len(move.joints) * (self.joint + CALCULATION_ERROR)
            far += math.radians(joints) * reach
            turned += joints
        tool = self._printed(move.tool)
        return Allowed(
            far, turned, _position_error(tool) + CALCULATION_ERROR, tool.angle + CALCULATION_ERROR
        )

    @property
    def _any(self) -> Printed:
        return Printed(self.value, self.angle)

    def _printed(self, pose: Pose) -> Printed:
        return self.constants.get(_position_key(pose), self._any)


def _position_error(printed: Printed) -> float:
    return math.sqrt(3.0) * printed.value


def _position_key(pose: Pose) -> tuple[float, ...]:
    return tuple(round(value, KEY_DECIMALS) + 0.0 for value in pose.position)


def tip_of(move: Moved) -> Pose | None:
    """The tip of the tool where a motion ends, None where only its joints are known."""
    return None if move.flange is None else move.flange @ move.tool


def reach_of(moves: Sequence[Moved]) -> float:
    """How far the farthest tip is from the base, in mm."""
    tips = [tip for tip in map(tip_of, moves) if tip is not None]
    return max((float(np.linalg.norm(tip.position)) for tip in tips), default=0.0)
