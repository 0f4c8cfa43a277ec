"""MELFA-BASIC's own rules over the files of one program: what a controller would refuse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.checks.registry import Check, Needs, findings, undamaged_findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.checks import flow, lines, motions, names, programs, values
from assistant.languages.melfa_basic.checks.file_view import Calls, Look
from assistant.languages.melfa_basic.checks.lines import damage_of, spoiled, with_single_rows
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tree import syntax as s

__all__ = ["CHECKS", "check", "missing"]

CHECKS: Final[tuple[Check[Look], ...]] = (
    Check(lines.step_order),
    Check(lines.step_lengths),
    Check(lines.jump_labels, Needs.NAMES),
    Check(names.name_forms),
    Check(names.program_name_form),
    Check(names.declared_twice, Needs.NAMES),
    Check(names.undefined_variables, Needs.NAMES),
    Check(names.undefined_calls, Needs.NAMES),
    Check(names.stored_twice),
    Check(flow.structure, Needs.ORDER),
    Check(flow.loops, Needs.ORDER),
    Check(flow.into_blocks, Needs.ORDER),
    Check(flow.subroutines, Needs.ORDER),
    Check(flow.unreachable, Needs.ORDER),
    Check(names.missing_words),
    Check(values.assigned_types, Needs.NAMES),
    Check(values.operand_types, Needs.NAMES),
    Check(values.type_marks, Needs.NAMES),
    Check(values.array_dimensions, Needs.NAMES),
    Check(values.argument_ranges),
    Check(values.argument_counts),
    Check(values.argument_types, Needs.NAMES),
    Check(values.strange_arguments, Needs.NAMES),
    Check(values.status_access),
    Check(motions.pulses_at_a_time),
    Check(values.missing_coordinates),
    Check(values.missing_arguments),
    Check(values.misplaced_lines),
    Check(motions.never_taught),
    Check(motions.flags, Needs.ORDER),
    Check(motions.arcs, Needs.ORDER),
    Check(motions.circles, Needs.ORDER),
    Check(programs.missing_programs),
    Check(programs.program_recursion),
    Check(programs.mechanism_requests, Needs.ORDER),
    Check(programs.started_early, Needs.ORDER),
    Check(programs.last_values, Needs.ORDER),
    Check(programs.interrupt_switches, Needs.ORDER),
    Check(programs.file_states, Needs.ORDER),
    Check(names.unused_names, Needs.WHOLE, advice=True),
    Check(motions.corners_at_stops, Needs.ORDER, advice=True),
    Check(motions.missing_tool, Needs.ORDER, advice=True),
    Check(values.argument_units, advice=True),
    Check(values.short_waits, advice=True),
)
"""Checks of one file each, which also see the other files of its program."""


def missing(trees: Sequence[s.File], dialect: Dialect) -> Iterator[Diagnostic]:
    """Findings on programs that `CallP` calls and that are not among the trees."""
    calls, damage = Calls(trees), damage_of(trees)
    for tree in trees:
        found = programs.missing_programs(Look(tree, dialect, calls, damage))
        yield from (one for one in found if one.code == rules.NOT_CALLED.code)


def check(trees: Sequence[s.File], dialect: Dialect | None = None) -> tuple[Diagnostic, ...]:
    """Return the findings of every rule over the files of one program, each file in the order of
    its lines.

    Findings that may follow from a line with a syntax error are omitted.
    dialect: with the limits of a certain controller; if omitted, that of each file.
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
        # Findings that several rules make alike are given once.
        found += sorted(dict.fromkeys(of_file), key=lambda f: (f.line or 0, f.column or 0))
    return tuple(found)
