"""Source texts: how a file's bytes were decoded, and where in them an offset is."""

from __future__ import annotations

import os
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path as FilePath
from typing import Any, BinaryIO, Final, NoReturn

from assistant.program import japanese, lines
from assistant.program.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    Span,
    Unreadable,
    error,
)
from assistant.program.system.bounded import NoFile, TooLarge, read_file, read_stream
from assistant.program.system.budgets import FILE

NO_PATH = error(
    "IN011",
    "`{given}` is no source",
    "give the name of a file, or a program that was read",
)
NOT_FOUND = error("IN001", "there is no file `{name}`", "check the name and folder")
IS_FOLDER = error("IN002", "`{name}` is a folder", "name a file inside it")
NOT_PERMITTED = error("IN003", "`{name}` may not be read", "ask for permission or copy the file")
NOT_READ = error("IN004", "`{name}` cannot be read: {reason}", "try the file again")
EMPTY = error("IN005", "`{name}` is empty", "export or save it again")
NO_FILE = error(
    "IN009",
    "`{name}` cannot be read as a file: {reason}",
    "copy what it gives into a file, or hand a robot program over on standard input, as `-`",
)
TOO_LARGE = error(
    "IN010",
    "`{name}` is not read: {reason}",
    "split it; or allow more: `robot-assistant --budget 10 …`",
)
UNDECODABLE = error(
    "IN006", "`{name}` is not text in any of the encodings {encodings}", "save it as plain text"
)
UNWRITABLE = error(
    "IN007",
    "`{character}` cannot be written in the file's encoding, {encoding}",
    "write it in other characters, or save the file as UTF-8 before the change",
)
_WORD: Final = re.compile(r"\w+")
SEVERAL_CODES: Final = ("cp932", japanese.CP932_IBM)
"""Encodings that have characters twice, so that a text need not give its bytes back."""


@dataclass(frozen=True)
class SourceText:
    """A text with what is needed to write the very same bytes again.

    text: decoded, line ends untouched. encoding: a Python codec name.
    newline: the line end that new lines get. path: where it came from.
    """

    text: str
    path: str | None = None
    encoding: str = "ascii"
    newline: str = field(default="\r\n")

    @cached_property
    def _line_end(self) -> str:
        return lines.line_end(self.text)

    @cached_property
    def _starts(self) -> list[int]:
        starts, at = [0], self.text.find(self._line_end)
        while at >= 0:
            starts.append(at + 1)
            at = self.text.find(self._line_end, at + 1)
        return starts

    def line_column(self, offset: int) -> tuple[int, int]:
        """Line and column, counted from 1, of a character offset."""
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    @property
    def line_count(self) -> int:
        """How many lines there are; what stands behind the last line end counts as one, if only
        as an empty one.
        """
        return len(self._starts)

    def line_text(self, line: int) -> str:
        """The line with that number, without its line end."""
        start = self._starts[line - 1]
        end = self.text.find(self._line_end, start)
        return self.text[start : end if end >= 0 else None].rstrip("\r")

    def finding(self, rule: Rule, span: Span, **fields: Any) -> Diagnostic:
        """The rule's finding at a span of this text, with line, column and excerpt."""
        line, column = self.line_column(span.start)
        end_line, end_column = self.line_column(span.end)
        excerpt = self.line_text(line)
        return rule(
            path=self.path,
            span=span,
            line=line,
            column=min(column, len(excerpt) + 1),  # not among the characters that end the line
            excerpt=excerpt,
            end_line=end_line,
            end_column=min(end_column, len(self.line_text(end_line)) + 1),
            **fields,
        )

    def odd_characters(self) -> Iterator[Diagnostic]:
        """Findings for what other readers take for an end of a line or of the text: see `lines`."""
        for character, at in lines.odd_characters(self.text):
            rule, names = next(row for row in _ODD_RULES if character in row[1])
            yield self.finding(rule, Span(at, at + 1), character=names[character])


@dataclass(frozen=True)
class SomeLines(SourceText):
    """Some lines of a text, with the numbers that they have there.

    numbers: from 1 and ascending, of each line of this text; the last one is where that text ends.
    """

    numbers: Sequence[int] = (1,)

    def line_column(self, offset: int) -> tuple[int, int]:
        line, column = super().line_column(offset)
        return self.numbers[line - 1], column

    @property
    def line_count(self) -> int:
        return self.numbers[-1]

    def line_text(self, line: int) -> str:
        """Empty for one that is left out."""
        at = bisect_left(self.numbers, line)
        there = at < len(self._starts) and self.numbers[at] == line
        return super().line_text(at + 1) if there else ""


_ODD_RULES: Final = (
    (lines.LINE_END_INSIDE, lines.LINE_ENDS),
    (lines.TEXT_END_INSIDE, lines.TEXT_ENDS),
    (lines.MISLEADING, lines.MISLEADS),
)


def words_of(text: str) -> list[str]:
    """Names and numbers in a text, in lower case and in their order."""
    return _WORD.findall(text.lower())


def comments(text: str, mark: str) -> Iterator[Span]:
    """Where comments stand, from the mark to the end of the line; none is in a string ("…")."""
    pattern = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|({re.escape(mark)}{lines.REST})'
    found = re.finditer(pattern, lines.with_line_feeds(text))
    return (Span(*match.span()) for match in found if match[1] is not None)


def path_of(given: object) -> FilePath:
    """Return the path that a caller gave; raises Refused for anything else, such as None."""
    if isinstance(given, str | os.PathLike):
        return FilePath(given)
    raise Refused(NO_PATH(given=f"{given!r:.60}"), exit_status=2)


