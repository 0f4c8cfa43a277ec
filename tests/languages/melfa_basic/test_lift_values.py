"""What values of programs of others mean: expressions, signals, positions, arrays of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from assistant import languages
from assistant.base import rotations
from assistant.base.source_text import SourceText
from assistant.compiler.read_back_proof import prove_read_back
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Tool
from assistant.program.motion import Speed
from assistant.program.program import Parameter, Signal
from tests.tables import every_row

from .lifting import AGAIN, body, lifted, moves, opaque


@pytest.mark.parametrize("level", [5, 6])
def test_the_percentages_of_the_start_are_known(level: int) -> None:
    (main,) = lifted("JOvrd 20\nJOvrd M_NJOvrd\nMov P1\nOvrd M_NOvrd\n", level).procedures
    move, override = main.body
    assert isinstance(move, p.Move) and isinstance(move.motion.speed, Speed)
    assert move.motion.speed.joint in (None, 100.0)
    assert override == p.SetOverride(e.Number(100))


def test_a_parameter_is_what_the_caller_gives_whatever_its_line_says() -> None:
    program = lifted("FPrm P1,M1\nMvs P1\nMvs P2\nMov P1,-50\n")
    (main,) = program.procedures
    assert main.parameters == (Parameter("P1", "position"), Parameter("M1", "number"))
    first, second, third = moves(main)
    assert (first.target, second.target) == (e.Name("P1"), e.Name("P2"))
    assert isinstance(third.target, e.Apply) and third.target.arguments[0] == e.Name("P1")
    assert "P1" not in {*program.targets, *program.variables}


def value(text: str) -> e.Expression:
    last = body(f"M1={text}\n")[-1]
    assert isinstance(last, p.Assign)
    return last.value


@every_row(
    ("text", "meant"),
    [
        ("Sin(Rad(30))", e.Apply("sin", (e.Number(30),))),
        ("Deg(J1.J2)", e.Member(e.Name("J1"), "j2")),
        ("Deg(Atn2(M2,M3))", e.Apply("atan2", (e.Name("M2"), e.Name("M3")))),
        ("P1.Z-5", e.Binary("-", e.Member(e.Name("P1"), "z"), e.Number(5))),
        ("Dist(P1,P2)", e.Apply("distance", (e.Name("P1"), e.Name("P2")))),
        ("M2 And 12", e.Apply("bitand", (e.Apply("round", (e.Name("M2"),)), e.Number(12)))),
        ("(M2>3)+1", e.Verbatim("melfa-basic-6", "(M2>3)+1")),
        ("Not M2", e.Verbatim("melfa-basic-6", "Not M2")),
    ],
)
def test_expressions(text: str, meant: e.Expression) -> None:
    assert value(text) == meant


def test_a_number_that_is_given_a_truth_is_one_or_zero() -> None:
    (given,) = body("M1=M2>3\n")
    larger = e.Binary(">", e.Name("M2"), e.Number(3))
    one, zero = (p.Assign(e.Name("M1"), e.Number(value)) for value in (1, 0))
    assert given == p.If((p.Branch(larger, (one,)),), (zero,))


def test_radians() -> None:
    assert value("J1.J2") == e.Binary("*", e.Member(e.Name("J1"), "j2"), e.Number(math.pi / 180.0))
    (turn,) = body("J1.J2=J1.J2+Rad(10)\n")
    joint = e.Member(e.Name("J1"), "j2")
    assert turn == p.Assign(joint, e.Binary("+", joint, e.Number(10)))


def test_a_shift_turned_about_several_axes_is_the_same_turn() -> None:
    (move,) = body("Mov P2*(1,2,-20,10,20,30)\n")
    assert isinstance(move, p.Move)
    assert isinstance(move.target, e.Apply)
    x, y, z, *turns = (n.value for n in move.target.arguments[1:] if isinstance(n, e.Number))
    assert (x, y, z) == (1.0, 2.0, -20.0)
    meant = rotations.from_euler(np.array([30.0, 20.0, 10.0]), "ZYX")
    assert rotations.angle_between(rotations.from_euler(np.array(turns), "XYZ"), meant) < 1e-6


def test_signals_by_constants_and_names() -> None:
    program = lifted(
        "MDONE=12\nDef Io glue=Bit,7\nM_Out(MDONE)=1 Dly 0.5\nglue=M_In(3)\n"
        "M_Out8(16)=M_In8(0) And &H0F\nWait M_In16(32)=5\n"
    )
    assert program.signals["glue"] == Signal("digital", "output", 7)
    assert program.signals["gi_4_0"] == Signal("group", "input", 0, 4)
    assert program.procedures[0].body[1:] == (
        p.SetSignal("do_12", e.Number(1), e.Number(0.5)),
        p.SetSignal("glue", e.Name("di_3")),
        p.SetSignal("go_8_16", e.Name("gi_4_0")),
        p.WaitSignal("gi_16_32", e.Number(5)),
    )


def test_bits_are_no_truths() -> None:
    (test,) = body("If M_In(1) And M_In(2)=0 Then Hlt\n")
    assert isinstance(test, p.If)
    one, two = e.Name("di_1"), e.Name("di_2")
    condition = e.Binary("and", e.Binary("=", one, e.Number(1)), e.Binary("=", two, e.Number(0)))
    assert test.branches[0].condition == condition
    (test,) = body("If M1 And M2 Then Hlt\n")
    assert isinstance(test, p.If)
    both = (e.Apply("round", (e.Name("M1"),)), e.Apply("round", (e.Name("M2"),)))
    assert test.branches[0].condition == e.Binary("<>", e.Apply("bitand", both), e.Number(0))


def test_a_name_with_c_is_a_text_only_where_something_says_so() -> None:
    program = lifted(
        'Count=3\nCount=Count+1\nCname$="a"\nDef Char Cone\nC_01$="b"\nCone="c"\nEnd\n'
    )
    assert {name: v.type for name, v in program.variables.items()} == {
        "Count": "number", "Cname": "text", "Cone": "text", "C_01": "text",
    }  # fmt: skip


def test_integers_are_rounded() -> None:
    assert body("Def Inte MN\nMN%=M2/3\n") == (
        p.Assign(e.Name("MN"), e.Apply("round", (e.Binary("/", e.Name("M2"), e.Number(3)),))),
    )


def test_positions_that_change_are_variables() -> None:
    program = lifted("P1.Z=P1.Z+5\nMov P1\nMov P2\n")
    assert "P1" not in program.targets
    assert program.variables["P1"].storage == "persistent"
    assert isinstance(program.variables["P1"].initial, e.TargetValue)
    assert "P2" in program.targets


def test_numbers_that_stand_behind_the_program_are_kept() -> None:
    program = lifted("M1=M1+1\nM3=4\nEnd\nM1=+2.50\nM2%=+7\nM3=+1\n")
    found = {name: (v.storage, v.initial) for name, v in program.variables.items()}
    assert found["M1"] == ("persistent", e.Number(2.5))
    assert "M2" not in found
    assert found["M3"] == ("persistent", e.Number(1))


def test_arrays() -> None:
    program = lifted("Dim PX(2)\nMov PX(M1)\nPX(1).X=3\n")
    assert program.variables["PX"].size == (2,)
    move, change = program.procedures[0].body
    assert isinstance(move, p.Move)
    assert isinstance(move.target, e.Index)
    assert change == p.Assign(e.Member(e.Index(e.Name("PX"), (e.Number(1),)), "x"), e.Number(3))


def test_programs_of_several_files_keep_their_own_positions() -> None:
    language = languages.get("melfa-basic-5")
    sub = SourceText("1 Mov P1\n2 M1=2\n" + AGAIN.replace("100", "900"), "SUB.prg")
    main = language.parse('1 CallP "SUB"\n2 Mov P1\n3 M1=1\n' + AGAIN)
    program = language.lift([main, language.parse(sub)])
    assert opaque(program) == []
    assert len(program.targets) == 2
    assert len(program.variables) == 2


@pytest.mark.parametrize(("word", "kind"), [("Tool", "tool"), ("Base", "frame")])
def test_programs_of_several_files_keep_their_own_tools_and_frames(word: str, kind: str) -> None:
    """What one file sets by the same name, or by numbers, is another tool in the next."""
    language = languages.get("melfa-basic-5")

    def text(size: int) -> str:
        given = (f"(0,0,{size},0,0,0)", "PT", "PS")
        lines = (line for one in given for line in (f"{word} {one}", "Mov P1"))
        numbered = [f"{at} {line}" for at, line in enumerate(lines, 2)]
        placed = f"PT=(0,0,{size + 1},0,0,0)(0,0)\nPS=(0,0,5,0,0,0)(0,0)\n"
        return "\n".join(('1 CallP "SUB"', *numbered, "")) + AGAIN + placed

    sub = SourceText(text(200).replace('CallP "SUB"', "Dly 1"), "SUB.prg")
    program = language.lift([language.parse(text(100)), language.parse(sub)])
    values = program.tools if kind == "tool" else program.frames
    used = [
        [getattr(node.motion, kind) for node in q.body if isinstance(node, p.Move)]
        for q in program.procedures
    ]
    assert used == [[f"{kind}_1", "PT", "PS"], [f"{kind}_2", "PT_2", "PS"]]
    heights = [
        abs((value.tip if isinstance(value, Tool) else value.user).position[2])
        for value in values.values()
    ]
    assert heights == [100, 101, 5, 200, 201]


def test_programs_of_several_files_have_functions_of_their_own() -> None:
    language = languages.get("melfa-basic-5")
    main = language.parse('1 Def FNMA(MX)=MX+1\n2 M1=FNMA(5)\n3 CallP "SUB"\n')
    sub = SourceText("1 Def FNMA(MX)=MX+2\n2 M1=FNMA(5)\n", "SUB.prg")
    program = language.lift([main, language.parse(sub)])
    assert opaque(program) == []
    made = {q.name: q.body for q in program.procedures}
    called = [node.value for node in program.statements() if isinstance(node, p.Assign)]
    sums = [made[x.function] for x in called if isinstance(x, e.Apply)]
    added = [e.Binary("+", e.Name("MX"), e.Number(number)) for number in (1, 2)]
    assert sums == [(p.Return(value),) for value in added]


def test_a_program_that_is_called_may_change_the_tool_by_its_number() -> None:
    language = languages.get("melfa-basic-5")
    sub = SourceText("1 M_Tool=2\n2 End\n", "SUB.prg")
    lines = '1 Tool (0,0,100,0,0,0)\n2 Mov P1\n3 CallP "SUB"\n4 Mov P1\n'
    program = language.lift([language.parse(lines + AGAIN), language.parse(sub)])
    assert opaque(program) == ["Tool (0,0,100,0,0,0)", "Mov P1", "M_Tool=2"]


def test_comments_keep_their_places() -> None:
    program = lifted(
        "If M1=1 Then 'a\nDly 1 'b\nElse 'c\nDly 2\nEndIf 'd\nFor M2=1 To 2 'e\nNext 'f\nEnd 'g\n"
    )
    texts = [node.text for node in program.statements() if isinstance(node, p.Comment)]
    assert texts == ["a", "b", "c", "d", "e", "f", "g"]


def test_a_wait_with_a_time_limit() -> None:
    text = (
        "M_Timer(1)=0\n*W1\nIf M_In(3)=1 Then *W1Z\nIf M_Timer(1)<2500 Then *W1\nError 9100\n*W1Z\n"
    )
    assert body(text) == (p.WaitSignal("di_3", e.Number(1), e.Number(2.5)),)


def test_it_means_what_the_rapid_program_means() -> None:
    rapid = languages.get("rapid")
    there = rapid.lift(
        rapid.parse(
            "MODULE job\nVAR num M1;\nPROC main()\nM1:=0;\nWHILE M1<3 DO\nM1:=M1+1;\n"
            "WaitTime 0.5;\nIF M1=2 THEN\nwork;\nELSE\nStop;\nENDIF\nENDWHILE\nENDPROC\n"
            "PROC work()\nM1:=Abs(M1);\nENDPROC\nENDMODULE\n"
        )
    )
    here = lifted(
        "M1=0\nWhile M1<3\nM1=M1+1\nDly 0.5\nIf M1=2 Then\nGoSub *work\nElse\nHlt\nEndIf\n"
        "WEnd\nEnd\n*work\nM1=Abs(M1)\nReturn\n",
        positions="",
    )
    assert here.procedures == there.procedures


@pytest.mark.parametrize("level", [4, 5, 6])
def test_a_branch_without_a_word_of_its_own_is_a_text_in_the_if(level: int) -> None:
    text = "10 If M1=1 Then Close Else M1=2\n20 If M1=3 Then Hlt Else Break\n30 End\n"
    language = languages.get(f"melfa-basic-{level}")
    first, second = language.lift(language.parse(text.upper())).procedures[0].body
    match first:
        case p.If((p.Branch(_, (p.Opaque(text=inside),)),), (p.Assign(),)):
            assert inside.upper() == "CLOSE"
        case _:
            pytest.fail(repr(first))
    assert isinstance(second, p.Opaque)  # `Break` of a block would leave another one


# ------------------------------------------------------------------- arrays of positions


SOME = "Dim PRow(3)\nPRow(1)=P1\nMov PRow(2)\nEnd\n"
TAUGHT = "P1=(100,0,300,180,0,180)(7,0)\nPRow(2)=(300,0,300,180,0,180)(7,0)\n"


def test_elements_that_were_never_taught_have_no_value() -> None:
    program = lifted(SOME, positions=TAUGHT)
    initial = program.variables["PRow"].initial
    assert isinstance(initial, e.Aggregate)
    first, second, third = initial.items
    assert (first, third) == (e.NEVER_GIVEN, e.NEVER_GIVEN)
    assert isinstance(second, e.TargetValue)
    assert not opaque(program)


@pytest.mark.parametrize("name", ["melfa-basic-4", "melfa-basic-5", "melfa-basic-6", "rapid"])
def test_what_was_never_taught_is_so_in_other_languages(name: str) -> None:
    language = languages.get(name)
    adapted = language.adapt(replace(lifted(SOME, positions=TAUGHT), origin=None))
    tree = language.build(adapted.program)
    files = {language.file_name(adapted.program, None): language.encode(tree)}
    assert prove_read_back(language, adapted.program, files).holds
    text = language.render(tree)
    if name == "rapid":  # no move takes an orientation of nothing
        unset = "[[0,0,0],[0,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
        assert text.count(unset) == 2 and f"PRow{{3}}:=[{unset}," in "".join(text.split())
    else:
        lines = text.upper()
        assert [lines.count(f"PROW({at})=") for at in (1, 2, 3)] == [1, 1, 0]
        assert "PROW(2)=(300" in lines


def test_joints_that_were_never_taught_are_kept() -> None:
    program = lifted("Dim JRow(2)\nMov JRow(1)\nEnd\n", positions="JRow(1)=(1,2,3,4,5,6)\n")
    assert opaque(program) == ["Dim JRow(2)", "Mov JRow(1)"]
