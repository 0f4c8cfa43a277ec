"""Rules of `confdata` in targets that are written out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.checks.plain_rules import NO_CFX, NO_QUADRANTS
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_target
from assistant.program.arrays import Floats

MOST: Final = 127
"""Quadrants are counted in turns of an axis, of which no arm has 32."""
SHAPES: Final = 8
"""Values of cfx of an arm with six axes, from 0."""
CODES: Final = (10, 9999)
"""An arm with seven axes has a code of up to four digits; those of one are as above."""


def configurations(look: Look) -> Found:
    """Quadrants and cfx are whole numbers, and cfx is one that an arm of six axes has."""
    for run, values, name in look.targets:
        yield from _rows(look, run, values[:, 7:11], name)
    for call in look.all(s.ProcedureCall):
        for argument in call.arguments:
            if isinstance(argument, s.Positional):
                yield from _written_out(look, argument.value, str(call.name))
    for node in look.all(s.Data):
        if node.value is not None and node.type.lower() == "robtarget":
            yield from _written_out(look, node.value, node.name)


def _written_out(look: Look, value: s.Expression, name: str) -> Found:
    """A target, or those of an array, at its own place."""
    numbers = literal_target(value)
    if numbers is not None:
        yield from _rows(look, value, np.array([numbers[7:11]]), lambda _: name)
    elif isinstance(value, s.AggregateNode):
        for item in value.items:
            if isinstance(item, s.AggregateNode):
                yield from _written_out(look, item, name)


def _rows(look: Look, node: s.Node, confdata: Floats, name: Callable[[int], str]) -> Found:
    """confdata: (n, 4) of the rows of a run. name: of a row."""
    whole = np.isfinite(confdata) & (confdata == np.round(confdata))
    quadrants = (whole[:, :3] & (np.abs(confdata[:, :3]) <= MOST)).all(axis=1)
    odd = ~(quadrants & whole[:, 3])
    cfx = confdata[:, 3]
    known = ((cfx >= 0) & (cfx < SHAPES)) | ((cfx >= CODES[0]) & (cfx <= CODES[1]))
    for faults, rule in ((odd, NO_QUADRANTS), (~odd & ~known, NO_CFX)):
        rows = np.flatnonzero(faults)
        if len(rows):
            numbers = [f"{value:g}" for value in confdata[rows[0]]]
            listed = ", ".join(numbers)
            yield from look.at_rows(rule, node, rows, name, numbers=listed, cfx=numbers[-1])
