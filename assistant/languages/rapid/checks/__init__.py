"""RAPID's own rules over the modules of one program: what a controller would refuse."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from assistant.base.diagnostics import Diagnostic, has_errors
from assistant.languages.checks.registry import Check, Needs, findings, undamaged_findings
from assistant.languages.rapid.checks import (
    arcs,
    by_construct,
    flow,
    motions,
    mounted,
    names,
    storage,
    targets,
    timing,
    undeclared,
    unused,
)
from assistant.languages.rapid.checks.damage import damage_of
from assistant.languages.rapid.checks.module_view import RuleContext, Task
from assistant.languages.rapid.checks.single_rows import with_single_rows
from assistant.languages.rapid.checks.tasks import tasks
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

__all__ = ["CHECKS", "check", "loaded_files"]

CHECKS: Final[tuple[Check[RuleContext], ...]] = (
    Check(names.module_names, Needs.ORDER),
    Check(names.duplicate_names),
    Check(names.name_spelling),
    Check(flow.declarations, Needs.ORDER),
    Check(flow.handlers, Needs.ORDER),
    Check(storage.storage_places, Needs.ORDER),
    Check(storage.initial_values),
    Check(storage.array_dimensions),
    Check(storage.read_only_data),
    Check(storage.traps_and_aliases),
    Check(names.string_lengths),
    Check(names.number_sizes),
    Check(targets.quaternion_lengths),
    Check(targets.configurations),
    Check(motions.motion_names),
    Check(mounted.equipment_values, Needs.ORDER),
    Check(mounted.held_pairs, Needs.ORDER),
    Check(timing.unset_triggers, Needs.ORDER),
    Check(timing.long_trigger_times),
    Check(by_construct.uses_by_construct),
    Check(flow.jumps, Needs.ORDER),
    Check(flow.outside_handlers, Needs.ORDER),
    Check(flow.never_booked, Needs.ORDER),
    Check(flow.returns, Needs.ORDER),
    Check(flow.unreachable, Needs.ORDER),
    Check(flow.cases_and_steps, Needs.ORDER),
    Check(undeclared.undeclared_names),
    Check(arcs.arcs, Needs.ORDER, advice=True),
    Check(timing.endless_waits, advice=True),
    Check(timing.signals_on_the_fly, advice=True),
    Check(unused.unused_declarations, Needs.ORDER, advice=True),
)
"""Each looks at one module, and sees what the modules beside it declare."""


def check(trees: Sequence[s.File]) -> tuple[Diagnostic, ...]:
    """Findings of the parser and of every rule, over the modules of a program.

    They are one task's, unless their folders are named like several tasks. What may follow from
    a syntax error is left out.
    """
    found = [finding for tree in trees for finding in tree.findings]
    damage = damage_of(trees)
    for files, common in tasks(trees):
        single = with_single_rows(files, common)
        shared = {id(one) for one in common}
        pairs = zip(files, single, strict=True)
        task = Task(single, [new for old, new in pairs if id(old) in shared])
        for tree in single:
            lacks = Needs.ORDER if has_errors(tree.findings) else Needs.NOTHING
            for module in tree.modules:
                look = RuleContext(tree, module, task)
                of_module = findings(CHECKS, look, lacks, compiled=look.compiled)
                found += undamaged_findings(of_module, damage, tree.source)
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
