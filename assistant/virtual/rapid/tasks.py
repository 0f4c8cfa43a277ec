"""Files of RAPID in the tasks of a controller: modules of a folder, and whole backups.

A backup keeps the modules of a task in `RAPID/TASKn/PROGMOD` and `SYSMOD`, those that all tasks
share in `RAPID/TASK0`, the names of the tasks in `BACKINFO/backinfo.txt`, and how they start in
`SYSPAR/SYS.cfg`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from assistant import languages
from assistant.base.diagnostics import Refused, error
from assistant.base.file_access import read_text
from assistant.virtual.parts import Group

SEVERAL_FOLDERS: Final = error(
    "VC204",
    "the folder holds programs in several folders: {names}",
    "name the folder of one task, a backup, or the modules that one task loads",
)
SEVERAL_LISTS: Final = error(
    "VC205",
    "the folder holds several lists of programs: {names}",
    "name the one that the task loads",
)
DEFAULT_TASK: Final = "T_ROB1"
PROGRAM_LIST: Final = ".pgf"
SHARED_TASK: Final = "TASK0"
_BACKUP_FOLDER: Final = re.compile(r"(?i)(?:^|/)RAPID/(TASK\d+)$")
_TASK_NAME: Final = re.compile(r"(?im)^>>\s*(TASK\d+)\s*:\s*\(\s*([A-Za-z]\w*)")
_TASK_TABLE: Final = re.compile(r"(?ims)^CAB_TASKS:(.*?)(?:^\S|\Z)")
_ATTRIBUTE: Final = re.compile(r'-(\w+)(?:\s+"([^"]*)")?')


def rapid_tasks(files: Sequence[str], folder: str | None) -> list[Group]:
    """The task that moves the robot first. Files that were named are all of one task."""
    if folder is None:
        return [Group(DEFAULT_TASK, tuple(files))]
    language = languages.get("rapid")
    inside: dict[Path, list[str]] = {}
    for file in files:
        inside.setdefault(language.program_of(Path(file)), []).append(file)
    backup = {found[1].upper(): path for path in inside if (found := _backup_task(path))}
    if backup:
        return list(_backup_groups(backup, inside))
    if len(inside) > 1:
        names = ", ".join(f"`{path}`" for path in inside)
        raise Refused(SEVERAL_FOLDERS(path=folder, names=names), exit_status=2)
    return [Group(DEFAULT_TASK, _folder_modules(folder, files), beside=False)]


def _backup_task(path: Path) -> re.Match[str] | None:
    return _BACKUP_FOLDER.search(path.absolute().as_posix())


def _folder_modules(folder: str, files: Sequence[str]) -> tuple[str, ...]:
    """The modules of a folder, without the list that names them."""
    lists = [file for file in files if file.lower().endswith(PROGRAM_LIST)]
    if len(lists) > 1:
        names = ", ".join(f"`{Path(file).name}`" for file in lists)
        raise Refused(SEVERAL_LISTS(path=folder, names=names), exit_status=2)
    return tuple(file for file in files if file not in lists) or tuple(lists)


def _backup_groups(backup: dict[str, Path], inside: dict[Path, list[str]]) -> Iterator[Group]:
    root = next(iter(backup.values())).absolute().parents[1]
    names = {key.upper(): name for key, name in _TASK_NAME.findall(_backup_text(root, "BACKINFO"))}
    rows = list(_task_rows(_backup_text(root, "SYSPAR")))
    moving = {row["Name"] for row in rows if "MotionTask" in row and "Name" in row}
    beside = {
        row.get("Name", "") for row in rows if row.get("Type", "").upper() in BACKGROUND_TYPES
    }
    shared = [f for key, path in backup.items() if key == SHARED_TASK for f in inside[path]]
    found = []
    for key, path in sorted(backup.items()):
        if key == SHARED_TASK:
            continue
        name = names.get(key) or (DEFAULT_TASK if key == "TASK1" else key)
        modules = (*_folder_modules(str(path), inside[path]), *shared)
        found.append(Group(name, modules, essential=name not in beside, beside=False))
    yield from sorted(found, key=lambda group: group.name not in moving)


BACKGROUND_TYPES: Final = ("STATIC", "SEMISTATIC")
"""Types of tasks that run all the time, whether or not the others have ended."""
BACKUP_FILES: Final = {"BACKINFO": "backinfo.txt", "SYSPAR": "SYS.cfg"}


def _backup_text(root: Path, folder: str) -> str:
    """A file of a backup, empty where it is not there or may not be read."""
    try:
        return read_text(root / folder / BACKUP_FILES[folder], "latin-1")
    except OSError:
        return ""


def _task_rows(text: str) -> Iterator[dict[str, str]]:
    """The tasks that the system parameters state, by their attributes."""
    table = _TASK_TABLE.search(text)
    if table is None:
        return
    for row in re.split(r"(?m)^\s*(?=-Name\b)", table[1].replace("\\\n", " ")):
        if attributes := dict(_ATTRIBUTE.findall(row)):
            yield attributes
