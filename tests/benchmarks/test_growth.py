"""The constructs of the growth benchmark: what they are drawn from, and how they are measured."""

from __future__ import annotations

import math

import pytest

from benchmarks.growth.construct import Construct
from benchmarks.growth.drawn import SPOKEN, drawn
from benchmarks.growth.flows import flows
from benchmarks.growth.measuring import Growth, calls, forked, run
from benchmarks.growth.report import SHORT
from benchmarks.growth.sources import sources


def test_everything_that_repeats_in_a_grammar_is_drawn_and_grows() -> None:
    constructs = list(drawn(SPOKEN[1:2]))
    assert len(constructs) >= 600
    assert all(len(one.text(9)) > len(one.text(3)) for one in constructs)


def test_each_listed_construct_grows() -> None:
    listed = [*flows(), *sources()]
    assert len(listed) > 100
    assert not [one.name for one in listed if length(one, 2) >= length(one, 8)]


def length(construct: Construct, n: int) -> int:
    """Of its text, with that of its process file, repeated so many times."""
    process = "" if construct.process is None else construct.process(n)
    return len(construct.text(n)) + len(process)


def test_a_run_is_counted_alike_each_time_and_its_fork_answers() -> None:
    one = next(one for one in flows() if one.name == SHORT[0])
    run(one, "check", 20, calls)
    first, second = (run(one, "check", 20, calls) for _ in range(2))
    assert first == pytest.approx(second, rel=0.01)
    assert forked(lambda: 2.5, 5.0) == 2.5


def test_the_exponent_is_that_of_the_largest_sizes() -> None:
    square = {n: n * n / 1e6 for n in (100, 200, 400)}
    assert Growth("a", "check", {10: 5.0} | square).exponent == pytest.approx(2.0)
    assert math.isnan(Growth("a", "check", {10: 1.0}).exponent)
