"""State that a command needs on a controller for a while, and takes away again.

`scratch` gives single statements variables of their own: those of a program that is open in the
edit slot and never saved. `borrowed` installs and runs programs, and afterwards each slot has the
program that it had, external variables have their values, and what was not there is deleted.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Final

from assistant.controllers.mitsubishi import programs
from assistant.controllers.mitsubishi.answers import BARE
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.mitsubishi.state import WAITING, slot_state
from assistant.controllers.mitsubishi.variables import externals, selected
from assistant.program.diagnostics import Refused

SCRATCH: Final = "ASSISTANT"
"""Program whose variables single statements use; no backup has it."""
ENDING: Final = 5.0
"""Seconds in which a program that was told to end does."""
LOOK: Final = 0.05
"""Seconds between two looks at it."""
PRESENT: Final = "N"
"""Answer of FCHECK for a file that exists."""


@contextmanager
def scratch(session: Session, doing: str) -> Iterator[int]:
    """The edit slot, with a program open whose variables vanish afterwards.

    The joint override of the slot becomes the usual one again. Some controllers may create a file
    as soon as a program of a new name is opened: it is deleted then.
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
    told = session.attempt(f"FCHECK{file}", doing=f"looking for `{name}`")
    return told.ok and told.text.strip().upper().startswith(PRESENT)


def _quietly(session: Session, command: str, slot: int) -> None:
    """Sends what tidies up; a controller that refuses it is as it was."""
    if session.connected:
        with suppress(Refused):
            session.attempt(command, doing="tidying up", slot=slot, shape=BARE)


@contextmanager
def borrowed(controller: object, names: Iterable[str]) -> Iterator[None]:
    """Puts slots and programs back as they were; see `Before`.

    controller: a client. What fails meanwhile is only raised where nothing else went wrong.
    """
    before = Before.of(controller, names)
    try:
        yield
    except BaseException:
        if before is not None:
            with suppress(Refused):
                before.put_back()
        raise
    if before is not None:
        before.put_back()


class Before:
    """What a controller held before programs were borrowed.

    names: of the programs that are installed meanwhile. shared: external variables that they set;
    one that had no value gets 0.
    """

    def __init__(self, session: Session, names: Iterable[str], shared: Iterable[str] = ()) -> None:
        self._session, self._names = session, tuple(names)
        self._slots: Mapping[int, str] = self._selected()
        there = set(programs.names(session))
        self._new = [name for name in self._names if name not in there]
        self._shared = dict.fromkeys(shared, "0")
        if self._shared:
            told = dict(line.split("=", 1) for line in externals(session))
            self._shared |= {name: told[name] for name in self._shared if name in told}

    @classmethod
    def of(
        cls, controller: object, names: Iterable[str], shared: Iterable[str] = ()
    ) -> Before | None:
        """None for what is no client of the controller link."""
        session = getattr(controller, "session", None)
        return cls(session, names, shared) if isinstance(session, Session) else None

    def put_back(self) -> None:
        """Ends the programs that were borrowed, over a new connection if there is none any more.

        A slot that had no program keeps the borrowed one where the controller does not clear it.
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
                session.ask(command, doing=doing, slot=session.edit_slot, shape=BARE)
            selected_now = set(self._selected().values())
            for name in self._new:
                if name not in selected_now:
                    programs.remove(session, name)

    def _selected(self) -> dict[int, str]:
        slots = range(1, self._session.about.slots + 1)
        return {slot: selected(self._session, slot) for slot in slots}

    def _end(self, slot: int) -> None:
        """Waits for the program of a slot, stops it if it does not end, and resets it."""
        session, stopped = self._session, False
        end = time.monotonic() + ENDING
        while slot_state(session, slot).running:
            if time.monotonic() > end:
                if stopped:
                    break
                session.ask("STOP", doing=f"stopping slot {slot}", slot=slot, shape=BARE)
                stopped, end = True, time.monotonic() + ENDING
            time.sleep(LOOK)
        if slot_state(session, slot).stop & WAITING:
            session.ask("RSTPRG", doing=f"resetting slot {slot}", slot=slot, shape=BARE)

    def _select(self, slot: int, name: str) -> None:
        session, doing = self._session, f"setting slot {slot} back"
        if name:
            session.ask(f"PRGLOAD={name}", doing=doing, slot=slot, shape=BARE)
        else:  # no command clears a slot, but a statement does
            _quietly(session, f"EXEC2=XCLR {slot}", session.edit_slot)
