"""How often a procedure is read: once for all settings at its calls that it says the same with."""

from __future__ import annotations

import pytest

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, Pose, Tool
from assistant.program.motion import FINE, Speed
from assistant.program.program import Procedure, Program, Variable

from .lifting import lifted
from .programs import differences, target
from .test_translation import DIALECTS, there_and_back


def called_twice(body: tuple[p.Statement, ...], second: p.Motion) -> Program:
    """A procedure that is called behind a joint move, and again behind another motion."""
    first = p.Motion(Speed(100.0, joint=10.0), FINE, FLANGE, BASE)
    home = e.Name("home")
    main = (
        *(p.Move("joint", home, first), p.Call("part")),
        *(p.Move("joint", home, second), p.Call("part")),
    )
    return Program(
        "job",
        (Procedure("main", main), Procedure("part", body)),
        tools={"torch": Tool(Pose((0.0, 0.0, 120.0)))},
        targets={"home": target(3)},
        variables={"place": Variable("position")},
    )


@pytest.mark.parametrize("name", DIALECTS)
def test_an_arc_from_where_the_robot_stands_is_at_no_percentage(name: str) -> None:
    motion = p.Motion(Speed(50.0), FINE, FLANGE, BASE)
    arc = p.MoveCircular(e.TargetValue(target(4)), e.Name("home"), motion)
    faster = p.Motion(Speed(100.0, joint=20.0), FINE, FLANGE, BASE)
    adapted, back, _ = there_and_back(called_twice((arc,), faster), name)
    assert differences(back, adapted) == []


@pytest.mark.parametrize("name", DIALECTS)
def test_a_position_is_read_by_the_same_words_with_any_tool(name: str) -> None:
    read = p.Assign(e.Name("place"), e.Here("tool0", "base"))
    torch = p.Motion(Speed(100.0, joint=10.0), FINE, "torch", BASE)
    adapted, back, _ = there_and_back(called_twice((read,), torch), name)
    assert differences(back, adapted) == []


def names(program: Program) -> list[str]:
    return [procedure.name for procedure in program.procedures]


def calls(program: Program) -> list[str]:
    return [node.procedure for node in program.statements() if isinstance(node, p.Call)]


@pytest.mark.parametrize("value", ["Slow(1)+Go(1)", "Go(Slow(1))", "Slow(Go(1))"])
def test_a_function_that_sets_the_speed_may_run_before_another_one_in_the_line(value: str) -> None:
    program = lifted(
        f"Spd 100\nM1={value}\nEnd\n"
        "Function M Slow(ByVal MX)\nSpd 50\nSlow=1\nFEnd\n"
        "Function M Go(ByVal MX)\nMvs P1\nGo=1\nFEnd\n"
    )
    kept = [node.text for node in program.statements() if isinstance(node, p.Opaque)]
    assert kept == ["Spd 100", "Spd 50", "Mvs P1"]


PART = "*PART\nMvs P1 WthIf M_In(3)=1,M_Out(3)=1\nReturn\n"


def test_forms_that_stay_the_same_text_are_one() -> None:
    program = lifted("Spd 9\nGoSub *PART\nSpd 5\nGoSub *OUTER\nEnd\n*OUTER\nGoSub *PART\nReturn\n"
                     + PART)  # fmt: skip
    assert names(program) == ["main", "OUTER", "PART"]
    assert calls(program) == ["PART", "OUTER", "PART"]


def test_what_a_text_does_not_depend_on_is_no_text() -> None:
    program = lifted("JOvrd 5\nSpd 9\nMvs P1 WthIf M_In(3)=1,M_Out(3)=1\nMov P2+(0,0,1)\nEnd\n")
    kept = [node.text for node in program.statements() if isinstance(node, p.Opaque)]
    assert kept == ["Spd 9", "Mvs P1 WthIf M_In(3)=1,M_Out(3)=1"]


