"""Rules of quaternions in declared targets, frames, tools and loads."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

import numpy as np

from assistant.languages.rapid import rules
from assistant.languages.rapid.checks import plain_rules
from assistant.languages.rapid.checks.kinds import Types
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number, literal_target
from assistant.languages.rapid.tree.runs import MOVES
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Diagnostic, Severity

OFF_UNIT: Final = 1e-5
"""Most that the squares of a quaternion may miss 1 by; beyond it NOrient has to mend it."""
USELESS: Final = 1e-3
"""Beyond this it is no rounded quaternion: four decimals are off by 2e-4 at most."""

Found = Iterator[Diagnostic]


def quaternions(look: Look) -> Found:
    """They have unit length; all zero is a place holder that no robot can move to."""
    for run in look.all(s.TargetRunNode):
        yield from _rows(look, run, run.run.values[:, 3:7], run.run.names.name)
    for moves in look.all(s.MoveRunNode):
        if moves.run.values is not None:
            yield from _rows(look, moves, moves.run.values[:, 3:7], partial(_word, moves))
    for call in look.all(s.ProcedureCall):
        yield from _call(look, call)
    types = Types(look)
    for node in look.all(s.Data):
        if isinstance(node.value, s.AggregateNode):
            depth = len(node.dimensions)
            for place, numbers in _orientations(types, node.value, node.type, depth):
                off = abs(sum(v * v for v in numbers) - 1.0)
                if not any(numbers):
                    if node.storage == "CONST" and node.type.lower() == "robtarget":
                        name = node.name
                        yield look.finding(plain_rules.NO_ORIENTATION, place, name=name, more="")
                elif off > OFF_UNIT:
                    yield look.finding(
                        rules.NOT_UNIT, place, severity=_severity(off), name=node.name, off=off
                    )


def _word(moves: s.MoveRunNode, row: int) -> str:
    return MOVES[int(moves.run.kinds[row])]


def _rows(look: Look, node: s.Node, q: Floats, name: Callable[[int], str]) -> Found:
    """q: (n, 4) of the rows of a run. name: of a row."""
    off = np.abs((q * q).sum(axis=1) - 1.0)
    zero = ~q.any(axis=1)
    bad = np.flatnonzero((off > OFF_UNIT) & ~zero)
    if len(bad):
        worst = int(bad[off[bad].argmax()])
        miss = float(off[worst])
        severity = _severity(miss)
        yield look.finding(
            rules.NOT_UNIT, node, row=worst, severity=severity, name=name(worst), off=miss
        )
    if zero.any():
        rows = np.flatnonzero(zero)
        more = f", as of {len(rows) - 1} more" if len(rows) > 1 else ""
        first = int(rows[0])
        yield look.finding(plain_rules.NO_ORIENTATION, node, row=first, name=name(first), more=more)


def _call(look: Look, call: s.ProcedureCall) -> Found:
    """Targets that are written out in a call."""
    for argument in call.arguments:
        numbers = literal_target(argument.value) if isinstance(argument, s.Positional) else None
        if numbers is not None:
            q = np.array([numbers[3:7]])
            yield from _rows(look, argument, q, lambda _: str(call.name))


def _severity(off: float) -> Severity:
    return Severity.ERROR if off > USELESS else Severity.WARNING


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
