"""Where the arm of a CR controller is: what JPOSF and PPOSF tell.

`name;value;…;;FL1,FL2;override;speed;limits` (BFP-A4288): values with two decimals, `****` of an
axis that the arm lacks. A, B and C are the angles of Rz(C)·Ry(B)·Rx(A); an arm of five axes shows
A and B only, which are those of Rz(J1)·Ry(B)·Rz(J6).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from assistant.base import rotations
from assistant.controllers.mitsubishi.session import Session
from assistant.controllers.states import Position

NO_AXIS: Final = re.compile(r"\*+|")
AXIS_VALUE: Final = re.compile(r"[+-]?\d{1,12}(?:\.\d{0,12})?", re.ASCII)
POSE_AXES: Final = ("X", "Y", "Z", "A", "B", "C")
ADDITIONAL_AXES: Final = ("L1", "L2")


@dataclass(frozen=True, slots=True)
class Shown:
    """values: by the name of the axis, None for one that the arm lacks. flags: as they are."""

    values: Mapping[str, float | None]
    flags: str
    alarmed: bool = False

    def value(self, name: str) -> float:
        """0 for an axis that is not there."""
        return self.values.get(name) or 0.0


def parse_shown(session: Session, command: str) -> Shown:
    """What JPOSF, PPOSF and their like tell."""
    doing = "asking where the arm is"
    answer = session.ask(command, doing=doing)
    axes, separator, rest = answer.text.partition(";;")
    fields = axes.split(";")
    names, values = fields[::2], fields[1::2]
    good = all(AXIS_VALUE.fullmatch(v) or NO_AXIS.fullmatch(v) for v in values)
    if not separator or not len(set(names)) == len(names) == len(values) or not good:
        session.garbled(doing, answer.text)
    read = {
        n: float(v) if AXIS_VALUE.fullmatch(v) else None for n, v in zip(names, values, strict=True)
    }
    return Shown(read, rest.split(";")[0].strip(), answer.alarmed)


def joints(session: Session) -> Shown:
    """Degrees, mm of linear axes."""
    told = parse_shown(session, "JPOSF")
    if not all(re.fullmatch(r"J[1-8]", name) for name in told.values):
        session.garbled("asking for the joints", repr(dict(told.values)))
    return told


def pose(session: Session) -> Shown:
    """X, Y, Z in mm, A, B, C in degrees."""
    told = parse_shown(session, "PPOSF")
    if any(told.values.get(name) is None for name in "XYZ"):
        session.garbled("asking for the pose", repr(dict(told.values)))
    return told


def position(session: Session) -> Position:
    """Joints and pose, of two answers: of an arm that moves they are not of the same moment."""
    axes, place = joints(session), pose(session)
    last = max((int(name[1:]) for name in axes.values), default=0)  # one may be left out between
    return Position(
        joints=tuple(axes.values.get(f"J{n}") for n in range(1, last + 1)),
        position=(place.value("X"), place.value("Y"), place.value("Z")),
        quaternion=orientation(axes, place),
        text=pose_text(place),
    )


def orientation(axes: Shown, place: Shown) -> tuple[float, float, float, float]:
    """The quaternion (w, x, y, z) of a pose, for an arm of five axes with the help of joints."""
    if has_five_axes(axes, place):
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
    """The quaternion of a record of numbers. joints: J1, J2 …; place: X, Y, Z, A, B, C …

    five_axes: of an arm without J4, whatever stands in its place.
    """
    told: dict[str, float | None] = {f"J{i}": joint for i, joint in enumerate(joints, 1)}
    shown: dict[str, float | None] = dict(zip(POSE_AXES, place, strict=False))
    if five_axes:
        told["J4"] = shown["C"] = None
    return orientation(Shown(told, ""), Shown(shown, ""))


def has_five_axes(axes: Shown, place: Shown) -> bool:
    """Whether the orientation is told by A and B alone: no J4, and no C."""
    return axes.values.get("J4") is None and place.values.get("C") is None and "B" in place.values


def pose_text(place: Shown, values: Mapping[str, float] | None = None) -> str:
    """The pose as MELFA-BASIC writes it, with some other values."""
    named = dict(place.values) | dict(values or {})
    names = [*POSE_AXES, *(name for name in ADDITIONAL_AXES if named.get(name) is not None)]
    body = ",".join(f"{named.get(name) or 0.0:.2f}" for name in names)
    flags = place.flags if re.fullmatch(r"\d+,\d+", place.flags) else "0,0"
    return f"({body})({flags})"
