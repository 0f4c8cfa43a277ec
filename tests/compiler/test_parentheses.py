"""Parentheses where the two languages, or readers, work out another operator first."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import translate
from assistant.compiler.motion_proof import Proving

PLACE = "P1=(400,0,300,180,0,180)(7,0)\n"
RAPID = """MODULE M
CONST robtarget p1:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR num a:=7;
VAR num b:=3;
VAR num c:=2;
VAR num d;
PROC main()
  MoveL p1,v100,fine,tool0;
  {statement}
  WHILE d<>0 DO
    d:=0;
  ENDWHILE
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize(
    ("source", "wanted"),
    [
        ("(M1 Mod 3)*45", "(M1 MOD 3)*45"),
        ("M1 Mod 3*2", "M1 MOD (3*2)"),
        ("M1*M2 Mod 3", "(M1*M2) MOD 3"),
        ("M1+M2 Mod 3", "M1+(M2 MOD 3)"),
        ("M1\\2*3", "M1 DIV (2*3)"),
        ("M1*2+M2/3", "M1*2+M2/3"),
        ("M1-(M2-1)", "M1-(M2-1)"),
    ],
)
def test_quotients_from_melfa_basic(tmp_path: Path, source: str, wanted: str) -> None:
    file = tmp_path / "A.prg"
    file.write_text(f"M1=7\nM2=5\nM3={source}\nMvs P1\nIf M3>2 Then Mvs P1\nEnd\n{PLACE}")
    done = translate(file, to="rapid", language="melfa-basic-5", proving=Proving())
    assert done.motion is not None and done.motion.holds
    assert f"M3:={wanted};" in b"".join(done.files.values()).decode()


@pytest.mark.parametrize(
    ("statement", "wanted"),
    [
        ("d:=(a MOD b)*45;", "MD=(MA Mod MB)*45"),
        ("d:=a MOD b*c;", "MD=(MA Mod MB)*MC"),
        ("d:=a*b DIV c;", "MD=(MA*MB)\\MC"),
        ("d:=a MOD (b*c);", "MD=MA Mod (MB*MC)"),
        ("d:=-Pow(a,2);", "MD=-(MA^2)"),
        ("d:=a*b+c/2;", "MD=MA*MB+MC/2"),
        ("IF a=1 AND b=1 OR c=2 d:=1;", "(MA=1 And MB=1) Or MC=2"),
        ("IF a=1 OR b=1 AND c=2 d:=1;", "MA=1 Or (MB=1 And MC=2)"),
        ("IF a=1 OR b=1 OR c=2 d:=1;", "MA=1 Or MB=1 Or MC=2"),
    ],
)
def test_quotients_and_logic_from_rapid(tmp_path: Path, statement: str, wanted: str) -> None:
    file = tmp_path / "m.mod"
    file.write_text(RAPID.format(statement=statement))
    done = translate(file, to="melfa-basic-5", proving=Proving())
    assert done.motion is not None and done.motion.holds
    assert wanted in b"".join(done.files.values()).decode()


@pytest.mark.parametrize(
    ("condition", "wanted"),
    [
        ("M1=1 And M2=2 Or M3=3", "(M1=1 AND M2=2) OR M3=3"),
        ("M1=1 And (M2=2 Or M3=3)", "M1=1 AND (M2=2 OR M3=3)"),
        ("Not (M1=1 And M2=2)", "NOT (M1=1 AND M2=2)"),
    ],
)
def test_logic_from_melfa_basic(tmp_path: Path, condition: str, wanted: str) -> None:
    file = tmp_path / "A.prg"
    file.write_text(f"M1=1\nM2=2\nM3=4\nIf {condition} Then Mvs P1\nEnd\n{PLACE}")
    done = translate(file, to="rapid", language="melfa-basic-5", proving=Proving())
    assert done.motion is not None and done.motion.holds
    assert f"IF {wanted} THEN" in b"".join(done.files.values()).decode()
