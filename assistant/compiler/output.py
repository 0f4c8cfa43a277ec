"""Output: a set of files appears in a folder complete, or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Final

from assistant.program.diagnostics import Refused, error

NOT_WRITTEN: Final = error(
    "CO201",
    "`{name}` cannot be written: {reason}",
    "free space or name another folder; what was there before is untouched",
)
BAD_NAME: Final = error("CO202", "`{name}` is no plain file name", "rename the program")

HOLDING: Final = ".robot-assistant-"
"""How the folder begins that holds files until all of them are there."""


def write_files(files: Mapping[str, bytes], folder: str | FilePath) -> tuple[FilePath, ...]:
    """Writes every file under a temporary name first, then puts all in place.

    Files that are replaced are kept until the last one is in place and put back if it is
    not. Raises Refused (exit status 2) if the folder or a file cannot be written.
    """
    into = FilePath(folder)
    for name in files:
        if FilePath(name).name != name or name in {"", ".", ".."}:
            raise Refused(BAD_NAME(path=str(into), name=name), exit_status=2)
    try:
        into.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=HOLDING, dir=into) as holding:
            return _put_in_place(files, into, FilePath(holding))
    except OSError as error:
        named = str(error.filename or into)
        name = str(into) if HOLDING in named else named  # nobody knows the folder of ours
        reason = error.strerror or str(error)
        raise Refused(
            NOT_WRITTEN(path=str(into), name=name, reason=reason), exit_status=2
        ) from None


def _put_in_place(
    files: Mapping[str, bytes], into: FilePath, holding: FilePath
) -> tuple[FilePath, ...]:
    for name, data in files.items():
        with (holding / name).open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
    replaced, placed = holding / "replaced", []
    replaced.mkdir()
    try:
        for name in files:
            target = into / name
            if target.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
            if target.exists():
                target.replace(replaced / name)
            placed.append(target)
            (holding / name).replace(target)
    except BaseException:  # also when the user interrupts
        for target in placed:
            with contextlib.suppress(FileNotFoundError):
                target.unlink()
            if (replaced / target.name).exists():
                (replaced / target.name).replace(target)
        raise
    return tuple(placed)
