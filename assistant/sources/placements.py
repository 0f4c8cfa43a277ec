"""Where a drawing stands as a command line says it, instead of its process file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused, error, info
from assistant.program import settings_tables
from assistant.program.geometry import Pose
from assistant.program.settings_tables import shown
from assistant.sources.process.placing import ONE_PLACEMENT, placement_by_marks

PLACED_BY_OPTIONS = info(
    "CT365",
    "the drawing is placed as the command line says, not as [placement] of the process file does",
    "leave out --place and --mark to have it as the file says",
)
PLACEMENT_WITHOUT_NUMBERS = error("CT366", "`{text}` says no {what}", "write {cure}")
THREE_MARKS = error(
    "CT367",
    "three marks place a drawing, and --mark was given {count} times",
    "give --mark three times",
)
NOT_A_DRAWING = error(
    "CT368",
    "`{name}` is no drawing, so it cannot be placed: it says itself where everything is",
    "leave out [placement], --place and --mark, and move it by a frame",
)

DRAWING_SUFFIXES: Final = (".dxf",)
"""Sources that do not say where they stand."""


@dataclass(frozen=True, slots=True)
class DrawingPlacement:
    """pose: the drawing's world in the default frame. findings: what is said of it."""

    pose: Pose
    findings: tuple[Diagnostic, ...] = ()


def check_drawn(source: FilePath) -> None:
    """Raises Refused (exit status 2) for a source that says itself where it stands."""
    if source.suffix.lower() not in DRAWING_SUFFIXES:
        raise Refused(NOT_A_DRAWING(path=str(source), name=shown(source.name)), exit_status=2)


def placement_of_options(place: str | None, marks: Sequence[str]) -> DrawingPlacement | None:
    """What `--place X,Y,Z,A,B,C` or three `--mark X,Y=X,Y,Z` say, None for neither.

    Raises Refused (exit status 2) for what says no place.
    """
    if place is None and not marks:
        return None
    if place is not None and marks:
        raise Refused(ONE_PLACEMENT(what="both --place and --mark are given"), exit_status=2)
    if place is not None:
        numbers = _option_numbers(
            place, "place of a drawing", (3, 4, 6), "X,Y,Z, X,Y,Z,TURN or X,Y,Z,A,B,C"
        )
        position = settings_tables.position(numbers[:3])
        angles = [*numbers[3:], 0.0, 0.0, 0.0][:3]
        return DrawingPlacement(Pose(position, settings_tables.euler_zyx(angles)))
    if len(marks) != 3:
        raise Refused(THREE_MARKS(count=len(marks)), exit_status=2)
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
            PLACEMENT_WITHOUT_NUMBERS(text=shown(mark), what="mark", cure=cure), exit_status=2
        )
    one = _option_numbers(drawn, "mark", (2, 3), cure)
    return [*one, 0.0][:3], _option_numbers(taught, "mark", (3,), cure)


def _option_numbers(text: str, what: str, counts: Sequence[int], cure: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(abs(n) <= settings_tables.LARGEST for n in numbers):
        raise Refused(
            PLACEMENT_WITHOUT_NUMBERS(text=shown(text), what=what, cure=cure), exit_status=2
        )
    return numbers
