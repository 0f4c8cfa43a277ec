"""Branches and turns along paths, against every possibility tried one by one."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from assistant.robots.branches import choose
from assistant.robots.turns import FREE, turn


@st.composite
def branch_cases(draw):
    n = draw(st.integers(1, 7))
    allowed = np.array(
        draw(st.lists(st.lists(st.booleans(), min_size=n, max_size=n), min_size=3, max_size=3))
    )
    starts = np.flatnonzero([True, *draw(st.lists(st.booleans(), min_size=n - 1, max_size=n - 1))])
    return allowed, starts


@given(branch_cases())
def test_as_few_changes_of_branch_as_can_be(case) -> None:
    allowed, starts = case
    n = allowed.shape[1]
    result = choose(allowed, starts, np.zeros(3))
    solvable = allowed.any(axis=0)
    assert ((result.chosen >= 0) == solvable).all()
    rows = np.flatnonzero(solvable)
    assert allowed[result.chosen[rows], rows].all()

    chain = np.searchsorted(starts, np.arange(n), side="right")
    best = None
    for guess in itertools.product(range(3), repeat=len(rows)):
        if not all(allowed[b, row] for b, row in zip(guess, rows, strict=True)):
            continue
        changes = [
            chain[rows[i]] == chain[rows[i - 1]]
            for i in range(1, len(rows))
            if guess[i] != guess[i - 1]
        ]
        score = (sum(changes), len(changes))
        best = score if best is None else min(best, score)
    mine = np.diff(result.chosen[rows]) != 0
    if len(rows):
        assert (len(result.broken) == 0) == (best[0] == 0)
        if best[0] == 0:
            assert mine.sum() == best[1]


def test_of_equally_good_branches_the_cheapest() -> None:
    allowed = np.ones((3, 4), dtype=bool)
    assert choose(allowed, np.array([0]), np.array([2.0, 1.0, 3.0])).chosen.tolist() == [1] * 4


@st.composite
def turn_cases(draw):
    n = draw(st.integers(1, 8))
    wound = np.cumsum(draw(st.lists(st.floats(-170, 170), min_size=n, max_size=n)))
    angles = wound - 360.0 * np.round(wound / 360.0)
    missing = draw(st.lists(st.booleans(), min_size=n, max_size=n))
    angles[np.array(missing) & (np.arange(n) > 0)] = np.nan
    starts = np.flatnonzero([True, *draw(st.lists(st.booleans(), min_size=n - 1, max_size=n - 1))])
    limit = draw(st.sampled_from([170.0, 200.0, 270.0, 360.0, 400.0]))
    return angles, starts, (-limit, limit), draw(st.floats(-400, 400))


@given(turn_cases())
def test_turns_stay_in_the_limits_and_chains_unbroken(case) -> None:
    angles, starts, (low, high), near = case
    inside = (angles >= low) & (angles <= high)
    angles = np.where(inside, angles, np.nan)
    result = turn(angles, (low, high), starts, near)
    known = np.isfinite(angles)
    assert (np.isfinite(result.angles) == known).all()
    turned = result.angles[known]
    assert (turned >= low - 1e-5).all()
    assert (turned <= high + 1e-5).all()
    assert np.allclose((turned - angles[known] + 180.0) % 360.0, 180.0)

    # Every count of turns, tried one by one: is there one that keeps all chains whole?
    chain = np.searchsorted(starts, np.arange(len(angles)), side="right")
    whole = True
    for number in np.unique(chain):
        rows = np.flatnonzero((chain == number) & known)
        if not len(rows):
            continue
        unwound = np.rad2deg(np.unwrap(np.deg2rad(angles[rows])))
        shifts = [unwound + 360.0 * k for k in range(-4, 5)]
        whole &= any((s >= low).all() and (s <= high).all() for s in shifts)
    jumps = np.abs(np.diff(turned)) > 180.0 + 1e-6
    rows = np.flatnonzero(known)
    within = chain[rows[1:]] == chain[rows[:-1]]
    if whole:
        assert not len(result.broken)
        assert not (jumps & within).any()


def test_a_stated_turn_holds_for_its_whole_chain() -> None:
    angles = np.array([170.0, -170.0, -150.0, 10.0])
    stated = np.full(4, FREE)
    stated[2] = 0
    starts = np.array([0, 3])
    result = turn(angles, (-360.0, 360.0), starts, 0.0, stated)
    assert result.angles.tolist() == [-190.0, -170.0, -150.0, 10.0]
    stated[2] = 1
    result = turn(angles, (-360.0, 360.0), starts, 0.0, stated)
    assert result.angles[:3].tolist() == [170.0, 190.0, 210.0]
