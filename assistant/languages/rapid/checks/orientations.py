"""Rules of quaternions in declared targets, frames, tools and loads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from assistant.languages.checks.registry import Found
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks import plain_rules
from assistant.languages.rapid.checks.kinds import Types
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number, literal_target
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Severity

OFF_UNIT: Final = 1e-5
"""Most that the squares of a quaternion may miss 1 by; beyond it NOrient has to mend it."""
USELESS: Final = 1e-3
"""Beyond this it is no rounded quaternion: four decimals are off by 2e-4 at most."""


def quaternions(look: Look) -> Found:
    """They have unit length; all zero is a place holder that no robot can move to."""
    for run, values, name in look.targets:
        yield from _rows(look, run, values[:, 3:7], name)
    for call in look.all(s.ProcedureCall):
        for argument in call.arguments:
            numbers = literal_target(argument.value) if isinstance(argument, s.Positional) else None
            if numbers is not None:
                yield from _rows(look, argument, np.array([numbers[3:7]]), _always(str(call.name)))
    types = look.once(Types)
    for node in look.all(s.Data):
        if isinstance(node.value, s.AggregateNode):
            depth = len(node.dimensions)
            target = node.storage == "CONST" and node.type.lower() == "robtarget"
            for place, numbers in _orientations(types, node.value, node.type, depth):
                if target or any(numbers):
                    yield from _rows(look, place, np.array([numbers]), _always(node.name))


def _always(name: str) -> Callable[[int], str]:
    return lambda _: name


def _rows(look: Look, node: s.Node, q: Floats, name: Callable[[int], str]) -> Found:
    """q: (n, 4) of the rows of a run. name: of a row."""
    off = np.abs((q * q).sum(axis=1) - 1.0)
    zero = ~q.any(axis=1)
    bad = np.flatnonzero((off > OFF_UNIT) & ~zero)
    if len(bad):
        worst = int(bad[off[bad].argmax()])
        miss = float(off[worst])
        severity = Severity.ERROR if miss > USELESS else Severity.WARNING
        yield look.finding(
            rules.NOT_UNIT, node, row=worst, severity=severity, name=name(worst), off=miss
        )
    yield from look.at_rows(plain_rules.NO_ORIENTATION, node, np.flatnonzero(zero), name)


def _orientations(
    types: Types, value: s.AggregateNode, type: str, depth: int
) -> Iterator[tuple[s.AggregateNode, list[float]]]:
    """Every orientation that is written out in a value of a type, arrays `depth` levels deep."""
    base = types.base(type) or ""
    if depth:
        inner = [(part, type, depth - 1) for part in value.items]
    elif base == "orient":
        numbers = [literal_number(item) for item in value.items]
        known = [float(n) for n in numbers if n is not None]
        if len(known) == len(numbers) == 4:
            yield value, known
        return
    else:
        components = types.components(base) or {}
        if len(components) != len(value.items):
            return
        inner = [(part, of, 0) for part, of in zip(value.items, components.values(), strict=True)]
    for part, of, left in inner:
        if isinstance(part, s.AggregateNode):
            yield from _orientations(types, part, of, left)
