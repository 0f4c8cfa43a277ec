"""Rules of several programs, advice, and what holds for all rules."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.languages.melfa_basic.checks import CHECKS
from assistant.program.diagnostics import Severity
from tests.languages.melfa_basic.ruled import QUIET, found, taught

SAMPLES = Path(__file__).parents[3] / "samples"


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (['CallP "B"'], ["MB123 1:7"]),
        (['CallP "B"', "Dly 1"], []),
        (['CallP "b"', "Dly 1"], []),
        (['XRun 2,"B"\nXLoad 3,"C"', "Dly 1"], ["MB115 2:9"]),
        (['CallP "B"', 'CallP "C"', 'CallP "A"'], ["MB143 1:1"]),
        (['CallP "B"', 'CallP "C"', "Dly 1"], []),
        (['XRun 2,"B"', "Mov P_Safe"], ["MB707 1:8"]),
        (['XRun 2,"B"', "GetM 1\nMov P_Safe"], []),
        (['XRun 1,"B"', "Mov P_Safe"], []),
        (["M_Out(1)=M_ABC", "M_ABC=1"], ["MB114 1:10"]),
        (['XRun 2,"B"\nM_02=0', "Wait M_02=0"], ["MB148 1:8"]),
        (['M_02=0\nXRun 2,"B"', "Wait M_02=0"], []),
        (['XRun 2,"B"\nM_02=0', "M_02=1\nWait M_02=0"], []),
        (['XLoad 2,"b"\nXRun 2\nM_02=0', "M_02=M_02+1"], ["MB148 2:1"]),
        (['XRun 2,"B"', "M_02=M_02+1"], []),
        (['XRun 2,"B"\nXRun 3,"C"', "Wait M_02=1", "Dly 1\nM_02=1"], ["MB148 1:8"]),
        (['XRun 2,"B"\nWait M_02=1', "Dly 1\nM_02=1"], ["MB114 2:6", "MB149 2:6"]),
        (['M_02=0\nXRun 2,"B"\nWait M_02=1', "Dly 1\nM_02=1"], []),
        (['CallP "B"\nM_02=0', "M_Out(1)=M_02"], []),
        (["Print #1,5", 'Open "COM1:" As #1\nCallP "A"\nClose #1'], []),
    ],
)
def test_programs_together(texts: list[str], expected: list[str]) -> None:
    assert found(5, *texts) == expected


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("PICK2", []),
        ("pick", []),
        ("ABCDEFGHIJKL", []),
        ("ABCDEFGHIJKLM", ["MB118 None:None"]),
        ("PICK_2", ["MB118 None:None"]),
    ],
)
def test_names_of_programs(name: str, expected: list[str]) -> None:
    assert found(5, "Dly 1", first=name) == expected
    assert found(5, taught("P1"), first=name) == []


def test_what_nothing_uses() -> None:
    text = "*A\nM1=1\nM2=2\nMov P1\nM_Out(1)=M2\n" + taught("P1", "P2", "P3")
    assert found(5, text, quiet=()) == [
        "MB116 1:1",
        "MB116 2:1",
        "MB710 4:1",
        "MB116 7:1",
    ]


def test_what_is_used() -> None:
    text = "Tool P_NTool\n*A\nMov P1*P2\nFor M1=1 To 3\nNext\nGoTo *A\n" + taught("P1", "P2")
    assert found(5, text, quiet=()) == []


def test_advice_is_not_asked_about_what_was_compiled() -> None:
    text = "' robot-assistant: melfa-basic-5\nMov P1\n" + taught("P1", "P2")
    assert found(5, text, quiet=()) == []


@pytest.mark.parametrize("version", [4, 5, 6])
@pytest.mark.parametrize("sample", ["positioning.csv", "taught.toml", "plate.dxf"])
def test_what_is_compiled_breaks_no_rule(sample: str, version: int) -> None:
    name = f"melfa-basic-{version}"
    language = languages.get(name)
    compiled = assistant.compile(SAMPLES / sample, language=name, robot="rv-4frl")
    texts = [language.decode(data, file) for file, data in compiled.files.items()]
    assert texts
    assert language.check([language.parse(text) for text in texts]) == ()


@pytest.mark.parametrize("file", sorted((SAMPLES / "melfa").glob("*.prg")), ids=lambda f: f.stem)
def test_samples_break_no_rule(file: Path) -> None:
    language = languages.of_file(file, file.read_bytes())
    assert language is not None
    findings = language.check([language.parse(language.read(file))])
    assert {f.severity for f in findings} <= {Severity.INFO}


def test_positions_may_be_taught_on_the_controller() -> None:
    language = languages.get("melfa-basic-5")
    for lines in ("", taught("P2")):
        tree = language.parse(f"Mov P1\n{lines}\n")
        severities = [f.severity for f in language.check([tree]) if f.code == "MB104"]
        assert severities == [Severity.WARNING]


def test_a_tree_without_source_is_checked_as_well() -> None:
    language = languages.get("melfa-basic-5")
    tree = language.parse("Mov P1\nGoTo *X\n")
    bare = replace(tree, source=None)
    codes = {f.code for f in language.check([bare])}
    assert {"MB101", "MB104"} <= codes


def test_every_rule_is_listed_once() -> None:
    assert len({check.find for check in CHECKS}) == len(CHECKS)


def test_long_programs_stay_in_columns() -> None:
    """Thousands of moves with one mistake each give a handful of findings."""
    count = 3000
    moves = "".join(f"{i} MVS P{i}\n" for i in range(1, count + 1))
    rows = "".join(
        f"P{i}=(+{i}.00,+0.00,+300.00,+180.00,+0.00,+180.00)({6 + i % 2},0)\n"
        for i in range(1, count + 1)
    )
    language = languages.get("melfa-basic-5")
    tree = language.parse(moves + rows)
    assert len(tree.items) == 2
    findings = language.check([tree])
    assert [f.code for f in findings if f.code not in QUIET] == ["MB702"] * 5
    assert "2994 more" in findings[-1].message + findings[-2].message
