"""The debugger as an editor meets it: a process that speaks the protocol."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path as FilePath

import pytest

from assistant.compiler import translate
from tests.forks import Forks
from tests.virtual.editor import Editor, editing

MODULE = """MODULE Cell
  PERS num total := 0;
  VAR robtarget here := [[500,0,600],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    VAR num i := 1;
    WHILE i <= 3 DO
      count i;
      i := i + 1;
    ENDWHILE
    SetDO lamp, 1;
    WaitDI ready, 1;
    TPWrite "done";
  ENDPROC
  PROC count(num by)
    total := total + by;
    TPWrite "counted";
  ENDPROC
ENDMODULE
"""
PROGRAM = """1 M1=1
2 GoSub *ADD
3 P1=(+500.00,+0.00,+400.00,+180.00,+0.00,+180.00)(7,0)
4 M_Out(3)=1
5 Wait M_In(5)=1
6 End
7 *ADD
8 M1=M1+4
9 Return
"""


Editing = Callable[[], AbstractContextManager[Editor]]
"""Starts a debugger's process with an editor."""


@pytest.fixture(scope="session")
def python(forks: Forks) -> str:
    """Python that has everything imported already."""
    return str(forks.folder / "python")


@pytest.fixture(scope="session")
def editor(python: str) -> Editing:
    return partial(editing, python)


@pytest.fixture
def module(tmp_path: FilePath) -> FilePath:
    path = tmp_path / "Cell.mod"
    path.write_text(MODULE)
    return path


@pytest.fixture
def program(tmp_path: FilePath) -> FilePath:
    path = tmp_path / "ADD.prg"
    path.write_text(PROGRAM)
    return path


def test_rapid_is_held_at_break_points_and_shows_calls_and_data(
    module: FilePath, editor: Editing
) -> None:
    with editor() as e:
        e.begin(module, (15,))
        stopped = e.event("stopped")
        assert (stopped["reason"], stopped["threadId"]) == ("breakpoint", 1)
        assert e.stack() == [("count", 15), ("main", 7)]
        assert e.data("Routine") == {"by": "1"}
        assert e.data("Task")["total"] == "0"
        e.ask("continue", threadId=1)
        e.event("stopped")
        assert e.data("Task")["total"] == "1"


def points(e: Editor, path: FilePath, *asked: dict[str, object]) -> list[tuple[bool, int]]:
    """Sets break points; which were verified, and where."""
    e.ask("initialize", adapterID="robot-assistant")
    e.ask("launch", program=str(path))
    e.event("initialized")
    answer = e.ask("setBreakpoints", source={"path": str(path)}, breakpoints=list(asked))
    e.ask("configurationDone")
    return [(one["verified"], one["line"]) for one in answer["breakpoints"]]


def test_break_points_move_to_the_next_statement_or_are_not_verified(
    module: FilePath, program: FilePath, tmp_path: FilePath, editor: Editing
) -> None:
    other = tmp_path / "Other.mod"
    other.write_text(MODULE)
    with editor() as e:
        asked = [{"line": line} for line in (1, 5, 9, 15, 17, 99)]
        found = points(e, module, *asked)
        assert found == [(True, 6), (True, 6), (True, 10), (True, 15), (False, 17), (False, 99)]
        told = e.ask("setBreakpoints", source={"path": str(other)}, breakpoints=[{"line": 6}])
        assert told["breakpoints"][0]["verified"] is False
        assert "does not contain" in told["breakpoints"][0]["message"]
        e.event("stopped")
        assert e.stack()[0] == ("main", 6)
    with editor() as e:
        assert points(e, program, {"line": 3}, {"line": 7}) == [(True, 3), (True, 8)]
        e.event("stopped")
        assert e.stack()[0] == ("GoSub", 8)
        e.ask("continue", threadId=1)
        e.event("stopped")
        assert e.stack()[0] == ("Main", 3)


def test_a_pseudo_program_is_held_where_a_statement_begins(
    tmp_path: FilePath, editor: Editing
) -> None:
    path = tmp_path / "two.pseudo"
    path.write_text("program Two\n\nprocedure main\n\n  wait 1 s\n  wait 2 s\nend\n")
    with editor() as e:
        assert points(e, path, {"line": 1}, {"line": 7}) == [(True, 5), (False, 7)]
        e.event("stopped")
        assert e.stack()[0][1] == 5


def stops(e: Editor, look: str) -> list[str]:
    """Values of an expression at each stop, until the program has ended."""
    found = []
    while True:
        while not any(one["event"] in ("stopped", "terminated") for one in e.events):
            e.events.append(e._next())
        if any(one["event"] == "terminated" for one in e.events):
            return found
        e.event("stopped")
        e.ask("stackTrace", threadId=1)
        found.append(e.ask("evaluate", expression=look)["result"])
        e.ask("continue", threadId=1)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("point", "stopped"),
    [
        ({"condition": "by > 1 AND total < 3"}, ["2"]),
        ({"condition": "NOT (by = 2)"}, ["1", "3"]),
        ({"condition": "total*2 = by AND by > 0 OR by MOD 3 = 0"}, ["2", "3"]),
        ({"hitCondition": "2"}, ["2"]),
        ({"hitCondition": ">= 2"}, ["2", "3"]),
        ({"hitCondition": "%2", "condition": "by <> 1"}, ["3"]),
        ({"condition": "nowhere = 1"}, ["1", "2", "3"]),
    ],
    ids=str,
)
def test_break_points_with_conditions_and_counts_hold_when_they_are_met(
    module: FilePath, point: dict[str, object], stopped: list[str], editor: Editing
) -> None:
    module.write_text(MODULE.replace("WaitDI ready, 1;", ""))
    with editor() as e:
        assert points(e, module, {"line": 15, **point}) == [(True, 15)]
        assert stops(e, "by") == stopped


