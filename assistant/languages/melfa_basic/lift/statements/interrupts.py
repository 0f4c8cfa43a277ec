"""`Def Act` and `Act` of programs that were written here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.languages import kept_reasons
from assistant.languages.melfa_basic.lift.structure.regions import place_name
from assistant.languages.melfa_basic.lift.values.symbols import Unliftable
from assistant.languages.melfa_basic.tables.vocabulary.interrupts import ALL
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.program import expressions as e
from assistant.program import statements as p

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lift.statements.lines import Statements


def define(reader: Statements, node: s.DefAct) -> list[p.Statement]:
    """An interrupt that calls a procedure and goes on where the program was, or ends it."""
    condition = reader.expressions.condition(node.condition)
    answer = reader.answers.get(place_name(node.target))
    if answer is not None and node.keyword == "GoSub" and not node.stop:
        call, ends = answer
        over = None if ends is None else reader.expressions.condition(ends)
        return [
            p.Interrupt(_name(reader, node.number), condition, p.Call(_called(reader, call)), over)
        ]
    called = _answering(reader, node)
    if called is None:
        raise Unliftable(kept_reasons.INTERRUPTS)
    over = e.Number(1) if node.keyword == "GoTo" else None
    return [p.Interrupt(_name(reader, node.number), condition, p.Call(called), over)]


def _answering(reader: Statements, node: s.DefAct) -> str | None:
    """The procedure that interrupts alone lead to, as it is called; None if there is none."""
    number = reader.by_label.get(place_name(node.target))
    if number is None or not reader.regions[number].answers:
        return None
    forms = [*reader.called.forms[number].values()]
    return forms[0].name if len(forms) == 1 and not forms[0].passes else None


def switch(reader: Statements, node: s.Command) -> list[p.Statement]:
    (given,) = node.arguments
    if not isinstance(given, s.Binary):
        raise Unliftable(kept_reasons.INTERRUPTS)
    state = literal(given.right)
    if state not in (0, 1):
        raise Unliftable(kept_reasons.INTERRUPTS)
    switched: p.SwitchInterrupt | p.SwitchInterrupts
    if literal(given.left) == ALL:
        if not reader.answers and None in _defined(reader).values():
            raise Unliftable(kept_reasons.INTERRUPTS)
        switched = p.SwitchInterrupts("on" if state else "off")
    else:
        switched = p.SwitchInterrupt(_name(reader, given.left), "on" if state else "off")
    return [switched]


def _defined(reader: Statements) -> dict[float | None, str | None]:
    """By the number of each interrupt what it calls, None for what cannot be said."""
    found: dict[float | None, str | None] = {}
    for node, alone in reader.definitions:
        number, called = literal(node.number), _answering(reader, node)
        same = found.get(number, called) == called and alone
        found[number] = called if same and number is not None else None
    return found


def _name(reader: Statements, node: s.Expression) -> str:
    number = literal(node)
    if number is None:
        raise Unliftable(kept_reasons.INTERRUPTS)
    known = reader.symbols.header.names["interrupt"].get(f"{number:g}")
    if known is None and _defined(reader).get(number) is not None:
        known = f"act_{number:g}"
    if known is None:
        raise Unliftable(kept_reasons.INTERRUPTS)
    return known


def _called(reader: Statements, call: s.Jump | s.Call) -> str:
    """The procedure that answers."""
    if isinstance(call, s.Jump):
        number = reader.by_label.get(place_name(call.target))
        if number is None:
            raise Unliftable(kept_reasons.INTERRUPTS)
        return reader.routines[number].name
    routine = reader.symbols.routines.get(call.function.key)
    if routine is None:
        raise Unliftable(kept_reasons.INTERRUPTS)
    return routine.name
