"""A CR controller looked at and operated: state, signals, variables, programs, motion."""

import contextlib
import datetime
import itertools
import os
import signal
import threading

import pytest

from assistant.controllers import Controller, connect, parse
from assistant.controllers.mitsubishi.cr import Cr
from assistant.controllers.mitsubishi.jogging import Goal
from assistant.controllers.rules import Lost
from assistant.controllers.states import Jog
from assistant.program.diagnostics import Refused
from assistant.program.rotations import angle_between
from assistant.virtual.cr import VirtualCr
from tests.controllers.cutting import Cutting
from tests.wire import Wire

COUNTING = b"10 M1=0\r\n20 *AGAIN\r\n30 M1=M1+1\r\n40 DLY 0.05\r\n50 GOTO *AGAIN\r\n"
ONCE = b"10 M1=5\r\n20 END\r\n"
ALONG = b"10 MOV P1\r\n20 MOV P2\r\n30 END\r\n" + b"".join(
    b"P%d=(+%d.00,+0.00,+400.00,+0.00,+180.00,+0.00)(6,0)\r\n" % (n, 100 + 50 * n) for n in (1, 2)
)


def codes(refused):
    return [finding.code for finding in refused.value.findings]


def number(refused):
    """The error number in a finding of the controller."""
    return int(refused.value.findings[0].message.split(" error ")[1][:4])


@pytest.fixture
def controller():
    with VirtualCr("rv-2aj", servo_time=0.02) as controller:
        yield controller


@pytest.fixture
def client(controller):
    with Cr(parse(controller.address), timeout=5, pace=0.01) as client:
        yield client


def until(done, seconds=5.0):
    """Waits for something that the controller does in its own time."""
    pause = threading.Event()
    for _ in range(int(seconds / 0.02)):
        if done():
            return
        pause.wait(0.02)
    raise AssertionError("it did not happen")


# -------------------------------------------------------------------------------- looking


def test_it_is_a_controller(client):
    assert isinstance(client, Controller)
    told = client.identify()
    assert (told.robot, told.controller) == ("RV-2AJ", "CR1")


def test_the_state_of_a_controller_at_rest(client):
    client.write("SEAM", ONCE)
    client.load("SEAM", "2")
    state = client.state()
    assert (state.mode, state.motors, state.running, state.right) == ("automatic", *[False] * 3)
    assert [(task.name, task.program, task.line) for task in state.tasks] == [("2", "SEAM", 10)]
    assert state.faults == () and not state.emergency


def test_an_error_has_its_number_its_words_and_a_place_in_the_log(controller, client):
    controller.alarm(4140, 2)
    controller.alarm(2800, 2)
    (fault,) = client.state().faults
    assert (fault.number, fault.level) == (2800, "error") and "reached" in fault.text
    assert [entry.number for entry in client.log()] == [2800, 4140]
    assert [entry.number for entry in client.log(1)] == [2800]
    assert isinstance(client.log()[0].time, datetime.datetime)
    client.reset()
    assert client.state().faults == ()


def test_where_an_arm_of_five_axes_is(client):
    place = client.position()
    assert place.joints == (0.0, 0.0, 90.0, None, 90.0, 0.0)
    assert place.text == "(160.00,0.00,478.00,0.00,180.00,0.00)(6,0)"
    assert place.quaternion == pytest.approx((0, 0, 1, 0))


def test_where_an_arm_of_six_axes_is():
    with VirtualCr("rv-4frl", pace=20) as controller, connect(controller.address) as client:
        place = client.position()
        robot = controller.state.robot
        shown = [angle for angle in place.joints if angle is not None]
        positions, quaternions = robot.fk([shown])
        assert place.position == pytest.approx(tuple(positions[0]), abs=0.01)
        assert angle_between([place.quaternion], quaternions)[0] < 0.02


def test_looking_again_and_again_needs_no_right(controller, client):
    with Wire(controller.port) as other:
        assert other.ask("1;1;CNTLON") == "QoK"
        samples = list(itertools.islice(client.watch(0.01, ["5", "out:900"]), 3))
        assert [set(sample.signals) for sample in samples] == [{"5", "out:900"}] * 3
        assert samples[0].seconds < samples[1].seconds < samples[2].seconds
        with pytest.raises(Refused) as refused:
            client.set_override(10)
        assert number(refused) == 6020
    with pytest.raises(Refused) as refused:
        next(client.watch(0.01, ["M1"]))
    assert codes(refused) == ["CN308"]


