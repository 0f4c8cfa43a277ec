"""Targets without the external axes that a cell says to stand still: 9E9, as of axes that are not
there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.external_axes import (
    AXES,
    FIRST,
    place_of,
    stated,
    still_axes,
)
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite

_NO_AXIS: Final = s.NumberLiteral("9E9")
_REPORTED_NODES: Final = (
    s.Data,
    s.Assignment,
    s.ProcedureCall,
    s.TargetRunNode,
    s.MoveRunNode,
    s.ReturnFrom,
)


def with_still_axes(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules without such axes, and the findings of each."""
    still = still_axes(modules)
    if not still:
        return modules, [[] for _ in modules]
    said = {place_of(axis) for axis in still}
    columns = [FIRST + AXES.index(axis) for axis in still]

    def stood(node: Any) -> Any:
        if stated(node).isdisjoint(still):
            return node
        if isinstance(node, s.TargetRunNode | s.MoveRunNode):
            values = np.array(node.run.values, copy=True)
            values[:, columns] = UNUSED
            return replace(node, run=replace(node.run, values=values))  # type: ignore[arg-type]
        *others, last = node.items
        places = zip(AXES, last.items, strict=True)
        items = tuple(_NO_AXIS if axis in still else item for axis, item in places)
        return replace(node, items=(*others, replace(last, items=items)))

    made = []
    for module in modules:
        items = tuple(
            rewrite(item, stood, ())
            for item in module.items
            if not (isinstance(item, s.Data) and item.name.lower() in said)
        )
        made.append(replace(module, items=items))
    return made, [_still_axis_findings(module, still) for module in modules]


def _still_axis_findings(module: s.Module, still: frozenset[str]) -> list[Diagnostic]:
    """A finding for each statement and declaration that states a place of such an axis."""
    found: list[Diagnostic] = []
    for node in nodes(module):
        if isinstance(node, _REPORTED_NODES) and node.span is not None:
            inner = [node] if isinstance(node, s.TargetRunNode | s.MoveRunNode) else nodes(node)
            axes = sorted(frozenset().union(*map(stated, inner)) & still)
            found += (rules.STILL_AXIS(axis=axis, span=node.span) for axis in axes)
    return found
