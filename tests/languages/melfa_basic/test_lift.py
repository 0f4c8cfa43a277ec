"""What programs of others mean: settings along every way, functions, jumps."""

from __future__ import annotations

import pytest

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import FINE, Blend
from assistant.program.program import Parameter, Procedure
from tests.tables import every_row

from .lifting import body, lifted, moves, opaque

# ---------------------------------------------------------------------------- settings


def test_a_setting_that_depends_on_the_way_stays_with_its_move() -> None:
    program = lifted(
        "Spd 100\nIf M1=1 Then\nSpd 50\nEndIf\nMov P1\nMvs P2\nSpd 70\nMvs P1+(0,0,9)\n"
    )
    assert opaque(program) == ["Spd 100", "Spd 50", "Mvs P2"]
    joint, linear = moves(program.procedures[0])
    assert joint.kind == "joint"  # its speed is another one
    assert linear.motion.speed == p.Speed(70.0)


def test_the_same_setting_on_both_ways_is_known() -> None:
    program = lifted("If M1=1 Then\nSpd 50\nElse\nSpd 50\nEndIf\nMvs P1\nMvs P1\n")
    assert opaque(program) == []
    assert {m.motion.speed for m in moves(program.procedures[0])} == {p.Speed(50.0)}


def test_what_a_loop_sets_holds_at_its_beginning() -> None:
    """The first turn starts without rounding, every other one with it."""
    program = lifted("*TURN\nMvs P1+(0,0,1)\nCnt 1,5,8\nMvs P2+(0,0,1)\nGoTo *TURN\n")
    blends = [m.motion.blend for m in moves(program.procedures[0])]
    assert blends == [FINE, Blend(5.0, 8.0), Blend(5.0, 8.0), Blend(5.0, 8.0)]
    program = lifted("*TURN\nCnt 0\nMvs P1+(0,0,1)\nCnt 1,5,8\nMvs P2+(0,0,1)\nGoTo *TURN\n")
    assert [m.motion.blend for m in moves(program.procedures[0])] == [FINE, Blend(5.0, 8.0)]


def test_a_subroutine_is_read_once_for_each_tool_that_it_is_called_with() -> None:
    program = lifted(
        "Tool (0,0,100,0,0,0)\nGoSub *S\nTool (0,0,50,0,0,0)\nGoSub *S\nEnd\n*S\nMov P3\nReturn\n"
    )
    main, first, second = program.procedures
    assert [c.procedure for c in main.body if isinstance(c, p.Call)] == [first.name, second.name]
    tips = [program.tools[moves(q)[0].motion.tool].tip.position[2] for q in (first, second)]
    assert tips == [100.0, 50.0]


def test_what_a_subroutine_sets_holds_behind_its_call() -> None:
    program = lifted(
        "Spd 9\nGoSub *S\nMvs P1\nGoSub *T\nMvs P1\nEnd\n*S\nSpd 20\nReturn\n*T\nReturn\n"
    )
    assert [m.motion.speed for m in moves(program.procedures[0])] == [p.Speed(20.0)] * 2


@pytest.mark.parametrize("setting", ["Spd M_01", "Spd FNFast(M1)", "Tool 2", "Base P9", "Cnt M2"])
def test_a_setting_that_is_worked_out_leaves_moves_as_they_are(setting: str) -> None:
    program = lifted(f"{setting}\nMvs P1\n")
    assert opaque(program) == [setting, "Mvs P1"]


@every_row(
    ("text", "known"),
    [
        ("Spd M1*2\nMvs P1\nMvs P2\n", [True, True]),
        ("Spd M1*2\nMvs P1\nM1=M1+3\nMvs P2\n", [True, False]),
        ("Spd M1\nM2=3\nMvs P1\nGoSub *S\nMvs P2\nEnd\n*S\nM1=4\nReturn\n", [True, False]),
        ("Spd M1\nFor M1=1 To 2\nMvs P1\nNext\n", [False]),
        ("Spd M1\nInput #1,M1\nMvs P1\n", [False]),
        ("M1=1\n*L\nSpd M1\nMvs P1\nM1=M1+1\nIf M1<3 Then GoTo *L\n", [True]),
        ("Spd M1\nDef Act 1,M_In(1)=1 GoSub *S\nMvs P1\nEnd\n*S\nM1=2\nReturn\n", [False]),
    ],
)
def test_a_speed_that_is_worked_out_holds_until_its_variables_change(
    text: str, known: list[bool]
) -> None:
    program = lifted(text)
    made = {f"Mvs P{at}": True for at in range(1, len(known) + 1)}
    made |= dict.fromkeys((one for one in opaque(program) if one in made), False)
    assert list(made.values()) == known
    for move in moves(program.procedures[0]):
        assert isinstance(move.motion.speed, p.ComputedSpeed)


