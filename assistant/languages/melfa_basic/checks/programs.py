"""Rules of several programs, of interrupts, and of lines of communication."""

from __future__ import annotations

from collections.abc import Iterator

from assistant.base.diagnostics import Rule
from assistant.languages.checks.control_flow import call_chain, call_depth
from assistant.languages.checks.names import Keyed, firsts
from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import flow_rules, motion_rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.walk import (
    awaited_programs,
    lines_with,
    literal,
    named_programs,
    program_key,
    program_name,
)


def missing_programs(look: Look) -> Found:
    """Programs that are called, run or loaded, and are not among the files."""
    awaits = {program_key(name) for _, name in awaited_programs(look.tree)}
    for line, name, _ in firsts(named_programs(look.tree), lambda call: program_key(call[1])):
        if program_key(name) not in look.calls.by_name:
            rule = rules.NOT_CALLED if program_key(name) in awaits else rules.NO_PROGRAM
            yield look.at(rule, line, f'"{name}"', name=name)


def program_recursion(look: Look) -> Found:
    """Programs that call themselves, or call too deep: the first call of either kind."""
    own = program_name(look.tree).upper()
    most = look.dialect.calls

    def inner(name: str) -> list[str]:
        tree = look.calls.by_name.get(name)
        return (
            [program_key(other) for _, other in awaited_programs(tree)] if tree is not None else []
        )

    for line, written in awaited_programs(look.tree):
        name = program_key(written)
        chain = call_chain(own, name, inner) if own else None
        if chain is not None:
            text = " calls ".join(f"`{n}`" for n in (own, *chain))
            yield look.at(flow_rules.CALLS_ITSELF, line, "CallP", chain=text)
            return
        deep = 1 + call_depth(name, inner)
        if deep == most + 1:
            yield look.at(flow_rules.CALLED_TOO_DEEP, line, "CallP", depth=deep, most=most)
            return


def mechanism_requests(look: Look) -> Found:
    """Programs that are run in slots other than 1, and move the robot without having asked."""
    others = (call for call in named_programs(look.tree) if (call[2] or 0) > 1)
    for line, name, slot in firsts(others, lambda call: program_key(call[1])):
        tree = look.calls.by_name.get(program_key(name))
        code = tree.code if tree else ()
        asks = any(command.keyword == "GetM" for _, command in lines_with(code, s.Command))
        if any(map(_moves_robot, code)) and not asks:
            yield look.at(motion_rules.NO_GETM, line, f'"{name}"', name=name, slot=slot)


def _moves_robot(item: s.Entry) -> bool:
    return isinstance(item, MoveRows) or isinstance(item.statement, s.Motion)


# ----------------------------------------------------------------------------------- interrupts


NumberedLines = Keyed[float, tuple[s.Line, str]]
"""By number the line that names it, and the word that it stands behind."""


def _without(look: Look, rule: Rule, some: NumberedLines, others: NumberedLines) -> Found:
    """The rule's finding at each number that is not among others."""
    for number, (line, word) in some.without(others):
        yield look.at(rule, line, word, word=word, number=f"{number:g}")


def interrupt_switches(look: Look) -> Found:
    """Interrupts that are switched but not defined, or defined but not switched on."""
    switches = list(_switches(look))
    defined = Keyed.of((literal(act.number), (line, "Act")) for line, act in look.all(s.DefAct))
    switched = Keyed.of((n, (line, "Act")) for line, n, _ in switches if n)
    on = Keyed.of(
        (n or None, (line, "Act")) for line, n, state in switches if n is None or state != 0
    )
    yield from _without(look, motion_rules.NO_ACT, switched, defined)
    yield from _without(look, motion_rules.ACT_OFF, defined, on)


def _switches(look: Look) -> Iterator[tuple[s.Line, float | None, float | None]]:
    """`Act n=state` statements; None for numbers that are worked out."""
    for line, command in look.all(s.Command):
        if command.keyword == "Act" and command.arguments:
            match command.arguments[0]:
                case s.Binary("=", number, state):
                    yield line, literal(number), literal(state)


# --------------------------------------------------------------------------------------- files


def file_states(look: Look) -> Found:
    """Lines that are used without being opened, opened twice, or never closed."""
    printed = ((literal(node.number), (line, "Print")) for line, node in look.all(s.Print))
    read = ((literal(node.number), (line, "Input")) for line, node in look.all(s.Input))
    used = Keyed.of((*printed, *read))
    opened = Keyed.of((literal(node.number), (line, "Open")) for line, node in look.all(s.Open))
    closed = Keyed.of(
        (number, (line, "Close"))
        for line, node in look.all(s.Close)
        for number in map(literal, node.numbers or (None,))
    )
    beside = (tree for tree in look.calls.trees if tree is not look.tree)
    others = any(any(lines_with(tree.items, s.Open)) for tree in beside)
    if not others:
        yield from _without(look, motion_rules.NOT_OPENED, used, opened)
    yield from _without(look, motion_rules.NOT_CLOSED, opened, closed)
    yield from _opened_twice(look)


def _opened_twice(look: Look) -> Found:
    """Opens of a number that is open, as far as the lines run straight on."""
    busy: set[float] = set()
    for line in look.lines:
        if line.label is not None:
            busy.clear()
        match line.statement:
            case s.Open(number=value):
                number = literal(value)
                if number is not None and number in busy:
                    yield look.at(motion_rules.OPENED_TWICE, line, "Open", number=f"{number:g}")
                if number is not None:
                    busy.add(number)
            case s.Close(numbers=numbers):
                busy -= {n for value in numbers if (n := literal(value)) is not None}
                if not numbers or any(literal(value) is None for value in numbers):
                    busy.clear()
            case s.Command("End") | s.Jump() | s.CallP() | s.Call() | s.If():
                busy.clear()
