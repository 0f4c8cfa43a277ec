"""Modules that a task holds beside its main one: the units that another language had of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from assistant.languages.rapid.text.header import opening
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import Body, map_bodies


def with_unit_calls(program: Program) -> Program:
    """A program whose calls of what stands in another module are calls of that unit."""
    homes = {q.name.lower(): q.unit for q in program.procedures}

    def home(call: p.Call, own: str | None) -> str | None:
        there = homes.get(call.procedure.lower())
        return there if call.unit is None and there != own else call.unit

    return _with_units_changed(program, lambda unit: unit, home)


def as_one_unit(program: Program) -> Program:
    """A program of one unit, where its modules say that the task holds them all."""
    origin = program.origin
    modules = () if origin is None else (m for file in origin.trees for m in file.modules)
    if not any(opening(module).resident for module in modules):
        return program
    return _with_units_changed(program, lambda _: None, lambda call, own: None)  # noqa: ARG005


def _with_units_changed(
    program: Program,
    of: Callable[[str | None], str | None],
    home: Callable[[p.Call, str | None], str | None],
) -> Program:
    def body(statements: Body, own: str | None) -> Body:
        return tuple(
            replace(node, unit=home(node, own))
            if isinstance(node, p.Call)
            else map_bodies(node, lambda inner: body(inner, own))
            for node in statements
        )

    procedures = (
        replace(q, unit=of(q.unit), body=body(q.body, q.unit)) for q in program.procedures
    )
    return replace(program, procedures=tuple(procedures))
