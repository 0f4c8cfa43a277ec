"""Runs of declared targets and of moves through them as paths, column by column."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows
from assistant.base.diagnostics import span_over
from assistant.languages.rapid.lift.data import DataLift
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.runs import CIRCULAR, PARTS, TargetRun
from assistant.languages.rapid.tree.walk import nodes
from assistant.languages.records import target
from assistant.languages.runs.columns import Names, joined_runs
from assistant.languages.runs.paths import (
    NamedTargets,
    PathRows,
    Stretch,
    setting_columns,
    values_at,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Target
from assistant.program.motion import UNSTATED, Kind, Path
from assistant.program.program import TakenNames, Variable, identifier
from assistant.robots.configurations import from_confdata

_NAMED_ITEMS: Final = (s.Data, s.Routine, s.Record, s.Alias)
_MOVE_KINDS: Final = {0: "joint", 1: "linear"}
_PATH_KINDS: Final = np.array([Kind.JOINT, Kind.LINEAR, Kind.END], dtype=np.uint8)

MOST_WRITTEN: Final = 100
"""Moves in a row to targets that are written out; more are a path, whose targets have names."""

Motions = Callable[[str, str, str, str], p.Motion]


class PathLift:
    """Which targets moves go through, and how often anything names them."""

    def __init__(
        self, modules: Sequence[s.Module], data: DataLift, original: Callable[[str], str]
    ) -> None:
        self.data, self.original = data, original
        runs = [i.run for m in modules for i in m.items if isinstance(i, s.TargetRunNode)]
        self.table = joined_runs([TargetRun(Names.none(0), np.empty((0, PARTS[-1][1]))), *runs])
        self.known = NamedTargets(self.table.names)
        self._taken = TakenNames(
            i.name for m in modules for i in m.items if isinstance(i, _NAMED_ITEMS)
        )
        seen = list(nodes(tuple(modules))) if runs else []
        named = (node.name for node in seen if isinstance(node, s.NameRef))
        self.known.count(Names.of([name for name in named if name.isascii()]))
        for run in (node.run for node in seen if isinstance(node, s.MoveRunNode)):
            self.known.count(run.names)
            self.known.count(run.vias)

    def statements(self, node: s.MoveRunNode, motion: Motions) -> Iterator[p.Statement]:
        run, index, spans = node.run, node.run.motions.index, node.row_span
        motions = [motion(m.speed, m.zone, m.tool, m.frame) for m in run.motions.table]
        if run.values is not None and len(run) > MOST_WRITTEN and _have_orientations(run.values):
            name = identifier("written", self._taken)  # the program gives these targets no names
            self._taken.add(name)
            whole = _path(name, run.values, run.kinds, index, motions)
            yield p.Follow(replace(whole, places=node.rows), span=node.span)
            return
        if run.values is not None:
            each = zip(run.values.tolist(), index, run.kinds, strict=True)
            for at, (values, row, kind) in enumerate(each):
                word: Any = _MOVE_KINDS[int(kind)]
                yield p.Move(word, _target_value(values), motions[row], span=spans(at))
            return
        rows = PathRows(run.names, run.vias, run.kinds == CIRCULAR, _PATH_KINDS[run.kinds])
        places, alone = self.known.alone(rows.names)
        for part in rows.stretches(alone):
            path = self._path(rows, part, places, index, motions) if part.numbered else None
            moves = rows.moves[part.start : part.stop]
            if path is not None:
                span = span_over(spans(int(moves[0])), spans(int(moves[-1])))
                yield p.Follow(replace(path, places=_relative_spans(node, moves)), span=span)
                continue
            made = rows.one_by_one(part, self.original, lambda move: motions[index[move]])
            for move, one in zip(np.unique(moves).tolist(), made, strict=True):
                yield replace(one, span=spans(move))

    def _path(
        self,
        rows: PathRows,
        part: Stretch,
        places: Rows,
        index: NDArray[np.int32],
        motions: Sequence[p.Motion],
    ) -> Path | None:
        taken = slice(part.start, part.stop)
        at = places[taken]
        stem = rows.names.stems[rows.names.stem[part.start]].decode("ascii")
        if not stem.endswith("_") or len(stem) < 2:
            return None
        values = values_at(at, self.table.values)
        if not _have_orientations(values):
            return None
        self.known.taken[at] = True
        name = self.original(stem[:-1])
        return _path(name, values, rows.kinds[taken], index[rows.moves[taken]], motions)

    def targets(self) -> dict[str, Target]:
        """The targets that are in no path."""
        left = dict(self.data.targets)
        for row in np.flatnonzero(~self.known.taken):
            name = self.original(self.table.names.name(int(row)))
            values = [float(v) for v in self.table.values[row]]
            if any(values[3:7]):
                left[name] = target(values)
                continue
            self.data.variables[name] = Variable("position", _target_value(values), (), "constant")
        return left


def _relative_spans(node: s.MoveRunNode, moves: Rows) -> Rows | None:
    """Spans of some moves of a run, counted from the first of them."""
    return None if node.rows is None else node.rows[moves] - node.rows[moves[0], 0]


def _target_value(values: Sequence[float]) -> e.Expression:
    """A robtarget as it stands in an expression; one without orientation is mere numbers."""
    if any(values[3:7]):
        return e.TargetValue(target(values))
    return e.Aggregate(tuple(e.Aggregate(tuple(map(e.Number, values[a:b]))) for a, b in PARTS))


def _have_orientations(values: Floats) -> bool:
    """Whether every target has an orientation at all."""
    return bool(values[:, 3:7].any(axis=1).all())


def _path(
    name: str,
    values: Floats,
    kinds: NDArray[np.uint8],
    motion: NDArray[np.int32],
    motions: Sequence[p.Motion],
) -> Path:
    """values: (n, 17) as of a TargetRun. motion: (n,) rows of motions."""
    return Path.of(
        name,
        values[:, 0:3],
        rotations.canonical(values[:, 3:7]),
        kinds=kinds,
        configurations=configurations(values[:, 7:11]),
        external=np.where(values[:, 11:17] >= UNUSED, np.nan, values[:, 11:17]),
        **setting_columns(motions, motion),
    )


def configurations(confdata: Floats) -> NDArray[np.int8]:
    """Neutral columns; unstated where confdata are no small whole numbers."""
    sane = ((np.abs(confdata) <= 127) & (confdata == np.rint(confdata))).all(axis=1)
    columns = from_confdata(np.where(sane[:, None], confdata, 0))
    columns[~sane, 0] = UNSTATED
    return columns
