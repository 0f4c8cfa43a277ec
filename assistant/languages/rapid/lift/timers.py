"""Clocks that are restarted and read, and nothing else: timers of the pseudo-program.

`ClkReset` stops a clock that runs and sets it to 0, `ClkStart` lets it run from there (RAPID
reference manual, instructions). A clock that is stopped, or started without a reset, stays as
it is written.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import chain, pairwise
from typing import Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inner_names, lists, nodes

CLOCK_TYPE: Final = "clock"
READ_FUNCTION: Final = "clkread"


def timer_clocks(modules: Sequence[s.Module]) -> frozenset[str]:
    """Lower-case names of the clocks that are timers: of a module, restarted and read only."""
    items = tuple(item for module in modules for item in module.items)
    data = [item for item in items if isinstance(item, s.Data)]
    found = {item.name.lower() for item in data if _is_clock(item)}
    if not found:
        return frozenset()
    named: Counter[str] = Counter()
    meant: Counter[str] = Counter()
    for node in nodes(items):
        match node:
            case s.NameRef(name):
                named[name.lower()] += 1
            case s.FunctionCall() if (clock := read_clock(node)) is not None:
                meant[clock] += 1
    routines = [item for item in items if isinstance(item, s.Routine)]
    started: set[str] = set()
    for body in chain.from_iterable(map(lists, routines)):
        for pair in pairwise(body):
            if (again := restarted_clock(pair)) is not None:
                meant[again.name.lower()] += 2
                started.add(again.name.lower())
    declared = Counter(item.name.lower() for item in data)
    alone = started & found - {name.lower() for name in inner_names(routines)}
    return frozenset(n for n in alone if declared[n] == 1 and named[n] == meant[n])


def restarted_clock(nodes: Sequence[s.Node]) -> s.NameRef | None:
    """The clock that `ClkReset c; ClkStart c;` restarts."""
    match nodes:
        case (
            s.ProcedureCall(str(reset), (s.Positional(s.NameRef(name) as clock, None),)),
            s.ProcedureCall(str(start), (s.Positional(s.NameRef(same), None),)),
        ) if (reset.lower(), start.lower(), name.lower()) == ("clkreset", "clkstart", same.lower()):
            return clock
    return None


def read_clock(node: s.FunctionCall) -> str | None:
    """The lower-case name of the clock that `ClkRead(c)` reads."""
    match node:
        case s.FunctionCall(str(word), (s.Positional(s.NameRef(name), None),)) if (
            word.lower() == READ_FUNCTION
        ):
            return name.lower()
    return None


def _is_clock(item: s.Data) -> bool:
    plain = item.storage == "VAR" and item.scope != "TASK" and item.value is None
    return plain and item.type.lower() == CLOCK_TYPE and not item.dimensions
