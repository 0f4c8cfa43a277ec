"""Open, Close, Print# and Input#: communication lines, files on the controller, and their records.

COSIROP: PRINT, INPUT, OPEN. Print# writes numbers, texts, positions and joints as ASCII; a position
is `(x,y,z,a,b,c)(fl1,fl2)` in mm and degrees, joints are `(j1,...)` in degrees.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, Protocol

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import expressions
from assistant.virtual.melfa.communication_lines import Line, Stored, TcpClient
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import (
    Elements,
    Failed,
    Joints,
    Kind,
    Position,
    Unknown,
    Value,
    eight,
    number,
    out_of_range,
    text,
)

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine
    from assistant.virtual.melfa.world import World


_ALL_DIGITS: Final = 10_000_000
"""From here on seven digits are not enough for the whole part of a number."""

# ------------------------------------------------------------------------------------ writing


def _record_text(value: Value, options: Options) -> str:
    """One item of Print#."""
    match value:
        case str():
            return value
        case Position(values, (one, two)):
            if one is None or two is None:
                raise Unknown("the flags of a position that is printed")
            return f"{_bracket_text(values, options)}({one},{two})"
        case Joints(values):
            return _bracket_text(values, options)
        case int() | float():
            return _number_record(number(value), options)
    raise Unknown("how Print # writes a constant that may be a position or joints")


def _number_record(value: float, options: Options) -> str:
    if not math.isfinite(value):
        raise Unknown("a number that is not finite")
    if abs(value) >= _ALL_DIGITS:
        return f"{value:.0f}"
    made = f"{value:.{options.printed}g}"
    # `g` turns to exponents for small numbers; `Print #` writes none.
    return made if "e" not in made else f"{value:.12f}".rstrip("0").rstrip(".")


def _bracket_text(values: Elements, options: Options) -> str:
    """Elements up to the last one that is defined."""
    count = max((i + 1 for i, v in enumerate(values) if v is not None), default=0)
    # Adding 0.0 makes 0.0 of -0.0.
    made = ("" if v is None else f"{v + 0.0:.{options.places}f}" for v in values[:count])
    return f"({','.join(made)})"


def _padded_text(text: str, width: int) -> str:
    """Up to the next column that items begin in."""
    return text + " " * (-len(text) % width)


# ------------------------------------------------------------------------------------ reading

# Up to the next comma that is not inside brackets.
_ITEM: Final = re.compile(r"(?:\([^()]*\)|[^,()])*")
_POSITION_ITEM: Final = re.compile(r"\s*\(([^()]*)\)\s*(?:\(([^()]*)\))?\s*")


def _record_items(line: str) -> Iterator[str]:
    """Items of a line, separated by commas outside brackets."""
    at = 0
    while True:
        found = _ITEM.match(line, at)
        assert found is not None
        end = found.end()
        if end < len(line) and line[end] != ",":
            end = len(line)  # a bracket that nothing closes
        yield line[at:end]
        if end >= len(line):
            return
        at = end + 1


def _record_value(item: str, kind: Kind) -> Value:
    """An item for a variable of a type; error 3500 if it is of another one."""
    match kind:
        case "text":
            return item
        case "position" | "joints":
            return _position_value(item, kind)
    return _plain_number(item, item)


