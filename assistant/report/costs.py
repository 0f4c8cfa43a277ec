"""What keeps a translated program from being said whole: the reasons that cost most."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Final

from assistant.compiler.source_map import Place
from assistant.compiler.translation import Level, ReportRow

MOST_COSTS: Final = 10
"""Reasons that a report tells of a program."""


@dataclass(frozen=True, slots=True)
class Cost:
    """A reason that statements have in common.

    count: of the statements that are not said, or only with a change, for this one first.
    cure: what to do about it. message: of the first of them, which stands at `place`. rows: of
    all of them, in their order.
    """

    code: str
    level: Level
    count: int
    message: str
    cure: str
    place: Place
    rows: tuple[ReportRow, ...] = ()

    def record(self) -> dict[str, Any]:
        return {
            "code": self.code,
            "level": self.level,
            "statements": self.count,
            "message": self.message,
            "cure": self.cure,
            "path": self.place.path,
            "line": self.place.line,
        }


def costs(rows: Iterable[ReportRow], most: int = MOST_COSTS) -> list[Cost]:
    """The reasons of the most statements, of those that are not said before the others."""
    found: dict[tuple[Level, str, str], list[ReportRow]] = {}
    for row in rows:
        if row.level != "supported" and row.reasons:
            first = row.reasons[0]
            found.setdefault((row.level, first.code, _common_message(first.message)), []).append(
                row
            )
    every = (_cost_record(level, alike) for (level, _, _), alike in found.items())
    ordered = sorted(every, key=lambda c: (c.level != "not", -c.count, c.code))
    return ordered[:most]


def _cost_record(level: Level, alike: Sequence[ReportRow]) -> Cost:
    row, count = alike[0], sum(one.count for one in alike)
    first = row.reasons[0]
    return Cost(first.code, level, count, first.message, first.cure, row.place, tuple(alike))


_QUOTED_NAME: Final = re.compile(r"`([A-Za-z_]\w*)[^`\w][^`]*`")
_ANY_NUMBER: Final = re.compile(r"(?<![\w`])[-+]?[0-9][0-9.,]*")


def _common_message(message: str) -> str:
    """A message without what differs from statement to statement: arguments and numbers."""
    return _ANY_NUMBER.sub("#", _QUOTED_NAME.sub(r"`\1`", message))
