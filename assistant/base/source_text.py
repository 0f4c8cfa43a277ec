"""Source texts: decoding of files, lines, offsets, letters, and what a terminal may show of them.

There is one definition of a line for every reader, printer, listing and controller. A line ends
at a line feed, with or without carriage returns before it; in a text without line feeds, at a
carriage return, as on the old Macintosh. Other characters that end a line or the text for some
readers are refused inside a text: a comment for one reader would be code for another. RAPID ends
a comment at a new line (CR LF or LF; a module with CR alone is one long line, ABB tech community,
"RS 5.08"); MELFA-BASIC is sent line by line, and has CR LF on disk.

Robot programs do not state their code page: the vendors' tools write the code page of their
Windows. So UTF-8, Japanese and Western code pages are tried. cp932 has 360 characters twice, in
rows ED and EE of NEC and in rows FA to FC of IBM; Python writes the former, Windows the latter.
The codec `cp932_ibm`, registered here, writes the latter, so that such a file keeps its bytes.

Letters beyond ASCII are transliterated for names and comments: readable, not reversible. Chinese
characters are read as in Mandarin in names, and stay code points in comments.
"""

from __future__ import annotations

import codecs
import os
import re
import unicodedata
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field, replace
from functools import cache, cached_property
from itertools import accumulate, islice
from pathlib import Path as FilePath
from typing import Any, BinaryIO, Final, NoReturn

from assistant.base.budgets import FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import (
    Diagnostic,
    Refused,
    Rule,
    Severity,
    Span,
    Unreadable,
    error,
    warning,
)
from assistant.base.file_access import NoFile, TooLarge, read_file, read_stream
from assistant.base.near_names import near_name

