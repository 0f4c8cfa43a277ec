"""Facts from a controller backup: system parameters, signals, and data that tasks share.

`SYSPAR` holds `EIO.cfg` with the signals, `SYS.cfg` with the tasks, `MOC.cfg` with the robot and
its external axes, `PROC.cfg` with the equipment of processes; `BACKINFO/backinfo.txt` tells which
task each folder `RAPID/TASKn` is: `>>TASK1: (T_ROB1,MyProgram,)`. A folder of RobotStudio for a
virtual controller has the same files. RobotWare 5 has `Unit` and `UnitMap`, 6 and 7 have `Device`
and `DeviceMap`. A row is `-Name "doGrip" -SignalType "DO"`; a backslash at its end continues it.

Other controllers have a few variables that all programs share, with fixed names: `M_00` to `M_19`
for numbers and truths, `C_00` to `C_19` for texts (MELFA-BASIC, CR1D 4.3.7). One of the tasks gives
the first value.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, Final, Literal

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.base.source_text import SourceText, one_line
from assistant.languages.language_types import (
    ControllerConfiguration,
    SharedData,
    Texts,
    catalogue_name,
    file_named,
)
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.constants import CONTROLLER_STATES
from assistant.languages.rapid.tables.signals import ARC_OUTPUT
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.changed_data import changed_names
from assistant.languages.rapid.tree.literals import EXTERNAL_AXES, literal_values, still_axis_name
from assistant.languages.rapid.tree.walk import nodes, renamed
from assistant.program.geometry import Pose
from assistant.program.program import Signal
from assistant.program.rewriting import rewrite
from assistant.program.undeclared_names import SuppliedValue, WantedKind

_SECTION: Final = re.compile(r"(?m)^([A-Z][A-Z0-9_]*):[ \t]*$")
_HEADER: Final = re.compile(r"\s*[A-Z]+:CFG")
_ATTRIBUTE: Final = re.compile(r'-([A-Za-z]\w*)(?:[ \t]+(?:"([^"\n]*)"|(-?[0-9.][0-9.eE+-]*)))?')


def _rows_of(text: str, section: str) -> Iterator[dict[str, str]]:
    """The attributes of each row of a section; those without a value have an empty one."""
    for name, body in _sections(text):
        if name == section:
            yield from _attribute_rows(body)


def _sections(text: str) -> Iterator[tuple[str, str]]:
    """The sections of a file, each with its name and its text."""
    # A backslash at the end of a line continues the row.
    joined = text.replace("\r\n", "\n").replace("\\\n", " ")
    pieces = _SECTION.split(joined)
    # The text before the first section is the header; after it names and bodies alternate.
    yield from zip(pieces[1::2], pieces[2::2], strict=False)


def _all_rows(text: str, prefix: str) -> Iterator[dict[str, str]]:
    """The rows of all sections whose names begin in a way."""
    for name, body in _sections(text):
        if name.startswith(prefix):
            yield from _attribute_rows(body)


def _is_known(text: str) -> bool:
    """True if a text looks like a file of system parameters."""
    return _HEADER.match(text) is not None or next(_sections(text), None) is not None


def _attribute_rows(body: str) -> Iterator[dict[str, str]]:
    for line in body.split("\n"):
        if line.lstrip().startswith("-"):
            found = _ATTRIBUTE.finditer(line)
            yield {one[1]: one[2] if one[2] is not None else one[3] or "" for one in found}


_SignalKind = Literal["digital", "analog", "group"]
_PARAMETER_SIGNAL_TYPES: Final[dict[str, tuple[_SignalKind, bool]]] = {
    "DI": ("digital", True),
    "DO": ("digital", False),
    "AI": ("analog", True),
    "AO": ("analog", False),
    "GI": ("group", True),
    "GO": ("group", False),
}
"""Types of signals: what they are, and whether they are inputs."""
_DEVICE_BITS: Final = 16
"""Bits of one device are counted from a multiple of this, behind those of the device before."""
_BIT_SPAN: Final = re.compile(r"(\d{1,5})(?:-(\d{1,5}))?")


def signals_of_file(text: str) -> ControllerConfiguration:
    """The signals of a file; those that name no type which there is are among the `unread`.

    Each device has its numbers behind those of the device before, as its map counts them.
    """
    rows, unread = [], []
    for row in _rows_of(text, "EIO_SIGNAL"):
        name, kind = (
            row.get("Name", ""),
            _PARAMETER_SIGNAL_TYPES.get(row.get("SignalType", "").upper()),
        )
        if kind is None or not name:
            unread.append(name or "a signal without a name")
            continue
        device = row.get("Device", row.get("Unit", "")).lower()
        begin, bits = _bits_of_map(row.get("DeviceMap", row.get("UnitMap", "")))
        # Only digital signals and groups are numbered by bits.
        rows.append(_SignalRow(name, *kind, device, None if kind[0] == "analog" else begin, bits))
    starts = _first_numbers(rows)
    signals: dict[str, Signal] = {}
    for one in rows:
        number = None if one.begin is None else starts[one.input, one.device] + one.begin
        bits = one.bits if one.kind == "group" else 1
        signals[one.name] = Signal(one.kind, "input" if one.input else "output", number, bits)
    results = {row.get("Res", "").lower() for row in _rows_of(text, "EIO_CROSS")} - {""}
    return ControllerConfiguration(signals, frozenset(results), tuple(unread), _is_known(text))


@dataclass(frozen=True, slots=True)
class _SignalRow:
    """A signal as it is stated. begin: the bit of its device that it begins with, if it has one."""

    name: str
    kind: _SignalKind
    input: bool
    device: str
    begin: int | None
    bits: int


def _bits_of_map(written: str) -> tuple[int | None, int]:
    """First bit and number of bits of a map; no first bit where they do not follow each other."""
    spans = [_BIT_SPAN.fullmatch(part.strip()) for part in written.split(",")]
    read = [(int(span[1]), int(span[2] or span[1])) for span in spans if span is not None]
    # A map in another notation gives no number.
    if len(read) < len(spans):
        return None, 1
    bits = sum(abs(end - begin) + 1 for begin, end in read)
    rising = all(begin <= end for begin, end in read)
    joined = all(end + 1 == begin for (_, end), (begin, _) in pairwise(read))
    return (read[0][0] if rising and joined else None), bits


def _first_numbers(rows: Sequence[_SignalRow]) -> dict[tuple[bool, str], int]:
    """The number of bit 0 of each device, of its inputs and of its outputs."""
    ends: dict[tuple[bool, str], int] = {}
    for row in rows:
        if row.begin is not None:
            key = row.input, row.device
            ends[key] = max(ends.get(key, 0), row.begin + row.bits)
    starts: dict[tuple[bool, str], int] = {}
    after = {True: 0, False: 0}
    for (is_input, device), end in ends.items():
        starts[is_input, device] = after[is_input]
        # Rounds up to whole devices.
        after[is_input] += -(-end // _DEVICE_BITS) * _DEVICE_BITS
    return starts


_SIGNALS_FILE: Final = "eio.cfg"
_PARAMETERS_FOLDER: Final = "syspar"
_MOST_FOLDERS_ABOVE: Final = 3
"""Folders above a module in which the system parameters may stand: PROGMOD, TASKn, RAPID."""
_FIRST_EXTERNAL_AXIS: Final = 7
"""Logical axis that is `eax_a`."""
_TASKS_SECTION: Final = "CAB_TASKS"
_CALLED_ROUTINES: Final = (
    ("sys", "CAB_EXEC_HOOKS", "Routine", "at {Shelf}"),
    ("sys", _TASKS_SECTION, "Entry", "as the start of the task `{Name}`"),
    ("eio", "SYSSIG_IN", "Arg1", "by the signal `{Signal}`"),
    ("mmc", "MMC_SERV_ROUT", "name", "as a service routine"),
)
"""Files, their sections and the attribute that names a routine which the controller calls."""
_SYSTEM_SIGNALS: Final = (
    ("SYSSIG_IN", "Action", "commands"),
    ("SYSSIG_OUT", "Status", "shows"),
)
"""Sections of signals that the controller itself reads and sets, with what each is wired to."""
_INTERRUPT_ACTION: Final = "Interrupt"
"""Action of an input of the system that calls a routine."""
_NORMAL_TASK: Final = "NORMAL"
"""Type of a task that is started and stopped with the robot."""
_ROBOT_TYPE: Final = re.compile(r"ROB\d+_(\d+)((?:_\w*?[0-9.]*)*)", re.IGNORECASE)
_FIGURE: Final = re.compile(r"(?<=_)\d+(?:\.\d+)?(?=_|\Z)")
_BACKUP_TASK: Final = re.compile(r"(?m)^>>TASK(\d+):[ \t]*\(([^,)\r\n]*)")
_TASK_FOLDER: Final = re.compile(r"(?i)(?:^|/)RAPID/TASK(\d+)(?:/|$)")
_WELD_ON: Final = "weldon"
"""Attribute of the equipment of arc welding, without `_`: the output that lights the arc."""


def signals_file(module: FilePath) -> FilePath | None:
    """Return the file with the controller's signals, for a module in a backup.

    The file is `EIO.cfg` in the folder of the module, or in `SYSPAR` of one of the folders above.
    """
    folders = [module.absolute().parent, *module.absolute().parent.parents[:_MOST_FOLDERS_ABOVE]]
    for place, folder in enumerate(folders):
        if place == 0 and (found := file_named(folder, _SIGNALS_FILE)) is not None:
            return found
        inner = file_named(folder, _PARAMETERS_FOLDER)
        if inner is not None and (found := file_named(inner, _SIGNALS_FILE)) is not None:
            return found
    return None


def backup_configuration(module: FilePath, read: Texts) -> ControllerConfiguration:
    """Return the configuration in the controller's files, for a module in a backup."""
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
        if path is not None and content is not None and _is_known(content):
            texts[name] = content
    return _SystemParameters(module, folder, texts, found, read).stated()


