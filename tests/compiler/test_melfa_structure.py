"""Programs of MELFA-BASIC in RAPID have the shape that programmers of RAPID give them."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.source_text import SourceText
from assistant.compiler import Translation, translate
from assistant.compiler.loader import load_text

from .proven import crossed

PLACES = """P1=(400,0,400,180,0,180)(7,0)
P2=(400,100,300,180,0,180)(7,0)
P3=(400,-100,300,180,0,180)(7,0)
"""
FIVE = "melfa-basic-5"


def to_rapid(code: str, places: str = PLACES, **options: float) -> Translation:
    """A program, its lines divided by `/`, that is proven by motion."""
    code = code.strip().replace("/", "\n")
    done = crossed(f"{code}\n{places}", FIVE, "rapid", **{"runs": 6, **options})  # type: ignore[arg-type]
    assert done.ok, [f"{f.code} {f.message}" for f in done.findings]
    assert done.motion is not None and done.motion.holds
    return done


def lines_of(done: Translation, procedure: str) -> list[str]:
    """The lines of a procedure without its first and last one."""
    (data,) = done.files.values()
    lines = [line.strip() for line in data.decode().splitlines()]
    first = lines.index(f"PROC {procedure}()")
    return lines[first + 1 : lines.index("ENDPROC", first)]


@pytest.mark.parametrize(
    ("above", "written"),
    [
        ("' --- left pad", ["! --- left pad"]),
        ("' left pad\n' of two", ["! left pad", "! of two"]),
        ("'\n' left pad\n'", ["!", "! left pad", "!"]),
        ("\n' left pad\n\n", ["! left pad"]),
    ],
)
def test_comments_above_a_label_are_of_its_procedure(above: str, written: list[str]) -> None:
    done = to_rapid(f"Mvs P1\nGoSub *PAD\nEnd\n{above}\n*PAD\nMvs P2\nReturn\n' the end")
    assert lines_of(done, "main")[-1] == "PAD;"
    lines = lines_of(done, "PAD")
    assert lines[:-2] == written
    assert lines[-2].startswith("MoveL P2")
    assert lines[-1] == "! the end"


def test_comments_above_a_subroutine_that_loops_to_its_label() -> None:
    done = to_rapid(
        "Mvs P1\nM1=0\nGoSub *AGAIN\nEnd\n' --- twice\n*AGAIN\nM1=M1+1\nMvs P2\nMvs P3\n"
        "If M1<2 Then GoTo *AGAIN\nReturn"
    )
    assert lines_of(done, "main")[-1] == "AGAIN;"
    assert lines_of(done, "AGAIN")[0] == "! --- twice"


def test_comments_above_subroutines_that_share_their_end() -> None:
    done = to_rapid(
        "Mvs P1\nGoSub *LEFT\nGoSub *RIGHT\nEnd\n' --- left\n*LEFT\nMvs P2\nGoTo *BOTH\n"
        "' --- right\n*RIGHT\nMvs P3\n*BOTH\nMvs P1\nReturn"
    )
    assert lines_of(done, "LEFT")[0] == "! --- left"
    assert lines_of(done, "RIGHT")[0] == "! --- right"


def test_nothing_follows_the_end_that_an_error_makes() -> None:
    done = to_rapid(
        "Mvs P1/GoSub *CHECK/If M_In(4)=1 Then GoTo *BAD/Mvs P3/End/*BAD/Error 9102/' worse/"
        "End/*CHECK/Mvs P2/If M_In(3)=0 Then/M_Out(5)=1/Error 9101/End/EndIf/Return"
    )
    assert lines_of(done, "main")[-2:] == ["EXIT;", "! worse"]
    check = lines_of(done, "CHECK")
    assert check[check.index("EXIT;") + 1 :] == ["ENDIF"]
    # No flag asks for an end that nothing leads to.
    assert b"cycle_ended" not in b"".join(done.files.values())


def test_statements_stay_that_follow_an_error() -> None:
    done = to_rapid(
        "Mvs P1/GoSub *CHECK/Mvs P3/End/*CHECK/If M_In(3)=1 Then Return/Error 9101/GoTo *OUT/"
        "*OUT/M_Out(5)=1/End"
    )
    lines = lines_of(done, "CHECK")
    assert lines[lines.index("EXIT;") + 1 :] == ["SetDO do_5,1;", "RETURN;"]
    assert "RA450" in {finding.code for finding in done.findings}


def test_an_end_in_a_subroutine_stays() -> None:
    done = to_rapid(
        "Mvs P1/GoSub *CHECK/Mvs P3/End/*CHECK/If M_In(3)=0 Then/M_Out(5)=1/End/EndIf/Return",
    )
    lines = lines_of(done, "CHECK")
    assert lines[lines.index("SetDO do_5,1;") + 1 :][:2] == ["cycle_ended:=TRUE;", "RETURN;"]


@pytest.mark.parametrize(
    ("loop", "wait"),
    [
        ("*W/If M_In(3)=0 Then GoTo *W", "WaitDI di_3,1;"),
        ("*W/If M_In(3)=0 Then *W ' part", "WaitDI di_3,1;"),
        ("*W: If M_In(3)=0 Or M_In(4)=1 Then *W", "WaitUntil di_3=1 AND di_4=0;"),
        (
            "M_Timer(1)=0/*W/If M_In(3)=0 And M_Timer(1)<100 Then *W",
            "WaitUntil di_3=1 OR ClkRead(timer_1)>=0.1;",
        ),
        ("*W/If M_In(3)=0 Then/GoTo *W/EndIf", "WaitDI di_3,1;"),
    ],
)
def test_a_loop_that_only_asks_is_a_wait(loop: str, wait: str) -> None:
    done = to_rapid(f"Mvs P1/{loop}/Mvs P2/M_Out(5)=M_In(3)/End", seconds=0.2)
    lines = [line.partition(" !")[0] for line in lines_of(done, "main")]
    assert wait in lines
    assert not any(line.startswith(("GOTO", "W:", "IF")) for line in lines)


@pytest.mark.parametrize(
    "loop",
    [
        "*W/Dly 0.1/If M_In(3)=0 Then *W",
        "*W/If M_In(3)=0 Then *W Else M_Out(5)=1",
        "*W/If M_In(3)=0 Then *W/If M_In(4)=0 Then *W",
    ],
)
def test_other_loops_keep_their_labels(loop: str) -> None:
    code = f"Mvs P1/{loop}/Mvs P2/End/".replace("/", "\n")
    done = translate(load_text(SourceText(code + PLACES), language=FIVE), to="rapid")
    assert "W:" in lines_of(done, "main")


def test_a_jump_to_the_end_of_a_subroutine_returns() -> None:
    done = to_rapid(
        "Mvs P1/GoSub *GET/Mvs P1/End/*GET/For M1=1 To 2/Mvs P2/If M_In(3)=1 Then *OK/Mvs P3/"
        "Next M1/GoTo *BAD/*OK/Return/' --- error exits/*BAD/M_Out(5)=1/If M_In(4)=1 Then *OUT/"
        "Mvs P3/*OUT/Return"
    )
    lines = lines_of(done, "GET")
    assert not any(line.startswith("GOTO") or line.endswith(":") for line in lines)
    assert lines[lines.index("ENDFOR") :][:3] == ["ENDFOR", "! --- error exits", "SetDO do_5,1;"]
    assert lines.count("RETURN;") == 2


def test_a_jump_to_the_end_of_the_program_ends_the_cycle() -> None:
    done = to_rapid("Mvs P1/If M_In(3)=1 Then GoTo *OUT/Mvs P2/*OUT/End")
    lines = lines_of(done, "main")
    assert lines[1:4] == ["IF di_3=1 THEN", "RETURN;", "ENDIF"]
    assert len(lines) == 5


@pytest.mark.parametrize("used", ["PGrip", "PGRIP", "pgrip"])
def test_a_tool_keeps_the_spelling_of_its_position(used: str) -> None:
    places = f"{PLACES}PGrip=(0,0,110,0,0,0)(0,0)\n"
    done = to_rapid(f"Tool {used}/Mvs P1/End", places)
    (text,) = done.files.values()
    assert b"PERS tooldata PGrip:=" in text
    assert lines_of(done, "main")[0].endswith(",PGrip;")


@pytest.mark.parametrize("key", ["PGrip", "PGRIP"])
def test_a_cell_file_names_the_tool_in_either_spelling(key: str, tmp_path: Path) -> None:
    program, cell = tmp_path / "job.prg", tmp_path / "cell.toml"
    program.write_text(f"Tool PGrip\nMvs P1\nEnd\n{PLACES}PGrip=(0,0,110,0,0,0)(0,0)\n")
    cell.write_text(
        f"[tools.{key}]\ntip = [0, 0, 110]\nquaternion = [1, 0, 0, 0]\nmass = 0.9\n"
        "centre = [0, 0, 50]\n"
    )
    done = translate(program, to="rapid", cell=cell)
    (text,) = done.files.values()
    assert b"PERS tooldata PGrip:=[TRUE,[[0,0,110],[1,0,0,0]],[0.9,[0,0,50]" in text


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ("9102", ['TPWrite "error "+ValToStr(MErr);', "EXIT;", "ENDIF"]),
        (
            "9100+M_Inb(32)",
            [
                'TPWrite "error "+ValToStr(Round(MErr));',
                "IF Round(MErr)<9200 OR Round(MErr)>9299 THEN",
                "EXIT;",
                "ENDIF",
            ],
        ),
    ],
)
def test_an_error_of_a_computed_number(value: str, written: list[str]) -> None:
    done = to_rapid(f"Mvs P1/MErr={value}/If M_In(3)=1 Then/Error MErr/EndIf/Mvs P2/End")
    lines = lines_of(done, "main")
    at = lines.index("IF di_3=1 THEN")
    assert lines[at + 1 : at + 1 + len(written)] == written
    assert "MB254" in {finding.code for finding in done.findings}
