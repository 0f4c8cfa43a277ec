"""The arm of a CR controller moved by hand: how far, within which limits, and stopped."""

import os
import signal
import threading

import pytest

from assistant.base.diagnostics import Refused
from assistant.base.rotations import angle_between
from assistant.controllers import connect
from assistant.controllers.mitsubishi.arm_moves import Goal
from assistant.controllers.rules import Lost
from assistant.controllers.states import Jog
from assistant.virtual.cr import VirtualCr
from tests.controllers.cutting import Cutting
from tests.controllers.mitsubishi.asked import COUNTING, codes, number, until


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
        *(Jog("J1", 1, speed=1e-9), Jog("J1", 1, speed=float("nan")), Jog("J1", 1e-9)),
        Jog("X", 5, "Tool"),  # which is not what it is called, and not the base
    ],
)
def test_jogs_that_are_none(standing, jog):
    standing.motors(True)
    with pytest.raises(Refused) as refused:
        standing.jog(jog)
    assert codes(refused) == ["CN308"]
    assert standing.position().joints == (0.0, 0.0, 90.0, None, 90.0, 0.0)


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
            client.jog(Jog("J1", 90, speed=1))
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
            moving.jog(Jog("J1", 90, speed=1))
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
