"""Any tree comes back from its text, and any layout of that text from its tree."""

from __future__ import annotations

import random
from dataclasses import is_dataclass

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.source_text import SourceText
from assistant.compiler.formatter import format_text
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.pseudo import parse as parse_pseudo
from assistant.program.pseudo import print_program
from tests.examples import drawn
from tests.languages.melfa_basic.files import files, of_type, position_lists
from tests.languages.melfa_basic.layouts import scattered
from tests.languages.melfa_basic.statements import word_node

LEVELS = (4, 5, 6)
PATIENT = settings(
    deadline=None,
    max_examples=drawn(100),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
THOROUGH = settings(PATIENT, max_examples=drawn(1_000))
SEEDS = st.integers(0, 2**32)
ANY = st.sampled_from(LEVELS).flatmap(files)
ENCODINGS = ("utf-8", "utf-8-sig", "cp932", "cp932_ibm", "cp1252")
LISTS = st.sampled_from(LEVELS).flatmap(position_lists)


def comes_back(tree: s.File, seed: int) -> None:
    language = languages.get(tree.dialect)
    printed = language.render(tree)
    again = language.parse(printed)
    assert not again.findings, printed
    assert again == tree
    assert language.render(again) == printed
    text = scattered(printed, random.Random(seed))
    other = language.parse(text)
    assert not other.findings, text
    assert language.same(other, tree)
    assert language.render(other) == text


def keeps_its_bytes(tree: s.File, seed: int) -> None:
    """In the encodings of the makers' tools and with mixed line ends."""
    language = languages.get(tree.dialect)
    chance = random.Random(seed)
    text = scattered(language.render(tree), chance)
    data = text.encode(chance.choice(ENCODINGS), "replace")
    source = language.decode(data)
    assert language.encode(language.parse(source)) == data


def is_laid_out(tree: s.File, seed: int) -> None:
    """`fmt` leaves tree and comments as they are, and what it wrote."""
    language = languages.get(tree.dialect)
    text = scattered(language.render(tree), random.Random(seed))
    once = format_text(SourceText(text), language)
    assert not once.findings, text
    twice = format_text(SourceText(once.text), language)
    assert twice.text == once.text
    assert language.same(language.parse(once.text), tree)


def is_lifted(tree: s.File, seed: int) -> None:
    """To the pseudo-program and its text, and back to the very tree; rules never fail."""
    language = languages.get(tree.dialect)
    text = scattered(language.render(tree), random.Random(seed))
    read = language.parse(text)
    language.check([read])
    program = language.lift(read)
    assert parse_pseudo(print_program(program).text) == program
    lowered = language.lower(program)
    assert lowered == read
    assert language.render(lowered) == text


def holds(tree: s.File, seed: int) -> None:
    comes_back(tree, seed)
    keeps_its_bytes(tree, seed)
    is_laid_out(tree, seed)
    is_lifted(tree, seed)


@PATIENT
@given(ANY, SEEDS)
def test_files_come_back(tree: s.File, seed: int) -> None:
    holds(tree, seed)


@pytest.mark.slow
@THOROUGH
@given(ANY, SEEDS)
def test_many_files_come_back(tree: s.File, seed: int) -> None:
    holds(tree, seed)


@PATIENT
@given(LISTS, SEEDS)
def test_position_lists_come_back(tree: s.File, seed: int) -> None:
    holds(tree, seed)


@pytest.mark.slow
@settings(PATIENT, max_examples=drawn(1_000))
@given(LISTS, SEEDS)
def test_many_position_lists_come_back(tree: s.File, seed: int) -> None:
    holds(tree, seed)


@pytest.mark.slow
def test_every_kind_of_node_is_made() -> None:
    kinds: set[type] = set()

    @settings(PATIENT, max_examples=2000, derandomize=True, database=None)
    @given(ANY)
    def look(tree: s.File) -> None:
        kinds.update(type(node) for node in of_type(tree.items, object) if is_dataclass(node))

    look()
    every = {kind for kind in vars(s).values() if isinstance(kind, type) and is_dataclass(kind)}
    of_texts = {s.Unread, s.File, s.Span, s.Diagnostic, s.SourceText}
    assert every - of_texts <= kinds


@pytest.mark.parametrize("level", LEVELS)
def test_every_command_comes_back(level: int) -> None:
    """With the fewest arguments that it takes, and with the most."""
    rows = [
        row
        for row in vocabulary.statements().values()
        if row.role in ("command", "motion") and level in row.dialects
    ]
    assert len(rows) > 50
    code: list[s.Line] = []
    for row in rows:
        first = [word_node(word) for word in row.words] or [s.Variable("P1")]
        made = s.Motion if row.role == "motion" else s.Command
        for count in (row.least, row.least + 3 if row.most is None else row.most):
            for one in first:
                arguments = (one, *[s.Number(1)] * (count - 1))[:count]
                code.append(s.Line(len(code) + 1, None, made(row.word, arguments)))
    comes_back(s.File(f"melfa-basic-{level}", tuple(code)), level)
