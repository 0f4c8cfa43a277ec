"""The speed beside a plain loop: a task that is too slow twice fails the run by its name."""

from __future__ import annotations

import pytest

from benchmarks import ratios
from benchmarks.emission import python_rapid

KINDS = ("slow", "quick")


@pytest.fixture(autouse=True)
def _few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ratios, "POINTS", 500)


def test_a_task_that_is_too_slow_is_measured_again_and_fails_by_its_name(monkeypatch, capsys):
    slow = ratios.Task(lambda: ratios.poses(5_000), python_rapid, 0.5)
    quick = ratios.Task(lambda: None, lambda given: None, 0.5)
    monkeypatch.setattr(ratios, "TASKS", {"slow one": slow, "quick one": quick})
    monkeypatch.setattr(ratios, "STARTS", {"slow start": 20.0, "quick start": 20.0})
    monkeypatch.setattr(ratios, "starts", {"slow start": 20.1, "quick start": 10.0}.get)
    with pytest.raises(SystemExit, match=r": slow one, slow start$"):
        ratios.main()
    shown = capsys.readouterr().out
    assert [shown.count(f"{kind} {what}") for what in ("one", "start") for kind in KINDS] == [
        *(2, 1, 2, 1)
    ]


def test_a_command_takes_several_starts_of_python():
    assert 1.0 < ratios.starts("--help") < 100.0