LINE_END_INSIDE = error(
    "IN008",
    "a {character} stands inside the line: it ends the line for some readers, not for others",
    "end the line with CR LF there, or take the character out",
)
_TEXT_END_INSIDE = error(
    "IN021",
    "a {character} stands in the text: it ends the text for some readers, not for others",
    "take the character out",
)
_MISLEADING = warning(
    "IN022",
    "a {character} stands in the text: what people see there is not what a controller reads",
    "take the character out",
)
_LONE_RETURNS = error(
    "IN023",
    "the lines end at a carriage return alone: for a controller all may be one line",
    "save it with CR LF",
)
_UTF_16 = error(
    "IN024",
    "the file is written in UTF-16, which no controller reads",
    "save it as ISO 8859-1, or as UTF-8",
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
"""Characters that end a line for Python or Unicode (UAX 14, `str.splitlines`); here none does but
the first, in a text without line feeds.
"""
TEXT_ENDS: Final = {
    "\0": "null character",
    "\x03": "control character (end of text)",
    "\x04": "control character (end of transmission)",
    "\x1a": "substitute (Ctrl-Z)",
}
"""Characters that end a text: of C, of serial lines, of files of CP/M and DOS. At its end they may
stand."""
_MISLEADS: Final = {
    "\b": "backspace",
    "\x1b": "control character (escape)",
    "\x7f": "delete",
    "\ufeff": "zero width no-break space",
    "\u200b": "zero width space",
    "\u2060": "word joiner",
    **dict.fromkeys("\u202a\u202b\u2066\u2067\u2068", "mark that turns the direction of a text"),
    **dict.fromkeys("\u202d\u202e", "mark that overrides the direction of a text"),
    **dict.fromkeys("\u202c\u2069", "mark that ends a direction of a text"),
}
"""Characters that hide or reorder their neighbours (CVE-2021-42574, "Trojan Source").

U+FEFF, the byte order mark, may begin a text.
"""

# Possessive quantifiers: no line is scanned twice.
REST: Final = r"[^\r\n]*+(?:\r++(?!\n|\Z)[^\r\n]*+)*+"
"""Regular expression for the rest of a line, for texts whose lines end at line feeds."""

_ODD_NAMES: Final = {**LINE_ENDS, **TEXT_ENDS, **_MISLEADS}
_ODD_CHARACTERS: Final = "".join(_ODD_NAMES.keys() - {"\r"})
_MAY_BE_ODD: Final = {
    "\n": re.compile(rf"[{re.escape(_ODD_CHARACTERS)}]|\r(?!\r*(?:\n|\Z))"),
    "\r": re.compile(rf"[{re.escape(_ODD_CHARACTERS)}]"),
}
"""Patterns of the characters that need a closer check, by the line end of the text."""
_NO_ENDS: Final = dict.fromkeys(map(ord, (LINE_ENDS.keys() | TEXT_ENDS.keys()) - {"\r"}))
_SEVERAL_RETURNS: Final = re.compile(r"\r+\n")
_CONTROL: Final = re.compile("[\\x00-\\x08\\x0a-\\x1f\\x7f-\\x9f\u2028\u2029]+")
_LONE_RETURN: Final = re.compile(r"\r(?!\n)")
_BLANK: Final = "".join(TEXT_ENDS) + " \t\r\n\v\f\x1c\x1d\x1e\x85\u2028\u2029"


def line_end(text: str) -> str:
    """Return the line end of a text: a carriage return only if the text has no line feed."""
    return "\r" if "\n" not in text and "\r" in text else "\n"


def with_line_feeds(text: str) -> str:
    """A text in which line feeds end the lines, each character where it was."""
    return text if "\n" in text else text.replace("\r", "\n")


def ended_lines(text: str) -> list[str]:
    """The lines of a text with their ends."""
    end = line_end(text)
    lines = [line + end for line in text.split(end)]
    lines[-1] = lines[-1][:-1]
    return lines if lines[-1] else lines[:-1]


def lines_of(text: str) -> list[str]:
    """Return the lines of a text without their ends. No empty line follows the last end."""
    lines = text.split(line_end(text))
    return [line.rstrip("\r") for line in (lines if lines[-1] else lines[:-1])]


def without_ends(text: str) -> str:
    """The text without what may end a line or the text for some; its lines end as they do."""
    return _SEVERAL_RETURNS.sub("\r\n", text.translate(_NO_ENDS))


def one_line(text: str) -> str:
    """The text with a blank for control characters, and for what else may end a line."""
    return _CONTROL.sub(" ", text)


def dominant_newline(text: str) -> str:
    r"""`\r\n`, `\n` or `\r`: the one that ends most lines, `\r\n` for a text of one line."""
    feeds, both = text.count("\n"), text.count("\r\n")
    if not feeds:
        return "\r" if "\r" in text else "\r\n"
    return "\r\n" if 2 * both >= feeds else "\n"


def odd_characters(text: str) -> Iterator[tuple[str, int]]:
    """List characters that readers of the text interpret differently, with their offsets.

    Once a line each: a character that may end the line and has text before and after it there, one
    that may end the text and has text after it, and one that misleads people.
    """
    if not any(one in text for one in _ODD_CHARACTERS) and _LONE_RETURN.search(text) is None:
        return  # nearly no text has one, and most are long
    # A text may end with such a character: only one with text after it matters.
    end, last = line_end(text), len(text.rstrip(_BLANK))
    pattern, at = _MAY_BE_ODD[end], 0
    while (found := pattern.search(text, at)) is not None:
        begin = text.rfind(end, 0, found.start()) + 1
        at = text.find(end, found.start()) + 1 or len(text) + 1
        line = text[begin : at - 1]
        # Blanks around the line do not count: a line end among them separates nothing.
        first, behind = begin + len(line) - len(line.lstrip()), begin + len(line.rstrip())
        told = set()
        for one in pattern.finditer(text, found.start(), at - 1):
            kind = next(table for table in (LINE_ENDS, TEXT_ENDS, _MISLEADS) if one[0] in table)
            if kind is LINE_ENDS:
                matters = first <= one.start() < behind
            else:
                # U+FEFF at the very start is the byte order mark.
                matters = one.start() < last and (one[0] != "\ufeff" or one.start() > 0)
            if matters and id(kind) not in told:
                told.add(id(kind))
                yield one[0], one.start()


CP932_IBM: Final = "cp932_ibm"


@cache
def _ibm_rows() -> tuple[re.Pattern[str], dict[str, bytes]]:
    codes = [bytes((row, cell)) for row in (0xFA, 0xFB, 0xFC) for cell in range(0x40, 0xFD)]
    known = {code.decode("cp932", "ignore"): code for code in codes}
    twice = {c: code for c, code in known.items() if len(c) == 1 and _is_of_nec(c)}
    return re.compile(f"([{''.join(twice)}])"), twice


def _is_of_nec(character: str) -> bool:
    return character.encode("cp932")[0] in (0xED, 0xEE)


def _encode_ibm(text: str, errors: str = "strict") -> tuple[bytes, int]:
    # The capturing group has `split` return the characters of the pattern as parts, too.
    pattern, rows = _ibm_rows()
    parts = pattern.split(text)
    return b"".join(rows.get(part) or part.encode("cp932", errors) for part in parts), len(text)


def _decode_ibm(data: bytes, errors: str = "strict") -> tuple[str, int]:
    return codecs.decode(data, "cp932", errors), len(data)


def _find_cp932_ibm(name: str) -> codecs.CodecInfo | None:
    return codecs.CodecInfo(_encode_ibm, _decode_ibm, name=CP932_IBM) if name == CP932_IBM else None  # type: ignore[arg-type]


codecs.register(_find_cp932_ibm)


_NO_PATH = error(
    "IN011",
    "`{given}` is no source",
    "give the name of a file, or a program that was read",
)
NOT_FOUND = error("IN001", "there is no file `{name}`", "{cure}")
_IS_FOLDER = error("IN002", "`{name}` is a folder", "name a file inside it")
_NOT_PERMITTED = error("IN003", "`{name}` may not be read", "ask for permission or copy the file")
_NOT_READ = error("IN004", "`{name}` cannot be read: {reason}", "try the file again")
EMPTY = error("IN005", "`{name}` is empty", "export or save it again")
_NO_FILE = error(
    "IN009",
    "`{name}` cannot be read as a file: {reason}",
    "copy what it gives into a file, or hand a robot program over on standard input, as `-`",
)
_TOO_LARGE = error(
    "IN010",
    "`{name}` is not read: {reason}",
    "split it; or allow more: `robot-assistant --budget 10 …`",
)
_UNDECODABLE = error(
    "IN006", "`{name}` is not text in any of the encodings {encodings}", "save it as plain text"
)
_UNWRITABLE = error(
    "IN007",
    "`{character}` cannot be written in the file's encoding, {encoding}",
    "write it in other characters, or save the file as UTF-8 before the change",
)
_WORD: Final = re.compile(r"\w+")
_SEVERAL_CODES: Final = ("cp932", CP932_IBM)
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
        return line_end(self.text)

    @cached_property
    def _starts(self) -> list[int]:
        lines = self.text.split(self._line_end)
        return list(accumulate((len(line) + 1 for line in lines[:-1]), initial=0))

    def line_column(self, offset: int) -> tuple[int, int]:
        """Line and column, counted from 1, of a character offset."""
        line = bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    @property
    def line_count(self) -> int:
        """The number of lines; text after the last line end counts as one, even if it is empty."""
        return self.text.count(self._line_end) + 1

    @property
    def ended_line_count(self) -> int:
        """The number of lines; nothing after the last line end is not one."""
        rest = self.text[self.text.rfind(self._line_end) + 1 :]
        return self.line_count - (not rest.rstrip("\r"))

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
        for character, at in odd_characters(self.text):
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
    (LINE_END_INSIDE, LINE_ENDS),
    (_TEXT_END_INSIDE, TEXT_ENDS),
    (_MISLEADING, _MISLEADS),
)


