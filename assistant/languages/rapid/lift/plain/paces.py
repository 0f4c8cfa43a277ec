"""Moves in columns as moves one by one, whose speeds and zones may be worked out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from assistant.languages.rapid.lift.plain.layouts import SPEED_AND_ZONE
from assistant.languages.rapid.lift.plain.scopes import Datum
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import CIRCULAR, MOVES, PARTS, MoveRun
from assistant.languages.rapid.tree.walk import nodes, root


def changes_speeds_or_zones(files: Sequence[s.File]) -> bool:
    """Whether a program assigns to a speed or zone that is one value."""
    written = {
        target.name.lower()
        for file in files
        for node in nodes(file.modules)
        if isinstance(node, s.Assignment) and (target := root(node.target)) is not None
    }
    return any(
        isinstance(node, s.Data)
        and node.type.lower() in SPEED_AND_ZONE
        and node.name.lower() in written
        for file in files
        for node in nodes(file.modules)
    )


def has_parted_settings(run: MoveRun, find: Callable[[str], Datum | None]) -> bool:
    """Whether moves in columns name a speed or zone that is taken apart. find: of data by name."""
    named = {name for how in run.motions.table for name in (how.speed, how.zone)}
    return any(found is not None and found.names for found in map(find, named))


def single_moves(run: MoveRun) -> Iterator[s.ProcedureCall]:
    """The moves of a run."""
    for row in range(len(run)):
        kind, how = int(run.kinds[row]), run.motions[row]
        named = [run.vias.name(row)] if kind == CIRCULAR else []
        named += [] if run.values is not None else [run.names.name(row)]
        given: list[s.Expression] = [s.NameRef(name) for name in named]
        if run.values is not None:
            given.append(_target_literal(run.values[row].tolist()))
        given += [s.NameRef(name) for name in (how.speed, how.zone, how.tool)]
        arguments: list[s.Argument] = [s.Positional(one) for one in given]
        if how.frame:
            arguments.append(s.Option("WObj", s.NameRef(how.frame)))
        yield s.ProcedureCall(MOVES[kind], tuple(arguments))


def _target_literal(values: Sequence[float]) -> s.AggregateNode:
    parts = (values[start:stop] for start, stop in PARTS)
    return s.AggregateNode(
        tuple(s.AggregateNode(tuple(map(_number_literal, part))) for part in parts)
    )


def _number_literal(value: float) -> s.Expression:
    written = s.NumberLiteral(repr(abs(value)))
    return s.Prefix("-", written) if value < 0 else written
