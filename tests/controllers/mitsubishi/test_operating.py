"""A CR controller looked at and operated: state, signals, variables, programs."""

import contextlib
import datetime
import itertools

import pytest

from assistant.base.diagnostics import Refused
from assistant.base.rotations import angle_between
from assistant.controllers import Controller, connect
from assistant.virtual.cr import VirtualCr
from tests.controllers.mitsubishi.asked import COUNTING, codes, number, until
from tests.wire import Wire

ONCE = b"10 M1=5\r\n20 END\r\n"
ALONG = b"10 MOV P1\r\n20 MOV P2\r\n30 END\r\n" + b"".join(
    b"P%d=(+%d.00,+0.00,+400.00,+0.00,+180.00,+0.00)(6,0)\r\n" % (n, 100 + 50 * n) for n in (1, 2)
)


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
def test_signals_have_numbers(standing, name):
    for act in (standing.inputs, standing.outputs):
        with pytest.raises(Refused) as refused:
            act([name])
        assert codes(refused) == ["CN308"]
    with pytest.raises(Refused):
        standing.set_output(name, 1)


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
def test_parameters_that_are_none(standing, name, value):
    with pytest.raises(Refused) as refused:
        standing.set_parameter(name, value)
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
def test_values_are_no_statements(standing, name, value):
    with pytest.raises(Refused) as refused:
        standing.set_variable(name, value, "SEAM")
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
