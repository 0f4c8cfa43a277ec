"""Rules of outputs that moves set on their way: what sets them up, and when."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from assistant.languages.rapid.checks import plain_rules as rules
from assistant.languages.rapid.checks.module_view import Look, Task
from assistant.languages.rapid.tables.triggers import LONGEST_TIME, MOVES, SETUPS, TYPE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.triggers import taken
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]


def never_set_up(look: Look) -> Found:
    """Data that moves are given though nothing sets them up."""
    if not any(str(call.name).lower() in MOVES for call in look.all(s.ProcedureCall)):
        return
    elsewhere = look.task.once(_elsewhere)
    for routine in look.routines:
        for node in nodes(routine):
            for one in taken(node):
                declared = look.find(one.name, routine)
                own = declared is not None and isinstance(declared.node, s.Data)
                if declared is None or not own or declared.type.lower() != TYPE:
                    continue
                if one.name.lower() not in elsewhere:
                    yield look.finding(rules.NEVER_SET_UP, one, name=one.name)


def _elsewhere(task: Task) -> set[str]:
    """Lower-case names that are mentioned other than where a move takes them."""
    named: Counter[str] = Counter()
    for node in nodes(task.modules):
        if isinstance(node, s.NameRef):
            named[node.name.lower()] += 1
        elif isinstance(node, s.ProcedureCall):
            named.subtract(one.name.lower() for one in taken(node))
    return {name for name, count in named.items() if count > 0}


def long_times(look: Look) -> Found:
    """Times before the end of a move that no controller looks ahead."""
    for call in look.all(s.ProcedureCall):
        if str(call.name).lower() in SETUPS and any(
            isinstance(x, s.Option) and x.name.lower() == "time" for x in call.arguments
        ):
            given = [x.value for x in call.arguments if isinstance(x, s.Positional)]
            seconds = literal_number(given[1]) if len(given) > 1 else None
            if seconds is not None and seconds > LONGEST_TIME:
                yield look.finding(rules.LONG_TIME, given[1], most=LONGEST_TIME)
