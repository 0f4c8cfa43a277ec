"""Rows of tables of tools and frames, as tools and frames of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from assistant.program import statements as p
from assistant.program.analysis.uses import declared, names_in
from assistant.program.geometry import Frame, Tool
from assistant.program.program import Declaration, Program, TakenNames, identifier
from assistant.program.rewriting import with_vendor_statements_replaced

RowTable = tuple[Declaration, Sequence[Tool | Frame]]
"""What a declaration says: the rows."""
RowName = Callable[[str, int], str | None]
"""The name of a row, by that of its table and its place from 1; None where there is none."""


def with_table_rows(
    program: Program,
    tables: Mapping[str, RowTable],
    said: Callable[[p.Opaque, RowName], p.Statement],
) -> Program:
    """The program whose moves name rows, if nothing else reads or changes the tables.

    tables: by lower-case name. said: what a kept text says where rows are named.
    """
    names: dict[tuple[str, int], str] = {}
    taken = TakenNames(declared(program))

    def named(table: str, place: int) -> str | None:
        key = table.lower(), place
        if key[0] not in tables or not 0 < place <= len(tables[key[0]][1]):
            return None
        if key not in names:
            names[key] = identifier(f"{table}_{place}", taken)
            taken.add(names[key].lower())
        return names[key]

    changed = with_vendor_statements_replaced(program, lambda node: (said(node, named),))
    if not tables.keys().isdisjoint(name.lower() for name in names_in(changed.procedures)):
        return program
    rows = {name: tables[table][1][place - 1] for (table, place), name in names.items()}
    dropped = [declaration for declaration, _ in tables.values()]
    return replace(
        changed,
        declarations=tuple(d for d in program.declarations if d not in dropped),
        tools=program.tools | {n: v for n, v in rows.items() if isinstance(v, Tool)},
        frames=program.frames | {n: v for n, v in rows.items() if isinstance(v, Frame)},
    )
