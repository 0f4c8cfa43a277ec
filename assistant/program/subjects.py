"""What a finding is about: a part of a program. Its words are made when they are shown.

A statement is known by its span alone, see `Diagnostic`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal, TypeAlias

ProgramTable: TypeAlias = Literal[
    "procedures",
    "paths",
    "variables",
    "targets",
    "joint_targets",
    "tools",
    "frames",
    "signals",
    "speeds",
    "blends",
]
"""The tables of names of a program; paths are those of its statements."""

TABLE_NOUNS: Final[Mapping[ProgramTable, str]] = MappingProxyType(
    {
        "procedures": "procedure",
        "paths": "path",
        "variables": "variable",
        "targets": "target",
        "joint_targets": "joint target",
        "tools": "tool",
        "frames": "frame",
        "signals": "signal",
        "speeds": "speed",
        "blends": "blend",
    }
)
"""Table → what one entry of it is called."""
DATA_TABLES: Final[tuple[ProgramTable, ...]] = (
    "variables",
    "targets",
    "joint_targets",
    "tools",
    "frames",
    "signals",
)
"""The tables of a program that hold what it declares beside its procedures."""


@dataclass(frozen=True, slots=True)
class Declared:
    """Something that a program has under a name.

    table: that holds it, None where its name alone is known. owner: the procedure whose own
    variable it is, empty for one of the program. in_full: whether the words say what it is and
    whose, `procedure p variable n` instead of `n`.
    """

    name: str
    table: ProgramTable | None = None
    owner: str = ""
    in_full: bool = False

    def __str__(self) -> str:
        if self.table is None or not self.in_full:
            return self.name
        of = f"procedure {self.owner} " if self.owner else ""
        return f"{of}{TABLE_NOUNS[self.table]} {self.name}"


@dataclass(frozen=True, slots=True)
class PathRow:
    """A row of a path, counted from 1.

    more: how many other rows the same is found of. in_full: whether the words say what it is,
    `path seam row 2` instead of `seam_2`. original: what the source text calls it, if otherwise.
    """

    path: str
    row: int
    more: int = 0
    in_full: bool = False
    original: str = ""

    def __str__(self) -> str:
        name = self.original or f"{self.path}_{self.row}"
        said = f"path {self.path} row {self.row}" if self.in_full else name
        return f"{said} and {self.more} more" if self.more else said


@dataclass(frozen=True, slots=True)
class NumberedMove:
    """A move to a target without a name, counted from 1 among the moves of its procedure."""

    number: int
    procedure: str

    def __str__(self) -> str:
        return f"move {self.number} of {self.procedure}"


Goal: TypeAlias = Declared | PathRow | NumberedMove
"""Where a move leads to: a target by its name, a row of a path, or what has neither."""


@dataclass(frozen=True, slots=True)
class Neighbours:
    """Targets that follow each other, from the first to the last."""

    first: Goal
    last: Goal

    def __str__(self) -> str:
        return f"{self.first} to {self.last}"


@dataclass(frozen=True, slots=True)
class SomeTargets:
    """Some of the targets of a path, or of the moves of a procedure.

    of: its name. count: how many of the whole. named: the first ones. more: the rest.
    """

    of: str
    count: int
    whole: int
    named: tuple[Goal | Neighbours, ...]
    more: int

    def __str__(self) -> str:
        more = f" and {self.more} more" if self.more else ""
        named = ", ".join(map(str, self.named))
        return f"{self.of}: {self.count} of {self.whole} targets ({named}{more})"


@dataclass(frozen=True, slots=True)
class Several:
    """Targets in several parts of a run of moves. more: how many other parts have some."""

    parts: tuple[SomeTargets | Goal, ...]
    more: int

    def __str__(self) -> str:
        more = f"; and in {self.more} more paths" if self.more else ""
        return "; ".join(map(str, self.parts)) + more


@dataclass(frozen=True, slots=True)
class Inner:
    """A part of a program by the fields, names and rows that lead to it from the outside."""

    steps: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join(self.steps)

    @property
    def declared(self) -> Declared | None:
        """The variable, target, tool … that it is, or that it is a part of."""
        match self.steps:
            case ("procedure", owner, "variables", name, *_):
                return Declared(name, "variables", owner)
            case (field, name, *_):
                table = next((table for table in DATA_TABLES if table == field), None)
                return Declared(name, table) if table is not None else None
        return None


@dataclass(frozen=True, slots=True)
class Repeated:
    """Parts of which the same is found. named: the first ones, in words."""

    parts: tuple[Subject | str | None, ...]
    named: tuple[str, ...]

    def __str__(self) -> str:
        rest = len(self.parts) - len(self.named)
        more = f" and {rest} more" if rest else ""
        return f"{len(self.parts)} times: {', '.join(filter(None, self.named))}{more}"


Subject: TypeAlias = Declared | PathRow | NumberedMove | SomeTargets | Several | Inner | Repeated
