"""Comments that ignore findings: their lines, their files, and what cannot be ignored."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base.diagnostics import Diagnostic, Severity
from assistant.base.source_text import SourceText
from assistant.findings.severities import comment_start, sift


def at(line: int, code: str = "RA204", severity: Severity = Severity.ERROR) -> Diagnostic:
    return Diagnostic(code, severity, "x", path="m.mod", line=line)


def left(text: str, *findings: Diagnostic, mark: str = "!") -> list[tuple[str, int | None]]:
    return [(f.code, f.line) for f in sift(findings, SourceText(text, "m.mod"), mark).left]


def test_a_comment_behind_code_counts_for_its_line() -> None:
    text = "a;\nb; ! assistant: ignore RA204\nc;\n"
    assert left(text, at(1), at(2), at(3)) == [("RA204", 1), ("RA204", 3)]
    assert left(text, at(2), at(2, "RA205")) == [("RA205", 2)]


def test_a_comment_that_stands_alone_counts_for_the_next_line_of_code() -> None:
    text = "a;\n  ! assistant: ignore RA204\n  ! assistant: ignore RA205\n  ! more\nb;\nc;\n"
    assert left(text, at(1), at(5), at(5, "RA205"), at(6)) == [("RA204", 1), ("RA204", 6)]


def test_several_codes_and_a_reason() -> None:
    text = "b; ! Assistant: ignore ra204, RA205: both are declared elsewhere\n"
    assert left(text, at(1), at(1, "RA205")) == []


def test_a_whole_file() -> None:
    text = "! assistant: ignore-file RA204\na;\nb;\n"
    assert left(text, at(2), at(3), at(3, "RA205")) == [("RA205", 3)]
    nowhere = Diagnostic("RA204", Severity.ERROR, "x", path="m.mod", about="m")
    assert left(text, nowhere) == []


def test_steps_stand_before_comments_of_melfa() -> None:
    text = "10 ' assistant: ignore MB101\n20 GOTO *X\n30 GOTO *Y ' assistant: ignore MB101\n"
    assert left(text, at(2, "MB101"), at(3, "MB101"), mark="'") == []


def test_what_cannot_be_read_cannot_be_ignored() -> None:
    text = "a; ! assistant: ignore RA101\n"
    assert left(text, at(1, "RA101")) == [("RA101", 1), ("FN202", 1)]


def test_a_comment_that_ignores_nothing_is_found_where_all_was_looked_for() -> None:
    text = "a;\nb; ! assistant: ignore RA204, RA205\n"
    source = SourceText(text, "m.mod")
    (unused,) = sift([at(2)], source, "!").left
    assert (unused.code, unused.severity) == ("FN201", Severity.INFO)
    assert unused.span is not None
    assert text[unused.span.start : unused.span.end] == "RA205"
    assert sift([at(2)], source, "!", complete=False).left == ()
    assert [f.line for f in sift([at(2)], source, "!").ignored] == [2]


@pytest.mark.parametrize("comment", ["ignore", "ignore all", "ignore RA", "ignore-file"])
def test_a_comment_without_a_code_is_found(comment: str) -> None:
    assert left(f"a; ! assistant: {comment}\n", at(1)) == [("RA204", 1), ("FN203", 1)]


@pytest.mark.parametrize(
    "line",
    [
        'TPWrite "! assistant: ignore RA204";',
        'TPWrite "a""! assistant: ignore RA204";',
        "assistant: ignore RA204",
        "! see assistant: ignore RA204",
    ],
)
def test_only_a_comment_of_its_own_counts(line: str) -> None:
    assert left(line + "\n", at(1)) == [("RA204", 1)]


@given(st.text(alphabet='ab"! \\', max_size=30))
def test_a_comment_begins_outside_of_strings(line: str) -> None:
    start = comment_start(line, "!")
    if start is None:
        assert all(line[:at].count('"') % 2 for at, c in enumerate(line) if c == "!")
    else:
        assert line[start] == "!"
        assert line[:start].count('"') % 2 == 0
