"""Generate source code: the kinematics of an arm in C or Python, without any dependency.

Forward kinematics, all branches of the inverse, the Jacobian and configurations come from templates
of jinja2, which is loaded when a template is used. A table of joints with their poses,
configurations, Jacobians and branches tests the source.
"""

from __future__ import annotations

import keyword
import math
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.blocks import rules
from assistant.program.geometry import Pose
from assistant.resources import resource
from assistant.robots import Robot
from assistant.robots.arms import FiveAxis, Placed, Scara, SixAxis
from assistant.robots.arms.arm import BOUNDARY, CLOSING
from assistant.robots.arms.closed_form import ON_AXIS_1, WRIST_IN_LINE
from assistant.robots.configurations import QUADRANTS
from assistant.robots.motion.singularities import distance_from_singularity
from assistant.robots.robot import LIMIT_TOLERANCE

if TYPE_CHECKING:
    from jinja2 import Environment


_VECTOR_ROWS: Final = 200
_VECTOR_SEED: Final = 22
_LEAST_FROM_SINGULARITY: Final = 0.02
"""Least distance of the rows from a singularity, in the measure of `away`: closer to one, the
rounding of a pose turns joints by more than the test allows.
"""
_DRAWING_ROUNDS: Final = 100
"""Times that four times as many joints are drawn as rows are wanted."""


def _vectors_csv(robot: Robot, rows: int = _VECTOR_ROWS) -> bytes:
    """A CSV with a row of names, then joints at random inside the limits and what is of them.

    There are fewer rows where hardly any joints are away from singularities; raises Refused where
    none are.
    """
    columns = np.hstack(list(_vector_columns(robot, _random_joints(robot, rows))))
    names = ",".join(_column_names(robot))
    lines = [",".join(map(repr, row)) for row in columns.tolist()]
    return "\n".join([names, *lines, ""]).encode()


def _random_joints(robot: Robot, rows: int) -> Floats:
    """(rows, a) at most, the same ones of each robot, none of them near a singularity."""
    random, (low, high) = np.random.default_rng(_VECTOR_SEED), robot.limits.T
    found = np.empty((0, len(low)))
    for _ in range(_DRAWING_ROUNDS):
        if len(found) >= rows:
            break
        more = random.uniform(low, high, (4 * rows, len(low)))
        found = np.concatenate(
            [found, more[distance_from_singularity(robot, more) > _LEAST_FROM_SINGULARITY]]
        )
    if not len(found):
        raise Refused(rules.ALWAYS_SINGULAR(title=robot.title))
    return found[:rows]


def _vector_columns(robot: Robot, joints: Floats) -> Iterator[Floats]:
    n = len(joints)
    p, q = robot.flange_poses(joints)
    yield from (joints, p, q, robot.configuration(joints).astype(np.float64))
    yield robot.jacobian(joints, unit="deg").reshape(n, -1)
    branches, valid = robot.ik(p, q)
    yield np.concatenate([branches, valid[..., None]], axis=2).reshape(n, -1)


def _column_names(robot: Robot) -> list[str]:
    axes = list(robot.axes)
    pose = ["x", "y", "z", "qw", "qx", "qy", "qz"]
    sides = ["side_1", "side_2", "side_3", "quarter_J1", "quarter_J4", "quarter_J6"]
    rates = [f"d{row}/d{axis}" for row in ("x", "y", "z", "rx", "ry", "rz") for axis in axes]
    branches = [
        f"branch_{branch}_{of}" for branch in range(robot.branches) for of in (*axes, "valid")
    ]
    return [*axes, *pose, *sides, *rates, *branches]


_LONGEST_NAME: Final = 40
"""Characters of a name that a file of the user's gives to what is generated."""
_LONGEST_WORDS: Final = 120
"""Characters of text from such a file that are copied into a comment."""


