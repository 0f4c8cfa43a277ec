"""Folders: the robot programs in them, and what of them is left out and why."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, Final

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Refused, Unreadable, error, info
from assistant.base.source_text import is_folder, read_bytes
from assistant.compiler.loading import files_in, language_of
from assistant.languages import Language

NO_PROGRAMS: Final = error(
    "CO403",
    "the folder `{name}` holds no robot programs",
    "name the files, and their language with --from",
)
LEFT_OUT: Final = info(
    "CO308", "left out, as {why}: {files}", "name a file by itself if it is meant"
)
WHY_EMPTY: Final = "empty"
WHY_NO_PROGRAM: Final = "nothing that looks like a robot program"
WHY_COPY: Final = "what a project keeps as a copy of a program"
WHY_NO_TEXT: Final = "what a controller makes of a program, which is no text"
WHY_OUTPUT: Final = "what stands in the folder that is written to"
MOST_FILES_NAMED: Final = 3
"""Files of one reason that are named."""

Report = Callable[[Diagnostic], None]


@dataclass(frozen=True, slots=True)
class OutputFolder:
    """Where programs of a language are written to: what a run before has left there."""

    folder: str
    language: str

    def holds(self, file: str, language: Language[Any], searched: str) -> bool:
        """Whether a file of any version of it is in this folder, inside the searched one."""
        here, whole = FilePath(self.folder).resolve(), FilePath(searched).resolve()
        inside = whole in here.parents and here in FilePath(file).resolve().parents
        suffixes = languages.get(self.language).suffixes
        return inside and not set(suffixes).isdisjoint(language.suffixes)


def programs_in(
    path: str,
    language: str | None = None,
    told: Report | None = None,
    output: OutputFolder | None = None,
) -> Iterator[str]:
    """The file itself, or the robot programs of a folder and the folders in it.

    Hidden folders are left aside, files that do not look like a program, and in a folder with
    texts of programs copies of them; told: is given a finding for each reason. output: what is
    no source as it was written there. Raises Refused if there is none.
    """
    if not is_folder(path):
        yield path
        return
    spoken = [language_of(language)] if language else list(map(languages.get, languages.names()))
    suffixes = {suffix for one in spoken for suffix in one.suffixes}
    found, left = list[str](), dict[str, str]()
    for file in files_in(path, suffixes):
        why = "" if language else _why_not(file, spoken, path, output)
        if why:
            left[file] = why
        else:
            found.append(file)
    if not found:
        found = [file for file, why in left.items() if why in (WHY_COPY, WHY_NO_TEXT)]
        left = {file: why for file, why in left.items() if file not in found}
    for why in dict.fromkeys(left.values()):
        if told is not None:
            told(LEFT_OUT(why=why, files=_left_out_finding(path, left, why), path=path))
    if not found:
        raise Refused(NO_PROGRAMS(path=path, name=path), exit_status=2)
    yield from found


def _left_out_finding(folder: str, left: Mapping[str, str], why: str) -> str:
    files = [FilePath(file).relative_to(folder) for file, one in left.items() if one == why]
    shown = ", ".join(f"`{file.as_posix()}`" for file in files[:MOST_FILES_NAMED])
    more = len(files) - MOST_FILES_NAMED
    return f"{shown} and {more} more" if more > 0 else shown


def _why_not(
    file: str, spoken: list[Language[Any]], searched: str, output: OutputFolder | None
) -> str:
    """Why a file of a folder is no program of it, empty if it is one."""
    try:
        data = read_bytes(file, allow_empty=True)
    except Unreadable:
        return ""  # to be said when it is read
    language = languages.of_file(file, data)
    if language is None:
        return WHY_NO_PROGRAM if data.strip() else WHY_EMPTY
    if any(one.begins and data.startswith(one.begins) for one in spoken):
        return WHY_NO_TEXT
    if output is not None and output.holds(file, language, searched):
        return WHY_OUTPUT
    return WHY_COPY if language.is_copy(FilePath(file)) else ""
