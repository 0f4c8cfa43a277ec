"""Programs compared whatever their places for jumps are called."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from assistant.program import statements as p
from assistant.program.program import Program, walk


def places_in_order(program: Program) -> Program:
    """The program with its labels called by their order: those of steps are called by number."""
    listed = [s for procedure in program.procedures for s in walk(procedure.body)]
    names = dict.fromkeys(s.name for s in listed if isinstance(s, p.Label))
    order = {name: f"L{at}" for at, name in enumerate(names)}
    procedures = (replace(one, body=_renamed(one.body, order)) for one in program.procedures)
    return replace(program, procedures=tuple(procedures))


def _renamed(node: Any, order: dict[str, str]) -> Any:
    """A statement or its parts; expressions and paths stay as they are."""
    if isinstance(node, tuple):
        return tuple(_renamed(one, order) for one in node)
    if isinstance(node, p.Label):
        return replace(node, name=order[node.name])
    if isinstance(node, p.Goto):
        return replace(node, label=order.get(node.label, node.label))
    if not is_dataclass(node) or type(node).__module__ != p.__name__:
        return node
    parts = {f.name: getattr(node, f.name) for f in fields(node)}
    changed = {name: _renamed(part, order) for name, part in parts.items()}
    moved = {name: part for name, part in changed.items() if part is not parts[name]}
    return replace(node, **moved) if moved else node  # type: ignore[type-var]
