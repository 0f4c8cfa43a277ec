"""Step numbers of lines and of tables of lines, whatever the language."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from assistant.base.arrays import Ints
from assistant.languages.runs.columns import Run
from assistant.languages.step_numbers import (
    cut_at,
    first_step,
    places_of_steps,
    steps_in,
    steps_of,
    with_ascending_steps,
    with_steps,
)


@dataclass(frozen=True)
class Line:
    number: int | None = None


@dataclass(frozen=True)
class Note:
    text: str = ""


@dataclass(frozen=True, eq=False)
class Table(Run):
    steps: Ints


def table(*steps: int) -> Table:
    return Table(np.array(steps, dtype=np.int64))


ITEMS = [Line(10), Note(), table(20, 30, 40), Line()]


def test_what_steps_there_are() -> None:
    assert [steps_of(item).tolist() for item in ITEMS] == [[10], [], [20, 30, 40], []]
    assert [first_step(item) for item in ITEMS] == [10, None, 20, None]
    assert steps_in(ITEMS) == 5
    assert places_of_steps(ITEMS) == {10: 0, 20: 2, 30: 2, 40: 2}


@pytest.mark.parametrize(
    ("step", "last", "wanted"),
    [(10, 100, [[10], [], [20, 30, 40], [50]]), (10, 15, [[3], [], [6, 9, 12], [15]])],
)
def test_steps_ascend_and_fit(step: int, last: int, wanted: list[list[int]]) -> None:
    made = list(with_ascending_steps(ITEMS, step, last))
    assert [steps_of(item).tolist() for item in made] == wanted
    assert made[1] is ITEMS[1]


def test_an_item_that_has_its_steps_already_stays() -> None:
    for item in (Line(10), table(20, 30)):
        assert with_steps(item, steps_of(item)) is item
        assert steps_of(with_steps(item, steps_of(item) + 1)).tolist() != steps_of(item).tolist()


def test_a_table_is_cut_where_a_step_is_wanted() -> None:
    parts = list(cut_at(ITEMS, {30, 10, 99}))
    assert [steps_of(part).tolist() for part in parts] == [[10], [], [20], [30, 40], []]