def words_of(text: str) -> list[str]:
    """Names and numbers in a text, in lower case and in their order."""
    return _WORD.findall(text.lower())


def comments(text: str, mark: str) -> Iterator[Span]:
    """Return the spans of comments, from the mark to the line end; strings ("…") have none."""
    pattern = rf'"(?:[^"\r\n]|"")*+(?:"|(?=[\r\n])|\Z)|({re.escape(mark)}{REST})'
    found = re.finditer(pattern, with_line_feeds(text))
    return (Span(*match.span()) for match in found if match[1] is not None)


def path_of(given: object) -> FilePath:
    """Return the path that a caller gave; raises Refused for anything else, such as None."""
    if isinstance(given, str | os.PathLike):
        return FilePath(given)
    raise Refused(_NO_PATH(given=f"{given!r:.60}"), exit_status=2)


def _cure_of_missing(name: str) -> str:
    """Return the cure for a missing file: the name that was meant, or how such a name is given."""
    if re.match(r"\w{2,}:/", name):
        return "an address of a controller comes first: `robot-assistant put CONTROLLER FILES`"
    if "\\" in name and os.sep == "/":
        return "check the name and folder; folders are separated by `/` here"
    path = FilePath(name)
    try:
        with os.scandir(path.parent) as entries:
            beside = [entry.name for entry in islice(entries, _MOST_BESIDE)]
    except (OSError, ValueError):
        return "check the name and folder"
    near = near_name(path.name, beside)
    return f"did you mean `{path.parent / near}`?" if near else "check the name and folder"


