"""Readers, layout and conversion see the same code in a text as the strictest reader would."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import languages
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import (
    LINE_ENDS,
    TEXT_ENDS,
    SourceText,
    ended_lines,
    lines_of,
    odd_characters,
)
from assistant.compiler.formatter import format_bytes
from assistant.compiler.translation import translate
from tests.examples import drawn

PACKAGE = Path(__file__).parent.parent.parent / "assistant"
ANY_END = re.compile("[\n\r\v\f\x1c-\x1e\x85\u2028\u2029\x00\x03\x04\x1a]")
"""Whatever ends a line or a text for anybody, stated here apart from what is tried."""

PIECES = {
    "rapid": ["! a", "Stop;", 'TPWrite "b";', "WaitTime 1;", "  ", ' "', "!", "IF TRUE Stop;"],
    "melfa-basic-5": ["' a", "Hlt", 'C1$="b"', "Dly 1", "  ", ' "', "'", "If M1=1 Then Hlt", "REM"],
}
FRAMES = {"rapid": ("MODULE m\nPROC main()\n", "\nENDPROC\nENDMODULE\n"), "melfa-basic-5": ("", "")}
NAMES = {"rapid": "m.mod", "melfa-basic-5": "M.prg"}


def texts(language: str) -> st.SearchStrategy[str]:
    ends = [*"\n\n\n\n\n", "\r\n", "\r\n", *LINE_ENDS, *TEXT_ENDS]
    piece = st.tuples(st.sampled_from(PIECES[language]), st.sampled_from(ends)).map("".join)
    begin, end = FRAMES[language]
    inner = st.lists(piece, min_size=1, max_size=6).map("".join)
    return inner.map(lambda text: f"{begin}{text}{end}")


def statements(language: str, text: str) -> list[str]:
    """What a reader takes for code; comments and layout count for nothing."""
    spoken = languages.get(language)
    if language == "rapid":
        return [form for form, _ in spoken.said(text)]
    tree = spoken.parse(text)
    return [type(item.statement).__name__ for item in tree.items if getattr(item, "statement", 0)]


def strictly(text: str) -> str:
    return "\n".join(ANY_END.split(text)) + "\n"


@pytest.mark.parametrize("language", list(PIECES))
@settings(max_examples=drawn(40))
@given(data=st.data())
def test_an_accepted_text_is_the_same_for_the_strictest_reader(
    language: str, data: st.DataObject
) -> None:
    text = data.draw(texts(language))
    if has_errors(languages.get(language).parse(text).findings):
        return
    seen = statements(language, text)
    assert statements(language, strictly(text)) == seen
    laid_out = format_bytes(text.encode(), NAMES[language], language, None).text
    assert statements(language, laid_out) == statements(language, strictly(laid_out)) == seen


def test_a_translation_leaves_such_characters_out(tmp_path: Path) -> None:
    file = tmp_path / "M.prg"
    for character in [*LINE_ENDS, *TEXT_ENDS]:
        file.write_bytes(f"1 ' a{character}\r\n2 Dly 1 ' b{character}\r\n3 End\r\n".encode())
        if character in TEXT_ENDS:
            with pytest.raises(Refused) as refused:
                translate(file, to="melfa-basic-6", language="melfa-basic-5")
            assert {finding.code for finding in refused.value.findings} == {"IN021"}
            continue
        (data,) = translate(file, to="melfa-basic-6", language="melfa-basic-5").files.values()
        assert data.decode().split("\r\n") == ["1 ' a", "2 Dly 1 ' b", "3 End", ""]


def test_what_people_do_not_see_is_told_of() -> None:
    for character in "\b\x1b\x7f\u200b\u202e\u2066\ufeff":
        for name, text in (
            ("rapid", "MODULE m\n! a{}b\nENDMODULE\n"),
            ("melfa-basic-5", "\n'a{}b\n"),
        ):
            (finding,) = languages.get(name).parse(text.format(character)).findings
            assert (finding.code, str(finding.severity)) == ("IN022", "warning")
            assert finding.line == 2


@given(st.text(alphabet="ab \t\r\n\v\0\u2028", max_size=30))
def test_lines_are_the_text_again(text: str) -> None:
    assert "".join(ended_lines(text)) == text
    assert [line.rstrip("\r\n") for line in ended_lines(text)] == lines_of(text)
    source = SourceText(text)
    for _, at in odd_characters(text):
        line, column = source.line_column(at)
        assert ended_lines(text)[line - 1][column - 1] == text[at]


HARMLESS = {
    "blocks/fmu/co_simulation.py": "what a compiler said, for people",
    "blocks/bdsim_adapter.py": "what bdsim printed, for people",
    "controllers/cyclic/process.py": "what our own process wrote",
    "controllers/mitsubishi/control_mode.py": "bytes, which end at CR and LF only",
    "controllers/trajectory_execution.py": "bytes, which end at CR and LF only",
    "controllers/connection.py": "words of an error, for people",
    "languages/melfa_basic/reading/mistakes.py": "a table of the package",
    "languages/melfa_basic/tables/vocabulary/__init__.py": "a table of the package",
    "languages/rapid/tables/predefined.py": "a table of the package",
    "languages/texts/words.py": "a table of the package",
    "program/pseudo/editor_support.py": "a table of the package",
    "sources/drawing/document.py": "bytes, which end at CR and LF only",
}
"""Modules that may ask Python for lines, and why."""


def test_python_is_not_asked_what_a_line_is() -> None:
    asked = {
        file.relative_to(PACKAGE).as_posix()
        for file in PACKAGE.rglob("*.py")
        if ".splitlines(" in file.read_text(encoding="utf-8")
    }
    assert asked == set(HARMLESS)
