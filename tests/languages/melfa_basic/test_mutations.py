"""Damaged programs: nothing raises, and the findings stand where the damage is."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Severity
from tests.languages.melfa_basic.mutations import KINDS, PROGRAMS, Mutation, language_of, mutations

LEAST, LEAST_MISSPELT, LEAST_NEEDED = 0.95, 0.90, 0.85


@cache
def damaged(*kinds: str) -> tuple[tuple[Mutation, list[Diagnostic]], ...]:
    """Each mutation with what is found in it."""
    made = mutations(kinds) if kinds else mutations()
    return tuple(found_in(made))


def found_in(made: Iterable[Mutation]) -> Iterator[tuple[Mutation, list[Diagnostic]]]:
    return ((one, findings_of(one.program, one.text)) for one in made)


def findings_of(program: str, text: str) -> list[Diagnostic]:
    language = languages.get(language_of(program))
    tree = language.parse(text)
    assert language.render(tree) == text
    language.lift(tree)
    found = (*tree.findings, *language.check([tree]))
    return [f for f in dict.fromkeys(found) if f.severity is not Severity.INFO]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.name)
def test_the_undamaged_programs_have_no_findings(path: Path) -> None:
    assert findings_of(path.name, path.read_text(encoding="utf-8")) == []


@pytest.mark.slow
def test_damage_is_found_where_it_is() -> None:
    """All mutations count, those too that leave a program which means something else."""
    missed = [mutation.name for mutation, found in damaged() if not mutation.is_near(found)]
    assert len(damaged()) >= 300
    assert len(missed) <= (1 - LEAST) * len(damaged()), missed


@pytest.mark.slow
def test_a_misspelt_word_is_found_or_named() -> None:
    """Near it, or where the name is used that a misspelt declaration no longer gives."""

    def said(mutation: Mutation, found: list[Diagnostic]) -> bool:
        (word,) = mutation.tokens
        return mutation.is_near(found) or any(word.lower() in f.message.lower() for f in found)

    cases = damaged("misspelt")
    missed = [mutation.name for mutation, found in cases if not said(mutation, found)]
    assert len(missed) <= (1 - LEAST_MISSPELT) * len(cases), missed


NEEDED = re.compile(
    r"\d+ +(\*\w+|if\b.*\bthen|endif|for\b.*|next\b.*|while\b.*|wend|select\b.*|end select"
    r"|function\b.*|fend)$|[PJ]\w+=.*",
    re.IGNORECASE,
)
"""Lines that another one relies on: labels, what opens and closes a block, positions."""


def without_a_needed_line() -> Iterator[tuple[str, str, str]]:
    for path in PROGRAMS:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        for at, line in enumerate(lines):
            if NEEDED.match(line.rstrip()):
                yield path.name, line.rstrip(), "".join((*lines[:at], *lines[at + 1 :]))


@pytest.mark.slow
def test_a_line_that_another_needs_is_missed() -> None:
    cases = list(without_a_needed_line())
    missed = [f"{name}: {line}" for name, line, text in cases if not findings_of(name, text)]
    assert len(cases) > 80
    assert len(missed) <= (1 - LEAST_NEEDED) * len(cases), missed


def test_findings_point_into_the_text() -> None:
    """In every fourth of the damaged programs, of all kinds of damage and all programs."""
    made = [*mutations(), *mutations(("line dropped",))][::4]
    assert {(one.program, one.kind) for one in made} == {
        (path.name, kind) for path in PROGRAMS for kind in (*KINDS, "line dropped")
    }
    point_into_the_text(found_in(made))


@pytest.mark.slow
def test_findings_point_into_the_text_of_all_damaged_programs() -> None:
    point_into_the_text((*damaged(), *damaged("line dropped")))


def point_into_the_text(cases: Iterable[tuple[Mutation, list[Diagnostic]]]) -> None:
    for mutation, found in cases:
        for finding in found:
            assert mutation.holds(finding), finding
