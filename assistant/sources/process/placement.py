"""Placement of a drawing: by position and rotation, or by three marks taught in the cell.

A process file states it, or the command line instead (`--place`, `--mark`). Marks are used as
controllers define frames: the first is the origin, the second is on the x axis, the third on the
side of y. The drawing and the cell each have such a frame, and the drawing is moved, never
stretched, so that one frame coincides with the other; the misfit of the marks is reported. mm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule, error, info
from assistant.program import settings_tables
from assistant.program.geometry import Pose
from assistant.program.settings_tables import Read, Wrong, kind_of, shown

_MARKS_MISFIT = error(
    "CT360",
    "the marks do not fit: mark {mark} would come {misfit:.2f} mm from where it was taught, "
    "and {most:g} mm are allowed; {lengths}",
    "teach the marks again, look at the unit of the drawing, or allow it: `misfit` {wanted:g}",
)
_MARKS_ON_A_LINE = error(
    "CT361",
    "the three marks of {where} lie on one line or too near to each other: {reason}",
    "take three marks that are well apart and not in a row",
)
_TURNED_OVER = error(
    "CT362",
    "the marks turn the drawing over: what is above it would be below",
    "see that the marks of `drawing` and of `cell` are in the same order; a part that does lie on "
    "its face is placed by `position` and `euler_zyx`",
)
ONE_PLACEMENT = error(
    "CT363",
    "{what}",
    "give `position` and `euler_zyx` or `quaternion`, or three marks as `drawing` and `cell`",
)
_PLACED_BY_MARKS = info(
    "CT364",
    "the drawing stands at {position}, turned by {angles} degrees about z, y, x; its marks fit "
    "within {misfit:.2f} mm",
)
MOST_MISFIT: Final = 1.0
"""mm that a mark may be off where the file does not say: what a careful hand teaches."""
_LEAST_MARK_DISTANCE: Final = 1.0
"""mm that marks have to be apart, and the third one from the line through the others."""
_LEAST_MARK_SINE: Final = 0.05
"""Sine of the least angle at the first mark: below 3 degrees a mistake of the third turns all."""


def _read_mark(value: Any) -> tuple[float, ...]:
    """Two or three numbers; in the plane of the drawing z is 0."""
    if isinstance(value, list) and len(value) == 2:
        value = [*value, 0.0]
    return settings_tables.position(value)


def _read_marks(value: Any) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list):
        raise Wrong(f"is {kind_of(value)}", "write three points: [[0, 0], [100, 0], [0, 50]]")
    if len(value) != 3:
        raise Wrong(f"has {len(value)} marks", "give three")
    found = []
    for number, one in enumerate(value, 1):
        try:
            found.append(_read_mark(one))
        except Wrong as wrong:
            raise Wrong(f"{wrong.what} in mark {number}", wrong.cure) from None
    return tuple(found)


PLACEMENT_KEYS: Final[Mapping[str, Read]] = {
    "position": settings_tables.position,
    "quaternion": settings_tables.quaternion,
    "euler_zyx": settings_tables.euler_zyx,
    "drawing": _read_marks,
    "cell": _read_marks,
    "misfit": settings_tables.number("mm", above=0.0, most=100.0),
}
"""Keys of [placement]."""


def placement_fault(given: Mapping[str, Any]) -> str | None:
    """Return the fault of the keys of a placement that are given together."""
    marks, pose = {"drawing", "cell"} & given.keys(), {"position", "quaternion", "euler_zyx"}
    if marks and pose & given.keys():
        return "the drawing is placed in two ways"
    if len(marks) == 1:
        (there,) = marks
        return f"`{there}` gives marks, but not where they are in the other place"
    if "misfit" in given and not marks:
        return "`misfit` is of marks, and there are none"
    return None


@dataclass(frozen=True, slots=True)
class MarkPlacement:
    """pose: the drawing's world in the frame that marks were taught in; None if they are wrong.

    rule, fields: the finding about it.
    """

    pose: Pose | None
    rule: Rule
    fields: Mapping[str, Any]


def placement_by_marks(
    drawing: Sequence[Sequence[float]], cell: Sequence[Sequence[float]], most: float = MOST_MISFIT
) -> MarkPlacement:
    """Place a drawing by three marks. drawing, cell: (3, 3) mm. most: mm that a mark may be off."""
    drawn, taught = np.array(drawing, dtype=np.float64), np.array(cell, dtype=np.float64)
    for where, marks in (("drawing", drawn), ("cell", taught)):
        reason = _marks_fault(marks)
        if reason is not None:
            return MarkPlacement(None, _MARKS_ON_A_LINE, {"where": f"`{where}`", "reason": reason})
    placed = _frame_of_marks(taught) @ _frame_of_marks(drawn).inverse()
    off = np.linalg.norm(placed.moved(drawn) - taught, axis=1)
    worst = int(off.argmax())
    misfit = float(off[worst])
    if misfit > most:
        wanted, lengths = math.ceil(misfit * 10.0) / 10.0, _mark_distances(drawn, taught)
        fields = {"mark": worst + 1, "misfit": misfit, "most": most, "wanted": wanted}
        return MarkPlacement(None, _MARKS_MISFIT, {**fields, "lengths": lengths})
    if rotations.rotate(np.array(placed.quaternion), np.array([0.0, 0.0, 1.0]))[2] < 0.0:
        return MarkPlacement(None, _TURNED_OVER, {})
    angles = rotations.to_euler(np.array(placed.quaternion), "ZYX") + 0.0
    at = {
        "position": _numbers_text(placed.position),
        "angles": _numbers_text(angles),
        "misfit": misfit,
    }
    return MarkPlacement(placed, _PLACED_BY_MARKS, at)


def _marks_fault(marks: Floats) -> str | None:
    """Why marks are too near to each other, or to one line, to tell how something is turned."""
    along, aside = marks[1] - marks[0], marks[2] - marks[0]
    sides = (along, aside, marks[2] - marks[1])
    if min(float(np.linalg.norm(side)) for side in sides) < _LEAST_MARK_DISTANCE:
        return "two of them are one place"
    away = float(np.linalg.norm(np.cross(along, aside)) / np.linalg.norm(along))
    if away < max(_LEAST_MARK_DISTANCE, _LEAST_MARK_SINE * float(np.linalg.norm(aside))):
        return f"the third is {away:.2f} mm from the line through the others"
    return None


def _frame_of_marks(marks: Floats) -> Pose:
    """The right-handed frame of an origin, a point on its x axis and one on the side of its y."""
    along, normal = marks[1] - marks[0], np.cross(marks[1] - marks[0], marks[2] - marks[0])
    x, z = along / np.linalg.norm(along), normal / np.linalg.norm(normal)
    turn = rotations.from_matrix(np.column_stack([x, np.cross(z, x), z]))
    return Pose.of(marks[0], turn)


def _mark_distances(drawn: Floats, taught: Floats) -> str:
    """Describe the distances between the marks, drawn and taught."""
    said = []
    for one, other in ((0, 1), (0, 2), (1, 2)):
        here, there = (float(np.linalg.norm(m[one] - m[other])) for m in (drawn, taught))
        said.append(f"{one + 1} to {other + 1} is {here:.2f} mm drawn, {there:.2f} mm taught")
    return "; ".join(said)


def _numbers_text(numbers: Sequence[float] | Floats) -> str:
    return "[" + ", ".join(f"{round(float(n), 3) + 0.0:g}" for n in numbers) + "]"


PLACED_BY_OPTIONS = info(
    "CT365",
    "the drawing is placed as the command line says, not as [placement] of the process file does",
    "leave out --place and --mark to have it as the file says",
)
_PLACEMENT_WITHOUT_NUMBERS = error("CT366", "`{text}` says no {what}", "write {cure}")
_THREE_MARKS = error(
    "CT367",
    "three marks place a drawing, and --mark was given {count} times",
    "give --mark three times",
)
_NOT_A_DRAWING = error(
    "CT368",
    "`{name}` is no drawing, so it cannot be placed: it says itself where everything is",
    "leave out [placement], --place and --mark, and move it by a frame",
)

DRAWING_SUFFIXES: Final = (".dxf",)
"""Sources that do not say where they stand."""


@dataclass(frozen=True, slots=True)
class DrawingPlacement:
    """Placement of a drawing. pose: the drawing's world in the default frame. findings: findings
    about it.
    """

    pose: Pose
    findings: tuple[Diagnostic, ...] = ()


def check_drawn(source: FilePath) -> None:
    """Raises Refused (exit status 2) for a source that says itself where it stands."""
    if source.suffix.lower() not in DRAWING_SUFFIXES:
        raise Refused(_NOT_A_DRAWING(path=str(source), name=shown(source.name)), exit_status=2)


def placement_of_options(place: str | None, marks: Sequence[str]) -> DrawingPlacement | None:
    """Return the placement of `--place X,Y,Z,A,B,C` or three `--mark X,Y=X,Y,Z`, None if neither is
    given.

    Raises Refused (exit status 2) if they do not state a placement.
    """
    if place is None and not marks:
        return None
    if place is not None and marks:
        raise Refused(ONE_PLACEMENT(what="both --place and --mark are given"), exit_status=2)
    if place is not None:
        numbers = option_numbers(
            place, "place of a drawing", (3, 4, 6), "X,Y,Z, X,Y,Z,TURN or X,Y,Z,A,B,C"
        )
        position = settings_tables.position(numbers[:3])
        angles = [*numbers[3:], 0.0, 0.0, 0.0][:3]
        return DrawingPlacement(Pose(position, settings_tables.euler_zyx(angles)))
    if len(marks) != 3:
        raise Refused(_THREE_MARKS(count=len(marks)), exit_status=2)
    pairs = [_mark_pair(mark) for mark in marks]
    placed = placement_by_marks([pair[0] for pair in pairs], [pair[1] for pair in pairs])
    said = placed.rule(**placed.fields)
    if placed.pose is None:
        raise Refused(said, exit_status=2)
    return DrawingPlacement(placed.pose, (said,))


def _mark_pair(mark: str) -> tuple[list[float], list[float]]:
    drawn, equals, taught = mark.partition("=")
    cure = "X,Y=X,Y,Z: where the mark is in the drawing, and where it was taught"
    if not equals:
        raise Refused(
            _PLACEMENT_WITHOUT_NUMBERS(text=shown(mark), what="mark", cure=cure), exit_status=2
        )
    one = option_numbers(drawn, "mark", (2, 3), cure)
    return [*one, 0.0][:3], option_numbers(taught, "mark", (3,), cure)


def option_numbers(text: str, what: str, counts: Sequence[int], cure: str) -> list[float]:
    """Numbers between commas, as many as one of the counts. Raises Refused (exit status 2)."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(abs(n) <= settings_tables.LARGEST for n in numbers):
        raise Refused(
            _PLACEMENT_WITHOUT_NUMBERS(text=shown(text), what=what, cure=cure), exit_status=2
        )
    return numbers
