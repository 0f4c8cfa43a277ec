"""Open, Close, Print# and Input#: communication lines, and files on the controller (COSIROP)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final, Protocol

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import expressions, records
from assistant.virtual.melfa.lines import Line, Stored, TcpClient
from assistant.virtual.melfa.stops import Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import Kind, text

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine
    from assistant.virtual.melfa.world import World

FILE_NUMBERS: Final = range(1, 9)
RECORD_END: Final = "\r"
PREFIX: Final = "PRN"
"""Of data on a line that takes commands as well (protocol without procedure)."""


class Outside(Protocol):
    """What `Open` leads to. stored: files by their names."""

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
        """Takes what has come; a carriage return ends a line, a line feed behind it is nothing."""
        self._buffer += self.line.receive().decode("latin-1")
        while RECORD_END in self._buffer:
            one, self._buffer = self._buffer.split(RECORD_END, 1)
            one = one.removeprefix("\n")
            if self.prefixed and not one.startswith(PREFIX):
                continue  # a command to the controller, none of whose programs reads it
            if self.prefixed:
                one = one.removeprefix(PREFIX).removeprefix(" ")
            self._items.extend(records.record_items(one))
            self.arrived += 1

    def has(self, count: int) -> bool:
        """Whether so many items can be read."""
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
    if number not in FILE_NUMBERS:
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
    outside: Outside = m.world if slot is None else slot.controller
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
    if len(name) > LONGEST_INPUT:
        raise Failed(None, f"the name {name} of a file is longer than {LONGEST_INPUT} characters")
    match mode:
        case "Output" | "Append":
            return Stored(files.setdefault(name, bytearray()), mode)
        case "Input":
            if name not in files:
                raise Failed(None, f"there is no file {name}")
            return Stored(files[name], mode)
    raise Unknown(f"the file {name} in random mode")


LONGEST_INPUT: Final = 16
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
            made = records.padded_text(made, options.columns)
        if item is not None:
            made += records.record_text(expressions.value(m, item), options)
    new = made[len(channel.unfinished) :] + ("" if goes_on else RECORD_END)
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
        expressions.store(m, variable, records.record_value(item, _variable_kind(m, variable)))


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
