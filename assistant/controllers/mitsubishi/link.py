"""Controller link of Mitsubishi CR controllers, client side: one command, one answer.

`[robot];[slot];COMMAND` goes out, and `QoK…`, or `QeR` with an error number, comes back
(BFP-A4288); a lower-case third letter is the same answer of a controller in an error state. The
controller never speaks first. Plain framing: an end code after each text, CR or CR LF, or none
where an answer ends when the line goes quiet. Procedural framing (RS-232, parameter CPRC232): ENQ,
ACK, a frame with length and checksum, ACK, EOT, and the answer the same way back; each step is
tried again three times, as RT ToolBox does.
"""

from __future__ import annotations

import re
import threading
import time
from functools import reduce
from operator import xor
from typing import Final, Literal, NoReturn, Protocol

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.address import Address
from assistant.controllers.connection import reason_of
from assistant.controllers.mitsubishi.data_link import Rate, Serial, Stream, TcpClient

ENCODING: Final = "latin-1"
_ANSWER_FORM: Final = re.compile(r"Q(OK|ER)([^\r\n]*)", re.IGNORECASE)
_ERROR_ANSWER: Final = re.compile(r"(\d{4})((?:;\d+)*)\s*")

BARE_ANSWER: Final = re.compile(r"[; ]*")
"""Answer to a command that only confirms its acceptance."""


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer: its text, or the error number and the positions (line, character) that follow it.

    alarmed: the controller is in an error state.
    """

    text: str = ""
    number: int | None = None
    places: tuple[int, ...] = ()
    alarmed: bool = False

    @property
    def ok(self) -> bool:
        return self.number is None


def parse_answer(raw: str) -> Answer | None:
    """Parse an answer, None if the text is not an answer."""
    found = _ANSWER_FORM.fullmatch(raw)
    if found is None:
        return None
    kind, text = found[1], found[2]
    alarmed = kind[1].islower()
    if kind.upper() == "OK":
        return Answer(text, alarmed=alarmed)
    error = _ERROR_ANSWER.fullmatch(text)
    if error is None:
        return None
    places = tuple(int(p) for p in error[2].split(";") if p)
    return Answer(text, int(error[1]), places, alarmed)


_MOST_ANSWER: Final = 1 << 20
"""Bytes after which an answer is nonsense."""
_FIRST_QUIET: Final = 0.3
"""Seconds of silence that end the first answer of a controller which sends no end code."""
_QUIET: Final = 0.1
"""The same once it is known to send none."""
_STX, _ETX, _EOT, _ENQ, _ACK, _NAK = (
    bytes([code]) for code in (0x02, 0x03, 0x04, 0x05, 0x06, 0x15)
)
_TRIALS: Final = 4
"""Trials of a step: the first one and three more."""
_STEP_TIMEOUT: Final = 2.0
"""Seconds for a step of the procedure; 255 bytes take 0.3 s at 9600 baud."""


class _UnaskedData(Exception):
    """data: bytes on the line that cannot be the answer to a command."""

    def __init__(self, data: bytes) -> None:
        super().__init__(data)
        self.data = data


class Framing(Protocol):
    """most: bytes of a command."""

    most: int

    def exchange(self, stream: Stream, command: bytes, timeout: float) -> bytes:
        """Sends a command and gives its answer.

        Raises OSError (TimeoutError if nothing comes in time), Unasked.
        """


class _PlainFraming:
    """No procedure. terminator: what ends a command, b"" for nothing."""

    def __init__(self, terminator: bytes = b"\r") -> None:
        self.most = 255
        self._terminator = terminator
        self._ends: bool | None = None  # whether answers have an end code; None: not known yet

    def exchange(self, stream: Stream, command: bytes, timeout: float) -> bytes:
        # The controller never speaks first: waiting bytes are a late answer to an earlier command.
        if waiting := pending(stream).strip(b"\r\n"):
            raise _UnaskedData(waiting)
        stream.send(command + self._terminator, timeout)
        return self._answer(stream, time.monotonic() + timeout)

    def _answer(self, stream: Stream, end: float) -> bytes:
        data = b""
        while len(data) < _MOST_ANSWER:
            started = parse_answer(data.decode(ENCODING)) is not None
            # An answer whose end code is unknown so far may be complete: silence decides.
            bare = started and not self._ends
            quiet = _FIRST_QUIET if self._ends is None else _QUIET
            left = end - time.monotonic()
            # A line that is never quiet would keep this loop beyond its time-out.
            if left < -_FIRST_QUIET:  # it is never quiet
                raise TimeoutError
            try:  # the end of the time is no end of an answer
                piece = stream.receive(quiet if bare else max(0.0, left))
            except TimeoutError:
                if not bare:
                    raise
                self._ends = False
                return data
            data = (data + piece).lstrip(b"\r\n")
            if code := re.search(rb"[\r\n]", data):
                self._ends = True
                # Bytes after the end code belong to no command that was sent.
                if data[code.start() :].strip(b"\r\n"):
                    raise _UnaskedData(data)
                return data[: code.start()]
        raise _UnaskedData(data)


class _ProceduralFraming:
    """With the procedure of RS-232."""

    def __init__(self) -> None:
        self.most = 254  # the length counts the letter before the command

    def exchange(self, stream: Stream, command: bytes, timeout: float) -> bytes:
        if waiting := pending(stream).strip(_EOT + b"\r\n"):
            raise _UnaskedData(waiting)
        end = time.monotonic() + timeout
        self._insist(stream, _ENQ, end)
        self._insist(stream, frame(command), end)
        stream.send(_EOT, timeout)
        return self._answer(stream, end)

    def _insist(self, stream: Stream, data: bytes, end: float) -> None:
        """Sends until it is acknowledged; raises OSError."""
        for _ in range(_TRIALS):
            stream.send(data, _STEP_TIMEOUT)
            try:
                reply = stream.receive(_left(end, _STEP_TIMEOUT))
            except TimeoutError:
                if time.monotonic() >= end:
                    raise
                continue
            # Noise may come before ACK: only the last byte counts.
            if reply.endswith(_ACK):
                return
            # ENQ: the controller speaks at the same time, so that the answers are out of step.
            if _ENQ in reply:
                raise _UnaskedData(reply)
        raise TimeoutError

    def _answer(self, stream: Stream, end: float) -> bytes:
        data = self._until(stream, _ENQ, b"", end, end - time.monotonic())
        stream.send(_ACK, _STEP_TIMEOUT)
        for _ in range(_TRIALS):
            data = self._until(stream, _ETX, data, end, _STEP_TIMEOUT)
            text = unframed(data)
            stream.send(_NAK if text is None else _ACK, _STEP_TIMEOUT)
            data = b""
            if text is not None:
                self._closed(stream, end)
                return text
        raise _UnaskedData(b"frames with wrong checksums")

    def _until(self, stream: Stream, code: bytes, data: bytes, end: float, step: float) -> bytes:
        """Return the bytes up to a control code, without the code; for ENQ the bytes after it."""
        while code not in data:
            if len(data) > _MOST_ANSWER:
                raise _UnaskedData(data)
            data += stream.receive(_left(end, step))
            if code == _ETX and data.endswith(_ENQ):  # our ACK was lost
                stream.send(_ACK, _STEP_TIMEOUT)
                data = b""
        before, _, after = data.partition(code)
        return after if code == _ENQ else before

    def _closed(self, stream: Stream, end: float) -> None:
        """Waits for EOT; a frame that comes once more is acknowledged once more."""
        try:
            # A repeated frame means that its ACK was lost:
            # acknowledge it, but do not read it twice.
            while not (data := stream.receive(_left(end, _STEP_TIMEOUT))).endswith(_EOT):
                if data.endswith(_ETX):
                    stream.send(_ACK, _STEP_TIMEOUT)
        except TimeoutError:
            return  # the frame was whole: what is missing is only its farewell


def frame(command: bytes) -> bytes:
    """A command with its length and checksum: XOR of all from the `D` on."""
    body = b"D0%02XR%s" % (len(command) + 1, command)
    return _STX + body + b"%02X" % reduce(xor, body) + _ETX


def unframed(data: bytes) -> bytes | None:
    """The answer in a frame without its ETX, None if length or checksum are wrong.

    The letter before the answer is not looked at: the manual shows it for commands only.
    """
    found = re.search(rb"\x02(D0([0-9A-Fa-f]{2})[A-Z](.*))([0-9A-Fa-f]{2})$", data, re.DOTALL)
    if found is None:
        return None
    whole = reduce(xor, found[1]) == int(found[4], 16) and len(found[3]) + 1 == int(found[2], 16)
    return found[3] if whole else None


def pending(stream: Stream) -> bytes:
    """Return the bytes that have arrived already; raises OSError."""
    data = b""
    while len(data) < _MOST_ANSWER:
        try:
            data += stream.receive(0.0)
        except TimeoutError:
            break
    return data


def _left(end: float, most: float) -> float:
    return min(most, max(0.0, end - time.monotonic()))


ENDS: Final = {"cr": b"\r", "crlf": b"\r\n", "none": b""}
"""Option `end` of an address → what ends a command."""
_PARITIES: Final[dict[str, Literal["none", "odd", "even"]]] = {
    "none": "none",
    "odd": "odd",
    "even": "even",
}
_STOPS: Final[dict[str, Literal[1, 2]]] = {"1": 1, "2": 2}
_BITS: Final[dict[str, Literal[7, 8]]] = {"7": 7, "8": 8}


class Link:
    """name: for findings. timeout: seconds for connecting and for each answer."""

    def __init__(self, stream: Stream, framing: Framing, *, name: str, timeout: float) -> None:
        self.most = framing.most
        self.connected = False
        self._stream, self._framing = stream, framing
        self._name = name
        self._timeout = timeout
        self._lock = threading.Lock()

    def open(self, timeout: float | None = None) -> None:
        """Connects; raises rules.Lost."""
        self.close()
        try:
            self._stream.open(self._timeout if timeout is None else timeout)
        except Refused:  # pyserial is missing; Refused is a ValueError, too
            raise
        except (OSError, UnicodeError, ValueError) as error:
            self._lost(
                rules.UNREACHABLE(place=self._name, address=self._name, reason=reason_of(error))
            )
        self.connected = True

    def close(self) -> None:
        self.connected = False
        self._stream.close()

    def ask(
        self,
        command: str,
        *,
        doing: str,
        state: str,
        shape: re.Pattern[str] | None = None,
        timeout: float | None = None,
    ) -> Answer:
        """Send one command and wait for its answer, which may be an error number.

        doing, state: for the finding if the connection fails; raises rules.Lost. shape: of an
        answer without an error. After a failure, and after an interruption, the connection is
        closed: a late answer must not pass for that of another command.
        """
        data = command.encode(ENCODING)
        assert len(data) <= self.most and not re.search(rb"[\r\n]", data)
        with self._lock:
            if not self.connected:
                self._lost(self._gone(doing, "there is no session", state))
            try:
                seconds = self._timeout if timeout is None else timeout
                raw = self._framing.exchange(self._stream, data, seconds)
            except OSError as error:
                self._lost(self._gone(doing, reason_of(error), state))
            except _UnaskedData as unasked:
                self._lost(self._garbled(doing, unasked.data.decode(ENCODING), state))
            # Ctrl-C within an exchange: a late answer must not pass for that of the next command.
            except BaseException:
                self.close()
                raise
            text = raw.decode(ENCODING)
            answer = parse_answer(text)
            # A confirmation with text is the answer to another command.
            if answer is None or (answer.ok and shape and not shape.fullmatch(answer.text)):
                self._lost(self._garbled(doing, text, state))
            return answer

    def stays_quiet(self, seconds: float) -> bool:
        """True if nothing arrives for a while; raises rules.Lost."""
        try:
            self._stream.receive(seconds)
        except TimeoutError:
            return True
        except OSError as error:
            self._lost(self._gone("listening", reason_of(error), "nothing was sent"))
        return False

    def garbled(self, doing: str, text: str, state: str) -> NoReturn:
        """Close the connection for an answer that makes no sense, and raise rules.Lost."""
        self._lost(self._garbled(doing, text, state))

    def _gone(self, doing: str, reason: str, state: str) -> Diagnostic:
        return rules.LOST(place=self._name, doing=doing, reason=reason, state=state)

    def _garbled(self, doing: str, text: str, state: str) -> Diagnostic:
        shown = repr(text[:80])
        return rules.GARBLED(place=self._name, doing=doing, answer=shown, state=state)

    def _lost(self, finding: Diagnostic) -> NoReturn:
        self.close()
        raise rules.Lost(finding) from None


def link_to(address: Address, *, timeout: float, terminator: bytes | None = None) -> Link:
    """The link that an address with its options says; terminator: instead of option `end`."""
    ends = ENDS[address.option("end", "cr")] if terminator is None else terminator
    procedural = address.option("framing", "plain") == "procedural"
    framing = _ProceduralFraming() if procedural else _PlainFraming(ends)
    stream: Stream
    if address.scheme == "melfa-serial":
        stream = Serial(address.host, _rate(address))
    else:
        stream = TcpClient(str(address), address.host, address.port, patient=False)
    return Link(stream, framing, name=str(address), timeout=timeout)


def _rate(address: Address) -> Rate:
    """Return the settings of a serial line; 9600 baud, 8 bits, even parity, 2 stop bits by
    default.
    """
    return Rate(
        int(address.option("baud", "9600")),
        _PARITIES[address.option("parity", "even")],
        _STOPS[address.option("stop", "2")],
        _BITS[address.option("bits", "8")],
    )