# -------------------------------------------------------------------------------- signals


def test_outputs_one_by_one(client):
    client.set_output("10", 1)
    client.set_output("12", 1)
    assert client.outputs(["10", "11", "12", "27"]) == {"10": 1, "11": 0, "12": 1, "27": 0}
    client.set_output("10", 0)
    assert client.outputs(["10", "12"]) == {"10": 0, "12": 1}


def test_inputs(controller, client):
    controller.state.board.inputs.set("5", 1.0)
    controller.state.board.inputs.set("900", 1.0)
    assert client.inputs(["900", "5", "6"]) == {"900": 1, "5": 1, "6": 0}


@pytest.mark.parametrize("name", ["", "x", "-1", "40000", "5\r1;1;SRVON", "5;6", "٥"])
def test_signals_have_numbers(client, name):
    for act in (client.inputs, client.outputs):
        with pytest.raises(Refused) as refused:
            act([name])
        assert codes(refused) == ["CN308"]
    with pytest.raises(Refused):
        client.set_output(name, 1)


def test_hands(client):
    client.hand(1, open=False)
    client.hand(1, open=True)
    for wrong in (0, 8, 9):
        with pytest.raises(Refused) as refused:
            client.hand(wrong, open=True)
        assert codes(refused) == ["CN308"]


# ----------------------------------------------------------------- parameters and variables


def test_parameters_are_read_and_written(client):
    assert client.parameters() == {}
    client.set_parameter("MEXTL", "0, 0, 12.5, 0, 0, 0")
    assert client.parameters() == {"MEXTL": "0, 0, 12.5, 0, 0, 0"}
    assert client.parameters(["TASKMAX"]) == {"TASKMAX": "8"}
    with pytest.raises(Refused) as refused:
        client.parameters(["NONSENSE"])
    assert number(refused) == 7080


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("mextl", "1"),
        ("A;B", "1"),
        ("MEXTL", "1;2"),
        ("MEXTL", "1\r2"),
        ("MEXTL", "0" * 300),
        ("MEXTL", "€"),
    ],
)
def test_parameters_that_are_none(client, name, value):
    with pytest.raises(Refused) as refused:
        client.set_parameter(name, value)
    assert codes(refused) == ["CN308"]


def test_kinds_of_parameters_come_from_a_file(client, tmp_path):
    file = tmp_path / "RV-2AJ#1.PRM"
    file.write_bytes(
        b"RV-2AJNARC parameter system V1.0;\r\nMEXTL=Uf,0,0,150,%r0,%r-0,%r0;\r\n"
        b'TASKMAX=Ud,8;\r\nNETIP=Us,"192.168.0.20";\r\n\x00'
    )
    client.learn_kinds([file])
    client.set_parameter("MEXTL", "0,0,10,0,0,0")
    for name, value in (("MEXTL", "0,0,10"), ("MEXTL", "0,0,ten,0,0,0"), ("TASKMAX", "8.5")):
        with pytest.raises(Refused) as refused:
            client.set_parameter(name, value)
        assert codes(refused) == ["CN308"]
    file.write_bytes(b"something else")
    for path in (file, tmp_path / "none.PRM"):
        with pytest.raises(Refused) as refused:
            client.learn_kinds([path])
        assert codes(refused) == ["CN312"]


def test_variables_of_programs_and_of_none(client):
    client.write("SEAM", ALONG)
    client.write("OTHER", ONCE)
    client.load("SEAM")
    client.set_variable("M5", "2.5")
    assert client.variable("M5") == "+2.5"
    assert client.variable("P1").startswith("(+150.00,+0.00,+400.00")
    client.set_variable("C1$", '"a;b"', "OTHER")
    assert client.variable("C1$", "OTHER") == '"a;b"'
    client.set_variable("M_05", "7")
    assert client.variable("M_05") == "+7"
    with pytest.raises(Refused) as refused:
        client.variable("M77")
    assert number(refused) == 4340


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("C1$", '"' + "x" * 250 + '"'),
        ("C1$", '"€"'),
        ("M1", "M2"),
        ("M1", "1\r"),
        ("M1;SRVON", "1"),
        ("", "1"),
        ("M_01", "1:SERVO ON"),
        ("M1", ""),
    ],
)
def test_values_are_no_statements(client, name, value):
    with pytest.raises(Refused) as refused:
        client.set_variable(name, value, "SEAM")
    assert codes(refused) == ["CN308"]


