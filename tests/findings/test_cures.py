"""Cures can be followed: what they name is there, and doing as they say ends the finding."""

from __future__ import annotations

import ast
from pathlib import Path

import assistant
from assistant.findings.rulebook import rules
from tests.findings.cures.naming import in_text, named

PACKAGE = Path(assistant.__file__).parent
OTHER_PROGRAMS = ("deploy/repository.py", "virtual/cr/mxt_process.py")
"""What calls programs that are none of ours, or itself, with options of their own."""
SENTENCES = {"robot-assistant itself failed"}


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
        for line, text in _said(ast.parse(file.read_text("utf-8")))
        for one in in_text(text)
        if one.kind is None and not any(said in text for said in SENTENCES)
    ]
    assert len(files) > 100
    assert unknown == []


def _said(tree: ast.Module) -> list[tuple[int, str]]:
    """The texts of a module with their lines, but for what documents it."""
    notes = {id(one.value) for one in ast.walk(tree) if isinstance(one, ast.Expr)}
    return [
        (one.lineno, one.value)
        for one in ast.walk(tree)
        if isinstance(one, ast.Constant) and isinstance(one.value, str) and id(one) not in notes
    ]