def test_log_points_say_what_expressions_are_and_hold_nothing(
    module: FilePath, editor: Editing
) -> None:
    module.write_text(MODULE.replace("WaitDI ready, 1;", ""))
    log = {"line": 15, "logMessage": "by={by}, half {by/2}, {here.trans.x}, {gone}"}
    with editor() as e:
        assert points(e, module, log) == [(True, 15)]
        e.event("terminated")
        said = [m["body"] for m in e.events if m["event"] == "output"]
        logged = [one["output"] for one in said if one["category"] == "console"]
        assert logged[1] == "by=2, half 1, 500, <`gone` is no data that is known here>\n"
        assert len(logged) == 3


def test_melfa_conditions_see_variables_components_and_ports(
    program: FilePath, editor: Editing
) -> None:
    wrong = {"line": 5, "condition": "M1 >"}, {"line": 5, "hitCondition": "often"}
    with editor() as e:
        good = {"line": 5, "condition": "M1=5 and P1.Z>=400 and M_Out(3)=1"}
        assert points(e, program, good, *wrong) == [(True, 5), (False, 5), (False, 5)]
        e.event("stopped")
        assert e.stack()[0] == ("Main", 5)
        assert e.ask("evaluate", expression="M1*2+1")["result"] == "11"


def test_a_request_after_the_end_is_answered(module: FilePath) -> None:
    with editing(sys.executable) as e:
        e.begin(module, (15,))
        e.event("stopped")
        e.ask("terminate")
        e.event("terminated")
        e.ask("threads")
        e.ask("disconnect")
        assert e.process.wait(30) == 0


def test_steps_go_into_over_and_out_of_calls(module: FilePath, editor: Editing) -> None:
    with editor() as e:
        e.begin(module, stopOnEntry=True)
        assert e.event("stopped")["reason"] == "entry"
        assert e.stack() == [("main", 6)]
        for step, place in (
            ("next", ("main", 7)),
            ("next", ("main", 8)),
            ("stepIn", ("main", 6)),
            ("next", ("main", 7)),
            ("stepIn", ("count", 15)),
            ("stepOut", ("main", 8)),
        ):
            e.ask(step, threadId=1)
            assert e.event("stopped")["reason"] == "step"
            assert e.stack()[0] == place


def test_melfa_is_stepped_and_shows_subroutines_positions_and_signals(
    program: FilePath, editor: Editing
) -> None:
    with editor() as e:
        e.begin(program, (8,))
        e.event("stopped")
        assert e.stack() == [("GoSub", 8), ("Main", 2)]
        e.ask("stepOut", threadId=1)
        e.event("stopped")
        e.ask("next", threadId=1)
        e.event("stopped")
        assert e.data("Program")["M1"] == "5"
        assert e.data("Program")["P1"] == "(500,0,400,180,0,180,,,7,0)"
        found = e.ask("evaluate", expression="p1.z")
        assert found["result"] == "400"
        e.ask("next", threadId=1)
        e.event("stopped")
        assert e.data("Outputs")["3"] == "1"


def test_an_input_that_is_set_ends_a_wait(program: FilePath, editor: Editing) -> None:
    with editor() as e:
        e.begin(program, (5,))
        e.event("stopped")
        frame = e.ask("stackTrace", threadId=1)["stackFrames"][0]["id"]
        scopes = e.ask("scopes", frameId=frame)["scopes"]
        (inputs,) = (s["variablesReference"] for s in scopes if s["name"] == "Inputs")
        e.ask("setVariable", variablesReference=inputs, name="5", value="1")
        e.ask("continue", threadId=1)
        assert e.event("exited")["exitCode"] == 0
        e.event("terminated")


