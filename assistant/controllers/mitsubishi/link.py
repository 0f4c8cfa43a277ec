"""The controller link of Mitsubishi CR controllers, client side: one command, one answer.

Framing and answers are those of the manual BFP-A4288: `[robot];[slot];COMMAND` goes out,
`QoK…` or `QeR<number>…` comes back; a lower-case third letter is the same answer of a
controller in an error state. The controller never speaks first.
"""

from __future__ import annotations

import re
import socket
from dataclasses import dataclass
from typing import Any, Final, NoReturn

from assistant.controllers import rules
from assistant.controllers.os_errors_in_words import reason_of
from assistant.program.diagnostics import Diagnostic, Rule

ENCODING: Final = "latin-1"
MOST_BYTES: Final = 255
"""Of one command, its head included."""
MOST_ANSWER: Final = 1 << 20
"""Bytes after which an answer is nonsense."""
FIRST_QUIET: Final = 0.3
"""Seconds of silence that end the first answer of a controller which sends no end code."""
QUIET: Final = 0.1
"""The same once it is known to send none."""
ANSWER: Final = re.compile(r"Q(OK|ER)(.*)", re.IGNORECASE | re.DOTALL)
ERROR: Final = re.compile(r"(\d{4})((?:;\d+)*)\s*$")


@dataclass(frozen=True, slots=True)
class Answer:
    """An answer: its text, or the error number and the places (line, character) behind it.

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
    """The answer that a text is, None if it is none."""
    found = ANSWER.match(raw)
    if found is None:
        return None
    kind, text = found[1], found[2]
    alarmed = kind[1].islower()
    if kind.upper() == "OK":
        return Answer(text, alarmed=alarmed)
    error = ERROR.match(text)
    if error is None:
        return None
    places = tuple(int(p) for p in error[2].split(";") if p)
    return Answer(text, int(error[1]), places, alarmed)


class Link:
    """A TCP connection to a controller link.

    timeout: seconds for connecting and for each answer. terminator: what ends a command.
    """

    def __init__(
        self, host: str, port: int, *, timeout: float = 10.0, terminator: bytes = b"\r"
    ) -> None:
        self._place = (host, port)
        self._timeout = timeout
        self._terminator = terminator
        self._socket: socket.socket | None = None
        self._ends: bool | None = None  # whether answers have an end code; None: not known yet

    @property
    def connected(self) -> bool:
        return self._socket is not None

    def open(self) -> None:
        """Connects; raises rules.Lost."""
        self.close()
        self._ends = None
        try:
            self._socket = socket.create_connection(self._place, timeout=self._timeout)
        except (OSError, UnicodeError) as error:
            self._lost(rules.UNREACHABLE, address=self._name, reason=reason_of(error))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def ask(self, command: str, *, doing: str, state: str) -> Answer:
        """Sends one command and waits for its answer, which may be an error number.

        doing, state: for the finding if the connection fails; raises rules.Lost. After a
        failure the connection is closed: a late answer must not pass for that of another.
        """
        if self._socket is None:
            self._lost(rules.LOST, doing=doing, reason="there is no session", state=state)
        data = command.encode(ENCODING)
        assert len(data) <= MOST_BYTES and not re.search(rb"[\r\n]", data)
        try:
            self._socket.settimeout(self._timeout)
            self._socket.sendall(data + self._terminator)
            raw = self._receive(self._socket)
        except OSError as error:
            self._lost(rules.LOST, doing=doing, reason=reason_of(error), state=state)
        answer = parse_answer(raw)
        if answer is None:
            shown = repr(raw[:80])
            self._lost(rules.GARBLED, doing=doing, answer=shown, state=state)
        return answer

    def _receive(self, connection: socket.socket) -> str:
        """One answer without its end code; raises OSError (TimeoutError if none comes)."""
        data = b""
        while len(data) < MOST_ANSWER:
            started = parse_answer(data.decode(ENCODING)) is not None
            bare = started and not self._ends
            quiet = FIRST_QUIET if self._ends is None else QUIET
            connection.settimeout(min(quiet, self._timeout) if bare else self._timeout)
            try:
                piece = connection.recv(65536)
            except TimeoutError:
                if not bare:
                    raise
                self._ends = False
                return data.decode(ENCODING)
            if not piece:
                raise ConnectionResetError
            data = (data + piece).lstrip(b"\r\n")
            if end := re.search(rb"[\r\n]", data):
                self._ends = True
                # What follows an end code, but for the LF of a CRLF, was not asked for.
                rest = data[end.start() :].strip(b"\r\n")
                return data.decode(ENCODING) if rest else data[: end.start()].decode(ENCODING)
        return data.decode(ENCODING)

    @property
    def _name(self) -> str:
        return f"melfa://{self._place[0]}:{self._place[1]}"

    def _lost(self, rule: Rule, **fields: str) -> NoReturn:
        self.close()
        raise rules.Lost(_filled(rule, self._name, fields)) from None


def _filled(rule: Rule, place: str, fields: dict[str, Any]) -> Diagnostic:
    return rule(place=place, **fields)
