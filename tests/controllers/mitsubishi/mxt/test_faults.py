"""Faults at every packet of a conversation, and many at once."""

import random

import numpy as np
import pytest

from assistant.controllers.cyclic import Settings
from tests.controllers.mitsubishi.mxt.controllers import ARM, CYCLE, controller, joints, led

SHORT = Settings(timeout=0.04, lapse=4, softness=0.5)
ENDS = {"CN711", "CN712", "CN717"}


def speeds(track):
    rows = np.array([ARM.home, *track])
    return np.abs(np.diff(rows, axis=0)) / CYCLE / ARM.speeds


@pytest.mark.slow
def test_a_controller_falls_silent_at_any_packet():
    with controller() as control:
        assert led(control, joints()).code == ""
    silences = range(1, control.result.replies - 1)
    assert len(silences) > 100
    for number in silences:
        with controller(faults={number: "silent"}) as control:
            done = led(control, joints(), settings=SHORT)
        assert done.code in ENDS, (number, done.code)
        assert done.code == "CN711" or number > 1


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_packets_are_lost_doubled_garbled_and_late_at_random(seed):
    draw = random.Random(seed)
    share = draw.choice([0.02, 0.1, 0.3])
    faults = {
        number: draw.choice(["lost", "twice", "garbled", "late"])
        for number in range(1, 5000)
        if draw.random() < share
    }
    trajectory = joints()
    with controller(faults=faults) as control:
        done = led(control, trajectory, settings=Settings(timeout=2.0, lapse=4, softness=0.5))
    assert done.code == ""
    assert control.result.number == 0
    assert control.result.track[-1] == pytest.approx(trajectory.rows[-1], abs=1e-4)
    assert speeds(control.result.track).max() <= 1.0
