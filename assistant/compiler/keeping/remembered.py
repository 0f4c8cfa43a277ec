"""What was written last, and is remembered, so that edits are known from it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Final

from assistant.compiler.keeping import rules
from assistant.program.diagnostics import Refused
from assistant.program.system.bounded import read_file
from assistant.program.system.writing import place_of, write_all

WRITTEN: Final = FilePath(".robot-assistant") / "written"
SUFFIX: Final = ".written"
"""Behind the name of what is remembered, which is no program for anybody who looks for such."""


def written_in(folder: str | FilePath) -> FilePath:
    """Where it is kept what was compiled into a folder."""
    return FilePath(folder) / WRITTEN


def write_unedited(
    files: Mapping[str, bytes], folder: str | FilePath, *, overwrite: bool = False
) -> tuple[FilePath, ...]:
    """Writes files into a folder, and remembers them; gives where they are.

    Raises Refused where one that is there is neither what would be written nor what was written
    last, unless `overwrite`: edits are kept by the commands alone.
    """
    memory = written_in(folder)
    wanted = {place_of(name, folder): data for name, data in files.items()}
    memories = {memory / f"{path.name}{SUFFIX}": data for path, data in wanted.items()}
    edited = [
        path
        for path, data in wanted.items()
        if bytes_of(path) not in (None, data, bytes_of(memory / f"{path.name}{SUFFIX}"))
    ]
    if edited and not overwrite:
        raise Refused(*(rules.FOREIGN(path=str(path), file=path) for path in edited))
    write_all({**wanted, **memories})
    return tuple(wanted)


def bytes_of(path: FilePath) -> bytes | None:
    """What is in a file, None if it is not there; empty, which no program is, if nobody may look.

    What is no file is told of when it is written.
    """
    try:
        return read_file(path)
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None
    except (OSError, Refused):
        return b""
