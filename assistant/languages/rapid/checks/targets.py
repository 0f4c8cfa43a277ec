"""Rules of what is written out in targets, frames, tools and loads: quaternions, `confdata`."""

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
MOST: Final = 127
"""Quadrants are counted in turns of an axis, of which no arm has 32."""
SHAPES: Final = 8
"""Values of cfx of an arm with six axes, from 0."""
CODES: Final = (10, 9999)
"""An arm with seven axes has a code of up to four digits; those of one are as above."""

Name = Callable[[int], str]
"""What a row of a run is called."""


def quaternions(look: Look) -> Found:
    """They have unit length; all zero is a place holder that no robot can move to."""
    for node, values, name in look.once(_targets):
        yield from _lengths(look, node, values[:, 3:7], name)
    types = look.once(Types)
    for data in look.all(s.Data):
        if isinstance(data.value, s.AggregateNode):
            depth = len(data.dimensions)
            target = data.storage == "CONST" and data.type.lower() == "robtarget"
            for place, numbers in _orientations(types, data.value, data.type, depth):
                if target or any(numbers):
                    yield from _lengths(look, place, np.array([numbers]), _always(data.name))


def configurations(look: Look) -> Found:
    """Quadrants and cfx are whole numbers, and cfx is one that an arm of six axes has."""
    for node, values, name in look.once(_targets):
        yield from _quadrants(look, node, values[:, 7:11], name)
    for data in look.all(s.Data):
        if data.value is not None and data.type.lower() == "robtarget":
            for node, values in _written_out(data.value):
                yield from _quadrants(look, node, values[:, 7:11], _always(data.name))


def _targets(look: Look) -> list[tuple[s.Node, Floats, Name]]:
    """Targets in runs, and those that moves are given: values (n, 17), and what a row is called."""
    found = list(look.targets)
    for call in look.all(s.ProcedureCall):
        for argument in call.arguments:
            if isinstance(argument, s.Positional):
                of_call = _written_out(argument.value)
                found += [(node, values, _always(str(call.name))) for node, values in of_call]
    return found


def _always(name: str) -> Name:
    return lambda _: name


def _written_out(value: s.Expression) -> Iterator[tuple[s.Node, Floats]]:
    """A target, or those of an array, at its own place: (1, 17)."""
    numbers = literal_target(value)
    if numbers is not None:
        yield value, np.array([numbers])
    elif isinstance(value, s.AggregateNode):
        for item in value.items:
            if isinstance(item, s.AggregateNode):
                yield from _written_out(item)


def _lengths(look: Look, node: s.Node, q: Floats, name: Name) -> Found:
    """q: (n, 4) of the rows of a run."""
    off = np.abs((q * q).sum(axis=1) - 1.0)
    zero = ~q.any(axis=1)
    bad = np.flatnonzero((off > OFF_UNIT) & ~zero)
    if len(bad):
        row = int(bad[off[bad].argmax()])
        words = {"name": name(row), "off": float(off[row])}
        severity = Severity.ERROR if off[row] > USELESS else Severity.WARNING
        yield look.finding(rules.NOT_UNIT, node, row=row, severity=severity, **words)
    yield from look.at_rows(plain_rules.NO_ORIENTATION, node, np.flatnonzero(zero), name)


def _quadrants(look: Look, node: s.Node, confdata: Floats, name: Name) -> Found:
    """confdata: (n, 4) of the rows of a run."""
    whole = np.isfinite(confdata) & (confdata == np.round(confdata))
    quadrants = (whole[:, :3] & (np.abs(confdata[:, :3]) <= MOST)).all(axis=1)
    odd = ~(quadrants & whole[:, 3])
    cfx = confdata[:, 3]
    known = ((cfx >= 0) & (cfx < SHAPES)) | ((cfx >= CODES[0]) & (cfx <= CODES[1]))
    for faults, rule in ((odd, plain_rules.NO_QUADRANTS), (~odd & ~known, plain_rules.NO_CFX)):
        rows = np.flatnonzero(faults)
        if len(rows):
            numbers = [f"{value:g}" for value in confdata[rows[0]]]
            words = {"numbers": ", ".join(numbers), "cfx": numbers[-1]}
            yield from look.at_rows(rule, node, rows, name, **words)


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
