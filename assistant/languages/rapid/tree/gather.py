"""Neighbouring plain declarations and moves as one columnar node, however they came about.

The reader of runs and the grammar must give the same tree for the same lines, and a built
tree the one that its text is read as; so all three go through `gathered`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any, Final

import numpy as np

from assistant.languages.rapid.tables.words import LONGEST_NAME
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import (
    CIRCULAR,
    FEWEST,
    MOVES,
    PARTS,
    MotionNames,
    MoveRun,
    TargetRun,
)
from assistant.languages.runs import gathering as alike
from assistant.languages.runs.columns import Entries, Run, joined
from assistant.languages.runs.names import Names
from assistant.program.diagnostics import Span

_PLAIN: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def gathered(nodes: Iterable[Any]) -> tuple[Any, ...]:
    """The nodes, with every stretch of at least FEWEST plain rows as one node."""
    listed = list(nodes)
    if listed and isinstance(listed[0], s.CommentLine) and listed[0].trailing:
        listed[0] = replace(listed[0], trailing=False)
    commented = (isinstance(n, s.CommentLine) and n.trailing for n in (*listed[1:], None))
    kinds = (
        [None if said else _kind(node) for node, said in zip(listed, commented, strict=True)]
        if listed
        else []
    )
    return tuple(chain.from_iterable(alike.gathered(listed, kinds, _run, FEWEST, _joined)))


def _run(node: Any) -> Run | None:
    return node.run if isinstance(node, s.TargetRunNode | s.MoveRunNode) else None


def _kind(node: Any) -> object:
    """What a node may be joined with: equal and not None."""
    if isinstance(node, s.TargetRunNode):
        return "targets", node.scope
    if isinstance(node, s.MoveRunNode):
        return "moves" if node.run.values is None else "inline moves"
    if isinstance(node, s.Data):
        return ("targets", node.scope) if target_values(node) is not None else None
    if isinstance(node, s.ProcedureCall):
        if plain_move(node) is not None:
            return "moves"
        return "inline moves" if inline_move(node) is not None else None
    return None


def _joined(stretch: Sequence[Any]) -> s.TargetRunNode | s.MoveRunNode:
    first, last = stretch[0], stretch[-1]
    span = Span(first.span.start, last.span.end) if first.span and last.span else None
    if isinstance(first, s.Data | s.TargetRunNode):
        targets = joined([_as_targets(node) for node in stretch])
        return s.TargetRunNode(first.scope, targets, span=span)
    return s.MoveRunNode(joined([_as_moves(node) for node in stretch]), span=span)


def target_values(node: s.Data) -> list[float] | None:
    """The 17 numbers of a plain declared robtarget, None for any other declaration."""
    if (
        node.storage != "CONST"
        or node.type != "robtarget"
        or node.scope not in ("", "LOCAL")
        or node.dimensions
        or not _plain_name(node.name)
    ):
        return None
    return literal_target(node.value)


def literal_target(value: s.Expression | None) -> list[float] | None:
    """The 17 numbers of a robtarget that is written out, None for anything else."""
    if not isinstance(value, s.AggregateNode) or len(value.items) != len(PARTS):
        return None
    numbers: list[float] = []
    for part, (start, stop) in zip(value.items, PARTS, strict=True):
        if not isinstance(part, s.AggregateNode) or len(part.items) != stop - start:
            return None
        for item in part.items:
            if (number := literal_number(item)) is None or not np.isfinite(number):
                return None
            numbers.append(number)
    return numbers


def literal_number(node: s.Expression) -> float | int | None:
    """A signed decimal number, None for anything else."""
    if isinstance(node, s.Prefix) and isinstance(node.operand, s.NumberLiteral):
        value = literal_number(node.operand)
        if value is None or node.operator == "NOT":
            return None
        return -value if node.operator == "-" else value
    if not isinstance(node, s.NumberLiteral):
        return None
    text = node.text.lower()
    if text[:2] in BASES:
        return int(text[2:], BASES[text[:2]])
    return int(text) if text.isdigit() and len(text) < 16 else float(text)


BASES: Final = {"0x": 16, "0o": 8, "0b": 2, "0d": 10}


def _plain_name(name: str) -> bool:
    return len(name) <= LONGEST_NAME and _PLAIN.fullmatch(name) is not None


def plain_move(node: s.ProcedureCall) -> tuple[int, list[str], MotionNames] | None:
    r"""Kind, names of via and target, and motion of `MoveL p,v,z,t\WObj:=w;`, else None."""
    if node.name not in MOVES:
        return None
    kind = MOVES.index(str(node.name))
    taken = _motion(node, 2 if kind == CIRCULAR else 1)
    if taken is None:
        return None
    points, motion = taken
    names = [p.name for p in points if isinstance(p, s.NameRef) and _plain_name(p.name)]
    return (kind, names, motion) if len(names) == len(points) else None


def inline_move(node: s.ProcedureCall) -> tuple[int, list[float], MotionNames] | None:
    r"""Kind, the 17 numbers of the target and motion of `MoveL [[…],…],v,z,t;`, else None."""
    if node.name not in MOVES[:CIRCULAR]:
        return None
    taken = _motion(node, 1)
    values = literal_target(taken[0][0]) if taken is not None else None
    if taken is None or values is None:
        return None
    return MOVES.index(str(node.name)), values, taken[1]


def _motion(
    node: s.ProcedureCall, points: int
) -> tuple[Sequence[s.Expression], MotionNames] | None:
    """What a move goes through and the names behind it; None if there is more or less."""
    given = node.arguments
    frame = ""
    if given and isinstance(given[-1], s.Option) and given[-1].name == "WObj":
        value = given[-1].value
        if not isinstance(value, s.NameRef) or not _plain_name(value.name):
            return None
        frame, given = value.name, given[:-1]
    plain = [a.value for a in given if isinstance(a, s.Positional) and a.name is None]
    words = [v.name for v in plain[points:] if isinstance(v, s.NameRef) and _plain_name(v.name)]
    if len(plain) != len(given) or len(plain) != points + 3 or len(words) != 3:
        return None
    speed, zone, tool = words
    return plain[:points], MotionNames(speed, zone, tool, frame)


def _as_targets(node: s.Data | s.TargetRunNode) -> TargetRun:
    if isinstance(node, s.TargetRunNode):
        return node.run
    values = target_values(node)
    assert values is not None
    return TargetRun(Names.of([node.name]), np.array([values], dtype=np.float64))


def _as_moves(node: s.ProcedureCall | s.MoveRunNode) -> MoveRun:
    if isinstance(node, s.MoveRunNode):
        return node.run
    values = None
    if (inline := inline_move(node)) is not None:
        kind, numbers, motion = inline
        names: list[str] = []
        values = np.array([numbers], dtype=np.float64)
    else:
        plain = plain_move(node)
        assert plain is not None
        kind, names, motion = plain
    return MoveRun(
        np.array([kind], dtype=np.uint8),
        Names.of(names[-1:]) if names else Names.none(1),
        Names.of(names[:-1]) if names[:-1] else Names.none(1),
        Entries((motion,), np.zeros(1, dtype=np.int32)),
        values,
    )
