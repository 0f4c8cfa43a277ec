"""MELFA-BASIC's own rules over the files of one program: what a controller would refuse."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from assistant.languages.melfa_basic.checks import (
    corners,
    flow,
    kinds,
    left_out,
    motions,
    names,
    programs,
    steps,
    undefined,
    unused,
    values,
    words,
)
from assistant.languages.melfa_basic.checks.damage import Damage, damage_of
from assistant.languages.melfa_basic.checks.file_view import Calls, Look
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import Diagnostic

__all__ = ["ADVICE", "RULES", "check"]

RULES: Final[tuple[Callable[[Look], Iterator[Diagnostic]], ...]] = (
    steps.order,
    steps.lengths,
    steps.labels,
    names.spelling,
    names.program,
    names.declarations,
    undefined.variables,
    undefined.calls,
    unused.twice,
    flow.structure,
    flow.loops,
    flow.into_blocks,
    flow.subroutines,
    flow.unreachable,
    words.missing,
    kinds.assignments,
    kinds.operands,
    kinds.suffixes,
    kinds.dimensions,
    values.ranges,
    values.counts,
    values.types,
    values.status,
    left_out.positions,
    left_out.arguments,
    left_out.lines,
    motions.never_taught,
    motions.flags,
    motions.arcs,
    motions.circles,
    programs.missing,
    programs.recursion,
    programs.mechanisms,
    programs.interrupts,
    programs.files,
)
"""Every rule: it looks at one file, and sees the files that stand beside it."""

ADVICE: Final[tuple[Callable[[Look], Iterator[Diagnostic]], ...]] = (
    unused.unused,
    corners.corners,
    corners.tools,
    values.units,
    values.waits,
)
"""Rules of how a program is written. They are not asked about a file that was compiled: the
program that it comes from has been checked, and its author wrote no MELFA-BASIC."""


PAIRING: Final[frozenset[Callable[[Look], Iterator[Diagnostic]]]] = frozenset(
    {
        flow.structure,
        flow.loops,
        flow.into_blocks,
        flow.subroutines,
        flow.unreachable,
        programs.mechanisms,
        programs.interrupts,
        programs.files,
        motions.flags,
        motions.arcs,
        motions.circles,
        corners.corners,
        corners.tools,
    }
)
"""Rules of lines that belong together or that follow each other: not asked where a damaged line
may be one of them."""

DEFINING: Final[frozenset[Callable[[Look], Iterator[Diagnostic]]]] = frozenset(
    {
        steps.labels,
        names.declarations,
        undefined.variables,
        undefined.calls,
        kinds.assignments,
        kinds.operands,
        kinds.suffixes,
        kinds.dimensions,
        values.types,
    }
)
"""Rules of what is not defined: not asked where a damaged line may define something unnamed."""


def check(trees: Sequence[s.File], dialect: Dialect | None = None) -> tuple[Diagnostic, ...]:
    """Findings of every rule over the files of one program, each file in the order of its lines.

    What may follow from a line with a syntax error is left out.
    dialect: with the limits of a certain controller; without it that of each file.
    """
    calls = Calls(trees)
    damage = damage_of(trees)
    found: list[Diagnostic] = []
    for tree in trees:
        look = Look(tree, dialect or DIALECTS[tree.dialect], calls, damage)
        asked = RULES if look.compiled else (*RULES, *ADVICE)
        of_file = (finding for rule in asked if _is_sure(rule, damage) for finding in rule(look))
        if damage is not None:
            of_file = (f for f in of_file if not damage.explains(f, tree.source))
        found += sorted(dict.fromkeys(of_file), key=lambda f: (f.line or 0, f.column or 0))
    return tuple(found)


def _is_sure(rule: Callable[[Look], Iterator[Diagnostic]], damage: Damage | None) -> bool:
    """Whether what a rule finds does not follow from a damaged line that names something else."""
    if damage is None:
        return True
    if rule is unused.unused:
        return False
    return (damage.plain or rule not in PAIRING) and (damage.named or rule not in DEFINING)
