"""Trap routines as procedures: other languages have their interrupts call those."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeGuard

from assistant.languages.rapid.tree import syntax as s


def with_traps(modules: Sequence[s.Module]) -> list[s.Module]:
    """The modules with a procedure for each trap routine."""
    return list(map(_with_trap_procedures, modules))


def _with_trap_procedures(module: s.Module) -> s.Module:
    if not any(_is_trap(item) for item in module.items):
        return module
    items = (replace(item, kind="PROC") if _is_trap(item) else item for item in module.items)
    return replace(module, items=tuple(items))


def _is_trap(item: s.Item) -> TypeGuard[s.Routine]:
    return isinstance(item, s.Routine) and item.kind == "TRAP"
