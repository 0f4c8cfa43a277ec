"""Several tasks, and signals in time, of RAPID programs whose arm takes its time."""

from __future__ import annotations

import pytest

from assistant import languages, robots
from assistant.virtual.events import Run, Said, Switched
from assistant.virtual.kernel.script import Answer, Change, Script
from assistant.virtual.kernel.timed_arm import Timed
from assistant.virtual.rapid import TaskProgram, run_tasks
from assistant.virtual.rapid.interpreter import STATEMENT_TIME

PLACES = """
CONST robtarget p10:=[[400,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget p20:=[[400,150,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
"""


def task(name: str, main: str, data: str = "", more: str = "", **given: object) -> TaskProgram:
    text = f"MODULE Cell\n{data}\nPROC main()\n{main}\nENDPROC\n{more}\nENDMODULE\n"
    file = languages.get("rapid").parse(text)
    assert not file.findings
    return TaskProgram(name=name, modules=[file], **given)  # type: ignore[arg-type]


def timed(*tasks: TaskProgram, **given: object) -> Run:
    robot = robots.get("irb1200-7-0.7")
    return run_tasks(tasks, robot=robot, motion=Timed(robot), **given)  # type: ignore[arg-type]


def changes(run: Run, signal: str) -> list[tuple[float, float]]:
    found = [row for row in run.log if isinstance(row.what, Switched) and row.what.signal == signal]
    return [(round(row.time, 4), row.what.value) for row in found if isinstance(row.what, Switched)]


def said(run: Run) -> list[tuple[float, str, str]]:
    found = [row for row in run.log if isinstance(row.what, Said)]
    return [
        (round(row.time, 4), row.task, row.what.text) for row in found if isinstance(row.what, Said)
    ]


def test_a_pulse_lasts_while_the_program_goes_on() -> None:
    main = "PulseDO\\High\\PLength:=0.5,do1;\nWaitTime 0.2;\nSet do2;\nWaitTime 1;"
    run = timed(task("T_ROB1", main))
    assert run.ended == "end"
    assert changes(run, "do1") == [(0.0, 1.0), (0.5, 0.0)]
    assert changes(run, "do2") == [(0.2, 1.0)]


def test_a_pulse_without_a_length_lasts_as_the_reference_says() -> None:
    run = timed(task("T_ROB1", "Set do1;\nPulseDO do1;\nWaitTime 1;"))
    assert changes(run, "do1") == [(0.0, 1.0), (0.0, 0.0), (0.2, 1.0)]


def test_a_new_pulse_takes_the_place_of_one_that_lasts() -> None:
    main = (
        "PulseDO\\High\\PLength:=1,do1;\nWaitTime 0.5;\nPulseDO\\High\\PLength:=1,do1;\nWaitTime 3;"
    )
    assert changes(timed(task("T_ROB1", main)), "do1") == [(0.0, 1.0), (0.5, 1.0), (1.5, 0.0)]


def test_a_signal_is_set_later() -> None:
    main = "SetDO\\SDelay:=0.3,do1,1;\nSetGO\\SDelay:=0.4,go1,5;\nSet do2;\nWaitTime 1;"
    run = timed(task("T_ROB1", main))
    assert changes(run, "do1") == [(0.3, 1.0)]
    assert changes(run, "go1") == [(0.4, 5.0)]
    assert changes(run, "do2") == [(0.0, 1.0)]


def test_an_interrupt_comes_in_the_midst_of_a_motion() -> None:
    main = """
MoveJ p10,v1000,fine,tool0;
CONNECT rising WITH told;
ISignalDI di1,1,rising;
Set doStart;
MoveL p20,v100,fine,tool0;
TPWrite "there";
"""
    trap = 'TRAP told\nTPWrite "trap";\nENDTRAP'
    program = task("T_ROB1", main, f"VAR intnum rising;{PLACES}", trap)
    script = Script(changes=(Change(name="di1", value=1.0, at=1.0),))
    run = timed(program, script=script)
    (start, _), *_ = changes(run, "dostart")
    assert run.ended == "end"
    assert [text for _, _, text in said(run)] == ["trap", "there"]
    (trapped, _, _), (arrived, _, _) = said(run)
    assert trapped == 1.0
    assert start < 1.0 < arrived
    assert arrived - start == pytest.approx(1.5, abs=0.2)