def _parameters_folder(module: FilePath) -> FilePath | None:
    folders = [module.absolute().parent, *module.absolute().parent.parents[:_MOST_FOLDERS_ABOVE]]
    inner = (file_named(folder, _PARAMETERS_FOLDER) for folder in folders)
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
        kind = row.get("Type", _NORMAL_TASK)
        if kind.upper() != _NORMAL_TASK:
            findings.append(rules.OTHER_TASK(task=task, kind=kind, path=str(self.folder)))
        arm, told = self.arm(task)
        frame = self.base(task)
        if frame is not None:
            findings.append(rules.BASE_FRAME(where=frame, path=str(self.folder)))
        wired = list(self.system_signals())
        if wired:
            path = self.found.source or self.folder
            findings.append(rules.SYSTEM_SIGNALS(signals=", ".join(wired), path=str(path)))
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
        return [
            row for row in _rows_of(self.texts.get("sys", ""), _TASKS_SECTION) if row.get("Name")
        ]

    def called(self, task: str) -> Iterator[tuple[str, str]]:
        """Routines that the controller calls, in lower case, each with the event that calls it."""
        when: dict[str, list[str]] = {}
        for file, section, key, words in _CALLED_ROUTINES:
            for row in _rows_of(self.texts.get(file, ""), section):
                own = (
                    ""
                    # A row for all tasks names none, so it applies to every task.
                    if "AllTask" in row
                    else row.get("Name" if section == _TASKS_SECTION else "Task")
                )
                # Only this action of an input calls a routine.
                if row.get("Action", _INTERRUPT_ACTION) != _INTERRUPT_ACTION or key not in row:
                    continue
                if not task or not own or own.lower() == task.lower():
                    known = when.setdefault(row[key].lower(), [])
                    known.append(words.format_map(defaultdict(str, row)))
        # Equipment names its routines in attributes that differ from process to process, so every
        # text counts as one.
        for row in _all_rows(self.texts.get("proc", ""), ""):
            for value in row.values():
                if value and not _is_number_text(value):
                    when.setdefault(value.lower(), ["in a process"])
        return ((name, " and ".join(dict.fromkeys(said))) for name, said in when.items())

    def system_signals(self) -> Iterator[str]:
        """Inputs that command the controller and outputs that show its state, in words.

        Inputs that call a routine are reported at the routine.
        """
        for section, key, way in _SYSTEM_SIGNALS:
            for row in _rows_of(self.texts.get("eio", ""), section):
                signal, what = row.get("Signal"), row.get(key)
                if signal and what and what != _INTERRUPT_ACTION:
                    yield f"`{signal}` {way} {what}"

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
        # Without the list of the backup, the folder is named like its task, or there is only one.
        return next((t for t in tasks if t.lower() == own or len(tasks) == 1), "")

    def row_of(self, task: str) -> dict[str, str]:
        return next((row for row in self.tasks() if row["Name"].lower() == task.lower()), {})

    def robots(self, task: str) -> list[dict[str, str]]:
        """The robot of a task: the only one, or that of its number, ROB_2 of T_ROB2."""
        rows = list(_rows_of(self.texts.get("moc", ""), "ROBOT"))
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
        """Describe the base of a robot that is not at the world's origin, None if it is."""
        for row in self.robots(task):
            # System parameters are in metres.
            places = [1000 * _parameter_number(row, f"base_frame_pos_{axis}") for axis in "xyz"]
            turn = [
                _parameter_number(row, f"base_frame_orient_u{n}", float(n == 0)) for n in range(4)
            ]
            pose = Pose(tuple(places), tuple(turn))  # type: ignore[arg-type]
            # The opposite sign of all parts is the same orientation.
            if np.abs(places).max() > 1e-6 or abs(abs(turn[0]) - 1) > 1e-9:
                x, y, z = (f"{one:g}" for one in pose.position)
                turned = "" if abs(abs(turn[0]) - 1) < 1e-9 else ", turned"
                return f"({x}, {y}, {z}) mm{turned}"
        return None

    def axes(self) -> Iterator[tuple[tuple[WantedKind, str], SuppliedValue]]:
        """That external axes stand still which the controller has not."""
        rows = list(_rows_of(self.texts.get("moc", ""), "JOINT"))
        if not rows:
            return
        there = {round(_parameter_number(row, "logical_axis")) for row in rows}
        for number, axis in enumerate(EXTERNAL_AXES, _FIRST_EXTERNAL_AXIS):
            if number not in there:
                yield ("data", still_axis_name(axis)), True

    def burning(self) -> dict[str, Signal]:
        """The output that lights the arc, if it is one that the controller has."""
        outputs = {n.lower(): s for n, s in self.found.signals.items() if s.direction == "output"}
        names = {
            value.lower()
            for row in _all_rows(self.texts.get("proc", ""), "ARC")
            for key, value in row.items()
            if key.replace("_", "").lower() == _WELD_ON
        }
        # With several outputs, nothing shows which one lights the arc of this program.
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


