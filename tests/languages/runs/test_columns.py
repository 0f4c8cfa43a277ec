"""Runs: compared, cut, joined, and merged into the text that they were read from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from assistant.base.arrays import Floats, Ints
from assistant.languages.runs.columns import (
    Entries,
    Names,
    Run,
    Store,
    gather_runs,
    joined_runs,
    rows_of,
)
from assistant.languages.texts.line_text import merged_run_text


@dataclass(frozen=True, slots=True, eq=False)
class Rows(Run):
    """stem: of all rows. steps: (n,). names: (n,). values: (n, 2). how: (n,). at: of the whole."""

    stem: str
    steps: Ints
    names: Names
    values: Floats
    how: Entries[str]
    at: int | None = field(default=None, compare=False)


def rows(count: int, first: int = 1) -> Rows:
    steps = np.arange(first, first + count)
    values = np.column_stack([steps, steps % 3]).astype(np.float64)
    how = Entries(("fast", "slow"), (steps % 2).astype(np.int32))
    return Rows("P", steps, Names.numbered(b"p", steps), values, how, at=first)


def text(run: Rows) -> str:
    named = zip(run.steps.tolist(), run.values.tolist(), strict=True)
    lines = (
        f"{step} {run.names.name(row)} {x:g} {y:g} {run.how[row]}\n"
        for row, (step, (x, y)) in enumerate(named)
    )
    return "".join(lines)


def test_runs_are_equal_by_what_their_rows_say() -> None:
    run = rows(5)
    table = Entries(("slow", "fast"), (1 - run.how.index).astype(np.int32))
    assert replace(run, stem="p", how=table, at=None) == run
    assert hash(replace(run, at=None)) == hash(run)
    for other in (
        rows(4),
        replace(run, stem="Q"),
        replace(run, steps=run.steps + 1),
        replace(run, values=run.values + 1),
        replace(
            run, how=run.how.rows(run.steps - 1)[::-1] if False else table.rows(np.zeros(5, int))
        ),
    ):
        assert other != run


def test_parts_of_a_run_joined_are_the_run() -> None:
    run = rows(9)
    parts = [run.rows(slice(2)), run.rows(np.arange(2, 5)), run.rows(run.steps > 5)]
    assert [len(part) for part in parts] == [2, 3, 4]
    assert joined_runs(parts) == run
    assert {part.at for part in parts} == {None}


def test_rows_of_a_store_are_joined_where_they_stand() -> None:
    store = Store(6, 2)
    for start in (0, 3):
        store.take(3)[:] = rows(3, start + 1).values
    values = store.take(0).base
    assert values is not None
    parts = [replace(rows(3, n), values=values[n - 1 : n + 2]) for n in (1, 4)]
    whole = joined_runs(parts)
    assert whole == rows(6)
    assert np.shares_memory(whole.values, values)
    turned = joined_runs(parts[::-1])
    assert turned.values[:, 0].tolist() == [4, 5, 6, 1, 2, 3]


def test_rows_are_equal_to_those_of_another_run() -> None:
    run, at = rows(5), np.array([0, 1, -1, 3, 3])
    assert run.equal(at, run).tolist() == [True, True, False, True, False]
    moved = replace(run, steps=run.steps * 10)
    assert not run.equal(np.arange(5), moved).any()
    assert run.equal(np.arange(5), moved, {"steps"}).all()


def test_neighbours_of_one_kind_become_one() -> None:
    items: list[Rows | str] = ["x", rows(2), rows(2, 3), "y", rows(1), "z", rows(4)]
    alike = [None if isinstance(item, str) else (item.stem, item) for item in items]
    flat = list(gather_runs(items, alike, joined_runs, lambda _, run: run, 3))
    assert flat == ["x", rows(4), "y", rows(1), "z", rows(4)]
    assert flat[-1] is items[-1]


def test_lines_that_say_the_same_keep_their_bytes() -> None:
    old = rows(6)
    odd = text(old).replace(" ", "   ")
    at = np.arange(6)
    assert merged_run_text(old, old, odd, at, text) == odd
    values = old.values.copy()
    values[2] = 8, 9
    lines = odd.splitlines(keepends=True)
    changed = merged_run_text(replace(old, values=values), old, odd, at, text)
    assert changed == "".join([*lines[:2], "3 p3 8 9 slow\n", *lines[3:]])


def test_a_line_with_another_number_keeps_what_stands_behind_it() -> None:
    old = rows(4)
    odd = text(old).replace(" ", "   ")
    new = replace(old, steps=np.array([1, 20, 3, 400]))
    made = merged_run_text(new, old, odd, np.arange(4), text, "steps").splitlines()
    assert [line.split()[0] for line in made] == ["1", "20", "3", "400"]
    assert [line.lstrip("0123456789") for line in made] == [
        line.lstrip("0123456789") for line in odd.splitlines()
    ]


def test_rows_that_went_and_came() -> None:
    old, new = rows(5), joined_runs([rows(2, 2), rows(2, 8)])
    loud = text(old).upper()
    made = merged_run_text(new, old, loud, rows_of(old.steps, new.steps), text)
    assert made == "".join(loud.splitlines(keepends=True)[1:3]) + text(rows(2, 8))
