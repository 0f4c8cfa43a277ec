"""Findings about programs that were edited since they were written."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

KEPT: Final = info(
    "CO330",
    "`{file}` was edited since it was written, and keeps that: {edits}",
    "`--overwrite` writes it as it is compiled",
)
FOREIGN: Final = error(
    "CO331",
    "`{file}` is there, says something else, and nobody knows whether it was edited since it was "
    "written",
    "write to another folder, or over it with `--overwrite`",
)
OF_ANOTHER: Final = error(
    "CO342",
    "`{file}` was written from `{other}`, and the program of `{source}` would replace it",
    "write to another folder, or delete `{file}` first",
)
BOTH_MOVED: Final = error(
    "CO332",
    "{what} was edited in `{file}` ({was} became {now}), and the source has changed it as well "
    "({made})",
    "`--keep-edit {name}` keeps the edit, `--drop-edit {name}` takes what the source says",
)
NOWHERE: Final = error(
    "CO333",
    "{what} was edited in `{file}` ({was} became {now}), and nothing of the new program is surely "
    "the same: {reason}",
    "`--drop-edit {name}` goes on without the edit: make it again where it belongs",
)
STATEMENTS: Final = error(
    "CO334",
    "statements of `{name}` were edited in `{file}`, and {reason}",
    "`--drop-edit {name}` takes those of the source: make the edit again",
)
SEVERAL: Final = error(
    "CO335",
    "`{file}` was edited, and its program, of {count} files, has changed",
    "write to another folder and make the edit again, or write over it with `--overwrite`",
)
NOT_READ: Final = error(
    "CO336",
    "`{file}` was edited and cannot be merged: {reason}",
    "correct it, write to another folder, or write over it with `--overwrite`",
)
COMMENT: Final = error(
    "CO337",
    "the comment `{comment}` was written into `{file}`, and there is no line for it in the new "
    "program",
    "take it out of the file, or write over that with `--overwrite`",
)
LEFT_OUT: Final = warning(
    "CO338",
    "of the edits of `{file}` is left out: {edits}",
    "make the edits again if they are still wanted",
)
NO_EDIT: Final = error(
    "CO339",
    "`{name}` names no edit of a written file",
    "{cure}",
)
