"""Whatever a command fails at, it answers in the form that it was asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click import FLOAT, INT, Choice, Context

from assistant.cli import main
from assistant.cli.app import app
from tests.cli.tables import each

LONG = "a" * 300
"""Longer than a name of a file may be on any system."""


def commands(group: Any, *names: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name in group.list_commands(Context(group)):
        command = group.get_command(Context(group), name)
        if hasattr(command, "commands"):
            yield from commands(command, *names, name)
        else:
            yield (*names, name), command


def forms() -> Iterator[tuple[tuple[str, ...], str]]:
    """Every command with `--format`, and each form that programs read."""
    for names, command in commands(app):
        for option in command.params:
            if option.name == "format":
                for form in {"json", "sarif"} & set(option.type.choices):
                    yield (*names, *arguments(command, form)), form


def arguments(command: Any, form: str) -> Iterator[str]:
    yield f"--format={form}"
    for one in command.params:
        if one.required or one.param_type_name == "argument":
            if one.param_type_name == "option":
                yield one.opts[0]
            is_number = isinstance(one.type, (type(INT), type(FLOAT)))
            choices = one.type.choices if isinstance(one.type, Choice) else ()
            yield choices[0] if choices else "1" if is_number else LONG


def test_a_name_that_no_file_can_have(capfd: Any, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    known = sorted(forms())
    assert len(known) > 60

    def check(*words: str) -> None:
        with pytest.raises(SystemExit) as end:
            main(list(words))
        answer = json.loads(capfd.readouterr().out)
        assert end.value.code in (0, 1, 2)
        if end.value.code and isinstance(answer, dict):
            assert answer.get("findings") or answer["runs"][0]["results"]
        assert not list(tmp_path.iterdir())

    each((words for words, _ in known), check)