# -------------------------------------------------------------------------------- programs


def test_programs_as_files(client):
    client.write("SEAM", ONCE)
    client.copy("SEAM", "COPY")
    client.rename("COPY", "MOVED")
    assert client.names() == ("MOVED", "SEAM")
    client.protect("SEAM", lines=True)
    plain, protected = client.entries()
    assert plain.attributes != protected.attributes and protected.size
    with pytest.raises(Refused):
        client.write("SEAM", b"10 END\r\n")
    client.protect("SEAM", lines=False)
    client.write("SEAM", b"10 END\r\n")
    for act, old, new in ((client.copy, "NONE", "X"), (client.rename, "SEAM", "MOVED")):
        with pytest.raises(Refused):
            act(old, new)
    assert client.read("MOVED") == ONCE


def test_a_program_is_loaded_started_and_stopped(client):
    client.write("COUNT", COUNTING)
    client.load("COUNT")
    client.start(forever=True)
    until(lambda: float(client.variable("M1")) > 2)
    state = client.state()
    assert state.running and state.tasks[0].running and state.tasks[0].line in (20, 30, 40, 50)
    client.set_variable("M1", "1000")
    until(lambda: float(client.variable("M1")) > 1001)
    with pytest.raises(Refused):
        client.load("COUNT")
    client.stop()
    assert not client.state().running
    client.load("COUNT")  # which resets what stands in the middle
    assert client.state().tasks[0].line == 10


def test_a_slot_without_a_program(client):
    with pytest.raises(Refused) as refused:
        client.start()
    assert number(refused) == 5100
    for task in ("9", "0", "x", "1;2"):
        with pytest.raises(Refused) as refused:
            client.start(task)
        assert codes(refused) == ["CN308"]


def test_a_program_that_fails_at_once(client):
    client.write("BAD", b"10 M1=M2+1\r\n20 END\r\n")
    client.load("BAD")
    with contextlib.suppress(Refused):  # the error may be there already
        client.start()
    until(lambda: client.state().faults)
    assert client.state().faults[0].number == 3700
    client.reset()


def test_single_statements(client):
    client.write("SEAM", ONCE)
    client.load("SEAM")
    client.execute("M_OUT(20)=1", wait=True)
    client.execute("M_07=3*4", wait=True)
    assert client.outputs(["20"]) == {"20": 1}
    assert client.variable("M_07") == "+12"
    for statement in ("", "M1=1\r1;1;SRVON", "M1=1\v", "M1=" + "1" * 300, 'C1$="€"'):
        with pytest.raises(Refused) as refused:
            client.execute(statement)
        assert codes(refused) == ["CN308"]
    with pytest.raises(Refused) as refused:
        client.execute("MOV ((")
    assert number(refused) == 4220


# ---------------------------------------------------------------------------------- motion


def test_servos(client):
    client.motors(True)
    assert client.state().motors
    client.motors(False)
    assert not client.state().motors


def test_the_override(client):
    client.set_override(25)
    assert client.state().override == 25
    for percent in (0, 101):
        with pytest.raises(Refused) as refused:
            client.set_override(percent)
        assert codes(refused) == ["CN308"]


def test_jogging_a_joint(client):
    client.motors(True)
    client.jog(Jog("J1", 5, speed=100))
    client.jog(Jog("j6", -3, speed=100))
    assert client.position().joints == (5.0, 0.0, 90.0, None, 90.0, -3.0)
    assert not client.state().right


def test_jogging_along_axes_of_base_and_tool(client):
    client.motors(True)
    client.jog(Jog("Z", -20, speed=100))
    assert client.position().position == pytest.approx((160, 0, 458), abs=0.1)
    client.jog(Jog("Z", 10, "tool", speed=100))  # the tool looks down
    client.jog(Jog("B", -5, speed=100))
    place = client.position()
    assert place.position == pytest.approx((160, 0, 448), abs=0.1)
    assert "175.0" in place.text
    with pytest.raises(Refused) as refused:
        client.jog(Jog("A", 5, "tool"))
    assert codes(refused) == ["CN209"]


