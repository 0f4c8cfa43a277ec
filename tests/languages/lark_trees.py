"""Trees of lark as nodes of a language, and nodes in a form that compares their places too."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from lark import Tree

from assistant.base.diagnostics import Span


def everything(value: Any) -> Any:
    """A tree as tuples, with the places, which do not count when nodes are compared."""
    if is_dataclass(value) and not isinstance(value, type):
        parts = (everything(getattr(value, field.name)) for field in fields(value))
        return (type(value).__name__, *parts)
    if isinstance(value, tuple | list):
        return tuple(map(everything, value))
    if isinstance(value, np.ndarray):
        return value.tobytes()
    return str(value) if isinstance(value, str) else value


def node_of(tree: Any, nodes: Any) -> Any:
    """The node that a tree of lark stands for; a token as its text."""
    if not isinstance(tree, Tree):
        return None if tree is None else str(tree)
    children = [node_of(child, nodes) for child in tree.children]
    place = None if tree.meta.empty else Span(tree.meta.start_pos, tree.meta.end_pos)
    return getattr(nodes, tree.data)(place, children)
