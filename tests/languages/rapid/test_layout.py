"""The one layout of RAPID: what it changes, and that it changes nothing else."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import has_errors
from assistant.languages.rapid.reading.scanner import words
from assistant.languages.texts.words import Word
from tests.examples import drawn
from tests.languages.rapid.modules import files
from tests.tables import every_row

RAPID = languages.get("rapid")
CASES = re.findall(
    r"^= (.+)\n((?s:.*?))^-\n((?s:.*?))(?=^= |\Z)",
    (Path(__file__).parent / "layouts.txt").read_text(encoding="utf-8"),
    re.MULTILINE,
)
"""Name, text as it is found, and as it is laid out."""


def laid_out(text: str) -> str:
    """The text in the layout; the tree, and the layout once more, are the same."""
    tree = RAPID.parse(text)
    assert not has_errors(tree.findings), (text, tree.findings)
    formatted = RAPID.format(tree)
    again = RAPID.parse(formatted)
    assert again == tree, formatted
    assert not has_errors(again.findings), formatted
    assert comments(formatted) == comments(text)
    assert RAPID.format(again) == formatted
    return formatted


def comments(text: str) -> list[str]:
    return [t.text.rstrip() for t in words(text) if t.kind == "comment"]


@every_row(("name", "given", "wanted"), CASES)
def test_layout(name: str, given: str, wanted: str) -> None:
    assert laid_out(given) == wanted
    assert laid_out(wanted) == wanted


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_line_ends_become_those_of_most_lines(newline: str) -> None:
    lines = ["MODULE m", "VAR num a;", "VAR num b;", "VAR num c;", "ENDMODULE"]
    odd = {"\n": "\r\n", "\r\n": "\n"}[newline]
    text = newline.join(lines[:-1]) + odd + lines[-1]
    formatted = laid_out(text)
    assert formatted.count(newline) == len(lines)
    assert formatted.splitlines(keepends=True)[-1] == f"ENDMODULE{newline}"
    assert len(re.findall(r"\r?\n", formatted)) == len(re.findall(newline, formatted))


def test_carriage_returns_too_many_go() -> None:
    assert laid_out("MODULE m\r\r\nVAR num a;\r\r\nENDMODULE\r\r\n") == (
        "MODULE m\r\n    VAR num a;\r\nENDMODULE\r\n"
    )


def test_a_broken_file_stays_as_it_is() -> None:
    text = "MODULE m\n  PROC p()\n a:=1\n  ENDPROC\nENDMODULE\n"
    tree = RAPID.parse(text)
    assert tree.findings
    assert RAPID.format(tree) == text


def test_a_changed_tree_is_laid_out_as_it_would_be_written() -> None:
    tree = RAPID.parse("MODULE  a\nENDMODULE\nMODULE  b\nVAR num x;\nENDMODULE\n")
    first, second = tree.modules
    changed = replace(tree, parts=(replace(first, name="c"), second))
    assert RAPID.format(changed) == ("MODULE c\nENDMODULE\n\nMODULE b\n    VAR num x;\nENDMODULE\n")


@settings(max_examples=drawn(60), deadline=None)
@given(files(), st.randoms(use_true_random=False))
def test_any_spelling_keeps_its_tree(tree, random) -> None:
    laid_out(spelt_anyhow(RAPID.render(replace(tree, origin=None)), random))


@settings(max_examples=drawn(40), deadline=None)
@given(files(), st.randoms(use_true_random=False))
def test_blanks_and_case_of_words_do_not_matter(tree, random) -> None:
    text = RAPID.render(replace(tree, origin=None))
    spoilt = ""
    for token, space in spaced(text):
        more = token.kind not in ("newline", "comment") and random.random() < 0.2
        spoilt += other_case(token, random) + " " * (space + more)
    assert blind(laid_out(spoilt)) == blind(laid_out(text))


def other_case(token: Word, random) -> str:
    words = [token.text, token.text.lower(), token.text.title()]
    return random.choice(words) if token.kind == "key" else token.text


def spaced(text: str):
    """The tokens of a text, and whether a blank stands behind each."""
    for token in words(text):
        end = token.start + len(token.text)
        yield token, text[end : end + 1] == " " or token.text == "%"


def blind(text: str) -> list[str]:
    """The lines of a text without the distance of comments behind them."""
    return [re.sub(r"(\S) +!", r"\1 !", line) for line in text.splitlines()]


def spelt_anyhow(text: str, random) -> str:
    """The same tokens with other line ends, blanks and case of keywords, and comments."""
    gaps = ["", "", "", " ", "\t", "  ", "\n", "\n\n\n"]
    noted = [*gaps, " ! note\n", '\n  ! "note"  \n\n']
    pieces = []
    for token, space in spaced(text):
        gap = random.choice(noted if token.text in (",", ";", ":=", "+", "[") else gaps)
        pieces.append(other_case(token, random))
        pieces.append("" if token.kind == "header" else gap or " " * space)
    return "".join(pieces)
