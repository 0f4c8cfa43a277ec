"""Moves through consecutively numbered targets as one path, in a pseudo-program."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import names_in
from assistant.program.arrays import Rows
from assistant.program.diagnostics import span_over
from assistant.program.geometry import Target
from assistant.program.kept import effect_of
from assistant.program.path import Kind, Path, configuration_row
from assistant.program.program import Program, bodies
from assistant.program.rewriting import map_bodies

_ROW: Final = re.compile(r"(.*)_([1-9][0-9]{0,14})", re.DOTALL)


def with_paths(program: Program, original: Callable[[str], str] = str) -> Program:
    """Moves through `seam_1`, `seam_2` … that nothing else uses, two at least, become `seam`.

    original: gives the name of a path back that was written under another.
    """
    uses: Counter[str] = Counter()
    for procedure in program.procedures:
        uses.update(n.lower() for n in names_in(procedure))
    for declaration in program.declarations:
        uses.update(effect_of(declaration).names)
    once = {n.lower(): (n, t) for n, t in program.targets.items() if uses[n.lower()] == 1}
    if not once:
        return program
    gatherer = _Gatherer(once, original)
    procedures = tuple(replace(q, body=gatherer.body(q.body)) for q in program.procedures)
    left = {n: t for n, t in program.targets.items() if n.lower() not in gatherer.gone}
    return replace(program, procedures=procedures, targets=left)


class _Gatherer:
    def __init__(
        self, once: Mapping[str, tuple[str, Target]], original: Callable[[str], str]
    ) -> None:
        self.once, self.original = once, original
        self.gone: set[str] = set()

    def body(self, body: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
        out: list[p.Statement] = []
        held: list[p.Statement] = []
        stem, count = "", 0
        for statement in body:
            piece = self.piece(statement)
            if piece is not None and piece[0] == stem.lower() and piece[1] == count + 1 and held:
                held.append(statement)
                count = piece[2]
                continue
            out += self.joined(held, count)
            if piece is not None and piece[1] == 1:
                held, stem, count = [statement], piece[0], piece[2]
            else:
                held, stem, count = [], "", 0
                out.append(self.inside(statement))
        return tuple(out + self.joined(held, count))

    def inside(self, statement: p.Statement) -> p.Statement:
        if not bodies(statement):
            return statement
        changed: p.Statement = map_bodies(statement, self.body)
        return changed

    def piece(self, statement: p.Statement) -> tuple[str, int, int] | None:
        """Stem, first and last number of the rows that a statement could be of a path."""
        match statement:
            case p.Follow(path):
                return path.name.lower(), 1, len(path)
            case p.Move(motion=motion) | p.MoveCircular(motion=motion) if (
                p.COMPUTED in motion.fixed
            ):
                return None
            case p.Move(_, e.Name(name), triggers=(), until=None):
                row = self.row(name)
                return None if row is None else (row[0], row[1], row[1])
            case p.MoveCircular(e.Name(via), e.Name(end), triggers=(), until=None):
                one, two = self.row(via), self.row(end)
                if one is not None and two is not None and (one[0], one[1] + 1) == two:
                    return one[0], one[1], two[1]
        return None

    def row(self, name: str) -> tuple[str, int] | None:
        match = _ROW.fullmatch(name.lower())
        if match is None or name.lower() not in self.once:
            return None
        return match[1], int(match[2])

    def joined(self, held: list[p.Statement], count: int) -> list[p.Statement]:
        if count < 2 or (len(held) == 1 and isinstance(held[0], p.Follow)):
            return held
        span = span_over(held[0].span, held[-1].span)
        paths = [self.path(statement) for statement in held]
        joined = joined_paths(paths[0].name, paths)
        places = None if span is None else _row_spans(held, paths, span.start)
        return [p.Follow(replace(joined, places=places), span=span)]

    def path(self, statement: p.Statement) -> Path:
        match statement:
            case p.Follow(path):
                return path
            case p.Move(kind, e.Name(name), motion):
                row = Kind.JOINT if kind == "joint" else Kind.LINEAR
                return self.of([name], [row], motion)
            case p.MoveCircular(e.Name(via), e.Name(end), motion):
                return self.of([via, end], [Kind.VIA, Kind.END], motion)
        raise TypeError(statement)

    def of(self, names: list[str], kinds: list[Kind], motion: p.Motion) -> Path:
        targets = [self.once[n.lower()][1] for n in names]
        self.gone.update(n.lower() for n in names)
        first = self.once[names[0].lower()][0]
        speed, blend = motion.fixed
        return Path.of(
            self.original(first.rsplit("_", 1)[0]),
            [t.pose.position for t in targets],
            [t.pose.quaternion for t in targets],
            kinds=np.array(kinds),
            configurations=[configuration_row(t.configuration) for t in targets],
            external=[t.external for t in targets],
            speeds=(speed,),
            blends=(blend,),
            tools=(motion.tool,),
            frames=(motion.frame,),
        )


def _row_spans(held: Sequence[p.Statement], paths: Sequence[Path], start: int) -> Rows | None:
    """Spans of the rows of paths in the text, counted from `start`; None if any has none."""
    parts = []
    for statement, path in zip(held, paths, strict=True):
        span, places = statement.span, path.places
        if span is None or (isinstance(statement, p.Follow) and places is None):
            return None
        if not isinstance(statement, p.Follow):
            places = np.full((len(path), 2), (0, span.end - span.start))
        assert places is not None
        parts.append(places + (span.start - start))
    return np.concatenate(parts)


def joined_paths(name: str, paths: list[Path]) -> Path:
    """Paths one after the other as one, without the places of their rows."""
    tables: dict[str, tuple[Any, ...]] = {}
    columns: dict[str, Any] = {}
    for column in ("speed", "blend", "tool", "frame"):
        rows: dict[Any, int] = {}
        parts = []
        for path in paths:
            entries = getattr(path, column + "s")
            index = np.array([rows.setdefault(v, len(rows)) for v in entries], dtype=np.int32)
            parts.append(index[getattr(path, column)])
        columns[column] = np.concatenate(parts)
        tables[column + "s"] = tuple(rows)
    for column in ("kinds", "positions", "quaternions", "configurations", "external"):
        columns[column] = np.concatenate([getattr(path, column) for path in paths])
    columns.update(tables)
    return replace(paths[0], name=name, places=None, **columns)
