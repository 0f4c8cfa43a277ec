"""Outputs that moves set on their way: `Wth`, and `WthIf` with what is left or done of the way."""

from __future__ import annotations

from typing import Final

from assistant.languages.melfa_basic.lift.statements.data import lift_assignment
from assistant.languages.melfa_basic.lift.statements.paths import Runs
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import Unliftable
from assistant.languages.melfa_basic.tables.triggers import TRIGGER_MEASURES
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.passes.trigger_positions import is_steady

_MEASURES: Final = {name.upper(): place for name, place in TRIGGER_MEASURES.items()}
_TURNED_COMPARISONS: Final = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "=<": ">=", "=>": "<="}


def lift_triggers(append: s.Append | None, lift: Expressions, runs: Runs) -> tuple[p.Trigger, ...]:
    """What a move sets on its way; raises Unliftable for anything but a number given to outputs."""
    if append is None:
        return ()
    if not isinstance(append.statement, s.Assign):
        raise Unliftable
    measure, amount = _trigger_place(append.condition, lift)
    match lift_assignment(append.statement, lift, runs):
        case [p.SetSignal(signal, e.Number() as value, (None | e.Number()) as pulse)] if (
            pulse is None or append.condition is None
        ):
            return (p.Trigger(signal, value, amount, measure, pulse),)
    raise Unliftable


def _trigger_place(
    condition: s.Expression | None, lift: Expressions
) -> tuple[p.Measure, e.Expression]:
    match condition:
        case None:
            return "start", e.Number(0)
        case s.Binary(operator, left, place) if _is_measured_place(
            place
        ) and not _is_measured_place(left):
            return _trigger_place(
                s.Binary(_TURNED_COMPARISONS.get(operator, ""), place, left), lift
            )
        case s.Binary(operator, s.Variable(arguments=None, component="") as place, bound):
            measure, reached = _MEASURES.get(place.key, (None, ""))
            amount = lift.of(bound)
            if measure is not None and operator[:1] == reached[:1] and _is_steady(bound, amount):
                return measure, amount
    raise Unliftable


def _is_steady(bound: s.Expression, amount: e.Expression) -> bool:
    """Whether a bound stays as it is while the robot moves: no input, timer or state is in it."""
    read = (x.key for x in nodes(bound) if isinstance(x, s.Variable))
    return is_steady(amount) and not any(key.startswith("M_") for key in read)


def _is_measured_place(x: s.Expression) -> bool:
    return isinstance(x, s.Variable) and x.key in _MEASURES
