"""The comparison of the learned map with its rivals, in little."""

from __future__ import annotations

from assistant.learning.experiments import three_joints
from assistant.learning.map_training import draw_test_goals
from benchmarks.learning import rows


def test_all_three_are_measured_at_each_number_of_steps() -> None:
    made = three_joints()
    found = list(rows(made, draw_test_goals(made.arm, made.space), (160, 320)))
    assert [(name.split(",")[0], count) for name, count, *_ in found] == [
        ("learned map", 160),
        ("learned map", 320),
        ("calibrated pair", 500),
        ("nearest pictures", 320),
        ("nearest pictures", 640),
    ]
    for _, _, rate, clear, noisy in found:
        assert rate > 0.0
        assert clear.mm < noisy.mm + 2.0
    assert found[2][3].worst_mm < 1e-6
