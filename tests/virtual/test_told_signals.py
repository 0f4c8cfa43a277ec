"""Signals that RAPID chooses as it runs: what is said for them elsewhere does the same."""

from __future__ import annotations

from pathlib import Path as FilePath

import pytest

from assistant import translate
from assistant.base.source_text import SourceText
from assistant.compiler.loader import load_text
from tests.virtual import rapid_words
from tests.virtual.test_translated_cases import HEAD
from tests.virtual.test_translated_rapid import says_the_same

SIX = "melfa-basic-6"
SCENARIOS: tuple[dict[str, float], ...] = ({}, {"di1": 1.0}, {"di1": 1.0, "giorder": 5.0})
DATA = """LOCAL VAR signaldo out;
LOCAL VAR signaldi in;
LOCAL VAR signalgi order;
LOCAL PERS string side:="1";
LOCAL VAR string name;
LOCAL VAR num n;
"""
CASES = {
    "one signal by a text that is worked out": r"""side:="1";
name:="di"+side;
AliasIO name,in;
IF in=1 SetDO do1,1;
WaitDI in,1\MaxTime:=2;""",
    "one of two, by name and by text": """FOR i FROM 1 TO 2 DO
IF i=1 THEN
AliasIO do1,out;
ELSE
AliasIO "doDone",out;
ENDIF
SetDO out,1;
IF DOutput(out)=1 AND di1=1 SetDO doGrip,1;
WHILE out=1 DO
Reset out;
ENDWHILE
ENDFOR""",
    "one of two, by a number in its name": r"""SetDO do1,0;
AliasIO "do"+NumToStr(1,0),out;
PulseDO\PLength:=0.2,out;
n:=out;
IF n=0 SetDO doDone,1;""",
    "by what a parameter says": """name_it "R";
AliasIO "di"+side,in;
IF TestDI(in) SetDO do1,1;
IF in=0 SetDO doDone,1;""",
    "a group, and a wait that tells": r"""VAR bool late;
AliasIO "giOrder",order;
IF GInput(order)=5 AliasIO "do1",out;
IF GInput(order)<>5 AliasIO "doDone",out;
Set out;
WaitUntil out=0 OR order>4\MaxTime:=1\TimeFlag:=late;
IF late SetDO doGrip,1;""",
}
MORE = """PROC name_it(string given)
IF given="R" THEN
side:="Part";
ELSE
side:="1";
ENDIF
ENDPROC
"""


def whole(body: str) -> str:
    return f"{HEAD}{DATA}PROC main()\n{body}\nENDPROC\n{MORE}ENDMODULE\n"


@pytest.mark.parametrize("name", CASES)
def test_it_does_the_same(name: str, tmp_path: FilePath) -> None:
    body = f"MoveL p10,v100,fine,tGripper;\n{CASES[name]}"
    says_the_same((name, whole(body), SCENARIOS), SIX, tmp_path)


def test_two_routines_of_one_name_in_two_modules(tmp_path: FilePath) -> None:
    two = "".join(
        f"MODULE M{n}\nLOCAL VAR signaldo out;\nLOCAL PROC same()\nAliasIO do{n},out;\n"
        f"SetDO out,1;\nENDPROC\nPROC go{n}()\nsame;\nENDPROC\nENDMODULE\n"
        for n in (1, 2)
    )
    done = translate(load_text(SourceText(two), language="rapid"), to=SIX, draft=True)
    assert done.rows


def crossed(body: str, tmp_path: FilePath) -> tuple[list[str], list[str]]:
    """The codes of what is found, and the statements that are not said."""
    process = tmp_path / "cell.process.toml"
    process.write_text(rapid_words.process_file(), encoding="utf-8")
    source = SourceText(whole(body))
    found = translate(load_text(source, process=process, language="rapid"), to=SIX)
    refused = [row.text for row in found.rows if row.level == "not"]
    return [one.code for one in found.findings], refused


def test_what_may_be_chosen_is_told(tmp_path: FilePath) -> None:
    codes, refused = crossed('AliasIO "di"+side,in;\nIF in=1 SetDO do1,1;', tmp_path)
    assert "RA393" in codes
    assert refused == []


@pytest.mark.parametrize("source", ["CTime()", "ArgName(n)"])
def test_a_name_that_nobody_knows_is_not_guessed(source: str, tmp_path: FilePath) -> None:
    _, refused = crossed(f"AliasIO {source},out;\nSetDO out,1;", tmp_path)
    assert f"AliasIO {source},out" in " ".join(refused)