_SHARED_LETTERS: Final[Mapping[str, str]] = {"num": "M", "bool": "M", "string": "C"}
"""By type: the letter of variables of all programs."""
_SHARED_NUMBERS: Final = tuple(f"{number:02}" for number in range(20))
"""Numbers after the letter and an underscore in shared names, the same on every controller."""

TaskFiles = Sequence[s.File]


def with_shared_data(tasks: Sequence[tuple[str, TaskFiles]]) -> list[SharedData]:
    """The files of each task of a controller, by the task's name, with names for all programs."""
    unlike = _unlike_values(tasks)
    tasks = _with_values_of_others(tasks)
    declared = [dict(_persistent_data(files)) for _, files in tasks]
    count = Counter(name for one in declared for name in one)
    # Persistents that no task changes keep their value in each program, without sharing.
    both = {name for name, many in count.items() if many > 1}
    files = {id(file): file for _, given in tasks for file in given}
    modules = [module for file in files.values() for module in file.modules]
    changed = both & changed_names(modules) if both else set()
    if not changed:
        return [
            SharedData(tuple(given), tuple(told))
            for (_, given), told in zip(tasks, unlike, strict=True)
        ]
    taken = {name.upper() for file in files.values() for name in _used_names(file)}
    free = {
        letter: iter([f"{letter}_{n}" for n in _SHARED_NUMBERS if f"{letter}_{n}" not in taken])
        for letter in "MC"
    }
    names: dict[str, str] = {}
    for name in sorted(changed):
        kinds = {_shared_kind(one[name]) for one in declared if name in one}
        # Tasks that declare a name with different types do not share it.
        letter = _SHARED_LETTERS.get(kinds.pop(), "") if len(kinds) == 1 else ""
        new = next(free[letter], None) if letter else None
        if new is not None:
            names[name] = new
    first = {name: next(at for at, one in enumerate(declared) if name in one) for name in changed}
    made = []
    for at, (_, given) in enumerate(tasks):
        own = {name: data for name, data in declared[at].items() if name in changed}
        # One task alone gives the first value: a second would overwrite what the first has counted
        # by then.
        kept = {name for name in names if first[name] == at}
        found = [
            _sharing_finding(
                data, names.get(name), tasks[first[name]][0] if first[name] != at else ""
            )
            for name, data in own.items()
        ]
        made.append(
            SharedData(
                tuple(_renamed_file(file, names, kept) for file in given), (*unlike[at], *found)
            )
        )
    return made