CELL = """[data.nPause]
type = "num"
value = 0.25
[signals.diReady]
kind = "digital"
direction = "input"
number = 4
[signals.doGrip]
kind = "digital"
direction = "output"
number = 5
"""
PART = """MODULE Part
  PROC main()
    WaitTime nPause;
    SetDO doGrip, 1;
    WaitDI diReady, 1;
    SetDO doGrip, 0;
  ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("translated", [False, True])
def test_signals_have_the_names_and_data_the_values_of_the_cell_file(
    tmp_path: FilePath, editor: Editing, translated: bool
) -> None:
    (tmp_path / "cell.toml").write_text(CELL)
    path = tmp_path / "Part.mod"
    path.write_text(PART)
    line = 5
    if translated:
        done = translate(path, to="melfa-basic-6", cell=tmp_path / "cell.toml")
        (path,) = done.write(tmp_path)
        texts = path.read_text("ascii").splitlines()
        line = 1 + next(at for at, text in enumerate(texts) if "Wait M_In(4)=1" in text)
    with editor() as e:
        e.begin(path, (line,))
        e.event("stopped")
        said = [m["body"]["output"] for m in e.events if m["event"] == "output"]
        assert any(text.startswith("0.25") and "doGrip" in text for text in said), said
        assert e.data("Outputs")["doGrip"] == "1"
        frame = e.ask("stackTrace", threadId=1)["stackFrames"][0]["id"]
        assert e.ask("evaluate", expression="dogrip", frameId=frame)["result"] == "1"
        scopes = e.ask("scopes", frameId=frame)["scopes"]
        (inputs,) = (s["variablesReference"] for s in scopes if s["name"] == "Inputs")
        e.ask("setVariable", variablesReference=inputs, name="diReady", value="1")
        assert e.data("Inputs")["diReady"] == "1"
        e.ask("continue", threadId=1)
        assert e.event("exited")["exitCode"] == 0


def test_a_wait_that_nothing_ends_is_told_and_ends_the_run(
    module: FilePath, editor: Editing
) -> None:
    with editor() as e:
        e.begin(module)
        assert e.event("exited")["exitCode"] == 1
        said = [m["body"]["output"] for m in e.events if m["event"] == "output"]
        assert sum("counted" in text for text in said) == 3
        assert "ready" in said[-1]


def test_a_program_that_never_ends_can_be_paused_and_left(
    tmp_path: FilePath, editor: Editing
) -> None:
    path = tmp_path / "L.prg"
    path.write_text("1 M1=0\n2 *LOOP\n3 M1=M1+1\n4 GoTo *LOOP\n")
    with editor() as e:
        e.begin(path, maxSteps=10**9)
        e.ask("pause", threadId=1)
        assert e.event("stopped")["reason"] == "pause"
        e.ask("disconnect")
        assert e.process.wait(30) == 0


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("launch", "said"),
    [
        ({"program": "/nowhere/X.mod"}, "/nowhere/X.mod"),
        ({"program": "{module}", "robot": "no-such-robot"}, "no-such-robot"),
        ({"program": 5}, "program"),
        ({"program": "{module}", "wrong": 1}, "wrong"),
    ],
)
def test_what_cannot_be_launched_is_refused_with_its_reason(
    launch: dict[str, object], said: str, module: FilePath, editor: Editing
) -> None:
    given = {k: str(module) if v == "{module}" else v for k, v in launch.items()}
    with editor() as e:
        e.ask("initialize", adapterID="robot-assistant")
        answer = e.answer("launch", **given)
        assert not answer["success"]
        assert said in answer["message"]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "sent",
    [
        b"Content-Length: x\r\n\r\n{}",
        b"Content-Length: 5\r\n\r\n{}",
        b"hello\r\n\r\n",
        b"Content-Length: 4\r\n\r\nabcd",
        b"Content-Length: 99999999999999\r\n\r\n",
        b"Content-Length: 2\r\n\r\n[]",
    ],
)
def test_what_is_no_message_ends_the_debugger_without_a_traceback(sent: bytes, python: str) -> None:
    command = [python, "-m", "assistant", "debug"]
    done = subprocess.run(command, input=sent, capture_output=True, timeout=60, check=False)
    assert done.returncode == 2
    assert b"Traceback" not in done.stderr
    assert done.stderr.strip()
    assert done.stdout == b""


@pytest.mark.skipif(sys.version_info < (3, 12), reason="the client needs Python 3.12")
def test_the_client_of_another_project_understands_what_is_said(
    module: FilePath, editor: Editing
) -> None:
    from dap import DAPClient

    with editor() as e:
        e.begin(module, (15,))
        e.event("stopped")
        e.stack()
        e.data("Task")
        e.ask("threads")
        e.ask("disconnect")
        e.process.wait(30)
    client = DAPClient(clientID="test", adapterID="robot-assistant")
    understood = list(client.recv(e.heard))
    assert len(understood) == e.heard.count(b"Content-Length: ")
    assert {message.type for message in understood} <= {"event", "response"}
