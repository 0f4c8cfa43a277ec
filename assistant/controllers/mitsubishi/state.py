"""State of a CR controller: slots, errors, identity, and the position of the arm.

STATE of a slot, fifth field (BFP-A4288), run bits: 01 repeat, 02 cycle stop off, 04 machine lock,
08 teach, 20 servo on, 40 running, 80 operation right; stop bits: 01 emergency stop, 02 stop,
04 wait, 08 stop signal off, 10 program selectable, 40 pseudo input.
JPOSF and PPOSF answer `name;value;…;;FL1,FL2;override;speed;limits`: values with two decimals,
`****` for an axis that the arm lacks. A, B and C are the angles of Rz(C)·Ry(B)·Rx(A); an arm of
five axes shows A and B only, those of Rz(J1)·Ry(B)·Rz(J6).
The error history has `date;time;no;text;level;prog;line;detail` for each entry.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Final, Literal

from assistant.base import rotations
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.link import BARE_ANSWER
from assistant.controllers.mitsubishi.programs import time_of
from assistant.controllers.mitsubishi.session import RUN_BITS, Session, cr_error
from assistant.controllers.states import Fault, Identity, Position, State, TaskState

_TEACH, SERVO, RUNNING = 0x08, 0x20, 0x40
_EMERGENCY, WAITING, _SELECTABLE = 0x01, 0x04, 0x10
_CAUTION: Final = "3"
"""Level of an error that stops nothing."""
_SERIAL_PARAMETER: Final = "RCSERIAL"
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
    """Return the state of a slot, read by STATE."""
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
    """True if a program runs in any slot."""
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
        mode="manual" if first.run & _TEACH else "automatic",
        motors=bool(first.run & SERVO),
        running=session.running,
        emergency=bool(first.stop & _EMERGENCY),
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
    # The controller's own level comes first; the table helps where it tells none.
    mild = level == _CAUTION or (not level and known.level == "C")
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
    told = session.attempt(f"PNR{_SERIAL_PARAMETER}", doing="asking for the serial number")
    fields = told.text.split(";")
    serial = (
        fields[1].strip(' "')
        if told.ok and fields[0] == _SERIAL_PARAMETER and len(fields) > 1
        else ""
    )
    return Identity(about.robot, about.controller, about.version, serial)


def _whole(text: str) -> int | None:
    return int(text) if text.strip().isdecimal() else None


_LOG_LEVELS: Final = {"H": "1", "L": "2", "C": "3"}
_MOST_LOG_ENTRIES: Final = 2000
"""Entries after which an endless history counts as a fault."""


def error_history(session: Session, most: int) -> tuple[Fault, ...]:
    """The latest errors, the newest first; all are read, as manuals tell no order of theirs."""
    doing = "reading the error history"
    found: list[Fault] = []
    text = session.ask("ERRORLOGTOP", doing=doing).text
    while text.strip("; ") and len(found) < _MOST_LOG_ENTRIES:
        fields = text.split(";")
        if len(fields) < 5 or not re.fullmatch(r"\d{1,5}", fields[2].strip()):
            session.garbled(doing, text)
        found.append(_log_entry(fields))
        text = session.ask("ERRORLOG+1", doing=doing).text
    newest = sorted(found, key=lambda entry: entry.time or datetime.min, reverse=True)
    return tuple(newest[:most])


def _log_entry(fields: list[str]) -> Fault:
    date, clock, number, text, level, *rest = (field.strip() for field in fields)
    words = "".join(letter for letter in text if letter.isprintable())
    if rest and rest[0]:
        line = f", line {rest[1]}" if len(rest) > 1 and rest[1].strip("0") else ""
        words += f" (`{rest[0]}`{line})"
    told = fault(int(number), _LOG_LEVELS.get(level.upper(), level), words)
    return replace(told, time=time_of(f"{date}{clock}"))


_NO_AXIS: Final = re.compile(r"\*+|")
_AXIS_VALUE: Final = re.compile(r"[+-]?\d{1,12}(?:\.\d{0,12})?", re.ASCII)
_POSE_AXES: Final = ("X", "Y", "Z", "A", "B", "C")
_ADDITIONAL_AXES: Final = ("L1", "L2")


@dataclass(frozen=True, slots=True)
class Shown:
    """values: by the name of the axis, None for one that the arm lacks. flags: as they are."""

    values: Mapping[str, float | None]
    flags: str
    alarmed: bool = False

    def value(self, name: str) -> float:
        """0 for an axis that is not there."""
        return self.values.get(name) or 0.0


def _parse_shown(session: Session, command: str) -> Shown:
    """Parse the answer to JPOSF, PPOSF and the like."""
    doing = "asking where the arm is"
    answer = session.ask(command, doing=doing)
    # Two semicolons part the axes from the flags.
    axes, separator, rest = answer.text.partition(";;")
    fields = axes.split(";")
    names, values = fields[::2], fields[1::2]
    good = all(_AXIS_VALUE.fullmatch(v) or _NO_AXIS.fullmatch(v) for v in values)
    if not separator or not len(set(names)) == len(names) == len(values) or not good:
        session.garbled(doing, answer.text)
    read = {
        n: float(v) if _AXIS_VALUE.fullmatch(v) else None
        for n, v in zip(names, values, strict=True)
    }
    return Shown(read, rest.split(";")[0].strip(), answer.alarmed)


def joints(session: Session) -> Shown:
    """Degrees, mm of linear axes."""
    told = _parse_shown(session, "JPOSF")
    if not all(re.fullmatch(r"J[1-8]", name) for name in told.values):
        session.garbled("asking for the joints", repr(dict(told.values)))
    return told


def pose(session: Session) -> Shown:
    """X, Y, Z in mm, A, B, C in degrees."""
    told = _parse_shown(session, "PPOSF")
    if any(told.values.get(name) is None for name in "XYZ"):
        session.garbled("asking for the pose", repr(dict(told.values)))
    return told


def position(session: Session) -> Position:
    """Joints and pose, of two answers: of an arm that moves they are not of the same moment."""
    axes, place = joints(session), pose(session)
    # An axis may be missing between others: the columns stay aligned.
    last = max((int(name[1:]) for name in axes.values), default=0)  # one may be left out between
    return Position(
        joints=tuple(axes.values.get(f"J{n}") for n in range(1, last + 1)),
        position=(place.value("X"), place.value("Y"), place.value("Z")),
        quaternion=orientation(axes, place),
        text=pose_text(place),
    )


def orientation(axes: Shown, place: Shown) -> tuple[float, float, float, float]:
    """The quaternion (w, x, y, z) of a pose, for an arm of five axes with the help of joints."""
    if _has_five_axes(axes, place):
        turns = (("Z", axes.value("J1")), ("Y", place.value("B")), ("Z", axes.value("J6")))
        one, two, three = (rotations.about(rotations.AXES[axis], by) for axis, by in turns)
        quaternion = rotations.multiply(rotations.multiply(one, two), three)
    else:
        quaternion = rotations.from_euler([place.value(name) for name in ("C", "B", "A")])
    w, x, y, z = (float(part) for part in rotations.canonical(quaternion).reshape(4))
    return w, x, y, z


def turn_of(
    joints: Sequence[float], place: Sequence[float], *, five_axes: bool
) -> tuple[float, float, float, float]:
    """Return the quaternion of a record of numbers. joints: J1, J2 …; place: X, Y, Z, A, B, C …

    five_axes: for an arm without J4, whatever value its column has.
    """
    told: dict[str, float | None] = {f"J{i}": joint for i, joint in enumerate(joints, 1)}
    shown: dict[str, float | None] = dict(zip(_POSE_AXES, place, strict=False))
    if five_axes:
        told["J4"] = shown["C"] = None
    return orientation(Shown(told, ""), Shown(shown, ""))


def _has_five_axes(axes: Shown, place: Shown) -> bool:
    """True if A and B alone define the orientation: no J4, and no C."""
    return axes.values.get("J4") is None and place.values.get("C") is None and "B" in place.values


def pose_text(place: Shown, values: Mapping[str, float] | None = None) -> str:
    """The pose as MELFA-BASIC writes it, with some other values."""
    named = dict(place.values) | dict(values or {})
    names = [*_POSE_AXES, *(name for name in _ADDITIONAL_AXES if named.get(name) is not None)]
    body = ",".join(f"{named.get(name) or 0.0:.2f}" for name in names)
    flags = place.flags if re.fullmatch(r"\d+,\d+", place.flags) else "0,0"
    return f"({body})({flags})"
