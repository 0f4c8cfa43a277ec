"""Long programs in several modules: a controller takes only so many targets in one."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.adapt_findings import Findings
from assistant.languages.rapid.naming import units
from assistant.program import statements as p
from assistant.program.path import Kind, Path
from assistant.program.program import Procedure, Program, identifier, walk
from assistant.program.rewriting import map_bodies


def split(program: Program, most: int, findings: Findings) -> Program:
    """Paths that fill a module over the limit, in modules of their own.

    most: targets of a module; fewer than LEAST_PIECE count as that.
    """
    most = max(most, LEAST_PIECE)
    count: dict[str | None, int] = {None: len(program.targets)}
    for procedure in program.procedures:
        for statement in walk(procedure.body):
            if isinstance(statement, p.Follow) and len(statement.path) <= most:
                count[procedure.unit] = count.get(procedure.unit, 0) + len(statement.path)
    taken = {q.name for q in program.procedures} | set(units(program)) | {program.name}
    taken |= {*program.targets, *program.variables, *program.signals, *program.tools}
    new: list[Procedure] = []

    def body(statements: tuple[p.Statement, ...], unit: str | None) -> tuple[p.Statement, ...]:
        out: list[p.Statement] = []
        for statement in statements:
            statement = map_bodies(statement, lambda b: body(b, unit))
            if not isinstance(statement, p.Follow) or (
                len(statement.path) <= most and count[unit] <= most
            ):
                out.append(statement)
                continue
            if len(statement.path) <= most:
                count[unit] -= len(statement.path)
                if unit is not None and count[unit] == 0:
                    count[unit] += len(statement.path)
                    out.append(statement)
                    continue
            pieces = _pieces(statement.path, most)
            findings.append(
                rules.SPLIT(name=statement.path.name, count=len(statement.path), parts=len(pieces))
            )
            for number, piece in enumerate(pieces, 1):
                name = statement.path.name[:20]
                procedure = identifier(f"{name}_part{number}", taken)
                module = identifier(f"{name}_unit{number}", taken | {procedure})
                taken.update((procedure, module))
                path = replace(piece, name=f"{procedure}_p")
                new.append(Procedure(procedure, (p.Follow(path),), unit=module))
                out.append(p.Call(procedure, (), module))
        return tuple(out)

    procedures = tuple(replace(q, body=body(q.body, q.unit)) for q in program.procedures)
    return replace(program, procedures=(*procedures, *new)) if new else program


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
