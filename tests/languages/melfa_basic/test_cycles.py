"""What one cycle leaves to the next: first values, ends of a cycle, and ends for good."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.compiler import Translation, translate
from assistant.compiler.motion_proof import Proving
from assistant.virtual import melfa, rapid
from assistant.virtual.events import Moved
from assistant.virtual.proving.comparison import difference

MELFA = ("melfa-basic-4", "melfa-basic-5", "melfa-basic-6")


def translated(folder: Path, data: str, main: str, to: str = "melfa-basic-5") -> Translation:
    """A module of RAPID with declarations and a main routine, each with parts behind `/`."""
    file = folder / "cell.mod"
    text = f"MODULE cell\n{data}\nPROC main()\n{main}\nENDPROC\nENDMODULE\n"
    file.write_text(text.replace("/", "\n"), encoding="utf-8", newline="\n")
    return translate(file, to=to)


def said(translation: Translation) -> list[str]:
    """Codes of findings that are about variables and ends, with their lines."""
    return [
        f"{reason.code} {row.place.line}"
        for row in translation.rows
        for reason in row.reasons
        if reason.code in ("MB227", "MB236", "MB237", "MB263")
    ]


def code(translation: Translation) -> list[str]:
    (text,) = translation.files.values()
    steps = (line.partition(" ") for line in text.decode().splitlines())
    lines = (line.strip() for step, _, line in steps if step.isdecimal())
    return [line for line in lines if not line.startswith("'")]


N = "VAR num n:=2;"
P1 = "CONST robtarget p1:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
MOVES = "/ENDPROC/PROC move()/MoveL p1,v100,fine,tool0;/"
SLOW = "ENDPROC/PROC slow()/AccSet 20,100;"
FULL = "VelSet 100,5000;"
CARRIED: dict[str, tuple[str, str]] = {
    "counted": (N, "n:=n+1;"),
    "without a value": ("VAR num n;", "n:=n+1;"),
    "read on one way only": (N, "IF di1=1 n:=0;/IF n>3 WaitTime 1;/n:=9;"),
    "changed behind its use": (N, "WaitTime n;/n:=3;"),
    "read in a routine": (N, "sub;/ENDPROC/PROC sub()/n:=n+1;"),
    "changed in a routine": (N, "WaitTime n;/sub;/ENDPROC/PROC sub()/n:=3;"),
    "given a value by a routine on some ways": (
        N, "sub;/WaitTime n;/ENDPROC/PROC sub()/IF di1=1 RETURN;/n:=3;",
    ),
    "given a value in a loop that may not run": (N, "WHILE di1=1 DO/n:=1;/ENDWHILE/WaitTime n;"),
    "behind a label": (N, "IF di1=1 GOTO over;/n:=1;/over:/WaitTime n;"),
    "handed over to be changed": (N, "sub n;/ENDPROC/PROC sub(INOUT num x)/x:=x+1;"),
    "a list": ("VAR num n{2}:=[1,2];", "WaitTime n{1};/n{1}:=3;"),
    "in a loop that is left": (N, "WHILE TRUE DO/n:=n+1;/IF n>5 RETURN;/ENDWHILE"),
    "an override": (P1, "move;/VelSet 30,5000;" + MOVES),
    "an acceleration of a routine": (P1, "move;/slow;" + MOVES + SLOW),
    "an override of some ways": (P1, "move;/VelSet 30,5000;/IF di1=1 " + FULL + MOVES),
}  # fmt: skip


@pytest.mark.parametrize(("data", "main"), CARRIED.values(), ids=CARRIED)
def test_what_a_cycle_leaves_to_the_next_stays_in_a_loop(
    tmp_path: Path, data: str, main: str
) -> None:
    found = translated(tmp_path, data, main)
    assert said(found) == ["MB263 3"]
    if found.files:  # the others lack the numbers of their signals
        lines = [line.lower() for line in code(found)]
        at = lines.index("while 1")
        assert lines[at + 1 :][:3] == ["gosub *cycle", "wend", "end"]


@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize("kind", ["VAR", "PERS"])
def test_many_cycles_do_the_same(tmp_path: Path, to: str, kind: str) -> None:
    """A count, a first cycle that is another one, an end in the middle and a variable of main."""
    data = f"{kind} num n:=0;/{kind} bool first:=TRUE;/VAR num seen;"
    main = (
        "VAR num own:=1;/IF first THEN/first:=FALSE;/WaitTime 9;/RETURN;/ENDIF/"
        "own:=own+1;/n:=n+own;/IF n>9 n:=0;/WaitTime n+1;/sub;/"
        "ENDPROC/PROC sub()/seen:=n;/IF n=4 THEN/WaitTime 8;/RETURN;/ENDIF/WaitTime seen+2;"
    )
    found = translated(tmp_path, data, main, to)
    (text,) = found.files.values()
    source = languages.get("rapid").parse((tmp_path / "cell.mod").read_text())
    first = rapid.run(source, most_cycles=10)
    language = languages.get(to)
    second = melfa.run(language.parse(language.decode(text)), most_steps=5_000)
    assert len(first.events) > 15
    assert len(second.events) > 15
    assert difference(first, second) is None
    proof = translate(tmp_path / "cell.mod", to=to, proving=Proving(seconds=2.0)).motion
    assert proof is not None
    assert proof.holds, proof.findings


def test_a_cycle_that_others_call_is_told_of(tmp_path: Path) -> None:
    main = "n:=n+1;/IF n<3 sub;/ENDPROC/PROC sub()/main;"
    assert "MB237 2" in said(translated(tmp_path, N, main, "melfa-basic-6"))


NOT_CARRIED: dict[str, tuple[str, str]] = {
    "given a value first": (N, "n:=1;/n:=n+1;"),
    "given one on both ways": (N, "IF di1=1 THEN/n:=1;/ELSE/n:=2;/ENDIF/n:=n+1;"),
    "given one by a routine": (N, "sub;/n:=n+1;/ENDPROC/PROC sub()/n:=3;"),
    "counted by a loop": (N, "FOR n FROM 1 TO 3 DO/WaitTime n;/ENDFOR"),
    "never changed": (N, "WaitTime n;"),
    "only written": (N, "n:=1;"),
    "in a loop without end": (N, "WHILE TRUE DO/n:=n+1;/ENDWHILE"),
    "a constant": ("CONST num n:=2;", "WaitTime n;"),
    "of the routine": ("", "VAR num n:=2;/n:=n+1;"),
    "by a routine that calls itself": (
        N, "sub;/ENDPROC/PROC sub()/IF di1=1 sub;/n:=1;/n:=n+1;",
    ),
    "behind an end for good": (N, "n:=n+1;/WHILE TRUE DO/Stop;/ENDWHILE"),
    "an override before all moves": (P1, "VelSet 30,5000;/move;" + MOVES),
    "an override that is taken back": (P1, "move;/VelSet 30,5000;/move;/" + FULL + MOVES),
    "an override of 100 percent": (P1, "move;/VelSet 100,5000;" + MOVES),
}  # fmt: skip


@pytest.mark.parametrize(("data", "main"), NOT_CARRIED.values(), ids=NOT_CARRIED)
def test_where_each_cycle_begins_alike_nothing_is_told(
    tmp_path: Path, data: str, main: str
) -> None:
    assert said(translated(tmp_path, data, main)) == []


@pytest.mark.parametrize("to", MELFA)
def test_a_variable_without_value_begins_with_that_of_its_type(tmp_path: Path, to: str) -> None:
    data = "VAR num n;/VAR string t;/VAR num unread;"
    found = translated(tmp_path, data, "n:=n+1;/t:=t;/unread:=n;", to)
    lines = [line.upper() for line in code(found)]
    assert lines[:2] == ["MN=0", 'CT$=""'], lines
    assert not any(line.startswith("MUNREAD=0") for line in lines)


def test_a_variable_of_main_begins_anew_in_each_cycle(tmp_path: Path) -> None:
    assert code(translated(tmp_path, "", "VAR num n;/n:=n+1;"))[:2] == ["MN=0", "MN=MN+1"]


def test_a_cycle_of_melfa_begins_with_the_usual_speed(tmp_path: Path) -> None:
    """`End` sets the override and the acceleration back; RAPID keeps both in the next cycle."""
    file = tmp_path / "SLOW.prg"
    place = "PA=(+350.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)"
    file.write_text(f"1 Spd 80\n2 Mvs PA\n3 Ovrd 50\n4 Accel 30,30\n5 Mvs PA\n6 End\n{place}\n")
    (text,) = translate(file, to="rapid").files.values()
    main = text.decode().partition("PROC main()")[2].split()
    assert [word for word in main if word.endswith("Set")] == ["VelSet", "AccSet"] * 2
    run = rapid.run(languages.get("rapid").parse(text.decode()), most_cycles=2)
    assert [one.speed for one in run.events if isinstance(one, Moved)] == [80, 40, 80, 40]


def test_a_variable_of_melfa_keeps_what_it_has() -> None:
    language = languages.get("melfa-basic-5")
    program = language.lift(language.parse("1 M1=M1+1\n2 End\n"))
    adapted = language.adapt(program)
    assert not adapted.findings
    assert "M1=0" not in language.render(language.build(adapted.program))


def test_a_persistent_that_is_read_first_is_told_of(tmp_path: Path) -> None:
    assert said(translated(tmp_path, "PERS num n:=2;", "n:=n+1;")) == ["MB227 2", "MB263 3"]
    assert said(translated(tmp_path, "PERS num n:=2;", "WaitTime n;")) == ["MB227 2"]
    assert said(translated(tmp_path, "PERS num n;", "WaitTime n;")) == ["MB227 2"]  # 0
    assert said(translated(tmp_path, "PERS num n:=2;", "n:=1;/n:=n+1;")) == []


# ------------------------------------------------------------------------------------ ends


@pytest.mark.parametrize("to", MELFA)
@pytest.mark.parametrize("main", ["EXIT;", "sub;/ENDPROC/PROC sub()/EXIT;"])
def test_an_end_for_good_stays_one(tmp_path: Path, to: str, main: str) -> None:
    found = translated(tmp_path, "", main, to)
    assert len(said(found)) == 1
    assert said(found)[0].startswith("MB236")
    lines = [line.lower() for line in code(found)]
    at = lines.index("while 1")
    assert lines[at : at + 3] == ["while 1", "hlt", "wend"]
    (text,) = found.files.values()
    (tmp_path / "back.prg").write_bytes(text)
    back = translate(tmp_path / "back.prg", to="rapid", language=to)
    (module,) = back.files.values()
    lines = [line.strip() for line in module.decode().splitlines()]
    at = lines.index("WHILE TRUE DO")
    assert lines[at : at + 3] == ["WHILE TRUE DO", "Stop;", "ENDWHILE"]


@pytest.mark.parametrize("to", MELFA)
def test_a_return_from_main_ends_the_cycle(tmp_path: Path, to: str) -> None:
    found = translated(tmp_path, "VAR num n;", "IF n=1 RETURN;/WaitTime 1;", to)
    assert said(found) == []
    assert [line.lower().split()[-1] for line in code(found)].count("end") == 2


def test_the_end_of_a_cycle_is_no_end_for_good(tmp_path: Path) -> None:
    file = tmp_path / "CELL.prg"
    file.write_text("1 If M1=1 Then End\n2 Dly 1\n3 End\n")
    (module,) = translate(file, to="rapid", language="melfa-basic-5").files.values()
    assert "RETURN;" in module.decode()
    assert "EXIT" not in module.decode()


def test_an_end_within_a_subroutine_leaves_its_callers(tmp_path: Path) -> None:
    file = tmp_path / "CELL.prg"
    file.write_text("1 GoSub *S\n2 End\n3 *S\n4 If M1=1 Then End\n5 Return\n")
    found = translate(file, to="rapid", language="melfa-basic-5")
    assert found.ok
    (module,) = found.files.values()
    lines = [line.strip() for line in module.decode().splitlines()]
    at = lines.index("S;")
    assert lines[at + 1 : at + 3] == ["IF cycle_ended THEN", "RETURN;"]


def test_an_end_within_an_interrupt_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "CELL.prg"
    file.write_text(
        "1 Def Act 1,M_In(1)=1 GoSub *S\n2 Act 1=1\n3 Dly 1\n4 End\n"
        "5 *S\n6 If M1=1 Then End\n7 Return 0\n"
    )
    found = translate(file, to="rapid", language="melfa-basic-5")
    assert not found.ok
    assert ["ends the cycle" in f.message for f in found.findings].count(True) == 1


def test_a_jump_out_of_a_subroutine_is_reported(tmp_path: Path) -> None:
    file = tmp_path / "CELL.prg"
    file.write_text(
        "1 *TOP\n2 GoSub *S\n3 Dly 1\n4 End\n5 *S\n6 If M_In(1)=1 Then GoTo *TOP\n7 Return\n"
    )
    found = translate(file, to="rapid", language="melfa-basic-5")
    assert found.ok
    rows = [row for row in found.rows if any(one.code == "MB298" for one in row.reasons)]
    assert [row.place.line for row in rows] == [2]
