"""Rules of values that are written out: strings, quaternions, initial values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from assistant.languages.rapid import rules
from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.checks.scope import Look
from assistant.languages.rapid.gather import literal_number, literal_target
from assistant.languages.rapid.tables import LONGEST_STRING
from assistant.program.diagnostics import Diagnostic

OFF_UNIT: Final = 1e-5
"""Most that the squares of a quaternion may miss 1 by."""

Found = Iterator[Diagnostic]


def strings(look: Look) -> Found:
    for node in look.all(s.StringLiteral):
        if len(node.value) > LONGEST_STRING:
            yield look.finding(rules.LONG_STRING, node, length=len(node.value))


def quaternions(look: Look) -> Found:
    for run in look.all(s.TargetRunNode):
        q = run.run.values[:, 3:7]
        off = np.abs((q * q).sum(axis=1) - 1.0)
        bad = np.flatnonzero((off > OFF_UNIT) & q.any(axis=1))
        if len(bad):
            name = run.run.names.name(int(bad[0]))
            yield look.finding(rules.NOT_UNIT, run, name=name, off=float(off[bad].max()))
    for node in look.all(s.Data):
        if node.type.lower() == "robtarget":
            values = literal_target(node.value)
            if values is not None and any(values[3:7]):
                miss = abs(sum(v * v for v in values[3:7]) - 1.0)
                if miss > OFF_UNIT:
                    yield look.finding(rules.NOT_UNIT, node, name=node.name, off=miss)


def persistents(look: Look) -> Found:
    for node in look.all(s.Data):
        if node.storage == "PERS" and node.value is not None and not literal(node.value):
            yield look.finding(rules.NOT_LITERAL, node, name=node.name)


def literal(value: s.Expression) -> bool:
    if isinstance(value, s.AggregateNode):
        return all(literal(v) for v in value.items)
    return (
        isinstance(value, s.BoolLiteral | s.StringLiteral | s.Placeholder)
        or literal_number(value) is not None
    )
