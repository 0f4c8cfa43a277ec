"""Laws of findings: each is of a rule with a page, says what to do, and stands in the text."""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from functools import cache
from itertools import islice

import pytest
from hypothesis import given

from assistant import languages
from assistant.base.diagnostics import Diagnostic, Rule, Severity
from assistant.findings import rulebook
from assistant.program.program import Program
from tests import strategies
from tests.languages.laws.subjects import WAITING, damaged, errors, every_language, few, written


@cache
def rules(name: str) -> dict[str, Rule]:
    """The rules that `robot-assistant explain` knows; with the toy's own room, for the toy."""
    if name != "toy":
        return dict(rulebook.rules())
    return {**rulebook.rules(), **own_rules(name)}


def own_rules(name: str) -> dict[str, Rule]:
    """The rules of a language's room, by code."""
    room = importlib.import_module(languages.ROOMS[name])
    family = languages.get(name).family
    return {r.code: r for r in rulebook.rules_in(room) if r.code.startswith(family)}


def are_of_rules(name: str, findings: Iterable[Diagnostic]) -> None:
    for finding in findings:
        assert finding.code in rules(name), finding
        assert finding.message and finding.cure, finding


def are_fixed(name: str, findings: Iterable[Diagnostic]) -> None:
    """A project cannot turn these errors down."""
    language = languages.get(name)
    for finding in errors(findings):
        own = finding.code.startswith(language.family)
        assert finding.code.startswith(language.fixed) or not own, finding


@every_language
def test_every_rule_of_a_language_has_a_page(name: str) -> None:
    known, language = rules(name), languages.get(name)
    assert own_rules(name)
    for code, rule in own_rules(name).items():
        assert known[code] == rule
        page = rulebook.section(rule)
        assert page.startswith(f"### {code}\n\n**{rule.severity}**: ")
        assert "What to do: " in page
    for prefix in language.fixed:
        severities = {r.severity for code, r in own_rules(name).items() if code.startswith(prefix)}
        assert Severity.ERROR in severities


def finds_what_points_into_the_text(name: str, start: int, step: int) -> None:
    """start, step: of the damages of the same text."""
    language = languages.get(name)
    (data,) = written(language, language.adapt(WAITING).program).values()
    spoilt = damaged(language.decode(data).text, language.comment_mark)
    for _, _, text in islice(spoilt, start, None, step):
        tree = language.parse(text)
        findings = (*tree.findings, *language.check([tree]))
        are_of_rules(name, findings)
        are_fixed(name, tree.findings)
        lines = text.splitlines()
        for finding in findings:
            assert finding.line is not None and finding.column is not None, finding
            assert finding.excerpt == lines[finding.line - 1]
            assert 1 <= finding.column <= len(finding.excerpt) + 1


@every_language
def test_what_is_found_in_a_damaged_text_points_into_it(name: str) -> None:
    """Those damages around which `test_texts.py` does not read."""
    finds_what_points_into_the_text(name, 1, 2)


@pytest.mark.slow
@every_language
def test_what_is_found_in_a_text_damaged_in_every_way_points_into_it(name: str) -> None:
    finds_what_points_into_the_text(name, 0, 1)


@every_language
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of numpy, at the largest of floats
@given(program=strategies.programs())
@few
def test_what_is_found_in_any_program_is_of_a_rule(name: str, program: Program) -> None:
    findings = languages.get(name).adapt(program).findings
    are_of_rules(name, findings)
    are_fixed(name, findings)
