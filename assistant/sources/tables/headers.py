"""Names of table columns: what a column holds, its unit, its convention. Nothing is guessed.

| column | meaning |
|---|---|
| `name` | name of the target; without this column the rows are one path |
| `x_mm` `y_mm` `z_mm` | position; also `_cm`, `_m`, `_in` |
| `q_w` `q_x` `q_y` `q_z` | unit quaternion, also `qw` … `qz` |
| `euler_zyx_z_deg` `euler_zyx_y_deg` `euler_zyx_x_deg` | R = Rz·Ry·Rx, as OrientZYX and C, B, A |
| `euler_xyz_x_deg` … | R = Rx·Ry·Rz |
| `euler_zyz_z1_deg` `euler_zyz_y_deg` `euler_zyz_z2_deg` | R = Rz(1)·Ry·Rz(2) |
| `fixed_xyz_x_deg` …, `fixed_zyx_x_deg` … | turns about fixed axes, one after the other |
| `rotvec_x_deg` … | unit axis times angle |
| `j1_deg` … `j8_deg` | joint target; `_mm`, `_m` for linear joints; absent for no such joint |
| `e1_deg` or `e1_mm` … `e6_…` | external axes; an empty cell is an unused axis |
| `back` `down` `flip` `quadrant1` `quadrant4` `quadrant6` | arm branch; all six or none |
| `speed_mm_s` or `speed_m_s` | speed of the TCP; an empty cell is the default |
| `rotation_deg_s`, `joint_percent` | speed of reorientation, of joint moves |
| `blend_mm` | corner radius, 0 or `fine` to stop at the target |
| `tool`, `frame` | names from the process file |
| `motion` | `joint`, `linear`, `via` or `end` (a `via` row and the `end` row after it are an arc) |
| `wait_s`, `set_<signal>`, `comment` | of named rows: after, after, and before the move |
| `_…` | any column whose name begins with `_` is left out |

Every angle may be in `_rad` as well. Case and outer blanks do not matter.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Rule, Severity, error
from assistant.base.length_units import UNITS
from assistant.base.near_names import near_name, spelled_like
from assistant.program.motion import CONFIGURATION_COLUMNS

ERROR: Final = Severity.ERROR
UNKNOWN_COLUMN = error("TB101", "there is no column called {name}", "{cure}")
AMBIGUOUS_COLUMN = error("TB102", "the column {name} {why}", "write {proposals}")
_TWICE = error("TB103", "the columns {names} say the same thing", "keep one of them")
_MISSING_COLUMN = error("TB104", "the column {names} is missing", "{cure}")
_UNNAMED_COLUMN = error(
    "TB105",
    "column {number} has no name",
    "name it, or take away the delimiter at the end of the lines",
)
_NO_HEADER = error(
    "TB106",
    "the first line names no columns",
    'write a line above it that does, such as `{example}` (numpy.savetxt: with comments="")',
)
_TWO_ORIENTATIONS = error("TB107", "the orientation is given twice, by {names}", "keep one of them")
_NEEDS_NAMES = error(
    "TB108", "the column {name} needs named rows", "add a `name` column, or leave it out"
)

MORE_UNKNOWN = error(
    "TB109",
    "{count} more columns have names that are not known, the first is {name}",
    "put `_` before the names of columns that are not for the robot",
)

_LENGTHS: Final = {unit: UNITS[unit][1] for unit in ("mm", "cm", "m", "in")}
_ANGLES: Final = {"deg": 1.0, "rad": math.degrees(1.0)}
ORIENTATIONS: Final = ("quaternion", "euler_zyx", "euler_xyz", "euler_zyz", "rotvec")
MOST_JOINTS: Final = 8
_MOST_UNKNOWN: Final = 10
"""Largest number of unknown columns with a finding each; the nearest name is searched among all."""
_AFTER_MOVE: Final = ("wait", "set", "comment")
_EXAMPLE: Final = "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z"


@dataclass(frozen=True, slots=True)
class Column:
    """Content of a column.

    group: quantity it is a part of; part: which part, from 0. factor: to mm, degrees, mm/s. detail:
    name of the signal of a `set_…` column.
    """

    group: str
    part: int = 0
    factor: float = 1.0
    detail: str = ""


@dataclass(frozen=True, slots=True)
class Problem:
    """A rule that a header breaks; index: of the column at which to look."""

    rule: Rule
    index: int
    fields: dict[str, Any]


def columns_of(names: Sequence[str]) -> tuple[list[Column], list[Problem]]:
    """The meaning of each column of a header, and what is wrong with the header."""
    if all(_NUMBER.fullmatch(name.strip()) for name in names):
        return [], [Problem(_NO_HEADER, 0, {"example": _EXAMPLE})]
    columns, problems, unknown = [], [], []
    for index, given in enumerate(names):
        column, problem = _column(index, given)
        columns.append(column or Column("unknown"))
        problems += [problem] if problem else []
        unknown += [index] if column is None and problem is None else []
    problems += [_unknown(index, names[index]) for index in unknown[:_MOST_UNKNOWN]]
    if more := unknown[_MOST_UNKNOWN:]:
        fields = {"count": len(more), "name": shown(names[more[0]])}
        problems.append(Problem(MORE_UNKNOWN, more[0], fields))
    problems.sort(key=lambda problem: problem.index)
    problems += _repeated(names, columns)
    if not problems:
        problems += _incomplete(names, columns)
    return columns, problems


def shown(text: str, most: int = 40) -> str:
    """Text from a file as a message may show it: on one line, not too long, marked."""
    cut = text if len(text) <= most else text[: most - 1] + "…"
    return f"`{cut}`" if cut.isprintable() and "`" not in cut else ascii(cut)


_NUMBER: Final = re.compile(r'"?[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?"?')


def _known() -> Iterator[tuple[str, Column]]:
    for name in ("name", "tool", "frame", "motion", "comment"):
        yield name, Column(name)
    for part, axis in enumerate("xyz"):
        for unit, factor in _LENGTHS.items():
            yield f"{axis}_{unit}", Column("position", part, factor)
        for unit, factor in _ANGLES.items():
            yield f"rotvec_{axis}_{unit}", Column("rotvec", part, factor)
    for part, axis in enumerate("wxyz"):
        yield f"q_{axis}", Column("quaternion", part)
        yield f"q{axis}", Column("quaternion", part)
    for unit, factor in _ANGLES.items():
        for order in ("zyx", "xyz"):
            for part, axis in enumerate(order):
                group = f"euler_{order}"
                yield f"euler_{order}_{axis}_{unit}", Column(group, part, factor)
                # turns about fixed axes are the turns about moving ones in reverse order
                yield f"fixed_{order[::-1]}_{axis}_{unit}", Column(group, part, factor)
        for part, axis in enumerate(("z1", "y", "z2")):
            yield f"euler_zyz_{axis}_{unit}", Column("euler_zyz", part, factor)
    either = {"deg": 1.0, "rad": _ANGLES["rad"], "mm": 1.0, "m": 1000.0}
    for unit, factor in either.items():
        for part in range(MOST_JOINTS):
            yield f"j{part + 1}_{unit}", Column("joints", part, factor)
        for part in range(6):
            yield f"e{part + 1}_{unit}", Column("external", part, factor)
    for part, name in enumerate(CONFIGURATION_COLUMNS):
        yield name, Column("configuration", part)
    yield "speed_mm_s", Column("speed")
    yield "speed_m_s", Column("speed", 0, 1000.0)
    yield "rotation_deg_s", Column("rotation")
    yield "joint_percent", Column("joint")
    yield "blend_mm", Column("blend")
    yield "wait_s", Column("wait")


KNOWN: Final[dict[str, Column]] = dict(_known())
"""Every column name but those of signals, with its meaning."""

_TURN = (
    "names no convention",
    "`euler_zyx_{axis}_{unit}` (R = Rz·Ry·Rx), `euler_xyz_{axis}_{unit}` (R = Rx·Ry·Rz) "
    "or `rotvec_{axis}_{unit}` (axis times angle)",
)
_NO_UNIT = "names no unit"
_PART_OR_JOINT = "may be a part of a quaternion or a joint"
_AMBIGUOUS: Final = tuple(
    (re.compile(pattern), why, proposals)
    for pattern, why, proposals in (
        (r"(?P<axis>[xyz])", _NO_UNIT, "`{axis}_mm` or `{axis}_m`"),
        (r"(?:r|rot_?|euler_?)(?P<axis>[xyz])(?:_(?P<unit>deg|rad))?", *_TURN),
        (r"(?P<axis>roll|pitch|yaw)(?:_(?P<unit>deg|rad))?", *_TURN),
        (r"(?P<axis>[abc])(?:_(?P<unit>deg|rad))?", *_TURN),
        (r"q(?P<axis>[1-4])", _PART_OR_JOINT, "`q_w`, `q_x`, `q_y`, `q_z` or `j{axis}_deg`"),
        (r"q0", _PART_OR_JOINT, "`q_w`, `q_x`, `q_y`, `q_z` or `j1_deg`"),
        (r"(?:j|joint_?|axis_?|a)(?P<axis>[1-8])", _NO_UNIT, "`j{axis}_deg` or `j{axis}_rad`"),
        (r"(?:e|eax_?|ext_?)(?P<axis>[1-6])", _NO_UNIT, "`e{axis}_mm` or `e{axis}_deg`"),
        (
            r"(?P<axis>(?:euler|fixed)_[xyz]{3}_[xyz][12]?|rotvec_[xyz])",
            _NO_UNIT,
            "`{axis}_deg` or `{axis}_rad`",
        ),
        (r"(?:speed|v|vel|velocity|feed)", _NO_UNIT, "`speed_mm_s` or `speed_m_s`"),
        (r"(?:blend|zone|radius)", _NO_UNIT, "`blend_mm`"),
        (r"(?:wait|delay|dwell)", _NO_UNIT, "`wait_s`"),
    )
)
"""Pattern of a tempting name, what it leaves open, and the full names to choose from."""

_AXIS_OF: Final = {"roll": "x", "pitch": "y", "yaw": "z", "a": "x", "b": "y", "c": "z"}


def _column(index: int, given: str) -> tuple[Column | None, Problem | None]:
    """Return the content of a column, or the fault of its name; neither for a name that is
    unknown.
    """
    name = given.strip().lower()
    if not name:
        return None, Problem(_UNNAMED_COLUMN, index, {"number": index + 1})
    if name.startswith("_"):
        return Column("left out", index), None
    if name.startswith("set_") and len(name) > len("set_"):
        return Column("set", detail=given.strip()[len("set_") :]), None
    if name in KNOWN:
        return KNOWN[name], None
    for pattern, why, proposals in _AMBIGUOUS:
        if match := pattern.fullmatch(name):
            found = {key: value for key, value in match.groupdict().items() if value}
            axis = found.get("axis", "")
            fields = {"axis": _AXIS_OF.get(axis, axis), "unit": found.get("unit", "deg")}
            offered = proposals.format(**fields)
            return None, Problem(
                AMBIGUOUS_COLUMN, index, {"name": shown(given), "why": why, "proposals": offered}
            )
    return None, None


def _unknown(index: int, given: str) -> Problem:
    near = near_name(given.strip(), KNOWN)
    cure = f"did you mean `{near}`? " if near else "docs/tables.md lists the columns; "
    cure += "put `_` before the name of a column that is not for the robot"
    return Problem(UNKNOWN_COLUMN, index, {"name": shown(given), "cure": cure})


def _repeated(names: Sequence[str], columns: Sequence[Column]) -> Iterator[Problem]:
    seen: dict[tuple[str, int, str], int] = {}
    for index, column in enumerate(columns):
        if column.group == "unknown":
            continue
        first = seen.setdefault((column.group, column.part, column.detail.lower()), index)
        if first != index:
            both = f"{shown(names[first])} and {shown(names[index])}"
            yield Problem(_TWICE, index, {"names": both})


def _incomplete(names: Sequence[str], columns: Sequence[Column]) -> Iterator[Problem]:
    groups = {column.group: index for index, column in reversed(list(enumerate(columns)))}
    orientations = [group for group in ORIENTATIONS if group in groups]
    if len(orientations) > 1:
        both = " and ".join(shown(names[groups[group]]) for group in orientations)
        yield Problem(_TWO_ORIENTATIONS, groups[orientations[1]], {"names": both})
        return
    if "name" not in groups:
        for group in _AFTER_MOVE:
            if group in groups:
                index = groups[group]
                yield Problem(_NEEDS_NAMES, index, {"name": shown(names[index])})
    for group, size in (("position", 3), ("configuration", 6), *((o, 3) for o in orientations)):
        if group in groups:
            parts = 4 if group == "quaternion" else size
            missing = set(range(parts)) - {c.part for c in columns if c.group == group}
            if missing:
                wanted = ", ".join(f"`{_sibling(names, columns, group, p)}`" for p in missing)
                yield Problem(
                    _MISSING_COLUMN,
                    groups[group],
                    {"names": wanted, "cure": "add it to the header"},
                )
    if "position" in groups and not orientations:
        yield Problem(
            _MISSING_COLUMN,
            groups["position"],
            {
                "names": "of the orientation",
                "cure": "add `q_w`, `q_x`, `q_y`, `q_z`, or `euler_zyx_z_deg`, "
                "`euler_zyx_y_deg`, `euler_zyx_x_deg`",
            },
        )
    if "position" not in groups and (orientations or "joints" not in groups):
        needed = "`x_mm`, `y_mm`, `z_mm`"
        cure = "add it, or `j1_deg`, `j2_deg` … for joint targets"
        yield Problem(_MISSING_COLUMN, 0, {"names": needed, "cure": cure})


def _sibling(names: Sequence[str], columns: Sequence[Column], group: str, part: int) -> str:
    """The name of a missing part, spelled as the parts that are there."""
    there = next(n.strip().lower() for n, c in zip(names, columns, strict=True) if c.group == group)
    choices = [name for name, c in KNOWN.items() if c.group == group and c.part == part]
    return spelled_like(there, choices, 1, least=0.0)[0]
