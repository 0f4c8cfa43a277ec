"""Whole tasks pass: a few here, 200 as a slow test, more by `python -m tests.fuzz.tasks`."""

from __future__ import annotations

import pytest

from tests.fuzz.tasks.drawing import drawn
from tests.fuzz.tasks.passing import passes

TASKS = 200


def test_the_same_seed_gives_the_same_task() -> None:
    assert drawn("task 1").files == drawn("task 1").files
    assert drawn("task 1").files != drawn("task 2").files


@pytest.mark.parametrize("number", range(3))
def test_a_task_passes(number: int) -> None:
    assert sum(passes(f"task {number}", seconds=0.5).totals.values()) > 20


@pytest.mark.slow
def test_many_tasks_pass() -> None:
    done = [passes(f"task {number}", seconds=1.0) for number in range(TASKS)]
    assert sum(one.whole for one in done) > TASKS / 2
