"""Programs as people write them: what they mean, and what is wrong with them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from assistant import languages
from assistant.base.diagnostics import Severity
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Configuration
from assistant.program.motion import FINE, Blend, Path, Speed
from assistant.program.program import Procedure, Program, Signal
from tests.tables import every_row

FIVE = languages.get("melfa-basic-5")
FOUR = languages.get("melfa-basic-4")

WRITTEN = """\
1 'pick and place
2 Servo On
3 Spd 100
4 Tool PT
5 *LOOP
6 Cnt 0
7 Mov PHOME
8 If M_In(3)=1 Then
9   GoSub *PICK
10 EndIf
11 Mvs P1
12 Mvs P2
13 Mvr P2,P3,P4
14 Cnt 1,5,8
15 Mvs P5
16 M1 = M1 + 1
17 If M1 > 10 Then *FIN Else *LOOP
18 *FIN
19 Hlt
20 End
21 *PICK 'get it
22 HClose 1
23 Mov P9,-50
24 Mvs P9
25 M_Out(17)=1 Dly 0.2
26 Select M1
27 Case 1
28 Mov P9
29 Break
30 Case 2
31 Dly 1
32 End Select
33 Return
PT=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)(0,0)
PHOME=(+400.00,+0.00,+600.00,+180.00,+0.00,+180.00)(7,0)
P1=(+10.00,+0.00,+600.00,+180.00,+0.00,+180.00)(7,0)
P2=(+20.00,+0.00,+600.00,+180.00,+0.00,+180.00)(7,0)
P3=(+30.00,+5.00,+600.00,+180.00,+0.00,+180.00)(3,1)
P4=(+40.00,+0.00,+600.00,+180.00,+0.00,+180.00)(7,0)
P5=(+50.00,+0.00,+600.00,+180.00,+0.00,+180.00)(7,0)
P9=(+90.00,+0.00,+600.00,+180.00,+0.00,+180.00)(7,0)
"""


def test_written_program() -> None:
    tree = FIVE.parse(WRITTEN)
    assert FIVE.check([tree]) == ()
    program = FIVE.lift(tree)
    assert program.comments == ("pick and place",)
    taught = [f"P{number}" for number in (1, 2, 3, 4, 5)]
    assert list(program.targets) == ["PHOME", *taught, "P9"]
    assert program.targets["P3"].configuration == Configuration(back=True, quadrants=(4, 0, 0))
    assert program.tools["PT"].tip.position == (0.0, 0.0, 100.0)
    assert program.signals["di_3"] == Signal("digital", "input", 3)
    main, pick = program.procedures
    servo, label, home, test, *moves, count, again, fin, stop = main.body
    assert servo == p.Opaque("melfa-basic-5", "Servo On")
    assert label == p.Label("LOOP")
    motion = p.Motion(Speed(math.inf, joint=100.0), FINE, "PT")
    assert home == p.Move("joint", e.Name("PHOME"), motion)
    condition = e.Binary("=", e.Name("di_3"), e.Number(1))
    assert test == p.If((p.Branch(condition, (p.Call("PICK"),)),))
    one, two, three, four, five = map(e.Name, taught)
    along = p.Motion(Speed(100.0), FINE, "PT")
    assert moves == [
        p.Move("linear", one, along),
        p.Move("linear", two, along),
        p.MoveCircular(three, four, along),
        p.Move("linear", five, replace(along, blend=Blend(5.0, 8.0))),
    ]
    assert isinstance(count, p.Assign)
    assert isinstance(again, p.If)
    assert again.branches[0].body == (p.Goto("FIN"),)
    assert again.otherwise == (p.Goto("LOOP"),)
    assert (fin, stop) == (p.Label("FIN"), p.Stop())
    assert pick.name == "PICK"
    note, hand, back, down, glue, switch = pick.body
    assert note == p.Comment("get it")
    assert hand == p.Gripper("close", 1)
    relative = e.Apply("relative", (e.Name("P9"), e.Number(0), e.Number(0), e.Number(-50)))
    assert back == p.Move("joint", relative, motion)
    assert isinstance(down, p.Move)
    assert glue == p.SetSignal("do_17", e.Number(1), e.Number(0.2))
    assert switch == p.Switch(
        e.Name("M1"),
        (
            p.Case((e.Number(1),), (p.Move("joint", e.Name("P9"), motion),)),
            p.Case((e.Number(2),), (p.Wait(e.Number(1)),)),
        ),
    )


def test_written_program_goes_to_another_version() -> None:
    program = FIVE.lift(FIVE.parse(WRITTEN.replace("2 Servo On\n", "")))
    adapted = FOUR.adapt(program)
    assert not [f for f in adapted.findings if f.severity is Severity.ERROR]
    text = FOUR.render(FOUR.build(adapted.program))
    assert FOUR.lift(FOUR.parse(text)).procedures == adapted.program.procedures


@every_row(
    ("lines", "code"),
    [
        ("10 GOTO *X", "MB101"),
        ("10 IF M1=1 THEN 200", "MB102"),
        ("10 *A\n20 *A", "MB103"),
        ("10 MOV P1", "MB104"),
        ("10 MOV J7", "MB104"),
        ("10 MOV P1\n20 MOV P2\nP1=(1,2,3,0,0,0)(7,0)", "MB104"),
        ("10 FOR M1=1 TO 3", "MB105"),
        ("10 WEND", "MB105"),
        ("10 WHILE M1=1\n20 NEXT\n30 WEND", "MB105"),
        ("10 MVERYLONG=1", "MB106"),
        ("10 *LONGLABEL", "MB106"),
        ("10 ' " + "x" * 130, "MB107"),
        ("20 END\n10 END", "MB108"),
        ("32768 END", "MB109"),
        ("10 HLT\nEND", "MB110"),
        ("10 IF M1=1 THEN\n20 HLT", "MB111"),
        ("10 END\nP1=(1,2,3,0,0,0)(7,0)\nP1=(1,2,3,0,0,0)(7,0)", "MB112"),
    ],
)
def test_checks(lines: str, code: str) -> None:
    tree = FOUR.parse(lines + "\n")
    assert not tree.findings
    found = FOUR.check([tree])
    assert code in {f.code for f in found}
    assert all(f.cure for f in found)


@every_row(
    ("statement", "code"),
    [
        (p.SetSignal("bare", e.Number(1)), "MB201"),
        (p.WaitSignal("bare", e.Number(1)), "MB201"),
        (p.SetSignal("level", e.Number(1)), "MB209"),
        (p.Call("nowhere"), "MB230"),
        (p.Goto("nowhere"), "MB209"),
        (p.Opaque("rapid", "TPErase;"), "MB209"),
        (p.Move("joint", e.Name("nowhere"), p.Motion(Speed(9.0, joint=1.0), FINE)), "MB229"),
        (p.Assign(e.Name("nowhere"), e.Number(1)), "MB229"),
        (p.Wait(e.Number(float("nan"))), "MB209"),
        (p.Gripper("open", 9), "MB209"),
    ],
)
def test_what_cannot_be_said_is_an_error(statement: p.Statement, code: str) -> None:
    program = Program(
        "job",
        (Procedure("main", (statement,)),),
        signals={
            "bare": Signal("digital", "output"),
            "ok": Signal("digital", "input", 3),
            "level": Signal("analog", "output", 4),
        },
    )
    found = [f for f in FOUR.adapt(program).findings if f.severity is Severity.ERROR]
    assert [f.code for f in found] == [code]


@pytest.mark.parametrize("value", [np.nan, np.inf, 9e9])
def test_no_wild_number_is_written(value: float) -> None:
    path = Path.of("seam", [[value, 0, 0]], [[1, 0, 0, 0]], speeds=[Speed(9.0)])
    program = Program("job", (Procedure("main", (p.Follow(path),)),))
    found = FOUR.adapt(program).findings
    assert "MB218" in {f.code for f in found if f.severity is Severity.ERROR}


def test_names_of_another_world_do_no_harm() -> None:
    program = Program(
        "Ünïcode-näme!",
        (Procedure("main", (p.Comment("a\r\n20 END ' x\x00"), p.Comment("ロボット"))),),
        comments=("one\ntwo",),
    )
    adapted = FOUR.adapt(program).program
    text = FOUR.render(FOUR.build(adapted))
    tree = FOUR.parse(text)
    assert not tree.findings
    assert text.count("\r\n") == len(tree.items) == len(text.splitlines())
    assert FOUR.lift(tree).procedures == adapted.procedures
    assert FOUR.file_name(adapted).isascii()


@every_row(
    ("text", "code"),
    [
        ("Mov P1\nM_Out(2)=1\nP1=(400,0,400,180,0,180)(7,0)\n", 2),
        ("Mov P1\nEnd\nM_Out(2)=1\n", 3),  # never come to, but no variable of the program
        ('Mov P1\nM1=1\nC1$="a"\n\nM2=2\nP1=(400,0,400,180,0,180)(7,0)\n', 4),
        ("*L\nMov P1\nGoTo *L\nM1=1\nP1=(400,0,400,180,0,180)(7,0)\n", 3),
        ("Mov P1\nEnd\nM1=1\nP1=(400,0,400,180,0,180)(7,0)\n", 2),
        ("Mov P1\nP1=(400,0,400,180,0,180)(7,0)\nM1=1\n", 1),
        ("M1=1\nP1=(400,0,400,180,0,180)(7,0)\n", 0),
    ],
)
def test_what_a_program_comes_to_is_no_variable_line(text: str, code: int) -> None:
    """Without step numbers, where assignments behind the last move are told from data."""
    items = FIVE.parse(text).items
    assert sum(isinstance(x, s.Line) for x in items) == code


def test_an_output_in_the_last_line_is_translated() -> None:
    text = "Mov P1\nM_Out(2)=1\nP1=(400,0,400,180,0,180)(7,0)\n"
    program = FIVE.lift(FIVE.parse(text))
    body = program.procedures[0].body
    assert isinstance(body[-1], p.SetSignal)
