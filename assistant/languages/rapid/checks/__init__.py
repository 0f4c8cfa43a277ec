"""RAPID's own rules over the modules of one program: what a controller would refuse."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.checks import (
    literals,
    motions,
    names,
    order,
    undeclared,
)
from assistant.languages.rapid.checks.scope import Look, Task
from assistant.languages.rapid.checks.walk import nodes
from assistant.program.diagnostics import Diagnostic

__all__ = ["RULES", "check", "loaded_files"]

RULES: Final[tuple[Callable[[Look], Iterator[Diagnostic]], ...]] = (
    names.duplicates,
    names.spelling,
    literals.strings,
    motions.arguments,
    literals.quaternions,
    literals.persistents,
    order.declarations,
    undeclared.names,
)
"""Every rule: it looks at one module, and sees what the modules beside it declare."""


def check(trees: Sequence[s.File]) -> tuple[Diagnostic, ...]:
    """Findings of the parser and of every rule, over the modules of one task."""
    found = [finding for tree in trees for finding in tree.findings]
    task = Task(trees)
    for tree in trees:
        for module in tree.modules:
            look = Look(tree, module, task)
            for rule in RULES:
                found += rule(look)
    return tuple(found)


def loaded_files(root: s.File) -> tuple[str, ...]:
    """Names of the files that `Load` instructions with a literal path name."""
    files = [
        first.value.value.replace(":", "/").rsplit("/", 1)[-1]
        for call in nodes(root.modules)
        if isinstance(call, s.ProcedureCall) and str(call.name).lower() == "load"
        for first in call.arguments
        if isinstance(first, s.Positional) and isinstance(first.value, s.StringLiteral)
    ]
    return tuple(sorted(set(files)))
