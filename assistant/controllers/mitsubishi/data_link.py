"""Data link: values to and from a program that has opened a line of the controller.

with DataLink("192.168.0.20:10003") as link:
    link.send(Joints((0, 10, 90, 0, 80, 0)))
    seconds, place = link.record(Form.parse("M_TIMER(1) | P_CURR"))

A stream carries the bytes: TCP as a client or a server, or a serial port. A position is
`(x,y,z,a,b,c)(fl1,fl2)` in mm and degrees, joints are `(j1,…)` in degrees (manuals BFP-A5993 and
BFP-A3379: PRINT, INPUT). A program that prints `M_TIMER(1), "|", P_CURR, "|", J_FBC` is read with
`Form.parse("M_TIMER | P_CURR | J_FBC")`.
"""

from __future__ import annotations

import math
import os
import re
import selectors
import socket
import time
from collections.abc import Callable, Iterable, Sequence
from termios import error as _terminal_error
from typing import TYPE_CHECKING, Final, Literal, NoReturn, Protocol, Self

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, Rule
from assistant.controllers.connection import reason_of
from assistant.controllers.mitsubishi import rules
from assistant.controllers.recording import Recording
from assistant.controllers.rules import Lost

if TYPE_CHECKING:
    import serial


__all__ = ["DataLink", "Form", "Joints", "Position", "Rate"]

try:
    from termios import error as _terminal_error

    _TERMINAL_ERRORS: tuple[type[Exception], ...] = (_terminal_error,)
except ImportError:  # not on Windows
    _TERMINAL_ERRORS = ()
_READ_AT_ONCE: Final = 1 << 16
_CONNECT_RETRY: Final = 0.1
"""Seconds between two trials to connect to a program that may not have opened its line yet."""


_PSEUDO_TERMINAL: Final = re.compile("/dev/pts/")
"""A pseudo terminal has no parity, and refuses to be set to one where nothing else changes."""
_PARITY_LETTERS: Final = {"none": "N", "odd": "O", "even": "E"}
_PORT_SLICE: Final = 0.05
"""Seconds that a serial port is waited for at a time."""


@dataclass(frozen=True, slots=True)
class Rate:
    """Settings of a serial line; the defaults are the factory settings of a controller.

    Parameters CBAU232, CPRTY232 and CSTOP232 (BFP-A5993).
    """

    baud: int = 9600
    parity: Literal["none", "odd", "even"] = "even"
    stops: Literal[1, 2] = 2
    bits: Literal[7, 8] = 8


class Stream(Protocol):
    """Bytes both ways. Raises OSError, TimeoutError where nothing came or went in time."""

    target: str

    def prepare(self) -> None:
        """Prepare before the other end exists: a server listens from here on."""

    def open(self, timeout: float) -> None:
        """Waits for the other end."""

    def send(self, data: bytes, timeout: float) -> None: ...

    def receive(self, timeout: float) -> bytes:
        """At least one byte."""

    def close(self) -> None:
        """May be called at any time, again and again."""


class _Tcp:
    def __init__(self, target: str, host: str, port: int) -> None:
        self.target = target
        self._place = host, port
        self._peer: socket.socket | None = None

    def prepare(self) -> None:
        """A client has nothing to prepare."""

    def open(self, timeout: float) -> None:
        raise NotImplementedError

    def _use(self, peer: socket.socket) -> None:
        # Lines are short and wait for an answer: Nagle's algorithm would delay them.
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        peer.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self._peer = peer

    def send(self, data: bytes, timeout: float) -> None:
        peer = self._connected()
        peer.settimeout(timeout)
        peer.sendall(data)

    def receive(self, timeout: float) -> bytes:
        peer = self._connected()
        with selectors.DefaultSelector() as selector:  # another thread may set the time-out to send
            try:
                selector.register(peer, selectors.EVENT_READ)
            except ValueError:
                raise ConnectionError("it was closed here") from None
            if not selector.select(timeout):
                raise TimeoutError
        data = peer.recv(_READ_AT_ONCE)
        if not data:
            raise ConnectionResetError("the controller closed it")
        return data

    def close(self) -> None:
        if self._peer is not None:
            self._peer.close()
            self._peer = None

    def _connected(self) -> socket.socket:
        if self._peer is None:
            raise ConnectionError("it is not open")
        return self._peer


