"""Rules of several programs, advice, and what holds for all rules."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import assistant
from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.base.source_text import SourceText
from assistant.languages.melfa_basic.checks import CHECKS
from tests.languages.melfa_basic.ruled import QUIET, found, taught
from tests.tables import every_row

SAMPLES = Path(__file__).parents[3] / "samples"


@every_row(
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
        (["M_Out(1)=M_ABC", "M_ABD=1"], ["MB114 1:10"]),
        (["M_Out(1)=M_ABC", "M_ABC=1"], []),
        (['CallP "B"\nM_02=0', "M_Out(1)=M_02"], []),
        (["Print #1,5", 'Open "COM1:" As #1\nCallP "A"\nClose #1'], []),
    ],
)
def test_programs_together(texts: list[str], expected: list[str]) -> None:
    assert found(5, *texts) == expected


STARTS_B = 'XRun 2,"B"'


@every_row(
    ("texts", "expected"),
    [
        # straight on
        ([f"{STARTS_B}\nM_02=0", "Wait M_02=0"], ["MB148 1:8"]),
        ([f"M_02=0\n{STARTS_B}", "Wait M_02=0"], []),
        ([f"{STARTS_B}\nM_02=0", "M_02=1\nWait M_02=0"], []),
        (['XLoad 2,"b"\nXRun 2\nM_02=0', "M_02=M_02+1"], ["MB148 2:1"]),
        ([STARTS_B, "M_02=M_02+1"], []),
        ([f'{STARTS_B}\nXRun 3,"C"', "Wait M_02=1", "Dly 1\nM_02=1"], ["MB148 1:8"]),
        ([f"{STARTS_B}\nWait M_02=1", "Dly 1\nM_02=1"], ["MB149 2:6"]),
        ([f"M_02=0\n{STARTS_B}\nWait M_02=1", "Dly 1\nM_02=1"], []),
        # jumps: the line that sets it stands above and is jumped over, or below and comes first
        ([f"GoTo *S\nM_02=0\n*S\n{STARTS_B}\nM_02=1", "Wait M_02=1"], ["MB141 2:1", "MB148 4:8"]),
        ([f"GoTo *S\n*R\n{STARTS_B}\nEnd\n*S\nM_02=0\nGoTo *R", "Wait M_02=1"], []),
        ([f"If M_In(1)=1 Then *S\nM_02=0\n*S\n{STARTS_B}", "Wait M_02=1"], ["MB148 4:8"]),
        ([f"{STARTS_B}\nM_02=0", "GoTo *S\n*R\nWait M_02=0\nEnd\n*S\nM_02=1\nGoTo *R"], []),
        ([f"{STARTS_B}\nM_02=0", "GoTo *S\nWait M_02=0\n*S\nDly 1"], []),
        # branches
        ([f"If M_In(1)=1 Then M_02=0\n{STARTS_B}", "Wait M_02=0"], ["MB148 2:8"]),
        ([f"If M_In(1)=1 Then M_02=0 Else M_02=1\n{STARTS_B}", "Wait M_02=0"], []),
        ([f"If M_In(1)=1 Then\nM_02=0\nEndIf\n{STARTS_B}", "Wait M_02=0"], ["MB148 4:8"]),
        ([f"If M_In(1)=1 Then\nM_02=0\nElse\nM_02=1\nEndIf\n{STARTS_B}", "Wait M_02=0"], []),
        ([f"{STARTS_B}\nM_02=0", "If M_In(1)=1 Then M_02=1\nWait M_02=1"], ["MB148 1:8"]),
        # loops: the first round comes before what a later one sets
        ([f"*L\n{STARTS_B}\nM_02=0\nGoTo *L", "Wait M_02=0"], ["MB148 2:8"]),
        ([f"M_02=0\n*L\n{STARTS_B}\nM_02=0\nGoTo *L", "Wait M_02=0"], []),
        ([f"While M_In(1)=1\nM_02=0\nWEnd\n{STARTS_B}", "Wait M_02=0"], ["MB148 4:8"]),
        ([f"{STARTS_B}\nM_02=0", "*L\nDly M_02\nM_02=1\nGoTo *L"], ["MB148 1:8"]),
        # subroutines, interrupts, programs that are called
        ([f"GoSub *S\n{STARTS_B}\nEnd\n*S\nM_02=0\nReturn", "Wait M_02=0"], []),
        (
            [
                f"GoSub *S\n{STARTS_B}\nEnd\n*S\nIf M_In(1)=1 Then *R\nM_02=0\n*R\nReturn",
                "Wait M_02=0",
            ],
            ["MB148 2:8"],
        ),
        ([f"M_02=0\nGoSub *S\nEnd\n*S\n{STARTS_B}\nReturn", "Wait M_02=0"], []),
        ([f"{STARTS_B}\nM_02=0", "GoSub *S\nEnd\n*S\nDly M_02\nReturn"], ["MB148 1:8"]),
        (
            [
                f"{STARTS_B}\nM_02=0",
                "Def Act 1,M_In(1)=1 GoSub *S\nM_02=0\nAct 1=1\nEnd\n*S\nDly M_02\nReturn 0",
            ],
            ["MB148 1:8"],
        ),
        (
            [
                f"{STARTS_B}\nM_02=0",
                "M_02=0\nDef Act 1,M_In(1)=1 GoSub *S\nAct 1=1\nEnd\n*S\nDly M_02\nReturn 0",
            ],
            [],
        ),
        ([f'CallP "C"\n{STARTS_B}', "Wait M_02=0", "M_02=0\nEnd"], []),
        ([f'{STARTS_B}\nCallP "C"', "Wait M_02=0", "Dly 1\nM_02=0"], ["MB148 1:8"]),
        ([f"{STARTS_B}\nM_02=0", 'CallP "C"', "Wait M_02=0"], ["MB148 1:8"]),
        ([STARTS_B, "Wait M_02=0", 'M_02=0\nCallP "A"'], []),
        # a wait for what only these programs give hands over what was set before
        (
            [f"M_01=0\n{STARTS_B}\nM_02=5\nM_01=1", "Wait M_01=1\nDly M_02"],
            [],
        ),
        (
            [f"M_01=0\n{STARTS_B}\nM_01=1\nM_02=5", "Wait M_01=1\nDly M_02"],
            ["MB148 2:8"],
        ),
        (
            [f"M_01=1\n{STARTS_B}\nM_02=5\nM_01=1", "Wait M_01=1\nDly M_02"],
            ["MB148 2:8"],
        ),
        ([f"M_01=0\n{STARTS_B}\nWait M_01=1\nDly M_02", "M_02=5\nM_01=1"], []),
        # which program a slot has loaded
        (['XLoad 2,"C"\nXLoad 2,"B"\nXRun 2\nM_02=0', "Wait M_02=0", "Dly 1"], ["MB148 3:1"]),
        (['XLoad 2,"B"\nXLoad 2,"C"\nXRun 2\nM_02=0', "Wait M_02=0", "Dly 1"], []),
    ],
)
def test_variables_that_slots_share(texts: list[str], expected: list[str]) -> None:
    assert found(5, *texts, quiet=("MB116", "MB710", "MB123")) == expected


def test_which_line_sets_a_shared_variable_too_late() -> None:
    trees = [
        languages.get("melfa-basic-5").parse(SourceText(text, f"{name}.prg"))
        for name, text in (
            ("A", 'XRun M1,"B"\nCallP "INIT"\n'),
            ("B", 'Dly 1\nCallP "SUB"\n'),
            ("SUB", "Dly M_02\n"),
            ("INIT", "Dly 1\nM_02=0\n"),
        )
    ]
    (told,) = (f for f in languages.get("melfa-basic-5").check(trees) if f.code == "MB148")
    assert told.message == (
        "`B`, which starts here in another slot, reads `M_02` in line 1 of `SUB`, and line 2 of "
        "`INIT` may not have set it by then: it finds 0, or what the last run left there"
    )


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


@pytest.mark.one_in(2)
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
