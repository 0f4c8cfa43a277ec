"""What the target expressions of a program stand for, as far as its text tells."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

from assistant.base import rotations
from assistant.program.expressions import (
    Apply,
    Binary,
    Expression,
    JointValue,
    Name,
    Number,
    TargetValue,
    Unary,
)
from assistant.program.geometry import BASE, FLANGE, Frame, JointTarget, Pose, Target, Tool
from assistant.program.program import Procedure, Program

V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class Place:
    """A target and the pose that a move goes to: its own, or one `moved` from there."""

    target: Target
    pose: Pose
    moved: bool = False


class Names:
    """The names of a program; without regard to case, a procedure's own ones first."""

    def __init__(self, program: Program) -> None:
        self.tools = {FLANGE: Tool()} | _lowered(program.tools)
        self.frames = {BASE: Frame()} | _lowered(program.frames)
        self.shared_targets = _lowered(program.targets)
        self.shared_joints = _lowered(program.joint_targets)
        self.shared_constants = {
            name.lower(): variable.initial
            for name, variable in program.variables.items()
            if variable.storage == "constant" and variable.initial is not None
        }
        self.own: dict[str, Expression | None] = {}

    def enter(self, procedure: Procedure) -> None:
        """Takes over the variables and parameters of a procedure."""
        self.own = {parameter.name.lower(): None for parameter in procedure.parameters}
        for name, variable in procedure.variables.items():
            constant = variable.storage == "constant"
            self.own[name.lower()] = variable.initial if constant else None

    def tool(self, name: str) -> Tool | None:
        return self.tools.get(name.lower())

    def frame(self, name: str) -> Frame | None:
        return self.frames.get(name.lower())

    def place(self, expression: Expression, depth: int = 8) -> Place | None:
        """Where a move goes; None if only running the program tells."""
        match expression:
            case TargetValue():
                return Place(expression.target, expression.target.pose)
            case Name():
                key = expression.name.lower()
                if key not in self.own and key in self.shared_targets:
                    target = self.shared_targets[key]
                    return Place(target, target.pose)
                value = self.constant(key)
                return self.place(value, depth - 1) if value is not None and depth else None
            case Apply(function=name, arguments=(first, *rest)) if name in SHIFTS and depth:
                place = self.place(first, depth - 1)
                numbers = [self.number(argument) for argument in rest]
                shift = SHIFTS[name](*[n for n in numbers if n is not None])
                if place is None or None in numbers or shift is None:
                    return None
                pose = place.pose
                if name == "offset":
                    x, y, z = (a + b for a, b in zip(pose.position, shift.position, strict=True))
                    return Place(place.target, Pose((x, y, z), pose.quaternion), moved=True)
                return Place(place.target, pose @ shift, moved=True)
        return None

    def joints(self, expression: Expression) -> JointTarget | None:
        match expression:
            case JointValue():
                return expression.target
            case Name():
                key = expression.name.lower()
                if key not in self.own and key in self.shared_joints:
                    return self.shared_joints[key]
                value = self.constant(key)
                return value.target if isinstance(value, JointValue) else None
        return None

    def constant(self, key: str) -> Expression | None:
        return self.own[key] if key in self.own else self.shared_constants.get(key)

    def number(self, expression: Expression, depth: int = 8) -> float | None:
        """The value of a number that the text tells."""
        match expression:
            case Number(value=value):
                return float(value)
            case Unary(operator="-", operand=operand):
                inner = self.number(operand, depth)
                return None if inner is None else -inner
            case Binary(operator="+" | "-" | "*" as operator, left=left, right=right):
                a, b = self.number(left, depth), self.number(right, depth)
                if a is None or b is None:
                    return None
                return a + b if operator == "+" else a - b if operator == "-" else a * b
            case Name(name=name) if depth:
                meant = self.constant(name.lower())
                return None if meant is None else self.number(meant, depth - 1)
        return None


def _offset(x: float = 0.0, y: float = 0.0, z: float = 0.0, *rest: float) -> Pose | None:
    return None if rest else Pose((x, y, z))


def _relative(
    x: float = 0.0, y: float = 0.0, z: float = 0.0,
    rx: float = 0.0, ry: float = 0.0, rz: float = 0.0, *rest: float,
) -> Pose | None:  # fmt: skip
    """A move in the tool frame; None for turns about several axes, whose order languages
    disagree about.
    """
    turns = [turn for turn in zip("XYZ", (rx, ry, rz), strict=True) if turn[1]]
    if rest or len(turns) > 1 or not math.isfinite(x + y + z + rx + ry + rz):
        return None
    q = [1.0, 0.0, 0.0, 0.0]
    for axis, degrees in turns:
        q = rotations.canonical(rotations.about(rotations.AXES[axis], degrees)).tolist()
    return Pose((x, y, z), (q[0], q[1], q[2], q[3]))


SHIFTS: Final = {"offset": _offset, "relative": _relative}


def _lowered(table: Mapping[str, V]) -> dict[str, V]:
    return {name.lower(): value for name, value in table.items()}
