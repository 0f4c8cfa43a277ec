"""What a line is: the one definition, for every reader, printer, listing and controller.

A line ends at a line feed, with carriage returns in front of it or none; in a text without line
feeds, at a carriage return, as on the old Macintosh. Other characters that end a line, or the
whole text, for some readers are refused inside of a text: comment for one reader would be code
for another. RAPID ends a comment at a new line (CR LF or LF; a module with CR alone is one long
line, ABB tech community, "RS 5.08"), MELFA-BASIC is sent line by line, CR LF on disk.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from assistant.program.diagnostics import error, warning

LINE_END_INSIDE = error(
    "IN008",
    "a {character} stands inside the line: it ends the line for some readers, not for others",
    "end the line with CR LF there, or take the character out",
)
TEXT_END_INSIDE = error(
    "IN021",
    "a {character} stands in the text: it ends the text for some readers, not for others",
    "take the character out",
)
MISLEADING = warning(
    "IN022",
    "a {character} stands in the text: what people see there is not what a controller reads",
    "take the character out",
)
LONE_RETURNS = error(
    "IN023",
    "the lines end at a carriage return alone: for a controller all may be one line",
    "save it with CR LF",
)
UTF_16 = error(
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
MISLEADS: Final = {
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
"""What hides or reorders what stands beside it (CVE-2021-42574, "Trojan Source"). U+FEFF, the byte
order mark, may begin a text.
"""

REST: Final = r"[^\r\n]*+(?:\r++(?!\n|\Z)[^\r\n]*+)*+"
"""What is left of a line, as a regular expression, for texts whose lines end at line feeds."""

_ODD_NAMES: Final = {**LINE_ENDS, **TEXT_ENDS, **MISLEADS}
_ODD_CHARACTERS: Final = "".join(_ODD_NAMES.keys() - {"\r"})
_MAY_BE_ODD: Final = {
    "\n": re.compile(rf"[{re.escape(_ODD_CHARACTERS)}]|\r(?!\r*(?:\n|\Z))"),
    "\r": re.compile(rf"[{re.escape(_ODD_CHARACTERS)}]"),
}
"""What is looked at more closely, by what ends the lines of the text."""
_NO_ENDS: Final = dict.fromkeys(map(ord, (LINE_ENDS.keys() | TEXT_ENDS.keys()) - {"\r"}))
_SEVERAL_RETURNS: Final = re.compile(r"\r+\n")
_CONTROL: Final = re.compile("[\\x00-\\x08\\x0a-\\x1f\\x7f-\\x9f\u2028\u2029]+")
_LONE_RETURN: Final = re.compile(r"\r(?!\n)")
_BLANK: Final = "".join(TEXT_ENDS) + " \t\r\n\v\f\x1c\x1d\x1e\x85\u2028\u2029"


def line_end(text: str) -> str:
    """What ends the lines of a text: a carriage return only where there is no line feed."""
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
    """The lines of a text without their ends. No empty one behind the last end."""
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
    """What stands in a text that is not for every reader what it is for others, and where.

    Once a line each: what may end the line and has something before and behind it there, what
    may end the text and has something behind it, and what misleads people.
    """
    if not any(one in text for one in _ODD_CHARACTERS) and _LONE_RETURN.search(text) is None:
        return  # nearly no text has one, and most are long
    end, last = line_end(text), len(text.rstrip(_BLANK))
    pattern, at = _MAY_BE_ODD[end], 0
    while (found := pattern.search(text, at)) is not None:
        begin = text.rfind(end, 0, found.start()) + 1
        at = text.find(end, found.start()) + 1 or len(text) + 1
        line = text[begin : at - 1]
        first, behind = begin + len(line) - len(line.lstrip()), begin + len(line.rstrip())
        told = set()
        for one in pattern.finditer(text, found.start(), at - 1):
            kind = next(table for table in (LINE_ENDS, TEXT_ENDS, MISLEADS) if one[0] in table)
            if kind is LINE_ENDS:
                matters = first <= one.start() < behind
            else:
                matters = one.start() < last and (one[0] != "\ufeff" or one.start() > 0)
            if matters and id(kind) not in told:
                told.add(id(kind))
                yield one[0], one.start()
