"""What whoever runs a program gives it: commands, functions and status variables, by name."""

from __future__ import annotations

import pytest

from assistant.virtual.events import Switched
from assistant.virtual.melfa import Given
from assistant.virtual.melfa.values import Failed, Position, Value
from tests.virtual.melfa_cell import outputs, run, shown


def test_a_function_gives_a_value() -> None:
    given: list[tuple[Value | None, ...]] = []

    def dot(call: Given) -> float:
        given.append(call.arguments)
        return 12.5

    done = run("P9=P1\nP9.Z=Dot(P1,P2,3)*2\nMvs P9\nEnd", commands={"Dot": dot})
    assert done.ended == "end" and shown(done) == [(400, 0, 25)]
    ((first, second, number),) = given
    assert isinstance(first, Position) and first.values[:3] == (400, 0, 500)
    assert isinstance(second, Position) and second.values[:3] == (450, 50, 500) and number == 3


@pytest.mark.parametrize("name", ["Rnd", "rnd", "RND"])
def test_names_in_any_case(name: str) -> None:
    done = run("If Rnd(0)>0.2 Then M_Out(1)=1\nEnd", commands={name: lambda _: 0.5})
    assert outputs(done) == [("1", 1)]


def test_a_function_of_a_text_may_be_named_with_its_mark() -> None:
    text = 'If StrUpr("ab")="X" Then M_Out(1)=1\nEnd'
    assert outputs(run(text, commands={"StrUpr$": lambda _: "X"})) == [("1", 1)]


def test_a_status_variable() -> None:
    done = run(
        "If M_Uar And &B10 Then M_Out(1)=1\nM_Out(2)=M_LdFact(3)-70\nEnd",
        commands={"M_Uar": lambda _: 2, "M_LdFact": lambda call: 68 + int(str(call.arguments[0]))},
    )
    assert outputs(done) == [("1", 1), ("2", 1)]


def test_setting_a_status_variable() -> None:
    given: list[tuple[Value | None, ...]] = []
    commands = {"P_FsGn0=": lambda call: given.append(call.arguments)}
    done = run("P_FsGn0=P1\nM_XDev(3)=1+1\nEnd", commands=commands)
    assert done.ended == "unknown" and "M_XDev" in done.message
    ((gains,),) = given
    assert isinstance(gains, Position) and gains.values[0] == 400
    done = run("M_YDev(3)=1+1\nEnd", commands={"m_ydev=": lambda x: given.append(x.arguments)})
    assert done.ended == "end" and given[-1] == (3, 2)


def test_a_command_acts_on_the_world() -> None:
    def track(call: Given) -> None:
        call.task.switch("trk", float(call.arguments == ("On",)))
        call.task.delay(0.5)

    done = run("Trk On\nMvs P1\nTrk Off\nEnd", commands={"Trk": track})
    assert outputs(done) == [("trk", 1), ("trk", 0)]
    assert done.seconds == pytest.approx(1.0, abs=0.01)


def test_a_command_of_two_words_has_the_rest_as_its_arguments() -> None:
    given: list[tuple[str, tuple[Value | None, ...]]] = []
    done = run(
        "Fsc On,0,,1\nFsc Off\nEnd",
        commands={
            "Fsc On": lambda call: given.append((call.name, call.arguments)),
            "fsc  off": lambda call: given.append((call.name, call.arguments)),
        },
    )
    assert done.ended == "end" and given == [("FSC ON", (0, None, 1)), ("FSC OFF", ())]


def test_a_motion() -> None:
    def arch(call: Given) -> None:
        assert isinstance(call.arguments[0], Position)
        call.task.tell(Switched("arch", call.arguments[0].values[2] or 0.0))

    done = run("Mva P1,1\nEnd", commands={"Mva": arch})
    assert outputs(done) == [("arch", 500)]


def test_a_call_of_a_name_that_the_language_lacks() -> None:
    done = run("Lamp(1,2)\nEnd", 6, commands={"Lamp": lambda call: call.task.switch("lamp", 1.0)})
    assert outputs(done) == [("lamp", 1)]


def test_it_stands_before_what_is_simulated() -> None:
    assert outputs(run("M_Out(1)=Abs(0)\nEnd", commands={"Abs": lambda _: 1})) == [("1", 1)]


def test_it_may_raise_an_error_of_the_controller() -> None:
    def refused(_: Given) -> float:
        raise Failed(7820, "no data came")

    done = run("M1=Rnd(0)\nEnd", commands={"Rnd": refused})
    assert done.ended == "error" and done.message.startswith("error 7820")


def test_a_function_without_a_value_ends_the_run() -> None:
    done = run("M1=Rnd(0)\nEnd", commands={"Rnd": lambda _: None})
    assert done.ended == "unknown" and "Rnd" in done.message
