"""Operation of a CR controller: slots, servos, start and stop, single statements, borrowed state.

`scratch` gives single statements separate variables: those of a program that is open in the edit
slot and never saved. `borrowed` surrounds the installing and running of programs: afterwards each
slot has its program again, external variables have their values, and new programs are deleted.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.mitsubishi import programs, values
from assistant.controllers.mitsubishi.link import BARE_ANSWER, ENCODING
from assistant.controllers.mitsubishi.programs import checked_name
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.mitsubishi.state import (
    SERVO,
    WAITING,
    faults,
    run_bits,
    running,
    slot_state,
)
from assistant.controllers.mitsubishi.values import external_variables, selected_program

_OPERATION_POLL: Final = 0.1
"""Seconds between two looks whether something has come to its end."""
_SERVO_TIME: Final = 10.0
"""Seconds that servos may take to come on; they need about two."""
MOST_PERCENT: Final = 100


def slot_of(session: Session, task: str, *, edit: bool = False) -> int:
    """The slot of a task's name, 1 for ""; raises Refused.

    edit: whether it may be the edit slot.
    """
    if not task:
        return 1
    last = session.edit_slot if edit else session.about.slots
    if task.isascii() and task.isdigit() and 1 <= int(task) <= last:
        return int(task)
    raise values.bad_value(
        task, "a task", "tasks of this controller are slots", "the number of a slot"
    )


def load(session: Session, name: str, slot: int) -> None:
    """Load a program into a slot; reset a program that is paused there first."""
    checked_name(name)
    doing = f"loading `{name}` into slot {slot}"
    with session.right(doing):
        before = slot_state(session, slot)
        if before.stop & WAITING and not before.running:
            session.ask("RSTPRG", doing=f"resetting slot {slot}", slot=slot, shape=BARE_ANSWER)
        session.ask(f"PRGLOAD={name}", doing=doing, slot=slot, shape=BARE_ANSWER)
    back = selected_program(session, slot)
    if back != name:
        raise Refused(rules.NOT_TAKEN(place=name, what=f"slot {slot}", sent=name, back=back))


def motors(session: Session, *, on: bool) -> None:
    """Switches the servos on or off, and comes back when they are."""
    doing = f"switching the servos {'on' if on else 'off'}"
    with session.right(doing):
        session.ask(f"SRV{'ON' if on else 'OFF'}", doing=doing, shape=BARE_ANSWER)

        def done() -> bool:
            return bool(run_bits(session)[0] & SERVO) == on

        state = "look at the state before anything moves"
        wait(session, done, doing, state, _SERVO_TIME, errors_end_it=on)


def start(session: Session, slot: int, *, forever: bool) -> None:
    """Starts the program of a slot, once or again and again."""
    name = selected_program(session, slot)
    doing = f"starting slot {slot}"
    if not name:
        raise Refused(session.alarm(5100, doing))
    checked_name(name)
    with session.right(doing):
        command = f"RUN{name};{0 if forever else 1}"
        state = "the program may or may not run now"
        session.ask(command, doing=doing, state=state, slot=slot, shape=BARE_ANSWER)
        session.running = slot_state(session, slot).running
        stopping = next((fault for fault in faults(session) if fault.level == "error"), None)
    if stopping is not None:
        raise Refused(session.alarm(stopping.number, doing, "the program stands"))


def stop(session: Session) -> None:
    """Stop all programs and motions, over a new connection if it is lost; needs no right.

    Other clients send STOP in slot 1; slots that continue get a separate stop.
    """
    session.running = False  # what stops does not wait for its turn
    with session.anew():
        session.ask("STOP", doing="stopping", shape=BARE_ANSWER)
        _stop_others(session, "stopping")


def halt(session: Session, caught: BaseException) -> None:
    """Stops what moves when something went wrong; raises Lost if that cannot be done."""
    session.running = False
    try:
        with session.anew():
            session.ask("STOP", doing="stopping", shape=BARE_ANSWER)
    except Refused as error:
        earlier = caught.findings if isinstance(caught, Refused) else ()
        place, reason = str(session.address), error.findings[0].message
        raise rules.Lost(
            *earlier, rules.NOT_STOPPED(place=place, address=place, reason=reason)
        ) from caught


def _stop_others(session: Session, doing: str) -> None:
    slots = range(1, session.about.slots + 1)
    for slot in slots:
        if slot_state(session, slot).running:
            session.ask("STOP", doing=doing, slot=slot, shape=BARE_ANSWER)

    state = "programs still run"
    wait(session, lambda: not running(session), doing, state, _SERVO_TIME, errors_end_it=False)


def override(session: Session, percent: int) -> None:
    if not 1 <= percent <= MOST_PERCENT:
        raise values.bad_value(percent, "an override", "it is a percentage", f"1 to {MOST_PERCENT}")
    doing = f"setting the override to {percent} %"
    with session.right(doing):
        back = session.ask(f"OVRD={percent}", doing=doing).text.strip()
    if back and back != str(percent):
        raise Refused(
            rules.NOT_TAKEN(place="override", what="the override", sent=str(percent), back=back)
        )


def execute(session: Session, statement: str, *, wait_for_end: bool, slot: int = 1) -> None:
    """Has the controller execute one statement, with what is open in the slot.

    wait_for_end: come back when it is done (EXEC2), else as soon as it is accepted (EXEC). It
    may move the arm: the controller is the one that looks at it.
    """
    command = f"EXEC2={statement}" if wait_for_end else f"EXEC{statement}"
    if not statement.strip() or not statement.isprintable():
        raise values.bad_value(
            statement, "a statement", "it holds control characters", "one statement"
        )
    if not session.carries(command):
        reason = f"the controller link carries {session.most} bytes of {ENCODING}"
        raise values.bad_value(statement[:40], "a statement", reason, "a shorter one")
    doing = f"executing `{statement[:40]}`"
    state = "it may or may not have been executed"
    with session.right(doing):
        session.ask(command, doing=doing, state=state, slot=slot, shape=BARE_ANSWER)


def wait(
    session: Session,
    done: Callable[[], bool],
    doing: str,
    state: str,
    seconds: float,
    *,
    errors_end_it: bool,
) -> None:
    """Looks until something is done; raises Refused if it lasts longer, or for an error.

    seconds: at most, and not less than an answer may take. errors_end_it: whether it will never
    be done while the controller shows an error.
    """
    most = max(seconds, session.timeout)
    end = time.monotonic() + most
    while not done():
        for fault in faults(session) if errors_end_it else ():
            if fault.level == "error":
                raise Refused(session.alarm(fault.number, doing, state))
        if time.monotonic() > end:
            place = str(session.address)
            raise Refused(rules.NOT_DONE(place=place, doing=doing, seconds=most, state=state))
        time.sleep(_OPERATION_POLL)


SCRATCH: Final = "ASSISTANT"
"""Program whose variables single statements use; no backup has it."""
_ENDING_TIMEOUT: Final = 5.0
"""Seconds in which a program must end, with and without a stop."""
_ENDING_POLL: Final = 0.05
"""Seconds between two looks whether it runs."""
_PRESENT: Final = "N"
"""Answer of FCHECK for a file that exists."""


@contextmanager
def scratch(session: Session, doing: str) -> Iterator[int]:
    """Open a program in the edit slot whose variables vanish afterwards; yields the slot.

    The joint override of the slot is reset to its initial value. A controller may create the file
    of a new program as soon as it is opened: it is deleted then.
    """
    with session.right(doing):
        before = _exists(session, SCRATCH)
        try:
            with programs.editing(session, SCRATCH, doing, session.under_way):
                slot = session.edit_slot
                try:
                    yield slot
                finally:
                    # The joint override outlives the statement: back to its initial value.
                    _quietly(session, "EXECJOVRD M_NJOVRD", slot)
        finally:
            if not before and session.connected:
                with suppress(Refused):
                    if _exists(session, SCRATCH):
                        programs.remove(session, SCRATCH)


def _exists(session: Session, name: str) -> bool:
    file = programs.file_name(session, name)
    answer = session.attempt(f"FCHECK{file}", doing=f"looking for `{name}`")
    return answer.ok and answer.text.strip().upper().startswith(_PRESENT)


def _quietly(session: Session, command: str, slot: int) -> None:
    """Send a command that tidies up; a refusal changes nothing and is ignored."""
    if session.connected:
        with suppress(Refused):
            session.attempt(command, doing="tidying up", slot=slot, shape=BARE_ANSWER)


@contextmanager
def borrowed(controller: object, names: Iterable[str]) -> Iterator[None]:
    """Put slots and programs back as they were, after an error as well; see `BorrowedState`.

    controller: a client; nothing is done for one without a controller link. A failure to put them
    back is raised only if there is no other error.
    """
    before = BorrowedState.of(controller, names)
    try:
        yield
    except BaseException:
        if before is not None:
            # The first error tells more than a failure to tidy up after it.
            with suppress(Refused):
                before.put_back()
        raise
    if before is not None:
        before.put_back()


class BorrowedState:
    """State of a controller before programs are borrowed.

    names: of the programs that are installed meanwhile. shared: external variables that they set;
    one without a value gets 0.
    """

    def __init__(self, session: Session, names: Iterable[str], shared: Iterable[str] = ()) -> None:
        self._session, self._names = session, tuple(names)
        self._slots: Mapping[int, str] = self._selected()
        there = set(programs.names(session))
        self._new = [name for name in self._names if name not in there]
        self._shared = dict.fromkeys(shared, "0")
        if self._shared:
            values = dict(line.split("=", 1) for line in external_variables(session))
            self._shared |= {name: values[name] for name in self._shared if name in values}

    @classmethod
    def of(
        cls, controller: object, names: Iterable[str], shared: Iterable[str] = ()
    ) -> BorrowedState | None:
        """Return the state of a controller; None for a client without a controller link."""
        session = getattr(controller, "session", None)
        return cls(session, names, shared) if isinstance(session, Session) else None

    def put_back(self) -> None:
        """End the borrowed programs and restore the state, over a new connection if it was lost.

        A slot that had no program keeps the borrowed one if the controller does not clear it.
        Raises Refused.
        """
        session = self._session
        with session.anew(), session.right("putting back what was borrowed"):
            for slot, now in self._selected().items():
                if now in self._names or now != self._slots[slot]:
                    self._end(slot)
                if now != self._slots[slot]:
                    self._select(slot, self._slots[slot])
            for name, value in self._shared.items():
                command, doing = f"EXEC2={name}={value}", f"setting {name} back"
                session.ask(command, doing=doing, slot=session.edit_slot, shape=BARE_ANSWER)
            # A slot that could not be cleared still has the
            # program open, which cannot be deleted then.
            selected_now = set(self._selected().values())
            for name in self._new:
                if name not in selected_now:
                    programs.remove(session, name)

    def _selected(self) -> dict[int, str]:
        slots = range(1, self._session.about.slots + 1)
        return {slot: selected_program(self._session, slot) for slot in slots}

    def _end(self, slot: int) -> None:
        """Wait for the program of a slot, stop it if it does not end, and reset it."""
        session, stopped = self._session, False
        end = time.monotonic() + _ENDING_TIMEOUT
        while slot_state(session, slot).running:
            if time.monotonic() > end:
                if stopped:
                    break
                session.ask("STOP", doing=f"stopping slot {slot}", slot=slot, shape=BARE_ANSWER)
                stopped, end = True, time.monotonic() + _ENDING_TIMEOUT
            time.sleep(_ENDING_POLL)
        if slot_state(session, slot).stop & WAITING:
            session.ask("RSTPRG", doing=f"resetting slot {slot}", slot=slot, shape=BARE_ANSWER)

    def _select(self, slot: int, name: str) -> None:
        session, doing = self._session, f"setting slot {slot} back"
        if name:
            session.ask(f"PRGLOAD={name}", doing=doing, slot=slot, shape=BARE_ANSWER)
        else:  # no command clears a slot, but a statement does
            _quietly(session, f"EXEC2=XCLR {slot}", session.edit_slot)
