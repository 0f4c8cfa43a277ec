"""Content of the parameter lists next to a program: tools, bases, communication lines, slots, the
arm.

A list (`COMMON.PRM`, `RV-4FRL-D#1.PRM`) begins with `…NARC parameter system V1.0;`, one parameter a
line follows: `MEXTL=Uf,0,0,150,%r0,%r0,%r0;`. The first letter is the owner of the parameter, then
its type; `%r` marks radians. A project of RT ToolBox3 keeps the programs in `RC1/Program`, and
lists in the backups in `RC1/Backup` and in its copies of the controller. Seen in projects of CR750
and CR800 controllers; no manual describes it. Parameters: manual CR1D, chapter 5.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.language_types import (
    CommunicationLine,
    ControllerConfiguration,
    Texts,
    file_named,
)
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import LAST_SET_PARAMETERS
from assistant.program.geometry import Frame, Pose, Tool
from assistant.program.undeclared_names import SuppliedValue, WantedKind

HEAD: Final = "NARC parameter system"
SUFFIX: Final = ".prm"
_COMMON: Final = "common.prm"
PROGRAMS: Final = "program"
"""Folder of the programs in a project."""
_HELD: Final = ("corespace online", "paramofflineedit", "corespace")
"""Folders of a project with parameters, the surest first; backups come before them."""
_COPIES: Final = frozenset({"backup", "robosim", *_HELD})
_ROW: Final = re.compile(r"(?m)^([A-Z][A-Z0-9_]{0,15})=[UM][a-z],(.*?);[ \t]*$")
_VALUE: Final = re.compile(r'"([^"]*)"|([^,]+)')
_RADIANS: Final = "%r"
_NUMBERED: Final = re.compile(r"MEXTL([1-9]\d?)|WK([1-9]\d?)CORD")
_FIRST_PORT: Final = 10000
"""NETPORT of the first element; `OPT11` is the line of the second one."""
_SERVER: Final = "1"
"""NETMODE of a line that waits for others."""
_USUAL: Final = ("REP", "START")
"""A slot runs its program again and again, from the start signal on."""


def surroundings(program: FilePath, read: Texts) -> ControllerConfiguration:
    """Read the parameter lists of the controller next to a program."""
    for folder in _folders(program.absolute().parent):
        lists = {path.name.lower(): path for path in _lists(folder)}
        if not lists:
            continue
        common = _rows(lists.get(_COMMON), read)
        robot = common.get("MECHA1", [""])[0]
        file = lists.get(f"{robot.lower()}#1{SUFFIX}")
        others = [path for name, path in lists.items() if name.endswith(f"#1{SUFFIX}")]
        # Without a name of the arm, the only list of a robot there is the one meant.
        if file is None and not robot and len(others) == 1:
            file = others[0]
            robot = file.name[: -len(f"#1{SUFFIX}")]
        own = _rows(file, read)
        return ControllerConfiguration(
            arm=_arm(robot),
            told=robot,
            values=dict(_places(own)),
            lines=dict(_lines(common)),
            findings=tuple(_slots(program, common)),
        )
    return ControllerConfiguration()


def _folders(folder: FilePath) -> Iterator[FilePath]:
    """Yield the folders that may contain lists, the most reliable first: the program's own, or
    those of its project.
    """
    yield folder
    if folder.name.lower() == PROGRAMS:
        backups = file_named(folder.parent, "backup")
        if backups is not None and backups.is_dir():
            yield from sorted((path for path in backups.iterdir() if path.is_dir()), reverse=True)
        for name in _HELD:
            if (held := file_named(folder.parent, name)) is not None:
                yield held


def is_copy(path: FilePath) -> bool:
    """True if a file is in a project's backups, or in its copy of a controller."""
    for folder in path.absolute().parents:
        if folder.name.lower() in _COPIES:
            programs = file_named(folder.parent, PROGRAMS)
            return programs is not None and programs.is_dir()
    return False


def _lists(folder: FilePath) -> list[FilePath]:
    try:
        return sorted(path for path in folder.iterdir() if path.suffix.lower() == SUFFIX)
    except OSError:
        return []


def _rows(file: FilePath | None, read: Texts) -> dict[str, list[str]]:
    text = None if file is None else read(file)
    # The first line states the format; other programs have files with this suffix, too.
    if text is None or HEAD not in text.partition(";")[0]:
        return {}
    joined = text.replace("\r\n", "\n").replace("\r", "\n")
    return {name: [a or b for a, b in _VALUE.findall(body)] for name, body in _ROW.findall(joined)}


def _places(
    rows: Mapping[str, list[str]],
) -> Iterator[tuple[tuple[WantedKind, str], SuppliedValue]]:
    """Tools and bases, those that hold until a program sets others among them."""
    for name, values in rows.items():
        numbered = _NUMBERED.fullmatch(name)
        pose = _pose(values) if numbered or name in LAST_SET_PARAMETERS.values() else None
        if pose is None:
            continue
        if name == LAST_SET_PARAMETERS["Tool"] or (numbered and numbered[1]):
            yield ("tool", name.lower()), Tool(pose)
        else:
            yield ("frame", name.lower()), Frame(pose)


def _pose(values: list[str]) -> Pose | None:
    numbers = list[float]()
    for value in values:
        turned = value.startswith(_RADIANS)
        try:
            number = float(value.removeprefix(_RADIANS))
        except ValueError:
            return None
        numbers.append(math.degrees(number) if turned else number)
    return poses.plain_pose(tuple(numbers)) if len(numbers) >= len("XYZABC") else None


def _arm(told: str) -> str | None:
    """The arm in the catalogue: `rv-4frl` of RV-4FRL-D, without what tells its controller."""
    from assistant import robots

    name, known = told.lower(), robots.names()
    while name:
        if name in known:
            return name
        # Drop the last part of the name, which states the controller or the variant.
        name = name.rpartition("-")[0]
    return None


def _lines(rows: Mapping[str, list[str]]) -> Iterator[tuple[int, CommunicationLine]]:
    own = "".join(rows.get("NETIP", []))
    for number, device in enumerate(rows.get("COMDEV", []), 1):
        found = re.fullmatch(r"OPT1([1-9])", device)
        if found is None:
            if device.startswith("RS232"):
                yield number, ("serial", number, "")
            continue
        # The first element of NETPORT is the port of the controller itself.
        at = int(found[1])
        port = int(_at(rows, "NETPORT", at, str(_FIRST_PORT + at)))
        if _at(rows, "NETMODE", at - 1, _SERVER) == _SERVER:
            if own:
                yield number, ("server", port, own)
        elif address := _at(rows, "NETHSTIP", at - 1, ""):
            yield number, ("client", port, address)


def _at(rows: Mapping[str, list[str]], name: str, place: int, usual: str) -> str:
    values = rows.get(name, [])
    return values[place].strip() if place < len(values) else usual


def _slots(program: FilePath, rows: Mapping[str, list[str]]) -> Iterator[Diagnostic]:
    for number in range(1, 33):
        values = [one.strip().upper() for one in rows.get(f"SLT{number}", [])]
        if len(values) >= 3 and values[0] == program.stem.upper():
            if number > 1 or tuple(values[1:3]) != _USUAL:
                how = " ".join(values[1:3])
                yield rules.SLOT(name=program.stem, number=number, how=how)
