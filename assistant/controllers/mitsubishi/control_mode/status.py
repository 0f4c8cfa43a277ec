"""The status stream of data link control mode: a thread that hears it, and keeps it alive.

The program DATALINK sends records from the first message on until a "0", and all programs stop
when the "2" of a client that asked to be watched does not come for two seconds.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, NoReturn

from assistant.base.diagnostics import Refused, Rule
from assistant.controllers.mitsubishi.data_link import DataLink, Form, Joints, Position, rules
from assistant.controllers.recording import Recording
from assistant.controllers.rules import Lost

FORM: Final = Form.parse("M_TIMER(1) | P_CURR | J_FBC | J_CURR | M_RSPD(3) | M_04")
"""What the program DATALINK prints."""
READY_WORD: Final = "READY"
END_WORD: Final = "END"
STOP_MESSAGE: Final = "0"
WATCH_MESSAGE: Final = "2"
WATCH_INTERVAL: Final = 0.4
"""Seconds between two messages of a client that is watched; two seconds stop the programs."""
STOPPING_TIMEOUT: Final = 5.0
"""Seconds that the programs have to end."""
STOP_BY_THEMSELVES: Final = "the programs stop by themselves within 2 s of the last message"
RUN_ON: Final = "no position was sent; programs that run may still wait for one"
"""What is known of a controller whose status line is gone."""


@dataclass(frozen=True, slots=True)
class Status:
    """A record of the stream.

    seconds: on the controller since its program began. position: of the tool. feedback,
    commanded: joints in degrees, as measured and as asked for. speed: of the tool, mm/s.
    taken: joint positions that the program has read from its line.
    """

    seconds: float
    position: Position
    feedback: Joints
    commanded: Joints
    speed: float
    taken: int


class StatusStream:
    """silence: seconds without a record after which the arm is not known any more."""

    def __init__(self, link: DataLink, silence: float) -> None:
        self.link = link
        self.silence = silence
        self.recording = FORM.recording("seconds")
        self.latest: Status | None = None
        self.ended = False
        self.failure: Refused | None = None
        self._news = threading.Condition()
        self._stopping = threading.Event()
        self._over = threading.Event()
        self._tried = False
        self._thread = threading.Thread(target=self._run, name="status", daemon=True)

    def start(self) -> None:
        """Asks for the stream; the link is open."""
        self._thread.start()

    def first(self) -> Status:
        """The latest record, once there is one; raises Refused as `wait` does."""
        if self._thread.ident is None:
            raise self._lost("asking for the status", "there is no session")
        while not self.wait(lambda latest: latest is not None, self.link.timeout):
            """The thread tells when that took too long."""
        assert self.latest is not None
        return self.latest

    def wait(self, enough: Callable[[Status | None], bool], timeout: float) -> bool:
        """Waits until a record is enough; False if none was in time.

        Raises Refused once there is no stream any more.
        """
        with self._news:
            self._news.wait_for(lambda: self._gone or enough(self.latest), timeout)
            if self.failure is not None:
                raise self.failure
            if self.ended:
                raise Lost(rules.ENDED(place=self.link.target, state="the arm stands"))
            return enough(self.latest)

    def stop(self, timeout: float, *, again: bool) -> bool:
        """Asks for the end of all programs; whether they said that they end.

        again: whether a line that was cut is connected to once more for that.
        """
        if self._thread.is_alive():
            self._stopping.set()
            with self._news:
                self._news.wait_for(lambda: self._gone, timeout)
        if again and self.failure is not None and not self.ended and not self._tried:
            self._tried = True
            with suppress(Refused):
                self._stop_anew(time.monotonic() + min(timeout, self.link.timeout))
        return self.ended

    def _stop_anew(self, end: float) -> None:
        self._thread.join()
        self.link.close()
        self.link.open()
        while not self.ended and time.monotonic() < end:
            self.link.send(STOP_MESSAGE)
            heard = time.monotonic()
            while not self.ended and time.monotonic() - heard < WATCH_INTERVAL:
                self.ended = self.link.wait(RECORD_SLICE) == END_WORD

    @property
    def state(self) -> str:
        """What is known of the programs if nothing more is heard of them."""
        return RUN_ON if self.latest is None else STOP_BY_THEMSELVES

    def close(self) -> None:
        """Ends the thread and the line."""
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()
        self.link.close()

    @property
    def _gone(self) -> bool:
        return self.ended or self.failure is not None

    def _run(self) -> None:
        failure: Refused | None = self._lost("listening", "nobody listens any more")
        try:
            self._hear()
            if self.ended:
                failure = None
        except Refused as error:
            failure = error
        finally:  # nobody waits for ever, whatever it was
            with self._news:
                self.failure = failure
                self._news.notify_all()

    def _hear(self) -> None:
        began = heard = time.monotonic()
        said, word = -WATCH_INTERVAL, ""
        while not self._over.is_set():
            now = time.monotonic()
            asked = STOP_MESSAGE if self._stopping.is_set() else WATCH_MESSAGE
            if now - said >= WATCH_INTERVAL or asked != word:
                said, word = now, asked
                self.link.send(word)
            line = self.link.wait(RECORD_SLICE)
            now = time.monotonic()
            if line == END_WORD:
                with self._news:
                    self.ended = True
                    self._news.notify_all()
                return
            if line is not None and self._take(line, now - began):
                heard = now
            allowed = self.silence if self.latest is not None else self.link.timeout
            if now - heard > allowed:
                self._fail(rules.SILENT, seconds=allowed)

    def _take(self, line: str, seconds: float) -> bool:
        """Whether the line is a record; raises Lost if it is nothing that the program says."""
        if line == READY_WORD and self.latest is None:
            return False
        try:
            values = FORM.read(line)
        except ValueError:
            self._fail(rules.LINE_GARBLED, answer=repr(line[:80]))
        match values:
            case (
                float(timer),
                Position() as position,
                Joints() as feedback,
                Joints() as commanded,
                float(speed),
                float(taken),
            ):
                status = Status(timer / 1000, position, feedback, commanded, speed, int(taken))
            case _:
                raise AssertionError(FORM)
        with self._news:
            self.latest = status
            FORM.record(self.recording, values, seconds)
            self._news.notify_all()
        return True

    def _lost(self, doing: str, reason: str) -> Lost:
        target, state = self.link.target, self.state
        return Lost(
            rules.LINE_LOST(place=target, target=target, doing=doing, reason=reason, state=state)
        )

    def _fail(self, rule: Rule, *, seconds: float = 0.0, answer: str = "") -> NoReturn:
        target = self.link.target
        raise Lost(
            rule(place=target, target=target, seconds=seconds, answer=answer, state=self.state)
        )


class Streaming:
    """What has a status stream; each time that it is entered it has another one."""

    def __init__(self, line: str | DataLink, silence: float, timeout: float) -> None:
        self._stream = StatusStream(link_to(line, timeout), silence)

    @property
    def recording(self) -> Recording:
        """Every status that came, in columns; `seconds` are those of this computer."""
        return self._stream.recording

    @property
    def status(self) -> Status:
        """The latest one; raises Refused if there is none any more."""
        return self._stream.first()

    def _anew(self) -> None:
        self._stream = StatusStream(self._stream.link, self._stream.silence)


def link_to(line: str | DataLink, timeout: float) -> DataLink:
    """line: a target of `DataLink`, or a link that is not open yet."""
    return line if isinstance(line, DataLink) else DataLink(line, timeout=timeout)


RECORD_SLICE: Final = 0.1
"""Seconds that a record is waited for at a time."""
