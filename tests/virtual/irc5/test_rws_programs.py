"""Programs of the virtual IRC5: started, held on the way, led and watched over RWS."""

from __future__ import annotations

import time

import pytest

from tests.virtual.irc5.programs import ended, module, ready, start
from tests.virtual.irc5.web import wait_for

FAR, NEAR = (f"[[{j1},0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]" for j1 in (40, 0))


def test_a_cycle_runs_and_the_log_tells_of_it(robot):
    ready(robot, "n := n + 1;", "SetDO do_lamp, 1;", data=("PERS num n := 1;",))
    assert start(robot).status == 204
    ended(robot)
    assert robot.value("T_ROB1/Work/n") == "2"
    assert robot.client.get("/rw/iosystem/signals/do_lamp").items()[0]["lvalue"] == "1"
    assert robot.codes() == [10011, 10002, 10151, 10125]
    assert start(robot).status == 204  # the pointer is at main again
    ended(robot)
    assert robot.value("T_ROB1/Work/n") == "3"


def test_a_start_needs_motors_and_a_pointer(robot):
    robot.take()
    robot.load("work.mod", module("WaitDI di_part, 1;"))
    refused = start(robot)
    assert refused.code == -1073442809 and "motoroff" in refused.text
    robot.motors()
    refused = start(robot)
    assert refused.code == -1073442809 and "pointer" in refused.text
    robot.execution("resetpp")
    assert start(robot).status == 204
    assert start(robot).code == -1073442809  # it runs already
    assert robot.state() == "running"


def test_the_arm_is_held_on_its_way_and_goes_on(robot):
    data = (f"CONST jointtarget far := {FAR};", "PERS num n := 0;")
    # So slow that it is on its way when a busy computer comes to the stop.
    ready(robot, "MoveAbsJ far, v10, fine, tool0;", "n := 1;", data=data)
    start(robot)
    wait_for(lambda: robot.joints()[0] > 1.0)
    assert robot.execution("stop", stopmode="stop").status == 204
    assert robot.state() == "stopped"
    held = robot.joints()
    assert 1.0 < held[0] < 39.0
    time.sleep(0.05)  # a second of the arm
    assert robot.joints() == held and robot.value("T_ROB1/Work/n") == "0"
    assert start(robot).status == 204
    ended(robot)
    assert robot.joints()[0] == pytest.approx(40.0)
    assert robot.value("T_ROB1/Work/n") == "1"


def test_a_new_pointer_leaves_the_way_of_the_arm(robot):
    data = (f"CONST jointtarget far := {FAR};", f"CONST jointtarget near := {NEAR};")
    first, second = "MoveAbsJ near, v5000, fine, tool0;", "MoveAbsJ far, v20, fine, tool0;"
    ready(robot, first, "WaitDI di_part, 1;", second, data=data)
    path = "/rw/iosystem/signals/di_part"
    robot.post(f"{path}?action=set", f"{path}/set-value", lvalue="1")
    start(robot)
    wait_for(lambda: robot.joints()[0] > 1.0)
    robot.execution("stop", stopmode="stop")
    held = robot.joints()[0]
    assert robot.execution("resetpp").status == 204
    assert robot.joints()[0] == pytest.approx(held)
    robot.post(f"{path}?action=set", f"{path}/set-value", lvalue="0")
    start(robot)
    wait_for(lambda: robot.joints()[0] == 0.0)  # from there to the first target


@pytest.mark.parametrize("value", ["1e300", "-3.5E38", "9" * 400])
def test_a_num_is_of_single_precision(robot, value):
    ready(robot, "n := n + 1;", data=("PERS num n := 7;", "PERS dnum d := 7;"))
    assert robot.set("T_ROB1/Work/n", value).status == 400
    assert robot.value("T_ROB1/Work/n") == "7"
    if value == "1e300":
        assert robot.set("T_ROB1/Work/d", value).status == 204
        assert robot.value("T_ROB1/Work/d") == "1E300"


def test_forever_goes_on_until_the_end_of_a_cycle_is_asked_for(robot):
    ready(robot, "n := n + 1;", "WaitTime 0.1;", data=("PERS num n := 0;",))
    start(robot, "forever")
    wait_for(lambda: float(robot.value("T_ROB1/Work/n")) > 3)
    robot.execution("stop", stopmode="cycle")
    ended(robot)
    count = robot.value("T_ROB1/Work/n")
    time.sleep(0.02)
    assert robot.value("T_ROB1/Work/n") == count


