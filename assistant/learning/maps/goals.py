"""Goals: what a map is asked to reach, as the cameras see it, with the truth to measure it by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths, norms
from assistant.base.diagnostics import Refused
from assistant.learning.maps.rules import BAD_BOX, BAD_RANGE, BOX_NOT_REACHED
from assistant.learning.maps.seen_arm import ObservedArm
from assistant.learning.maps.solving import solve_joints
from assistant.robots import Robot

ToolRule = Literal["any", "down", "forward"]
"""How a tool is held: anyhow, its z axis down, or along x of the base."""
TOOL_ROTATIONS: Final[dict[ToolRule, tuple[float, float, float, float]]] = {
    "down": (0.0, 0.0, 1.0, 0.0),
    "forward": (0.7071067811865476, 0.0, 0.7071067811865476, 0.0),
}
"""Rotations of a tool that is not turned about its own axis."""
BOX_SAMPLES: Final = 2000
"""Poses by which it is asked how much of a box an arm reaches."""
LEAST_REACHED: Final = 0.999
REACHED_MM: Final = 0.01
"""Mm within which a place is reached."""


@dataclass(frozen=True, slots=True, eq=False)
class Goals:
    """pixels: (m, d). points: (m, k, 3) mm of the tool there. turns: (m, 4) of the tool, None where
    only a place is wanted.
    """

    pixels: Floats
    points: Floats
    turns: Floats | None = None

    @property
    def diagonal(self) -> float:
        """Mm of the box about the places of the first point."""
        return float(np.linalg.norm(np.ptp(self.points[:, 0], axis=0)))


@dataclass(frozen=True, slots=True, eq=False)
class InRanges:
    """The tool wherever joints between (a, 2) bring it."""

    ranges: Floats

    def draw(self, arm: ObservedArm, count: int, draw: np.random.Generator) -> Goals:
        joints = _random_joints(draw, self.ranges, count)
        points, turns = arm.tool(joints)
        return Goals(arm.seen(points), points, None if arm.free else turns)


@dataclass(frozen=True, slots=True, eq=False)
class InBox:
    """The first point of the tool in a box (3, 2) mm of the base, the tool held by a rule.

    rule: `any` only for arms of which one point is seen. turn: degrees about the tool's own axis,
    lowest and highest.
    """

    box: Floats
    rule: ToolRule = "any"
    turn: tuple[float, float] = (0.0, 0.0)

    def draw(self, arm: ObservedArm, count: int, draw: np.random.Generator) -> Goals:
        places = _random_joints(draw, self.box, count)
        if self.rule == "any":
            points = places[:, None]
            return Goals(arm.seen(points), points)
        turns = self._turns(draw.uniform(*self.turn, count))
        points = places[:, None] + rotations.rotate(turns[:, None], arm.points - arm.points[0])
        return Goals(arm.seen(points), points, turns)

    def joints(
        self, arm: ObservedArm, count: int, draw: np.random.Generator
    ) -> tuple[Floats, Truths]:
        """Of poses in the box: joints (n, a) of the branch that reaches most, and which reach."""
        places = _random_joints(draw, self.box, count)
        turns = self._turns(draw.uniform(*self.turn, count))
        flange = places - rotations.rotate(turns, arm.points[0])
        joints, valid = arm.robot.ik(flange, turns)
        best = int(valid.sum(axis=0).argmax())
        return joints[:, best], valid[:, best]

    def _turns(self, degrees: Floats) -> Floats:
        about = rotations.about((0.0, 0.0, 1.0) * np.ones((len(degrees), 1)), degrees)
        return rotations.canonical(rotations.multiply(np.array(TOOL_ROTATIONS[self.rule]), about))


Space = InRanges | InBox


def ranges_about_home(robot: Robot, moves: Sequence[str]) -> Floats:
    """(a, 2) in which every joint of an arm can learn: 25 degrees about its home, 50 of the first
    axis and 45 of the last, moved into its limits.
    """
    wide = {robot.axes[0]: 50.0, robot.axes[-1]: 45.0}
    out = []
    for name in moves:
        at = robot.axes.index(name)
        least, most = robot.limits[at]
        half = min(wide.get(name, 25.0), (most - least) / 2.0)
        middle = float(np.clip(robot.home[at], least + half, most - half))
        out.append((middle - half, middle + half))
    return np.array(out)


def check_ranges(robot: Robot, moves: Sequence[str], ranges: Floats) -> Floats:
    """The same ranges (a, 2); raises Refused for one that is none or leaves the limits."""
    for name, (low, high) in zip(moves, ranges.tolist(), strict=True):
        least, most = robot.limits[robot.axes.index(name)].tolist()
        if not least <= low < high <= most:
            said = BAD_RANGE(
                axis=name, low=low, high=high, robot=robot.title, least=least, most=most
            )
            raise Refused(said, exit_status=2)
    return ranges


def check_box(box: Floats) -> Floats:
    """The same box (3, 2); raises Refused for one that is none."""
    reason = ""
    if box.shape != (3, 2) or not np.isfinite(box).all():
        reason = "is not three ranges of numbers"
    elif not (box[:, 0] < box[:, 1]).all():
        reason = "is empty"
    if reason:
        raise Refused(BAD_BOX(reason=reason), exit_status=2)
    return box


def ranges_for_box(arm: ObservedArm, space: InBox, seed: int = 0) -> Floats:
    """(a, 2) between which joints reach all of a box, a twentieth wider, inside the limits.

    Raises Refused if the arm does not reach the box in one of its branches, without a rule from its
    home on.
    """
    draw = np.random.default_rng(seed)
    limits = arm.robot.limits[arm.columns]
    if space.rule == "any":
        points = _random_joints(draw, space.box, BOX_SAMPLES)[:, None]
        home = np.tile(arm.robot.home[arm.columns], (BOX_SAMPLES, 1))
        joints = solve_joints(arm, points, home, limits)
        reached = norms(arm.tool(joints)[0][:, 0] - points[:, 0]) < REACHED_MM
    else:
        joints, reached = space.joints(arm, BOX_SAMPLES, draw)
    share = float(reached.mean())
    if share < LEAST_REACHED:
        held = "anyhow" if space.rule == "any" else space.rule
        finding = BOX_NOT_REACHED(share=share, robot=arm.robot.title, rule=held)
        raise Refused(finding, exit_status=1)
    low, high = joints[reached].min(axis=0), joints[reached].max(axis=0)
    more = 0.05 * (high - low) + 1.0
    least, most = limits.T
    return np.column_stack([np.maximum(low - more, least), np.minimum(high + more, most)])


def _random_joints(draw: np.random.Generator, ranges: Floats, count: int) -> Floats:
    """(count, a) between ranges (a, 2)."""
    return draw.uniform(ranges[:, 0], ranges[:, 1], (count, len(ranges)))
