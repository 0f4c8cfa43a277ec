"""Cell files: values of what programs use and do not declare, as TOML.

Tools, frames, signals, joint speeds and lines are written as in a process file. Each other name
that no program declares has a table:

    [speeds.vSlow]
    speed = 50                    # mm/s

    [blends.zNear]
    blend = "fine"                # or mm

    [positions.pHome]
    position = [400, 0, 300]      # in the frame of the move, with euler_zyx or quaternion
    # joints = [0, 0, 0, 0, 90, 0]  # degrees, if it is given as joint angles

    [data.nParts]
    type = "bool"                 # as the program's language names it
    value = true

    [routines.rWash]
    routine = "empty"             # or "stop": the program stops there; or the name of its file

    [records.message]
    components = ["TYPE id", "TYPE text"]  # type and name of each, in order

    [lines.line_1]
    role = "client"               # or "server", "serial"
    port = 10001                  # of TCP; for a serial line the number of the port
    address = "192.168.0.5"       # of the other computer; of a server its own

    [arms.taught_on]
    arm = "irb1200-7-0.7"         # that joint angles were taught on; "same": it runs the program

A value that is still to be filled in is `"?"`, and its whole entry is ignored.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Any, Final, TypeVar

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.base.toml_edits import toml_key, toml_value, with_values
from assistant.base.toml_text import toml_content
from assistant.program import settings_tables
from assistant.program.geometry import Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.program import Signal
from assistant.program.settings_tables import ENCODINGS, Read, Table, Wrong, read_toml
from assistant.program.undeclared_names import (
    JOINT_SPEED,
    LINE_NAME,
    CallArgument,
    ChannelLine,
    Plain,
    SuppliedValue,
    Wanted,
    WantedKind,
)
from assistant.sources.process import NO_PROCESS, Process
from assistant.sources.process.file import process_in

V = TypeVar("V")

_OPEN_VALUE: Final = "?"
"""Placeholder for a value that is still to be filled in."""
TABLE_OF_KIND: Final[Mapping[WantedKind, str]] = {
    "tool": "tools", "frame": "frames", "speed": "speeds", "blend": "blends",
    "position": "positions", "joints": "positions", "signal": "signals", "data": "data",
    "routine": "routines", "record": "records", "arm": "arms", "line": "lines",
}  # fmt: skip
_CELL_TABLES: Final = ("speeds", "blends", "positions", "data", "routines", "records", "arms")
"""Tables that a process file has not."""
_SCENE_TABLES: Final = ("world", "robots", "bodies")
"""Tables of the same file that `assistant.cell` reads."""
_ENTRIES: Final = tuple(dict.fromkeys(TABLE_OF_KIND.values()))


def _read_plain_value(value: Any) -> Plain:
    match value:
        case bool() | str():
            return value
        case int() | float():
            return settings_tables.number("", least=-9e9, most=9e9)(value)  # type: ignore[no-any-return]
        case list():
            return tuple(map(_read_plain_value, value))
    raise Wrong("is a date or a table", "write a number, true, false, a text, or these in brackets")


def _read_joints(value: Any) -> JointTarget:
    if not isinstance(value, list) or not 1 <= len(value) <= 6:
        raise Wrong("is no list of joint angles", "write up to six numbers of degrees in brackets")
    return JointTarget(tuple(settings_tables.number("degrees")(one) for one in value))


def _read_components(value: Any) -> Plain:
    if not isinstance(value, list) or not value or not all(map(_is_component, value)):
        raise Wrong(
            "is no list of components",
            "write the type and the name of each, as a text",
        )
    return tuple(value)


def _is_component(value: Any) -> bool:
    return isinstance(value, str) and bool(re.fullmatch(r"[^\W\d]\w* [^\W\d]\w*", value))


_SPEED_KEYS: Final[Mapping[str, Read]] = {"speed": settings_tables.speed}
_BLEND_KEYS: Final[Mapping[str, Read]] = {"blend": settings_tables.blend}
POSITION_KEYS: Final[Mapping[str, Read]] = {
    "position": settings_tables.position,
    "quaternion": settings_tables.quaternion,
    "euler_zyx": settings_tables.euler_zyx,
    "joints": _read_joints,
}
DATA_KEYS: Final[Mapping[str, Read]] = {"type": settings_tables.name, "value": _read_plain_value}
ROUTINE_KEYS: Final[Mapping[str, Read]] = {"routine": settings_tables.text}
RECORD_KEYS: Final[Mapping[str, Read]] = {"components": _read_components}
ARM_KEYS: Final[Mapping[str, Read]] = {"arm": settings_tables.text}


@dataclass(frozen=True, slots=True)
class Cell:
    """Content of a cell file.

    process: its tools, frames, signals and joint speed. given: values of other names, by their
    table and their name in lower case. types: of data, by name in lower case. known: all of its
    entries by table and lower-case name, also those that are not filled in. open: those. text: of
    the file.
    """

    process: Process = NO_PROCESS
    given: Mapping[tuple[str, str], SuppliedValue] = field(default_factory=dict)
    types: Mapping[str, str] = field(default_factory=dict)
    known: frozenset[tuple[str, str]] = frozenset()
    open: frozenset[tuple[str, str]] = frozenset()
    text: str = ""

    def value(self, wanted: Wanted) -> SuppliedValue | None:
        """Return the value that the file states for a name, None if it is missing or not filled
        in.
        """
        low = wanted.name.lower()
        if wanted.kind == "tool":
            return _entries_of(self.process.tools, low)
        if wanted.kind == "frame":
            return _entries_of(self.process.frames, low)
        if wanted.kind == "line":
            return next(
                (v for n, v in self.process.lines.items() if LINE_NAME.format(n) == low), None
            )
        return self.given.get((TABLE_OF_KIND[wanted.kind], low))

    def signal(self, name: str) -> Signal | None:
        return _entries_of(self.process.signals, name.lower())


NO_CELL: Final = Cell()
CELL_FILE: Final = "cell.toml"
"""Name of a cell file that commands find without being told of it."""


def cell_file_beside(source: str | FilePath) -> FilePath | None:
    """Return the cell file of a program or folder that no option names, None if there is none.

    It is in the folder, in one above it as far as the current folder, or in the current one.
    """
    path, here = FilePath(source).absolute(), FilePath.cwd()
    folder = path if path.is_dir() else path.parent
    above = [one for one in folder.parents if here in (one, *one.parents)]
    for one in dict.fromkeys((folder, *above, here)):
        if (one / CELL_FILE).is_file():
            found = one / CELL_FILE
            return found.relative_to(here) if found.is_relative_to(here) else found
    return None


def _entries_of(table: Mapping[str, V], low: str) -> V | None:
    return next((value for name, value in table.items() if name.lower() == low), None)


def read_cell(path: str | FilePath) -> Cell:
    """Read a cell file; return an empty one if the file does not exist.

    Raises Unreadable if it is not TOML, Refused, with every finding, if the content has errors.
    """
    if not FilePath(path).exists():
        return NO_CELL
    return parse_cell(decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS))


def parse_cell(source: SourceText) -> Cell:
    """Parse a cell file from text, like `read_cell`."""
    top = read_toml(source)
    known, opened = set[tuple[str, str]](), set[tuple[str, str]]()
    content = dict(top.content)
    for table in _ENTRIES:
        entries = content.get(table)
        if not isinstance(entries, dict):
            continue
        known |= {(table, name.lower()) for name in entries}
        unfilled = {name for name, entry in entries.items() if _is_open(entry)}
        opened |= {(table, name.lower()) for name in unfilled}
        content[table] = {n: entry for n, entry in entries.items() if n not in unfilled}
    rest = replace(top, content=content)
    given: dict[tuple[str, str], SuppliedValue] = {}
    types: dict[str, str] = {}
    for table in _CELL_TABLES:
        for name, entry in rest.table(table).named():
            value = _entry(table, entry, types, name.lower())
            if value is not None:
                given[table, name.lower()] = value
    process = process_in(
        rest, (*_CELL_TABLES, *_SCENE_TABLES)
    )  # raises what the tables above have found as well
    return Cell(process, given, types, frozenset(known), frozenset(opened), source.text)


def _is_open(entry: Any) -> bool:
    if isinstance(entry, dict):
        return any(map(_is_open, entry.values()))
    if isinstance(entry, list):
        return any(map(_is_open, entry))
    return isinstance(entry, str) and entry == _OPEN_VALUE


def _entry(table: str, entry: Table, types: dict[str, str], low: str) -> SuppliedValue | None:
    match table:
        case "speeds":
            speed: Speed | None = entry.read(_SPEED_KEYS).get("speed")
            return speed
        case "blends":
            blend: Blend | None = entry.read(_BLEND_KEYS).get("blend")
            return blend
        case "positions":
            return _position(entry)
        case "data":
            found = entry.read(DATA_KEYS)
            if "type" in found:
                types[low] = found["type"]
            plain: Plain | None = found.get("value")
            return plain
        case "records":
            components: Plain | None = entry.read(RECORD_KEYS).get("components")
            return components
        case "arms":
            arm: str | None = entry.read(ARM_KEYS).get("arm")
            return arm
    routine: str | None = entry.read(ROUTINE_KEYS).get("routine")
    return routine


def _position(entry: Table) -> Target | JointTarget:
    found = entry.read(POSITION_KEYS)
    if "joints" in found:
        joints: JointTarget = found["joints"]
        return joints
    turn = found["quaternion"][0] if "quaternion" in found else None
    turn = turn or found.get("euler_zyx", Pose().quaternion)
    return Target(Pose(found.get("position", (0.0, 0.0, 0.0)), turn))


# ------------------------------------------------------------------------------------ write

_CELL_FILE_HEAD: Final = (
    '# What programs of this cell use and do not declare. Write a value for each "?", then run',
    "# the command again; see docs/translating.md for what each table takes.",
)


def with_entries(text: str, entries: Iterable[tuple[Wanted, SuppliedValue | None]]) -> str:
    """Append entries to a cell file's text, with a value or a placeholder for each.

    None: a placeholder. A signal's value is in its `Wanted`, without a number for a placeholder.
    """
    parts = [text.rstrip("\n")] if text.strip() else ["\n".join(_CELL_FILE_HEAD)]
    for wanted, value in entries:
        parts.append("\n".join(_lines(wanted, value)))
    return "\n\n".join(parts) + "\n"


def open_keys(wanted: Wanted) -> Iterator[tuple[str, str]]:
    """The keys of an entry that are to be filled in, each with a remark on its value."""
    # Only the number of a signal can be unknown.
    if wanted.signal is not None:
        wanted = replace(wanted, signal=replace(wanted.signal, number=None))
    for key, given, remark in _keys(wanted, None):
        if given is None:
            yield key, remark


def with_answer(text: str, wanted: Wanted, key: str, answer: str) -> str:
    """Return a cell file's text with an answer in the first open placeholder of a key of an entry.

    The answer is TOML; an answer that is not TOML is a text. The text is returned unchanged if it
    has no such placeholder.
    """
    table = TABLE_OF_KIND[wanted.kind]
    entries = (toml_content(text) or {}).get(table, {})
    name = next((one for one in entries if one.lower() == wanted.name.lower()), None)
    if name is None or entries[name].get(key) != _OPEN_VALUE:
        return text
    read = toml_content(f"answer = {answer}") or {"answer": answer}
    return with_values(text, {(table, name, key): read["answer"]}) or text


_MOST_USES: Final = 6
_OTHER_KINDS: Final = {
    "data": "if it is data, write [data.{name}] with its type and value instead.",
    "signal": "if it is a signal, write [signals.{name}] with kind, direction, number instead.",
    "type": "no use shows the type; correct it if it is another one.",
}
"""What to write for a name whose uses allow another kind."""


def _lines(wanted: Wanted, value: SuppliedValue | None) -> Iterator[str]:
    places = ", ".join(wanted.uses[:_MOST_USES])
    more = len(wanted.uses) - _MOST_USES
    used = f", used in {places}" + (f" and {more} more" if more > 0 else "") if places else ""
    yield f"# {_wanted_words(wanted)}{used}"
    if wanted.perhaps is not None:
        yield f"# Doubtful: {_OTHER_KINDS[wanted.perhaps].format(name=wanted.name)}"
    yield f"[{toml_key(TABLE_OF_KIND[wanted.kind], wanted.name)}]"
    for key, given, remark in _keys(wanted, value):
        line = f"{key} = {toml_value(_OPEN_VALUE if given is None else given)}"
        yield line + (f"  # {remark}" if remark else "")


_WORDS: Final[Mapping[WantedKind, str]] = {
    "tool": "tool", "frame": "frame", "speed": "speed", "blend": "corner", "position": "position",
    "joints": "joint angles", "signal": "signal", "data": "data", "routine": "routine",
    "record": "type", "arm": "arm of the joint angles", "line": "communication line",
}  # fmt: skip


def wanted_in_words(wanted: Wanted) -> str:
    """Describe a wanted name in words: `tool tGrip`, `digital input diOn (perhaps data)`."""
    return _wanted_words(wanted) + (f" (perhaps {_perhaps(wanted)})" if wanted.perhaps else "")


def _perhaps(wanted: Wanted) -> str:
    return {"data": "data", "signal": "a signal", "type": "of another type"}[
        wanted.perhaps or "type"
    ]


def _wanted_words(wanted: Wanted) -> str:
    if wanted.kind == "routine":
        given = ", ".join(map(_argument, wanted.arguments))
        result = f" that gives {wanted.type}" if wanted.type else ""
        return f"routine {wanted.name}({given}){result}"
    if wanted.kind == "arm":
        return f"arm that joint angles were {wanted.name.replace('_', ' ')}"
    return f"{kind_in_words(wanted)} {wanted.name}"


def kind_in_words(wanted: Wanted) -> str:
    """Describe the kind of a wanted name: `tool`, `digital input`, `data of type num`."""
    if wanted.tip is not None:
        return "load of tool"
    if wanted.signal is not None:
        return f"{wanted.signal.kind} {wanted.signal.direction}"
    if wanted.kind == "data" and wanted.type:
        return f"data of type {wanted.type}"
    return _WORDS[wanted.kind]


def _argument(one: CallArgument) -> str:
    return f"\\{one.option}" if one.option else one.type or "?"


def _keys(wanted: Wanted, value: SuppliedValue | None) -> Iterator[tuple[str, Any, str]]:
    """Keys of an entry with their values, None for one to be filled in, and remarks."""
    match wanted.kind:
        case "tool":
            tip = value.tip if isinstance(value, Tool) else wanted.tip
            yield "tip", tip and list(tip.position), "mm in the flange frame"
            yield "quaternion", list(tip.quaternion if tip else Pose().quaternion), ""
            if wanted.tip is not None:
                yield "mass", None, "kg"
                yield "centre", None, "of gravity, mm in the flange frame"
        case "frame":
            user = value.user if isinstance(value, Frame) else None
            yield "position", user and list(user.position), "mm in the robot's base frame"
            yield "quaternion", list(user.quaternion if user else Pose().quaternion), ""
        case "speed":
            joint = " of joint moves at a percentage" if wanted.name == JOINT_SPEED else ""
            yield "speed", value.tcp if isinstance(value, Speed) else None, f"mm/s{joint}"
        case "blend":
            given = (value.radius or "fine") if isinstance(value, Blend) else None
            yield "blend", given, '"fine", or mm of the corner'
        case "position":
            pose = value.pose if isinstance(value, Target) else None
            yield "position", pose and list(pose.position), "mm in the frame of the move"
            yield "quaternion", list(pose.quaternion if pose else (0.0, 0.0, 1.0, 0.0)), ""
        case "joints":
            joints = list(value.joints) if isinstance(value, JointTarget) else None
            yield "joints", joints, "degrees"
        case "signal":
            signal = wanted.signal or Signal("digital", "input")
            yield "kind", signal.kind, ""
            yield "direction", signal.direction, ""
            yield "number", signal.number, "" if signal.number is not None else wanted.numbers
            if signal.kind == "group":
                yield "bits", signal.bits if signal.number is not None else None, ""
        case "data":
            yield "type", wanted.type, ""
            several = value is None and isinstance(wanted.nothing, tuple)
            yield "value", value, f"like {data_text(wanted.nothing)}" if several else ""
        case "routine":
            yield "routine", value, '"stop", "empty", or the name of its file'
        case "record":
            perhaps = "" if value else f"; perhaps {toml_value(wanted.nothing)}"
            yield "components", value, f"type and name of each in their order{perhaps}"
        case "line":
            line = value if isinstance(value, ChannelLine) else None
            yield "role", line and line.role, '"server", "client" or "serial"'
            yield "port", line and line.port, "of TCP, or the number of the serial port"
            yield "address", line and line.address, 'of a client the other computer; or ""'
        case "arm":
            yield (
                "arm",
                value,
                'the robot, by its name; "same" if it runs the program',
            )


def data_text(value: Plain | None) -> str:
    """A value of data as the file has it."""
    return toml_value(_OPEN_VALUE if value is None else value)