_MOST_BESIDE: Final = 1000
"""Files of a folder among which a similar name is searched for."""


def read_bytes(path: str | FilePath, *, allow_empty: bool = False, most: int = FILE) -> bytes:
    """The bytes of a file, see `bounded.read_file`.

    Raises Unreadable, with a finding, for whatever keeps it from being read.
    """
    name = str(path_of(path))
    try:
        data = read_file(path, most)
    except NoFile as error:
        raise Unreadable(_NO_FILE(path=name, name=name, reason=error.strerror)) from None
    except TooLarge as error:
        raise Unreadable(_TOO_LARGE(path=name, name=name, reason=error.strerror)) from None
    except Refused:
        raise
    except FileNotFoundError:
        raise Unreadable(NOT_FOUND(path=name, name=name, cure=_cure_of_missing(name))) from None
    except (IsADirectoryError, NotADirectoryError):
        raise Unreadable(_IS_FOLDER(path=name, name=name)) from None
    except PermissionError:
        windows_folder = os.name == "nt" and FilePath(path).is_dir()  # which is not permitted there
        rule = _IS_FOLDER if windows_folder else _NOT_PERMITTED
        raise Unreadable(rule(path=name, name=name)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Unreadable(_NOT_READ(path=name, name=name, reason=reason)) from None
    if not data and not allow_empty:
        raise Unreadable(EMPTY(path=name, name=name))
    return data


def is_folder(path: str | FilePath) -> bool:
    """True if the path is a folder; False too for a name that no folder can have."""
    try:
        return FilePath(path).is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: str | FilePath) -> bool:
    """True if the path is a file; False too for a name that no file can have."""
    try:
        return FilePath(path).is_file()
    except (OSError, ValueError):
        return False


def folders_of(folder: str | FilePath) -> Iterator[tuple[str, list[str], list[str]]]:
    """Walk a folder like `os.walk`, but refuse a subfolder that cannot be read.

    Raises Unreadable.
    """

    def refuse(error: OSError) -> NoReturn:
        name = str(error.filename or folder)
        if isinstance(error, PermissionError):
            raise Unreadable(_NOT_PERMITTED(path=name, name=name)) from None
        raise Unreadable(_NOT_READ(path=name, name=name, reason=error.strerror)) from None

    return os.walk(os.fspath(folder), onerror=refuse)


def read_input(stream: BinaryIO, name: str = "standard input") -> bytes:
    """All that comes on a stream; raises Unreadable if that is nothing, or too much."""
    try:
        data = read_stream(stream, name=name)
    except TooLarge as error:
        raise Unreadable(_TOO_LARGE(path=name, name=name, reason=error.strerror)) from None
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
        if encoding not in _SEVERAL_CODES or text.encode(encoding) == data:
            return SourceText(text, path, encoding, newline)
    name = path or "input"
    raise Unreadable(_UNDECODABLE(path=path, name=name, encodings=", ".join(encodings)))


