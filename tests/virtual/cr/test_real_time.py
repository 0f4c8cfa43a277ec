"""A virtual CR controller whose program is started over the link and then led over UDP."""

import numpy as np
import pytest

from assistant.controllers import connect
from assistant.controllers.cyclic import Ended, Limits, Settings, Trajectory
from assistant.controllers.mitsubishi.external_control import CYCLES, Monitor, Mxt, program
from assistant.virtual.cr import VirtualCr

PATIENT = Settings(timeout=10.0, lapse=100, opening=10.0, softness=0.5)


@pytest.fixture
def virtual():
    made = VirtualCr("rv-4frl", language="melfa-basic-5", servo_time=0.0)
    made.state.parameters.write("MONMODE", "1", all_levels=True)
    with made:
        yield made


def started(controller):
    controller.write("FOLLOW", program("127.0.0.1").encode())
    controller.motors(True)
    controller.load("FOLLOW")
    controller.start()


def test_an_arm_is_led_while_its_monitor_tells(virtual):
    robot = virtual.state.robot
    goal = robot.home + 5.0
    limits = Limits(tuple(robot.speeds), tuple(10.0 * robot.speeds))
    mxt = Mxt(
        "127.0.0.1",
        port=virtual.mxt_port,
        cycle=CYCLES["CR750"],
        limits=limits,
        settings=PATIENT,
    )
    with connect(virtual.address) as controller:
        started(controller)
        with mxt, Monitor("127.0.0.1", ("joints",), port=virtual.monitor_port) as monitor:
            report = mxt.follow(Trajectory.of_joints([robot.home, goal], unit="deg"), end=True)
            columns = monitor.record(2)
        assert report.done == report.rows
        assert controller.position().joints == pytest.approx(tuple(goal), abs=0.02)
    assert set(columns) >= {"joints_J1", "joints_J6"}
    assert np.isfinite(columns["joints_J1"]).all()


@pytest.mark.slow
def test_a_stop_from_the_panel_ends_the_client(virtual):
    robot = virtual.state.robot
    far = Trajectory.of_joints([robot.home, robot.home + 60.0], unit="deg")
    mxt = Mxt(
        "127.0.0.1",
        port=virtual.mxt_port,
        limits=Limits(tuple(0.2 * robot.speeds)),
        settings=Settings(timeout=0.6, opening=10.0),
    )
    with connect(virtual.address) as controller:
        started(controller)
        with mxt, pytest.raises(Ended) as ended:
            mxt.follow(far, watch=lambda now: virtual.emergency_stop())
        assert [one.code for one in ended.value.findings] == ["CN712"]
        there = controller.position().joints
    assert there != pytest.approx(tuple(far.rows[-1]), abs=1.0)
