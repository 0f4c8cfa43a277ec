"""Files read to texts, and places in them."""

from __future__ import annotations

import os
from pathlib import Path as FilePath

import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.base import source_text
from assistant.base.diagnostics import Rule, Severity, Span, Unreadable
from assistant.base.source_text import SourceText, decode, encode, read_bytes

ODD = Rule("XX102", Severity.ERROR, "odd {what}")


def code_of(path: FilePath, **options: bool) -> str:
    with pytest.raises(Unreadable) as refused:
        read_bytes(path, **options)
    (finding,) = refused.value.findings
    assert finding.path == str(path) and finding.message and finding.cure
    assert refused.value.exit_status == 2
    return finding.code


def test_what_cannot_be_read_says_why(tmp_path: FilePath) -> None:
    empty = tmp_path / "empty"
    empty.touch()
    assert code_of(tmp_path / "missing") == "IN001"
    assert code_of(tmp_path) == "IN002"
    assert code_of(empty / "inside") == "IN002"
    assert code_of(FilePath("nul\0")) == "IN004"
    assert code_of(empty) == "IN005"
    assert read_bytes(empty, allow_empty=True) == b""


def test_a_file_without_permission_says_so(tmp_path: FilePath) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(b"x")
    secret.chmod(0)
    if os.access(secret, os.R_OK):  # root, or a file system without permissions
        assert read_bytes(secret) == b"x"
    else:
        assert code_of(secret) == "IN003"


def test_bytes_come_as_they_are(tmp_path: FilePath) -> None:
    file = tmp_path / "a"
    file.write_bytes(b"\x00\r\n\xff")
    assert read_bytes(file) == read_bytes(str(file)) == b"\x00\r\n\xff"


@pytest.mark.parametrize(
    ("data", "encoding", "text", "newline"),
    [
        (b"a\r\nb", "utf-8", "a\r\nb", "\r\n"),
        (b"a\nb", "utf-8", "a\nb", "\n"),
        (b"ab", "utf-8", "ab", "\r\n"),
        (b"\xef\xbb\xbfa\n", "utf-8-sig", "a\n", "\n"),
        ("ü\n".encode(), "utf-8", "ü\n", "\n"),
        (b"\xfc\n", "latin-1", "ü\n", "\n"),
    ],
)
def test_the_first_encoding_that_fits_is_taken(
    data: bytes, encoding: str, text: str, newline: str
) -> None:
    source = decode(data, "a.mod", ("utf-8-sig", "utf-8", "latin-1"))
    assert source == SourceText(text, "a.mod", encoding, newline)
    assert source.text.encode(source.encoding) == data


def test_what_no_encoding_fits_is_refused() -> None:
    with pytest.raises(Unreadable) as refused:
        decode(b"\xff\xfe", None, ("ascii", "utf-8"))
    assert refused.value.findings[0].code == "IN006"
    assert "ascii, utf-8" in refused.value.findings[0].message


@given(st.text(st.sampled_from("ab\r\n\u2028\x0c"), max_size=30), st.data())
def test_line_and_column_find_the_character_again(text: str, data: st.DataObject) -> None:
    offset = data.draw(st.integers(0, len(text)))
    source = SourceText(text)
    line, column = source.line_column(offset)
    end = "\n" if "\n" in text or "\r" not in text else "\r"
    assert line == text.count(end, 0, offset) + 1
    lines = text.split(end)
    assert sum(len(before) + 1 for before in lines[: line - 1]) + column - 1 == offset
    assert source.line_text(line) == lines[line - 1].rstrip("\r")


def test_a_finding_of_a_text_has_its_place_and_line() -> None:
    source = SourceText("one\r\ntwo three\r\n", "a.mod")
    finding = source.finding(ODD, Span(9, 14), what="word")
    assert (finding.where(), finding.excerpt, finding.span) == (
        "a.mod:2:5",
        "two three",
        Span(9, 14),
    )
    assert finding.message == "odd word"
    end = source.finding(ODD, Span(len(source.text), len(source.text)), what="end")
    assert (end.line, end.column, end.excerpt) == (3, 1, "")


@pytest.mark.parametrize("written", ["高", "髙", "ⅰ", "№"])
def test_japanese_bytes_come_back_as_windows_wrote_them(written: str) -> None:
    windows = {"髙": b"\xfb\xfc", "ⅰ": b"\xfa\x40"}
    data = b"10 ' " + windows.get(written, written.encode("cp932")) + b"\r\n"
    source = decode(data, None, ("ascii", "utf-8", "cp932", source_text.CP932_IBM))
    assert source.text == f"10 ' {written}\r\n"
    assert encode(source) == data
