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
    Check(steps.order),
    Check(steps.lengths),
    Check(steps.labels, Needs.NAMES),
    Check(names.spelling),
    Check(names.program),
    Check(names.twice, Needs.NAMES),
    Check(undefined.variables, Needs.NAMES),
    Check(undefined.calls, Needs.NAMES),
    Check(unused.twice),
    Check(flow.structure, Needs.ORDER),
    Check(flow.loops, Needs.ORDER),
    Check(flow.into_blocks, Needs.ORDER),
    Check(flow.subroutines, Needs.ORDER),
    Check(flow.unreachable, Needs.ORDER),
    Check(words.missing),
    Check(kinds.assignments, Needs.NAMES),
    Check(kinds.operands, Needs.NAMES),
    Check(kinds.suffixes, Needs.NAMES),
    Check(kinds.dimensions, Needs.NAMES),
    Check(values.ranges),
    Check(values.counts),
    Check(values.types, Needs.NAMES),
    Check(values.strange, Needs.NAMES),
    Check(values.status),
    Check(timing.at_a_time),
    Check(left_out.positions),
    Check(left_out.arguments),
    Check(left_out.lines),
    Check(motions.never_taught),
    Check(motions.flags, Needs.ORDER),
    Check(motions.arcs, Needs.ORDER),
    Check(motions.circles, Needs.ORDER),
    Check(programs.missing),
    Check(programs.recursion),
    Check(programs.mechanisms, Needs.ORDER),
    Check(shared_variables.started_early, Needs.ORDER),
    Check(shared_variables.last_values, Needs.ORDER),
    Check(programs.interrupts, Needs.ORDER),
    Check(programs.files, Needs.ORDER),
    Check(unused.unused, Needs.WHOLE, advice=True),
    Check(timing.corners, Needs.ORDER, advice=True),
    Check(timing.tools, Needs.ORDER, advice=True),
    Check(values.units, advice=True),
    Check(values.waits, advice=True),
)
"""Each looks at one file, and sees the files that stand beside it."""


def missing(trees: Sequence[s.File], dialect: Dialect) -> Iterator[Diagnostic]:
    """Findings on programs that `CallP` calls and that are not among the trees."""
    calls, damage = Calls(trees), damage_of(trees)
    for tree in trees:
        found = programs.missing(Look(tree, dialect, calls, damage))
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
