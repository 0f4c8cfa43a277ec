"""Tasks: what of a folder a controller loads as one program, for languages of several files.

A language whose every file is a program of its own has none of this.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, Final, Literal, TypeAlias

from assistant.base import source_text
from assistant.base.diagnostics import Diagnostic
from assistant.program.program import Signal
from assistant.program.undeclared_names import SuppliedValue, WantedKind


@dataclass(frozen=True, slots=True)
class TaskLoading:
    """How the files of a task are told.

    entry: the procedure that a task begins with, in lower case. lists: suffixes of files that
    name the files of a task. shared: of a folder, as `program_of` gives it, whether every other
    task beside it loads its files as well. closed: whether a task there loads all files of its
    folders, and none from elsewhere but shared ones. loaded: of a file there, whether a task
    loads it though its list does not name it. sharing: the trees of all tasks of a controller, by
    the name of each, with names of data that other controllers share as well.
    """

    entry: str
    lists: tuple[str, ...]
    shared: Callable[[FilePath], bool]
    closed: Callable[[FilePath], bool]
    loaded: Callable[[FilePath], bool]
    sharing: Callable[[Sequence[tuple[str, Sequence[Any]]]], Sequence[SharedData]]


@dataclass(frozen=True, slots=True)
class SharedData:
    """The trees of a task that shares data with others of its controller. findings: on that."""

    trees: tuple[Any, ...]
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True)
class ControllerConfiguration:
    """What the files of a controller state of its programs.

    signals: by their names. source: the file that states them. crossed: names in lower case of
    those that the controller sets from others. unread: what is stated there and cannot be used.
    known: whether the text looks like such a file at all. arm: the robot, by its name in the
    catalogue; told: the same in its maker's words. entry: the procedure that the task begins
    with, in lower case. called: routines that the controller calls, by their names in lower case,
    each with when. values: of names that programs use and do not declare. lines:
    communication lines by number, each with its role, port and address. findings: on the files.
    """

    signals: Mapping[str, Signal] = field(default_factory=dict)
    crossed: frozenset[str] = frozenset()
    unread: tuple[str, ...] = ()
    known: bool = True
    arm: str | None = None
    told: str = ""
    entry: str | None = None
    called: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[tuple[WantedKind, str], SuppliedValue] = field(default_factory=dict)
    lines: Mapping[int, CommunicationLine] = field(default_factory=dict)
    source: FilePath | None = None
    findings: tuple[Diagnostic, ...] = ()


CommunicationLine: TypeAlias = tuple[Literal["server", "client", "serial"], int, str]
Texts: TypeAlias = Callable[[FilePath], str | None]
"""Reads a file of a controller, None where that cannot be done."""
Surroundings: TypeAlias = Callable[[FilePath, Texts], ControllerConfiguration]
"""What the files beside one of a program state of its controller."""


def file_named(folder: FilePath, name: str) -> FilePath | None:
    """What stands in a folder under a name in lower case, whatever its own case."""
    try:
        return next((path for path in folder.iterdir() if path.name.lower() == name), None)
    except OSError:
        return None


def catalogue_name(family: str, figures: frozenset[float]) -> str | None:
    """The arm in the catalogue of a family, `irb1200`, with these figures behind its name."""
    from assistant import robots

    for name in robots.names():
        first, *others = name.split("-")
        if first == family and frozenset(map(float, filter(_FIGURE.fullmatch, others))) == figures:
            return name
    return None


_FIGURE: Final = re.compile(r"[0-9]+(?:\.[0-9]+)?")


_WORD: Final = r"[^\W\d]\w*"


def words_of(text: str, mark: str) -> frozenset[str]:
    """Names in a text, in lower case, but for those in comments and in strings ("…")."""
    apart = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|{re.escape(mark)}{source_text.REST}|({_WORD})'
    found = re.finditer(apart, source_text.with_line_feeds(text))
    return frozenset(match[1].lower() for match in found if match[1])
