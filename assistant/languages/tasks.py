"""Tasks: what of a folder a controller loads as one program, for languages of several files.

A language whose every file is a program of its own has none of this.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from assistant.program import lines
from assistant.program.program import Signal


@dataclass(frozen=True, slots=True)
class Loading:
    """How the files of a task are told.

    entry: the procedure that a task begins with, in lower case. lists: suffixes of files that
    name the files of a task. shared: of a folder, as `program_of` gives it, whether every other
    task beside it loads its files as well. closed: whether a task there loads all files of its
    folders, and none from elsewhere but shared ones. loaded: of a file there, whether a task
    loads it though its list does not name it. signals_beside: the file with the signals of the
    controller that a file of a program belongs to. signals_of: those in its text.
    """

    entry: str
    lists: tuple[str, ...]
    shared: Callable[[FilePath], bool]
    closed: Callable[[FilePath], bool]
    loaded: Callable[[FilePath], bool]
    signals_beside: Callable[[FilePath], FilePath | None]
    signals_of: Callable[[str], Configured]


@dataclass(frozen=True, slots=True)
class Configured:
    """Signals as the files of a controller state them, by their names.

    crossed: names in lower case of those that the controller sets from others. unread: what is
    stated and cannot be used. known: whether the text looks like such a file at all.
    """

    signals: Mapping[str, Signal]
    crossed: frozenset[str] = frozenset()
    unread: tuple[str, ...] = ()
    known: bool = True


_WORD: Final = r"[^\W\d]\w*"


def words_of(text: str, mark: str) -> frozenset[str]:
    """Names in a text, in lower case, but for those in comments and in strings ("…")."""
    apart = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|{re.escape(mark)}{lines.REST}|({_WORD})'
    found = re.finditer(apart, lines.with_line_feeds(text))
    return frozenset(match[1].lower() for match in found if match[1])