class TcpClient(_Tcp):
    """To a line of a controller that is the server (NETMODE 1, as it is delivered).

    patient: whether to try again while nothing listens there.
    """

    def __init__(self, target: str, host: str, port: int, *, patient: bool = True) -> None:
        super().__init__(target, host, port)
        self._patient = patient

    def open(self, timeout: float) -> None:
        end = time.monotonic() + timeout
        while True:
            try:
                left = max(_CONNECT_RETRY, end - time.monotonic())
                peer = socket.create_connection(self._place, timeout=left)
            except ConnectionRefusedError:
                if not self._patient or time.monotonic() + _CONNECT_RETRY > end:
                    raise
                time.sleep(_CONNECT_RETRY)
            else:
                return self._use(peer)


class _TcpServer(_Tcp):
    """For a controller that is the client (NETMODE 0): one at a time."""

    def __init__(self, target: str, host: str, port: int) -> None:
        super().__init__(target, host, port)
        self._listener: socket.socket | None = None

    @property
    def port(self) -> int:
        """Port of the listener; for 0, the free one that was chosen."""
        assert self._listener is not None
        return int(self._listener.getsockname()[1])

    def prepare(self) -> None:
        if self._listener is None:
            family = socket.AF_INET6 if ":" in self._place[0] else socket.AF_INET
            self._listener = socket.create_server(self._place, family=family)

    def open(self, timeout: float) -> None:
        self.prepare()
        assert self._listener is not None
        self._listener.settimeout(timeout)
        self._use(self._listener.accept()[0])

    def close(self) -> None:
        super().close()
        if self._listener is not None:
            self._listener.close()
            self._listener = None


