"""The speed beside a plain loop: a task that is too slow twice fails the run by its name."""

from __future__ import annotations

import pytest

from benchmarks import ratios
from benchmarks.emission import python_rapid


@pytest.fixture(autouse=True)
def _few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ratios, "POINTS", 500)


def test_a_task_that_is_too_slow_is_measured_again_and_fails_by_its_name(monkeypatch, capsys):
    slow = ratios.Task(lambda: ratios.poses(5_000), python_rapid, 0.5)
    quick = ratios.Task(lambda: None, lambda given: None, 0.5)
    monkeypatch.setattr(ratios, "TASKS", {"slow one": slow, "quick one": quick})
    with pytest.raises(SystemExit, match=r": slow one$"):
        ratios.main()
    shown = capsys.readouterr().out
    assert (shown.count("slow one"), shown.count("quick one")) == (2, 1)
