"""Where in the cell the targets are that findings are about."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.base.arrays import Floats
from assistant.base.diagnostics import (
    Declared,
    Diagnostic,
    Neighbours,
    NumberedMove,
    PathRow,
    Several,
    SomeTargets,
)
from assistant.program.expressions import Expression, Name
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.program import Program
from assistant.program.statements import Follow, Move, MoveCircular
from assistant.report.track import Stop, stops

TargetName = tuple[str, str]
"""A kind and a name in lower case."""


class LocatedTargets:
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
