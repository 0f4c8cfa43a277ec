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
from assistant.languages.rapid.tree.walk import lists, nodes

TYPE: Final = "clock"
READ: Final = "clkread"


def clocks(modules: Sequence[s.Module]) -> frozenset[str]:
    """Lower-case names of the clocks that are timers: of a module, restarted and read only."""
    items = tuple(item for module in modules for item in module.items)
    declared = Counter(
        item.name.lower() for item in items if isinstance(item, s.Data) and _is_clock(item)
    )
    if not declared:
        return frozenset()
    named: Counter[str] = Counter()
    meant: Counter[str] = Counter()
    for node in nodes(items):
        match node:
            case s.NameRef(name):
                named[name.lower()] += 1
            case s.FunctionCall() if (clock := read(node)) is not None:
                meant[clock] += 1
            case s.Data(name=str(name)) | s.ParameterNode(name=str(name)):
                named[name.lower()] += 1
            case s.ForLoop(variable=str(name)):
                named[name.lower()] += 2  # hides it
    routines = (item for item in items if isinstance(item, s.Routine))
    started: set[str] = set()
    for body in chain.from_iterable(map(lists, routines)):
        for pair in pairwise(body):
            if (again := restarted(pair)) is not None:
                meant[again.name.lower()] += 2
                started.add(again.name.lower())
    alone = {name for name, count in declared.items() if count == 1}
    return frozenset(n for n in alone & started if named[n] == meant[n] + 1)


def restarted(nodes: Sequence[s.Node]) -> s.NameRef | None:
    """The clock that `ClkReset c; ClkStart c;` restarts."""
    match nodes:
        case (
            s.ProcedureCall(str(reset), (s.Positional(s.NameRef(name) as clock, None),)),
            s.ProcedureCall(str(start), (s.Positional(s.NameRef(same), None),)),
        ) if (reset.lower(), start.lower(), name.lower()) == ("clkreset", "clkstart", same.lower()):
            return clock
    return None


def read(node: s.FunctionCall) -> str | None:
    """The lower-case name of the clock that `ClkRead(c)` reads."""
    match node:
        case s.FunctionCall(str(word), (s.Positional(s.NameRef(name), None),)) if (
            word.lower() == READ
        ):
            return name.lower()
    return None


def _is_clock(item: s.Data) -> bool:
    plain = item.storage == "VAR" and item.scope != "TASK" and item.value is None
    return plain and item.type.lower() == TYPE and not item.dimensions
