"""Branches and turns along paths, against every possibility tried one by one."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.robots.motion.branch_sequence import (
    BRANCH_CHANGE_COST,
    BROKEN_CHAIN_COST,
    TURNS_NOT_STATED,
    BranchCosts,
    add_whole_turns,
    cheapest_branches,
    choose_branches,
)


def free(chains: int) -> BranchCosts:
    """Three branches that cost nothing."""
    return BranchCosts(np.zeros(3), np.zeros((3, chains)), lambda at: np.zeros((3, 3, len(at))))


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
    result = choose_branches(allowed, starts, lambda used: free(len(used)))
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
    costs = free(1)
    costs.chains[:, 0] = 2.0, 1.0, 3.0
    assert choose_branches(allowed, np.array([0]), lambda _: costs).chosen.tolist() == [1] * 4


def test_a_change_has_to_save_more_than_it_counts() -> None:
    allowed = np.ones((2, 3), dtype=bool)
    for saved, wanted in (
        (BRANCH_CHANGE_COST * 0.9, [0, 0, 0]),
        (BRANCH_CHANGE_COST * 1.1, [0, 1, 1]),
    ):
        chains = np.array([[0.0, saved / 2, saved / 2], [2 * BRANCH_CHANGE_COST, 0.0, 0.0]])
        costs = BranchCosts(np.zeros(2), chains, lambda at: np.zeros((2, 2, len(at))))
        assert (
            choose_branches(allowed, np.arange(3), lambda _, c=costs: c).chosen.tolist() == wanted
        )


@st.composite
def cost_cases(draw):
    """Few branches and chains, with costs of everything that can be chosen."""
    branches, chains = draw(st.integers(1, 4)), draw(st.integers(1, 6))
    seconds = st.floats(0, 3)
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    possible = rng.random((branches, chains)) < 0.7
    possible[rng.integers(0, branches, chains), np.arange(chains)] = True
    table = rng.uniform(0, 3, (branches, branches, chains))
    within = rng.uniform(0, draw(seconds), (branches, chains))
    change = np.where(rng.random(chains) < 0.3, BROKEN_CHAIN_COST, BRANCH_CHANGE_COST)
    return possible, rng.uniform(0, 3, branches), within, table, change


def total(way, first, within, table, change) -> float:
    seconds = first[way[0]] + within[way[0], 0]
    for chain in range(1, len(way)):
        seconds += table[way[chain - 1], way[chain], chain] + within[way[chain], chain]
        seconds += change[chain] * (way[chain] != way[chain - 1])
    return float(seconds)


@given(cost_cases())
def test_no_other_choice_of_branches_costs_less(case) -> None:
    possible, first, within, table, change = case
    branches, chains = possible.shape
    way = cheapest_branches(
        possible, BranchCosts(first, within, lambda at: table[:, :, at]), change
    )
    assert possible[way, np.arange(chains)].all()
    best = min(
        total(guess, first, within, table, change)
        for guess in itertools.product(range(branches), repeat=chains)
        if possible[guess, np.arange(chains)].all()
    )
    assert total(way, first, within, table, change) == pytest.approx(best)


@pytest.mark.parametrize(
    ("branches", "chains"),
    [
        *((3, chains) for chains in (63, 64, 65, 66, 500, 16385, 16386, 40000)),
        (16, 4098),
        (70, 200),
    ],
)
def test_many_chains_cost_what_one_after_the_other_does(branches: int, chains: int) -> None:
    rng = np.random.default_rng(chains)
    possible = rng.random((branches, chains)) < 0.6
    possible[rng.integers(0, branches, chains), np.arange(chains)] = True
    first, within = rng.uniform(0, 1, branches), rng.uniform(0, 1, (branches, chains))
    table = rng.uniform(0, 1, (branches, branches, chains))
    change = np.full(chains, BRANCH_CHANGE_COST)
    way = cheapest_branches(
        possible, BranchCosts(first, within, lambda at: table[:, :, at]), change
    )
    assert possible[way, np.arange(chains)].all()
    within = np.where(possible, within, np.inf)
    least = first + within[:, 0]
    for chain in range(1, chains):
        ways = least[:, None] + table[:, :, chain] + BRANCH_CHANGE_COST * (1 - np.eye(branches))
        least = ways.min(axis=0) + within[:, chain]
    assert total(way, first, within, table, change) == pytest.approx(least.min())


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
    result = add_whole_turns(angles, (low, high), starts, near)
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
    stated = np.full(4, TURNS_NOT_STATED)
    stated[2] = 0
    starts = np.array([0, 3])
    result = add_whole_turns(angles, (-360.0, 360.0), starts, 0.0, stated)
    assert result.angles.tolist() == [-190.0, -170.0, -150.0, 10.0]
    stated[2] = 1
    result = add_whole_turns(angles, (-360.0, 360.0), starts, 0.0, stated)
    assert result.angles[:3].tolist() == [170.0, 190.0, 210.0]
