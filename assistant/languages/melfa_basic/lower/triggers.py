"""Outputs that moves set on their way, and what breaks them off, as appended to a motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from assistant.languages.melfa_basic.lower.expressions import Unsayable
from assistant.languages.melfa_basic.lower.signals import output_assignment
from assistant.languages.melfa_basic.tables.triggers import TRIGGER_MEASURES
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend
from assistant.program.passes.trigger_positions import ZERO, is_at_start, is_steady

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.writer import Writer

MEASURE_WORDS: Final = {measure: name for name, (measure, _) in TRIGGER_MEASURES.items()}
"""The status variable of each measure that has one."""


def appended_statement(w: Writer, move: p.MoveStatement) -> s.Append | None:
    """`Wth` or `WthIf` for what a move sets on its way or ends at, None if that is nothing."""
    triggers, blend = move.triggers, move.motion.blend
    if move.until is not None:
        if triggers:
            raise Unsayable(
                f"that `{triggers[0].signal}` is set on the way of a move that may be broken off",
                "set it before or behind the move",
            )
        return s.Append(s.Command("Skip"), w.expressions.of(move.until))
    if not triggers:
        return None
    if len(triggers) > 1:
        names = " and ".join(f"`{one.signal}`" for one in triggers)
        raise Unsayable(
            f"that {names} are set on the way of one move, which has one `Wth`",
            "divide the move, or set all but one before or behind it",
        )
    (one,) = triggers
    stops, at = isinstance(blend, Blend) and blend.fine, one.amount
    given = all(isinstance(x, e.Number) for x in (one.value, one.pulse or ZERO))
    steady = isinstance(at, e.Number) or (stops and is_steady(at, w.expressions.signals))
    for what, cure in _unsayable_trigger(one, given and steady):
        raise Unsayable(what, cure)
    pulse = None if one.pulse is None else w.expressions.of(one.pulse)
    assignment = output_assignment(w, one, pulse)
    if is_at_start(one):
        return s.Append(assignment)
    name = MEASURE_WORDS[one.measure]
    place, operator = s.Variable(w.expressions.word(name)), TRIGGER_MEASURES[name][1]
    return s.Append(assignment, s.Binary(operator, place, w.expressions.of(one.amount)))


def _unsayable_trigger(x: p.Trigger, steady: bool) -> Iterator[tuple[str, str]]:
    """What `Wth` and `WthIf` have no form for, and what to do instead.

    steady: what it sets is a number, and so is its place, or the move stops and the place stays as
    it is until then.
    """
    name = f"`{x.signal}`"
    if x.ahead is not None:
        yield f"a delay of what {name} sets on the way", "give the place where it is to be set"
    if x.measure == "time":
        yield f"that {name} is set a time before the end of a move", "give mm before the end"
    if not steady:
        cure = "write numbers, or let the move end with `fine`"
        yield f"what {name} is set to, or where, by more than numbers", cure
    if x.measure == "start" and not is_at_start(x):
        yield (
            f"that {name} is set mm behind the start of a way of unknown length",
            "give mm before the end, or let a move to a known target stand before it",
        )
    if x.measure in MEASURE_WORDS and x.pulse is not None:
        yield f"a pulse of {name} at a place of the way", "set it there, and back elsewhere"
    if x.measure == "end" and x.amount == ZERO:
        yield (
            f"that {name} is set at the very end of a move that does not stop",
            "end the move with `fine`, or set it some mm before",
        )
