"""How one command and its answer lie on the line: plain, or with the procedure of RS-232.

Plain: an end code behind each, CR or CR LF, or none where an answer ends when the line goes
quiet. Procedural: ENQ, ACK, a frame with its length and checksum, ACK, EOT, and the answer the
same way back, each step tried again three times (BFP-A4288, parameter CPRC232; the number of
trials is that of RT ToolBox).
"""

from __future__ import annotations

import re
import time
from functools import reduce
from operator import xor
from typing import Final, Protocol

from assistant.controllers.mitsubishi.answers import ENCODING, parse_answer
from assistant.controllers.mitsubishi.data_link.streams import Stream

MOST_ANSWER: Final = 1 << 20
"""Bytes after which an answer is nonsense."""
FIRST_QUIET: Final = 0.3
"""Seconds of silence that end the first answer of a controller which sends no end code."""
QUIET: Final = 0.1
"""The same once it is known to send none."""
STX, ETX, EOT, ENQ, ACK, NAK = (bytes([code]) for code in (0x02, 0x03, 0x04, 0x05, 0x06, 0x15))
TRIALS: Final = 4
"""Of a step: the first one and three more."""
STEP_TIMEOUT: Final = 2.0
"""Seconds for a step of the procedure; 255 bytes take 0.3 s at 9600 baud."""


class UnaskedData(Exception):
    """data: what is on the line and cannot be the answer to a command."""

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


class PlainFraming:
    """No procedure. terminator: what ends a command, b"" for nothing."""

    def __init__(self, terminator: bytes = b"\r") -> None:
        self.most = 255
        self._terminator = terminator
        self._ends: bool | None = None  # whether answers have an end code; None: not known yet

    def exchange(self, stream: Stream, command: bytes, timeout: float) -> bytes:
        if waiting := pending(stream).strip(b"\r\n"):
            raise UnaskedData(waiting)
        stream.send(command + self._terminator, timeout)
        return self._answer(stream, time.monotonic() + timeout)

    def _answer(self, stream: Stream, end: float) -> bytes:
        data = b""
        while len(data) < MOST_ANSWER:
            started = parse_answer(data.decode(ENCODING)) is not None
            bare = started and not self._ends
            quiet = FIRST_QUIET if self._ends is None else QUIET
            left = end - time.monotonic()
            if left < -FIRST_QUIET:  # it is never quiet
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
                if data[code.start() :].strip(b"\r\n"):
                    raise UnaskedData(data)
                return data[: code.start()]
        raise UnaskedData(data)


class ProceduralFraming:
    """With the procedure of RS-232."""

    def __init__(self) -> None:
        self.most = 254  # the length counts the letter before the command

    def exchange(self, stream: Stream, command: bytes, timeout: float) -> bytes:
        if waiting := pending(stream).strip(EOT + b"\r\n"):
            raise UnaskedData(waiting)
        end = time.monotonic() + timeout
        self._insist(stream, ENQ, end)
        self._insist(stream, frame(command), end)
        stream.send(EOT, timeout)
        return self._answer(stream, end)

    def _insist(self, stream: Stream, data: bytes, end: float) -> None:
        """Sends until it is acknowledged; raises OSError."""
        for _ in range(TRIALS):
            stream.send(data, STEP_TIMEOUT)
            try:
                reply = stream.receive(_left(end, STEP_TIMEOUT))
            except TimeoutError:
                if time.monotonic() >= end:
                    raise
                continue
            if reply.endswith(ACK):
                return
            if ENQ in reply:
                raise UnaskedData(reply)
        raise TimeoutError

    def _answer(self, stream: Stream, end: float) -> bytes:
        data = self._until(stream, ENQ, b"", end, end - time.monotonic())
        stream.send(ACK, STEP_TIMEOUT)
        for _ in range(TRIALS):
            data = self._until(stream, ETX, data, end, STEP_TIMEOUT)
            text = unframed(data)
            stream.send(NAK if text is None else ACK, STEP_TIMEOUT)
            data = b""
            if text is not None:
                self._closed(stream, end)
                return text
        raise UnaskedData(b"frames with wrong checksums")

    def _until(self, stream: Stream, code: bytes, data: bytes, end: float, step: float) -> bytes:
        """What comes up to a control code, which is left out with all before ENQ."""
        while code not in data:
            if len(data) > MOST_ANSWER:
                raise UnaskedData(data)
            data += stream.receive(_left(end, step))
            if code == ETX and data.endswith(ENQ):  # our ACK was lost
                stream.send(ACK, STEP_TIMEOUT)
                data = b""
        before, _, after = data.partition(code)
        return after if code == ENQ else before

    def _closed(self, stream: Stream, end: float) -> None:
        """Waits for EOT; a frame that comes once more is acknowledged once more."""
        try:
            while not (data := stream.receive(_left(end, STEP_TIMEOUT))).endswith(EOT):
                if data.endswith(ETX):
                    stream.send(ACK, STEP_TIMEOUT)
        except TimeoutError:
            return  # the frame was whole: what is missing is only its farewell


def frame(command: bytes) -> bytes:
    """A command with its length and checksum: XOR of all from the `D` on."""
    body = b"D0%02XR%s" % (len(command) + 1, command)
    return STX + body + b"%02X" % reduce(xor, body) + ETX


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
    """What has come already; raises OSError."""
    data = b""
    while len(data) < MOST_ANSWER:
        try:
            data += stream.receive(0.0)
        except TimeoutError:
            break
    return data


def _left(end: float, most: float) -> float:
    return min(most, max(0.0, end - time.monotonic()))