_MOST_OF_VALUE: Final = 40
"""Characters of a value that a finding shows."""


def _unlike_values(tasks: Sequence[tuple[str, TaskFiles]]) -> list[list[Diagnostic]]:
    """Return for each task its persistent data that an earlier one states another value of."""
    first: dict[tuple[str, str, int], tuple[Any, s.Expression, SourceText]] = {}
    found: list[list[Diagnostic]] = []
    for _, files in tasks:
        constants, told = _PlainConstants(files), list[Diagnostic]()
        found.append(told)
        for file in files:
            for name, data in _persistent_data((file,)):
                text = file.source
                if data.value is None or data.value.span is None or text is None:
                    continue
                plain = rewrite(data.value, constants.of)
                if _names_any(plain):
                    continue
                key = name, data.type.lower(), len(data.dimensions)
                values = literal_values(plain)
                compared = plain if _is_worked_out(values) else values
                other, value, there = first.setdefault(key, (compared, data.value, text))
                if compared != other and value.span is not None:
                    line, _ = there.line_column(value.span.start)
                    told.append(
                        text.finding(
                            rules.OTHER_VALUE,
                            data.span or data.value.span,
                            name=data.name,
                            value=_shown_value(data.value, text),
                            other=_shown_value(value, there),
                            there=f"{there.path}:{line}",
                        )
                    )
    return found


