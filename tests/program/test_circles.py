"""Names that lead back to themselves, against following each of them."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant.program.analysis.uses import recursive_names
from tests.examples import drawn

NAMES = st.sampled_from("abcdefgh")


@pytest.mark.parametrize(
    ("calls", "found"),
    [
        ({}, ""),
        ({"a": "b", "b": "c", "c": ""}, ""),
        ({"a": "a", "b": "a"}, "a"),
        ({"a": "b", "b": "c", "c": "b"}, "bc"),
        ({"a": "bc", "b": "d", "c": "d", "d": ""}, ""),
        ({"a": "x", "b": "a"}, ""),
    ],
)
def test_only_what_comes_back_is_found(calls: dict[str, str], found: str) -> None:
    assert recursive_names(calls) == frozenset(found)


@settings(max_examples=drawn(100), deadline=None)
@given(st.dictionaries(NAMES, st.sets(NAMES, max_size=3)))
def test_it_is_what_following_each_name_tells(calls: dict[str, set[str]]) -> None:
    def reached(name: str) -> set[str]:
        seen = set[str]()
        pending = list(calls[name])
        while pending:
            if (one := pending.pop()) not in seen:
                seen.add(one)
                pending += calls.get(one, ())
        return seen

    assert recursive_names(calls) == {name for name in calls if name in reached(name)}


def test_a_long_chain_and_a_long_ring_are_followed_to_their_ends() -> None:
    size = 20_000
    chain = {str(k): [str(k + 1)] for k in range(size)}
    assert recursive_names(chain) == frozenset()
    assert len(recursive_names({**chain, str(size): ["0"]})) == size + 1