def test_jogging_an_arm_of_six_axes():
    with VirtualCr("rv-4frl", pace=20) as controller, connect(controller.address) as client:
        client.motors(True)
        client.jog(Jog("J5", 20, speed=100))
        before = client.position()
        client.jog(Jog("X", 5, "tool", speed=100))
        client.jog(Jog("C", 4, "tool", speed=100))
        client.jog(Jog("A", -2, speed=100))
        now = client.position()
        assert sum((b - a) ** 2 for a, b in zip(before.position, now.position, strict=True)) == (
            pytest.approx(25, abs=0.5)
        )
        turned = angle_between([before.quaternion], [now.quaternion])[0]
        assert 2 < turned < 6.1


@pytest.mark.parametrize(
    "jog",
    [
        *(Jog("J9", 1), Jog("J4", 1), Jog("C", 1), Jog("X;", 1), Jog("J1", 0), Jog("J1", 500)),
        *(Jog("J1", float("nan")), Jog("J1", 1, speed=0), Jog("J1", 1, speed=101)),
        Jog("X", 5, "Tool"),  # which is not what it is called, and not the base
    ],
)
def test_jogs_that_are_none(client, jog):
    client.motors(True)
    with pytest.raises(Refused) as refused:
        client.jog(jog)
    assert codes(refused) == ["CN308"]
    assert client.position().joints == (0.0, 0.0, 90.0, None, 90.0, 0.0)


def test_nothing_moves_beyond_the_limits(client):
    client.motors(True)
    client.jog(Jog("J5", -10, speed=100))
    with pytest.raises(Refused) as refused:
        client.jog(Jog("J5", 50))
    assert codes(refused) == ["CN309"]
    goals = []

    def never(goal: Goal):
        goals.append(goal)
        raise Refused()

    client.check = never
    with pytest.raises(Refused):
        client.jog(Jog("J1", 1))
    assert goals[0].joints["J1"] == 1.0
    assert client.position().joints[0] == 0.0


def test_nothing_moves_with_servos_off_during_errors_or_programs(controller, client):
    def refused_with():
        with pytest.raises(Refused) as refused:
            client.jog(Jog("J1", 1))
        return number(refused)

    assert refused_with() == 2000
    client.motors(True)
    client.write("COUNT", COUNTING)
    client.load("COUNT")
    client.start(forever=True)
    assert refused_with() == 5640
    client.stop()
    controller.alarm(2800, 2)
    assert refused_with() == 2800


def test_a_goal_out_of_reach_is_an_error_of_the_controller(client):
    client.motors(True)
    with pytest.raises(Refused) as refused:
        client.jog(Jog("Z", 90))
    assert number(refused) in (2600, 2602, 2802)
    client.reset()
    assert not client.state().right


def test_a_jog_that_is_interrupted_stops_the_arm(controller, client):
    client.motors(True)
    with connect(controller.address) as other:

        def interrupt():
            until(lambda: other.position().joints[0] > 0.5)
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=interrupt)
        with pytest.raises(KeyboardInterrupt):
            thread.start()
            client.jog(Jog("J1", 90, speed=5))
        thread.join()
        first, second = (other.position().joints[0] for _ in range(2))
        assert 0.5 < first < 80 and first == second
        assert not other.state().right


def test_a_jog_whose_line_is_cut_stops_the_arm(controller, client):
    client.motors(True)
    with Cutting(controller.port) as proxy:

        def cut_on_the_way():
            until(lambda: client.position().joints[0] > 0.5)
            proxy.cut_now()

        cutter = threading.Thread(target=cut_on_the_way)
        address = f"melfa://127.0.0.1:{proxy.port}"
        with pytest.raises(Lost) as lost, connect(address, timeout=5) as moving:
            cutter.start()
            moving.jog(Jog("J1", 90, speed=5))
        cutter.join()
    assert "the arm may have moved" in lost.value.findings[0].message
    assert 0.5 < client.position().joints[0] < 80
    assert not client.state().right


def test_stopping_needs_no_session():
    with VirtualCr("rv-2aj") as controller:
        with connect(controller.address, timeout=5) as client:
            client.write("COUNT", COUNTING)
            client.load("COUNT")
            client.start(forever=True)
        client.stop()
        with connect(controller.address, timeout=5) as client:
            assert not client.state().running
