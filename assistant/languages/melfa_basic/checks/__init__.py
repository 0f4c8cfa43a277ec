"""MELFA-BASIC's own rules over the files of one program: what a controller would refuse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.checks.registry import Check, Needs, findings, undamaged_findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import (
    flow,
    kinds,
    left_out,
    motions,
    names,
    programs,
    shared_variables,
    steps,
    timing,
    undefined,
    unused,
    values,
    words,
)
from assistant.languages.melfa_basic.checks.damage import damage_of, spoiled
from assistant.languages.melfa_basic.checks.file_view import Calls, Look
from assistant.languages.melfa_basic.checks.single_rows import with_single_rows
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tree import syntax as s

__all__ = ["CHECKS", "check", "missing"]

CHECKS: Final[tuple[Check[Look], ...]] = (
    Check(steps.step_order),
    Check(steps.step_lengths),
    Check(steps.jump_labels, Needs.NAMES),
    Check(names.name_forms),
    Check(names.program_name_form),
    Check(names.declared_twice, Needs.NAMES),
    Check(undefined.undefined_variables, Needs.NAMES),
    Check(undefined.undefined_calls, Needs.NAMES),
    Check(unused.stored_twice),
    Check(flow.structure, Needs.ORDER),
    Check(flow.loops, Needs.ORDER),
    Check(flow.into_blocks, Needs.ORDER),
    Check(flow.subroutines, Needs.ORDER),
    Check(flow.unreachable, Needs.ORDER),
    Check(words.missing_words),
    Check(kinds.assigned_types, Needs.NAMES),
    Check(kinds.operand_types, Needs.NAMES),
    Check(kinds.type_marks, Needs.NAMES),
    Check(kinds.array_dimensions, Needs.NAMES),
    Check(values.argument_ranges),
    Check(values.argument_counts),
    Check(values.argument_types, Needs.NAMES),
    Check(values.strange_arguments, Needs.NAMES),
    Check(values.status_access),
    Check(timing.pulses_at_a_time),
    Check(left_out.missing_coordinates),
    Check(left_out.missing_arguments),
    Check(left_out.misplaced_lines),
    Check(motions.never_taught),
    Check(motions.flags, Needs.ORDER),
    Check(motions.arcs, Needs.ORDER),
    Check(motions.circles, Needs.ORDER),
    Check(programs.missing_programs),
    Check(programs.program_recursion),
    Check(programs.mechanism_requests, Needs.ORDER),
    Check(shared_variables.started_early, Needs.ORDER),
    Check(shared_variables.last_values, Needs.ORDER),
    Check(programs.interrupt_switches, Needs.ORDER),
    Check(programs.file_states, Needs.ORDER),
    Check(unused.unused_names, Needs.WHOLE, advice=True),
    Check(timing.corners_at_stops, Needs.ORDER, advice=True),
    Check(timing.missing_tool, Needs.ORDER, advice=True),
    Check(values.argument_units, advice=True),
    Check(values.short_waits, advice=True),
)
"""Each looks at one file, and sees the files that stand beside it."""


def missing(trees: Sequence[s.File], dialect: Dialect) -> Iterator[Diagnostic]:
    """Findings on programs that `CallP` calls and that are not among the trees."""
    calls, damage = Calls(trees), damage_of(trees)
    for tree in trees:
        found = programs.missing_programs(Look(tree, dialect, calls, damage))
        yield from (one for one in found if one.code == rules.NOT_CALLED.code)


def check(trees: Sequence[s.File], dialect: Dialect | None = None) -> tuple[Diagnostic, ...]:
    """Findings of every rule over the files of one program, each file in the order of its lines.

    What may follow from a line with a syntax error is left out.
    dialect: with the limits of a certain controller; without it that of each file.
    """
    damage = damage_of(trees)
    lacks = spoiled(trees, damage)
    trees = with_single_rows(trees, dialect)
    calls = Calls(trees)
    found: list[Diagnostic] = []
    for tree in trees:
        look = Look(tree, dialect or DIALECTS[tree.dialect], calls, damage)
        of_file = undamaged_findings(
            findings(CHECKS, look, lacks, compiled=look.compiled), damage, tree.source
        )
        found += sorted(dict.fromkeys(of_file), key=lambda f: (f.line or 0, f.column or 0))
    return tuple(found)
