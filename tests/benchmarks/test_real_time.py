"""The benchmark of real-time control, in little."""

from __future__ import annotations

import pytest

from benchmarks.real_time import LOOPS, measured

CYCLE = 0.002


@pytest.mark.slow
@pytest.mark.parametrize("loop", LOOPS)
def test_a_loop_answers_and_is_measured(loop: str) -> None:
    row = measured(loop, CYCLE, 1.6, load=loop == "cyclic")
    assert int(row["cycles"]) > 100
    assert 0.0 < float(row["median"]) <= float(row["most_of"]) <= float(row["longest"])
    assert 0 <= int(row["late"]) <= int(row["cycles"])
