"""External axes that the targets of a program state places of, and those that a cell has not.

Other languages have two axes at most beside those of the arm, and ask for no components of them. A
cell may say of each that it stands still there: `eax_a_stands` is TRUE.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from assistant.languages.rapid.tables.words import UNUSED
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.undeclared_names import BASE_FRAME_SUFFIX

EXTERNAL_COMPONENT: Final = "extax"
EXTERNAL_AXES: Final = tuple(f"eax_{letter}" for letter in "abcdef")
FIRST_EXTERNAL_COLUMN: Final = 11
"""Column of the first external axis in the 17 numbers of a target."""
MOST_EXTERNAL_AXES: Final = 2
"""Axes that other languages have."""
_TARGET_SHAPES: Final = ([3, 4, 4, 6], [6, 6])


def is_target(node: Any) -> bool:
    """Whether a node is a target or joint target in brackets."""
    return isinstance(node, s.AggregateNode) and _bracket_shape(node.items) in _TARGET_SHAPES


def _bracket_shape(items: Sequence[s.Expression]) -> list[int]:
    return [len(item.items) if isinstance(item, s.AggregateNode) else 0 for item in items]


def stated_axes(node: Any) -> frozenset[str]:
    """The axes that a target in brackets, or one of a run of targets or moves, gives a place."""
    match node:
        case s.TargetRunNode(run=run) | s.MoveRunNode(run):
            if run.values is None:
                return frozenset()
            given = np.asarray(run.values)[:, FIRST_EXTERNAL_COLUMN:] < UNUSED
            return frozenset(EXTERNAL_AXES[column] for column in np.flatnonzero(given.any(axis=0)))
        case s.AggregateNode(items) if is_target(node):
            last: Any = items[-1]
            numbers = map(literal_number, last.items)
            pairs = zip(EXTERNAL_AXES, numbers, strict=True)
            return frozenset(axis for axis, n in pairs if n is None or n < UNUSED)
    return frozenset()


def used_axes(modules: Sequence[s.Module]) -> frozenset[str]:
    """Those that any target which is written out gives a place."""
    return frozenset().union(*map(stated_axes, nodes(tuple(modules))))


def still_axis_name(axis: str) -> str:
    """The name of what says whether an axis stands still."""
    return axis + BASE_FRAME_SUFFIX


def axes_to_ask(modules: Sequence[s.Module]) -> list[str]:
    """Axes that a cell is to tell of, as other languages cannot say what is done with them."""
    used = used_axes(modules)
    if not used:
        return []
    found = [axis for axis in EXTERNAL_AXES if axis in used]
    most = len(found) > MOST_EXTERNAL_AXES or found != list(EXTERNAL_AXES[: len(found)])
    parts = (
        isinstance(node, s.Component) and node.name.lower() == EXTERNAL_COMPONENT
        for node in nodes(tuple(modules))
    )
    return found if most or any(parts) else []


def still_axes(modules: Sequence[s.Module]) -> frozenset[str]:
    """Axes that data of the modules say to stand still."""
    names = {still_axis_name(axis): axis for axis in EXTERNAL_AXES}
    return frozenset(
        names[item.name.lower()]
        for module in modules
        for item in module.items
        if isinstance(item, s.Data)
        and item.name.lower() in names
        and item.value == s.BoolLiteral(True)
    )
