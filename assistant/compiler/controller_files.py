"""What the files of a controller state about its programs: their signals."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.compiler.cell_file import with_signals
from assistant.program.diagnostics import Diagnostic, Refused, info, warning
from assistant.program.text import decode, read_bytes

if TYPE_CHECKING:
    from assistant.languages.tasks import Loading
    from assistant.program.program import Program, Signal

NUMBERED: Final = info(
    "CO043",
    "{count} signals of the program have the numbers of the maps in `{name}`, each device behind "
    "the one before",
    "see that the other controller is wired so, or state other numbers in the process file",
)
CROSSED: Final = warning(
    "CO044",
    "the controller sets {names} from other signals, as `{name}` states; this is not translated",
    "have the other controller or its wiring do that as well",
)
UNREAD: Final = warning(
    "CO045",
    "{what} of `{name}` is not used: {reason}",
    "correct it, or state the signals in the process file",
)
ALL: Final = "the text"
MOST_NAMED: Final = 5
ENCODINGS: Final = ("utf-8-sig", "utf-8", "cp1252", "latin-1")


def as_configured(
    program: Program, loading: Loading, file: str | FilePath
) -> tuple[Program, Mapping[str, Signal], tuple[Diagnostic, ...]]:
    """A program with the signals that the controller's files state, and all of those.

    file: of the program. A file that cannot be read is a finding.
    """
    where = loading.signals_beside(FilePath(file))
    if where is None:
        return program, {}, ()
    path = str(where)
    try:
        text = decode(read_bytes(where), path, ENCODINGS).text
    except Refused as refused:
        reason = refused.findings[0].message
        return program, {}, (UNREAD(name=where.name, what=ALL, reason=reason, path=path),)
    given = loading.signals_of(text)
    found: list[Diagnostic] = []
    if not given.known:
        reason = "it does not look like a file of system parameters"
        found.append(UNREAD(name=where.name, what=ALL, reason=reason, path=path))
    if given.unread:
        what, reason = _named(given.unread), "it states no type of signal that there is"
        found.append(UNREAD(name=where.name, what=what, reason=reason, path=path))
    made = with_signals(program, given.signals)
    numbered = _numbers(made) - _numbers(program)
    if numbered:
        found.append(NUMBERED(count=len(numbered), name=where.name, path=path))
    crossed = [name for name in made.signals if name.lower() in given.crossed]
    if crossed:
        found.append(CROSSED(names=_named(crossed), name=where.name, path=path))
    return made, given.signals, tuple(found)


def _numbers(program: Program) -> set[str]:
    return {name for name, signal in program.signals.items() if signal.number is not None}


def _named(names: list[str] | tuple[str, ...]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:MOST_NAMED])
    more = len(names) - MOST_NAMED
    return f"{shown} and {more} more" if more > 0 else shown