def check_sent(data: bytes, path: str, *, by_line: bool = False) -> None:
    """Raises Refused for a text whose lines or end a controller may see elsewhere than we do.

    The code page does not matter: control characters are the same in all of them. Data that is not
    text, but an encrypted module, is left to the controller; it begins beyond ASCII and letters.
    by_line: each line is sent separately, whatever ends it here.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise Refused(_UTF_16(path=path))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        # An encrypted module begins beyond ASCII and letters; the controller has to judge it.
        if data[:1] >= b"\xf0":
            return
        # next line is a letter, or half of one, in the code pages of Windows
        text = data.decode("latin-1").replace("\x85", ".")
    source = SourceText(text, path)
    odd = (one for one in source.odd_characters() if one.severity is Severity.ERROR)
    found = list(islice(odd, 10))
    if not by_line and line_end(text) == "\r" and len(lines_of(text)) > 1:
        at = text.index("\r")
        found.append(source.finding(_LONE_RETURNS, Span(at, at + 1)))
    if found:
        raise Refused(*found)


def encode(source: SourceText) -> bytes:
    """The bytes of a text; raises Refused where it has a character that the encoding lacks."""
    try:
        return source.text.encode(source.encoding)
    except UnicodeEncodeError as error:
        character, span = source.text[error.start], Span(error.start, error.start + 1)
        raise Refused(
            source.finding(_UNWRITABLE, span, character=character, encoding=source.encoding)
        ) from None


def starts_of(texts: Iterable[SourceText | None]) -> list[int]:
    """Return the offset of each text of a program, for spans that count on from text to text.

    They are one character apart; None represents a tree without a text.
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


_JAPANESE_CODE_PAGES: Final = ("cp932", CP932_IBM)
_WESTERN_CODE_PAGES: Final = ("cp1252", "cp1250", "cp1254")
CODE_PAGES_READ: Final = (
    "ascii",
    "utf-8-sig",
    "utf-8",
    *_JAPANESE_CODE_PAGES,
    *_WESTERN_CODE_PAGES,
    "latin-1",
)
_CODE_PAGES_WRITTEN: Final = (_WESTERN_CODE_PAGES[0], _JAPANESE_CODE_PAGES[0], "utf-8")
"""New text beyond ASCII: the first that has all its characters, and is read as what it is."""

_LETTERS_OF_CODE_PAGE: Final = {
    "cp1250": re.compile(r"[A-Za-z][\xb9\xb3\xbf\xbe\x9f]|[\xb9\xb3\xbf\xbe][a-z]"),
    "cp1254": re.compile(r"[A-Za-z][\xf0\xfe\xfd\xdd\xde\xd0]|[\xfe\xde][a-z]"),
}
"""Code pages by what their letters look like in cp1252: signs and Icelandic inside of words."""


def decode_code_page(data: bytes, path: str | None) -> SourceText:
    """The text of a file. What European programs hold is not taken for Japanese."""
    source = decode(data, path, CODE_PAGES_READ)
    # cp932 decodes most Western texts as well, into rare letters instead of accented ones.
    if source.encoding in _JAPANESE_CODE_PAGES and not _is_japanese(source.text):
        others = [name for name in _WESTERN_CODE_PAGES if _round_trips(data, name)]
        source = decode(data, path, others or _JAPANESE_CODE_PAGES)
    # cp1252 decodes the other Western code pages, too: only odd letters inside words show them.
    if source.encoding == "cp1252":
        for encoding, sign in _LETTERS_OF_CODE_PAGE.items():
            if sign.search(source.text) and _round_trips(data, encoding):
                source = replace(source, text=data.decode(encoding), encoding=encoding)
                break
    return replace(source, newline=dominant_newline(source.text))


def encode_code_page(text: str, source: SourceText | None) -> bytes:
    """The bytes of a text: in its source's encoding, else in the first of WRITTEN that fits.

    Raises Refused where that of the source does not have all the characters.
    """
    if source is not None and source.encoding != "ascii":
        return encode(replace(source, text=text))
    if text.isascii():
        return text.encode("ascii")
    for encoding in _CODE_PAGES_WRITTEN:
        data = text.encode(encoding, errors="ignore")
        if decode_code_page(data, None).text == text:
            return data
    return encode(replace(source or SourceText(""), text=text, encoding="utf-8"))


