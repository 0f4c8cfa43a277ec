"""The benchmark of models in real time, in little."""

from __future__ import annotations

import pytest

from benchmarks.models import LOOPS, STEP, measured


@pytest.mark.slow
@pytest.mark.parametrize("loop", LOOPS)
def test_a_loop_leads_the_arm_and_is_measured(loop: str) -> None:
    row = measured(loop, 1.0, load=False)
    assert len(row.lateness) == int(1.0 / STEP) + 1
    assert (row.lateness >= 0.0).all()
    assert len(row.answers) > 50 and (row.answers > 0.0).all()
