"""Which modules belong to one task, as far as the names of their folders and files tell."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from typing import Final

from assistant.languages.rapid.tree import syntax as s

_TASK_NAME: Final = re.compile(r"(?:T_\w+|TASK\d+)", re.IGNORECASE)
"""Folders that a controller names after its tasks: `T_ROB1`, `TASK1` in a backup."""
_ARM_NAME: Final = re.compile(r"(.+?)([Ll]eft|[Rr]ight|(?<![A-Za-z])[LRlr]|(?<=[a-z])[LR])(_?\d*)")
"""Names of the files of a robot with two arms, each of which is a task."""
COMMON_TASKS: Final = ("", "task0")
"""No task, and the folder of a backup with the modules that every task has."""


TaskFiles = tuple[s.File, ...]


def tasks(files: Sequence[s.File]) -> Iterator[tuple[TaskFiles, TaskFiles]]:
    """The files of each task, and those among them that are of every task.

    One task with all files if no names of folders or files tell several apart.
    """
    paths = [PurePosixPath((file.path or "").replace("\\", "/")) for file in files]
    arms = _arms(paths)
    named = [_task_of_path(path) or arms.get(path.stem, "") for path in paths]
    names = [name for name in dict.fromkeys(named) if name not in COMMON_TASKS]
    if len(names) < 2:
        yield tuple(files), ()
        return
    common = tuple(file for file, of in zip(files, named, strict=True) if of in COMMON_TASKS)
    for name in names:
        yield (
            tuple(f for f, of in zip(files, named, strict=True) if of in (name, *COMMON_TASKS)),
            common,
        )


def _task_of_path(path: PurePosixPath) -> str:
    """The task that a path names: its innermost folder that is named like one, else the file."""
    names = [*reversed(path.parts[:-1]), path.stem]
    return next((name.lower() for name in names if _TASK_NAME.fullmatch(name)), "")


def _arms(paths: Sequence[PurePosixPath]) -> dict[str, str]:
    """`l` or `r` by the name of each file that has a counterpart for the other arm."""
    sides = [(path.stem, match) for path in paths if (match := _ARM_NAME.fullmatch(path.stem))]
    found: dict[tuple[str, str], set[str]] = {}
    for _, match in sides:
        found.setdefault((match[1], match[3]), set()).add(match[2][0].lower())
    return {stem: m[2][0].lower() for stem, m in sides if len(found[m[1], m[3]]) == 2}