class Serial:
    """A serial port by its path or name."""

    def __init__(self, target: str, rate: Rate) -> None:
        self.target = target
        self._rate = rate
        self._port: serial.Serial | None = None

    def prepare(self) -> None:
        """Do nothing: a port opened earlier would hold data for another program."""

    def open(self, timeout: float) -> None:
        try:
            import serial
        except ImportError:
            raise Refused(rules.NO_SERIAL(place=self.target), exit_status=2) from None
        try:
            self._port = serial.Serial(
                self.target,
                self._rate.baud,
                bytesize=self._rate.bits,
                # A real port is set to the parity; a pseudo terminal has none.
                parity="N" if _is_pseudo(self.target) else _PARITY_LETTERS[self._rate.parity],
                stopbits=self._rate.stops,
                timeout=_PORT_SLICE,  # not changed later: that would set the port anew
                write_timeout=timeout,
                exclusive=None if os.name == "nt" else True,
            )
        except _TERMINAL_ERRORS as error:
            raise OSError(f"the port takes no such rate ({error.args[-1]})") from None

    def send(self, data: bytes, timeout: float) -> None:  # noqa: ARG002 - that of `open`
        import serial

        try:
            self._opened().write(data)
        except serial.SerialTimeoutException:
            raise TimeoutError from None

    def receive(self, timeout: float) -> bytes:
        port, end = self._opened(), time.monotonic() + timeout
        # Without time, only what has come: read(1) would wait for a slice.
        if timeout <= 0 and not port.in_waiting:
            raise TimeoutError
        try:
            while not (data := bytes(port.read(1))):
                if time.monotonic() >= end:
                    raise TimeoutError
            return data + bytes(port.read(port.in_waiting))
        except TypeError:  # of pyserial, whose port another thread has closed meanwhile
            raise ConnectionError("it was closed here") from None

    def close(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None

    def _opened(self) -> serial.Serial:
        if self._port is None:
            raise ConnectionError("it is not open")
        return self._port


def _is_pseudo(target: str) -> bool:
    """True if a serial port is a pseudo terminal, or a link to one."""
    return _PSEUDO_TERMINAL.match(os.path.realpath(target)) is not None


def stream_to(target: str, rate: Rate | None = None) -> Stream:
    """Return the stream for a target; raises Refused.

    target: `host:port` of a controller's line, `listen:address:port` of this computer for a
    controller that connects itself, or a serial port as `/dev/ttyUSB0` or `COM3`. rate: of a serial
    port.
    """
    if re.fullmatch(r"(?:/[^\x00-\x1f]+|COM\d{1,3})", target):
        return Serial(target, rate or Rate())
    listens, rest = target.startswith("listen:"), target.removeprefix("listen:")
    host, _, port = rest.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    wrong = (
        (not re.fullmatch(r"[A-Za-z0-9_.:-]+", host), "the host is no name"),
        (not re.fullmatch(r"\d{1,5}", port) or int(port) > 65535, "the port is no number"),
        # `listen:` may use port 0, any free one.
        (not listens and port.strip("0") == "", "port 0 cannot be connected to"),
    )
    for is_wrong, reason in wrong:
        if is_wrong:
            raise Refused(rules.BAD_LINE(target=target, reason=reason), exit_status=2)
    kind: Callable[[str, str, int], Stream] = _TcpServer if listens else TcpClient
    return kind(target, host, int(port))


AXES: Final = 8
"""Components of a position and of joints: six, and two additional axes."""
DECIMALS: Final = 4
"""Decimals of a number that is sent; a single-precision value of a controller has no more."""
_MOST_BYTES: Final = 255
"""Bytes of a line that is sent: a text variable has no more."""
_ENCODING: Final = "latin-1"
_COMPONENTS: Final = {
    "number": (),
    "text": (),
    "position": ("X", "Y", "Z", "A", "B", "C", "L1", "L2", "FL1", "FL2"),
    "joints": tuple(f"J{axis}" for axis in range(1, AXES + 1)),
}
"""Names of the components of a value, as they are recorded."""

ValueKind = Literal["number", "text", "position", "joints"]
_VALUE_KINDS: Final[dict[str, ValueKind]] = {
    "M": "number",
    "C": "text",
    "P": "position",
    "J": "joints",
}
"""First letter of a variable → what it holds."""


@dataclass(frozen=True, slots=True)
class Position:
    """A pose as the controller has it.

    values: (8,) X Y Z in mm, A B C in degrees, L1 L2; NaN for what the arm lacks.
    flags: FL1, the posture, and FL2, the turns of the joints.
    """

    values: tuple[float, ...]
    flags: tuple[int, int] = (0, 0)

    @property
    def numbers(self) -> tuple[float, ...]:
        return (*self.values, *map(float, self.flags))


@dataclass(frozen=True, slots=True)
class Joints:
    """values: (8,) degrees (mm of a linear axis), NaN for axes that the arm lacks."""

    values: tuple[float, ...]

    @property
    def numbers(self) -> tuple[float, ...]:
        return self.values


Value = float | str | Position | Joints


@dataclass(frozen=True, slots=True)
class Form:
    """The fields of a record, and what stands between them.

    names: as they are printed, such as `P_CURR` or `M_RSPD(3)`. kinds: of what they hold.
    """

    names: tuple[str, ...]
    kinds: tuple[ValueKind, ...]
    separator: str = "|"

    @staticmethod
    def parse(text: str, separator: str = "|") -> Form:
        """The form that a text such as `M_TIMER | P_CURR | J_FBC` says; raises Refused."""
        names = tuple(name.strip() for name in text.split(separator))
        for name in names:
            if not _FORM_FIELD.fullmatch(name):
                raise Refused(rules.BAD_FORM(place=text, field=name), exit_status=2)
        return Form(names, tuple(_VALUE_KINDS[name[0].upper()] for name in names), separator)

    def read(self, line: str) -> tuple[Value, ...]:
        """The values of a line; raises ValueError if it is of another form."""
        parts = line.split(self.separator)
        if len(parts) != len(self.names):
            raise ValueError(f"{len(parts)} fields, not {len(self.names)}")
        return tuple(
            read_value(part.strip(), kind) for part, kind in zip(parts, self.kinds, strict=True)
        )

    def recording(self, *more: str) -> Recording:
        """An empty recording of these fields but for texts, behind single numbers `more`."""
        numeric = self._numeric()
        fields = {name: _COMPONENTS[kind] for name, kind in numeric}
        return Recording({**dict.fromkeys(more, ()), **fields})

    def record(self, recording: Recording, values: Sequence[Value], *more: float) -> None:
        """Adds a row to one of `recording`."""
        recording.add(
            *more, *(_value_components(value) for value in values if not isinstance(value, str))
        )

    def _numeric(self) -> Iterable[tuple[str, ValueKind]]:
        pairs = zip(self.names, self.kinds, strict=True)
        return ((name, kind) for name, kind in pairs if kind != "text")


_FORM_FIELD: Final = re.compile(r"[MCPJ][A-Z0-9_]*[$%&!#]?(?:\(\s*\d+\s*(?:,\s*\d+\s*)*\))?", re.I)
NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?", re.I)
_BRACKETS: Final = re.compile(r"\(([^()]*)\)\s*(?:\(([^()]*)\))?")
_LACKING: Final = {"", "****"}
"""Texts of an axis that the arm lacks."""


def _value_components(value: float | Position | Joints) -> float | tuple[float, ...]:
    """The components of a value, as a recording has them."""
    return value if isinstance(value, (int, float)) else value.numbers


def read_value(text: str, kind: ValueKind) -> Value:
    """A printed value; raises ValueError if it is of another kind."""
    match kind:
        case "text":
            return text
        case "number":
            return _read_number(text)
        case "joints" | "position":
            return _read_brackets(text, kind)


def _read_number(text: str) -> float:
    if not NUMBER.fullmatch(text):
        raise ValueError(f"{text!r} is no number")
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is too large")
    return value


def _read_brackets(text: str, kind: Literal["position", "joints"]) -> Position | Joints:
    found = _BRACKETS.fullmatch(text)
    if found is None or (found[2] is None) != (kind == "joints"):
        raise ValueError(f"{text!r} is no {kind}")
    parts = [part.strip() for part in found[1].split(",")]
    if len(parts) > AXES:
        raise ValueError(f"{text!r} has more than {AXES} components")
    given = [math.nan if part in _LACKING else _read_number(part) for part in parts]
    values = (*given, *[math.nan] * (AXES - len(given)))
    if found[2] is None:
        return Joints(values)
    flags = [_read_number(part.strip()) for part in found[2].split(",")]
    if len(flags) != 2 or any(flag != int(flag) for flag in flags):
        raise ValueError(f"{text!r} has no two whole flags")
    return Position(values, (int(flags[0]), int(flags[1])))


def input_line(values: Sequence[Value]) -> str:
    """A line for Input#, its items between commas; raises Refused for what no line can carry."""
    line = ",".join(map(_item_text, values))
    if len(line) > _MOST_BYTES:
        reason = f"it has {len(line)} bytes, a line {_MOST_BYTES}"
        raise _unsendable("the line", reason, "send fewer items at once")
    return line


def _item_text(value: Value) -> str:
    match value:
        case str():
            if strange := re.search(r"[\x00-\x1f\x7f-\x9f,()\"]|[^\x00-\xff]", value):
                reason = f"it holds {strange[0]!r}, which would end it or is not known there"
                raise _unsendable(repr(value), reason, "send a text without it")
            return value
        case Position(values, (one, two)):
            return f"{_bracket_text(values)}({one},{two})"
        case Joints(values):
            return _bracket_text(values)
    return _decimal_text(value)


def _bracket_text(values: Sequence[float]) -> str:
    """Components up to the last one that there is; 0 for one that the arm lacks."""
    # NaN is the one number that differs from itself.
    count = max((place for place, value in enumerate(values, 1) if value == value), default=0)
    if not 0 < count <= AXES:
        raise _unsendable(str(tuple(values)), f"it has {count} components", f"give 1 to {AXES}")
    return f"({','.join('0' if math.isnan(v) else _decimal_text(v) for v in values[:count])})"


def _decimal_text(value: float) -> str:
    if not math.isfinite(value):
        raise _unsendable(str(value), "it is not finite", "send a finite number")
    text = f"{value:.{DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _unsendable(what: str, reason: str, cure: str) -> Refused:
    return Refused(rules.UNSENDABLE(what=what, reason=reason, cure=cure), exit_status=2)


_MOST_LINE: Final = 4096
"""Bytes without an end after which what comes is no line of a program."""
_LINE_END: Final = b"\r"


class DataLink:
    """Peer of `Open "COMn:"`, Print# and Input# of a program; a context manager.

    target: see `stream_to`. timeout: seconds for connecting, sending and each line. prefix: `PRN`
    on a line that takes commands as well (CPRC232 = 0). state: text of the findings about the
    controller.
    """

    def __init__(
        self,
        target: str,
        *,
        timeout: float = 10.0,
        rate: Rate | None = None,
        prefix: str = "",
        state: str = "what the program does then is its own affair",
    ) -> None:
        self.stream: Stream = stream_to(target, rate)
        self.timeout = timeout
        self.state = state
        self._prefix = prefix
        self._come = b""

    def __enter__(self) -> Self:
        self.prepare()
        self.open()
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @property
    def target(self) -> str:
        return self.stream.target

    def prepare(self) -> None:
        """Prepare before a program opens the line; raises Lost."""
        try:
            self.stream.prepare()
        except (OSError, OverflowError, UnicodeError) as error:
            self._lost(rules.NO_LINE, reason=reason_of(error))

    def open(self) -> None:
        """Waits for the other end; raises Lost."""
        self._come = b""
        try:
            self.stream.open(self.timeout)
        except Refused:  # pyserial is missing; Refused is a ValueError, too
            raise
        except (OSError, UnicodeError, ValueError) as error:
            self._lost(rules.NO_LINE, reason=reason_of(error))

    def close(self) -> None:
        self.stream.close()

    def send(self, *values: Value) -> None:
        """A line with the items of one Input#: numbers, texts, positions, joints.

        Raises Refused for what no line can carry, Lost if it does not go out.
        """
        data = f"{self._prefix}{input_line(values)}".encode(_ENCODING) + _LINE_END
        try:
            self.stream.send(data, self.timeout)
        except OSError as error:
            self._lost(rules.LINE_LOST, doing="sending", reason=reason_of(error))

    def receive(self, timeout: float | None = None) -> str:
        """The next line that a program prints, without its end; raises Lost.

        CR or CR LF ends it. After a failure the line is closed: half a line must not pass for one.
        """
        line = self.wait(self.timeout if timeout is None else timeout)
        if line is None:
            self._lost(rules.LINE_LOST, doing="receiving", reason="no answer in time")
        return line

    def wait(self, timeout: float) -> str | None:
        """The same, but None if no whole line has come in time; what came stays for the next."""
        end = time.monotonic() + timeout
        while (line := self._whole()) is None:
            # Not a line of a program: the wrong rate, or another device on the line.
            if len(self._come) > _MOST_LINE:
                self._lost(rules.LINE_GARBLED, answer=repr(self._come[:80]))
            try:
                self._come += self.stream.receive(max(0.0, end - time.monotonic()))
            except TimeoutError:
                return None
            except OSError as error:
                self._lost(rules.LINE_LOST, doing="receiving", reason=reason_of(error))
        return line

    def record(self, form: Form, timeout: float | None = None) -> tuple[Value, ...]:
        """The values of the next line; raises Lost if it is of another form."""
        line = self.receive(timeout)
        try:
            return form.read(line)
        except ValueError as error:
            answer = f"{line[:80]!r} ({error})"
            self._lost(rules.LINE_GARBLED, answer=answer)

    def _whole(self) -> str | None:
        # LF of CR LF, which may come with the next piece.
        self._come = self._come.removeprefix(b"\n")
        line, end, rest = self._come.partition(_LINE_END)
        if not end:
            return None
        self._come = rest
        return line.decode(_ENCODING)

    def _lost(self, rule: Rule, *, doing: str = "", reason: str = "", answer: str = "") -> NoReturn:
        self.close()
        self._come = b""
        raise Lost(
            rule(
                place=self.target,
                target=self.target,
                doing=doing,
                reason=reason,
                answer=answer,
                state=self.state,
            )
        ) from None
