"""Statements as lines, in every dialect: what is written says what was meant, there and back."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.compiler.read_back_proof import prove_read_back
from assistant.compiler.retarget import with_joint_speed
from assistant.languages.language_types import Frames
from assistant.program.program import Program, Signal
from assistant.program.statements import Comment

RAPID = languages.get("rapid")
DIALECTS = ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6"]
SIGNALS = {
    "glue": Signal("digital", "output", 5),
    "ok": Signal("digital", "input", 7),
    "mode": Signal("group", "output", 32, 8),
    "job": Signal("group", "input", 40, 5),
    "answer": Signal("group", "output", 48, 12),
    "pressure": Signal("analog", "output", 6010),
}
DATA = """\
 CONST robtarget home:=[[600,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 CONST robtarget seat:=[[100,50,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 CONST robtarget left:=[[120,70,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 CONST robtarget rim_1:=[[10,0,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 CONST robtarget rim_2:=[[20,0,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 CONST robtarget rim_3:=[[30,5,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 CONST robtarget rim_4:=[[40,0,5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
 PERS tooldata pen:=[TRUE,[[0,0,120],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];
 PERS wobjdata tray:=[FALSE,TRUE,"",[[500,100,20],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
"""


def program(main: str, beside: str = "", data: str = "") -> Program:
    """A RAPID program of this body, with other routines and data, as the pseudo-program."""
    text = f"MODULE job\n{DATA}{data}\n PROC main()\n{main}\n ENDPROC\n{beside}\nENDMODULE\n"
    tree = RAPID.parse(text)
    assert not tree.findings, tree.findings
    return replace(RAPID.lift(tree), signals=SIGNALS)


def written(given: Program, name: str, frames: Frames = "base") -> str:
    """The code lines of the main file, without step numbers; proven, also by way of RAPID."""
    language = languages.get(name).with_frames(frames)
    adapted = language.adapt(given)
    assert not [f for f in adapted.findings if f.severity is Severity.ERROR], adapted.findings
    tree = language.build(adapted.program)
    files = {language.file_name(adapted.program): language.encode(tree)}
    proof = prove_read_back(language, adapted.program, files)
    assert proof.holds, proof.findings
    assert language.adapt(adapted.program).program == adapted.program
    lifted = language.lift(tree)
    back = RAPID.adapt(with_joint_speed(lifted, 100.0)[0])
    assert not [f for f in back.findings if f.severity is Severity.ERROR], back.findings
    module = {"job.mod": RAPID.encode(RAPID.build(back.program))}
    again = prove_read_back(RAPID, back.program, module)
    assert again.holds, again.findings
    lines = [line.strip().split(" ", 1)[-1] for line in language.render(tree).splitlines()]
    end = lines.index("' robot-assistant: end")
    return "\n".join(line.strip() for line in lines[end + 1 :])


STATEMENTS = [
    ("WaitTime 0.5;", "DLY 0.5"),
    ("SetDO glue,1;", "M_OUT(5)=1"),
    ("PulseDO\\High\\PLength:=0.3,glue;", "M_OUT(5)=1 DLY 0.3"),
    ("SetAO pressure,3;", "M_DOUT(6010)=3"),
    ("WaitDI ok,1;", "WAIT M_IN(7)=1"),
    ("SetDO hand1_open,1;", "HOPEN 1"),
    ("AccSet 50,100;", "ACCEL 50,50"),
    ("VelSet 40,5000;", "OVRD 40"),
    ("Stop;", "HLT"),
    ("Incr n;", "MN=MN+1"),
    ("n:=Round(Sqrt(Abs(n))+ATan2(n,1));", "MN=CINT(SQR(ABS(MN))+DEG(ATN2(MN,1)))"),
    ("n:=Sin(30)*2;", "MN=SIN(RAD(30))*2"),
    ("n:=Distance(home.trans,seat.trans);", "MN=DIST(PHOME,PSEAT)"),
    ('t:="no. "+NumToStr(n,0);', 'CT$="no. "+STR$(CINT(MN))'),
    ("t:=StrPart(t,2,3);", "CT$=MID$(CT$,2,3)"),
    ("n:=StrLen(t);", "MN=LEN(CT$)"),
    ("spot:=home;", "PSPOT=PHOME"),
    ("spot.trans.x:=spot.trans.x+5;", "PSPOT.X=PSPOT.X+5"),
    ("axes:=CJointT();", "JAXES=J_CURR"),
    ("axes.robax.rax_2:=15;", "JAXES.J2=RAD(15)"),
    ("n:=axes.robax.rax_3;", "MN=DEG(JAXES.J3)"),
    ("heights{2}:=heights{n}+1;", "MHEIGHTS(2)=MHEIGHTS(MN)+1"),
    ("FOR i FROM 3 TO 1 STEP -1 DO\nn:=n+i;\nENDFOR",
     "FOR MI=3 TO 1 STEP -1\nMN=MN+MI\nNEXT MI"),
    ("WHILE n<3 DO\nn:=n+1;\nENDWHILE", "WHILE MN<3\nMN=MN+1\nWEND"),
]  # fmt: skip


@pytest.mark.parametrize("name", DIALECTS)
def test_statements_one_by_one(name: str) -> None:
    """All are in one program, each after a comment with its number."""
    data = " VAR num n;\n VAR string t;\n VAR robtarget spot;\n VAR jointtarget axes;\n"
    data += " VAR num heights{3};\n"
    main = "\n".join(f"! --{row}--\n{one}" for row, (one, _) in enumerate(STATEMENTS))
    text = written(program(main, data=data), name).upper()
    _, *parts = re.split(r"^' --\d+--$", text, flags=re.MULTILINE)
    assert len(parts) == len(STATEMENTS), text
    for part, (one, lines) in zip(parts, STATEMENTS, strict=True):
        assert lines.upper() in part, one


@pytest.mark.parametrize("name", DIALECTS)
def test_a_group_of_an_odd_width_leaves_the_bits_beside_it(name: str) -> None:
    text = written(program("SetGO answer,n;\nn:=job;\nSetGO mode,3;", data=" VAR num n;\n"), name)
    wide, narrow = ("M_OUTW", "M_INB") if name.endswith("4") else ("M_Out16", "M_In8")
    with_and = " AND " if name.endswith("4") else " And "
    with_or = " OR " if name.endswith("4") else " Or "
    assert f"{wide}(48)=({wide}(48){with_and}&HF000){with_or}" in text
    number = "Mn" if name.endswith("6") else "MN"
    assert f"({number}{with_and}&HFFF)" in text
    assert f"{number}={narrow}(40){with_and}&H1F" in text


@pytest.mark.parametrize("name", DIALECTS)
def test_a_wait_with_a_time_limit_ends_with_an_error(name: str) -> None:
    text = written(program("WaitDI ok,1\\MaxTime:=2.5;\nWaitUntil n>3\\MaxTime:=n;",
                           data=" VAR num n;\n"), name).upper()  # fmt: skip
    assert (
        "M_TIMER(1)=0\n*W1\nIF M_IN(7)=1 THEN *W1Z ' OK\nIF M_TIMER(1)<2500 THEN *W1\n"
        "ERROR 9100\n*W1Z\n" in text
    )
    assert "IF M_TIMER(1)<MN*1000 THEN *W2" in text


@pytest.mark.parametrize("name", DIALECTS)
def test_computed_targets_are_put_together(name: str) -> None:
    main = "MoveL Offs(seat,10*n,0,-n),v100,fine,pen\\WObj:=tray;\nspot:=Offs(home,n,0,5);"
    data = " VAR num n:=2;\n VAR robtarget spot;\n"
    text = written(program(main, data=data), name).upper().replace("PAT_1", "PAT1")
    assert "PAT1=PSEAT\nPAT1.X=PAT1.X+10*MN\nPAT1.Z=PAT1.Z-MN\n" in text
    assert "MVS PAT1" in text
    assert "PSPOT=PHOME\nPSPOT.X=PSPOT.X+MN\nPSPOT.Z=PSPOT.Z+5\n" in text


@pytest.mark.parametrize("name", DIALECTS)
def test_arrays_are_filled_when_the_program_starts(name: str) -> None:
    data = (
        " CONST num steps{2,2}:=[[1,2],[3,4]];\n"
        " CONST robtarget stops{2}:=[[[1,0,9],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],"
        "[[2,0,9],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];\n VAR num n:=1;\n"
    )
    text = written(program("MoveL stops{n},v100,fine,pen;\nn:=steps{2,n};", data=data), name)
    text = text.upper()
    assert "DIM MSTEPS(2,2)\nDIM PSTOPS(2)\n" in text
    assert "MSTEPS(1,2)=2\nMSTEPS(2,1)=3" in text
    assert (
        "PSTOPS(2)=(+2.00,+0.00,+9.00,+180.00,+0.00,+180.00)(7,0)" in text.partition("\nEND\n")[2]
    )
    assert "MVS PSTOPS(MN)" in text
    assert "MN=MSTEPS(2,MN)" in text


@pytest.mark.parametrize(("axis", "refused"), [("b", False), ("c", True), ("f", True)])
def test_only_two_additional_axes_have_components(axis: str, refused: bool) -> None:
    given = program(f"j:=CJointT();\nn:=j.extax.eax_{axis};", data="VAR jointtarget j;\nVAR num n;")
    found = languages.get("melfa-basic-6").adapt(given).findings
    assert ("MB209" in {one.code for one in found}) == refused


def test_a_short_if_is_one_line_in_iv() -> None:
    main = "IF ok=1 THEN\nSetDO glue,1;\nELSE\nn:=2;\nENDIF\nIF n>1 n:=0;"
    text = written(program(main, data=" VAR num n;\n"), "melfa-basic-4")
    assert "IF M_IN(7)=1 THEN M_OUT(5)=1 ELSE MN=2 ' ok, glue\nIF MN>1 THEN MN=0\nRETURN\n" in text
    text = written(program(main, data=" VAR num n;\n"), "melfa-basic-5")
    assert "If M_In(7)=1 Then ' ok\nM_Out(5)=1 ' glue\nElse\nMN=2\nEndIf\n" in text


@pytest.mark.parametrize("name", DIALECTS)
def test_names_of_signals_stand_behind_their_numbers(name: str) -> None:
    main = (
        "SetDO glue,1;\nSetDO glue,0; ! glue\nSetDO glue,1; ! on\n"
        "IF ok=1 THEN ! ok\nSetGO mode,3;\nENDIF"
    )
    given = program(main)
    text = written(given, name).upper()
    assert "M_OUT(5)=1 ' GLUE\n" in text
    assert "' GLUE\nM_OUT(5)=0\n" in text  # a comment of the source keeps its own line
    assert "M_OUT(5)=1 ' ON\n" in text  # a comment of the source stays
    assert "M_OUTB(32)=3 ' MODE\n" in text.replace("M_OUT8", "M_OUTB")
    language = languages.get(name)
    back = language.lift(language.build(language.adapt(given).program))
    said = [one.text for one in back.statements() if isinstance(one, Comment)]
    assert said == ["glue", "on", "ok"]  # the comments of the source alone


@pytest.mark.parametrize("name", DIALECTS)
def test_names_that_say_nothing_or_may_be_wrong_do_not_stand_there(name: str) -> None:
    given = program("SetDO do_9,1;\nSetGO mode,3;\nSetGO low,3;")
    more = {"do_9": Signal("digital", "output", 9), "low": Signal("group", "output", 32, 4)}
    text = written(replace(given, signals={**SIGNALS, **more}), name).upper()
    assert "M_OUT(9)=1\n" in text
    assert "' LOW" not in text and "' MODE" not in text  # both begin at output 32


def test_long_names_keep_all_their_words() -> None:
    data = " VAR num nPartsOnTheLeftPallet;\n VAR num nPartsOnTheRightPallet;\n"
    main = "nPartsOnTheLeftPallet:=1;\nnPartsOnTheRightPallet:=2;\nfillTheTrayOnTheLeft;"
    given = program(main, " PROC fillTheTrayOnTheLeft()\n ENDPROC", data)
    five = written(given, "melfa-basic-5")
    assert "MNPARONTHELEFPAL=1\nMNPARONTHERIGPAL=2\nGOSUB *FITHETRAONTHELEF" in five.upper()
    assert "MNPONTLP=1\nMNPONTRP=2\n" in written(given, "melfa-basic-4")


def test_cases_of_one_number_are_select() -> None:
    main = "TEST n\nCASE 1:\nn:=2;\nCASE 2:\nn:=3;\nDEFAULT:\nn:=0;\nENDTEST"
    given = program(main, data=" VAR num n;\n")
    assert "SELECT MN\nCASE 1\nMN=2\nCASE 2\nMN=3\nDEFAULT\nMN=0\nEND SELECT" in written(
        given, "melfa-basic-4"
    )
    six = written(given, "melfa-basic-6")
    assert "Case 1\nMn=2\nBreak\nCase 2\nMn=3\nBreak\nDefault\nMn=0\nBreak\nEnd Select" in six


MOVES = """\
 MoveJ home,v1000,fine,pen;
 MoveJ Offs(seat,0,0,50),v1000,z10,pen\\WObj:=tray;
 MoveL seat,v100,fine,pen\\WObj:=tray;
 MoveC left,rim_1,v50,z1,pen\\WObj:=tray;
 MoveL RelTool(left,0,0,-30),v100,fine,pen\\WObj:=tray;
 MoveL rim_1,v100,fine,pen\\WObj:=tray;
 MoveL rim_2,v100,z1,pen\\WObj:=tray;
 MoveC rim_3,rim_4,v100,fine,pen\\WObj:=tray;
 MoveL home,v100,fine,pen;
 MoveC left,seat,v50,fine,pen\\WObj:=tray;"""


@pytest.mark.parametrize("name", DIALECTS)
def test_frames_are_the_base_or_factors(name: str) -> None:
    base = written(program(MOVES), name).upper()
    assert "BASE PTRAY\n" in base
    assert "PTRAY=(-500.00,-100.00,-20.00," in base
    assert "PTRAY*" not in base
    product = written(program(MOVES), name, "product").upper()
    assert product.count("BASE ") == product.count("BASE P_NBASE") == 1
    assert "MOV PTRAY*(PSEAT+(0,0,50,0,0,0))\n" in product
    assert "MVS PTRAY*PSEAT\n" in product
    assert "MVS PTRAY*PLEFT,-30\n" in product
    assert "PTRAY=(+500.00,+100.00,+20.00," in product
    assert "(7,0)" in next(x for x in product.splitlines() if x.startswith("PTRAY="))


def test_a_product_has_one_arm_branch() -> None:
    other = " CONST robtarget far:=[[1,2,3],[0,0,1,0],[0,0,0,4],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
    main = "MoveL seat,v100,fine,pen\\WObj:=tray;\nMoveJ far,v100,fine,pen\\WObj:=tray;"
    given = program(main, data=other)
    five = languages.get("melfa-basic-5")
    assert "MB228" not in {f.code for f in five.adapt(given).findings}
    assert "MB228" in {f.code for f in five.with_frames("product").adapt(given).findings}


def test_names_and_texts_of_another_world_come_back() -> None:
    data = " VAR num n:=1;\n VAR string t;\n"
    given = program('t:="say ""hello""";', data=data)
    renamed = replace(given, variables={"größe": given.variables["n"], "t": given.variables["t"]})
    adapted = languages.get("melfa-basic-4").adapt(renamed)
    assert "MB226" in {f.code for f in adapted.findings}
    text = written(renamed, "melfa-basic-4")
    assert "MGROSSE=1" in text or "MGROE=1" in text
    assert "CT$=\"say 'hello'\"" in text
    tree = languages.get("melfa-basic-4").build(adapted.program)
    assert languages.get("melfa-basic-4").render(tree).isascii()
    assert "größe" in languages.get("melfa-basic-4").lift(tree).variables


def foreign(text: str, level: int) -> Program:
    language = languages.get(f"melfa-basic-{level}")
    return language.lift(language.parse(text))


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-6"])
def test_an_external_variable_keeps_its_name(name: str) -> None:
    """Programs share it by that name, another one would be a variable of this program alone."""
    language = languages.get(name)
    program = foreign('M_01=M_01+1\nP_Ab=P_01\nC_01$="a"\nEnd\n', 5)
    adapted = language.adapt(program, None).program
    lines = language.render(language.build(adapted, None)).upper()
    for line in ("M_01=M_01+1", "P_AB=P_01", 'C_01$="A"'):
        assert line in lines
    files = {"A.prg": language.encode(language.build(adapted, None))}
    assert prove_read_back(language, adapted, files, None).holds


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-6"])
def test_an_expression_of_one_dialect_is_one_of_another(name: str) -> None:
    language = languages.get(name)
    adapted = language.adapt(foreign("M1=3\nM3=Not M1\nEnd\n", 5), None).program
    lines = language.render(language.build(adapted, None)).upper()
    assert "M3=NOT M1" in lines
    files = {"A.prg": language.encode(language.build(adapted, None))}
    assert prove_read_back(language, adapted, files, None).holds


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("Total=3\nMov P1 Wth M_Out(3)=Total\n", ["MB232"]),
        ("Total=3\nM1=Not Total\n", ["MB232"]),
        ("Def Act 1,M_In(3)=1 GoSub *A_Long_One\nEnd\n*A_Long_One\nHlt\n", ["MB232"]),
        ("M1=3\nMov P1 Wth M_Out(3)=M1\n", []),
    ],
)
def test_vendor_text_keeps_the_names_that_are_written(text: str, codes: list[str]) -> None:
    """`Total` is written `MTOTAL`; a text that kept `Total` would mean another variable."""
    position = "P1=(300,0,300,180,0,180)(7,0)\n"
    adapted = languages.get("melfa-basic-6").adapt(foreign(text + position, 5), None)
    assert [f.code for f in adapted.findings if f.severity is Severity.ERROR] == codes
