"""The host's end of a line that a program on the controller has opened."""

from __future__ import annotations

import time
from typing import Final, NoReturn, Self

from assistant.base.diagnostics import Refused, Rule
from assistant.controllers.mitsubishi.data_link import records, rules
from assistant.controllers.mitsubishi.data_link.records import Form, Value
from assistant.controllers.mitsubishi.data_link.streams import Rate, Stream, stream_to
from assistant.controllers.os_errors_in_words import reason_of
from assistant.controllers.rules import Lost

MOST_LINE: Final = 4096
"""Bytes without an end after which what comes is no line of a program."""
LINE_END: Final = b"\r"


class DataLink:
    """What `Open "COMn:"`, Print# and Input# of a program talk to; a context manager.

    target: see `streams.stream_to`. timeout: seconds for connecting, sending and each line.
    prefix: `PRN` on a line that takes commands as well (CPRC232 = 0). state: what the findings
    say about the controller.
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
        """What can be done before a program opens the line; raises Lost."""
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
        data = f"{self._prefix}{records.input_line(values)}".encode(records.ENCODING) + LINE_END
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
            if len(self._come) > MOST_LINE:
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
        self._come = self._come.removeprefix(b"\n")
        line, end, rest = self._come.partition(LINE_END)
        if not end:
            return None
        self._come = rest
        return line.decode(records.ENCODING)

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
