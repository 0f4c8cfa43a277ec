"""Backups in the layout that controllers write (reference, 4.3), and what a restore takes from one.

`BACKINFO`, `HOME`, `RAPID/TASK1/PROGMOD` and `SYSMOD`, `SYSPAR`. A restore brings the files of
HOME:, the modules and the system parameters back.
"""

from __future__ import annotations

import shutil
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.base.file_access import UNFINISHED, read_file, read_text, write_whole
from assistant.virtual.irc5.parameters import PARAMETER_DOMAINS, parse_cfg
from assistant.virtual.irc5.programs import TASK, Programs, read_module

if TYPE_CHECKING:
    from assistant.virtual.irc5.cabinet import Cabinet

BACKUP_FOLDERS: Final = {False: "PROGMOD", True: "SYSMOD"}
"""By whether a module is a SYSMODULE."""
MODULE_FOLDER_SUFFIXES: Final = {False: ".mod", True: ".sys"}


def back_up(programs: Programs, target: FilePath, cabinet: Cabinet) -> None:
    """Makes a folder, which appears whole or not at all; raises OSError."""
    beside = target.with_name(f"{UNFINISHED}{target.name}")
    shutil.rmtree(beside, ignore_errors=True)
    try:
        _write_backup(programs, beside, cabinet)
        beside.replace(target)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def _write_backup(programs: Programs, folder: FilePath, cabinet: Cabinet) -> None:
    home = cabinet.disk.folder("HOME")
    arriving = shutil.ignore_patterns(f"{UNFINISHED}*")
    (folder / "BACKINFO").mkdir(parents=True)
    told = f">>SYSTEM_ID:\n{cabinet.name}\n\n>>PRODUCTS_ID:\nRobotWare\n\n>>TASK1: ({TASK},,)\n"
    (folder / "BACKINFO" / "backinfo.txt").write_text(told, "latin-1")
    shutil.copytree(home, folder / "HOME", ignore=arriving)
    for system in (False, True):
        (folder / "RAPID" / "TASK1" / BACKUP_FOLDERS[system]).mkdir(parents=True)
    for one in programs.modules.values():
        file = (
            folder
            / "RAPID"
            / "TASK1"
            / BACKUP_FOLDERS[one.system]
            / f"{one.name}{MODULE_FOLDER_SUFFIXES[one.system]}"
        )
        file.write_bytes(programs.text(one).encode("latin-1", "replace"))
    (folder / "SYSPAR").mkdir()
    for domain in PARAMETER_DOMAINS:
        text = cabinet.parameters.text(domain)
        (folder / "SYSPAR" / f"{domain}.cfg").write_text(text, "latin-1", "replace")


def is_backup(folder: FilePath) -> bool:
    return (folder / "BACKINFO").is_dir() and (folder / "RAPID").is_dir()


def restore(programs: Programs, source: FilePath, cabinet: Cabinet) -> None:
    """Raises NotPossible or ValueError for what cannot be loaded, and changes nothing; OSError."""
    files = sorted((source / "RAPID").glob("TASK1/*/*"))
    read = [one for file in files for one in read_module(file.name, read_file(file))]
    settings = [read_text(file, "latin-1") for file in sorted((source / "SYSPAR").glob("*.cfg"))]
    for text in settings:
        parse_cfg(text)
    home, kept = cabinet.disk.folder("HOME"), source / "HOME"
    programs.restore(read)
    for text in settings:
        cabinet.parameters.load(text, "add-with-reset")
    _restore_files(kept, home)


def _restore_files(kept: FilePath, home: FilePath) -> None:
    """Has a folder hold what another one does; each file of it is whole at any time."""
    wanted = {one.relative_to(kept): one for one in sorted(kept.rglob("*"))}
    for name, one in wanted.items():
        target = home / name
        if target.exists() and target.is_dir() != one.is_dir():
            _remove_folder(target)
        if one.is_dir():
            target.mkdir(exist_ok=True)
        else:
            write_whole(target, one.read_bytes())
    for old in sorted(home.rglob("*"), reverse=True):
        if old.relative_to(home) not in wanted:
            _remove_folder(old)


def _remove_folder(old: FilePath) -> None:
    if old.is_dir() and not old.is_symlink():
        shutil.rmtree(old)
    else:
        old.unlink()
