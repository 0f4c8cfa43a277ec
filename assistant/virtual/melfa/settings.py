"""Statements that are a word and its arguments: settings, waits, hands, ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.events import Stopped
from assistant.virtual.melfa import blocks, expressions, multitask, pallets, poses
from assistant.virtual.melfa.arm import FULL, OPTIMUM
from assistant.virtual.melfa.code import nodes
from assistant.virtual.melfa.stops import Ended, Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import Position, Value, holds, position

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def command(m: Machine, node: s.Command) -> None:
    """Runs a command; raises Unknown for one that is not simulated."""
    word = " ".join(node.keyword.upper().split())
    if m.world.commands and _plugged(m, word, node.arguments):
        return
    if word in STRUCTURE:
        STRUCTURE[word](m, node)
    elif word in WORDS:
        known, count = vocabulary.statement(word), len(node.arguments)
        if known and not known.least <= count <= (count if known.most is None else known.most):
            raise Failed(3120, f"{node.keyword} with {count} arguments")
        WORDS[word](m, *node.arguments)
    elif word not in QUIET:
        raise Unknown(f"the statement {node.keyword}")


def _plugged(m: Machine, word: str, nodes: tuple[s.Expression | None, ...]) -> bool:
    """Runs the plug-in of a command, which may have its first word of arguments in its name."""
    first = nodes[0] if nodes else None
    two = f"{word} {expressions.bare(first)}".upper()
    name = two if two in m.world.commands else word
    if name not in m.world.commands:
        return False
    rest = nodes[1:] if name == two else nodes
    m.world.given(name, tuple(None if a is None else _loose(m, a) for a in rest))
    return True


def _loose(m: Machine, node: s.Expression) -> Value:
    """The value of an argument of a plug-in; a bare word is a text."""
    word = expressions.bare(node)
    return word if word in LOOSE else expressions.value(m, node)


LOOSE: Final = frozenset(("On", "Off", "Jnt", "Pos", "Tool"))

QUIET: Final = frozenset((
    "ENDIF", "END SELECT", "OADL", "LOADSET", "FINE", "PREC", "MVTUNE", "SPDOPT", "COLCHK",
    "COLLVL", "TITLE",
))  # fmt: skip
"""Words that change no event: ends of blocks, and settings."""

# ------------------------------------------------------------------------------------ motion


def _tool(m: Machine, node: s.Expression) -> None:
    """Holds at once, also for P_Curr."""
    arm = m.world.arm
    arm.tool = _frame(m, node)
    arm.tip = poses.pose_of(arm.tool)


def _base(m: Machine, node: s.Expression) -> None:
    """The robot's base seen from where positions are counted."""
    arm = m.world.arm
    arm.base = _frame(m, node)
    arm.foot = poses.pose_of(arm.base)


def _frame(m: Machine, node: s.Expression) -> Position:
    found = expressions.value(m, node)
    if isinstance(found, int | float):
        raise Unknown("a tool or base by its number")
    return position(found, "a tool or base")


def _speed(m: Machine, node: s.Expression) -> None:
    speed = expressions.plain(m, node, "the speed")
    if speed <= 0:
        raise out_of_range(f"the speed {speed}")
    m.world.settings.speed = min(float(speed), OPTIMUM)


def _percent(m: Machine, node: s.Expression | None, what: str) -> float:
    value = FULL if node is None else float(expressions.plain(m, node, what))
    if not 0 < value <= FULL:
        raise out_of_range(f"{what} of {value} percent")
    return value


def _override(m: Machine, node: s.Expression, *others: s.Expression | None) -> None:
    if others:
        raise Unknown("Ovrd by the direction of the motion")
    m.world.settings.override = _percent(m, node, "the override")


def _joint_override(m: Machine, node: s.Expression) -> None:
    m.world.settings.joint_override = _percent(m, node, "the joint override")


def _acceleration(m: Machine, *nodes: s.Expression | None) -> None:
    first, second, *_ = (*nodes, None, None)
    m.world.settings.acceleration = (
        _percent(m, first, "the acceleration"),
        _percent(m, second, "the deceleration"),
    )


