"""Two programs that people wrote: whether they do the same, and which lines differ."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

import pytest

from assistant import Proving, Refused, compare, translate
from assistant.base.source_text import SourceText
from assistant.compiler.comparison import Comparison, counterparts
from assistant.compiler.loader import load_text
from assistant.virtual.proving import search

HEAD = """MODULE Cell
PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
CONST robtarget pPick:=[[350,20,150],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pPlace:=[[300,-120,120],[0,0.130526192,0.991444861,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget pHome:=[[330,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
"""  # noqa: E501
POSITIONS = """PTOOL=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)
PPICK=(+350.00,+20.00,+150.00,+180.00,+0.00,+180.00)(7,0)
PPLACE=(+300.00,-120.00,+120.00,+180.00,+0.00,+165.00)(7,0)
PHOME=(+330.00,+0.00,+300.00,+180.00,+0.00,+180.00)(7,0)
"""
PICKING = """PROC main()
  MoveL pHome,v200,fine,tGrip;
  FOR i FROM 1 TO 2 DO
    WaitDI diPart,1;
    MoveL Offs(pPick,0,0,50),v200,z10,tGrip;
    MoveL pPick,v100,fine,tGrip;
    SetDO doGrip,1;
    WaitTime 0.3;
    MoveL Offs(pPick,0,0,50),v200,z10,tGrip;
    MoveL pPlace,v100,fine,tGrip;
    SetDO doGrip,0;
    PulseDO\\PLength:=0.4,doDone;
  ENDFOR
ENDPROC
ENDMODULE
"""
PICKED = """Tool PTOOL
Spd 200
Cnt 0
Mvs PHOME
M1=0
While M1<2
GoSub *PICK
Spd 100
Cnt 0
Mvs PPLACE
M_Out(10)=0
M_Out(11)=1 Dly 0.4
M1=M1+1
WEnd
End
*PICK
*WAITING
If M_In(4)=0 Then GoTo *WAITING
PABOVE=PPICK
PABOVE.Z=PABOVE.Z+50
Spd 200
Cnt 1,10,10
Mvs PABOVE
Spd 100
Cnt 0
Mvs PPICK
M_Out(10)=1
Dly 0.3
Spd 200
Cnt 1,10,10
Mvs PABOVE
Return
"""
CHOOSING = """PROC main()
  VAR num n;
  MoveL pHome,v200,fine,tGrip;
  n:=giKind;
  TEST n
  CASE 1:
    MoveL pPick,v100,fine,tGrip;
  CASE 2,3:
    MoveL pPlace,v100,fine,tGrip;
    SetDO doGrip,1;
  DEFAULT:
    SetDO doDone,1;
  ENDTEST
  IF diPart=1 AND (diOpen=1 OR n>2) THEN
    MoveL pHome,v200,fine,tGrip;
  ENDIF
ENDPROC
ENDMODULE
"""
CHOSEN = """Tool PTOOL
Spd 200
Cnt 0
Mvs PHOME
M1=M_In(20)+2*M_In(21)
Spd 100
If M1=1 Then *ONE
If M1=2 Or M1=3 Then *TWO
M_Out(11)=1
GoTo *ON
*ONE
Mvs PPICK
GoTo *ON
*TWO
Mvs PPLACE
M_Out(10)=1
*ON
If M_In(4)=0 Then *OUT
If M_In(5)=0 And M1<=2 Then *OUT
Spd 200
Mvs PHOME
*OUT
End
"""
GLUING = """PROC main()
  VAR bool bLate;
  MoveJ pHome,v200,fine,tGrip;
  WaitDI diPart,1\\MaxTime:=3\\TimeFlag:=bLate;
  IF bLate THEN
    SetDO doDone,1;
  ELSE
    MoveL pPick,v100,fine,tGrip;
    SetDO doGrip,1;
    MoveC pHome,pPlace,v100,z5,tGrip;
    SetDO doGrip,0;
  ENDIF
ENDPROC
ENDMODULE
"""
GLUED = """JOvrd 20
Tool PTOOL
Cnt 0
Mov PHOME
M_Timer(1)=0
*AGAIN
If M_In(4)=1 Then *THERE
If M_Timer(1)<3000 Then *AGAIN
M_Out(11)=1
End
*THERE
Spd 100
Mvs PPICK
M_Out(10)=1
Cnt 1,5,5
Mvr PPICK,PHOME,PPLACE
M_Out(10)=0
End
"""
CELL = """
[signals.doGrip]
number = 10
[signals.doDone]
number = 11
[signals.diPart]
direction = "input"
number = 4
[signals.diOpen]
direction = "input"
number = 5
[signals.giKind]
kind = "group"
direction = "input"
number = 20
bits = 2
"""


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def compared(
    folder: Path, rapid: str, melfa: str, runs: int = 200, seconds: float = 10.0
) -> Comparison:
    """A program in RAPID, and what somebody wrote for it in MELFA-BASIC V."""
    first = written(folder, "cell.mod", HEAD + rapid)
    second = written(folder, "CELL.prg", melfa + POSITIONS)
    process = written(folder, "cell.process.toml", CELL)
    proving = Proving(runs=runs, seconds=seconds)
    return compare(first, second, process=process, language="melfa-basic-5", proving=proving)


SAME = {
    "a subroutine, a loop that polls": (PICKING, PICKED),
    "jumps for a choice": (CHOOSING, CHOSEN),
    "a timer for a longest time": (GLUING, GLUED),
    "a condition the other way round": (
        CHOOSING.replace("diPart=1 AND (diOpen=1 OR n>2)", "NOT (diPart=0 OR (diOpen=0 AND n<3))"),
        CHOSEN,
    ),
    "a loop that counts down": (
        PICKING,
        PICKED.replace("M1=0", "M1=2").replace("M1<2", "M1>0").replace("M1=M1+1", "M1=M1-1"),
    ),
}


@dataclass(frozen=True)
class Fault:
    """A typing error. lines: of both programs, where it shows. said: a part of the answer.
    runs: how many are tried at most.
    """

    pair: tuple[str, str]
    typed: tuple[str, str]
    lines: tuple[str | None, str | None]
    said: str
    runs: int = 200


FAULTS = {
    "a digit": Fault(
        (PICKING, PICKED),
        ("Z=PABOVE.Z+50", "Z=PABOVE.Z+5"),
        ("MoveL Offs(pPick,0,0,50),v200,z10,tGrip;", "Mvs PABOVE"),
        "another flange, 45.00 mm and 0.00 degrees off",
    ),
    "a wait that is missing": Fault(
        (PICKING, PICKED),
        ("If M_In(4)=0 Then GoTo *WAITING\n", ""),
        ("WaitDI diPart,1;", "Mvs PABOVE"),
        "a wait that ends with 4=1, and linear to",
    ),
    "one more of a loop": Fault(
        (PICKING, PICKED),
        ("While M1<2", "While M1<=2"),
        (None, "Mvs PABOVE"),
        "ended as `end`, and linear to",
        runs=4,  # later ones leave the written program waiting without end
    ),
    "another output": Fault(
        (CHOOSING, CHOSEN),
        ("M_Out(11)=1", "M_Out(10)=1"),
        ("SetDO doDone,1;", "M_Out(10)=1"),
        "signal 11 = 1, and signal 10 = 1",
    ),
    "a term of a condition": Fault(
        (CHOOSING, CHOSEN),
        ("If M_In(5)=0 And M1<=2 Then *OUT", "If M_In(5)=0 And M1<=3 Then *OUT"),
        ("MoveL pHome,v200,fine,tGrip;", None),
        "and ended as `end`",
    ),
    "the length of a pulse": Fault(
        (PICKING, PICKED),
        ("Dly 0.4", "Dly 4"),
        ("PulseDO\\PLength:=0.4,doDone;", "M_Out(11)=1 Dly 4"),
        "after 0.4 s, and signal 11 = 0 after 4 s",
    ),
    "a longest time": Fault(
        (GLUING, GLUED),
        ("M_Timer(1)<3000", "M_Timer(1)<300"),
        ("SetDO doDone,1;", "M_Out(11)=1"),
        "another longest time of a wait",
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_programs_in_another_style_are_equal(tmp_path: Path, name: str) -> None:
    done = compared(tmp_path, *SAME[name])
    assert done.answer == "equal", [*done.differences, *done.findings]
    assert done.exit_status == 0


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_found_at_its_lines(tmp_path: Path, name: str) -> None:
    fault = FAULTS[name]
    rapid, melfa = fault.pair
    assert melfa.count(fault.typed[0]) == 1
    done = compared(tmp_path, rapid, melfa.replace(*fault.typed), fault.runs)
    assert (done.answer, done.exit_status) == ("different", 1)
    shown = [
        (tuple(place.text if place else None for place in one.places), one.what)
        for one in done.differences
    ]
    assert any(lines == fault.lines and fault.said in what for lines, what in shown), shown


def test_the_inputs_and_the_condition_before_a_difference_are_told(tmp_path: Path) -> None:
    done = compared(tmp_path, CHOOSING, CHOSEN.replace("And M1<=2", "And M1<=3"))
    (one,) = done.differences
    assert one.inputs == "di_20=1, di_21=1, diPart=1"
    assert [place and place.text for place in one.behind] == [
        "IF diPart=1 AND (diOpen=1 OR n>2) THEN",
        "If M_In(5)=0 And M1<=3 Then *OUT",
    ]
    (finding,) = [f for f in done.findings if f.code == "CO118"]
    assert finding.line == 20 and "CELL.prg:" not in finding.message


def test_either_program_may_be_the_first(tmp_path: Path) -> None:
    first = written(tmp_path, "CELL.mb5", PICKED + POSITIONS)
    process = written(tmp_path, "cell.process.toml", CELL)
    second = written(tmp_path, "cell.mod", HEAD + PICKING)
    done = compare(first, second, names={"di_4": "diPart", "do_10": "doGrip", "do_11": "doDone"})
    assert done.answer == "equal", [*done.differences, *done.findings]
    assert compare(second, second, process=[process, process]).equal
    with pytest.raises(Refused) as refused:
        compare(second, second, process=[process] * 3)
    assert (refused.value.findings[0].code, refused.value.exit_status) == ("CO125", 2)


def test_a_visit_of_the_script_is_the_same_motion_of_both(tmp_path: Path) -> None:
    waiting = "WaitDI diPart,1;\nMoveL pPick,v100,fine,tGrip;\n"
    looks = "PROC main()\nMoveL pHome,v100,fine,tGrip;\n"
    rapid = f"{looks}MoveL pPick,v100,fine,tGrip;\nMoveL pHome,v100,fine,tGrip;\n"
    first = written(tmp_path, "one.mod", f"{HEAD}{rapid}{waiting}ENDPROC\nENDMODULE\n")
    renamed = (HEAD + rapid).replace("pHome", "p1").replace("pPick", "p2")
    early = renamed.replace("PROC main()", "PROC main()\nWaitDI diPart,1;")
    text = f"{renamed}{waiting.replace('pPick', 'p2')}ENDPROC\nENDMODULE\n"
    second = written(tmp_path, "two.mod", text)
    script = written(
        tmp_path, "part.toml", '[[set]]\ninput = "diPart"\nwhen = "visit 2 of pHome"\n'
    )
    driven = Proving(script=script)
    assert compare(first, second, proving=driven).equal
    second.write_text(f"{early}MoveL p2,v100,fine,tGrip;\nENDPROC\nENDMODULE\n")
    assert compare(first, second, proving=driven).answer == "different"
    script.write_text(script.read_text().replace("pHome", "pHomme"))
    (told,) = [f for f in compare(first, second, proving=driven).findings if f.code == "CO126"]
    assert "at a visit of `phomme`" in told.message and "`phome`" in told.cure


RENAMED = PICKING.replace("diPart", "diReady").replace("doGrip", "doTake").replace("doDone", "doOk")


def test_names_of_a_table_and_by_their_order(tmp_path: Path) -> None:
    first = written(tmp_path, "one.mod", HEAD + PICKING)
    second = written(tmp_path, "two.mod", HEAD + RENAMED)
    done = compare(first, second)
    assert done.equal
    told = [f.message for f in done.findings if f.code == "CO121"]
    assert len(told) == 3 and any("`diPart` is taken for `diReady`" in one for one in told)
    crossed = {"doGrip": "doOk", "doDone": "doTake"}
    assert compare(first, second, names=crossed).answer == "different"
    table = written(tmp_path, "names.toml", '[names]\ndoGrip = "doTake"\ndoDone = "doOk"\n')
    done = compare(first, second, names=table)
    assert done.equal and [f.code for f in done.findings] == ["CO121"]


def test_what_nobody_can_pair_is_not_compared(tmp_path: Path) -> None:
    first = written(tmp_path, "one.mod", HEAD + PICKING)
    second = written(
        tmp_path, "two.mod", HEAD + RENAMED.replace("SetDO doTake,0;", "SetDO doOff,1;")
    )
    with pytest.raises(Refused) as refused:
        compare(first, second)
    assert refused.value.exit_status == 2
    assert {f.code for f in refused.value.findings} >= {"CO120"}
    with pytest.raises(Refused) as refused:
        compare(first, second, names={"doGrib": "doTake"})
    assert "`doGrib` in the first program" in str(refused.value)


def test_shared_data_is_paired_by_the_table(tmp_path: Path) -> None:
    body = "PROC main()\n  nTotal:=nTotal+1;\n  SetDO doDone,1;\nENDPROC\nENDMODULE\n"
    text = f"PERS num nTotal:=0;\n{body}"
    first = written(tmp_path, "one.mod", HEAD + text)
    other = text.replace("nTotal", "nCount").replace("+1", "+2")
    second = written(tmp_path, "two.mod", HEAD + other)
    assert compare(first, second).equal
    done = compare(first, second, names={"nTotal": "nCount"})
    assert done.differences[0].what.endswith("`ntotal` is 1, and `ntotal` is 2")


def test_a_program_that_does_nothing_is_not_compared(tmp_path: Path) -> None:
    script = written(tmp_path, "s.toml", '[[set]]\ninput = "diOpen"\n')
    body = "PROC main()\n  WaitDI diPart,1;\nENDPROC\nENDMODULE\n"
    waits = written(tmp_path, "one.mod", HEAD + body)
    done = compare(waits, waits, proving=Proving(script=script))
    assert (done.answer, done.exit_status) == ("not compared", 2)
    none = written(tmp_path, "two.mod", HEAD + "PROC main()\nENDPROC\nENDMODULE\n")
    done = compare(none, none)
    assert (done.answer, done.exit_status) == ("not compared", 2)
    assert [f.code for f in done.findings] == ["CO123"]


def test_programs_of_folders_are_paired_by_their_names(tmp_path: Path) -> None:
    for folder in ("old", "new"):
        (tmp_path / folder).mkdir()
        written(tmp_path / folder, "PICK.prg", PICKED + POSITIONS)
    written(tmp_path / "old", "GLUE.prg", GLUED + POSITIONS)
    pairs = counterparts(str(tmp_path / "old"), str(tmp_path / "new"), "melfa-basic-5")
    assert [Path(one.name).name for one, _ in pairs.both] == ["PICK.prg"]
    assert [Path(name).name for name, _ in pairs.lone] == ["GLUE.prg"]


def test_a_counter_is_one_less_where_a_loop_ends_early(tmp_path: Path) -> None:
    retried = """PROC main()
  VAR num n;
  n:=0;
  WHILE diPart=1 AND n<3 DO
    MoveL pPick,v200,fine,tGrip;
    MoveL pHome,v200,fine,tGrip;
    n:=n+1;
  ENDWHILE
  IF n>=3 THEN
    PulseDO\\PLength:=0.5,doGrip;
  ENDIF
ENDPROC
ENDMODULE
"""
    one = written(tmp_path, "one.mod", HEAD + retried)
    other = written(tmp_path, "other.mod", HEAD + retried.replace("n>=3", "n>=2"))
    cell = written(tmp_path, "cell.process.toml", CELL)
    done = compare(one, other, process=[cell, cell])
    assert done.answer == "different"
    assert "diPart=1, then diPart=0" in done.differences[0].inputs
    assert compare(one, one, process=[cell, cell]).equal


@pytest.mark.parametrize(
    "idle",
    [
        "WHILE TRUE DO\n  ENDWHILE",
        pytest.param("here:\n  GOTO here;", marks=pytest.mark.slow),
    ],
)
def test_a_program_that_goes_on_without_doing_anything_is_another_one(
    tmp_path: Path, idle: str
) -> None:
    cycle = (
        "PROC main()\n  WHILE TRUE DO\n  MoveL pPick,v200,fine,tGrip;\n{}"
        "  MoveL pHome,v200,fine,tGrip;\n  ENDWHILE\nENDPROC\n"
    )
    one = written(tmp_path, "one.mod", HEAD + cycle.format("") + "ENDMODULE\n")
    other = written(tmp_path, "other.mod", HEAD + cycle.format(f"  {idle}\n") + "ENDMODULE\n")
    done = compare(one, other)
    assert done.answer == "different"
    assert "does less in" in done.differences[0].what


def test_a_program_that_does_nothing_without_end_is_itself(tmp_path: Path) -> None:
    idle = "PROC main()\n  WHILE TRUE DO\n  ENDWHILE\nENDPROC\nENDMODULE\n"
    one = written(tmp_path, "one.mod", HEAD + idle)
    assert compare(one, one).answer != "different"


def test_an_interrupt_whose_input_stays_is_answered_alike(tmp_path: Path) -> None:
    code = """Def Act 1,M_In(4)=1 GoSub *SAFE
Tool PTOOL
Spd 100
Act 1=1
Mvs PPICK
Mvs PPLACE
Dly 1
Mvs PHOME
Act 1=0
End
*SAFE
M_Out(10)=1 Dly 0.5
Return 0
"""
    source = written(tmp_path, "SAFE.mb5", code + POSITIONS)
    done = translate(source, to="rapid", language="melfa-basic-5", proving=Proving())
    assert done.ok and done.motion is not None and done.motion.found is not None
    assert done.motion.holds, done.motion.findings


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [300, 2000])
def test_a_loop_that_waits_for_the_time_is_not_without_effect(seconds: int) -> None:
    body = f"""PROC main()
  VAR clock timer;
  WHILE TRUE DO
    MoveL pPick,v200,fine,tGrip;
    ClkReset timer;
    ClkStart timer;
    WaitUntil ClkRead(timer)>{seconds};
    MoveL pHome,v200,fine,tGrip;
  ENDWHILE
ENDPROC
ENDMODULE
"""
    loaded = load_text(SourceText(HEAD + body), language="rapid")
    done = translate(loaded, to="melfa-basic-6", proving=Proving())
    assert done.ok and done.motion is not None and done.motion.holds


WATCHING = """VAR intnum iWatch;
PROC main()
MoveL pHome,v100,fine,tGrip;
CONNECT iWatch WITH tWatch;
ISignalDI diPart,1,iWatch;
MoveL pPick,v100,fine,tGrip;
WaitTime 1;
MoveL pHome,v100,fine,tGrip;
IDelete iWatch;
MoveL pPick,v100,fine,tGrip;
SetDO doDone,0;
ENDPROC
TRAP tWatch
SetDO doDone,1;
ENDTRAP
ENDMODULE
"""
WATCHED = """Def Act 1,M_In(4)<>MSEEN GoSub *CAME
Tool PTOOL
Spd 100
Cnt 0
Mvs PHOME
MSEEN=M_In(4)
Act 1=1
Mvs PPICK
Dly 1
Mvs PHOME
Act 1=0
Mvs PPICK
M_Out(11)=0
End
*CAME
MSEEN=M_In(4)
If MSEEN=1 Then M_Out(11)=1
Return 0
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("typed", "instead"),
    [
        ("Def Act 1,M_In(4)<>MSEEN GoSub *CAME\n", "Def Act 1,M_In(5)<>MSEEN GoSub *CAME\n"),
        ("Act 1=1\n", ""),
        ("Act 1=0\n", ""),
        ("Mvs PHOME\nAct 1=0\n", "Act 1=0\nMvs PHOME\n"),
        ("If MSEEN=1 Then M_Out(11)=1", "If MSEEN=0 Then M_Out(11)=1"),
        ("If MSEEN=1 Then M_Out(11)=1", "If MSEEN=1 Then M_Out(10)=1"),
        ("*CAME\nMSEEN=M_In(4)\n", "*CAME\n"),
    ],
)
def test_a_fault_of_an_interrupt_is_found(tmp_path: Path, typed: str, instead: str) -> None:
    equal = compared(tmp_path, WATCHING, WATCHED)
    assert equal.answer == "equal" and "other moments of interrupts, stops" in equal.line()
    assert WATCHED.count(typed) == 1
    done = compared(tmp_path, WATCHING, WATCHED.replace(typed, instead))
    assert done.answer == "different"


def test_a_run_without_end_is_compared_also_where_the_time_of_the_search_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = itertools.count()
    # A millisecond for each look at the clock: the search is over in the middle of its second run.
    monkeypatch.setattr(search.time, "thread_time", lambda: next(clock) / 1000)
    monkeypatch.setattr(search, "QUIET_STATEMENTS", 3000)
    interrupted_for_ever = WATCHED.replace("*CAME\nMSEEN=M_In(4)\n", "*CAME\n")
    done = compared(tmp_path, WATCHING, interrupted_for_ever, seconds=0.05)
    assert done.answer == "different"


@pytest.mark.parametrize(
    ("edge", "handler", "instead"),
    [
        ("0", "SetDO doDone,1;", "SetDO doDone,0;"),
        ("0", "SetDO doDone,1;", ""),
        ("1", "Incr nCame;\nIF nCame=2 SetDO doDone,1;", "Incr nCame;"),
    ],
)
def test_an_interrupt_of_an_input_that_goes_or_comes_again_is_tried(
    tmp_path: Path, edge: str, handler: str, instead: str
) -> None:
    right = HEAD + "VAR num nCame:=0;\n" + WATCHING.replace("diPart,1,", f"diPart,{edge},")
    right = right.replace("SetDO doDone,0;\n", "").replace("SetDO doDone,1;", handler)
    one = written(tmp_path, "right.mod", right)
    two = written(tmp_path, "wrong.mod", right.replace(handler, instead))
    assert compare(one, one).answer == "equal"
    assert compare(one, two).answer == "different"


LOOP = """FOR i FROM 1 TO 2 DO
IF i=1 MoveL pHome,v100,fine,tGrip;
ENDFOR
"""


@pytest.mark.parametrize("loop", ["", LOOP])
def test_an_interrupt_alone_is_tried(tmp_path: Path, loop: str) -> None:
    """Neither program reads an input but by its interrupt; the first run takes every branch."""
    code = HEAD + WATCHING.replace("PROC main()\n", f"PROC main()\n{loop}")
    one = written(tmp_path, "one.mod", code)
    other = written(tmp_path, "two.mod", code.replace("SetDO doDone,1", "SetDO doGrip,1"))
    cell = written(tmp_path, "cell.process.toml", CELL)
    assert compare(one, one, process=[cell, cell]).equal
    assert compare(one, other, process=[cell, cell]).answer == "different"


@pytest.mark.slow
def test_a_loop_that_only_looks_does_less(tmp_path: Path) -> None:
    endless = WATCHED.replace("*CAME\n", "*CAME\nWhile M_In(4)=1\nWEnd\n")
    done = compared(tmp_path, WATCHING, endless)
    assert done.answer == "different", done.line()
