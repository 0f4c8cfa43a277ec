"""Data link control mode through the controller link, against the virtual controller."""

from contextlib import contextmanager

import pytest

from assistant.base.diagnostics import Refused
from assistant.controllers import connect
from assistant.controllers.mitsubishi.control_mode import (
    PROGRAM_NAMES,
    ControlMode,
    Measuring,
    program_texts,
)
from assistant.controllers.mitsubishi.data_link import DataLink, Rate
from assistant.controllers.rules import Lost
from assistant.virtual.cr import VirtualCr
from tests.controllers.mitsubishi.test_control_mode import LIMITS, codes, points


@contextmanager
def cell(**settings):
    """The controller as the paper has it: positions over RS-232, the status over Ethernet."""
    with VirtualCr("rv-2aj", serial=True, framing="data link", servo_time=0.02) as virtual:
        host, port = virtual.data_ports["COM2:"]
        control = DataLink(virtual.serial_path, rate=Rate(9600, "none", 1), timeout=5)
        status = DataLink(f"{host}:{port}", timeout=5)
        with connect(virtual.address, timeout=5) as controller:
            yield (
                virtual,
                controller,
                ControlMode(controller, control, status, limits=LIMITS, **settings),
            )


@pytest.mark.slow
def test_programs_are_installed_started_followed_and_stopped():
    with cell() as (_, controller, mode):
        with mode:
            assert set(PROGRAM_NAMES) <= set(controller.names())
            mode.follow(points(0, 5, 10, 8))
        state = controller.state()
        assert not state.running and not state.faults and not state.right
        assert controller.position().joints[0] == pytest.approx(8, abs=0.01)
        assert mode.recording.column("J_CURR")[-1, 0] == pytest.approx(8, abs=0.01)


@pytest.mark.slow
def test_programs_that_are_there_are_not_written_again():
    with cell() as (_, controller, mode):
        with mode:
            mode.follow(points(5))
        before = {entry.name: entry.changed for entry in controller.entries()}
        with mode:
            mode.follow(points(6))
        assert {entry.name: entry.changed for entry in controller.entries()} == before
        assert mode.recording.column("J_CURR")[-1, 0] == pytest.approx(6, abs=0.01)


def test_an_emergency_stop_is_told_of_and_everything_is_stopped():
    with cell(silence=5.0) as (virtual, controller, mode):
        pressed = []

        def press(done, _count):
            if not pressed:
                pressed.append(done)
                mode._stream.silence = 0.4  # no record will come; before, a slow one may
                virtual.emergency_stop()

        with pytest.raises(Lost) as lost, mode:
            mode.follow(points(*range(0, 150, 5)), progress=press)
        assert codes(lost)[0] in ("CN625", "CN614") and "emergency stop" in str(lost.value)
        state = controller.state()
        assert not state.running and state.emergency
        assert controller.position().joints[0] < 145


SLOW = [pytest.param(wrong, marks=pytest.mark.slow) for wrong in ("other program", "running")]


@pytest.mark.parametrize("wrong", ["emergency", *SLOW])
def test_a_controller_that_is_not_ready_is_left_alone(wrong):
    with cell() as (virtual, controller, mode):
        match wrong:
            case "other program":
                controller.write("DATALINK", b"10 END\r\n")
            case "running":
                controller.write("LOOP", b"10 *L\r\n20 GOTO *L\r\n")
                controller.load("LOOP")
                controller.start()
            case "emergency":
                virtual.emergency_stop()
        with pytest.raises(Refused) as refused, mode:
            pass
        assert codes(refused) == ["CN626"]
        assert "MULTITASK" not in controller.names()
        if wrong == "running":
            assert controller.state().running
        if wrong == "other program":
            assert controller.read("DATALINK").splitlines() == [b"10 END"]
            mode._replace = True
            with mode:
                assert len(controller.read("DATALINK").splitlines()) > 20


def test_a_measurement_goes_on_by_itself_and_ends_with_its_client():
    with cell() as (virtual, controller, _):
        host, port = virtual.data_ports["COM2:"]
        for _ in range(2):
            with Measuring(controller, f"{host}:{port}", timeout=5) as measuring:
                assert controller.state().running
                assert measuring.status.feedback.values[2] == pytest.approx(90, abs=0.01)
            assert not controller.state().running
        assert controller.names() == ()


@pytest.mark.slow
def test_a_measurement_whose_client_says_nothing_more_ends():
    with cell() as (virtual, controller, _):
        host, port = virtual.data_ports["COM2:"]
        controller.write("MEASURE", program_texts(["MEASURE"])["MEASURE"])
        controller.load("MEASURE", task="2")
        controller.start("2")
        with DataLink(f"{host}:{port}", timeout=30) as link:
            link.send("2")
            while link.receive() != "END":
                """It tells where the arm is for 2 s."""
        assert not controller.state().running
