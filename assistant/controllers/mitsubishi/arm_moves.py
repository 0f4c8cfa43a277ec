"""Moves of the arm of a CR controller to a target computed here: jogs, and single statements.

JOG of the link moves for as long as it is repeated. Here the target is computed from where the arm
stands, put into a variable and moved to by Mov: whatever becomes of the line, the arm goes there at
most. Mov interpolates the joints. The variable belongs to a program of the edit slot that is never
saved, so nothing of it stays (`operation.scratch`).
The statements of single moves may set posture flags: the text after the numbers of a position, with
its closing bracket.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Final

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abilities import Held
from assistant.controllers.mitsubishi import operation, state, values
from assistant.controllers.mitsubishi.link import BARE_ANSWER
from assistant.controllers.mitsubishi.operation import scratch
from assistant.controllers.mitsubishi.session import UNCHANGED, Session
from assistant.controllers.mitsubishi.state import SERVO, Shown, faults, run_bits, running
from assistant.controllers.states import Jog

_LIMITS: Final = "MEJAR"
"""Parameter of the least and the most of each joint, degrees (mm of a linear axis)."""
_LEAST_STEP: Final = 0.01
_MOST_STEP: Final = 100.0
"""Degrees or mm of one jog; places are written with two decimals."""
_LEAST_SPEED: Final = 1.0
"""Percent: what the joint override of a program is given at least."""
LOOK: Final = 0.05
"""Seconds between two looks at the arm."""
_STILL: Final = 40
"""Looks at an arm that does not move, after which it does not arrive any more."""
NEAR: Final = 0.06
"""mm and degrees that the arm may be off: places are shown with two decimals."""
_MOST_SECONDS: Final = 120.0
_SERVOS_OFF, _DURING_RUN = 2000, 5640
_OUT_OF_REACH: Final = frozenset({2600, 2601, 2602, 2603, 2800, 2801, 2802, 2803})
"""Errors of goals that are out of reach or of the limits."""
_JOINT_VARIABLE, _POSE_VARIABLE = "JGOAL", "PGOAL"
_ROTATION_AXES: Final = {"A": "X", "B": "Y", "C": "Z"}


@dataclass(frozen=True, slots=True)
class Goal:
    """Goal of a jog: joints by their names, or values of the pose by theirs.

    All in degrees, mm for X, Y, Z and linear axes.
    """

    joints: Mapping[str, float] | None = None
    pose: Mapping[str, float] | None = None


Check = Callable[[Goal], None]
"""Raises Refused for a goal that the arm must not be sent to."""


def _always_held() -> bool:
    """Default for motions that need no hold by the user."""
    return True


def jog(session: Session, asked: Jog, check: Check | None, held: Held = _always_held) -> None:
    """Move, and return when the arm has stopped at the goal; stop it on any failure.

    check: called before anything moves; the joint limits of the controller are checked too. held:
    called repeatedly during the motion: False stops the motion and raises Refused.
    """
    axis = asked.axis.upper()
    _sensible(asked, axis)
    doing = f"jogging {axis} by {asked.by:g}"
    with session.right(doing):
        _may_move(session, doing)
        axes = state.joints(session)
        if axis.startswith("J"):
            goal = Goal(joints=_joints(session, asked, axis, axes))
            name, value = _JOINT_VARIABLE, _joint_text(axes, goal)
        else:
            place = state.pose(session)
            goal = Goal(pose=_pose(session, asked, axis, axes, place))
            name, value = _POSE_VARIABLE, state.pose_text(place, goal.pose)
        if check is not None:
            check(goal)
        _go(session, asked.speed, name, value, goal, doing, held)


def execute_while(session: Session, statement: str, goal: Goal, held: Held, slot: int) -> None:
    """Move the arm to a goal by a statement, and return when it has stopped there.

    For lines with room for one connection: the line stays free for the stop, which goes out once
    the motion is not held.
    """
    doing = f"executing `{statement[:40]}`"
    with session.right(doing):
        if goal.pose is not None:  # an arm of five axes shows no turn about its third
            shown = state.pose(session).values
            goal = Goal(pose={n: v for n, v in goal.pose.items() if shown.get(n) is not None})
        # From here on the arm may move: any exception, also Ctrl-C, has to stop it.
        with _stopping(session):
            operation.execute(session, statement, wait_for_end=False, slot=slot)
            _arrive(session, goal, doing, held)


def jog_joints(
    session: Session, joints: Mapping[str, float], speed: float, check: Check | None
) -> None:
    """Moves several joints at once, each by no more than one jog may; else as `jog`.

    joints: J1 … with the degrees (mm) to go to; the others stay.
    """
    doing = f"jogging {', '.join(joints)}"
    with session.right(doing):
        _may_move(session, doing)
        axes = state.joints(session)
        there = {name: value for name, value in axes.values.items() if value is not None}
        if unknown := set(joints) - set(there):
            raise values.bad_value(min(unknown), "an axis", "the arm lacks it", ", ".join(there))
        for axis, value in joints.items():
            if not abs(value - there[axis]) <= _MOST_STEP:
                reason = f"one jog goes {_MOST_STEP:g} mm or degrees at most"
                raise values.bad_value(value, f"a place of {axis}", reason, "one that is nearer")
        _within(session, joints, list(there))
        _sensible_speed(speed)
        goal = Goal(joints=there | dict(joints))
        if check is not None:
            check(goal)
        _go(session, speed, _JOINT_VARIABLE, _joint_text(axes, goal), goal, doing)


def _go(
    session: Session,
    speed: float,
    name: str,
    value: str,
    goal: Goal,
    doing: str,
    held: Held = _always_held,
) -> None:
    """Set a variable to a value, move to it, and return when the arm has stopped there."""
    # The scratch variables last until the arm stands: Mov reads them from the edit slot.
    with _acknowledged(session), scratch(session, doing) as slot:
        session.ask(f"EXECJOVRD {speed:g}", doing=doing, slot=slot, shape=BARE_ANSWER)
        session.ask(f"EXEC{name}={value}", doing=doing, slot=slot, shape=BARE_ANSWER)
        if not held():
            raise _not_there(session, doing, 0.0, "nothing has moved")
        with _stopping(session):
            state = "the arm may have begun to move"
            session.ask(f"EXECMOV {name}", doing=doing, state=state, slot=slot, shape=BARE_ANSWER)
            _arrive(session, goal, doing, held)


def _sensible(asked: Jog, axis: str) -> None:
    if not re.fullmatch(r"J[1-8]|[XYZABC]", axis):
        raise values.bad_value(
            asked.axis, "an axis", "there is none of that name", "J1 … J8, X … C"
        )
    if asked.frame not in ("base", "tool"):
        raise values.bad_value(asked.frame, "a frame", "there is none of that name", "base or tool")
    if not math.isfinite(asked.by) or not _LEAST_STEP <= abs(asked.by) <= _MOST_STEP:
        reason = f"one jog goes {_LEAST_STEP:g} to {_MOST_STEP:g} mm or degrees"
        raise values.bad_value(asked.by, "a step", reason, "one of that size")
    _sensible_speed(asked.speed)


def _sensible_speed(speed: float) -> None:
    if not _LEAST_SPEED <= speed <= operation.MOST_PERCENT:
        raise values.bad_value(speed, "a speed", "it is a percentage", "1 to 100")


def _may_move(session: Session, doing: str) -> None:
    """Raises Refused while a program runs, during an error, and with servos that are off."""
    numbers = [fault.number for fault in faults(session) if fault.level == "error"]
    if not numbers and running(session):
        numbers = [_DURING_RUN]
    if not numbers and not run_bits(session)[0] & SERVO:
        numbers = [_SERVOS_OFF]
    if numbers:
        raise Refused(session.alarm(numbers[0], doing))


def _joints(session: Session, asked: Jog, axis: str, axes: Shown) -> dict[str, float]:
    """All joints that there are, one of them further; raises Refused beyond its limits."""
    there = {name: value for name, value in axes.values.items() if value is not None}
    if axis not in there:
        raise values.bad_value(axis, "an axis", "the arm lacks it", ", ".join(there))
    target = there | {axis: there[axis] + asked.by}
    _within(session, {axis: target[axis]}, list(there))
    return target


def _within(session: Session, joints: Mapping[str, float], there: list[str]) -> None:
    """Raises Refused for places of joints beyond their limits."""
    limits = _limits(session, there)
    for axis, value in joints.items():
        least, most = limits.get(axis, (-math.inf, math.inf))
        if not least <= value <= most:
            raise Refused(
                rules.OUT_OF_LIMITS(place=axis, axis=axis, value=value, least=least, most=most)
            )


def _limits(session: Session, there: list[str]) -> dict[str, tuple[float, float]]:
    """The least and the most of each joint that the controller tells them of.

    It tells pairs, of the axes that there are or of J1 to J8.
    """
    told = session.attempt(f"PNR{_LIMITS}", doing="asking for the limits of the joints")
    fields = told.text.split(";")
    numbers = re.findall(values.NUMBER_PATTERN, fields[1]) if told.ok and len(fields) > 1 else []
    # One iterator twice: zip takes the numbers in pairs.
    pairs = list(zip(*[iter(map(float, numbers))] * 2, strict=False))
    names = there if len(pairs) == len(there) else [f"J{n}" for n in range(1, len(pairs) + 1)]
    known = dict(zip(names, pairs, strict=True)) if len(pairs) >= len(there) else {}
    return {name: (least, most) for name, (least, most) in known.items() if least < most}


def _joint_text(axes: Shown, goal: Goal) -> str:
    """Return joints in MELFA-BASIC notation: six, 0 for a missing one, and additional axes."""
    target = goal.joints or {}
    names = [f"J{n}" for n in range(1, 9) if n <= 6 or f"J{n}" in axes.values]
    return f"({','.join(f'{target.get(name, 0.0):.2f}' for name in names)})"


def _pose(session: Session, asked: Jog, axis: str, axes: Shown, place: Shown) -> dict[str, float]:
    """The values of the pose that the arm shows, further along or about an axis."""
    here = {name: value for name, value in place.values.items() if value is not None}
    in_tool = asked.frame == "tool"
    turn = state.orientation(axes, place)
    if axis in rotations.AXES:
        step = [asked.by * part for part in rotations.AXES[axis]]
        # Along the tool's axes the step is turned into the base first.
        moved = rotations.rotate(turn, step) if in_tool else step
        return here | {n: here[n] + float(by) for n, by in zip("XYZ", moved, strict=True)}
    if axis not in here:
        raise values.bad_value(axis, "an axis", "the arm cannot turn about it", ", ".join(here))
    if len({"A", "B", "C"} & set(here)) < 3:
        if in_tool:
            raise Refused(
                rules.NOT_HERE(
                    place=str(session.address),
                    address=session.address,
                    what="turn about an axis of the tool",
                    reason="the arm has fewer than six axes",
                    cure="jog its joints",
                )
            )
        # An arm with fewer axes has no free orientation: its angles can only be changed singly.
        return here | {axis: here[axis] + asked.by}
    by = rotations.about(rotations.AXES[_ROTATION_AXES[axis]], asked.by)
    # A turn about the tool's axis multiplies from the right, about the base's from the left.
    new = rotations.multiply(turn, by) if in_tool else rotations.multiply(by, turn)
    c, b, a = (float(angle) for angle in rotations.to_euler(new))
    return here | {"A": a, "B": b, "C": c}


class _Alarmed(Refused):
    """A motion that an error of the controller ended."""


@contextmanager
def _acknowledged(session: Session) -> Iterator[None]:
    """Acknowledge the controller's error of a goal that is out of reach: the refusal reports it.

    Any other error stays on the controller until the operator has seen it.
    """
    try:
        yield
    except _Alarmed:
        if session.connected:
            with suppress(Refused):
                if {fault.number for fault in faults(session)} <= _OUT_OF_REACH:
                    session.ask("RSTALRM", doing="acknowledging the error", shape=BARE_ANSWER)
        raise


@contextmanager
def _stopping(session: Session) -> Iterator[None]:
    """A motion that is stopped if it does not come to its own end."""
    session.under_way = "the arm may have moved"
    try:
        yield
    except BaseException as caught:
        operation.halt(session, caught)
        raise
    finally:
        session.under_way = UNCHANGED


def _not_there(session: Session, doing: str, seconds: float, state: str) -> Refused:
    place = str(session.address)
    return Refused(rules.NOT_DONE(place=place, doing=doing, seconds=round(seconds, 1), state=state))


def _arrive(session: Session, goal: Goal, doing: str, held: Held) -> None:
    """Comes back when the arm stands at the goal; raises Refused for errors and if it does not."""
    end = time.monotonic() + _MOST_SECONDS
    began = time.monotonic()
    before: list[float] = []
    still = 0
    while True:
        off = _off(session, goal)
        # Two equal looks: near the goal the arm may still move.
        if off == before and max(off) <= NEAR:
            return
        if not held():
            state = "it was let go, and the arm has been stopped"
            raise _not_there(session, doing, time.monotonic() - began, state)
        for fault in faults(session):
            if fault.level == "error":
                raise _Alarmed(session.alarm(fault.number, doing, "the arm has been stopped"))
        # An arm that stands far from its goal has given up without an error.
        still = still + 1 if off == before else 0
        before = off
        if still >= _STILL or time.monotonic() > end:
            state = "the arm does not get to its goal and has been stopped"
            raise _not_there(session, doing, time.monotonic() - began, state)
        time.sleep(LOOK)


def _off(session: Session, goal: Goal) -> list[float]:
    """Return the distance of each axis from the goal; for angles of a pose the shorter way
    round.
    """
    if goal.joints is not None:
        now = state.joints(session)
        return [abs(now.value(name) - value) for name, value in goal.joints.items()]
    here, target = state.pose(session), goal.pose or {}
    lengths = [abs(here.value(n) - v) for n, v in target.items() if n not in _ROTATION_AXES]
    angles = {name: value for name, value in target.items() if name in _ROTATION_AXES}
    if len(angles) == 3:
        # A, B and C of the same turn may differ: the angle between the turns counts.
        turns = [rotations.from_euler([m["C"], m["B"], m["A"]]) for m in (_angles(here), angles)]
        return [*lengths, float(rotations.angle_between(*turns))]
    return [
        *lengths,
        # 179 and -179 degrees are 2 degrees apart.
        *(abs((here.value(n) - v + 180.0) % 360.0 - 180.0) for n, v in angles.items()),
    ]


def _angles(place: Shown) -> dict[str, float]:
    return {name: place.value(name) for name in _ROTATION_AXES}


def joints_statement(joints: Floats) -> list[str]:
    """By the joints. joints: (6,) in degrees."""
    return [f"J99={_bracket(joints)}", "MOV J99"]


def pose_statement(pose: Floats, posture: str) -> list[str]:
    """By the joints. pose: (6,) X, Y, Z in mm, A, B, C in degrees."""
    return [_position("P99", pose, posture), "MOV P99"]


def line_to_joints_statement(joints: Floats) -> list[str]:
    """On a line to where joints bring the tool."""
    return [f"J99={_bracket(joints)}", "P99=JTOP(J99)", "MVS P99"]


def line_to_pose_statement(pose: Floats, posture: str) -> list[str]:
    """On a line."""
    return [_position("P99", pose, posture), "MVS P99"]


def arc_statement(via: Floats, pose: Floats, posture: str) -> list[str]:
    """From where the arm is, by way of a pose to another one."""
    first, last = _position("P98", via, posture), _position("P99", pose, posture)
    return ["P97=P_CURR", first, last, "MVR P97,P98,P99"]


def _position(name: str, pose: Floats, posture: str) -> str:
    return f"{name}={_bracket(pose)}({posture}"


def _bracket(values: Floats) -> str:
    return f"({','.join(f'{value:.2f}' for value in values)})"
