"""The environment of a simulated run: its disk, hosts, lines and answers, and when it is held.

A program may open files below one folder, reach hosts and lines by given names, and ask on
standard input. A run is held at a time in seconds or at FILE:LINE.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, Rule, error
from assistant.base.source_text import SourceText, visible

if TYPE_CHECKING:
    from assistant.virtual.events import Place
    from assistant.virtual.kernel import Kernel


_NOT_A_HOST: Final = error(
    "CL030",
    "`{given}` names no host for an address",
    "write ADDRESS=HOST, as 192.168.125.1=127.0.0.1",
)
_NO_FOLDER: Final = error("CL031", "there is no folder `{folder}`", "make it, or name another one")
INPUT_IS_PROGRAM: Final = error(
    "CL032", "the program itself is read from standard input", "name its file, or leave --ask out"
)


_NOT_A_LINE: Final = error(
    "CL033",
    "`{given}` leads no line anywhere",
    "write NAME=PORT, NAME=HOST:PORT or NAME=PATH, as COM1=10003",
)
_NAMED_TWICE: Final = error("CL043", "`{name}` is led to two places", "name it once")


def check_disk_folder(folder: Path | None) -> None:
    if folder is not None and not folder.is_dir():
        raise Refused(_NO_FOLDER(folder=folder), exit_status=2)


def hosts_of(given: Sequence[str]) -> dict[str, str]:
    """Hosts by address; raises Refused for what names none."""
    return _named_values(given, _NOT_A_HOST)


def line_targets(given: Sequence[str]) -> dict[str, str]:
    """Return the endpoint of each line by its name; raise Refused for an argument without a
    name.
    """
    return _named_values(given, _NOT_A_LINE)


def _named_values(given: Sequence[str], wrong: Rule) -> dict[str, str]:
    pairs: dict[str, str] = {}
    named: set[str] = set()
    for pair in given:
        name, _, value = (part.strip() for part in pair.partition("="))
        if not name or not value:
            raise Refused(wrong(given=pair), exit_status=2)
        known = name.rstrip(":").upper()
        if known in named:
            raise Refused(_NAMED_TWICE(name=name), exit_status=2)
        named.add(known)
        pairs[name] = value
    return pairs


def answer_from_input(kernel: Kernel, flush: Callable[[], None]) -> None:
    """Has what programs ask answered on standard input, as long as there is more of it.

    flush: prints what happened until then.
    """

    def asked(question: str) -> str | None:
        kernel.catch_up()
        flush()
        sys.stderr.write(f"answer to `{visible(question)}`: ")
        sys.stderr.flush()
        line = sys.stdin.readline()
        return line.strip() if line else None

    kernel.person.console = asked


_NOT_A_TIME: Final = error("CL022", "`{given}` is no time", "write seconds, 0 or more")
_NOT_A_LINE_OF_PROGRAM: Final = error(
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
        raise Refused(_NOT_A_TIME(given=given), exit_status=2)
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
    raise Refused(_NOT_A_LINE_OF_PROGRAM(given=given, names=_file_names(sources)), exit_status=2)


def _file_names(sources: Sequence[SourceText]) -> str:
    return ", ".join(f"`{PurePath(source.path or '').name}`" for source in sources) or "none"