def test_a_loop_without_any_wait_still_lets_commands_through(robot):
    loop = ("WHILE TRUE DO", "n := n + 1;", "ENDWHILE")
    ready(robot, *loop, data=("VAR num n := 0;",))
    start(robot)
    wait_for(lambda: float(robot.value("T_ROB1/Work/n")) > 10)
    assert robot.execution("stop", stopmode="stop").status == 204
    count = robot.value("T_ROB1/Work/n")
    assert robot.value("T_ROB1/Work/n") == count


def test_variables_are_first_again_at_main_and_persistents_stay(robot):
    ready(robot, "v := v + 1;", "p := p + 1;", data=("VAR num v := 5;", "PERS num p := 5;"))
    for _ in range(2):
        start(robot)
        ended(robot)
    assert (robot.value("T_ROB1/Work/v"), robot.value("T_ROB1/Work/p")) == ("7", "7")
    robot.execution("resetpp")
    assert robot.value("T_ROB1/Work/p") == "7"
    start(robot)
    ended(robot)
    assert (robot.value("T_ROB1/Work/v"), robot.value("T_ROB1/Work/p")) == ("6", "8")


@pytest.mark.parametrize(
    ("body", "code", "words"),
    [
        ("n := 1 / (n - n);", 40228, "zero"),
        ("MoveL [[9000,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;",
         50050, "reach"),
        ("%\"nowhere\"%;", 40228, "nowhere"),
    ],
)  # fmt: skip
def test_an_error_is_an_event_and_stops_the_program_alone(robot, body, code, words):
    ready(robot, body, data=("VAR num n := 1;",))
    start(robot)
    ended(robot)
    assert robot.codes()[-2:] == [code, 10126]
    last = robot.client.get("/rw/elog/0?lang=en&order=fifo").items()
    text = next(row["desc"] for row in last if int(row["code"]) == code)
    assert words in text and "work.mod" in text
    assert start(robot).code == -1073442809  # the pointer is lost
    assert robot.execution("resetpp").status == 204


def test_an_error_stops_the_arm_where_it_is(robot):
    data = ("VAR num n := 1;", f"CONST jointtarget far := {FAR};")
    ready(robot, "MoveAbsJ far, v100, z200, tool0;", "n := 1 / (n - n);", data=data)
    start(robot)
    ended(robot)
    held = robot.joints()
    assert 0.0 < held[0] < 39.0
    time.sleep(0.05)  # a second of the arm
    assert robot.joints() == held


def test_a_program_may_be_led_by_egm(robot):
    data = (
        "VAR egmident id;",
        "CONST egm_minmax near := [-0.1,0.1];",
        f"CONST jointtarget at := {NEAR};",
    )
    axes = r"\J1:=near \J2:=near \J3:=near \J4:=near \J5:=near \J6:=near"
    body = (
        "MoveAbsJ at, v5000, fine, tool0;",
        "EGMReset id;",
        "EGMGetId id;",
        r'EGMSetupUC ROB_1, id, "default", "UCdevice:" \Joint \CommTimeout:=0.5;',
        rf"EGMActJoint id {axes};",
        r"EGMRunJoint id, EGM_STOP_HOLD \J1 \J2 \J3 \J4 \J5 \J6 \CondTime:=20;",
    )
    ready(robot, *body, data=data)
    start(robot)
    ended(robot)  # nobody leads
    assert robot.codes()[-2:] == [41822, 10126]


def test_the_program_waits_for_a_signal_that_is_set_here(robot):
    ready(robot, "WaitDI di_part, 1;", "SetDO do_lamp, 1;")
    start(robot)
    path = "/rw/iosystem/signals/di_part"
    assert robot.state() == "running"
    robot.post(f"{path}?action=set", f"{path}/set-value", lvalue="1")
    ended(robot)
    assert robot.client.get("/rw/iosystem/signals/do_lamp").items()[0]["lvalue"] == "1"


