"""Procedures that are forms of one and say the same are one: how they differ does not matter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure
from assistant.program.rewriting import rewrite


def without_equal_procedures(
    procedures: list[Procedure], origin: Mapping[str, int]
) -> list[Procedure]:
    """The procedures without those that another form of the same code says as well.

    origin: of each procedure that is a form of some code, by name, which code that is.
    """
    while True:
        exchanged: dict[str, str] = {}
        kept: dict[int, list[Procedure]] = {}
        for procedure in procedures:
            if procedure.name not in origin:
                continue
            forms = kept.setdefault(origin[procedure.name], [])
            same = next((q for q in forms if replace(procedure, name=q.name) == q), None)
            if same is None:
                forms.append(procedure)
            else:
                exchanged[procedure.name] = same.name
        if not exchanged:
            return procedures
        procedures = [
            replace(q, body=_with_calls_replaced(q.body, exchanged))
            for q in procedures
            if q.name not in exchanged
        ]


def _with_calls_replaced(
    body: tuple[p.Statement, ...], names: Mapping[str, str]
) -> tuple[p.Statement, ...]:
    def visit(node: Any) -> Any:
        match node:
            case p.Call(procedure=name) if name in names and node.unit is None:
                return replace(node, procedure=names[name])
            case e.Apply(function=name) if name in names:
                return replace(node, function=names[name])
        return node

    return rewrite(body, visit)
