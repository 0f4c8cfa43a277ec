"""Damaged programs: nothing raises, and the findings stand where the damage is."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest

from assistant import languages
from assistant.program.diagnostics import Diagnostic, Severity
from tests.languages.rapid.mutations import PROGRAMS, Mutation, mutations

RAPID = languages.get("rapid")
NEAR = 2
"""Lines between a damage and a finding that is about it."""
LEAST = 0.95


@cache
def damaged() -> tuple[tuple[Mutation, list[Diagnostic]], ...]:
    """Each mutation with what is found in it."""
    return tuple((mutation, findings_of(mutation.text)) for mutation in mutations())


def findings_of(text: str) -> list[Diagnostic]:
    tree = RAPID.parse(text)
    assert RAPID.render(tree) == text
    return [f for f in RAPID.check([tree]) if f.severity is not Severity.INFO]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_the_undamaged_programs_have_no_findings(path: Path) -> None:
    assert findings_of(path.read_text(encoding="utf-8")) == []


def is_near(mutation: Mutation, found: Iterable[Diagnostic]) -> bool:
    first, last = mutation.lines
    return any(first - NEAR <= f.line <= last + NEAR for f in found if f.line is not None)


def test_damage_is_found_where_it_is() -> None:
    """All mutations count, those too that leave a program which means something else."""
    missed = [mutation.name for mutation, found in damaged() if not is_near(mutation, found)]
    assert len(damaged()) >= 300
    assert len(missed) <= (1 - LEAST) * len(damaged()), missed


def test_findings_point_into_the_text() -> None:
    for mutation, found in damaged():
        lines = mutation.text.split("\n")
        for finding in found:
            assert finding.line is not None
            assert finding.column is not None
            assert finding.excerpt == lines[finding.line - 1]
            assert 1 <= finding.column <= len(finding.excerpt) + 1
            assert finding.cure
