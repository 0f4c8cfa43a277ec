"""Long paths in units of their own: a controller takes only so many targets in one program."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from assistant.program import statements as p
from assistant.program.arrays import Ints
from assistant.program.passes.legalising import Legalisation, Units
from assistant.program.passes.path_tables import with_used_entries
from assistant.program.path import Kind, Path
from assistant.program.program import Procedure, Program, TakenNames, identifier, walk
from assistant.program.rewriting import Body, map_bodies
from assistant.program.subjects import Declared


def split(job: Legalisation) -> Program:
    """The program with calls of new procedures for the paths that fill a unit over its limit."""
    if job.can.units is None:
        return job.program
    splitter = _Splitter(job, job.can.units)
    procedures = tuple(map(splitter.procedure, job.program.procedures))
    if not splitter.new:
        return job.program
    return replace(job.program, procedures=(*procedures, *splitter.new))


class _Splitter:
    """count: targets that each unit still has. new: procedures of pieces."""

    def __init__(self, job: Legalisation, units: Units) -> None:
        program = job.program
        self.findings, self.units = job.findings, units
        self.most = max(units.most, units.least_most)
        self.new: list[Procedure] = []
        self.taken = TakenNames((program.name, *(q.name for q in program.procedures)))
        self.taken.update(q.unit for q in program.procedures if q.unit is not None)
        self.taken.update(program.targets, program.variables, program.signals, program.tools)
        self.count: dict[str | None, int] = {None: len(program.targets)}
        for q in program.procedures:
            kept = sum(size for size in _path_sizes(q) if size <= self.most)
            self.count[q.unit] = self.count.get(q.unit, 0) + kept

    def procedure(self, procedure: Procedure) -> Procedure:
        return replace(procedure, body=self.body(procedure.body, procedure))

    def body(self, body: Body, owner: Procedure) -> Body:
        made: list[p.Statement] = []
        for node in body:
            if isinstance(node, p.Follow):
                made += self.follow(node, owner)
            else:
                made.append(map_bodies(node, lambda inner: self.body(inner, owner)))
        return tuple(made)

    def follow(self, node: p.Follow, owner: Procedure) -> Iterator[p.Statement]:
        """A path, or calls of a new procedure, in a new unit, for each piece of it."""
        pieces = unit_ranges(node.path, self.units, self.most)
        if len(pieces) < 2 and self.stays(len(node.path), owner):
            yield node
            return
        by_procedure = self.units.counted == "procedure"
        about = Declared(owner.name, "procedures") if by_procedure else None
        name, count = node.path.name, len(node.path)
        self.findings.append(
            self.units.split(name=name, count=count, parts=len(pieces), about=about)
        )
        for number, (start, stop) in enumerate(pieces, 1):
            procedure = identifier(self.units.part.format(name, number), self.taken)
            self.taken.add(procedure)
            unit = procedure
            if self.units.unit:
                unit = identifier(self.units.unit.format(name, number), self.taken)
                self.taken.add(unit)
            rows = node.path.rows(start, stop, self.units.path.format(procedure))
            self.new.append(Procedure(procedure, (p.Follow(with_used_entries(rows)),), unit=unit))
            yield p.Call(procedure, unit=unit, span=node.span)

    def stays(self, size: int, owner: Procedure) -> bool:
        """Whether a path in one piece stays where it is; the last one of a unit does."""
        if self.units.counted == "procedure":
            sizes = _path_sizes(owner)
            lone = owner.unit is not None and len(owner.body) == 1
            return lone or len(sizes) < 2 or sum(sizes) <= self.most
        left = self.count[owner.unit] - size
        if self.count[owner.unit] <= self.most or (owner.unit is not None and left == 0):
            return True
        self.count[owner.unit] = left
        return False


def _path_sizes(procedure: Procedure) -> list[int]:
    return [len(node.path) for node in walk(procedure.body) if isinstance(node, p.Follow)]


def unit_ranges(path: Path, units: Units, most: int) -> list[tuple[int, int]]:
    """Ranges of rows that fit one unit each; an arc's two rows stay together."""
    n = len(path)
    costs, most_steps = _row_steps(path, units), units.most_steps or np.iinfo(np.int64).max
    total = np.concatenate([[0], np.cumsum(costs)])
    if n <= most and total[-1] <= most_steps:
        return [(0, n)]
    pieces, start = [], 0
    while start < n:
        room = min(int(total[start]) + most_steps, int(total[-1]))
        stop = int(np.searchsorted(total, room, side="right")) - 1
        stop = min(n, start + most, max(stop, start + 2))
        if stop < n:
            stop -= units.least if n - stop < units.least else 0
            stop = _good_cut(path, start, stop, units.straight)
        pieces.append((start, stop))
        start = stop
    return pieces


def _good_cut(path: Path, start: int, stop: int, straight: bool) -> int:
    """The last row up to `stop` that a piece may begin with.

    straight: it begins with a straight move where one is near, so that no arc starts unknown.
    """
    least = max(start + 1, stop - (stop - start) // 4)
    kinds = path.kinds[least : stop + 1]
    straights = np.flatnonzero((kinds != Kind.VIA) & (kinds != Kind.END))
    if straight and len(straights):
        return least + int(straights[-1])
    whole = np.flatnonzero(path.kinds[start + 1 : stop + 1] != Kind.END)
    return start + 1 + int(whole[-1]) if len(whole) else stop


def _row_steps(path: Path, units: Units) -> Ints:
    """Steps that each row takes at most: its move, and its settings where they change."""
    costs = (path.kinds != Kind.VIA).astype(np.int64)
    costs[:1] += units.first
    for column, lines in units.steps.items():
        values = getattr(path, column)
        costs[1:] += lines * (values[1:] != values[:-1])
    return np.asarray(costs)
