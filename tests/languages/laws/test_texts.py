"""Laws of texts: kept as they are, laid out without a change, read around what is damaged."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Unreadable
from assistant.base.source_text import LINE_ENDS
from assistant.program import statements as p
from assistant.program.comparison import compare
from assistant.program.program import Program
from tests.examples import drawn
from tests.languages.laws.subjects import (
    LANGUAGES,
    TEXTS,
    WAITING,
    WAITS,
    damaged,
    errors,
    every_language,
    read,
    written,
)
from tests.tables import every_row

every_text = every_row(("name", "file"), TEXTS)


def test_every_language_has_texts() -> None:
    assert {name for name, _ in TEXTS} == set(LANGUAGES)


@every_text
def test_a_text_comes_back(name: str, file: Path) -> None:
    language, tree = languages.get(name), read(name, file)
    assert not errors(tree.findings)
    assert language.render(tree) == language.read(file).text
    assert language.encode(tree) == file.read_bytes()


@every_text
def test_a_program_that_nobody_changed_is_lowered_to_its_text(name: str, file: Path) -> None:
    language, tree = languages.get(name), read(name, file)
    assert language.encode(language.lower(language.lift(tree))) == file.read_bytes()


@every_text
def test_the_layout_changes_nothing_that_is_said(name: str, file: Path) -> None:
    language, tree = languages.get(name), read(name, file)
    text = language.format(tree)
    again = language.parse(replace(tree.source, text=text))
    assert language.same(again, tree)
    assert language.format(again) == text
    assert codes(again) <= codes(tree)
    assert compare(language.lift(tree), language.lift(again)).same


def codes(tree) -> Counter[str]:
    return Counter(finding.code for finding in tree.findings)


def is_read_around(name: str, step: int) -> None:
    """A damaged line is found, and the other ones are read. step: from damage to damage."""
    language = languages.get(name)
    (data,) = written(language, language.adapt(WAITING).program).values()
    text = language.decode(data).text
    whole = language.lift(language.parse(text))
    assert waits(whole) == list(WAITS)
    own = {text.count("\n", 0, wait.span.start) + 1: wait for wait in waits(whole) if wait.span}
    assert len(own) == len(WAITS)
    for line, lost, spoilt in islice(damaged(text, language.comment_mark), 0, None, step):
        tree = language.parse(spoilt)
        assert language.render(tree) == spoilt
        assert line in {finding.line for finding in errors(tree.findings)}, spoilt
        language.check([tree])
        if lost < 1 or line in own:  # a block that nothing begins is no block any more
            left = waits(language.lift(tree))
            assert [wait for wait in left if wait != own.get(line)] == [
                wait for wait in WAITS if wait != own.get(line)
            ], spoilt


@every_language
def test_a_damaged_line_is_found_and_the_others_are_read(name: str) -> None:
    """Of the three damages every other one: each line has one of them, or two."""
    is_read_around(name, 2)


@pytest.mark.slow
@every_language
def test_a_line_damaged_in_every_way_is_found_and_the_others_are_read(name: str) -> None:
    is_read_around(name, 1)


def waits(program: Program) -> list[p.Wait]:
    return [statement for statement in program.statements() if isinstance(statement, p.Wait)]


def nothing_raises(name: str, text: str) -> None:
    language = languages.get(name)
    tree = language.parse(text)
    assert language.render(tree) == text
    assert tree.findings or not text.strip() or tree != language.parse("")
    language.check([tree])
    language.lift(tree)
    if not errors(tree.findings):
        assert language.same(language.parse(language.format(tree)), tree)


@every_language
@given(
    text=st.text(max_size=200) | st.binary(max_size=200).map(lambda data: data.decode("latin-1"))
)
@settings(max_examples=drawn(150))
def test_no_text_raises(name: str, text: str) -> None:
    nothing_raises(name, text)


@every_language
@given(data=st.data())
@settings(max_examples=drawn(50))
def test_no_words_raise(name: str, data: st.DataObject) -> None:
    """Words of the language in any order, which comes nearer to it than any text does."""
    words = data.draw(st.lists(st.sampled_from(words_of(name)), max_size=40))
    nothing_raises(name, " ".join(words))


@cache
def words_of(name: str) -> list[str]:
    """The words and marks of the texts of a language, and what may end a line."""
    texts = (languages.get(name).read(file).text for told, file in TEXTS if told == name)
    return [
        "\n",
        *LINE_ENDS,
        *sorted({word for text in texts for word in re.findall(r"\w+|[^\w\s]", text)}),
    ]


@every_language
@given(data=st.binary(max_size=300))
def test_any_bytes_are_read_and_come_back(name: str, data: bytes) -> None:
    language = languages.get(name)
    language.recognises(data)
    try:
        source = language.decode(data)
    except Unreadable:
        assert language.begins and data.startswith(language.begins)
        return
    assert language.encode(language.parse(source)) == data
