"""Backups in the layout that controllers write (reference, 4.3), and what a restore takes from one.

`BACKINFO`, `HOME`, `RAPID/TASK1/PROGMOD` and `SYSMOD`, `SYSPAR`. A restore brings the files of
HOME: and the modules back; the system parameters of this controller are what it was started with.
"""

from __future__ import annotations

import shutil
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final

from assistant.virtual.atomic import ARRIVING
from assistant.virtual.irc5.programs import TASK, Programs, read_module

if TYPE_CHECKING:
    from assistant.virtual.irc5.cabinet import Cabinet

FOLDERS: Final = {False: "PROGMOD", True: "SYSMOD"}
"""By whether a module is a SYSMODULE."""
SUFFIXES: Final = {False: ".mod", True: ".sys"}
DOMAINS: Final = ("EIO", "MMC", "MOC", "PROC", "SIO", "SYS")
HEAD: Final = "{domain}:CFG_1.0:6:1::\n#\n"
TASK_ROW: Final = f'CAB_TASKS:\n\n      -Name "{TASK}" -Type "NORMAL" -Entry "main" -MotionTask\n'


def back_up(programs: Programs, target: FilePath, cabinet: Cabinet) -> None:
    """Makes a folder, which appears whole or not at all; raises OSError."""
    beside = target.with_name(f"{ARRIVING}{target.name}")
    shutil.rmtree(beside, ignore_errors=True)
    try:
        _write(programs, beside, cabinet)
        beside.replace(target)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def _write(programs: Programs, folder: FilePath, cabinet: Cabinet) -> None:
    home = cabinet.disk.folder("HOME")
    arriving = shutil.ignore_patterns(f"{ARRIVING}*")
    (folder / "BACKINFO").mkdir(parents=True)
    told = f">>SYSTEM_ID:\n{cabinet.name}\n\n>>PRODUCTS_ID:\nRobotWare\n\n>>TASK1: ({TASK},,)\n"
    (folder / "BACKINFO" / "backinfo.txt").write_text(told, "latin-1")
    shutil.copytree(home, folder / "HOME", ignore=arriving)
    for system in (False, True):
        (folder / "RAPID" / "TASK1" / FOLDERS[system]).mkdir(parents=True)
    for one in programs.modules.values():
        file = (
            folder / "RAPID" / "TASK1" / FOLDERS[one.system] / f"{one.name}{SUFFIXES[one.system]}"
        )
        file.write_bytes(programs.text(one).encode("latin-1", "replace"))
    (folder / "SYSPAR").mkdir()
    for domain in DOMAINS:
        body = {"EIO": _signals(cabinet), "SYS": TASK_ROW}.get(domain, "")
        (folder / "SYSPAR" / f"{domain}.cfg").write_text(HEAD.format(domain=domain) + body)


def _signals(cabinet: Cabinet) -> str:
    rows = [
        f'      -Name "{one.name}" -SignalType "{one.type}" -Device "{one.device}" -Access "All"\n'
        for one in cabinet.given.values()
    ]
    return "EIO_SIGNAL:\n\n" + "\n".join(rows)


def is_backup(folder: FilePath) -> bool:
    return (folder / "BACKINFO").is_dir() and (folder / "RAPID").is_dir()


def restore(programs: Programs, source: FilePath, cabinet: Cabinet) -> None:
    """Raises NotPossible if a module cannot be loaded, and changes nothing; or OSError."""
    files = sorted((source / "RAPID").glob("TASK1/*/*"))
    read = [one for file in files for one in read_module(file.name, file.read_bytes())]
    home, kept = cabinet.disk.folder("HOME"), source / "HOME"
    programs.restore(read)
    for old in home.iterdir():
        if old.is_dir():
            shutil.rmtree(old)
        else:
            old.unlink()
    if kept.is_dir():
        shutil.copytree(kept, home, dirs_exist_ok=True)
