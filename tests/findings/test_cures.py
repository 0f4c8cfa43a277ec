"""Cures can be followed: what they name is there, and doing as they say ends the finding."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import assistant
from assistant.findings.rulebook import rules
from tests.findings.cures import (
    calibrating,
    cells,
    controllers,
    drawings,
    following,
    keeping,
    leading,
    placing,
    programs,
    seeing,
    shaping,
    standing,
    styling,
    tables,
)
from tests.findings.cures.case import Bench, Case, follow
from tests.findings.cures.naming import FOLLOWED, OPTION, followable, in_text, named
from tests.findings.cures.not_followed import NOT_FOLLOWED, NOT_WRITTEN

PACKAGE = Path(assistant.__file__).parent
OTHER_PROGRAMS = ("base/installation.py", "deploy/repository.py", "virtual/cr/mxt_process.py")
"""What calls programs that are none of ours, or itself, with options of their own."""
SENTENCES = {"robot-assistant itself failed"}
MODULES = (
    *(drawings, following, cells, programs, tables, controllers),
    *(placing, shaping, standing, keeping, seeing, calibrating),
    *(leading, styling),
)
CASES: tuple[Case, ...] = tuple(one for module in MODULES for one in module.CASES)


def test_whatever_a_cure_names_is_there() -> None:
    unknown = {
        rule.code: [one.text for one in named(rule) if one.kind is None]
        for rule in rules().values()
    }
    assert {code: names for code, names in unknown.items() if names} == {}


def test_whatever_else_the_package_says_names_options_and_commands_that_are_there() -> None:
    """Cures that are put together where a fault is seen stand in no table."""
    files = sorted(PACKAGE.rglob("*.py"))
    unknown = [
        f"{file.relative_to(PACKAGE)}:{line}: {one.text}"
        for file in files
        if file.relative_to(PACKAGE).as_posix() not in OTHER_PROGRAMS
        for line, text in _said(file.read_text("utf-8"))
        for one in in_text(text)
        if one.kind is None and not any(said in text for said in SENTENCES)
    ]
    assert len(files) > 100
    assert unknown == []


def test_every_cure_that_names_something_is_followed_or_says_why_not() -> None:
    wanted = {code for code, rule in rules().items() if followable(rule)}
    followed = {case.code for case in CASES}
    assert wanted - followed - set(NOT_FOLLOWED) == set()
    assert set(NOT_FOLLOWED) & followed == set()
    assert set(NOT_FOLLOWED) <= wanted
    assert all(len(reason) > 20 for reason in NOT_FOLLOWED.values())


def test_everything_that_a_followed_cure_names_is_written() -> None:
    missed = {
        (case.code, one.text)
        for case in CASES
        for one in named(rules()[case.code])
        if one.kind in FOLLOWED and not set(one.text.split()) <= _written(case.code)
    }
    assert missed == set(NOT_WRITTEN)


def _parameter(number: int, case: Case) -> object:
    slow = case.slow or case in controllers.CASES
    marks = [pytest.mark.slow] if slow else []
    return pytest.param(case, marks=marks, id=f"{case.code} {number}")


def _written(code: str) -> set[str]:
    """Words, and parts of those with dots, that following the cure of a rule writes."""
    words = {word for case in CASES if case.code == code for word in case.written}
    return words | {part for word in words for part in word.split(".")}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", [_parameter(number, one) for number, one in enumerate(CASES)])
def test_who_follows_a_cure_is_rid_of_the_finding(
    case: Case,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("webbrowser.open", lambda *_: False)
    follow(case, Bench(tmp_path, capsys, monkeypatch))


def _said(text: str) -> Iterator[tuple[int, str]]:
    """The texts of a module with their lines, but for what documents it; none of a module in which
    nothing looks like an option or a command.
    """
    if NAMING.search(text) is None:
        return
    notes: set[int] = set()
    for one in ast.walk(ast.parse(text)):  # an expression comes before what is in it
        if isinstance(one, ast.Expr):
            notes.add(id(one.value))
        elif isinstance(one, ast.Constant) and isinstance(one.value, str) and id(one) not in notes:
            yield one.lineno, one.value


NAMING = re.compile(f"{OPTION.pattern}|robot-assistant")
