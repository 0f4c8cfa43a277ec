"""`Def Act` and `Act` of programs that were written here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.languages import kept_reasons
from assistant.languages.melfa_basic.lift.structure.regions import place_name
from assistant.languages.melfa_basic.lift.values.symbols import Unliftable
from assistant.languages.melfa_basic.tables.vocabulary.interrupts import ALL
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.program import statements as p

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lift.statements.lines import Statements


def define(reader: Statements, node: s.DefAct) -> list[p.Statement]:
    """An interrupt that calls a procedure and goes on where the program was."""
    answer = reader.answers.get(place_name(node.target))
    if answer is None or node.keyword != "GoSub" or node.stop:
        raise Unliftable(kept_reasons.INTERRUPTS)
    name = _name(reader, node.number)
    call, ends = answer
    condition = reader.expressions.condition(node.condition)
    over = None if ends is None else reader.expressions.condition(ends)
    return [p.Interrupt(name, condition, p.Call(_called(reader, call)), over)]


def switch(reader: Statements, node: s.Command) -> list[p.Statement]:
    (given,) = node.arguments
    if not isinstance(given, s.Binary) or not reader.answers:
        raise Unliftable(kept_reasons.INTERRUPTS)
    state = literal(given.right)
    if state not in (0, 1):
        raise Unliftable(kept_reasons.INTERRUPTS)
    switched: p.SwitchInterrupt | p.SwitchInterrupts
    if literal(given.left) == ALL:
        switched = p.SwitchInterrupts("on" if state else "off")
    else:
        switched = p.SwitchInterrupt(_name(reader, given.left), "on" if state else "off")
    return [switched]


def _name(reader: Statements, node: s.Expression) -> str:
    number = literal(node)
    known = None if number is None else reader.symbols.header.names["interrupt"].get(f"{number:g}")
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
