"""A program that no arm goes through on the page: as its robot is not told, or cannot run it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic
from assistant.base.source_text import visible
from assistant.compiler.source_map import Places
from assistant.program.geometry import Pose
from assistant.program.motion import Kind
from assistant.program.program import Program, walk
from assistant.program.statements import Moving
from assistant.report.track import track
from assistant.robots.timing.segments import label_of
from assistant.view.motion import Record, column_text
from assistant.view.moves import MOST_MOVES, MOST_TEXT, MoveKey, text_records

MOST_PLACES: Final = 100_000
"""Of the path of a program that is only drawn."""
NO_NUMBERS: Final = column_text(np.zeros(0))


@dataclass(frozen=True, slots=True)
class StillMotion:
    """What a page is told of a motion where there is none."""

    until: float = 0.0

    def record(self) -> Record:
        names = ("times", "joints", "places", "speeds", "room", "nearest")
        rest = {"axes": 0, "names": [], "held": True, "whole": 0.0}
        return dict.fromkeys(names, NO_NUMBERS) | rest

    def passing(self, place: Floats) -> None:
        """No time at all."""


@dataclass(slots=True)
class StillMoves:
    """The motion statements of a program in order of text."""

    program: Program
    texts: Places
    _spans: dict[int, int] = field(default_factory=dict)
    _records: list[Record] = field(default_factory=list)

    def __post_init__(self) -> None:
        for procedure in self.program.procedures:
            moving = (one for one in walk(procedure.body) if isinstance(one, Moving))
            for number, statement in enumerate(moving, start=1):
                self._add((procedure.name, number), statement)

    def __len__(self) -> int:
        return len(self._records)

    def records(self) -> list[Record]:
        return self._records[:MOST_MOVES]

    def played(self) -> Record:
        return {"times": NO_NUMBERS, "moves": NO_NUMBERS, "lines": NO_NUMBERS, "until": 0.0}

    def lines(self) -> tuple[list[Record], int]:
        """The texts, see `text_records`."""
        return text_records(self.texts.texts)

    def of_finding(self, finding: Diagnostic) -> int | None:
        """The place in the list of the statement that a finding is at."""
        return None if finding.span is None else self._spans.get(finding.span.start)

    def _add(self, key: MoveKey, statement: Moving) -> None:
        procedure, number = key
        span = statement.span
        place = None if span is None else self.texts.of(span)
        if span is not None:
            self._spans.setdefault(span.start, len(self._records))
        self._records.append(
            {
                "procedure": visible(procedure),
                "number": number,
                "label": visible(label_of(statement).strip("`")),
                "time": None,
                "line": None if place is None else place.line,
                "global": 0 if span is None else self.texts.lines(span)[0],
                "path": None if place is None or place.path is None else visible(place.path),
                "text": "" if place is None else visible(place.text[:MOST_TEXT]),
            }
        )


def path_record(program: Program, base: Pose) -> Record:
    """The way of the tool as straight pieces between its targets; `joint` where a joint move leads
    to one, whose way nobody tells.
    """
    way = track(program)
    places: Floats = base.moved(way.positions[:MOST_PLACES])
    joint = (way.kinds[:MOST_PLACES] == Kind.JOINT).astype(np.int64)
    left = max(0, len(way) - MOST_PLACES)
    return {"places": column_text(places), "joint": column_text(joint), "left": left}