@cache
def template_environment() -> Environment:
    """Templates of our own, which are named by their places below `templates/`."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    def text(name: str) -> str:
        return resource("templates", name).read_text(encoding="utf-8")

    return Environment(  # noqa: S701 - C, Python and XML: each value is written by a function here
        loader=FunctionLoader(text),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def number_literal(value: float) -> str:
    """A finite float as C, Python and XML read it, to the last digit."""
    if not math.isfinite(value):
        raise ValueError(f"{value} is no number of a source")
    return repr(float(value) + 0.0)


def number_literals(values: Iterable[float]) -> tuple[str, ...]:
    """Each of them by `number_literal`."""
    return tuple(number_literal(value) for value in values)


def safe_text(text: str) -> str:
    """Text of the user's for a comment or a string: nothing in it can end one or begin another."""
    plain = "".join(c if c.isascii() and (c.isalnum() or c in " -_.,()/+") else " " for c in text)
    return re.sub(r"/+", "/", " ".join(plain.split()))[:_LONGEST_WORDS].strip() or "an arm"


def source_identifier(text: str) -> str:
    """Text of the user's as the name of a module and the beginning of names: `rv_2aj`."""
    plain = re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:_LONGEST_NAME].strip("_")
    if not plain or not plain[0].isalpha():
        plain = f"arm_{plain}".strip("_")
    if keyword.iskeyword(plain) or plain in sys.stdlib_module_names or plain in _RESERVED_NAMES:
        plain += "_arm"
    return plain


_RESERVED_NAMES: Final = frozenset(
    {"con", "prn", "aux", "nul", "std"}
    | {f"{port}{number}" for port in ("com", "lpt") for number in range(1, 10)}
)
"""Names of devices, which no file of Windows may have."""


Language = Literal["c", "python"]


@dataclass(frozen=True, slots=True)
class SourceNames:
    """Names in the source of an arm.

    stem: of its files. prefix: of its functions, followed by a `_`.
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
    vectors = _vectors_csv(robot)
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
    """Joint counting, base and flange of a robot file's closed form, as literals."""

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
    """Return the values of a robot for the templates."""
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
        "branch_words": _BRANCH_WORDS[arm.kind],
        "shape_words": _SHAPE_WORDS[arm.kind],
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


_BRANCH_WORDS: Final = {
    SixAxis.kind: "4 * back + 2 * lower + flip, lower: the forearm is bent backwards",
    FiveAxis.kind: "2 * back + lower, lower: the forearm is bent backwards",
    Scara.kind: "0 has the elbow right (J2 below 0), 1 left",
}
"""Kind of arm → what the number of a branch says."""
_SHAPE_WORDS: Final = {
    SixAxis.kind: "wrist behind axis 1, elbow down, wrist flipped",
    FiveAxis.kind: "wrist behind axis 1, elbow down, and 1",
    Scara.kind: "elbow left, 1, and 1",
}
"""Kind of arm → what the first three numbers of a configuration say."""
_LENGTH_WORDS: Final = {
    "d1": "floor to axis 2",
    "a1": "axis 1 to axis 2, forward",
    "a2": "axis 2 to axis 3",
    "a3": "axis 3 to the axis of the forearm, forward",
    "d4": "axis 3 to the wrist centre along the forearm",
    "d6": "wrist centre to the flange",
}
_OPTIONAL_LENGTHS: Final = frozenset({"a1", "a3"})
"""Lengths that are 0 of every arm of five axes."""


def _length_rows(arm: SixAxis | FiveAxis | Scara | Placed) -> list[tuple[str, str, str]]:
    """Name, value and words of each length."""
    if isinstance(arm, Scara):
        links = (arm.l1, "axis 1 to axis 2"), (arm.l2, "axis 2 to axes 3 and 4")
        return [(f"l{i}", number_literal(value), said) for i, (value, said) in enumerate(links, 1)]
    some = [
        name
        for name in _LENGTH_WORDS
        if not (isinstance(arm, FiveAxis) and name in _OPTIONAL_LENGTHS)
    ]
    return [
        (name, number_literal(getattr(arm.lengths, name)), _LENGTH_WORDS[name]) for name in some
    ]
