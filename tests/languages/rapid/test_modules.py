"""Any tree comes back from its text, and any layout of that text from its tree."""

from __future__ import annotations

import random
from dataclasses import fields, is_dataclass
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, find, given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.languages.rapid.tree import syntax as s
from tests.examples import drawn
from tests.languages.rapid.layouts import scattered
from tests.languages.rapid.modules import files

RAPID = languages.get("rapid")
PATIENT = settings(
    deadline=None,
    max_examples=drawn(200),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
THOROUGH = settings(PATIENT, max_examples=drawn(1_000))
SEEDS = st.integers(0, 2**32)


def comes_back(tree: s.File, seed: int) -> None:
    printed = RAPID.render(tree)
    again = RAPID.parse(printed)
    assert not again.findings, printed
    assert again == tree
    assert RAPID.render(again) == printed
    text = scattered(printed, random.Random(seed))
    other = RAPID.parse(text)
    assert not other.findings, text
    assert other == tree
    assert RAPID.render(other) == text


@PATIENT
@given(files(), SEEDS)
def test_modules_come_back(tree: s.File, seed: int) -> None:
    comes_back(tree, seed)


@pytest.mark.slow
@THOROUGH
@given(files(), SEEDS)
def test_many_modules_come_back(tree: s.File, seed: int) -> None:
    comes_back(tree, seed)


def kinds(node: Any, seen: set[type]) -> set[type]:
    if isinstance(node, tuple):
        for part in node:
            kinds(part, seen)
    elif is_dataclass(node):
        seen.add(type(node))
        for field in fields(node):
            kinds(getattr(node, field.name), seen)
    return seen


@pytest.mark.slow  # it is about the strategy
@pytest.mark.filterwarnings("ignore:Generating overly large repr")  # of the file that is found
def test_every_kind_of_node_is_made() -> None:
    every = {kind for kind in vars(s).values() if isinstance(kind, type)}
    wanted = {kind for kind in every if issubclass(kind, s.Node)} - {s.Node, s.RunNode}
    seen: set[type] = set()
    draws = settings(
        PATIENT, max_examples=1000, derandomize=True, database=None, phases=[Phase.generate]
    )
    find(files(), lambda tree: wanted <= kinds(tree, seen), settings=draws)
