"""The loop over lines that spoil packets, and controllers that do not count theirs."""

import numpy as np
import pytest

from assistant.controllers.mitsubishi import external_control
from tests.controllers.mitsubishi.mxt.controllers import (
    ARM,
    CYCLE,
    FAULTY,
    controller,
    joints,
    led,
)
from tests.controllers.mitsubishi.mxt.relay import Bad, Early, through


def steps(track):
    rows = np.array([ARM.home, *track])
    return np.abs(np.diff(rows, axis=0)) / CYCLE / ARM.speeds


def test_packets_that_are_not_counted_are_all_answers():
    trajectory = joints()
    with controller(counts=False) as control:
        done = led(control, trajectory)
    assert (done.code, control.result.reason, done.repeated) == ("", "end", 0)
    assert control.result.track[-1] == pytest.approx(trajectory.rows[-1], abs=1e-4)


def test_an_answer_of_an_earlier_run_does_not_tell_where_the_arm_is():
    away = external_control.pack_data(2, np.radians(ARM.home + 3.0).tolist())
    late = external_control.pack_packet(
        {"send_type": 2, "recv_type": 2, "data": away, "c_count": 999}
    )
    with controller() as control, through(Early(control.port, late)) as line:
        done = led(line, joints())
    assert (done.code, control.result.reason) == ("", "end")
    assert control.result.track[0] == pytest.approx(list(ARM.home), abs=0.01)
    assert steps(control.result.track).max() <= 1.0


SEEDS = [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 30))]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("counts", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_packets_that_are_lost_doubled_swapped_and_of_others(seed, counts):
    """The arm never goes faster than its limits, two rows a cycle least of all."""
    trajectory = joints()
    with controller(counts=counts) as control, through(Bad(control.port, seed)) as line:
        done = led(line, trajectory, settings=FAULTY)
    assert done.code == ""
    assert control.result.track[-1] == pytest.approx(trajectory.rows[-1], abs=1e-4)
    assert steps(control.result.track).max() <= 1.0
