"""Damaged programs: nothing raises, and the findings stand where the damage is."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Severity
from tests.languages.rapid.mutations import KINDS, PROGRAMS, Mutation, mutations
from tests.tables import every_row

RAPID = languages.get("rapid")
LEAST = 0.95


@cache
def damaged() -> tuple[tuple[Mutation, list[Diagnostic]], ...]:
    """Each mutation with what is found in it."""
    return tuple((mutation, findings_of(mutation.text)) for mutation in mutations())


def findings_of(text: str) -> list[Diagnostic]:
    tree = RAPID.parse(text)
    assert RAPID.render(tree) == text
    return [f for f in RAPID.check([tree]) if f.severity is not Severity.INFO]


@every_row("path", PROGRAMS)
def test_the_undamaged_programs_have_no_findings(path: Path) -> None:
    assert findings_of(path.read_text(encoding="utf-8")) == []


@pytest.mark.slow
def test_damage_is_found_where_it_is() -> None:
    """All mutations count, those too that leave a program which means something else."""
    missed = [mutation.name for mutation, found in damaged() if not mutation.is_near(found)]
    assert len(damaged()) >= 300
    assert len(missed) <= (1 - LEAST) * len(damaged()), missed


def test_findings_point_into_the_text() -> None:
    """In every third of the damaged programs, of all kinds of damage and all programs."""
    made = [*mutations()][::3]
    assert {(one.program, one.kind) for one in made} == {
        (path.name, kind) for path in PROGRAMS for kind in KINDS
    }
    point_into_the_text((one, findings_of(one.text)) for one in made)


@pytest.mark.slow
def test_findings_point_into_the_text_of_all_damaged_programs() -> None:
    point_into_the_text(damaged())


def point_into_the_text(cases: Iterable[tuple[Mutation, list[Diagnostic]]]) -> None:
    for mutation, found in cases:
        for finding in found:
            assert mutation.holds(finding), finding