def test_a_second_form_has_a_name_of_its_own() -> None:
    program = lifted(
        "Spd 9\nGoSub *PART\nSpd 5\nGoSub *PART\nGoSub *PART_2\nEnd\n"
        "*PART\nMvs P1\nReturn\n*PART_2\nM1=1\nReturn\n"
    )
    assert names(program) == ["main", "PART", "PART_2_2", "PART_2"]
    assert calls(program) == ["PART", "PART_2_2", "PART_2"]


def test_a_subroutine_is_not_named_like_a_program_that_is_called() -> None:
    program = lifted('GoSub *PART\nCallP "PART"\nEnd\n*PART\nM1=1\nReturn\n')
    assert names(program) == ["main", "PART_2"]
    inner, other = (node for node in program.statements() if isinstance(node, p.Call))
    assert (inner.procedure, inner.unit) == ("PART_2", None)
    assert (other.procedure, other.unit) == ("PART", "PART")


@pytest.mark.parametrize("call", ['CallP "PART"', "GoSub *A\nIf M1=1 Then\n*A\nEndIf"])
def test_a_tool_stays_set_in_front_of_a_call_that_may_leave_it(call: str) -> None:
    positions = "PT=(0,0,120,0,0,0)(0,0)\nP1=(500,0,400,180,0,180)(7,0)\n"
    body = lifted(f"Tool PT\n{call}\nMov P1\nEnd\n{positions}").procedures[0].body
    assert [one.text for one in body if isinstance(one, p.Opaque)][:1] == ["Tool PT"]


@pytest.mark.parametrize("between", ["Dly 1", "Dly 1\nGoTo *SUB1\n*OTHER\nReturn"])
def test_a_tool_stays_set_for_lines_that_are_come_to_in_unknown_ways(between: str) -> None:
    way = "Def Act 1,M_In(8)=1 GoTo *SUB1\nAct 1=1"
    positions = "PT=(0,0,120,0,0,0)(0,0)\nP1=(500,0,400,180,0,180)(7,0)\n"
    program = lifted(
        f"Tool PT\nGoSub *SUB0\n{way}\nGoTo *LAST\n"
        f"*SUB0\n{between}\n*SUB1\nMov P1\nReturn\n*LAST\nEnd\n{positions}"
    )
    assert "Tool PT" in [one.text for one in program.statements() if isinstance(one, p.Opaque)]


LINES_THAT_DIFFER = "Tool P_NTool\nBase P_NBase\nCnt 0\nSpd 100\n"


def test_a_text_that_calls_a_subroutine_calls_it_as_its_settings_are() -> None:
    program = lifted(
        "Spd 250\nGoTo *MAIN\n*PART\nMvs P1\nReturn\n*MAIN\n"
        f"GoSub *PART\n{LINES_THAT_DIFFER}On M1 GoSub *ODD,*PART\n"
        "If M_In(9)=1 Then\n*ODD\nM1=2\nEndIf\nEnd\n"
    )
    assert names(program) == ["main", "PART"]
    (move,) = program.procedures[1].body
    assert isinstance(move, p.Opaque)


def test_a_text_that_calls_a_function_calls_it_as_its_settings_are() -> None:
    program = lifted(
        f"Function Main\nSpd 250\nM1=Go(1)\n{LINES_THAT_DIFFER}"
        "Mvs P2 WthIf Go(1)>0,M_Out(1)=1\nFEnd\n"
        "Function M Go(ByVal M0)\nMvs P1\nGo=1\nFEnd\n"
    )
    assert names(program) == ["main", "Go"]


def test_a_tool_stays_that_lines_set_which_a_call_leads_into_from_outside() -> None:
    positions = "PT=(0,0,120,0,0,0)(0,0)\nP1=(500,0,400,180,0,180)(7,0)\n"
    program = lifted(
        "GoSub *ODD\nMov P1\nIf M_In(9)=1 Then\n*ODD\nTool PT\nReturn\nEndIf\nEnd\n" + positions
    )
    assert "Tool PT" in [one.text for one in program.statements() if isinstance(one, p.Opaque)]
