"""`Def Act` and `Act` of programs that were written here; Mo triggers, which they may ask."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assistant.languages import vendor_statements
from assistant.languages.melfa_basic.lift.structure.blocks import Code
from assistant.languages.melfa_basic.lift.structure.regions import target_name
from assistant.languages.melfa_basic.lift.values.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.tables.vocabulary.interrupts import ALL_INTERRUPTS
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.blocks import statement_of
from assistant.languages.melfa_basic.tree.walk import literal
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Variable

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lift.statements.lines import Statements


def define_interrupt(reader: Statements, node: s.DefAct) -> list[p.Statement]:
    """An interrupt that calls a procedure and goes on where the program was, or ends it."""
    condition = reader.expressions.condition(node.condition)
    answer = reader.answers.get(target_name(node.target))
    if answer is not None and node.keyword == "GoSub" and not node.stop:
        call, ends = answer
        over = None if ends is None else reader.expressions.condition(ends)
        return [
            p.Interrupt(
                _interrupt_name(reader, node.number),
                condition,
                p.Call(_called_procedure(reader, call)),
                over,
            )
        ]
    called = _answering_procedure(reader, node)
    if called is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    over = e.Number(1) if node.keyword == "GoTo" else None
    return [p.Interrupt(_interrupt_name(reader, node.number), condition, p.Call(called), over)]


def _answering_procedure(reader: Statements, node: s.DefAct) -> str | None:
    """The procedure that interrupts alone lead to, as it is called; None if there is none."""
    number = reader.by_label.get(target_name(node.target))
    if number is None or not reader.regions[number].answers:
        return None
    forms = [*reader.called.forms[number].values()]
    return forms[0].name if len(forms) == 1 and not forms[0].passes else None


def switch_interrupt(reader: Statements, node: s.Command) -> list[p.Statement]:
    (given,) = node.arguments
    if not isinstance(given, s.Binary):
        raise Unliftable(vendor_statements.INTERRUPTS)
    state = literal(given.right)
    if state not in (0, 1):
        raise Unliftable(vendor_statements.INTERRUPTS)
    switched: p.SwitchInterrupt | p.SwitchInterrupts
    if literal(given.left) == ALL_INTERRUPTS:
        if not reader.answers and None in _defined_interrupts(reader).values():
            raise Unliftable(vendor_statements.INTERRUPTS)
        switched = p.SwitchInterrupts("on" if state else "off")
    else:
        switched = p.SwitchInterrupt(_interrupt_name(reader, given.left), "on" if state else "off")
    return [switched]


def _defined_interrupts(reader: Statements) -> dict[float | None, str | None]:
    """By the number of each interrupt what it calls, None for what cannot be said."""
    found: dict[float | None, str | None] = {}
    for node, alone in reader.definitions:
        number, called = literal(node.number), _answering_procedure(reader, node)
        same = found.get(number, called) == called and alone
        found[number] = called if same and number is not None else None
    return found


def _interrupt_name(reader: Statements, node: s.Expression) -> str:
    number = literal(node)
    if number is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    known = reader.symbols.header.names["interrupt"].get(f"{number:g}")
    if known is None and _defined_interrupts(reader).get(number) is not None:
        known = f"act_{number:g}"
    if known is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    return known


def _called_procedure(reader: Statements, call: s.Jump | s.Call) -> str:
    """The procedure that answers."""
    if isinstance(call, s.Jump):
        number = reader.by_label.get(target_name(call.target))
        if number is None:
            raise Unliftable(vendor_statements.INTERRUPTS)
        return reader.routines[number].name
    routine = reader.symbols.routines.get(call.function.key)
    if routine is None:
        raise Unliftable(vendor_statements.INTERRUPTS)
    return routine.name


# ------------------------------------------------------------------------------ Mo triggers


def mo_triggers(code: Code, symbols: Symbols) -> dict[int, tuple[str, s.Expression]]:
    """The condition of each Mo trigger that has one definition, and a name for whether it is on."""
    found: dict[int, list[s.Expression | None]] = {}
    for item in code:
        node = statement_of(item)
        if isinstance(node, s.DefOther) and node.kind == "MoTrg" and len(node.arguments) == 2:
            number = symbols.constants.value(node.arguments[0])
            if not isinstance(number, float):
                return {}
            found.setdefault(round(number), []).append(node.arguments[1])
    return {
        number: (symbols.free(f"mo_trigger_{number}"), conditions[0])
        for number, conditions in found.items()
        if len(conditions) == 1 and conditions[0] is not None
    }


def watch_mo_triggers(reader: Statements, node: s.Command) -> list[p.Statement]:
    """`SetMoTrg n`: from here on a Mo trigger is watched; with 0 none is."""
    symbols = reader.symbols
    number = symbols.value(node.arguments[0])
    if not symbols.telling or not isinstance(number, float) or not symbols.mo_triggers:
        raise Unliftable
    wanted = [round(number)] if number else sorted(symbols.mo_triggers)
    if not set(wanted) <= symbols.mo_triggers.keys():
        raise Unliftable
    names = [symbols.mo_triggers[one][0] for one in wanted]
    for name in names:
        symbols.variables.setdefault(name, Variable("integer", e.Number(0)))
    return [p.Assign(e.Name(name), e.Number(int(number != 0))) for name in names]
