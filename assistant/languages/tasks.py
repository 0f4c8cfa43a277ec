"""Tasks: what of a folder a controller loads as one program, for languages of several files.

A language whose every file is a program of its own has none of this.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from assistant.program import lines


@dataclass(frozen=True, slots=True)
class Loading:
    """How the files of a task are told.

    entry: the procedure that a task begins with, in lower case. lists: suffixes of files that
    name the files of a task. shared: of a folder, as `program_of` gives it, whether every other
    task beside it loads its files as well. closed: whether a task there loads all files of its
    folders, and none from elsewhere but shared ones. loaded: of a file there, whether a task
    loads it though its list does not name it.
    """

    entry: str
    lists: tuple[str, ...]
    shared: Callable[[FilePath], bool]
    closed: Callable[[FilePath], bool]
    loaded: Callable[[FilePath], bool]


_WORD: Final = r"[^\W\d]\w*"


def words_of(text: str, mark: str) -> frozenset[str]:
    """Names in a text, in lower case, but for those in comments and in strings ("…")."""
    apart = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|{re.escape(mark)}{lines.REST}|({_WORD})'
    found = re.finditer(apart, lines.with_line_feeds(text))
    return frozenset(match[1].lower() for match in found if match[1])