def _is_worked_out(values: Any) -> bool:
    """True if a value is no literal, or an item of it is none."""
    if isinstance(values, list):
        return any(map(_is_worked_out, values))
    return values is None


def _shown_value(value: s.Expression, text: SourceText) -> str:
    """Return the beginning of a value as it is written."""
    assert value.span is not None
    written = one_line(text.text[value.span.start : value.span.end])
    return written if len(written) <= _MOST_OF_VALUE else f"{written[:_MOST_OF_VALUE]}…"


def _with_values_of_others(
    tasks: Sequence[tuple[str, TaskFiles]],
) -> Sequence[tuple[str, TaskFiles]]:
    """The tasks with values for persistent data that only another task states the value of."""
    values: dict[tuple[str, str, int], s.Expression] = {}
    lacking = False
    for _, files in tasks:
        constants = _PlainConstants(files)
        for name, data in _persistent_data(files):
            lacking |= data.value is None
            # A name may be another constant in another task, or none.
            value = None if data.value is None else rewrite(data.value, constants.of)
            if value is not None and not _names_any(value):
                values.setdefault((name, data.type.lower(), len(data.dimensions)), value)
    if not lacking:
        return tasks

    def of_item(item: s.Item) -> s.Item:
        if isinstance(item, s.Data) and item.storage == "PERS" and not item.scope:
            key = item.name.lower(), item.type.lower(), len(item.dimensions)
            if item.value is None and key in values:
                # Its places are in another text.
                return replace(item, value=rewrite(values[key], _without_place))
        return item

    def of_part(part: Any) -> Any:
        if not isinstance(part, s.Module):
            return part
        items = tuple(map(of_item, part.items))
        same = all(a is b for a, b in zip(items, part.items, strict=True))
        return part if same else replace(part, items=items)

    return [
        (name, [replace(file, parts=tuple(map(of_part, file.parts))) for file in files])
        for name, files in tasks
    ]


