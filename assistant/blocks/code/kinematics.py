"""Kinematics of an arm as source: forward, all branches of inverse, Jacobian, configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, Literal

import numpy as np

from assistant.base.diagnostics import Refused
from assistant.blocks.code import rules
from assistant.blocks.code.templates import (
    number_literal,
    number_literals,
    safe_text,
    source_identifier,
    template_environment,
)
from assistant.blocks.code.vectors import vectors_csv
from assistant.program.geometry import Pose
from assistant.robots import Robot
from assistant.robots.arms import FiveAxis, Placed, Scara, SixAxis
from assistant.robots.arms.arm import BOUNDARY, CLOSING
from assistant.robots.arms.closed_form import ON_AXIS_1, WRIST_IN_LINE
from assistant.robots.configurations import QUADRANTS
from assistant.robots.robot import LIMIT_TOLERANCE

Language = Literal["c", "python"]
LANGUAGES: Final[tuple[Language, ...]] = ("c", "python")


@dataclass(frozen=True, slots=True)
class SourceNames:
    """What the source of an arm is called.

    stem: of its files. prefix: of its functions, with a `_` behind it.
    """

    stem: str
    prefix: str


def kinematics(robot: Robot, language: Language) -> Mapping[str, bytes]:
    """The files of the source by their names: the source, a table of vectors, and what checks it.

    Raises Refused for an arm without a closed form, and one that is never away from singularities.
    """
    stem = source_identifier(robot.name)
    named = SourceNames(stem, stem)
    endings = {"c": (".h", ".c"), "python": (".py",)}[language]
    files = {f"{stem}{end}": source_of(robot, named, end) for end in endings}
    check = template_environment().get_template(f"kinematics/check{endings[-1]}.j2")
    checked = check.render(_name_values(named)).encode()
    vectors = vectors_csv(robot)
    return files | {f"{stem}_check{endings[-1]}": checked, f"{stem}_vectors.csv": vectors}


def source_of(robot: Robot, named: SourceNames, ending: str) -> bytes:
    """One file of the source: `.h`, `.c` or `.py`; raises Refused without a closed form."""
    template = template_environment().get_template(f"kinematics/arm{ending}.j2")
    return template.render(_name_values(named) | _robot_values(robot)).encode()


def _name_values(named: SourceNames) -> dict[str, Any]:
    macro = named.prefix.upper()
    return {
        "stem": named.stem,
        "prefix": named.prefix,
        "macro": macro,
        "guard": f"{macro}_H",
        "header": f"{named.stem}.h",
    }


@dataclass(frozen=True)
class _PlacedArm:
    """How a file counts joints, base and flange of the closed form, ready to be written."""

    arm: Placed

    @cached_property
    def senses(self) -> tuple[str, ...]:
        return number_literals(self.arm.senses)

    @cached_property
    def offsets(self) -> tuple[str, ...]:
        return number_literals(self.arm.zeros)

    @cached_property
    def poses(self) -> list[tuple[str, tuple[str, ...], tuple[str, ...]]]:
        named: dict[str, Pose] = {
            "BASE": self.arm.base,
            "FLANGE": self.arm.flange,
            "TO_BASE": self.arm.base.inverse(),
            "FROM_FLANGE": self.arm.flange.inverse(),
        }
        return [
            (name, number_literals(p.position), number_literals(p.quaternion))
            for name, p in named.items()
        ]


def _robot_values(robot: Robot) -> dict[str, Any]:
    """What the templates are told of a robot."""
    arm = robot.arm
    if not isinstance(arm, SixAxis | FiveAxis | Scara | Placed):
        raise Refused(rules.NO_CLOSED_FORM(title=robot.title))
    axis_of = dict(robot.turning())
    turning = [axis_of.get(column, -1) for column in range(QUADRANTS.start, QUADRANTS.stop)]
    return {
        "title": safe_text(robot.title),
        "kind": arm.kind,
        "axes": robot.axes,
        "branches": robot.branches,
        "branch_words": BRANCH_WORDS[arm.kind],
        "shape_words": SHAPE_WORDS[arm.kind],
        "lengths": _length_rows(arm),
        "zero": number_literals(robot.zero),
        "limits": [number_literals(row) for row in robot.limits],
        "slides": np.where(robot.sliding, 1, 0).tolist(),
        "sliding": [name for name, slides in zip(robot.axes, robot.sliding, strict=True) if slides],
        "coupling": number_literal(robot.coupling),
        "placed": _PlacedArm(arm) if isinstance(arm, Placed) else None,
        "turning": turning,
        "turns": robot.counts == "turns",
        "closing": number_literal(CLOSING),
        "angle": number_literal(arm.angle),
        "boundary": number_literal(BOUNDARY),
        "limit_tolerance": number_literal(LIMIT_TOLERANCE),
        "in_line": number_literal(WRIST_IN_LINE),
        "on_axis": number_literal(ON_AXIS_1),
    }


BRANCH_WORDS: Final = {
    SixAxis.kind: "4 * back + 2 * lower + flip, lower: the forearm is bent backwards",
    FiveAxis.kind: "2 * back + lower, lower: the forearm is bent backwards",
    Scara.kind: "0 has the elbow right (J2 below 0), 1 left",
}
"""Kind of arm → what the number of a branch says."""
SHAPE_WORDS: Final = {
    SixAxis.kind: "wrist behind axis 1, elbow down, wrist flipped",
    FiveAxis.kind: "wrist behind axis 1, elbow down, and 1",
    Scara.kind: "elbow left, 1, and 1",
}
"""Kind of arm → what the first three numbers of a configuration say."""
LENGTH_WORDS: Final = {
    "d1": "floor to axis 2",
    "a1": "axis 1 to axis 2, forward",
    "a2": "axis 2 to axis 3",
    "a3": "axis 3 to the axis of the forearm, forward",
    "d4": "axis 3 to the wrist centre along the forearm",
    "d6": "wrist centre to the flange",
}
OPTIONAL_LENGTHS: Final = frozenset({"a1", "a3"})
"""Lengths that are 0 of every arm of five axes."""


def _length_rows(arm: SixAxis | FiveAxis | Scara | Placed) -> list[tuple[str, str, str]]:
    """Name, value and words of each length."""
    if isinstance(arm, Scara):
        links = (arm.l1, "axis 1 to axis 2"), (arm.l2, "axis 2 to axes 3 and 4")
        return [(f"l{i}", number_literal(value), said) for i, (value, said) in enumerate(links, 1)]
    some = [
        name
        for name in LENGTH_WORDS
        if not (isinstance(arm, FiveAxis) and name in OPTIONAL_LENGTHS)
    ]
    return [(name, number_literal(getattr(arm.lengths, name)), LENGTH_WORDS[name]) for name in some]