def test_a_tool_that_is_changed_is_no_constant() -> None:
    assert opaque(lifted("P1.Z=P1.Z+10\nTool P1\nMov P2\n")) == ["Tool P1", "Mov P2"]


# ------------------------------------------------------------------------------- jumps


def test_jumps_to_steps() -> None:
    program = lifted(
        "10 IF M1>3 THEN 30 ELSE 20\n20 GOSUB 50\n30 HLT\n40 END\n50 DLY 1\n60 RETURN\n", 4
    )
    main, sub = program.procedures
    test, label, call, last, stop = main.body
    assert isinstance(test, p.If)
    assert (*test.branches[0].body, *test.otherwise) == (p.Goto("L30"), p.Goto("L20"))
    assert (label, call, last, stop) == (p.Label("L20"), p.Call("L50"), p.Label("L30"), p.Stop())
    assert sub == Procedure("L50", (p.Wait(e.Number(1)),))


def test_on_goto_and_gosub() -> None:
    jump, a, stop, b, _ = body("On M1 GoTo *A,*B\n*A\nHlt\n*B\nHlt\n")
    subject = e.Apply("round", (e.Name("M1"),))
    wanted = (p.Case((e.Number(1),), (p.Goto("A"),)), p.Case((e.Number(2),), (p.Goto("B"),)))
    assert jump == p.Switch(subject, wanted)
    assert (a, stop, b) == (p.Label("A"), p.Stop(), p.Label("B"))


def test_a_jump_by_number_into_subroutines_comes_back() -> None:
    text = "On M1 GoSub *A,*B\nGoSub *A\nEnd\n*A\nHlt\nReturn\n*B\nHlt\nReturn\n"
    chosen, call = lifted(text).procedures[0].body
    assert isinstance(chosen, p.Switch)
    assert [case.body for case in chosen.cases] == [(p.Call("A"),), (p.Call("B"),)]
    assert call == p.Call("A")


def test_a_number_to_jump_by_is_rounded() -> None:
    main = body("On M1 GoTo *A,*A\nOn M2% GoTo *A,*A\n*A\nHlt\n")
    subjects = [node.subject for node in main if isinstance(node, p.Switch)]
    assert subjects == [e.Apply("round", (e.Name("M1"),)), e.Name("M2")]


def test_next_of_two_loops() -> None:
    (outer,) = body("For M1=3 To 1 Step -1\nFor M2=1 To 2\nDly 1\nNext M2,M1\n")
    assert isinstance(outer, p.For)
    assert outer.step == e.Number(-1)
    (inner,) = outer.body
    assert isinstance(inner, p.For)
    assert inner.body == (p.Wait(e.Number(1)),)


def test_break_leaves_the_innermost_block() -> None:
    loop, label = body("While 1\nIf M1=1 Then Break\nM1=M1+1\nWEnd\n")
    assert isinstance(loop, p.While)
    assert loop.condition == e.Truth(True)
    (test, _) = loop.body
    assert isinstance(test, p.If)
    assert test.branches[0].body == (p.Goto("leave"),)
    assert label == p.Label("leave")


def test_select_of_ranges() -> None:
    (test,) = body(
        "Select M1\nCase 1\nDly 1\nBreak\nCase 2 To 4\nDly 2\nCase Is >8\nDly 3\nDefault\nHlt\n"
        "End Select\n"
    )
    assert isinstance(test, p.If)
    assert len(test.branches) == 3
    assert test.otherwise == (p.Stop(),)
    low = e.Binary(">=", e.Name("M1"), e.Number(2))
    assert test.branches[1].condition == e.Binary(
        "and", low, e.Binary("<=", e.Name("M1"), e.Number(4))
    )


def test_what_cannot_be_followed_stays() -> None:
    """A subroutine does not begin inside a block."""
    program = lifted("GoSub *S\nIf M1=1 Then\n*S\nDly 1\nReturn\nEndIf\n")
    assert opaque(program)[0] == "GoSub *S"


