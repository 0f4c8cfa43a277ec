"""Statements that act on the arm beside its moves: frames, servo, hands, turns, softness."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import expressions, poses
from assistant.virtual.melfa.arm import Arm
from assistant.virtual.melfa.options import Frame
from assistant.virtual.melfa.stops import Failed, Unknown, open_point, out_of_range
from assistant.virtual.melfa.values import ORIGIN, Position, eight, position, whole

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine

# ------------------------------------------------------------------------------------ frames


def _set_tool_statement(m: Machine, node: s.Expression) -> None:
    """Holds at once, also for P_Curr."""
    found = expressions.value(m, node)
    if isinstance(found, bool | int | float):
        choose_tool(m, whole(found))
    else:
        _set_tool(m.world.arm, position(found, "a tool"), None)


def choose_tool(m: Machine, number: int) -> None:
    """A tool by its number, as the parameters MEXTL1 and so on give it."""
    kept = _parameter_position(m, f"MEXTL{number}")
    _set_tool(m.world.arm, kept or _numbered_frame(m.world.options.tools, number, "tool"), number)


def _parameter_position(m: Machine, parameter: str) -> Position | None:
    """The value of a parameter that a program's list of positions holds for its cell.

    As a position whose name is that of the parameter behind a P.
    """
    place = m.main.places.get(f"P{parameter}")
    value = place.get() if place is not None and place.is_set() else None
    return value if isinstance(value, Position) else None


def _set_tool(arm: Arm, tool: Position, number: int | None) -> None:
    arm.tool, arm.tip, arm.tool_number = tool, poses.pose_of(tool), number


def _set_base(m: Machine, node: s.Expression) -> None:
    """The robot's base seen from where positions are counted."""
    arm, found, number = m.world.arm, expressions.value(m, node), None
    if isinstance(found, bool | int | float):
        number = whole(found)
        kept = _parameter_position(m, f"WK{number}CORD")
        base = kept or _numbered_frame(m.world.options.bases, number, "base")
        if kept is None and number and m.world.options.bases_are is None:
            raise open_point("from where a numbered base is seen", "bases_are")
        if kept is not None or m.world.options.bases_are == "seen":
            base = poses.inverse(base, None)
    else:
        base = position(found, "a base")
    arm.base, arm.foot, arm.base_number = base, poses.pose_of(base), number


def _numbered_frame(frames: Mapping[int, Frame], number: int, what: str) -> Position:
    """That of 0 is none unless somebody says otherwise (CR1D: Base, Tool)."""
    if number == 0 and number not in frames:
        return ORIGIN
    if number not in frames:
        raise open_point(f"the {what} {number}, which stands in a parameter", f"{what}s")
    return Position(eight(frames[number]), (0, 0))


# -------------------------------------------------------------------------------------- servo


def _switch_servo(m: Machine, node: s.Expression, *mechanism: s.Expression | None) -> None:
    m.world.needs_mechanism("Servo")
    word = expressions.bare(node)
    if word not in ("On", "Off"):
        raise Failed(4220, "Servo without On or Off")
    if mechanism:
        raise Unknown("Servo of a mechanism by its number")
    m.world.stand()
    m.world.arm.servo = word == "On"


def _change_turns(m: Machine, node: s.Expression, axis: s.Expression | None = None) -> None:
    """JRC: the joint counts a turn more or less, and the arm stays where it is."""
    turns = expressions.integer(m, node, "the turns of JRC")
    which = SIXTH_AXIS if axis is None else expressions.integer(m, axis, "the axis of JRC")
    if turns not in (-1, 0, 1):
        raise out_of_range(f"{turns} turns of JRC")
    if not m.world.options.joint_turns:
        m.world.note("JRC does nothing while the parameter JRCEXE is 0")
        return
    if which != SIXTH_AXIS:
        raise Unknown("JRC of an axis whose turns a parameter gives")
    if turns == 0:
        raise Failed(3910, "JRC 0 of an axis of the arm")
    m.world.stand()
    arm = m.world.arm
    if arm.robot is not None and arm.flange is not None:
        arm.shown_joints()
    if arm.joints is not None:
        arm.joints = (*arm.joints[:5], arm.joints[5] + 360.0 * turns, *arm.joints[6:])
    one, two = arm.flags
    if two is not None:
        nibble = (two >> TURN_SHIFT & 15) + turns & 15
        arm.flags = (one, two & ~(15 << TURN_SHIFT) | nibble << TURN_SHIFT)


SIXTH_AXIS: Final = 6
TURN_SHIFT: Final = 20
"""Of the four bits of joint 6 in FL2."""

# -------------------------------------------------------------------------------------- hands


def _move_hand(m: Machine, node: s.Expression, value: float) -> None:
    order_hand(m, expressions.integer(m, node, "the hand"), value)


def order_hand(m: Machine, hand: int, value: float) -> None:
    """An order to open (1) or to close (0) a hand."""
    if not 1 <= hand <= MOST_HANDS:
        raise out_of_range(f"the hand {hand}")
    m.world.arm.hands[hand] = value
    m.world.task.switch(HAND_SIGNAL.format(hand), value)


MOST_HANDS: Final = 8
HAND_SIGNAL: Final = "hand{}"
"""The event of a hand: 1 as it opens, 0 as it closes."""

# ----------------------------------------------------------------------------------- softness


def _set_softness(m: Machine, mode: s.Expression, axes: s.Expression | None = None) -> None:
    """Cmp: without a force on the arm it stays where it is sent."""
    word, arm = expressions.bare(mode), m.world.arm
    if word not in ("Jnt", "Pos", "Tool", "Off") or (axes is None) != (word == "Off"):
        raise Failed(4220, "Cmp without its kind and its axes")
    if axes is not None:
        expressions.integer(m, axes, "the axes of Cmp")
        if arm.soft not in ("", word):
            raise Failed(2700, f"Cmp {word} while Cmp {arm.soft} holds")
    arm.soft = "" if axes is None else word
    m.world.note("Cmp has no effect: nothing pushes the arm here")


ARM_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "TOOL": _set_tool_statement,
    "BASE": _set_base,
    "SERVO": _switch_servo,
    "JRC": _change_turns,
    "HOPEN": lambda m, hand, *_: _move_hand(m, hand, 1.0),
    "HCLOSE": lambda m, hand: _move_hand(m, hand, 0.0),
    "CMP": _set_softness,
}