def _corner(m: Machine, switch: s.Expression, *sizes: s.Expression | None) -> None:
    """`Cnt 1,a,b`: a corner from a before the place to b behind it; the smaller one limits."""
    on = expressions.integer(m, switch, "the switch of Cnt")
    given = [float(expressions.plain(m, node, "a corner")) for node in sizes if node is not None]
    if on not in (0, 1) or any(size < 0 for size in given):
        raise out_of_range("an argument of Cnt")
    m.world.settings.corner = min(given, default=math.inf) if on else 0.0


def _servo(m: Machine, node: s.Expression, *mechanism: s.Expression | None) -> None:
    m.world.needs_mechanism("Servo")
    if node != s.Word("On") or mechanism:
        raise Unknown("what a program does without servo")


# -------------------------------------------------------------------------- hands and pallets


def _hand(m: Machine, node: s.Expression, value: float) -> None:
    hand = expressions.integer(m, node, "the hand")
    if not 1 <= hand <= HANDS:
        raise out_of_range(f"the hand {hand}")
    m.world.task.switch(HAND.format(hand), value)


HANDS: Final = 8
HAND: Final = "hand{}"
"""The event of a hand: 1 as it opens, 0 as it closes."""


def define_pallet(m: Machine, arguments: tuple[s.Expression | None, ...]) -> None:
    """`Def Plt`, whose diagonal corner may be missing with its comma."""
    if len(arguments) == 7:
        arguments = (*arguments[:4], None, *arguments[4:])
    if len(arguments) != 8:
        raise Failed(3120, f"Def Plt with {len(arguments)} arguments")
    number = expressions.integer(m, arguments[0], "the pallet")
    corners = [None if a is None else expressions.value(m, a) for a in arguments[1:5]]
    first, second, direction = (
        expressions.integer(m, a, "an argument of Def Plt") for a in arguments[5:]
    )
    places = tuple(None if c is None else position(c, "a corner of the pallet") for c in corners)
    m.pallets[number] = pallets.grid(number, places, (first, second), direction)


# ------------------------------------------------------------------------------ waits and ends


def _delay(m: Machine, node: s.Expression) -> None:
    seconds = float(expressions.plain(m, node, "the time"))
    if seconds < 0:
        raise out_of_range(f"a time of {seconds} seconds")
    m.world.task.delay(seconds)


def _wait(m: Machine, node: s.Expression) -> None:
    """A timer goes on by itself, so that a condition with one is asked again and again."""
    task = m.world.task
    if any(isinstance(part, s.Variable) and part.key == "M_TIMER" for part in nodes(node)):
        while not holds(expressions.value(m, node)):
            task.step()
    else:
        task.wait(lambda: holds(expressions.value(m, node)))


def _halt(m: Machine) -> None:
    m.world.task.tell(Stopped())
    if m.world.slot is not None:
        m.world.slot.hold()


def _return(m: Machine, node: s.Expression | None = None) -> None:
    if node is not None:
        raise Unknown("the return from an interrupt")
    if not m.frame.back:
        raise Failed(3840, "Return without GoSub")
    m.at = m.frame.back.pop()


def _error(m: Machine, node: s.Expression) -> None:
    number = expressions.integer(m, node, "the number of an error")
    if number not in USER_ERRORS:
        raise out_of_range(f"the error {number}")
    if number >= CAUTION:
        raise Unknown("a caution that the program raises")
    raise Failed(number, "raised by the program")


USER_ERRORS: Final = range(9000, 9300)
CAUTION: Final = 9200
"""From here on the program runs on."""


def _end(_: Machine) -> None:
    raise Ended


WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "TOOL": _tool,
    "BASE": _base,
    "SPD": _speed,
    "OVRD": _override,
    "JOVRD": _joint_override,
    "ACCEL": _acceleration,
    "CNT": _corner,
    "SERVO": _servo,
    "HOPEN": lambda m, hand, *_: _hand(m, hand, 1.0),
    "HCLOSE": lambda m, hand: _hand(m, hand, 0.0),
    "DLY": _delay,
    "WAIT": _wait,
    "HLT": _halt,
    "RETURN": _return,
    "ERROR": _error,
    "END": _end,
    "EXIT FUNCTION": lambda m: m.leave(),
    "FEND": lambda m: m.leave(),
    **multitask.WORDS,
}

STRUCTURE: Final[Mapping[str, Callable[[Machine, Any], None]]] = {
    "ELSE": blocks.skip_rest,
    "DEFAULT": blocks.skip_rest,
    "WHILE": blocks.test_while,
    "WEND": blocks.back_to_while,
    "BREAK": blocks.leave,
}
