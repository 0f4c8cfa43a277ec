"""How commands read a source: a file, or standard input; and sources are not written over."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error

if TYPE_CHECKING:
    from assistant.base.source_text import SourceText
    from assistant.cli.options import ReaderOptions
    from assistant.compiler import Loaded
    from assistant.robots import Robot
    from assistant.sources.process import SurroundingsByRobot


NO_FILE_NAME = error("CL003", "`{name}` is no name of a file", "name the file to write")
TWICE = error("CL004", "standard input can be read only once", "name `-` only once")
_OVER_SOURCE = error(
    "CL007", "`{name}` would be written over the source itself", "name another folder or file"
)
STANDARD: Final = "-"
SIDE_TABLES_ABOVE: Final = 1000
"""Rows of a path that a `.pseudo` file on disk still holds in its text."""


def load_given(
    source: str,
    robot: str | Robot | None,
    reader: ReaderOptions,
    from_language: str | None,
    entry: str | None = None,
    around: SurroundingsByRobot | None = None,
) -> Loaded:
    """The program of a file, or of standard input if the source says so.

    entry: the procedure that it begins with, None for its own. around: what stands around it.
    """
    from assistant.compiler.arms import robot_of
    from assistant.compiler.loader import with_entry
    from assistant.compiler.program_files import load

    arm = robot_of(robot)
    given = load_named(source, from_language, robot, reader) or load(
        source,
        process=reader.process,
        robot=arm,
        language=from_language,
        unit=reader.unit,
        around=around,
        placement=reader.placement,
    )
    return replace(given, program=with_entry(given.program, entry))


def load_named(
    source: str, language: str | None, robot: str | Robot | None, reader: ReaderOptions
) -> Loaded | None:
    """The program on standard input if the source says so, or a file of a named language."""
    from assistant.base.length_units import unit_stated
    from assistant.compiler.arms import robot_of
    from assistant.compiler.loader import load_text
    from assistant.compiler.program_files import load
    from assistant.sources.process.placement import check_drawn

    if reader.placement is not None and source == STANDARD:
        check_drawn(Path("standard input"))
    if source != STANDARD:
        if language is None:
            return None
        return load(
            source,
            process=reader.process,
            robot=robot_of(robot),
            language=language,
            unit=reader.unit,
            placement=reader.placement,
        )
    text, spoken = standard_input(language)
    loaded = load_text(text, process=reader.process, robot=robot_of(robot), language=spoken)
    if reader.unit is None:
        return loaded
    found = unit_stated("standard input", reader.unit)
    return replace(loaded, findings=(*loaded.findings, found))


def standard_input(language: str | None) -> tuple[SourceText, str | None]:
    """The text on standard input, and the robot language that is named or that it shows.

    It is decoded as files of that language are, else as pseudo text. Raises Unreadable if
    there is nothing.
    """
    from assistant import languages
    from assistant.base.source_text import decode, read_input
    from assistant.compiler.loader import PSEUDO_ENCODINGS, language_of

    data = read_input(sys.stdin.buffer)
    if language is None and not _PSEUDO.search(data):
        known = map(languages.get, languages.names())
        language = next((one.name for one in known if one.recognises(data)), None)
    encodings = language_of(language).encodings if language else PSEUDO_ENCODINGS
    return decode(data, "standard input", encodings), language


def cell_of(source: str) -> Path | None:
    """Return the cell file of a robot program or folder that no option names, None for none.

    It is that of the project, else the one beside it.
    """
    from assistant import languages
    from assistant.base.source_text import is_folder
    from assistant.program.project_file import project_of
    from assistant.sources.cell_values import cell_file_beside

    path = Path(source)
    if source == STANDARD or not path.exists():
        return None
    if not is_folder(source):
        suffixes = {suffix for name in languages.names() for suffix in languages.get(name).suffixes}
        if path.suffix.lower() not in suffixes:
            return None
        if project_of(path.absolute().parent) is not None:  # few files need to load all of projects
            from assistant.project.source_options import SourceOptions, completed_options

            if (stated := completed_options(source, SourceOptions(), ("cell",)).cell) is not None:
                return stated
    return cell_file_beside(source)


_PSEUDO: Final = re.compile(rb"^\s*program\b", re.MULTILINE)


def keep_sources(sources: Sequence[str], written: Sequence[Path]) -> None:
    """Raises Refused (exit status 2) if a file that is to be written is one of the sources."""
    read = [Path(source) for source in sources if source != STANDARD]
    for file in written:
        if file.is_file() and any(one.exists() and one.samefile(file) for one in read):
            raise Refused(_OVER_SOURCE(path=str(file), name=file), exit_status=2)
