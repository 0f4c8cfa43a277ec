"""RAPID's own rules over the modules of one program: what a controller would refuse."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from assistant.languages.rapid.checks import (
    arcs,
    by_construct,
    configurations,
    flow,
    literals,
    motions,
    names,
    order,
    orientations,
    storage,
    timing,
    undeclared,
    unused,
)
from assistant.languages.rapid.checks.damage import damage_of
from assistant.languages.rapid.checks.module_view import Look, Task
from assistant.languages.rapid.checks.tasks import tasks
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.diagnostics import Diagnostic, has_errors

__all__ = ["ADVICE", "RULES", "check", "loaded_files"]

RULES: Final[tuple[Callable[[Look], Iterator[Diagnostic]], ...]] = (
    names.modules,
    names.duplicates,
    names.spelling,
    order.declarations,
    order.handlers,
    storage.places,
    storage.initial_values,
    storage.dimensions,
    storage.assignments,
    storage.connections,
    literals.strings,
    literals.persistents,
    orientations.quaternions,
    configurations.configurations,
    motions.arguments,
    by_construct.uses,
    flow.jumps,
    flow.handled,
    flow.returns,
    flow.unreachable,
    flow.choices,
    undeclared.names,
)
"""Every rule: it looks at one module, and sees what the modules beside it declare."""

ADVICE: Final[tuple[Callable[[Look], Iterator[Diagnostic]], ...]] = (
    arcs.arcs,
    timing.endless_waits,
    timing.on_the_fly,
    unused.unused,
)
"""Rules of how a program is written. They are not asked about a module that was compiled: the
program that it comes from has been checked, and its author wrote no RAPID."""


WHOLE: Final[frozenset[Callable[[Look], Iterator[Diagnostic]]]] = frozenset(
    {
        names.modules,
        order.declarations,
        order.handlers,
        storage.places,
        flow.jumps,
        flow.handled,
        flow.returns,
        flow.unreachable,
        flow.choices,
        arcs.arcs,
        unused.unused,
    }
)
"""Rules of what surrounds or follows each other: not asked about a module with a syntax error."""


def check(trees: Sequence[s.File]) -> tuple[Diagnostic, ...]:
    """Findings of the parser and of every rule, over the modules of a program.

    They are one task's, unless their folders are named like several tasks. What may follow from
    a syntax error is left out.
    """
    found = [finding for tree in trees for finding in tree.findings]
    damage = damage_of(trees)
    for files, common in tasks(trees):
        task = Task(files, common)
        for tree in files:
            broken = has_errors(tree.findings)
            for module in tree.modules:
                look = Look(tree, module, task)
                for rule in RULES if look.compiled else (*RULES, *ADVICE):
                    if broken and rule in WHOLE:
                        continue
                    found += (
                        f for f in rule(look) if damage is None or not damage.explains(f, tree)
                    )
    return tuple(dict.fromkeys(found))


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
