"""How far two runs may be apart because the text of one of them prints so many decimals.

A text holds constants: positions, frames, tools. Each value of one is off by half of its last
decimal at most, three values of a place by √3 of that; an orientation is off by an angle, which
moves what is told in it by the angle times its lever. What a robot does hangs on few constants:

- the target;
- what the program moves it by, or reads it from, on the way there;
- the frame that it is told in: its angle counts with the distance from the frame to the tip;
- the tool: its angle counts with its length, since the place of the flange follows from both.

A frame or a tool that is none of its own (the base, the flange) is no constant. Joint values are
off by half of their last decimal each; how far that moves the tip is at most the sum of them times
how far the arm reaches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.program.geometry import IDENTITY, Pose
from assistant.virtual.events import Moved

TARGET_AND_SHIFT: Final = 2
"""Constants that every visit may hang on; its frame and its tool count where they are some."""
SLACK: Final = 1e-6
"""mm and degrees that working numbers out may add."""


@dataclass(frozen=True, slots=True)
class Allowed:
    """mm and degrees that the tips, and the tools on their flanges, may be apart."""

    tip: float
    angle: float
    tool: float
    tool_angle: float


@dataclass(frozen=True, slots=True)
class Rounding:
    """What a language prints. value: mm, half of the last decimal of a coordinate. angle: degrees,
    of a whole orientation, whose three angles are off by half of their last decimal each. joint:
    degrees, of a joint value.
    """

    value: float
    angle: float
    joint: float

    def allowed(self, move: Moved, reach: float) -> Allowed:
        """How far another program's motion may be from one. reach: mm, the farthest of all tips."""
        place, turn = math.sqrt(3.0) * self.value + SLACK, self.angle + SLACK
        constants, lever = TARGET_AND_SHIFT, 0.0
        if move.tool != IDENTITY:
            constants += 1
            lever += math.hypot(*move.tool.position)
        if move.frame != IDENTITY and (tip := tip_of(move)) is not None:
            constants += 1
            lever += math.dist(tip.position, move.frame.position)
        tip_apart = constants * place + math.radians(turn) * lever
        angle = constants * turn
        if move.joints is not None:
            joints = len(move.joints) * (self.joint + SLACK)
            tip_apart += math.radians(joints) * reach
            angle += joints
        return Allowed(tip_apart, angle, 2.0 * place, 2.0 * turn)


def tip_of(move: Moved) -> Pose | None:
    """The tip of the tool where a motion ends, None where only its joints are known."""
    return None if move.flange is None else move.flange @ move.tool


def reach_of(moves: Sequence[Moved]) -> float:
    """How far the farthest tip is from the base, in mm."""
    tips = [tip for tip in map(tip_of, moves) if tip is not None]
    return max((float(np.linalg.norm(tip.position)) for tip in tips), default=0.0)
