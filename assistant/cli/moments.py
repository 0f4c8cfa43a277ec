"""Times and lines of programs, as the command line names them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.base.source_text import SourceText

if TYPE_CHECKING:
    from assistant.virtual.events import Place

NOT_A_TIME: Final = error("CL022", "`{given}` is no time", "write seconds, 0 or more")
NOT_A_LINE_OF_PROGRAM: Final = error(
    "CL027",
    "`{given}` is no place in the programs",
    "write FILE:LINE, the file one of {names}, and one of its lines",
)


def time_or_line(given: str | None, sources: Sequence[SourceText]) -> float | Place | None:
    """Seconds, or a file and a line."""
    if given is None:
        return None
    try:
        seconds = float(given)
    except ValueError:
        return line_named(given, sources)
    if not 0.0 <= seconds < float("inf"):
        raise Refused(NOT_A_TIME(given=given), exit_status=2)
    return seconds


def line_named(given: str, sources: Sequence[SourceText]) -> Place:
    """FILE:LINE, the file as the programs' own is named, with or without folder and suffix."""
    name, _, number = given.rpartition(":")
    wanted = name.replace("\\", "/").casefold()
    shapes: tuple[Callable[[PurePath], str], ...] = (
        PurePath.as_posix,
        lambda path: path.name,
        lambda path: path.stem,
    )
    for shape in shapes:
        found = [s for s in sources if shape(PurePath(s.path or "")).casefold() == wanted]
        if len(found) == 1 and number.isascii() and number.isdecimal():
            line = int(number)
            if 1 <= line <= found[0].text.count("\n") + 1:
                return found[0].path or "", line
    raise Refused(NOT_A_LINE_OF_PROGRAM(given=given, names=_file_names(sources)), exit_status=2)


def _file_names(sources: Sequence[SourceText]) -> str:
    return ", ".join(f"`{PurePath(source.path or '').name}`" for source in sources) or "none"
