"""Source texts: how a file's bytes were decoded, and where in them an offset is."""

from __future__ import annotations

import os
import re
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any, BinaryIO, Final

from assistant.program import japanese
from assistant.program.bounded import NoFile, TooLarge, read_file, read_stream
from assistant.program.budgets import FILE
from assistant.program.diagnostics import Diagnostic, Refused, Rule, Span, Unreadable, error

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
LINE_END_INSIDE = error(
    "IN008",
    "a {character} stands inside the line: it ends the line for some readers, not for others",
    "end the line with CR LF there, or take the character out",
)
LINE_ENDS: Final = {
    "\r": "carriage return without a line feed",
    "\v": "vertical tab",
    "\f": "form feed",
    "\x1c": "file separator",
    "\x1d": "group separator",
    "\x1e": "record separator",
    "\x85": "next line",
    "\u2028": "line separator",
    "\u2029": "paragraph separator",
}
"""Characters that end a line for Python or Unicode; here only a line feed does, with carriage
returns in front of it or none, or a carriage return in a text without line feeds."""
_ANY: Final = re.compile(f"[\n{''.join(LINE_ENDS)}]+")
_OTHER: Final = f"[{''.join(LINE_ENDS.keys() - {chr(13)})}]"
_INSIDE: Final = {
    "\n": re.compile(rf"{_OTHER}|\r(?!\r*(?:\n|\Z))"),
    "\r": re.compile(_OTHER),
}
"""What may end a line sooner, by what ends the lines of the text."""
_LONE_RETURN: Final = re.compile(r"\r(?!\n)")

_WORD: Final = re.compile(r"\w+")
SEVERAL_CODES: Final = ("cp932", japanese.CODEC)
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
        """What ends the lines: a carriage return in a file of the old Macintosh."""
        return "\r" if "\n" not in self.text and "\r" in self.text else "\n"

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

    def line_text(self, line: int) -> str:
        """The line with that number, without its line end."""
        start = self._starts[line - 1]
        end = self.text.find(self._line_end, start)
        return self.text[start : end if end >= 0 else None].rstrip("\r")

    def finding(self, rule: Rule, span: Span, **fields: Any) -> Diagnostic:
        """The rule's finding at a span of this text, with line, column and excerpt."""
        line, column = self.line_column(span.start)
        end_line, end_column = self.line_column(span.end)
        return rule(
            path=self.path,
            span=span,
            line=line,
            column=column,
            excerpt=self.line_text(line),
            end_line=end_line,
            end_column=end_column,
            **fields,
        )

    def line_ends_inside(self) -> Iterator[Diagnostic]:
        """A finding for each line that ends sooner for some readers, and says more behind that.

        What stands between such a character and an end of its line may be blank: then it does
        not matter where the line ends.
        """
        if not self._may_end_inside():
            return
        at, pattern = 0, _INSIDE[self._line_end]
        while (found := pattern.search(self.text, at)) is not None:
            begin = self.text.rfind(self._line_end, 0, found.start()) + 1
            end = self.text.find(self._line_end, found.start())
            end = len(self.text) if end < 0 else end
            line = self.text[begin:end]
            first, last = begin + len(line) - len(line.lstrip()), begin + len(line.rstrip())
            if (inside := pattern.search(self.text, first, last)) is not None:
                name = LINE_ENDS[inside[0]]
                yield self.finding(LINE_END_INSIDE, Span(*inside.span()), character=name)
            at = end + 1

    def _may_end_inside(self) -> bool:
        """Whether there is any character that could; nearly no text has one, and most are long."""
        if any(one in self.text for one in LINE_ENDS if one != "\r"):
            return True
        return self._line_end == "\n" and _LONE_RETURN.search(self.text) is not None


def lines_of(text: str) -> list[str]:
    """The lines of a text without their ends: see LINE_ENDS. No empty one behind the last end."""
    lines = text.split("\n") if "\n" in text else text.split("\r")
    return [line.rstrip("\r") for line in (lines if lines[-1] else lines[:-1])]


def one_line(text: str) -> str:
    """The text with a blank for what may end a line: see LINE_ENDS."""
    return _ANY.sub(" ", text)


def words_of(text: str) -> list[str]:
    """Names and numbers in a text, in lower case and in their order."""
    return _WORD.findall(text.lower())


def dominant_newline(text: str) -> str:
    r"""`\r\n`, `\n` or `\r`: the one that ends most lines, `\r\n` for a text of one line."""
    feeds, both = text.count("\n"), text.count("\r\n")
    if not feeds:
        return "\r" if "\r" in text else "\r\n"
    return "\r\n" if 2 * both >= feeds else "\n"


def comments(text: str, mark: str) -> Iterator[Span]:
    """Where comments stand, from the mark to the end of the line; none is in a string ("…")."""
    pattern = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|({re.escape(mark)}[^\r\n]*)'
    return (Span(*match.span()) for match in re.finditer(pattern, text) if match[1] is not None)


def read_bytes(path: str | FilePath, *, allow_empty: bool = False, most: int = FILE) -> bytes:
    """The bytes of a file, see `bounded.read_file`.

    Raises Unreadable, with a finding, for whatever keeps it from being read.
    """
    name = str(path)
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