def _is_japanese(text: str) -> bool:
    """True if most non-ASCII letters are in rows, as in Japanese; accented letters are single."""
    rows = re.findall(r"[^\x00-\x7f]+", text)
    if any("\ue000" <= character <= "\uf8ff" for row in rows for character in row):
        return False  # of nobody's language
    return 2 * sum(len(row) for row in rows if len(row) > 1) > sum(map(len, rows))


def _round_trips(data: bytes, encoding: str) -> bool:
    try:
        return data.decode(encoding).encode(encoding) == data
    except UnicodeError:
        return False


_LETTERS: Final = {
    "ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "ø": "oe", "å": "aa", "œ": "oe",
    "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ẞ": "SS", "Æ": "Ae", "Ø": "Oe", "Å": "Aa", "Œ": "Oe",
    "ð": "d", "đ": "d", "ł": "l", "þ": "th", "ı": "i",
    "Ð": "D", "Đ": "D", "Ł": "L", "Þ": "Th",
}  # fmt: skip
"""Letters that are more than one of ASCII with an accent, as their languages write them there."""

_ROWS: Final = {
    "": "アイウエオ", "k": "カキクケコ", "g": "ガギグゲゴ", "s": "サシスセソ", "z": "ザジズゼゾ",
    "t": "タチツテト", "d": "ダヂヅデド", "n": "ナニヌネノ", "h": "ハヒフヘホ", "b": "バビブベボ",
    "p": "パピプペポ", "m": "マミムメモ", "r": "ラリルレロ",
}  # fmt: skip
_SINGLE: Final = {
    "ヤ": "ya", "ユ": "yu", "ヨ": "yo", "ワ": "wa", "ヲ": "o", "ン": "n", "ヴ": "vu", "シ": "shi",
    "チ": "chi", "ツ": "tsu", "フ": "fu", "ジ": "ji", "ヂ": "ji", "ヅ": "zu",
}  # fmt: skip
_SYLLABLES: Final = {
    kana: consonant + vowel
    for consonant, row in _ROWS.items()
    for kana, vowel in zip(row, "aiueo", strict=True)
} | _SINGLE
"""Katakana in the letters of Hepburn, as road signs in Japan have them."""

_SMALL: Final = {"ァ": "a", "ィ": "i", "ゥ": "u", "ェ": "e", "ォ": "o"}
_GLIDES: Final = {"ャ": "a", "ュ": "u", "ョ": "o"}
_SIGNS: Final = {
    "、": ", ", "。": ". ", "・": " ", "「": '"', "」": '"', "『": '"', "』": '"',
    "【": "[", "】": "]", "〜": "-", "～": "-", "—": "-", "–": "-", "―": "-",
    "‘": "'", "’": "'", "“": '"', "”": '"',
    "→": "->", "←": "<-", "⇒": "=>", "°": " deg", "×": "x", "μ": "u", "µ": "u", "★": "*",
    "☆": "*", "■": "#", "□": "#", "●": "*", "○": "o",
    "※": "*", "±": "+/-", "≦": "<=", "≧": ">=", "≤": "<=", "≥": ">=", "≠": "<>", "…": "...",
}  # fmt: skip
_DIAMETER: Final = re.compile(
    r"([⌀∅]|%%[cC](?=\s*[.,]?[0-9])|((?<![^\W\d_])|(?<=[0-9][xX×]))[ØøΦφϕ](?![^\W\d_]))(\s*(?=[0-9]))?"
)
"""Sign of a diameter, with spaces before its number. Letters count as one where they are in no
word: in `4xØ6`, but not in `HØJDE`."""
_HIRAGANA: Final = {chr(code): chr(code + 0x60) for code in range(0x3041, 0x3097)}
_KANA: Final = re.compile(r"[ァ-ヴー]+")


_HAN: Final = re.compile("[\u2e80-\u2fdf\u3400-\u9fff\uf900-\ufaff\U00020000-\U0003ffff]")
"""Characters with several readings, which depend on the language and on the word around them."""
_NOTHING: Final = re.compile("(?!)")


