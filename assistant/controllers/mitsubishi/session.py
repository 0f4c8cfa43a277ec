"""Session with a CR controller: opening, commands, return of the operation right; error numbers.

The session takes the right for the commands that need it and gives it back afterwards, however they
end. If the line was cut meanwhile, one new connection gives it back, or a finding reports that it
may still be held. `cr_error` explains an error number by `errors.tsv`; numbers and levels are those
of the controllers' error lists (BFP-A8871, BFP-A5993). A number that ends in `n` represents those
of all axes or units.
"""

from __future__ import annotations

import csv
import io
import re
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from importlib.resources import files
from typing import Final, NoReturn

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.address import Address
from assistant.controllers.mitsubishi.link import BARE_ANSWER, ENCODING, Answer, Link, link_to

_ERROR_LEVELS: Final = {"H": "high", "L": "low", "C": "caution"}
"""High: servos go off. Low: the program stops. Caution: the program goes on."""

_ERROR_FAMILIES: Final = {
    0: "an error of the hardware",
    1: "an error of the servos",
    2: "an error of the motion",
    3: "an error of the running program",
    4: "an error of a program or its editing",
    5: "a command that the present state forbids",
    6: "an error of the communication or the signals",
    7: "an error of files, parameters or options",
    8: "an error of an option",
    9: "an error raised by the user's program",
}
"""First digit of the number → what it is about, for numbers that the table does not name."""

LOOK_IT_UP: Final = "look the number up in the controller's troubleshooting manual"


@dataclass(frozen=True, slots=True)
class CrError:
    """One error number; level is a key of `_ERROR_LEVELS`, "" if it is not known."""

    number: int
    level: str
    text: str
    cure: str


