"""The controller link of Mitsubishi CR controllers, client side: one command, one answer.

`[robot];[slot];COMMAND` goes out, an answer comes back (BFP-A4288); the controller never
speaks first. What carries the bytes and how a command lies among them are parts of their own.
"""

from __future__ import annotations

import re
import threading
from typing import Final, Literal, NoReturn

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.address import Address
from assistant.controllers.mitsubishi.answers import ENCODING, Answer, parse_answer
from assistant.controllers.mitsubishi.data_link.streams import Rate, Serial, Stream, TcpClient
from assistant.controllers.mitsubishi.framing import (
    Framing,
    PlainFraming,
    ProceduralFraming,
    UnaskedData,
)
from assistant.controllers.os_errors_in_words import reason_of

ENDS: Final = {"cr": b"\r", "crlf": b"\r\n", "none": b""}
"""Option `end` of an address → what ends a command."""
PARITIES: Final[dict[str, Literal["none", "odd", "even"]]] = {
    "none": "none",
    "odd": "odd",
    "even": "even",
}
STOPS: Final[dict[str, Literal[1, 2]]] = {"1": 1, "2": 2}
BITS: Final[dict[str, Literal[7, 8]]] = {"7": 7, "8": 8}


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
        """Sends one command and waits for its answer, which may be an error number.

        doing, state: for the finding if the connection fails; raises rules.Lost. shape: of an
        answer that is no error. After a failure, and after an interruption, the connection is
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
            except UnaskedData as unasked:
                self._lost(self._garbled(doing, unasked.data.decode(ENCODING), state))
            except BaseException:
                self.close()
                raise
            text = raw.decode(ENCODING)
            answer = parse_answer(text)
            if answer is None or (answer.ok and shape and not shape.fullmatch(answer.text)):
                self._lost(self._garbled(doing, text, state))
            return answer

    def stays_quiet(self, seconds: float) -> bool:
        """Whether nothing comes for a while; raises rules.Lost."""
        try:
            self._stream.receive(seconds)
        except TimeoutError:
            return True
        except OSError as error:
            self._lost(self._gone("listening", reason_of(error), "nothing was sent"))
        return False

    def garbled(self, doing: str, text: str, state: str) -> NoReturn:
        """What an answer says makes no sense: closes the connection and raises rules.Lost."""
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
    framing = ProceduralFraming() if procedural else PlainFraming(ends)
    stream: Stream
    if address.scheme == "melfa-serial":
        stream = Serial(address.host, _rate(address))
    else:
        stream = TcpClient(str(address), address.host, address.port, patient=False)
    return Link(stream, framing, name=str(address), timeout=timeout)


def _rate(address: Address) -> Rate:
    """What a serial line is set to; 9600 baud, 8 bits, even parity, 2 stop bits if not stated."""
    return Rate(
        int(address.option("baud", "9600")),
        PARITIES[address.option("parity", "even")],
        STOPS[address.option("stop", "2")],
        BITS[address.option("bits", "8")],
    )
