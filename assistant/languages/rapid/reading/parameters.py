"""What the system parameters of a controller state of the programs in its backup.

`SYSPAR` holds `EIO.cfg` with the signals, `SYS.cfg` with the tasks, `MOC.cfg` with the robot and
its external axes, `PROC.cfg` with the equipment of processes; `BACKINFO/backinfo.txt` tells which
task each folder `RAPID/TASKn` is: `>>TASK1: (T_ROB1,MyProgram,)`. A folder of RobotStudio for a
virtual controller has the same ones.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.languages.language_types import (
    ControllerConfiguration,
    Texts,
    catalogue_name,
    file_named,
)
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.parameter_rows import all_rows, is_known, rows_of
from assistant.languages.rapid.reading.signals import signals_of_file
from assistant.languages.rapid.tables.processes import ARC_OUTPUT
from assistant.languages.rapid.tables.states import CONTROLLER_STATES
from assistant.languages.rapid.tree.external_axes import EXTERNAL_AXES, still_axis_name
from assistant.program.geometry import Pose
from assistant.program.program import Signal
from assistant.program.undeclared_names import SuppliedValue, WantedKind

SIGNALS_FILE: Final = "eio.cfg"
PARAMETERS_FOLDER: Final = "syspar"
MOST_FOLDERS_ABOVE: Final = 3
"""Folders above a module in which the system parameters may stand: PROGMOD, TASKn, RAPID."""
FIRST_EXTERNAL_AXIS: Final = 7
"""Logical axis that is `eax_a`."""
TASKS_SECTION: Final = "CAB_TASKS"
CALLED_ROUTINES: Final = (
    ("sys", "CAB_EXEC_HOOKS", "Routine", "at {Shelf}"),
    ("sys", TASKS_SECTION, "Entry", "as the start of the task `{Name}`"),
    ("eio", "SYSSIG_IN", "Arg1", "by the signal `{Signal}`"),
    ("mmc", "MMC_SERV_ROUT", "name", "as a service routine"),
)
"""Files, their sections and the attribute that names a routine which the controller calls."""
INTERRUPT_ACTION: Final = "Interrupt"
"""Action of an input of the system that calls a routine."""
NORMAL_TASK: Final = "NORMAL"
"""Type of a task that is started and stopped with the robot."""
_ROBOT_TYPE: Final = re.compile(r"ROB\d+_(\d+)((?:_\w*?[0-9.]*)*)", re.IGNORECASE)
_FIGURE: Final = re.compile(r"(?<=_)\d+(?:\.\d+)?(?=_|\Z)")
_BACKUP_TASK: Final = re.compile(r"(?m)^>>TASK(\d+):[ \t]*\(([^,)\r\n]*)")
_TASK_FOLDER: Final = re.compile(r"(?i)(?:^|/)RAPID/TASK(\d+)(?:/|$)")
WELD_ON: Final = "weldon"
"""Attribute of the equipment of arc welding, without `_`: the output that lights the arc."""


def signals_file(module: FilePath) -> FilePath | None:
    """The file with the signals of the controller that a module stands in a backup of.

    `EIO.cfg` beside the module, or in `SYSPAR` of one of the folders above.
    """
    folders = [module.absolute().parent, *module.absolute().parent.parents[:MOST_FOLDERS_ABOVE]]
    for place, folder in enumerate(folders):
        if place == 0 and (found := file_named(folder, SIGNALS_FILE)) is not None:
            return found
        inner = file_named(folder, PARAMETERS_FOLDER)
        if inner is not None and (found := file_named(inner, SIGNALS_FILE)) is not None:
            return found
    return None


def backup_configuration(module: FilePath, read: Texts) -> ControllerConfiguration:
    """What the files of the controller that a module stands in a backup of state."""
    found = ControllerConfiguration()
    file = signals_file(module)
    text = None if file is None else read(file)
    if file is not None and text is not None:
        found = replace(signals_of_file(text), source=file)
    folder = _parameters_folder(module)
    if folder is None:
        return found
    texts = dict[str, str]()
    for name in ("sys", "moc", "proc", "eio", "mmc"):
        path = file_named(folder, f"{name}.cfg")
        content = None if path is None else read(path)
        if path is not None and content is not None and is_known(content):
            texts[name] = content
    return _SystemParameters(module, folder, texts, found, read).stated()


def _parameters_folder(module: FilePath) -> FilePath | None:
    folders = [module.absolute().parent, *module.absolute().parent.parents[:MOST_FOLDERS_ABOVE]]
    inner = (file_named(folder, PARAMETERS_FOLDER) for folder in folders)
    own = folders[0] if file_named(folders[0], "sys.cfg") is not None else None
    return next((folder for folder in inner if folder is not None), own)


@dataclass(frozen=True, slots=True)
class _SystemParameters:
    """The texts of the files in a folder `SYSPAR`, by name. found: what `EIO.cfg` states."""

    module: FilePath
    folder: FilePath
    texts: Mapping[str, str]
    found: ControllerConfiguration
    read: Texts

    def stated(self) -> ControllerConfiguration:
        values = dict[tuple[WantedKind, str], SuppliedValue]()
        task = self.task()
        findings = [*self.found.findings]
        if task:
            values["data", CONTROLLER_STATES["gettaskname"].name] = task
        row = self.row_of(task)
        kind = row.get("Type", NORMAL_TASK)
        if kind.upper() != NORMAL_TASK:
            findings.append(rules.OTHER_TASK(task=task, kind=kind, path=str(self.folder)))
        arm, told = self.arm(task)
        frame = self.base(task)
        if frame is not None:
            findings.append(rules.BASE_FRAME(where=frame, path=str(self.folder)))
        values |= dict(self.axes())
        signals = {**self.found.signals, **self.burning()}
        return replace(
            self.found,
            signals=signals,
            arm=arm,
            told=told,
            entry=row.get("Entry", "").lower() or None,
            called=dict(self.called(task)),
            values=values,
            findings=tuple(findings),
        )

    def tasks(self) -> list[dict[str, str]]:
        return [row for row in rows_of(self.texts.get("sys", ""), TASKS_SECTION) if row.get("Name")]

    def called(self, task: str) -> Iterator[tuple[str, str]]:
        """Routines that the controller calls, in lower case, each with the event that calls it."""
        when: dict[str, list[str]] = {}
        for file, section, key, words in CALLED_ROUTINES:
            for row in rows_of(self.texts.get(file, ""), section):
                own = (
                    ""
                    if "AllTask" in row
                    else row.get("Name" if section == TASKS_SECTION else "Task")
                )
                if row.get("Action", INTERRUPT_ACTION) != INTERRUPT_ACTION or key not in row:
                    continue
                if not task or not own or own.lower() == task.lower():
                    known = when.setdefault(row[key].lower(), [])
                    known.append(words.format_map(defaultdict(str, row)))
        for row in all_rows(self.texts.get("proc", ""), ""):
            for value in row.values():
                if value and not _is_number_text(value):
                    when.setdefault(value.lower(), ["in a process"])
        return ((name, " and ".join(dict.fromkeys(said))) for name, said in when.items())

    def task(self) -> str:
        """The name of the task that the module is loaded by, empty if nothing tells it."""
        place = _TASK_FOLDER.search(self.module.absolute().parent.as_posix())
        folder = file_named(self.folder.parent, "backinfo")
        info = None if folder is None else file_named(folder, "backinfo.txt")
        text = None if info is None else self.read(info)
        names: dict[str, str] = {n: name.strip() for n, name in _BACKUP_TASK.findall(text or "")}
        if place is not None and names.get(place[1]):
            return names[place[1]]
        own = self.module.absolute().parent.name.lower()
        tasks = [row["Name"] for row in self.tasks()]
        return next((t for t in tasks if t.lower() == own or len(tasks) == 1), "")

    def row_of(self, task: str) -> dict[str, str]:
        return next((row for row in self.tasks() if row["Name"].lower() == task.lower()), {})

    def robots(self, task: str) -> list[dict[str, str]]:
        """The robot of a task: the only one, or that of its number, ROB_2 of T_ROB2."""
        rows = list(rows_of(self.texts.get("moc", ""), "ROBOT"))
        number = re.search(r"\d+\Z", task)
        if len(rows) > 1 and number is not None:
            rows = [row for row in rows if row.get("name", "").lower() == f"rob_{number[0]}"]
        return rows if len(rows) == 1 else []

    def arm(self, task: str) -> tuple[str | None, str]:
        """The robot's name in the catalogue, and its type: `ROB1_1200_0.9_5_TypeB`."""
        for row in self.robots(task):
            told = row.get("use_robot_type", "")
            found = _ROBOT_TYPE.fullmatch(told)
            if found is not None:
                figures = frozenset(map(float, _FIGURE.findall(found[2])))
                return catalogue_name(f"irb{found[1]}", figures), told
            return None, told
        return None, ""

    def base(self, task: str) -> str | None:
        """Where a robot stands that does not stand at the world's origin, in words."""
        for row in self.robots(task):
            places = [1000 * _parameter_number(row, f"base_frame_pos_{axis}") for axis in "xyz"]
            turn = [
                _parameter_number(row, f"base_frame_orient_u{n}", float(n == 0)) for n in range(4)
            ]
            pose = Pose(tuple(places), tuple(turn))  # type: ignore[arg-type]
            if np.abs(places).max() > 1e-6 or abs(abs(turn[0]) - 1) > 1e-9:
                x, y, z = (f"{one:g}" for one in pose.position)
                turned = "" if abs(abs(turn[0]) - 1) < 1e-9 else ", turned"
                return f"({x}, {y}, {z}) mm{turned}"
        return None

    def axes(self) -> Iterator[tuple[tuple[WantedKind, str], SuppliedValue]]:
        """That external axes stand still which the controller has not."""
        rows = list(rows_of(self.texts.get("moc", ""), "JOINT"))
        if not rows:
            return
        there = {round(_parameter_number(row, "logical_axis")) for row in rows}
        for number, axis in enumerate(EXTERNAL_AXES, FIRST_EXTERNAL_AXIS):
            if number not in there:
                yield ("data", still_axis_name(axis)), True

    def burning(self) -> dict[str, Signal]:
        """The output that lights the arc, if it is one that the controller has."""
        outputs = {n.lower(): s for n, s in self.found.signals.items() if s.direction == "output"}
        names = {
            value.lower()
            for row in all_rows(self.texts.get("proc", ""), "ARC")
            for key, value in row.items()
            if key.replace("_", "").lower() == WELD_ON
        }
        found = [outputs[name] for name in names if name in outputs]
        return {ARC_OUTPUT: found[0]} if len(found) == 1 else {}


def _is_number_text(value: str) -> bool:
    try:
        float(value)
    except ValueError:
        return False
    return True


def _parameter_number(row: Mapping[str, str], key: str, usual: float = 0.0) -> float:
    try:
        return float(row.get(key, usual))
    except ValueError:
        return usual
