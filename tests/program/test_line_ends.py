"""One definition of a line: for parsers, what counts lines, and what is sent to controllers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from assistant import languages
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import LINE_ENDS, SourceText, lines_of
from assistant.compiler import check_files, translate
from assistant.controllers.mitsubishi.programs import program_lines as listed_lines
from tests.tables import every_row

HIDDEN = {
    "TEST1.prg": "10 ' a {}15 HLT\r\n20 DLY 1\r\n30 END\r\n",
    "hidden.mod": "MODULE hidden\r\nPROC main()\r\n! a {}EvilStop;\r\nENDPROC\r\nENDMODULE\r\n",
}
"""A comment in which a statement stands behind a character that may end the line."""
LANGUAGES = {"TEST1.prg": "melfa-basic-4", "hidden.mod": "rapid"}

both = pytest.mark.parametrize("name", list(HIDDEN))


def found(name: str, text: str) -> list[tuple[str, int | None, int | None]]:
    tree = languages.get(LANGUAGES[name]).parse(text)
    return [(f.code, f.line, f.column) for f in tree.findings]


@both
@every_row("character", list(LINE_ENDS))
def test_what_may_end_a_comment_is_an_error_at_its_place(name: str, character: str) -> None:
    text, at = HIDDEN[name].format(character), HIDDEN[name].index("{}")
    line, column = text[:at].count("\n") + 1, at - text.rfind("\n", 0, at)
    assert ("IN008", line, column) in found(name, text)
    tree = languages.get(LANGUAGES[name]).parse(text)
    assert has_errors(tree.findings)
    assert languages.get(LANGUAGES[name]).format(tree) == text


@both
def test_it_is_neither_translated_nor_laid_out(name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    file.write_bytes(HIDDEN[name].format("\r").encode())
    assert "IN008" in [f.code for f in check_files([file]).findings]
    with pytest.raises(Refused, match="carriage return"):
        translate(file, to="melfa-basic-5" if name.endswith("mod") else "rapid")
    assert file.read_bytes() == HIDDEN[name].format("\r").encode()


@both
@every_row("character", list(LINE_ENDS))
def test_at_the_edge_of_a_line_it_does_not_matter(name: str, character: str) -> None:
    text = HIDDEN[name].format("").replace("\r\n", f" {character}\r\n", 1)
    assert "IN008" not in [code for code, *_ in found(name, text)]


@both
@pytest.mark.parametrize("newline", ["\r\n", "\n", "\r"])
def test_a_file_may_end_its_lines_in_one_of_three_ways(name: str, newline: str) -> None:
    text = HIDDEN[name].format("\r\n").replace("EvilStop", "Stop").replace("\r\n", newline)
    language = languages.get(LANGUAGES[name])
    tree = language.parse(text)
    assert not has_errors(tree.findings)
    sound = language.parse(text.replace(newline, "\n"))
    assert language.lift(tree).procedures == language.lift(sound).procedures


@every_row("character", list(LINE_ENDS))
def test_a_comment_of_a_tree_is_written_on_one_line(character: str) -> None:
    rapid = languages.get("rapid")
    tree = rapid.parse("! a\r\nMODULE m\r\nENDMODULE\r\n")
    comment = replace(tree.parts[0], text=f"a {character}EvilStop;")
    written = rapid.render(replace(tree, parts=(comment, *tree.parts[1:])))
    assert written.splitlines() == ["! a  EvilStop;", "MODULE m", "ENDMODULE"]
    assert not has_errors(rapid.parse(written).findings)


@every_row("character", ["\n", *LINE_ENDS])
@every_row("number", [0, 1, 2])
def test_a_comment_of_melfa_basic_is_written_on_one_line(number: int, character: str) -> None:
    basic = languages.get("melfa-basic-5")
    tree = basic.parse("1 'a\r\n2 Hlt 'a\r\n3 End\r\n")
    line = replace(tree.items[number], comment=f"'b{character}9 Dly 1")
    items = (*tree.items[:number], line, *tree.items[number + 1 :])
    for changed in (replace(tree, items=items), replace(tree, items=items, source=None, parsed=())):
        written = basic.render(changed)
        assert written.splitlines()[number].endswith("'b 9 Dly 1")
        assert len(written.splitlines()) == 3


def test_a_controller_is_sent_the_lines_that_are_read() -> None:
    for text in ("1 Hlt\r\n2 End\r\n", "1 Hlt\n2 End", "1 Hlt\r2 End\r"):
        assert [line.text for line in listed_lines(text.encode())] == ["1 Hlt", "2 End"]
    (only,) = listed_lines(b"1 ' a \r15 Hlt\n")
    assert only.text == "1 ' a \r15 Hlt"


@pytest.mark.parametrize("text", ["a\r\nb", "a\nb\n", "a\rb\r", "a\nb", "a\rb"])
def test_lines_of_a_text_are_those_that_are_counted(text: str) -> None:
    assert lines_of(text) == ["a", "b"]
    source = SourceText(text)
    assert [source.line_text(n) for n in (1, 2)] == ["a", "b"]
    assert source.line_column(text.index("b")) == (2, 1)