def _plain_number(text: str, item: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise Failed(3500, f"`{item}` is not of the type of its variable")
    return value


def _position_value(item: str, kind: Kind) -> Value:
    found = _POSITION_ITEM.fullmatch(item)
    if found is None or (kind == "joints" and found[2] is not None):
        raise Failed(3500, f"`{item}` is no {kind}")
    parts = [part.strip() for part in found[1].split(",")]
    values = eight(tuple(_plain_number(part, item) if part else None for part in parts))
    if kind == "joints":
        return Joints(values)
    if found[2] is None:
        raise Unknown("a position without flags that comes over a line")
    flags = [part.strip().rstrip(".") for part in found[2].split(",")]
    if len(flags) != 2:
        raise Unknown("a position with other than two flags that comes over a line")
    one, two = (_plain_number(flag, item) for flag in flags)
    return Position(values, (int(one), int(two)))


_FILE_NUMBERS: Final = range(1, 9)
_RECORD_END: Final = "\r"
_PREFIX: Final = "PRN"
"""Prefix of data on a line that takes commands as well (protocol without procedure)."""


class _Outside(Protocol):
    """Files and lines that `Open` opens. stored: files by their names."""

    stored: dict[str, bytearray]

    def line(self, name: str) -> Line: ...

    def uses(self, line: Line) -> bool: ...


class Channel:
    """An open file. arrived: complete lines that have come. unfinished: the line that Print# is in.

    prefixed: whether data has PRN in front.
    """

    def __init__(self, name: str, line: Line, prefixed: bool) -> None:
        self.name, self.line, self.prefixed = name, line, prefixed
        self.arrived = 0
        self.unfinished = ""
        self._buffer = ""
        self._items: deque[str] = deque()

    def pull(self) -> None:
        """Read received data; a carriage return ends a line, a line feed after it is ignored."""
        self._buffer += self.line.receive().decode("latin-1")
        while _RECORD_END in self._buffer:
            one, self._buffer = self._buffer.split(_RECORD_END, 1)
            # The line feed after the carriage return of the line before.
            one = one.removeprefix("\n")
            if self.prefixed and not one.startswith(_PREFIX):
                continue  # a command to the controller, none of whose programs reads it
            if self.prefixed:
                one = one.removeprefix(_PREFIX).removeprefix(" ")
            self._items.extend(_record_items(one))
            self.arrived += 1

    def has(self, count: int) -> bool:
        """True if so many items can be read."""
        self.pull()
        return len(self._items) >= count

    @property
    def unread(self) -> int:
        """Lines that may not have been read yet: those of which items are left, and one of them."""
        return min(1, len(self._items))

    def take(self, count: int) -> list[str]:
        return [self._items.popleft() for _ in range(count)]


def _file_number(m: Machine, node: s.Expression) -> int:
    number = expressions.integer(m, node, "the number of a file")
    if number not in _FILE_NUMBERS:
        raise out_of_range(f"the file {number}")
    return number


def _open_channel(m: Machine, node: s.Expression, what: str) -> Channel:
    number = _file_number(m, node)
    found = m.world.files.get(number)
    if found is None:
        raise Failed(None, f"{what} with file {number}, which is not open")
    return found


def _open_file(m: Machine, node: s.Open) -> None:
    number = _file_number(m, node.number)
    name = text(expressions.value(m, node.name), "the name of a file").strip().upper()
    slot = m.world.slot
    outside: _Outside = m.world if slot is None else slot.controller
    line: Line
    if ":" in name:
        line = outside.line(name)
    else:
        line = _stored_file(outside.stored, name, node.mode.capitalize())
    if number in m.world.files or outside.uses(line):
        raise Failed(3130, f"{name} or the file {number} is open already")
    try:
        line.open()
    except OSError as error:
        raise Failed(3140, f"{name} cannot be opened: {error.strerror or error}") from None
    m.world.task.kernel.attached += line.outside
    m.world.files[number] = Channel(name, line, m.world.options.prefixed)


def _stored_file(files: dict[str, bytearray], name: str, mode: str) -> Stored:
    """A file on the controller."""
    if len(name) > _LONGEST_INPUT:
        raise Failed(None, f"the name {name} of a file is longer than {_LONGEST_INPUT} characters")
    match mode:
        case "Output" | "Append":
            return Stored(files.setdefault(name, bytearray()), mode)
        case "Input":
            if name not in files:
                raise Failed(None, f"there is no file {name}")
            return Stored(files[name], mode)
    raise Unknown(f"the file {name} in random mode")


_LONGEST_INPUT: Final = 16
"""Characters of a file's name (COSIROP: OPEN)."""


def _close_files(m: Machine, node: s.Close) -> None:
    numbers = tuple(_file_number(m, number) for number in node.numbers)
    m.world.close_files(numbers or None)


# ------------------------------------------------------------------------------------ writing


def _print_record(m: Machine, node: s.Print) -> None:
    """A comma goes on in the next column, a semicolon at once; either at the end keeps the line."""
    channel, options = _open_channel(m, node.number, "Print #"), m.world.options
    if isinstance(channel.line, Stored) and channel.line.mode == "Input":
        raise Failed(3150, f"{channel.name} is open for input")
    made, goes_on = channel.unfinished, False
    for place, (mark, item) in enumerate(node.items):
        goes_on = item is None
        if mark == "," and place > 0:
            made = _padded_text(made, options.columns)
        if item is not None:
            made += _record_text(expressions.value(m, item), options)
    # Columns count from the beginning of the line, of which a part was sent before.
    new = made[len(channel.unfinished) :] + ("" if goes_on else _RECORD_END)
    channel.unfinished = made if goes_on else ""
    line = channel.line
    if line.full():
        m.world.task.wait(lambda: not line.full(), what=f"{channel.name} to send", outside=True)
    line.send(new.encode("latin-1", "replace"))


# ------------------------------------------------------------------------------------ reading


def _input_record(m: Machine, node: s.Input) -> None:
    """Waits for an item for each variable; further ones are for the next Input#."""
    channel = _open_channel(m, node.number, "Input #")
    count, line = len(node.variables), channel.line
    if isinstance(line, Stored) and line.mode != "Input":
        raise Failed(3170, f"{channel.name} is open for output")
    if isinstance(line, Stored) and not channel.has(count):
        raise Unknown(f"what Input # does behind the end of {channel.name}")
    m.world.task.wait(
        lambda: channel.has(count), what=f"data on {channel.name}", outside=line.outside
    )
    for variable, item in zip(node.variables, channel.take(count), strict=True):
        expressions.store(m, variable, _record_value(item, _variable_kind(m, variable)))


def _variable_kind(m: Machine, variable: s.Variable) -> Kind:
    if variable.component:
        return "number"
    place, _ = expressions.reference(m, variable)
    return place.kind


# ------------------------------------------------------------------------------------ targets


def set_target(world: World, number: int, told: str) -> None:
    """`C_Com(n)="ETH:address,port"`: where the line connects to when it is opened next."""
    kind, _, rest = told.partition(":")
    host, _, port = rest.partition(",")
    if world.slot is None:
        raise Unknown("lines of a program that runs without a controller")
    if kind.strip().upper() != "ETH" or not port.strip().isdigit():
        raise Unknown(f"the target `{told}` of a line")
    if host.strip() not in LOOPBACK:
        raise Unknown("a connection to another computer")
    world.slot.controller.lines[f"COM{number}:"] = TcpClient(host.strip(), int(port))


LOOPBACK: Final = ("127.0.0.1", "localhost")

FILE_FORMS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    s.Open: _open_file,
    s.Close: _close_files,
    s.Print: _print_record,
    s.Input: _input_record,
}