def test_a_motion_interrupts_at_a_place_on_its_way() -> None:
    main = """
MoveJ p10,v1000,fine,tool0;
CONNECT near WITH told;
TriggInt close,50,near;
FOR i FROM 1 TO 2 DO
TriggL p20,v100,close,fine,tool0;
TPWrite "there";
MoveL p10,v100,fine,tool0;
ENDFOR
IDelete near;
TriggL p20,v100,close,fine,tool0;
"""
    read = "here:=CPos(\\Tool:=tool0\\WObj:=wobj0);\nTPWrite ValToStr(Round(here.y));"
    trap = f"TRAP told\n{read}\nENDTRAP"
    data = f"VAR intnum near; VAR triggdata close; VAR pos here;{PLACES}"
    run = timed(task("T_ROB1", main, data, trap))
    assert run.ended == "end"
    assert [text for _, _, text in said(run)] == ["100", "there"] * 2
    (trapped, _, _), (arrived, _, _) = said(run)[:2]
    assert arrived - trapped == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("wait", ["WaitUntil\\InPos,TRUE;", "WaitTime\\InPos,0;"])
def test_a_wait_may_begin_when_the_arm_stands(wait: str) -> None:
    tell = "here:=CPos(\\Tool:=tool0\\WObj:=wobj0);\nTPWrite ValToStr(here);"
    main = f"MoveJ p10,v1000,fine,tool0;\nMoveL p20,v100,z50,tool0;\n{wait}\n{tell}"
    run = timed(task("T_ROB1", main, f"VAR pos here;{PLACES}"))
    assert [text for _, _, text in said(run)] == ["[400,150,500]"]


def test_tasks_meet_where_the_arm_stands() -> None:
    lists = 'PERS tasks both{2}:=[["T_ROB1"],["T_BACK"]];\nVAR syncident met;'
    main = "MoveJ p10,v1000,fine,tool0;\nMoveL p20,v100,z50,tool0;\nWaitSyncTask\\InPos,met,both;"
    back = 'WaitSyncTask met,both;\nTPWrite "met";'
    run = timed(task("T_ROB1", main, lists + PLACES), task("T_BACK", back, lists, moves=False))
    (met, who, _), *_ = said(run)
    assert (who, run.ended) == ("T_BACK", "end")
    assert met == pytest.approx(run.seconds, abs=1e-4)


def test_tasks_go_on_while_one_of_them_moves() -> None:
    moves = task("T_ROB1", "MoveJ p10,v1000,fine,tool0;\nMoveL p20,v100,fine,tool0;", PLACES)
    beside = task("T_BACK", "WaitTime 0.25;\nTPWrite ValToStr(TaskRunRob());", moves=False)
    run = timed(moves, beside)
    assert said(run) == [(0.25, "T_BACK", "FALSE")]
    assert run.ended == "end"


def test_a_background_task_sees_what_the_others_do() -> None:
    main = "Set doBusy;\nWaitTime 1;\nReset doBusy;\nWaitTime 1;"
    back = "WaitUntil doBusy=1;\nTPWrite CTime();\nWaitUntil doBusy=0;\nTPWrite CTime();"
    run = timed(task("T_ROB1", main), task("T_BACK", back, kind="static", moves=False))
    assert said(run) == [(0.0, "T_BACK", "00:00:00"), (1.0, "T_BACK", "00:00:01")]


def test_statements_take_the_time_that_a_run_says() -> None:
    loop = "FOR i FROM 1 TO 100 DO\nreg1:=reg1+i;\nENDFOR\nTPWrite ValToStr(reg1);"
    (at_once, *_), *_ = said(timed(task("T_ROB1", loop)))
    (later, *_), *_ = said(timed(task("T_ROB1", loop), statement_time=STATEMENT_TIME))
    assert at_once == 0.0
    assert later == pytest.approx(202 * STATEMENT_TIME)


def test_a_loop_that_looks_for_an_input_comes_to_see_it() -> None:
    main = 'WHILE diPart=0 DO\nENDWHILE\nTPWrite "seen";'
    back = "WHILE TRUE DO\nreg1:=reg1+1;\nENDWHILE"
    script = Script(changes=(Change(name="dipart", value=1.0, at=5.0),))
    run = run_tasks([task("T_ROB1", main), task("T_BACK", back, kind="static")], script=script)
    assert [(round(time, 1), text) for time, _, text in said(run)] == [(5.0, "seen")]
    assert run.ended == "end"


def test_a_script_answers_what_a_task_asks() -> None:
    ask = 'TPReadNum reg1,"How many?";\nTPWrite ValToStr(reg1);'
    script = Script(answers=(Answer(value="7", after=5.0),))
    run = timed(task("T_ROB1", ask), script=script)
    assert said(run) == [(0.0, "T_ROB1", "How many?"), (5.0, "T_ROB1", "7")]


def test_a_task_that_goes_wrong_ends_all() -> None:
    run = timed(task("T_ROB1", "WaitTime 10;"), task("T_BACK", "WaitTime 1;\nreg1:=1/0;"))
    assert (run.ended, run.task) == ("error", "T_BACK")