def test_the_pointer_tells_where_the_program_is(robot):
    path = "/rw/rapid/tasks/T_ROB1/pcp"
    assert robot.client.get(path).items() == []
    ready(robot, "WaitTime 0.01;", "inner;", data=())
    inner = "MODULE Inner\nPROC inner()\nWaitDI di_part, 1;\nENDPROC\nENDMODULE\n"
    robot.load("inner.mod", inner)
    robot.execution("resetpp")
    at = robot.client.get(path).items("pcp-info")[0]
    assert (at["modulemame"], at["routinename"], at["beginposition"]) == ("Work", "main", "3,1")
    start(robot)
    wait_for(lambda: robot.client.get(path).items()[0]["routinename"] == "inner")
    at = robot.client.get(path).items("pcp-info")[0]
    assert (at["modulemame"], at["beginposition"]) == ("Inner", "3,1")
    robot.execution("stop", stopmode="stop")
    form = {"routine": "inner", "module": "Inner"}
    moved = robot.post(f"{path}?action=set-pp-routine", f"{path}/routine", **form)
    assert moved.status == 204
    assert robot.client.get(path).items()[0]["routinename"] == "inner"


def test_an_instruction_may_stop_the_program_and_it_goes_on(robot):
    ready(robot, "n := 1;", "Stop;", "n := 2;", data=("PERS num n := 0;",))
    start(robot)
    ended(robot)
    assert robot.value("T_ROB1/Work/n") == "1"
    start(robot)
    ended(robot)
    assert robot.value("T_ROB1/Work/n") == "2"


def test_messages_of_the_program_are_events(robot):
    ready(robot, 'ErrWrite \\W, "Hot", "The torch is hot";')
    start(robot)
    ended(robot)
    row = next(
        row for row in robot.client.get("/rw/elog/8?lang=en").items() if row["code"] == "80002"
    )
    assert (row["msgtype"], row["title"], row["desc"]) == ("2", "Hot", "The torch is hot")
    number = row["_title"].rpartition("/")[2]
    alone = robot.client.get(f"/rw/elog/8/{number}?lang=en").items("elog-message")[0]
    assert [one["value"] for one in alone["argv"]] == ["Hot", "The torch is hot"]
    clear = robot.post("/rw/elog/8?action=clear", "/rw/elog/8/clear")
    assert clear.status == 204 and robot.client.get("/rw/elog/8").items() == []


def test_an_emergency_stop_holds_the_arm_until_the_motors_are_on_again(robot, fresh):
    ready(robot, "MoveAbsJ far, v20, fine, tool0;", data=(f"CONST jointtarget far := {FAR};",))
    start(robot)
    wait_for(lambda: robot.joints()[0] > 1.0)
    fresh.press_emergency_stop()
    assert robot.state() == "stopped"
    path = robot.either("/rw/panel/ctrlstate", "/rw/panel/ctrl-state")
    assert robot.client.get(path).items()[0]["ctrlstate"] == "emergencystop"
    assert robot.motors().code == -1073442809
    fresh.release_emergency_stop()
    assert robot.client.get(path).items()[0]["ctrlstate"] == "emergencystopreset"
    assert robot.motors().status == 204
    held = robot.joints()[0]
    assert start(robot).status == 204
    wait_for(lambda: robot.joints()[0] > held)
    assert 10013 in robot.codes()


def test_positions_of_tools_and_work_objects(robot):
    data = (
        "PERS tooldata long := [TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        'PERS wobjdata desk := [FALSE,TRUE,"",[[100,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
        f"CONST jointtarget near := {NEAR};",
    )
    ready(robot, "MoveAbsJ near, v5000, fine, tool0;", data=data)
    start(robot)
    ended(robot)
    path = "/rw/motionsystem/mechunits/ROB_1/robtarget"
    bare = robot.client.get(path).items("ms-robtargets")[0]
    # rapid.md, 4.5: tool0 of this arm at [0,0,0,0,30,0]
    assert [float(bare[axis]) for axis in "xyz"] == pytest.approx([422.014, 0, 750.1], abs=1e-3)
    assert [float(bare[f"q{i}"]) for i in range(1, 5)] == pytest.approx([0.5, 0, 0.8660254, 0])
    assert [bare[f"cf{i}"] for i in "146x"] == ["0", "0", "0", "0"]
    held = robot.client.get(f"{path}?tool=long&wobj=desk&coordinate=Wobj").items()[0]
    out = 422.014 + 100 * 0.8660254 - 100  # the tool points 30 degrees down
    assert float(held["x"]) == pytest.approx(out, abs=1e-3)
    assert robot.client.get(f"{path}?tool=none").status in (400, 404)
    plain = robot.client.get("/rw/motionsystem/mechunits/ROB_1/cartesian").items()[0]
    assert float(plain["z"]) == pytest.approx(750.1)
    assert plain[robot.either("jx", "cfx")] == "0"
