"""Angles of MELFA-BASIC, which are radian in expressions, in RAPID, which has degrees alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import translate
from assistant.compiler.motion_proof import Proving
from assistant.compiler.translation import Translation
from tests.tables import every_row

PLACE = "P1=(+400.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)\n"
HEAD = "Tool P_NTool\nBase P_NBase\nSpd 100\nCnt 0\n"


def made(folder: Path, *lines: str, to: str = "rapid") -> tuple[Translation, str]:
    """A program of these lines that ends with a move to P1, translated and proven by motion."""
    source = folder / "ANGLE.prg"
    source.write_text(HEAD + "".join(f"{line}\n" for line in lines) + f"Mvs P1\nEnd\n{PLACE}")
    done = translate(
        source, to=to, robot="irb1200-7-0.7", from_robot="rv-4frl", proving=Proving(seconds=2.0)
    )
    assert done.ok, [f.message for f in done.findings]
    assert done.motion is not None
    return done, b"".join(done.files.values()).decode("ascii")


@every_row(
    ("lines", "said"),
    [
        (("M1=Rad(300)", "P1.X=400+10*Cos(M1)"), ("M1:=300;", "400+10*Cos(M1)")),
        (("M1=Rad(30)", "M2=Deg(M1)", "P1.X=400+M2"), ("M1:=30;", "M2:=M1;")),
        (("M1=P1.C", "M1=M1+Rad(10)", "P1.C=M1"), ("M1:=P1_C;", "M1:=M1+10;", "P1_C:=M1;")),
        (("M1=Rad(20)", "M2=-M1/2+Rad(5)", "P1.Y=Sin(M2)"), ("M2:=(-M1)/2+5;", "Sin(M2)")),
        (("M1=Atn2(1,2)", "P1.Y=Tan(M1)"), ("M1:=ATan2(1,2);", "Tan(M1)")),
        (("M1=0", "If M1<Rad(45) Then M1=Rad(50)", "P1.Y=Sin(M1)"), ("IF M1<45 ", "M1:=50;")),
        (("M1=Rad(10)+Rad(20)", "P1.X=400+M1"), ("M1:=(10+20)*pi/180;", "400+M1")),
        (("M1=0.5", "P1.Y=10*Sin(M1)"), ("M1:=0.5;", "10*Sin(M1*180/pi)")),
        (("M1=Rad(10)", "M2=M1+1", "P1.X=400+M2"), ("M1:=10*pi/180;", "M2:=M1+1;")),
        (("M1=Rad(10)", "P1.X=400+M1", "P1.Y=Sin(M1)"), ("M1:=10*pi/180;", "Sin(M1*180/pi)")),
        (("M1=Rad(10)", "M2=M1*Deg(M1)", "P1.Y=M2"), ("M1:=10*pi/180;",)),
    ],
)
def test_angles_are_converted_at_most_once(
    tmp_path: Path, lines: tuple[str, ...], said: tuple[str, ...]
) -> None:
    _, text = made(tmp_path, *lines)
    assert not [one for one in said if one not in text], text
    assert "0.01745" not in text


def test_the_answer_names_what_is_in_another_unit(tmp_path: Path) -> None:
    done, _ = made(tmp_path, "M1=Rad(300)", "M2=Rad(10)", "P1.X=400+10*Cos(M1)+M2")
    (told,) = [f.message for f in done.findings if f.code == "MB299"]
    assert "`M1`" in told and "`M2`" not in told


def test_what_is_counted_on_and_compared_stays_in_radian(tmp_path: Path) -> None:
    """0.1 in nine steps is 0.9 or a little less or more, which is another number of turns."""
    lines = ("M1=Rad(5)", "While M1<=Rad(45)", "M1=M1+Rad(5)", "P1.X=P1.X+1", "WEnd")
    _, text = made(tmp_path, *lines)
    assert "WHILE M1<=45*pi/180 DO" in text and "M1:=M1+5*pi/180;" in text


def test_external_variables_stay_in_radian_for_other_programs(tmp_path: Path) -> None:
    _, text = made(
        tmp_path, "Def Float M_ANG", "M_00=Rad(30)", "M_ANG=Rad(5)", "P1.Y=Sin(M_00+M_ANG)"
    )
    assert "M_00:=30*pi/180;" in text and "M_ANG:=5*pi/180;" in text


def test_what_a_comment_quotes_stays_in_radian(tmp_path: Path) -> None:
    source = tmp_path / "ANGLE.prg"
    source.write_text(f"{HEAD}M1=Rad(300)\nP1.Y=Sin(M1)\nPrint #1,M1\nMvs P1\nEnd\n{PLACE}")
    done = translate(source, to="rapid", robot="irb1200-7-0.7", from_robot="rv-4frl", draft=True)
    text = b"".join(done.files.values()).decode("ascii")
    assert "| Print #1,M1" in text and "M1:=300*pi/180;" in text


def test_a_program_may_have_a_name_pi_of_its_own(tmp_path: Path) -> None:
    _, text = made(tmp_path, "PI=P1", "M1=Rad(10)", "P1.X=400+M1", "Mvs PI")
    assert "M1:=10*3.141592653589793/180;" in text


@pytest.mark.parametrize("own", ["", "CONST num pi:=3;\n"])
def test_radian_of_rapid_are_converted_by_name(tmp_path: Path, own: str) -> None:
    source = tmp_path / "angle.mod"
    source.write_text(
        f"MODULE angle\n{own}VAR num n;\nVAR num a:=30;\nPROC main()\na:=30;\nn:=a*pi/180;\n"
        "a:=n*180/pi;\nMoveL [[400+n,0,400+Sin(a)],[0,0,1,0],[0,0,0,0],"
        "[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    )
    done = translate(
        source, to="melfa-basic-6", robot="rv-4frl", from_robot="irb1200-7-0.7",
        proving=Proving(seconds=2.0),
    )  # fmt: skip
    assert done.ok, [f.message for f in done.findings]
    text = b"".join(done.files.values()).decode("ascii")
    assert ("Mn=Rad(Ma)" in text and "Ma=Deg(Mn)" in text) == (not own), text
    assert "400+Sin(Rad(Ma))" in text
