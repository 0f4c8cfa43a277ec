"""Runs of declared targets and of moves through them as paths, column by column."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.languages.rapid.lift.data import DataLift
from assistant.languages.rapid.lift.expressions import target
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import join_names, names_of
from assistant.languages.rapid.tree.runs import (
    CIRCULAR,
    JOINT,
    PARTS,
    MoveRun,
    Names,
    TargetRun,
    concatenate,
)
from assistant.languages.rapid.tree.walk import nodes
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.arrays import Floats, Rows, Truths
from assistant.program.geometry import Target
from assistant.program.path import UNSTATED, Kind, Path
from assistant.program.program import Variable, identifier
from assistant.robots.configurations import from_confdata

_NAMED: Final = (s.Data, s.Routine, s.Record, s.Alias)
_KIND: Final = {0: "joint", 1: "linear"}

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
        self.table: TargetRun = concatenate(runs)
        self.uses = np.zeros(len(self.table), dtype=np.int64)
        self.gone = np.zeros(len(self.table), dtype=bool)
        self._index = _Index(self.table.names)
        self._taken = {i.name for m in modules for i in m.items if isinstance(i, _NAMED)}
        if not runs:
            return
        names: list[str] = []
        for node in nodes(tuple(modules)):
            if isinstance(node, s.NameRef):
                names.append(node.name)
            elif isinstance(node, s.MoveRunNode):
                for column in (node.run.names, node.run.vias):
                    self._count(self._index.rows(column))
        for name in names:
            self._count(self._index.row(name))

    def _count(self, rows: Rows) -> None:
        found = rows[rows >= 0]
        self.uses += np.bincount(found, minlength=len(self.uses))

    def statements(self, node: s.MoveRunNode, motion: Motions) -> Iterator[p.Statement]:
        run = node.run
        motions = [motion(m.speed, m.zone, m.tool, m.frame) for m in run.motions]
        if run.values is not None and len(run) > MOST_WRITTEN and _turned(run.values):
            yield p.Follow(self._written_path(run, run.values, motions), span=node.span)
            return
        if run.values is not None:
            for values, row, kind in zip(run.values.tolist(), run.motion, run.kinds, strict=True):
                word: Any = _KIND[int(kind)]
                yield p.Move(word, _written(values), motions[row], span=node.span)
            return
        rows = _Rows(run)
        places = self._index.rows(rows.names)
        alone = np.zeros(len(places), dtype=bool)
        alone[places >= 0] = self.uses[places[places >= 0]] == 1
        for first, last in rows.sequences(alone):
            path = None
            if first.number == 1:
                path = self._path(rows, places, first.start, last, motions)
            if path is not None:
                yield p.Follow(path, span=node.span)
            else:
                yield from self._moves(rows, first.start, last, motions, node)

    def _path(
        self, rows: _Rows, places: Rows, start: int, stop: int, motions: Sequence[p.Motion]
    ) -> Path | None:
        at = places[start:stop]
        stem = rows.names.stems[rows.names.stem[start]].decode("ascii")
        if stop - start < 2 or not stem.endswith("_") or len(stem) < 2:
            return None
        values = self.table.values[at[0] : at[0] + len(at)]
        if not np.array_equal(at, np.arange(at[0], at[0] + len(at))):
            values = self.table.values[at]
        if not _turned(values):
            return None
        self.gone[at] = True
        kinds, motion = rows.kinds[start:stop], rows.motion[start:stop]
        return _path(self.original(stem[:-1]), values, kinds, motion, motions)

    def _written_path(self, run: MoveRun, values: Floats, motions: Sequence[p.Motion]) -> Path:
        """A path of targets that the program gives no names."""
        name = identifier("written", self._taken)
        self._taken.add(name)
        return _path(name, values, run.kinds, run.motion, motions)

    def _moves(
        self,
        rows: _Rows,
        start: int,
        stop: int,
        motions: Sequence[p.Motion],
        node: s.MoveRunNode,
    ) -> Iterator[p.Statement]:
        via: e.Name | None = None
        for row in range(start, stop):
            name = e.Name(self.original(rows.names.name(row)))
            motion, kind = motions[rows.motion[row]], rows.kinds[row]
            if kind == Kind.VIA:
                via = name
            elif via is not None:
                yield p.MoveCircular(via, name, motion, span=node.span)
                via = None
            else:
                word: Any = "joint" if kind == Kind.JOINT else "linear"
                yield p.Move(word, name, motion, span=node.span)

    def targets(self) -> dict[str, Target]:
        """The targets that are in no path."""
        left = dict(self.data.targets)
        for row in np.flatnonzero(~self.gone):
            name = self.original(self.table.names.name(int(row)))
            values = [float(v) for v in self.table.values[row]]
            if any(values[3:7]):
                left[name] = target(values)
                continue
            self.data.variables[name] = Variable("position", _written(values), (), "constant")
        return left


def _written(values: Sequence[float]) -> e.Expression:
    """A robtarget as it stands in an expression; one without orientation is mere numbers."""
    if any(values[3:7]):
        return e.TargetValue(target(values))
    return e.Aggregate(tuple(e.Aggregate(tuple(map(e.Number, values[a:b]))) for a, b in PARTS))


def _turned(values: Floats) -> bool:
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
    columns: dict[str, Any] = {}
    for column in ("speed", "blend", "tool", "frame"):
        entries: dict[Any, int] = {}
        index = [entries.setdefault(getattr(m, column), len(entries)) for m in motions]
        columns[column] = np.array(index, dtype=np.int32)[motion]
        columns[column + "s"] = tuple(entries)
    return Path.of(
        name,
        values[:, 0:3],
        rotations.canonical(values[:, 3:7]),
        kinds=kinds,
        configurations=configurations(values[:, 7:11]),
        external=np.where(values[:, 11:17] >= UNUSED, np.nan, values[:, 11:17]),
        **columns,
    )


def configurations(confdata: Floats) -> NDArray[np.int8]:
    """Neutral columns; unstated where confdata are no small whole numbers."""
    sane = ((np.abs(confdata) <= 127) & (confdata == np.rint(confdata))).all(axis=1)
    columns = from_confdata(np.where(sane[:, None], confdata, 0))
    columns[~sane, 0] = UNSTATED
    return columns


class _Start:
    def __init__(self, start: int, number: int) -> None:
        self.start, self.number = start, number


class _Rows:
    """The targets of a run of moves, one a row: VIA and END of an arc are two."""

    def __init__(self, run: MoveRun) -> None:
        circular = run.kinds == CIRCULAR
        self.ends = np.cumsum(1 + circular) - 1
        count = len(run) + int(circular.sum())
        vias = self.ends[circular] - 1
        self.names = join_names([run.names, run.vias])
        order = np.empty(count, dtype=np.intp)
        order[self.ends] = np.arange(len(run))
        order[vias] = len(run) + np.arange(len(vias))
        self.names = self.names.rows(order)
        self.kinds = np.full(count, Kind.LINEAR, dtype=np.uint8)
        self.kinds[self.ends[run.kinds == JOINT]] = Kind.JOINT
        self.kinds[vias] = Kind.VIA
        self.kinds[self.ends[circular]] = Kind.END
        self.motion = np.empty(count, dtype=np.int32)
        self.motion[self.ends] = run.motion
        self.motion[vias] = run.motion[circular]

    def sequences(self, alone: Truths) -> Iterator[tuple[_Start, int]]:
        """Stretches of consecutive numbers: first row with its number (0: no path), end.

        alone: (rows,) whether the target is declared and named once only.
        """
        stem, number = self.names.stem, self.names.number
        follows = np.zeros(len(stem), dtype=bool)
        follows[1:] = (stem[1:] == stem[:-1]) & (number[1:] == number[:-1] + 1)
        follows[1:] &= alone[1:] & alone[:-1]
        follows[1:] &= number[1:] > 1
        broken = (self.kinds == Kind.END) & ~follows  # an arc through no neighbours
        cut = ~follows & ~broken
        cut[np.flatnonzero(broken) - 1] = True
        cut[np.minimum(np.flatnonzero(broken) + 1, len(cut) - 1)] |= True
        cut &= self.kinds != Kind.END
        starts = np.flatnonzero(cut)
        usable = alone.copy()
        usable[np.flatnonzero(broken)] = False
        usable[np.flatnonzero(broken) - 1] = False
        for start, stop in zip(starts, [*starts[1:], len(stem)], strict=True):
            good = usable[start] and (stop - start > 1)
            yield _Start(int(start), int(number[start]) if good else 0), int(stop)


class _Index:
    """Rows of a column of names by stem without case and number."""

    def __init__(self, names: Names) -> None:
        self._order = np.lexsort((names.number, names.stem))
        self._numbers = names.number[self._order]
        stems = names.stem[self._order]
        bounds = np.searchsorted(stems, np.arange(len(names.stems) + 1))
        self._slices: dict[bytes, list[tuple[int, int]]] = {}
        for number, stem in enumerate(names.stems):
            pair = (int(bounds[number]), int(bounds[number + 1]))
            self._slices.setdefault(stem.lower(), []).append(pair)

    def rows(self, names: Names) -> Rows:
        """The row of each name, -1 if it is none."""
        found = np.full(len(names), -1, dtype=np.intp)
        for at, stem in enumerate(names.stems):
            mine = np.flatnonzero(names.stem == at) if len(names.stems) > 1 else slice(None)
            wanted = names.number[mine]
            hits = np.full(len(wanted), -1, dtype=np.intp)
            for start, stop in self._slices.get(stem.lower(), ()):
                numbers = self._numbers[start:stop]
                place = np.searchsorted(numbers, wanted)
                inside = place < len(numbers)
                match = np.zeros(len(wanted), dtype=bool)
                match[inside] = numbers[place[inside]] == wanted[inside]
                hits[match] = self._order[start + place[match]]
            found[mine] = hits
        return found

    def row(self, name: str) -> Rows:
        if not name.isascii():
            return np.array([-1], dtype=np.intp)
        return self.rows(names_of([name]))
