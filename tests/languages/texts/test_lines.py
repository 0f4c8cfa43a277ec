"""The text rooms of a language of lines, with one that has numbers, jumps, loops and comments."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from assistant.base.arrays import Ints
from assistant.base.diagnostics import Refused, Rule, Severity, Span
from assistant.base.source_text import SourceText
from assistant.languages.line_blocks import NO_WORD, BlockWord
from assistant.languages.runs.columns import Run
from assistant.languages.step_numbers import Change, Steps, renumbered, with_fitted_steps
from assistant.languages.texts import line_text, words
from assistant.languages.texts.line_merge import LineMerger, LinePart
from assistant.languages.texts.line_text import lay_out

BLOCKS = {"repeat": BlockWord("repeat", "loop"), "again": BlockWord(closes=("repeat",))}


@dataclass(frozen=True, slots=True)
class Line:
    """`10 jump 20  # a comment`."""

    number: int | None = None
    statement: str | None = None
    comment: str | None = None
    span: Span | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True, eq=False)
class Table(Run):
    """None of these stands in a text."""

    steps: Ints
    span: Span | None = field(default=None, compare=False)


def read(text: str) -> list[Line]:
    found = []
    for line in re.finditer(r".*\n", text):
        parts = re.match(r"[ ]*([0-9]*)[ ]*([^#\n]*)(#[^\n]*)?", line[0])
        assert parts is not None
        number, statement, comment = parts.groups()
        said = " ".join(statement.split()) or None
        found.append(Line(int(number) if number else None, said, comment, Span(*line.span())))
    return found


class Lines(line_text.LinePrinter):
    table, number, blocks, most = Table, "numbers", True, 40

    def __init__(self, items: Sequence[Line]) -> None:
        self.items = items

    def line(self, item: Line) -> line_text.Line:
        return line_text.Line(item.number, item.statement, item.comment)

    def word(self, code: str | None) -> BlockWord:
        return BLOCKS.get(code.split()[0], NO_WORD) if code else NO_WORD

    def printed(self, code: str | None) -> str:
        return code or ""

    def words(self, text: str) -> list[words.Word]:
        return [words.Word("word", m[0], m.start()) for m in re.finditer(r"\S+", text)]

    def spaced(self, words: Sequence[words.Word]) -> str:
        return " ".join(word.text for word in words)

    def key(self, word: words.Word) -> str:
        return word.text

    def says(self, text: str, code: str) -> bool:
        return " ".join(text.split()) == code

    def text(self, at: int, newline: str, level: int = 0) -> str:
        item = self.items[at]
        code = " " * (4 * level) + (item.statement or "") if item.statement else ""
        parts = ("" if item.number is None else str(item.number), code, item.comment or "")
        return " ".join(filter(None, parts)) + newline

    def respelled(self, at: int, text: str) -> str:
        return text

    def rows(self, table: Table, newline: str, indent: int) -> Callable[[Table], str]:
        raise NotImplementedError

    def as_data(self, item: Line) -> None:
        return None


class Merger(LineMerger):
    line, table, header = Line, Table, ("# kept", "# end")

    def parts(self, line: Line) -> Iterator[LinePart]:
        if line.comment is not None:
            yield LinePart("comment", line.comment)
        if line.statement is not None:
            yield LinePart("statement", line.statement, line.statement.split()[0])

    def rows_as_lines(self, rows: Table) -> Iterator[Line]:
        raise NotImplementedError


def jumps(items: Iterable[Line]) -> set[int]:
    return {int(i.statement[5:]) for i in items if (i.statement or "").startswith("jump ")}


def retargeted(item: Line, change: Change) -> Line:
    said = "".join(f"jump {change(to)}" for to in jumps([item]))
    return replace(item, statement=said) if said else item


FALLING, HIGH, UNKNOWN = (Rule(code, Severity.ERROR, code) for code in ("XX1", "XX2", "XX3"))
STEPS = Steps(Line, 99, jumps, retargeted, FALLING, HIGH, UNKNOWN)

TEXT = """\
10  start   1   # slowly
20 repeat 3
30   turn  5    # here
40 again
50 jump 20
"""


def changed(items: Sequence[Any]) -> str:
    return line_text.render_changed_file(SourceText(TEXT, newline="\n"), read(TEXT), Lines(items))


def test_a_layout_indents_what_stands_in_blocks_and_keeps_comments_aligned() -> None:
    text = "10 repeat   3\n20 turn 5   # here\n30 wait 10  # there\n40 again\n"
    assert lay_out(SourceText(text), Lines(read(text))) == (
        "10 repeat 3\n20     turn 5   # here\n30     wait 10  # there\n40 again\n"
    )


def test_new_files_are_printed_with_their_blocks() -> None:
    new = [replace(item, comment=None, span=None) for item in read(TEXT)]
    assert "".join(line_text.print_items(Lines(new), "\n")) == (
        "10 start 1\n20 repeat 3\n30     turn 5\n40 again\n50 jump 20\n"
    )


def test_a_changed_line_keeps_its_blanks_and_a_new_one_stands_as_deep_as_its_neighbours() -> None:
    items = read(TEXT)
    items[2] = replace(items[2], statement="turn 6")
    items.insert(3, Line(35, "wait 1"))
    assert changed(items) == TEXT.replace(
        "30   turn  5    # here\n", "30   turn  6    # here\n35   wait 1\n"
    )


def test_a_change_of_a_built_program_goes_into_the_lines_that_were_written() -> None:
    before = [Line(None, said) for said in ("start 1", "repeat 3", "turn 5", "again")]
    after = [*before[:2], Line(None, "turn 7"), Line(None, "wait 1"), before[3]]
    merged = next(Merger().merged(read(TEXT), before, after))
    numbered = with_fitted_steps(merged, 10, STEPS)
    assert numbered is not None
    assert changed(numbered) == TEXT.replace(
        "30   turn  5    # here\n", "30   turn  7    # here\n35   wait 1\n"
    )


def test_where_no_number_is_free_lines_move_on_with_the_jumps_to_them() -> None:
    items = [Line(1, "start 1"), Line(None, "wait 1"), Line(2, "turn 5"), Line(3, "jump 2")]
    assert with_fitted_steps(items, 1, STEPS) == [
        *(Line(1, "start 1"), Line(2, "wait 1"), Line(3, "turn 5"), Line(4, "jump 3")),
    ]
    assert with_fitted_steps([Line(99, "start 1"), Line(None, "wait 1")], 1, STEPS) is None


def test_numbers_given_anew_take_jumps_along() -> None:
    numbered = renumbered(read(TEXT), 1, 2, STEPS, None)
    assert [(item.number, item.statement) for item in numbered][1::3] == [
        (3, "repeat 3"), (9, "jump 3"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "first", "code"),
    [("10 jump 11\n", 10, "XX3"), ("20 wait\n10 wait\n", 10, "XX1"), ("10 wait\n", 100, "XX2")],
)
def test_what_cannot_be_numbered_is_refused(text: str, first: int, code: str) -> None:
    with pytest.raises(Refused) as refused:
        renumbered(read(text), first, 1, STEPS, SourceText(text))
    assert [finding.code for finding in refused.value.findings] == [code]