def in_ascii(text: str) -> str:
    r"""Return the text of a comment in ASCII: letters in their Latin spelling, others as `\u539f`.

    Characters of Chinese and Japanese stay the numbers that they have: no reading is right in both.
    """
    if text.isascii():
        return text
    text = _DIAMETER.sub("dia. ", text)
    # Signs are replaced twice: NFKC dissolves some of them, and makes others from half-width forms.
    text = unicodedata.normalize("NFKC", "".join(_SIGNS.get(c, c) for c in text))
    spelled = _spelled(_kana("".join(_SIGNS.get(c, c) for c in text)), kept=_HAN)
    return spelled.encode("ascii", "backslashreplace").decode("ascii")


def plain_letters(text: str) -> str:
    """The text of a name: letters of LETTERS spelled out, others without accents or in Latin ones.

    Characters of Chinese and Japanese are read as in Mandarin: `外形` is `WaiXing`. A sign of a
    diameter, `%%c` of drawings included, is a D: `Ø6.6` is `D6.6`. What is no letter anywhere
    stays.
    """
    if "%%" not in text and text.isascii():
        return text
    text = _DIAMETER.sub("D", text)
    return text if text.isascii() else _spelled(_kana(unicodedata.normalize("NFC", text)))


def _spelled(text: str, kept: re.Pattern[str] = _NOTHING) -> str:
    letters = (c if kept.match(c) else _latin(c) for c in unicodedata.normalize("NFC", text))
    spelled = "".join(letters)
    # `ß` is lower case even in a word of capitals.
    return spelled.upper() if text.replace("ß", "").isupper() else spelled


def _latin(character: str) -> str:
    """A character in the letters of ASCII, itself if nobody writes it so."""
    if character.isascii():
        return character
    if character in _LETTERS:
        return _LETTERS[character]
    parts = unicodedata.normalize("NFKD", character)
    bare = "".join(c for c in parts if not unicodedata.combining(c))
    if bare.isascii():
        return bare
    from anyascii import anyascii

    return str(anyascii(character)) or character


def _kana(text: str) -> str:
    """Kana as they are spoken."""
    katakana = "".join(_HIRAGANA.get(c, c) for c in text)
    return _KANA.sub(lambda found: _spoken(found[0]), katakana)


def _spoken(kana: str) -> str:
    """Katakana in the letters of Hepburn."""
    said, double = "", False
    for c in kana:
        if c == "ッ":
            double = True
        elif c == "ー":
            # `ー` lengthens the vowel before it.
            said += said[-1:]
        elif c in _GLIDES:
            # A small ya, yu or yo replaces the i before it: kya, but sha, cha, ja.
            stem = said[:-1] if said.endswith("i") else said
            said = stem + ("" if stem.endswith(("sh", "ch", "j")) else "y") + _GLIDES[c]
        elif c in _SMALL:
            said = said[:-1] + _SMALL[c] if said[-1:] in ("e", "i", "u") else said + _SMALL[c]
        else:
            syllable = _SYLLABLES.get(c, c)
            # `ッ` doubles the consonant that follows; Hepburn writes tch for a doubled ch.
            said += (syllable[:1].replace("c", "t") if double else "") + syllable
            double = False
    return said


STEERING: Final = (
    "\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u0600-\u0605\u061c\u06dd\u070f\u0890\u0891\u08e2\u180e"
    "\u200b-\u200f\u2028-\u202e\u2060-\u2064\u2066-\u206f\ud800-\udfff\ufeff\ufff9-\ufffb\ufffe\uffff"
    "\U000110bd\U000110cd\U00013430-\U0001343f\U0001bca0-\U0001bca3\U0001d173-\U0001d17a"
    "\U000e0001\U000e0020-\U000e007f"
)
"""Control and format characters, ends of lines and paragraphs, and what stands for bytes that are
no text (Unicode's Cc, Cf, Zl, Zp and Cs), and the two code points that no XML may hold, for a class
of a regular expression; not the tab and the line feed."""
_SHOWN_AS_MARK: Final = re.compile(f"[{STEERING}\n]")


def visible(text: str) -> str:
    """The text on one line, with a mark for what steers a terminal or turns a text around."""
    return _SHOWN_AS_MARK.sub("�", text)
