"""Blocks of lines by their words, and the ways through them, whatever the language."""

from __future__ import annotations

import pytest

from assistant.languages.line_blocks import (
    ANY,
    EXIT,
    NO_WORD,
    ON,
    Blocks,
    BlockWord,
    Exits,
    Graph,
    blocks_of,
    graph_of,
)
from tests.tables import every_row

WORDS = {
    "routine": BlockWord(bounds="begins"),
    "if": BlockWord("if"),
    "else": BlockWord(parts="if", certain=True),
    "elseif": BlockWord(parts="if"),
    "endif": BlockWord(closes=("if",)),
    "loop": BlockWord("loop", "loop"),
    "forever": BlockWord("loop", "loop", certain=True),
    "again": BlockWord(closes=("loop",)),
    "all again": BlockWord(closes=("loop", "loop")),
    "choose": BlockWord("choice", "choice"),
    "case": BlockWord(parts="choice"),
    "otherwise": BlockWord(parts="choice", certain=True),
    "chosen": BlockWord(closes=("choice",)),
    "end": BlockWord(closes=(ANY,)),
}
LEAVING = {"leave": Exits(on=False, breaks=True), "back": Exits(on=False, returns=True)}


def blocks(text: str) -> Blocks:
    return blocks_of(enumerate(WORDS.get(word, NO_WORD) for word in text.split("/")))


def ways(text: str) -> Graph:
    """`go x` jumps to the line `x`, `call x` calls it."""
    lines = text.split("/")

    def exits(at: int) -> Exits[str]:
        word, _, to = lines[at].partition(" ")
        if word == "go":
            return Exits(jumps=(to,), on=False)
        return Exits(calls=(to,)) if word == "call" else LEAVING.get(word, ON)

    def find(name: str) -> int | None:
        return lines.index(name) if name in lines else None

    return graph_of(range(len(lines)), blocks(text), exits, find)


@pytest.mark.parametrize("ending", ["endif", "end"])
def test_a_block_knows_its_words_and_what_stands_in_it(ending: str) -> None:
    found = blocks(f"a/if/b/else/loop/c/end/{ending}/d")
    outer, inner = found.all
    assert found.sound and outer.words == [1, 3, 7] and inner.words == [4, 6]
    assert [found.around[at] for at in range(9)] == [
        *(None, None, outer, outer, outer, inner, outer, None, None)
    ]
    assert inner.depth == 2 and list(inner.chain) == [inner, outer]


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("a/endif", [(1, "if", None)]),
        ("if/else/again", [(2, "loop", None)]),
        ("end", [(0, ANY, None)]),
        ("if/loop/endif/again", [(2, "if", "loop")]),
        ("loop/else/again", [(1, "if", None)]),
        ("if/routine/endif", [(2, "if", None)]),
    ],
)
def test_words_that_do_not_fit(text: str, wrong: list[tuple[int, str, str | None]]) -> None:
    found = blocks(text)
    told = [(one.at, one.kind, one.inside and one.inside.kind) for one in found.wrong]
    assert told == wrong and not found.sound


def test_a_block_that_is_crossed_ends_where_the_one_around_it_does() -> None:
    outer, inner = blocks("if/loop/endif/again").all
    assert outer.last == 2 and inner.last == 3 and inner.crossed == 2


def test_one_word_closes_several_blocks() -> None:
    found = blocks("loop/loop/all again")
    assert [block.first for block in found.closing[2]] == [1, 0]


@every_row(
    ("text", "after"),
    [
        ("if/a/endif/b", {0: [1, 2], 1: [2], 2: [3], 3: [EXIT]}),
        ("if/a/elseif/b/else/c/endif", {0: [1, 2], 1: [6], 2: [3, 4], 3: [6], 4: [5], 5: [6]}),
        ("loop/a/again/b", {0: [1, 3], 1: [2], 2: [0]}),
        ("forever/a/again/b", {0: [1], 2: [0]}),
        ("choose/a/case/b/case/c/chosen", {0: [2, 4, 6], 2: [3], 3: [6], 5: [6]}),
        ("choose/case/b/otherwise/c/chosen", {0: [1, 3], 2: [5]}),
        ("loop/leave/again/a", {1: [3]}),
        ("back/a", {0: [EXIT]}),
        ("go b/a/b", {0: [2]}),
        ("go c/a", {0: []}),
    ],
)
def test_what_may_follow_a_line(text: str, after: dict[int, list[int]]) -> None:
    graph = ways(text)
    assert {at: graph.after[at] for at in after} == after


def test_what_is_called_is_reached_if_calls_count() -> None:
    graph = ways("call c/back/c/back")
    assert graph.called == {2}
    assert graph.reached([0]) == {0, 1}
    assert graph.reached([0], through_calls=True) == {0, 1, 2, 3}
