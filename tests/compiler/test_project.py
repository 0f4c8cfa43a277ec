"""What a project's file states about its controllers, and the programs beside a program."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Refused
from assistant.compiler import check_files
from assistant.compiler.loader import with_project_settings
from assistant.findings.severities import severities_for
from assistant.program.project_file import project_of

LONG = "1 MABCDEFGHIJKLMNOPQRST=1\n2 M_Out(1)=MABCDEFGHIJKLMNOPQRST\n3 Dly 1\n"
"""A name of 21 characters."""


def write(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def codes(*files: Path) -> list[str]:
    return [f.code for f in check_files(files).findings]


def test_a_project_states_the_length_of_names(tmp_path: Path) -> None:
    program = write(tmp_path / "cell" / "PICK.prg", LONG)
    assert codes(program) == []
    write(tmp_path / "assistant.toml", "[melfa-basic]\nname-length = 20\n")
    assert codes(program) == ["MB106"]
    write(tmp_path / "assistant.toml", "[melfa-basic]\nname-length = 21\n")
    assert codes(program) == []


def test_a_project_states_the_length_of_steps(tmp_path: Path) -> None:
    program = write(tmp_path / "PICK.prg", "1 Dly 1 '" + "x" * 200 + "\n")
    assert codes(program) == []
    table = "[tool.robot-assistant.melfa-basic]\nstep-length = 127\n"
    write(tmp_path / "pyproject.toml", table)
    assert codes(program) == ["MB107"]


@pytest.mark.parametrize(
    ("table", "code", "line"),
    [
        ("[melfa-basic]\nname_length = 20\n", "CO304", 2),
        ("[melfa-basic]\nname-length = 7\n", "CO305", 2),
        ("[melfa-basic]\nname-length = true\n", "CO305", 2),
        ('[melfa-basic]\nname-length = "20"\n', "CO305", 2),
        ("melfa-basic = 20\n", "CO306", 1),
        ('[melfa-basic]\nhalves = "down"\n', "CO307", 2),
        ("[melfa-basic]\nremainder = 1\n", "CO307", 2),
    ],
)
def test_settings_that_are_none(tmp_path: Path, table: str, code: str, line: int) -> None:
    program = write(tmp_path / "PICK.prg", LONG)
    settings = write(tmp_path / "assistant.toml", table)
    checked = check_files([program])
    assert [(f.code, f.line, f.path) for f in checked.findings] == [(code, line, str(settings))]
    assert checked.unreadable
    with pytest.raises(Refused) as refused:
        with_project_settings(languages.get("melfa-basic-6"), tmp_path)
    assert refused.value.exit_status == 2


def test_settings_of_a_language_are_no_odd_keys_of_a_project(tmp_path: Path) -> None:
    write(tmp_path / "assistant.toml", "[melfa-basic]\nname-length = 20\n[melfa]\na = 1\n")
    assert [(f.code, f.line) for f in severities_for(tmp_path).findings] == [("FN101", 3)]


def test_a_language_without_settings_is_as_it_is(tmp_path: Path) -> None:
    write(tmp_path / "assistant.toml", "[melfa-basic]\nname-length = 20\n")
    rapid = languages.get("rapid")
    assert with_project_settings(rapid, tmp_path) is rapid
    melfa = languages.get("melfa-basic-5")
    assert with_project_settings(melfa, tmp_path) is not melfa
    (tmp_path / "assistant.toml").unlink()
    assert with_project_settings(melfa, tmp_path) is melfa
    assert project_of(tmp_path) is None


def test_programs_of_other_slots_are_read_from_beside(tmp_path: Path) -> None:
    start = write(tmp_path / "START.prg", '1 XRun 2,"work"\n')
    assert codes(start) == ["MB115"]
    write(tmp_path / "WORK.prg", "1 Mov P_Safe\n2 GoTo *X\n")
    assert codes(start) == ["MB707"]  # and nothing of what is wrong in the other file
    write(tmp_path / "WORK.prg", "1 GetM 1\n2 Mov P_Safe\n")
    assert codes(start) == []


def test_a_called_file_is_told_of_once(tmp_path: Path) -> None:
    write(tmp_path / "A.prg", '1 CallP "C"\n')
    write(tmp_path / "B.prg", '1 CallP "C"\n')
    write(tmp_path / "C.prg", "1 Dly 1\n2 GoTo *X\n")
    assert codes(tmp_path) == ["MB101"]
