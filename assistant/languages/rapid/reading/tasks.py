"""Folders of RAPID: what of them a controller loads as one task.

A backup keeps the modules of a task in `RAPID/TASKn/PROGMOD` and `SYSMOD`, and those that all tasks
share in `RAPID/TASK0`. A list of a program names its program modules only: system modules are
loaded by the system parameters.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.languages.language_types import (
    ControllerConfiguration,
    SharedData,
    TaskLoading,
    Texts,
)

TASK_FOLDERS: Final = frozenset(("PROGMOD", "SYSMOD"))
SYSTEM_FOLDER: Final = "SYSMOD"
SYSTEM_SUFFIXES: Final = (".sys", ".sysx")
_TASK_FOLDER: Final = re.compile(r"(?i)(?:^|/)RAPID/TASK(\d+)$")


def task_folder(path: FilePath) -> FilePath:
    """The modules of a folder are one task; a backup keeps a task's in two folders."""
    folder = path.parent
    return folder.parent if folder.name.upper() in TASK_FOLDERS else folder


def is_shared_folder(folder: FilePath) -> bool:
    """Whether a folder is TASK0 of a backup."""
    found = _TASK_FOLDER.search(folder.as_posix())
    return found is not None and int(found[1]) == 0


def is_task_folder(folder: FilePath) -> bool:
    """Whether a folder is a task of a backup."""
    return _TASK_FOLDER.search(folder.as_posix()) is not None


def is_system_module(path: FilePath) -> bool:
    """Whether a file is a system module by its folder or suffix."""
    return path.parent.name.upper() == SYSTEM_FOLDER or path.suffix.lower() in SYSTEM_SUFFIXES


def surroundings(module: FilePath, read: Texts) -> ControllerConfiguration:
    from assistant.languages.rapid.reading.parameters import backup_configuration

    return backup_configuration(module, read)


def _with_shared_data_of_tasks(tasks: Sequence[tuple[str, Sequence[Any]]]) -> list[SharedData]:
    """See `shared_data`, which knows the tree: only what loads several tasks asks for it."""
    from assistant.languages.rapid.reading.shared_data import with_shared_data

    return with_shared_data(tasks)


LOADING: Final = TaskLoading(
    "main",
    (".pgf",),
    is_shared_folder,
    is_task_folder,
    is_system_module,
    _with_shared_data_of_tasks,
)