def read_bytes(path: str | FilePath, *, allow_empty: bool = False, most: int = FILE) -> bytes:
    """The bytes of a file, see `bounded.read_file`.

    Raises Unreadable, with a finding, for whatever keeps it from being read.
    """
    name = str(path_of(path))
    try:
        data = read_file(path, most)
    except NoFile as error:
        raise Unreadable(NO_FILE(path=name, name=name, reason=error.strerror)) from None
    except TooLarge as error:
        raise Unreadable(TOO_LARGE(path=name, name=name, reason=error.strerror)) from None
    except Refused:
        raise
    except FileNotFoundError:
        raise Unreadable(NOT_FOUND(path=name, name=name)) from None
    except (IsADirectoryError, NotADirectoryError):
        raise Unreadable(IS_FOLDER(path=name, name=name)) from None
    except PermissionError:
        windows_folder = os.name == "nt" and FilePath(path).is_dir()  # which is not permitted there
        rule = IS_FOLDER if windows_folder else NOT_PERMITTED
        raise Unreadable(rule(path=name, name=name)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Unreadable(NOT_READ(path=name, name=name, reason=reason)) from None
    if not data and not allow_empty:
        raise Unreadable(EMPTY(path=name, name=name))
    return data


def is_folder(path: str | FilePath) -> bool:
    """Whether there is a folder of that name; False too for a name that nothing can have."""
    try:
        return FilePath(path).is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: str | FilePath) -> bool:
    """Whether there is a file of that name; False too for a name that nothing can have."""
    try:
        return FilePath(path).is_file()
    except (OSError, ValueError):
        return False


def folders_of(folder: str | FilePath) -> Iterator[tuple[str, list[str], list[str]]]:
    """As `os.walk`, but a folder that may not be read is told of, not left out.

    Raises Unreadable.
    """

    def refuse(error: OSError) -> NoReturn:
        name = str(error.filename or folder)
        if isinstance(error, PermissionError):
            raise Unreadable(NOT_PERMITTED(path=name, name=name)) from None
        raise Unreadable(NOT_READ(path=name, name=name, reason=error.strerror)) from None

    return os.walk(os.fspath(folder), onerror=refuse)


def read_input(stream: BinaryIO, name: str = "standard input") -> bytes:
    """All that comes on a stream; raises Unreadable if that is nothing, or too much."""
    try:
        data = read_stream(stream, name=name)
    except TooLarge as error:
        raise Unreadable(TOO_LARGE(path=name, name=name, reason=error.strerror)) from None
    if not data:
        raise Unreadable(EMPTY(path=name, name=name))
    return data


def decode(data: bytes, path: str | None, encodings: Sequence[str]) -> SourceText:
    """Decodes with the first encoding that gives the bytes back; raises Unreadable if none does.

    `utf-8-sig` in the list is taken only for data that begins with its mark.
    """
    newline = "\r\n" if b"\r\n" in data or b"\n" not in data else "\n"
    for encoding in encodings:
        if encoding == "utf-8-sig" and not data.startswith(b"\xef\xbb\xbf"):
            continue
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if encoding not in SEVERAL_CODES or text.encode(encoding) == data:
            return SourceText(text, path, encoding, newline)
    name = path or "input"
    raise Unreadable(UNDECODABLE(path=path, name=name, encodings=", ".join(encodings)))


def check_sent(data: bytes, path: str, *, by_line: bool = False) -> None:
    """Raises Refused for a text whose lines or end a controller may see elsewhere than we do.

    Whatever code page it is in: control characters are the same in all of them. What is no text at
    all, but an encrypted module, is left to the controller; it begins beyond ASCII and letters.
    by_line: each line is sent by itself, whatever ends it here.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Refused(lines.UTF_16(path=path))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        if data[:1] >= b"\xf0":
            return
        # next line is a letter, or half of one, in the code pages of Windows
        text = data.decode("latin-1").replace("\x85", ".")
    source = SourceText(text, path)
    odd = (one for one in source.odd_characters() if one.severity is Severity.ERROR)
    found = list(islice(odd, 10))
    if not by_line and lines.line_end(text) == "\r" and len(lines.lines_of(text)) > 1:
        at = text.index("\r")
        found.append(source.finding(lines.LONE_RETURNS, Span(at, at + 1)))
    if found:
        raise Refused(*found)


def encode(source: SourceText) -> bytes:
    """The bytes of a text; raises Refused where it has a character that the encoding lacks."""
    try:
        return source.text.encode(source.encoding)
    except UnicodeEncodeError as error:
        character, span = source.text[error.start], Span(error.start, error.start + 1)
        raise Refused(
            source.finding(UNWRITABLE, span, character=character, encoding=source.encoding)
        ) from None


def starts_of(texts: Iterable[SourceText | None]) -> list[int]:
    """Where each text of a program begins, for spans that count on from one text to the next.

    They are one character apart; None stands for a tree without a text.
    """
    starts, end = [], 0
    for text in texts:
        starts.append(end)
        end += len(text.text if text else "") + 1
    return starts


def finding_in(
    source: SourceText | None, rule: Rule, span: Span | None, **fields: Any
) -> Diagnostic:
    """The rule's finding at a span of a text, of the file alone where one of them is not known."""
    if source is None or span is None:
        return rule(path=None if source is None else source.path, **fields)
    return source.finding(rule, span, **fields)
