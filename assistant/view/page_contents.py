"""The contents of a page: a program and its findings, with their lines and places in the cell.

`Shown` holds what a page shows. A finding is in the list, at its line of the text, and where the
target or contact that it is about is in the cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    Neighbours,
    NumberedMove,
    PathRow,
    Several,
    SomeTargets,
)
from assistant.base.source_text import visible
from assistant.cell.clearances import Closeness
from assistant.cell.collision.model import Carriers
from assistant.cell.scene import CORE_SUFFIX, PlacedRobot, Scene
from assistant.compiler.source_map import Places
from assistant.program.expressions import Expression, Name
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import Program
from assistant.program.statements import Follow, Move, MoveCircular
from assistant.report.contour_plot import DrawnLine
from assistant.report.track import Stop, stops
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing import Simulation
from assistant.view.motion import MOST_MOVES, Motion, Moves, Record, StillMotion, StillMoves
from assistant.view.side_by_side import SideBySide

Marked = tuple[Diagnostic, Closeness | None]
"""A finding, and where in the scene it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """Contents of a page.

    solution: of the program, simulated on `placed`, one of the robots of the scene; the others are
    at home. None for both if no arm runs it: then `program` is drawn as it is, with `placed`, or
    alone without it. places: of the program's texts. findings: in the order of the list. drawn:
    lines of its drawing. live: the name of the controller that the page follows, None for none.
    program: drawn without an arm. notes: sentences below the title. beside: the text that it was
    made of, line by line. told, spans: the program of the findings, and the places of its texts, if
    it is another. plan: seen from above and from the side at first.
    """

    title: str
    solution: SolvedProgram | None
    simulation: Simulation | None
    scene: Scene
    placed: PlacedRobot | None
    places: Places
    findings: Sequence[Marked] = ()
    drawn: Sequence[DrawnLine] = ()
    live: str | None = None
    program: Program | None = None
    notes: Sequence[str] = ()
    beside: SideBySide | None = None
    told: Program | None = None
    spans: Places | None = None
    plan: bool = False

    @property
    def is_bare(self) -> bool:
        """True if there is nothing to draw, as of a text that cannot be read."""
        bodies = any(True for _ in self.scene.all_bodies())
        return not (self.scene.robots or bodies or self.program or self.drawn)

    @property
    def base(self) -> Pose:
        """Pose of the program's robot base in the world."""
        return IDENTITY if self.placed is None else self.placed.base


_TargetName = tuple[str, str]
"""A kind and a name in lower case."""


class _LocatedTargets:
    """The targets of a program, by what findings call them.

    base: of the robot that runs it, in the world.
    """

    def __init__(self, program: Program | None, base: Pose = IDENTITY) -> None:
        self._base = base
        self._spans: dict[int, Floats] = {}
        self._numbers: dict[tuple[str, int], Floats] = {}
        self._paths: dict[str, Floats] = {}
        self._names: dict[str, Floats | None] = {}
        for stop in () if program is None else stops(program):
            self._add(stop)

    def of(self, finding: Diagnostic) -> list[float] | None:
        """(x, y, z) mm in the world, None where the finding is about no place, or about several
        of one name.
        """
        place = self._subject(finding.about)
        if place is None and finding.span is not None and finding.line is None:
            place = self._spans.get(finding.span.start)
        return None if place is None else self._base.moved(place[None])[0].tolist()

    def _add(self, stop: Stop) -> None:
        statement, places = stop.statement, stop.positions
        if statement.span is not None:
            self._spans.setdefault(statement.span.start, places[-1])
        if isinstance(statement, Follow):
            self._paths.setdefault(statement.path.name.lower(), places)
            return
        for number, place in zip(stop.numbers, places, strict=True):
            self._numbers[stop.procedure.lower(), number] = place
        for name, place in zip(_target_names(statement), places, strict=True):
            if name is not None:
                known = self._names.setdefault(name, place)
                if known is not None and abs(known - place).max() > 1e-3:
                    self._names[name] = None  # in several frames

    def _subject(self, about: object) -> Floats | None:
        match about:
            case PathRow(path=name, row=row):
                rows = self._paths.get(name.lower())
                return None if rows is None or not 0 < row <= len(rows) else rows[row - 1]
            case NumberedMove(number=number, procedure=name):
                return self._numbers.get((name.lower(), number))
            case Declared(name=name, table=None | "targets"):
                return self._names.get(name.lower())
            case SomeTargets(named=(first, *_)) | Several(parts=(first, *_)):
                return self._subject(first)
            case Neighbours(first=first):
                return self._subject(first)
        return None