def _names_any(value: s.Expression) -> bool:
    return any(isinstance(node, s.NameRef) for node in nodes((value,)))


class _PlainConstants:
    """The constants of a task whose value names nothing, and that one module alone declares."""

    def __init__(self, files: TaskFiles) -> None:
        data = [x for f in files for m in f.modules for x in m.items if isinstance(x, s.Data)]
        count = Counter(one.name.lower() for one in data)
        self._values = {
            one.name.lower(): one.value
            for one in data
            if one.storage == "CONST"
            and one.value is not None
            and count[one.name.lower()] == 1
            and not _names_any(one.value)
        }

    def of(self, node: Any) -> Any:
        """The value of a constant, any other node as it is."""
        return self._values.get(node.name.lower(), node) if isinstance(node, s.NameRef) else node


def _without_place(node: Any) -> Any:
    return replace(node, span=None) if isinstance(node, s.Node) else node


def _persistent_data(files: TaskFiles) -> Iterator[tuple[str, s.Data]]:
    """The data of a task that others may share, by lower-case name."""
    for file in files:
        for module in file.modules:
            for item in module.items:
                if isinstance(item, s.Data) and item.storage == "PERS" and not item.scope:
                    yield item.name.lower(), item


def _shared_kind(data: s.Data) -> str:
    return data.type.lower() if not data.dimensions else ""


def _used_names(file: s.File) -> Iterator[str]:
    for node in nodes(file.modules):
        if isinstance(node, s.NameRef | s.Data | s.ParameterNode):
            yield node.name


def _sharing_finding(data: s.Data, new: str | None, first: str) -> Diagnostic:
    if new is None:
        return rules.NOT_SHARED(name=data.name)
    return rules.SHARED(
        name=data.name, new=new, begins=f"the program of `{first}`" if first else "this program"
    )


def _renamed_file(file: s.File, names: Mapping[str, str], kept: set[str]) -> s.File:
    """kept: names in lower case whose first value the task gives."""

    def of_module(module: s.Module) -> s.Module:
        own = {
            item.name.lower()
            for item in module.items
            if isinstance(item, s.Data) and (item.scope or item.storage != "PERS")
        }
        # Data of the module hides the shared name.
        said = {name: new for name, new in names.items() if name not in own}
        return replace(module, items=tuple(renamed(bare(item), said) for item in module.items))

    def bare(item: s.Item) -> s.Item:
        if isinstance(item, s.Data) and item.storage == "PERS" and not item.scope:
            if item.name.lower() in names and item.name.lower() not in kept:
                return replace(item, value=None)
        return item

    parts = (of_module(one) if isinstance(one, s.Module) else one for one in file.parts)
    return replace(file, parts=tuple(parts))
