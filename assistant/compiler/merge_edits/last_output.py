"""Last output: the last output is stored, so that edits are known from it.

The sources of the written files are stored as well, so that a file is not replaced by another
source's without notice.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.file_access import read_file
from assistant.base.file_sets import file_in_folder, write_all
from assistant.base.source_text import path_of
from assistant.compiler.merge_edits import rules

WRITTEN: Final = FilePath(".robot-assistant") / "written"
_SOURCES_FILE: Final = "sources.json"
"""Source of each file of a folder."""
WRITTEN_SUFFIX: Final = ".written"
"""After the name of what is remembered, which is no program for anybody who looks for such."""


def written_in(folder: str | FilePath) -> FilePath:
    """Return the path that stores the output compiled into a folder."""
    return path_of(folder) / WRITTEN


def replaced(
    files: Mapping[FilePath, bytes], source: str | FilePath | None, memory: FilePath
) -> list[Diagnostic]:
    """A finding for each file that was written from another source, which is still there.

    source: that the files are made of now, None if it is no file.
    """
    known = _stored_sources(memory)
    found: list[Diagnostic] = []
    for path, data in files.items():
        other = memory / known.get(path.name, "")
        if path.name not in known or bytes_of(path) in (None, data) or not other.is_file():
            continue
        if source is None or not FilePath(source).exists() or not other.samefile(source):
            was = os.path.relpath(other)
            finding = rules.OF_ANOTHER(
                path=str(path), file=path, other=was, source=source or "standard input"
            )
            found.append(finding)
    return found


def with_sources(
    made: Mapping[str | FilePath, Iterable[str]], memory: FilePath
) -> dict[FilePath, bytes]:
    """Records of the sources of written files, by the file that holds them.

    made: names of files by their source; of what is no file nothing is remembered.
    """
    known = _stored_sources(memory)
    for source, names in made.items():
        for name in names:
            known.pop(name, None)
            if FilePath(source).is_file():
                known[name] = FilePath(os.path.relpath(source, memory)).as_posix()
    text = json.dumps(dict(sorted(known.items())), indent=1, ensure_ascii=False)
    return {memory / _SOURCES_FILE: f"{text}\n".encode()}


def _stored_sources(memory: FilePath) -> dict[str, str]:
    """The sources of files in a folder by the files' names, relative to its memory."""
    try:
        known = json.loads(bytes_of(memory / _SOURCES_FILE) or b"{}")
    except ValueError:
        return {}
    pairs = known.items() if isinstance(known, dict) else ()
    return {name: path for name, path in pairs if isinstance(path, str)}


def write_unedited(
    files: Mapping[str, bytes],
    folder: str | FilePath,
    *,
    source: str | FilePath | None = None,
    overwrite: bool = False,
) -> tuple[FilePath, ...]:
    """Write files into a folder, and store them as the last output; return their paths.

    source: file that they are made of. Raises Refused if an existing file differs from the new and
    from the last output, or was made of another source, unless `overwrite`: only the commands keep
    edits.
    """
    memory = written_in(folder)
    wanted = {file_in_folder(name, folder): data for name, data in files.items()}
    memories = {memory / f"{path.name}{WRITTEN_SUFFIX}": data for path, data in wanted.items()}
    edited = [
        path
        for path, data in wanted.items()
        if bytes_of(path) not in (None, data, bytes_of(memory / f"{path.name}{WRITTEN_SUFFIX}"))
    ]
    if edited and not overwrite:
        raise Refused(*(rules.FOREIGN(path=str(path), file=path) for path in edited))
    if not overwrite and (others := replaced(wanted, source, memory)):
        raise Refused(*others)
    made = {"" if source is None else source: [path.name for path in wanted]}
    write_all({**wanted, **memories, **with_sources(made, memory)})
    return tuple(wanted)


def bytes_of(path: FilePath) -> bytes | None:
    """Return the contents of a file, None if it does not exist; empty, which no program is, if
    access is denied.

    A path that is not a file is reported when it is written.
    """
    try:
        return read_file(path)
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None
    except (OSError, Refused):
        return b""
