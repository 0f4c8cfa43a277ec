"""The loop against a virtual controller: what arrives there, and what is made of every fault."""

from dataclasses import replace

import numpy as np
import pytest

from assistant.controllers.cyclic import Settings, Trajectory
from assistant.controllers.cyclic.loop import Stop
from tests.controllers.mitsubishi.mxt.controllers import (
    ARM,
    CYCLE,
    FAULTY,
    PATIENT,
    controller,
    joints,
    led,
)


def steps(track):
    """Speeds of the commands that arrived, as parts of the joints' speeds."""
    rows = np.array([ARM.home, *track])
    return np.abs(np.diff(rows, axis=0)) / CYCLE / ARM.speeds


def test_joints_arrive_as_they_were_given():
    trajectory = joints()
    with controller() as control:
        done = led(control, trajectory)
    assert (done.code, control.result.reason) == ("", "end")
    assert control.result.track[-1] == pytest.approx(trajectory.rows[-1], abs=1e-4)
    assert steps(control.result.track).max() <= 1.0
    lead = [sample for sample in done.samples if sample[1] < 0]
    assert lead, "no soft start"


def test_poses_arrive_as_they_were_given():
    place, turn = ARM.fk(ARM.home[None])
    positions = place + np.array([[1, 0, 0], [6, 10, 3], [1, 0, 0]])
    trajectory = Trajectory.of_poses(positions, np.repeat(turn, 3, axis=0))
    with controller(0) as control:
        done = led(control, trajectory, mode="pose", flags=(7, 0))
    assert (done.code, control.result.reason) == ("", "end")
    assert ARM.fk(np.array(control.result.track[-1])[None])[0][0] == pytest.approx(
        positions[-1], abs=1e-3
    )


def test_pulses_arrive_as_they_were_given():
    away = 100.0 * (ARM.home + np.array([[0.0], [2.0], [0.0]]))
    with controller(2) as control:
        done = led(
            control,
            Trajectory.of_joints(away, unit="deg"),
            mode="pulse",
            settings=replace(PATIENT, slack=500, approach=500),
        )
    assert (done.code, control.result.reason) == ("", "end")
    assert max(row[0] for row in control.result.track) == pytest.approx(ARM.home[0] + 2.0)


@pytest.mark.parametrize(
    ("faults", "counted"),
    [
        ({9: "lost"}, "asked_again"),
        ({9: "twice"}, "repeated"),
        ({9: "garbled"}, "garbled"),
        ({9: "late", 12: "late"}, None),
        ({1: "lost"}, None),
        ({8: "lost", 9: "lost", 10: "late", 11: "garbled", 12: "twice"}, "asked_again"),
    ],
)
def test_a_fault_of_the_line_is_got_over(faults, counted):
    trajectory = joints()
    with controller(faults=faults) as control:
        done = led(control, trajectory, settings=FAULTY)
    assert (done.code, control.result.reason) == ("", "end")
    assert control.result.track[-1] == pytest.approx(trajectory.rows[-1], abs=1e-4)
    assert steps(control.result.track).max() <= 1.0
    assert counted is None or getattr(done, counted) >= 1


STARVED = Settings(timeout=0.3, lapse=100, softness=0.5)
"""Silence that is longer than a busy machine stops for."""


@pytest.mark.parametrize("fault", ["silent", "stop"])
def test_a_controller_that_says_no_more_ends_it(fault):
    with controller(faults={60: fault}) as control:
        done = led(control, joints(), settings=STARVED)
    assert done.code == "CN712"
    assert 0 < done.done < done.fields["rows"]
    assert len(control.result.track) == 58  # two asked where the arm is


def test_a_controller_that_only_talks_nonsense_ends_it():
    with controller(faults=dict.fromkeys(range(20, 2000), "garbled")) as control:
        done = led(control, joints(), settings=Settings(timeout=10.0, garbled=3, lapse=1))
    assert done.code == "CN717"
    assert control.result.reason == "end"


def test_a_controller_that_never_answers():
    with controller(faults={1: "silent"}) as control:
        done = led(control, joints(), settings=Settings(timeout=0.05))
    assert done.code == "CN711"
    assert "nothing came" in done.fields["reason"]
    assert control.result.track == []


def test_an_arm_that_does_not_follow_is_held_and_the_control_ended():
    with controller(servo=0.0) as control:
        done = led(control, joints(), settings=replace(PATIENT, lag=0.0, slack=2.0))
    assert done.code == "CN714"
    assert done.fields["distance"] > 2.0
    assert control.result.reason == "end"
    assert steps(control.result.track)[-3:].max() < 1e-3


def test_a_first_point_that_is_too_far_moves_nothing():
    far = Trajectory.of_joints([ARM.home + 30.0], unit="deg")
    with controller() as control:
        done = led(control, far)
    assert done.code == "CN703"
    assert control.result.track == []


def test_a_stop_brings_the_arm_to_rest_on_its_way():
    stop = Stop()

    def tell(*_):
        stop.asked = True

    with controller() as control:
        done = led(
            control,
            Trajectory.of_joints([ARM.home, ARM.home + 45.0], unit="deg"),
            stop=stop,
            tell=tell,
        )
    assert done.code == "CN715"
    assert control.result.reason == "end"
    moved = steps(control.result.track)
    assert moved.max() <= 1.0
    assert moved[-3:].max() < 1e-3  # the arm stands
    rises = np.abs(np.diff(moved * ARM.speeds, axis=0)) / CYCLE
    assert (rises / (ARM.speeds * 20.0)).max() < 1.6
    share = (np.array(control.result.track) - ARM.home) / 45.0
    assert np.ptp(share, axis=1).max() < 1e-3  # all the way on the line between the points
    assert share[-1, 0] < 0.95


def test_signals_go_both_ways():
    with controller() as control:
        control._signals.inputs[904] = True
        done = led(control, joints(), first=900, mask=0x00FF, word=0x0081, signals=2)
        outputs = control._signals.outputs
    assert done.code == ""
    assert [number for number, on in outputs.items() if on] == [900, 907]
    assert {sample[-1] for sample in done.samples[1:]} == {0x0010}


def test_packets_of_the_oldest_controllers():
    with controller(short=True) as control:
        done = led(control, joints(), short=True, watched="command")
    assert (done.code, control.result.reason) == ("", "end")


def test_a_filter_delays_what_the_arm_does():
    with controller(filter_ms=40.0) as control:
        done = led(control, joints(), watched="filtered")
    assert (done.code, control.result.reason) == ("", "end")
    behind = max(abs(sample[2] - sample[8]) for sample in done.samples)
    assert behind > 0.5
    assert PATIENT.lag * ARM.speeds[0] > behind
