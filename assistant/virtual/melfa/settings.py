"""Statements that are a word and its arguments: settings, waits, hands, ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.events import Said
from assistant.virtual.melfa import (
    blocks,
    data,
    expressions,
    interrupts,
    mechanism,
    multitask,
    pallets,
)
from assistant.virtual.melfa.arm import FULL, OPTIMUM
from assistant.virtual.melfa.code import nodes
from assistant.virtual.melfa.stops import Ended, Failed, Unknown, out_of_range
from assistant.virtual.melfa.values import Value, holds, position

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine


def run_command(m: Machine, node: s.Command) -> None:
    """Runs a command; raises Unknown for one that is not simulated."""
    word = " ".join(node.keyword.upper().split())
    if m.world.commands and _run_plugin(m, word, node.arguments):
        return
    if word in BLOCK_WORDS:
        BLOCK_WORDS[word](m, node)
    elif word in COMMAND_WORDS:
        known, count = vocabulary.statement(word), len(node.arguments)
        if known and not known.least <= count <= (count if known.most is None else known.most):
            raise Failed(3120, f"{node.keyword} with {count} arguments")
        COMMAND_WORDS[word](m, *node.arguments)
    elif word in TUNING_WORDS:
        m.world.note(f"{node.keyword} has no effect on this run")
    elif word not in WORDS_WITHOUT_EFFECT:
        raise Unknown(f"the statement {node.keyword}")


def _run_plugin(m: Machine, word: str, nodes: tuple[s.Expression | None, ...]) -> bool:
    """Runs the plug-in of a command, which may have its first word of arguments in its name."""
    first = nodes[0] if nodes else None
    two = f"{word} {expressions.bare(first)}".upper()
    name = two if two in m.world.commands else word
    if name not in m.world.commands:
        return False
    rest = nodes[1:] if name == two else nodes
    m.world.given(name, tuple(None if a is None else _loose_argument(m, a) for a in rest))
    return True


def _loose_argument(m: Machine, node: s.Expression) -> Value:
    """The value of an argument of a plug-in; a bare word is a text."""
    word = expressions.bare(node)
    return word if word in LOOSE_WORDS else expressions.value(m, node)


LOOSE_WORDS: Final = frozenset(("On", "Off", "Jnt", "Pos", "Tool"))

WORDS_WITHOUT_EFFECT: Final = frozenset(("ENDIF", "END SELECT", "TITLE"))
"""Ends of blocks, and what is a comment."""
TUNING_WORDS: Final = frozenset((
    "OADL", "LOADSET", "FINE", "PREC", "MVTUNE", "SPDOPT", "COLCHK", "COLLVL", "CAVCHK", "CMPG",
    "TORQ",
))  # fmt: skip
"""Settings that change no event: how the arm is driven, and what it watches."""

# ------------------------------------------------------------------------------------ motion


def _set_speed(m: Machine, node: s.Expression) -> None:
    speed = expressions.plain(m, node, "the speed")
    if speed <= 0:
        raise out_of_range(f"the speed {speed}")
    m.world.settings.speed = min(float(speed), OPTIMUM)


def _percent_of(m: Machine, node: s.Expression | None, what: str) -> float:
    value = FULL if node is None else float(expressions.plain(m, node, what))
    if not 0 < value <= FULL:
        raise out_of_range(f"{what} of {value} percent")
    return value


def _set_override(m: Machine, node: s.Expression, *others: s.Expression | None) -> None:
    for other in others:
        _percent_of(m, other, "the override of Mva")
    m.world.settings.override = _percent_of(m, node, "the override")


def _set_joint_override(m: Machine, node: s.Expression) -> None:
    m.world.settings.joint_override = _percent_of(m, node, "the joint override")


def _set_acceleration(m: Machine, *nodes: s.Expression | None) -> None:
    first, second, *_ = (*nodes, None, None)
    m.world.settings.acceleration = (
        _percent_of(m, first, "the acceleration"),
        _percent_of(m, second, "the deceleration"),
    )


def _set_corner(m: Machine, switch: s.Expression, *sizes: s.Expression | None) -> None:
    """`Cnt 1,a,b`: a corner from a before the place to b behind it; the smaller one limits."""
    on = expressions.integer(m, switch, "the switch of Cnt")
    given = [float(expressions.plain(m, node, "a corner")) for node in sizes if node is not None]
    if on not in (0, 1) or any(size < 0 for size in given):
        raise out_of_range("an argument of Cnt")
    m.world.settings.corner = min(given, default=math.inf) if on else 0.0


# ----------------------------------------------------------------------------------- pallets


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
    m.pallets[number] = pallets.pallet_grid(
        number, places, (first, second), direction, fixed=m.world.options.pallets == "start"
    )


# ------------------------------------------------------------------------------ waits and ends


def _delay(m: Machine, node: s.Expression) -> None:
    seconds = float(expressions.plain(m, node, "the time"))
    if seconds < 0:
        raise out_of_range(f"a time of {seconds} seconds")
    m.world.stand()
    m.world.task.delay(seconds)


def _wait(m: Machine, node: s.Expression) -> None:
    """A timer goes on by itself, so that a condition with one is asked again and again."""
    task = m.world.task
    m.world.stand()
    if any(isinstance(part, s.Variable) and part.key == "M_TIMER" for part in nodes(node)):
        since = task.kernel.now
        while not holds(expressions.value(m, node)):
            task.looked(since, over=False)
            task.step()
        task.looked(since, over=True)
    else:
        interrupts.attend(m, node)
        try:
            task.wait(lambda: holds(expressions.value(m, node)))
        finally:
            interrupts.attend(m)


def _halt_program(m: Machine) -> None:
    m.world.stand()
    m.world.halt()


def _raise_error(m: Machine, node: s.Expression) -> None:
    number = expressions.integer(m, node, "the number of an error")
    if number not in USER_ERRORS:
        raise out_of_range(f"the error {number}")
    if number < FIRST_CAUTION:
        raise Failed(number, "raised by the program")
    m.world.warn(number)
    m.world.task.tell(Said(f"error {number}"))


def _reset_error(m: Machine) -> None:
    if not m.world.options.resets:
        raise Failed(None, "Reset Err in a program that does not always run (ALWENA)")
    m.world.warn(0)


USER_ERRORS: Final = range(9000, 9300)
FIRST_CAUTION: Final = 9200
"""From here on the program runs on."""


def _end_program(_: Machine) -> None:
    raise Ended


COMMAND_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    **mechanism.ARM_WORDS,
    **data.DATA_WORDS,
    "SPD": _set_speed,
    "OVRD": _set_override,
    "JOVRD": _set_joint_override,
    "ACCEL": _set_acceleration,
    "CNT": _set_corner,
    "DLY": _delay,
    "WAIT": _wait,
    "HLT": _halt_program,
    "ERROR": _raise_error,
    "RESET ERR": _reset_error,
    "END": _end_program,
    "EXIT FUNCTION": lambda m: m.leave(),
    "FEND": lambda m: m.leave(),
    **multitask.SLOT_WORDS,
    **interrupts.WORDS,
}

BLOCK_WORDS: Final[Mapping[str, Callable[[Machine, Any], None]]] = {
    "ELSE": blocks.skip_rest,
    "DEFAULT": blocks.skip_rest,
    "WHILE": blocks.test_while,
    "WEND": blocks.back_to_while,
    "BREAK": blocks.leave_block,
}