def _target_names(statement: object) -> Iterator[str | None]:
    """The names of the targets of a move, None for one without."""
    targets: tuple[Expression, ...] = ()
    match statement:
        case Move(target=target):
            targets = (target,)
        case MoveCircular(via=via, target=target):
            targets = (via, target)
    for target in targets:
        yield target.name.lower() if isinstance(target, Name) else None


MOST_FINDINGS: Final = 500


def finding_records(
    shown: Shown, motion: Motion | StillMotion, moves: Moves | StillMoves, program: Program
) -> list[Record]:
    """The first of them. program: that is shown."""
    lines = _CountedLines(shown, moves)
    located = _LocatedTargets(shown.told or program, shown.base)
    return [
        _finding_record(shown, motion, moves, marked, lines, located)
        for marked in shown.findings[:MOST_FINDINGS]
    ]


class _CountedLines:
    """Lines of the texts of a page, counted through all of them, by file and line."""

    def __init__(self, shown: Shown, moves: Moves | StillMoves) -> None:
        self._moves: dict[int, int] = {}
        for number, one in enumerate(moves.records()):
            self._moves.setdefault(one["global"], number)
        self._own = _first_lines([(one.path, one.line_count) for one in shown.places.texts])
        beside = () if shown.beside is None else shown.beside.texts
        self._beside = _first_lines([(one.path, one.line_count) for one in beside])

    def of(self, finding: Diagnostic, own: bool) -> tuple[int, int]:
        """Return the finding's lines in the program and in its source; 0 for not in that text.

        own: it is about the program, not about its source.
        """
        first, other = (known.get(finding.path) for known in (self._own, self._beside))
        line = finding.line
        return (
            0 if first is None or line is None or not own else first + line - 1,
            0 if other is None or line is None else other + line - 1,
        )

    def move(self, line: int) -> int | None:
        """The motion statement that begins in a line of the program."""
        return self._moves.get(line) if line else None


def _first_lines(texts: list[tuple[str | None, int]]) -> dict[str | None, int]:
    found: dict[str | None, int] = {}
    first = 1
    for path, count in texts:
        found.setdefault(path, first)
        first += count
    return found


def _finding_record(
    shown: Shown,
    motion: Motion | StillMotion,
    moves: Moves | StillMoves,
    marked: Marked,
    lines: _CountedLines,
    located: _LocatedTargets,
) -> Record:
    finding, close = marked
    own = shown.spans is None or close is not None
    place = located.of(finding) if close is None else None
    placed = (shown.places if own else shown.spans or shown.places).finding(finding)
    line, beside = lines.of(placed, own)
    move = moves.of_finding(finding) if own and finding.line is None else lines.move(line)
    mark: Record | None = None
    if close is not None and isinstance(moves, Moves) and isinstance(motion, Motion):
        mark = _contact_record(shown, motion, close)
        move = moves.places.get((close.procedure, close.number))
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": visible(finding.message),
        "cure": None if finding.cure is None else visible(finding.cure),
        "where": visible(placed.where()),
        "move": move if move is not None and move < MOST_MOVES else None,
        "line": line,
        "beside": beside,
        "mark": mark,
        "at": place,
        "time": None if place is None else motion.passing(np.array(place)),
    }


def _contact_record(shown: Shown, motion: Motion, close: Closeness) -> Record:
    contact = close.contact
    at = _own_joints(shown, close.joints)
    return {
        "one": visible(contact.one.removesuffix(CORE_SUFFIX)),
        "other": visible(contact.other.removesuffix(CORE_SUFFIX)),
        "points": [list(point) for point in contact.points],
        "out": [0.0 - part for part in contact.normal],
        "deep": max(0.0, -min(close.least, contact.distance)),
        "joints": motion.robot.chained(at[None])[0].tolist(),
        "time": motion.when(at),
    }


def _own_joints(shown: Shown, joints: Floats) -> Floats:
    """Return the joints of the moving robot from a row of the joints of all robots."""
    carriers = Carriers(shown.scene.robots)
    at = next(i for i, one in enumerate(shown.scene.robots) if one is shown.placed)
    return joints[carriers.columns[at]]
