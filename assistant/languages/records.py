"""Records as values in brackets, in the order of their fields: `[[400,0,300],[1,0,0,0]]`.

A target is its position, quaternion, quadrants of axes 1, 4 and 6 with a number for the rest, and
its external axes, which are UNUSED where there are none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Rule
from assistant.program import expressions as e
from assistant.program.geometry import (
    UNUSED_AXIS,
    Configuration,
    Frame,
    JointTarget,
    Load,
    Pose,
    Target,
    Tool,
)
from assistant.program.motion import configuration_of, configuration_row
from assistant.robots.configurations import from_confdata, to_confdata

Values = Any
"""A number, truth or text, or a list of values; None for anything else."""

_UNUSED: Final = 9e9
"""Stands for an external axis that there is none of."""
_POSE: Final = "[[nnn][nnnn]]"
_TOOL: Final = f"b{_POSE}[n[nnn][nnnn]nnn]"
_FRAME: Final = f"bbt{_POSE}{_POSE}"


# ------------------------------------------------------------------------------------- read


def shape(values: Values) -> str:
    """`n` a number, `b` a truth, `t` a text, brackets for lists, `?` for anything else."""
    return "".join(map(_letter, values)) if isinstance(values, list) else "?"


def _letter(value: Values) -> str:
    match value:
        # First, as a truth is an int in Python.
        case bool():
            return "b"
        case int() | float():
            return "n"
        case str():
            return "t"
        case list():
            return f"[{shape(value)}]"
    return "?"


def tool_of(values: Values) -> Tool | None:
    """The tool that values say, None if they are none; of one below 0 kg the load is not known."""
    if shape(values) != _TOOL:
        return None
    held, tip, (mass, *rest) = values
    tip_pose = _pose(*tip)
    # A mass below 0, such as -1, stands for a load that is not defined.
    load = None if mass < 0 else load_of(mass, *rest)
    return None if tip_pose is None else Tool(tip_pose, load, held)


def load_of(mass: float, centre: list[float], axes: list[float], *inertia: float) -> Load:
    """The load that values say: mass, centre, axes of inertia, and inertia."""
    x, y, z = map(float, centre)
    a, b, c, d = map(float, axes)
    i, j, k = map(float, inertia)
    return Load(float(mass), (x, y, z), (a, b, c, d), (i, j, k))


def frame_of(values: Values) -> Frame | None:
    """The frame that values say, None if they are none."""
    if shape(values) != _FRAME:
        return None
    held, fixed, mechanism, user, object = values
    first, second = _pose(*user), _pose(*object)
    # A work object that neither stands still nor has a unit moves with nothing.
    if first is None or second is None or not (fixed or mechanism):
        return None
    return Frame(first, second, held, "" if fixed else mechanism)


def aggregate(items: tuple[e.Expression, ...]) -> e.Expression:
    """Values in brackets: a target, joint target or pose if they have its form."""
    values: list[list[float]] = []
    for item in items:
        if not isinstance(item, e.Aggregate):
            return e.Aggregate(items)
        numbers = [float(n.value) for n in item.items if isinstance(n, e.Number)]
        if len(numbers) != len(item.items):
            return e.Aggregate(items)
        values.append(numbers)
    match [len(part) for part in values]:
        # A zero quaternion is a target without an orientation, which stays a list of values.
        case [3, 4, 4, 6] if any(values[1]):
            return e.TargetValue(target([v for part in values for v in part]))
        case [6, 6]:
            return e.JointValue(JointTarget(tuple(values[0]), _external(values[1])))
        case [3, 4] if (pose := _pose(*values)) is not None:
            return e.PoseValue(pose)
    return e.Aggregate(items)


def target(values: Sequence[float]) -> Target:
    """From the 17 numbers of a target whose quaternion is not zero."""
    configuration: Configuration | None = None
    # Quadrants are whole numbers that fit a byte; other values state no configuration.
    if all(-127 <= v <= 127 and v == int(v) for v in values[7:11]):
        configuration = configuration_of(from_confdata([values[7:11]])[0])
    pose = _pose(values[:3], values[3:7])
    assert pose is not None
    return Target(pose, configuration, _external(values[11:17]))


def _pose(position: Sequence[float], quaternion: Sequence[float]) -> Pose | None:
    if not any(quaternion):
        return None
    # Both signs of a quaternion are one orientation; one of them is kept, so that poses compare.
    return Pose.of(np.array(position, dtype=np.float64), rotations.canonical(quaternion))


def _external(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(UNUSED_AXIS if v >= _UNUSED else v for v in values)


# ------------------------------------------------------------------------------------ write


@dataclass(frozen=True, slots=True)
class Decimals:
    """Those of positions (mm), quaternions, joints (degrees or mm), and other sizes.

    not_finite: tells of numbers that are infinite or none; has the field what.
    """

    position: int
    quaternion: int
    joint: int
    size: int
    not_finite: Rule

    def values(self, record: Pose | Target | JointTarget | Load | Tool | Frame) -> Values:
        """The values of a record, rounded; raises Refused. A tool has a load."""
        match record:
            case Pose():
                return self._pose(record, "a pose")
            case Target(pose, configuration, external):
                branch = to_confdata([configuration_row(configuration)])[0]
                outside = self._external(external, "a target")
                return [*self._pose(pose, "a target"), [*map(float, branch)], outside]
            case JointTarget(joints, external):
                what = "a joint target"
                return [self.rounded(joints, self.joint, what), self._external(external, what)]
            case Load(mass, centre, axes, inertia):
                what = "the load of a tool"
                size, *sizes = self.rounded((mass, *inertia), self.size, what)
                place = self.rounded(centre, self.position, what)
                return [size, place, self.rounded(axes, self.quaternion, what), *sizes]
            case Tool(tip, load, held):
                assert load is not None
                return [held, self.values(tip), self.values(load)]
            case Frame(user, object, held, mechanism):
                return [held, not mechanism, mechanism, self.values(user), self.values(object)]

    def rounded(self, values: Sequence[float], places: int, what: str) -> list[float]:
        """Numbers with so many decimals; raises Refused with `what` they are of."""
        if not np.isfinite(values).all():
            raise Refused(self.not_finite(what=what))
        # Adding 0.0 turns -0.0 into 0.0, which is printed without a sign.
        return [float(v) + 0.0 for v in np.round(values, places)]

    def _pose(self, pose: Pose, what: str) -> list[list[float]]:
        place = self.rounded(pose.position, self.position, what)
        return [place, self.rounded(pose.quaternion, self.quaternion, what)]

    def _external(self, values: Sequence[float], what: str) -> list[float]:
        # An axis without a position is NaN, which differs from itself.
        return self.rounded([_UNUSED if v != v else v for v in values], self.joint, what)
