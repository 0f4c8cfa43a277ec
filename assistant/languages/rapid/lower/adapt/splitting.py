"""Long programs in several modules: a controller takes only so many targets in one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.lower.adapt.findings import Findings
from assistant.languages.rapid.lower.names import units
from assistant.program import statements as p
from assistant.program.path import Kind, Path
from assistant.program.program import Procedure, Program, identifier, walk
from assistant.program.rewriting import Body, map_bodies


def split(program: Program, most: int, findings: Findings) -> Program:
    """Paths that fill a module over the limit, in modules of their own.

    most: targets of a module; fewer than LEAST_PIECE count as that.
    """
    most = max(most, LEAST_PIECE)
    splitter = _Splitter(program, most, findings)
    procedures = tuple(replace(q, body=splitter.body(q.body, q.unit)) for q in program.procedures)
    if not splitter.new:
        return program
    return replace(program, procedures=(*procedures, *splitter.new))


class _Splitter:
    """count: targets that each unit still has. new: procedures of pieces."""

    def __init__(self, program: Program, most: int, findings: Findings) -> None:
        self.most, self.findings = most, findings
        self.new: list[Procedure] = []
        self.taken = {q.name for q in program.procedures} | set(units(program)) | {program.name}
        self.taken |= {*program.targets, *program.variables, *program.signals, *program.tools}
        self.count: dict[str | None, int] = {None: len(program.targets)}
        for q in program.procedures:
            for statement in walk(q.body):
                if isinstance(statement, p.Follow) and len(statement.path) <= most:
                    self.count[q.unit] = self.count.get(q.unit, 0) + len(statement.path)

    def body(self, body: Body, unit: str | None) -> Body:
        out: list[p.Statement] = []
        for statement in body:
            if isinstance(statement, p.Follow) and self.leaves(statement.path, unit):
                out += self.calls(statement.path)
            else:
                out.append(map_bodies(statement, lambda b: self.body(b, unit)))
        return tuple(out)

    def leaves(self, path: Path, unit: str | None) -> bool:
        """Whether a path goes out of its unit; the last one of a unit that is loaded stays."""
        size = len(path)
        if size > self.most:
            return True
        left = self.count[unit] - size
        if self.count[unit] <= self.most or (unit is not None and left == 0):
            return False
        self.count[unit] = left
        return True

    def calls(self, path: Path) -> Iterator[p.Call]:
        """Of a new procedure, in a new unit, for each piece of a path."""
        pieces = _pieces(path, self.most)
        self.findings.append(rules.SPLIT(name=path.name, count=len(path), parts=len(pieces)))
        for number, piece in enumerate(pieces, 1):
            name = path.name[:20]
            procedure = identifier(f"{name}_part{number}", self.taken)
            module = identifier(f"{name}_unit{number}", self.taken | {procedure})
            self.taken.update((procedure, module))
            follow = p.Follow(replace(piece, name=f"{procedure}_p"))
            self.new.append(Procedure(procedure, (follow,), unit=module))
            yield p.Call(procedure, (), module)


LEAST_PIECE: Final = 5
"""Targets of a piece at least, whatever is asked for: room to cut between arcs."""


def _pieces(path: Path, most: int) -> list[Path]:
    pieces, start = [], 0
    while start < len(path):
        stop = min(start + most, len(path))
        if stop < len(path) and len(path) - stop < 2:
            stop -= 2  # a piece of one target would be no path
        if stop < len(path) and path.kinds[stop] == Kind.END:
            stop -= 1
        pieces.append(path.rows(start, stop))
        start = stop
    return pieces
