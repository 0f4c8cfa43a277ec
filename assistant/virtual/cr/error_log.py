"""The error history of a controller, and what its error numbers mean."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from functools import cache
from importlib.resources import files
from typing import Final

MOST_ERRORS: Final = 128
"""That the history keeps; the oldest go first."""
LEVELS: Final = {"H": 1, "L": 2, "C": 3}


@dataclass(frozen=True, slots=True)
class ErrorEntry:
    """level: 1 high, 2 low, 3 caution. program, line: where it came, empty and 0 for none."""

    when: datetime
    number: int
    level: int
    program: str = ""
    line: int = 0

    @property
    def detail(self) -> str:
        """The number with the detail that nothing here tells, nine digits."""
        return f"{self.number:04}00000"

    @property
    def fields(self) -> str:
        """As ERRORLOG tells it."""
        when = f"{self.when:%y-%m-%d;%H:%M:%S}"
        text = error_message(self.number)
        return (
            f"{when};{self.number:04};{text};{self.level};{self.program};{self.line};{self.detail}"
        )


@dataclass
class ErrorLog:
    """entries: the newest first. counts: by number, since the summary was cleared.

    since: when the history and the summary were begun.
    """

    entries: list[ErrorEntry] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=dict)
    latest: dict[int, datetime] = field(default_factory=dict)
    since: dict[str, datetime] = field(default_factory=dict)

    def add(self, when: datetime, number: int, level: int, program: str, line: int) -> None:
        self.entries.insert(0, ErrorEntry(when, number, level, program, line))
        del self.entries[MOST_ERRORS:]
        self.counts[number] = self.counts.get(number, 0) + 1
        self.latest[number] = when

    def of(self, level: int, detail: str) -> Sequence[ErrorEntry]:
        """The newest first; of a level, 0 for all, whose details begin as stated."""
        return [e for e in self.entries if level in (0, e.level) and e.detail.startswith(detail)]

    def clear(self, level: int) -> None:
        self.entries = [e for e in self.entries if level not in (0, e.level)]

    def clear_summary(self) -> None:
        self.counts.clear()
        self.latest.clear()


def error_message(number: int) -> str:
    """What an error number means; never fails."""
    return error_table().get(number, ("", f"Error {number:04}"))[1]


def error_level(number: int) -> int:
    """1 high, 2 low, 3 caution; low where the table does not know the number."""
    return LEVELS.get(error_table().get(number, ("L", ""))[0], LEVELS["L"])


@cache
def error_table() -> Mapping[int, tuple[str, str]]:
    """Number → letter of its level, and what it means."""
    text = files(__package__).joinpath("errors.tsv").read_text(encoding="ascii")
    rows = csv.DictReader(io.StringIO(text), delimiter="\t", quoting=csv.QUOTE_NONE)
    return {int(row["number"]): (row["level"], row["text"]) for row in rows}
