"""Names that nothing declares, in modules whose header says that they are whole programs.

A module that people wrote may use data and signals of the controller or of other modules; one
that was compiled has everything in it, its signals in the header.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any, Final

import numpy as np

from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.gather import split
from assistant.languages.rapid.header import opening
from assistant.languages.rapid.runs import MOVES, Names
from assistant.languages.rapid.standard import INSTRUCTIONS, OF_OPTIONS
from assistant.languages.rapid.tables import GRIPPER_SIGNAL, PREDEFINED

WRITTEN: Final = frozenset(
    """
    accset pulsedo setao setdo setgo tpwrite velset waitdi waitdo waitgi waitgo waittime waituntil
    """.split()  # noqa: SIM905
)
_MOVES: Final = frozenset(word.lower() for word in (*MOVES, "MoveAbsJ"))
_AS_IS: Final = (INSTRUCTIONS | OF_OPTIONS) - WRITTEN - _MOVES
"""Instructions that the pseudo-program has no word for: their data may be of other modules."""
_OF_MOTION: Final = 3
"""Last arguments of a move: its speed, zone and tool, which have rules of their own."""
_HAND: Final = re.compile(GRIPPER_SIGNAL.format(hand="[1-9][0-9]?"), re.IGNORECASE)


class Declared:
    """What the modules of a program declare together."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        self.names = set(PREDEFINED)
        self.runs: list[Names] = []
        for module in modules:
            header = opening(module)
            for name in header.signals:
                self.names.add(name.lower())
            signals = {n.lower() for n in header.signals}
            self.names |= {n for n, o in header.names.items() if o.lower() in signals}
            for item in module.items:
                if isinstance(item, s.TargetRunNode):
                    self.runs.append(item.run.names)
                elif isinstance(item, s.Data | s.Routine | s.Record | s.Alias):
                    self.names.add(item.name.lower())

    def __contains__(self, name: str) -> bool:
        low = name.lower()
        if low in self.names or _HAND.fullmatch(name):
            return True
        found = low.isascii() and any(_holds(run, low) for run in self.runs)
        if found:
            self.names.add(low)
        return found


def _holds(names: Names, name: str) -> bool:
    stem, number = split(name)
    rows = [i for i, text in enumerate(names.stems) if text.lower() == stem]
    return bool((np.isin(names.stem, rows) & (names.number == number)).any()) if rows else False


def undeclared(module: s.Module, declared: Declared) -> Iterator[s.NameRef]:
    """The first use of each name that nothing declares; none in a module that people wrote."""
    header = opening(module)
    if not (header.program or header.unit):
        return
    seen: set[str] = set()
    for item in module.items:
        own: frozenset[str] = frozenset()
        if isinstance(item, s.Routine):
            given = (q for g in item.parameters for q in g.alternatives)
            own = frozenset(q.name.lower() for q in given if isinstance(q, s.ParameterNode))
            own |= {d.name.lower() for d in item.body if isinstance(d, s.Data)}
        for name in _used(item, own):
            if name.name not in declared and name.name.lower() not in seen:
                seen.add(name.name.lower())
                yield name


def _used(node: Any, own: frozenset[str]) -> Iterator[s.NameRef]:
    """Names of values in a tree that are not those of its routine or of loops around them."""
    match node:
        case tuple():
            for item in node:
                yield from _used(item, own)
        case s.NameRef(name):
            if name.lower() not in own:
                yield node
        case s.ForLoop(variable, first, last, step, body):
            yield from _used((first, last, step), own)
            yield from _used(body, own | {variable.lower()})
        case s.ProcedureCall(str(name), arguments) if name.lower() in _MOVES:
            plain = tuple(a for a in arguments if isinstance(a, s.Positional))
            yield from _used(plain[:-_OF_MOTION], own)
        case s.ProcedureCall(str(name)) if name.lower() in _AS_IS:
            pass
        case s.Option(name) if name.lower() in ("tool", "wobj"):
            pass
        case s.Node():
            for f in fields(node):
                yield from _used(getattr(node, f.name), own)
