"""Words of a text: kind and offset, descriptions, line wrapping, and ASCII forms of names.

Letters beyond ASCII are written in comments as Python's backslash escapes, since a controller and
the tools around it may open a file in any code page.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Final, NamedTuple


class Word(NamedTuple):
    """kind: as the language calls it. text: as written. start: its offset."""

    kind: str
    text: str
    start: int

    @property
    def end(self) -> int:
        return self.start + len(self.text)


def abouts(package: str) -> Mapping[str, str]:
    """Sentences by lower-case word, of `abouts.txt` in a package: lines `word, word: sentence`."""
    text = files(package).joinpath("abouts.txt").read_text("utf-8")
    told: dict[str, str] = {}
    for line in text.splitlines():
        listed, colon, sentence = line.partition(": ")
        if colon and not line.startswith("#"):
            told |= {word.strip().lower(): sentence.strip() for word in listed.split(",")}
    return told


def wrapped_text(text: str, most: int, mark: str) -> list[str]:
    """Cut a text between words, into parts of at most so many bytes in UTF-8.

    mark: first characters of further parts. A single word that is too long is cut.
    """
    if _utf8_size(text) <= most:
        return [text]
    parts, line = list[str](), ""
    # Each word keeps the blank after it, so that the joined parts are the text again.
    for piece in re.split(r"(?<= )", text):
        for part in piece if _utf8_size(piece) > most - _utf8_size(mark) else [piece]:
            if _utf8_size(line + part) > most:
                parts.append(line.rstrip())
                line = mark
            line += part
    return [*parts, line.rstrip()]


def _utf8_size(text: str) -> int:
    return len(text.encode("utf-8"))


_ESCAPE: Final = r"\\(?:x[0-9a-f]{2}|u[0-9a-f]{4}|U[0-9a-f]{8})"

ASCII_NAME: Final = rf"(?:[A-Za-z_]|{_ESCAPE})(?:[A-Za-z0-9_]|{_ESCAPE})*"
"""The regular expression of a name as `in_ascii` writes it."""


def in_ascii(name: str) -> str:
    return name.encode("ascii", "backslashreplace").decode("ascii")


def from_ascii(text: str) -> str:
    """Return the name before escaping; the text unchanged if the result is not a name."""
    name = re.sub(_ESCAPE, lambda m: chr(min(int(m[0][2:], 16), 0x10FFFF)), text)
    return name if re.fullmatch(r"[^\W\d]\w*", name) else text
