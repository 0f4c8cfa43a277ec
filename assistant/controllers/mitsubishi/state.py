"""The state of a CR controller: what STATE of each slot tells, the present error, who it is.

Bits of the fifth field of STATE (BFP-A4288): of the run, 01 repeat, 02 cycle stop off, 04 machine
lock, 08 teach, 20 servo on, 40 running, 80 operation right; of the stop, 01 emergency stop,
02 stop, 04 wait, 08 stop signal off, 10 program selectable, 40 pseudo input.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.answers import BARE_ANSWER
from assistant.controllers.mitsubishi.errors import cr_error
from assistant.controllers.mitsubishi.session import RUN_BITS, Session
from assistant.controllers.states import Fault, Identity, State, TaskState

TEACH, SERVO, RUNNING = 0x08, 0x20, 0x40
EMERGENCY, WAITING, SELECTABLE = 0x01, 0x04, 0x10
CAUTION: Final = "3"
"""Level of an error that stops nothing."""
SERIAL_PARAMETER: Final = "RCSERIAL"
"""Parameter of the controller's serial number, as parameter files of RT ToolBox have it."""


@dataclass(frozen=True, slots=True)
class SlotState:
    """A task slot. run, stop: bits; error: its number, 0 for none."""

    program: str
    line: int | None
    override: int | None
    run: int
    stop: int
    error: int

    @property
    def running(self) -> bool:
        return bool(self.run & RUNNING)


def slot_state(session: Session, number: int) -> SlotState:
    """What STATE tells of a slot."""
    doing = f"asking for the state of slot {number}"
    text = session.ask("STATE", doing=doing, slot=number).text
    fields = text.split(";")
    bits = RUN_BITS.fullmatch(fields[4]) if len(fields) > 4 else None
    if bits is None:
        session.garbled(doing, text)
    return SlotState(
        program=fields[0].partition(".")[0].strip(),
        line=_whole(fields[1]) or None,
        override=_whole(fields[2]),
        run=int(bits[1], 16),
        stop=int(bits[2], 16),
        error=int(bits[3] or 0),
    )


def run_bits(session: Session) -> tuple[int, int]:
    """Run and stop bits of slot 1, by the short DSTATE."""
    doing = "asking for the state"
    text = session.ask("DSTATE", doing=doing).text
    bits = RUN_BITS.fullmatch(text)
    if bits is None:
        session.garbled(doing, text)
    return int(bits[1], 16), int(bits[2], 16)


def running(session: Session) -> bool:
    """Whether a program runs in any slot."""
    session.running = any(
        slot_state(session, slot).running for slot in range(1, session.about.slots + 1)
    )
    return session.running


def controller_state(session: Session, slots: Iterable[int] | None = None) -> State:
    """The state with the programs of these slots, of all of them if not stated; slot 1 is one."""
    first = slot_state(session, 1)
    others = range(2, session.about.slots + 1) if slots is None else sorted(set(slots) - {1})
    told = {1: first, **{number: slot_state(session, number) for number in others}}
    session.running = any(slot.running for slot in told.values())
    return State(
        mode="manual" if first.run & TEACH else "automatic",
        motors=bool(first.run & SERVO),
        running=session.running,
        emergency=bool(first.stop & EMERGENCY),
        right=session.has_right,
        override=first.override,
        tasks=tuple(
            TaskState(str(number), slot.program, slot.line, slot.running)
            for number, slot in told.items()
            if slot.program or slot.running
        ),
        faults=faults(session),
    )


def faults(session: Session) -> tuple[Fault, ...]:
    """The present error; ERROR tells one."""
    doing = "asking for the error"
    text = session.ask("ERROR", doing=doing).text.strip()
    number, _, level = text.partition(";")
    if not number:
        return ()
    if not number.isdecimal():
        session.garbled(doing, text)
    return () if not int(number) else (fault(int(number), level.strip()),)


def fault(number: int, level: str = "", text: str = "") -> Fault:
    """An error by its number; level: 1 high, 2 low, 3 caution, as the controller tells it."""
    known = cr_error(number)
    mild = level == CAUTION or (not level and known.level == "C")
    kind: Literal["error", "warning"] = "warning" if mild else "error"
    return Fault(number, text or known.text, kind, known.cure)


def reset(session: Session) -> None:
    """Acknowledges the error; raises Refused if it is still there then."""
    doing = "resetting the error"
    session.ask("RSTALRM", doing=doing, shape=BARE_ANSWER)
    for left in faults(session):
        if left.level == "error":
            raise Refused(session.alarm(left.number, doing, "the error is still there"))


def identify(session: Session) -> Identity:
    """Robot, controller and version; the serial number where the controller has one to tell."""
    about = session.about
    told = session.attempt(f"PNR{SERIAL_PARAMETER}", doing="asking for the serial number")
    fields = told.text.split(";")
    serial = (
        fields[1].strip(' "')
        if told.ok and fields[0] == SERIAL_PARAMETER and len(fields) > 1
        else ""
    )
    return Identity(about.robot, about.controller, about.version, serial)


def _whole(text: str) -> int | None:
    return int(text) if text.strip().isdecimal() else None
