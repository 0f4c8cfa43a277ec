"""State that a command needs on a controller for a while, and removes again.

`scratch` gives single statements separate variables: those of a program that is open in the edit
slot and never saved. `borrowed` surrounds the installing and running of programs: afterwards each
slot has its program again, external variables have their values, and new programs are deleted.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi import programs
from assistant.controllers.mitsubishi.answers import BARE_ANSWER
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.mitsubishi.state import WAITING, slot_state
from assistant.controllers.mitsubishi.variables import external_variables, selected_program

SCRATCH: Final = "ASSISTANT"
"""Program whose variables single statements use; no backup has it."""
ENDING_TIMEOUT: Final = 5.0
"""Seconds in which a program must end, with and without a stop."""
ENDING_POLL: Final = 0.05
"""Seconds between two looks whether it runs."""
PRESENT: Final = "N"
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
                    _quietly(session, "EXECJOVRD M_NJOVRD", slot)
        finally:
            if not before and session.connected:
                with suppress(Refused):
                    if _exists(session, SCRATCH):
                        programs.remove(session, SCRATCH)


def _exists(session: Session, name: str) -> bool:
    file = programs.file_name(session, name)
    answer = session.attempt(f"FCHECK{file}", doing=f"looking for `{name}`")
    return answer.ok and answer.text.strip().upper().startswith(PRESENT)


def _quietly(session: Session, command: str, slot: int) -> None:
    """Send a command that tidies up; a refusal changes nothing and is ignored."""
    if session.connected:
        with suppress(Refused):
            session.attempt(command, doing="tidying up", slot=slot, shape=BARE_ANSWER)


@contextmanager
def borrowed(controller: object, names: Iterable[str]) -> Iterator[None]:
    """Put slots and programs back as they were, after an error as well; see `Before`.

    controller: a client; nothing is done for one without a controller link. A failure to put them
    back is raised only if there is no other error.
    """
    before = BorrowedState.of(controller, names)
    try:
        yield
    except BaseException:
        if before is not None:
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
        end = time.monotonic() + ENDING_TIMEOUT
        while slot_state(session, slot).running:
            if time.monotonic() > end:
                if stopped:
                    break
                session.ask("STOP", doing=f"stopping slot {slot}", slot=slot, shape=BARE_ANSWER)
                stopped, end = True, time.monotonic() + ENDING_TIMEOUT
            time.sleep(ENDING_POLL)
        if slot_state(session, slot).stop & WAITING:
            session.ask("RSTPRG", doing=f"resetting slot {slot}", slot=slot, shape=BARE_ANSWER)

    def _select(self, slot: int, name: str) -> None:
        session, doing = self._session, f"setting slot {slot} back"
        if name:
            session.ask(f"PRGLOAD={name}", doing=doing, slot=slot, shape=BARE_ANSWER)
        else:  # no command clears a slot, but a statement does
            _quietly(session, f"EXEC2=XCLR {slot}", session.edit_slot)
