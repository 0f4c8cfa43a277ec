"""Truths, inverses and largest values of MELFA-BASIC in RAPID: what is exact is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import translate
from assistant.compiler.motion_proof import Proving

HEAD = "1 Tool P_NTool\n2 Base P_NBase\n"
POSITIONS = "P1=(400,0,300,180,0,180)(7,0)\nPR=(0,0,10,0,0,90)(7,0)\n"


def translated(folder: Path, line: str) -> tuple[str, list[str]]:
    file = folder / "A.prg"
    file.write_text(f"{HEAD}3 {line}\n4 End\n{POSITIONS}")
    made = translate(file, to="rapid", language="melfa-basic-5")
    text = "".join(data.decode() for data in made.files.values())
    body = " ".join(text.partition("PROC main()")[2].partition("ENDPROC")[0].split())
    return body, [f.code for f in made.findings]


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        ("M3=(M1=1)", "IF M1=1 THEN M3:=1; ELSE M3:=0; ENDIF"),
        ("M_Out(3)=M1>2", "IF M1>2 THEN SetDO do_3,1; ELSE SetDO do_3,0; ENDIF"),
        (
            "M_Out(11)=M_In(1) And M_In(2)",
            "IF di_1=1 AND di_2=1 THEN SetDO do_11,1; ELSE SetDO do_11,0; ENDIF",
        ),
        ("If Not M1=2 Then Hlt", "IF NOT (M1=2) THEN Stop; ENDIF"),
        ("If M1 Or M2 Then Hlt", "IF Round(M1)<>0 OR Round(M2)<>0 THEN Stop; ENDIF"),
        ("If M_Inb(8) Or M1=3 Then Hlt", "IF gi_8_8<>0 OR M1=3 THEN Stop; ENDIF"),
        ("M1=Max(M1,M2,M3)", "M1:=Max(Max(M1,M2),M3);"),
        ("M1=Min(M1,M2,M3,4)", "M1:=Min(Min(Min(M1,M2),M3),4);"),
        ("PQ=PW*Inv(PR)", "PQ:=RelTool(PW,0,0,-10\\Rx:=0\\Ry:=0\\Rz:=-90);"),
    ],
)
def test_what_is_exact_is_said(tmp_path: Path, line: str, wanted: str) -> None:
    assert translated(tmp_path, line)[0] == wanted


def test_the_inverse_of_a_constant_is_worked_out(tmp_path: Path) -> None:
    body, found = translated(tmp_path, "P2=Inv(P1)")
    assert body.startswith("P2:=[[400,0,300],[0,0,1,0],")
    assert not any(code in ("CO102", "CO103") for code in found)


@pytest.mark.parametrize("line", ["P2=Inv(P3)", "If Not M_In(1) Then Hlt", "M1=(M2>3)+1"])
def test_what_is_not_is_refused_in_words_of_its_own(tmp_path: Path, line: str) -> None:
    body, found = translated(tmp_path, line)
    assert body == ""
    assert not any(code in ("CO102", "CO103") for code in found)
    assert any(code.startswith("RA3") for code in found)


def test_booleans_come_back_as_such(tmp_path: Path) -> None:
    source = tmp_path / "m.mod"
    source.write_text(
        "MODULE m\nVAR bool x;\nVAR bool y;\nVAR bool z;\n"
        "PROC main()\nz:=(NOT x) OR y;\nIF NOT z Stop;\nENDPROC\nENDMODULE\n"
    )
    there = translate(source, to="melfa-basic-5")
    (name, data) = next(iter(there.files.items()))
    (tmp_path / name).write_bytes(data)
    back = translate(tmp_path / name, to="rapid")
    assert [f.code for f in back.findings if f.severity.name == "ERROR"] == []
    (text,) = back.files.values()
    assert b"IF NOT x OR y THEN" in text and b"z:=TRUE;" in text and b"z:=FALSE;" in text


COMPARING = """MODULE M
CONST robtarget p1:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR bool ok;
VAR num n:=2;
PROC main()
  MoveL p1,v100,fine,tool0;
  {statement}
  IF ok MoveL p1,v200,fine,tool0;
  ok:=FALSE;
ENDPROC
PROC check(bool given)
  ok:=given;
ENDPROC
FUNC bool full()
  RETURN n>=2;
ENDFUNC
ENDMODULE
"""


@pytest.mark.parametrize("to", ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"])
@pytest.mark.parametrize(
    ("statement", "condition"),
    [
        ("ok:=di19<>1;", "M_In(19)<>1"),
        ("ok:=n>1 AND di19=1;", "Mn>1 And M_In(19)=1"),
        ("ok:=(NOT ok) OR n=7;", "MOk=0 Or Mn=7"),
        ("check n>1;", "Mn>1"),
        ("ok:=full();", "Mn>=2"),
    ],
)
def test_what_a_comparison_gives_is_chosen_by_if(
    tmp_path: Path, to: str, statement: str, condition: str
) -> None:
    source, cell = tmp_path / "m.mod", tmp_path / "cell.toml"
    source.write_text(COMPARING.format(statement=statement))
    cell.write_text('[signals.di19]\nnumber = 19\ndirection = "input"\n')
    made = translate(source, to=to, cell=cell, proving=Proving())
    assert made.motion is not None and made.motion.holds
    text = b"".join(made.files.values()).decode().lower()
    comparing = [line for line in text.splitlines() if condition.lower() in line]
    assert comparing and all(f"if {condition.lower()} then" in line for line in comparing)


def test_a_chosen_truth_stays_what_a_program_of_a_dialect_says(tmp_path: Path) -> None:
    source = tmp_path / "A.prg"
    source.write_text(f"10 M1=(M2=1)\n20 MVS P1\n30 END\n{POSITIONS}")
    made = translate(source, to="melfa-basic-6", language="melfa-basic-4")
    assert "M1=M2=1" in b"".join(made.files.values()).decode().replace("(", "").replace(")", "")
