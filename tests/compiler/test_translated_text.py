"""Comments, blank lines and names of a translation stand as a reader of the source expects them."""

from pathlib import Path

import pytest

from assistant.compiler import Translation, translate
from assistant.compiler.loader import language_of

HOME = "[[400,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
MODULE = f"""MODULE Cell
  ! Cell of J. Müller
  CONST robtarget pHome:={HOME}; ! taught in May
  VAR num nCount:=0;

  ! What it does
  PROC main()
    ! go home first
    MoveL pHome,v500,fine,tool0; ! slowly

    ! MoveL pHome,v100,fine,tool0;
    WHILE nCount<3 DO
      Place_part 2; ! twice
    ENDWHILE ! all of them
    IF nCount=1 THEN
      nCount:=2;
    ELSE ! not yet
      nCount:=3;
    ENDIF
  ENDPROC

  ! Puts a part down
  PROC Place_part(num nTimes)
    nCount:=nCount+nTimes; ! counts
  ENDPROC
ENDMODULE
"""
PROGRAM = """1 ' weld
2 Spd 100 ' slow
3 Mvs P1 ' \u539f\u70b9
4 '
5 ' \u30c1\u30a7\u30c3\u30af\u3001OK
6 M_Out(5)=1 ' \u00c4pfel
7 If M_In(8)=1 Then ' asked
8 Dly 0.5 ' settle
9 EndIf
10 Mvs P1,-50 ' away
11 End
P1=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)
"""


def of_rapid(folder: Path, to: str) -> Translation:
    file = folder / "Cell.mod"
    file.write_text(MODULE, encoding="utf-8")
    return translate(file, to=to)


def text(found: Translation) -> list[str]:
    """The lines, without their step numbers; behind the heading."""
    assert found.ok, found.findings
    (data,) = found.files.values()
    lines = language_of(found.language).decode(data).text.splitlines()
    return [line.partition(" ")[2] if line[:1].isdigit() else line for line in lines]


def test_comments_of_rapid_stay_at_their_statements(tmp_path: Path) -> None:
    lines = text(of_rapid(tmp_path, "melfa-basic-6"))
    assert lines[:2] == ["' Cell of J. Müller", "' pHome: taught in May"]
    code = lines[lines.index("' robot-assistant: end") + 1 :]
    assert code == [
        "Def Float MnCount",
        "' nCount: kept from cycle to cycle; a cycle stop does not end this loop",
        "Function V Main()",
        "    MnCount=0",
        "    While 1",
        "        cycle()",
        "    WEnd",
        "FEnd",
        "' What it does",
        "Function V cycle()",
        "    ' go home first",
        "    Tool P_NTool",
        "    Base P_NBase",
        "    Spd 500",
        "    Cnt 0",
        "    Mvs pHome ' slowly",
        "    '",
        "    ' MoveL pHome,v100,fine,tool0;",
        "    While MnCount<3",
        "        Place_part(2) ' twice",
        "    WEnd ' all of them",
        "    If MnCount=1 Then",
        "        MnCount=2",
        "    Else",
        "        ' not yet",
        "        MnCount=3",
        "    EndIf",
        "FEnd",
        "' Puts a part down",
        "Function V Place_part(ByVal MnTimes)",
        "    MnCount=MnCount+MnTimes ' counts",
        "FEnd",
        "pHome=(+400.00,+0.00,+500.00,+180.00,+0.00,+180.00)(7,0)",
    ]


@pytest.mark.parametrize("to", ["melfa-basic-4", "melfa-basic-5"])
def test_versions_that_store_upper_case_get_it(tmp_path: Path, to: str) -> None:
    lines = text(of_rapid(tmp_path, to))
    assert any(line.casefold() == "mvs phome ' slowly" and "PHOME" in line for line in lines)
    assert "'" in lines[lines.index("' robot-assistant: end") :]


def test_a_comment_that_a_line_has_no_room_for_stands_above_it(tmp_path: Path) -> None:
    file = tmp_path / "Cell.mod"
    long = "a " * 48 + "b"
    file.write_text(MODULE.replace("! slowly", f"! {long}").replace("pHome", "pHomeOfTheCell"))
    lines = text(translate(file, to="melfa-basic-6"))
    at = lines.index("    Mvs pHomeOfTheCell")
    assert f"    ' {long}" in lines[:at]


def test_names_that_differ_in_case_alone_stay_apart(tmp_path: Path) -> None:
    """A position and a procedure of one name; `p_` would be a name that programs share."""
    file = tmp_path / "Cell.mod"
    file.write_text(
        f"MODULE Cell\nCONST robtarget p_Home:={HOME};\nVAR num M_Home:=1;\nPROC main()\n"
        "MoveL p_Home,v500,fine,tool0;\npHome;\nENDPROC\nPROC pHome()\nM_Home:=2;\n"
        "ENDPROC\nENDMODULE\n"
    )
    lines = text(translate(file, to="melfa-basic-6"))
    assert {"Mvs pHome", "GoSub *pHome2", "*pHome2", "MHome=2"} <= set(lines)


def test_comments_of_melfa_basic_stay_at_their_statements(tmp_path: Path) -> None:
    file = tmp_path / "CELL.prg"
    file.write_text(PROGRAM, encoding="utf-8")
    found = translate(file, to="rapid", language="melfa-basic-6")
    lines = [line.strip() for line in text(found)]
    at = lines.index("PROC main()")
    assert lines[at + 1 : -1] == [
        "! slow",
        r"MoveL P1,v100,fine,tool0; ! \u539f\u70b9",
        "!",
        "! chekku, OK",
        "SetDO do_5,1; ! Aepfel",
        "! asked",
        "IF di_8=1 THEN",
        "WaitTime 0.5; ! settle",
        "ENDIF",
        "MoveL RelTool(P1,0,0,-50),v100,fine,tool0; ! away",
        "ENDPROC",
    ]
    told = [f.message for f in found.findings if f.code == "RA306"]
    assert any("the comment `\u539f\u70b9`" in message for message in told)