def test_a_subroutine_that_is_also_run_into_is_there_twice() -> None:
    program = lifted("GoSub *S\n*S\nDly 1\nReturn\n")
    assert opaque(program) == ["Return"]  # that of the main program, which is an error
    main, sub = program.procedures
    assert main.body[0] == p.Call("S")
    assert sub.body == (p.Wait(e.Number(1)),)


# --------------------------------------------------------------------------- functions


def test_functions() -> None:
    main, add, step = lifted(
        "Def Inte MSum\nFunction Main\nMSum=fnAdd(2,MSum)\nfnStep(P1,MSum)\nFEnd\n"
        "' adds\nFunction M% fnAdd(ByVal A%, ByVal B%)\nfnAdd=A%+B%\nFEnd\n"
        "Function V fnStep(ByVal P, ByRef N%)\nIf N%>5 Then Exit Function\nMvs P\nFEnd\n"
    ).procedures
    sum_ = e.Name("MSum")
    assert main.body == (
        p.Assign(sum_, e.Apply("fnAdd", (e.Number(2), sum_))),
        p.Call("fnStep", (e.Name("P1"), sum_)),
    )
    assert add.parameters == (Parameter("A", "integer"), Parameter("B", "integer"))
    assert add.result == "integer"
    assert add.body == (p.Comment("adds"), p.Return(e.Binary("+", e.Name("A"), e.Name("B"))))
    assert step.parameters == (Parameter("P", "position"), Parameter("N", "integer", "inout"))
    test, move = step.body
    assert isinstance(test, p.If)
    assert test.branches[0].body == (p.Return(),)
    assert isinstance(move, p.Move)


def test_a_result_that_is_changed_later_is_a_variable() -> None:
    program = lifted(
        "Function Main\nFEnd\nFunction M fnR(ByVal A)\nfnR=0\nIf A>1 Then fnR=2\nFEnd\n"
    )
    result = program.procedures[1]
    assert list(result.variables) == ["result"]
    assert result.body[0] == p.Assign(e.Name("result"), e.Number(0))
    assert result.body[-1] == p.Return(e.Name("result"))


def test_a_function_takes_an_array() -> None:
    main, all_ = lifted(
        "Dim PRow(3),M1(2)\nFunction Main\nM1(2)=5\nfnAll(PRow,M1)\nFEnd\n"
        "Function V fnAll(ByVal PA(),ByRef MB%())\nMB%(1)=MB%(2)\nMov PA(MB%(1))\nFEnd\n"
    ).procedures
    assert all_.parameters == (
        Parameter("PA", "position", "in", 1), Parameter("MB", "integer", "inout", 1),
    )  # fmt: skip
    assert main.body[-1] == p.Call("fnAll", (e.Name("PRow"), e.Name("M1")))
    first = e.Index(e.Name("MB"), (e.Number(1),))
    assert all_.body[0] == p.Assign(first, e.Index(e.Name("MB"), (e.Number(2),)))
    (move,) = moves(all_)
    assert move.target == e.Index(e.Name("PA"), (first,))


@pytest.mark.parametrize("given", ["P1", "PGrid", "PRow(1)"])
def test_an_array_parameter_takes_an_array_of_one_extent(given: str) -> None:
    program = lifted(
        f"Dim PRow(3),PGrid(2,2)\nFunction Main\nfnAll({given})\nFEnd\n"
        "Function V fnAll(ByVal PA())\nMov PA(1)\nFEnd\n"
    )
    assert [type(node) for node in program.procedures[0].body] == [p.Opaque]


def test_a_function_that_takes_an_array_of_two_extents_is_kept_whole() -> None:
    text = "Function V fnAll(ByVal P())\nMov P(1,2)\nFEnd"
    program = lifted(f"Function Main\nFEnd\n{text}\n")
    (kept,) = program.declarations
    assert kept.text.splitlines() == text.splitlines()


def test_def_fn_and_fprm() -> None:
    main, mean = lifted("FPrm M1,P9\nDef FNAV(MA,MB)=(MA+MB)/2\nM5=FNAV(M1,3)\nMov P9\n").procedures
    assert main.parameters == (Parameter("M1", "number"), Parameter("P9", "position"))
    assert main.body[0] == p.Assign(e.Name("M5"), e.Apply("FNAV", (e.Name("M1"), e.Number(3))))
    half = e.Binary("/", e.Binary("+", e.Name("MA"), e.Name("MB")), e.Number(2))
    assert mean.body == (p.Return(half),)