def cr_error(number: int) -> CrError:
    """Return the meaning of an error number; never fails."""
    digits = f"{number:04}"
    # A row ending in `n` stands for the errors of all axes or units; an exact number comes first.
    rows = (_error_table().get(digits), _error_table().get(f"{digits[:-1]}n"))
    level, text, cure = next((row for row in rows if row is not None), ("", "", ""))
    words = text.replace("{n}", digits[-1]) or _ERROR_FAMILIES.get(number // 1000, "an error")
    return CrError(number, level, words, cure or LOOK_IT_UP)


@cache
def _error_table() -> Mapping[str, tuple[str, str, str]]:
    """Return number → level, text and cure; a text is empty where the table has none."""
    text = files(__package__).joinpath("errors.tsv").read_text(encoding="ascii")
    rows = csv.DictReader(io.StringIO(text), delimiter="\t", quoting=csv.QUOTE_NONE)
    return {row["number"]: (row["level"], row["text"], row["cure"]) for row in rows}


_OPEN_NAME: Final = "USERTOOL"
"""Name under which a session is opened; controllers know NARCUSR, USERTOOL and TOOLBOX."""
_HELLOS: Final = 3
"""Times that a session is opened on a serial line until the answer is one to that."""
_QUIET_AFTER_HELLO: Final = 0.15
"""Seconds after that answer in which nothing else may come: it could be a late one itself."""
_TAKEN_ERRORS: Final = frozenset({4170})
"""A program that is open somewhere, also in a session whose line is cut (reference, 4)."""
_NO_RIGHT: Final = 6020
UNCHANGED: Final = "nothing was changed by that"
RUN_BITS: Final = re.compile(r"([0-9A-F]{2})([0-9A-F]{2})(\d*)(?:;.*)?", re.IGNORECASE | re.DOTALL)
"""Run bits, stop bits and error number, as DSTATE and the fifth field of STATE have them."""
_RIGHT_TAKEN: Final = 0x80
COMMAND_INTERVAL: Final = 0.1
"""Seconds between commands while a program runs, which the manual asks for."""
_RIGHT_POLL: Final = 0.05
"""Seconds between two looks whether the right is free."""


@dataclass(frozen=True, slots=True)
class About:
    """Identity that a controller reports when a session is opened; "" for missing fields.

    suffix: of its program files. slots: number of its task slots; the edit slot follows.
    """

    robot: str = ""
    controller: str = ""
    version: str = ""
    suffix: str = ""
    slots: int = 8


def about(text: str) -> About:
    """Parse the answer to OPEN=; missing fields stay empty."""
    # The field may be missing or empty on older controllers, which have eight slots.
    fields = dict(enumerate(text.split(";")))
    slots = fields.get(15, "").strip()
    return About(
        robot=fields.get(6, "").strip(),
        controller=fields.get(7, "").strip(),
        version=fields.get(10, "").strip(),
        suffix=fields.get(4, "").strip().upper(),
        slots=int(slots) if re.fullmatch(r"[1-9]\d?", slots) else 8,
    )


class Session:
    """A connection to a CR controller that can be opened, used and closed.

    running: whether a program ran when the state was last read; commands keep `pace` seconds
    between them then. under_way: condition of the controller during an operation that has changed
    it, where a single command changes nothing.
    """

    def __init__(
        self,
        address: Address,
        *,
        timeout: float,
        terminator: bytes | None = None,
        pace: float = COMMAND_INTERVAL,
    ) -> None:
        self.address = address
        self.timeout = timeout
        self.about = About()
        self.has_right = False
        self.running = False
        self.under_way = UNCHANGED
        self._link: Link = link_to(address, timeout=timeout, terminator=terminator)
        self._pace = pace
        self._depth = 0
        self._asked = 0.0
        self._lock = threading.RLock()

    @property
    def most(self) -> int:
        """Bytes of a command, its head included."""
        return self._link.most

    def carries(self, command: str) -> bool:
        """True if the link can carry a command with its head, unchanged."""
        data = command.encode(ENCODING, "replace")
        longest = len(f"0;{self.edit_slot};") + len(data)
        return longest <= self.most and data.decode(ENCODING) == command

    @property
    def edit_slot(self) -> int:
        return self.about.slots + 1

    @property
    def connected(self) -> bool:
        return self._link.connected

    def open(self) -> None:
        """Connects and opens a session; raises Lost."""
        self._link.open()
        try:
            answer = self._hello(self.timeout)
        except BaseException:
            self._link.close()
            raise
        if answer.ok:  # a controller without OPEN still takes the other commands
            self.about = about(answer.text)

    def close(self) -> None:
        if self._link.connected:
            with suppress(Refused):
                self.ask("CLOSE", doing="closing the session", shape=BARE_ANSWER)
        self._link.close()

    def ask(
        self,
        command: str,
        *,
        doing: str,
        state: str = UNCHANGED,
        slot: int = 1,
        shape: re.Pattern[str] | None = None,
    ) -> Answer:
        """Return an answer without an error; take the operation right if the controller asks."""
        answer = self.attempt(command, doing=doing, state=state, slot=slot, shape=shape)
        if answer.number is not None:
            raise self.refusal(answer.number, doing, state)
        return answer

    def attempt(
        self,
        command: str,
        *,
        doing: str,
        state: str = UNCHANGED,
        slot: int = 1,
        shape: re.Pattern[str] | None = None,
    ) -> Answer:
        """The answer, which may be an error number."""

        def once() -> Answer:
            return self._once(f"1;{slot};{command}", doing, state, shape)

        answer = once()
        # Refused although this session holds the right: taking it again would change nothing.
        if answer.number != _NO_RIGHT or self.has_right:
            return answer
        with self.scope():
            refused = self._take_right(doing, state)
            return refused or once()

    @contextmanager
    def scope(self) -> Iterator[None]:
        """Context of related commands: gives an operation right acquired in it back at its end."""
        self._depth += 1
        try:
            yield
        except BaseException as caught:
            # Before the right goes back: `_leave` does so at the outermost scope only.
            self._depth -= 1
            self._leave(caught)
            raise
        self._depth -= 1
        self._leave(None)

    @contextmanager
    def right(self, doing: str, state: str = UNCHANGED) -> Iterator[None]:
        """Context with the operation right; raises Refused if another client has it."""
        with self.scope():
            refused = None if self.has_right else self._take_right(doing, state)
            if refused is not None and refused.number is not None:
                raise self.refusal(refused.number, doing, state)
            yield

    @contextmanager
    def anew(self) -> Iterator[None]:
        """Context with a connection: a new one if the present one is gone, closed again at the
        end.
        """
        # A connection that is there stays open for whoever uses the session next.
        if self._link.connected:
            yield
            return
        self._link.open()
        try:
            self._hello(self.timeout)
            yield
        finally:
            self._link.close()

    def refusal(self, number: int, doing: str, state: str = UNCHANGED) -> Refused:
        """Return the exception for an error number."""
        kind = rules.Taken if number in _TAKEN_ERRORS else Refused
        return kind(self.alarm(number, doing, state))

    def alarm(self, number: int, doing: str, state: str = UNCHANGED) -> Diagnostic:
        """The finding that an error number is."""
        known = cr_error(number)
        return rules.ALARM(
            place=str(self.address),
            number=f"{number:04}",
            text=known.text,
            cure=known.cure,
            doing=doing,
            state=self._state(state),
        )

    def garbled(self, doing: str, text: str, state: str = UNCHANGED) -> NoReturn:
        """End the connection for an answer that makes no sense; raises rules.Lost."""
        self._link.garbled(doing, text, self._state(state))

    def _state(self, state: str) -> str:
        return self.under_way if state == UNCHANGED else state

    def _once(
        self, command: str, doing: str, state: str, shape: re.Pattern[str] | None = None
    ) -> Answer:
        with self._lock:
            if self.running:
                time.sleep(max(0.0, self._asked + self._pace - time.monotonic()))
            try:
                told = self._state(state)
                return self._link.ask(command, doing=doing, state=told, shape=shape)
            finally:
                self._asked = time.monotonic()

    def _hello(self, timeout: float) -> Answer:
        """OPEN=; on a serial line again if what comes is not for it.

        There half a command of an earlier connection may stand before it, or a late answer.
        """
        # On a line without connections, bytes of an earlier session may still be under way.
        doing = "opening a session"
        serial = self.address.port == 0
        for left in reversed(range(_HELLOS if serial else 1)):
            try:
                answer = self._link.ask(
                    f"1;1;OPEN={_OPEN_NAME}", doing=doing, state=UNCHANGED, timeout=timeout
                )
            except rules.Lost as error:
                if not left or error.findings[0].code != rules.GARBLED.code:
                    raise
                self._link.open(timeout)  # which forgets what has come
                continue
            # A late answer of an earlier session has no robot, or the real one follows it.
            if not serial or (
                about(answer.text).robot and self._link.stays_quiet(_QUIET_AFTER_HELLO)
            ):
                break
        return answer

    def _take_right(self, doing: str, state: str) -> Answer | None:
        """None if this session has the right now, else the answer that refuses it."""
        self.has_right = True  # from here on it may be held, whatever becomes of the answer
        answer = self._once("1;1;CNTLON", doing, state, BARE_ANSWER)
        self.has_right = answer.ok
        return None if answer.ok else answer

    def _leave(self, caught: BaseException | None) -> None:
        """Gives the right back; raises Lost with what was caught if that cannot be done."""
        if self._depth or not self.has_right:
            return
        doing = "giving the operation right back"
        lost: Refused | None = None
        reason: str | None = "the connection was lost"
        if self._link.connected:
            try:
                answer = self._once("1;1;CNTLOFF", doing, "what was asked for is done", BARE_ANSWER)
                reason = None if answer.ok else f"error {answer.number:04}"
            except rules.Lost as error:
                lost = error
        if not self._link.connected:
            reason = self._give_back_anew()
        self.has_right = False
        if reason is not None:
            earlier = caught.findings if isinstance(caught, Refused) else ()
            place = str(self.address)
            # An earlier error is reported together with the right that could not be given back.
            raise rules.Lost(
                *earlier, rules.RIGHT_HELD(place=place, address=place, reason=reason)
            ) from caught
        if lost is not None and caught is None:
            raise lost

    def _give_back_anew(self) -> str | None:
        """Gives the right back over a new connection; why not, None if it is free."""
        end = time.monotonic() + self.timeout
        doing = "giving the operation right back over a new connection"
        try:
            self._link.open(self.timeout)
            self._hello(self.timeout)
            while True:
                # The old connection may hold the right until the
                # controller notices its end: look repeatedly.
                left = max(_RIGHT_POLL, end - time.monotonic())
                self._link.ask("1;1;CNTLOFF", doing=doing, state=UNCHANGED, timeout=left)
                told = self._link.ask("1;1;DSTATE", doing=doing, state=UNCHANGED, timeout=left)
                bits = RUN_BITS.fullmatch(told.text)
                if bits is None or not told.ok:
                    return "the controller does not tell whether it is free"
                if not int(bits[1], 16) & _RIGHT_TAKEN:
                    return None
                if time.monotonic() + _RIGHT_POLL > end:
                    return "the controller shows it as taken"
                time.sleep(_RIGHT_POLL)
        except Refused as error:
            return error.findings[0].message
        finally:
            self._link.close()
