"""Texts of programs that say nowhere which code page they are in: UTF-8, Japanese or Western.

The tools of the makers of robots write in the code page of the Windows that they run on.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from assistant.program import japanese
from assistant.program import text as texts
from assistant.program.lines import dominant_newline
from assistant.program.text import SourceText

JAPANESE_CODE_PAGES: Final = ("cp932", japanese.CP932_IBM)
WESTERN_CODE_PAGES: Final = ("cp1252", "cp1250", "cp1254")
CODE_PAGES_READ: Final = (
    "ascii",
    "utf-8-sig",
    "utf-8",
    *JAPANESE_CODE_PAGES,
    *WESTERN_CODE_PAGES,
    "latin-1",
)
CODE_PAGES_WRITTEN: Final = (WESTERN_CODE_PAGES[0], JAPANESE_CODE_PAGES[0], "utf-8")
"""New text beyond ASCII: the first that has all its characters, and is read as what it is."""

_LETTERS_OF_CODE_PAGE: Final = {
    "cp1250": re.compile(r"[A-Za-z][\xb9\xb3\xbf\xbe\x9f]|[\xb9\xb3\xbf\xbe][a-z]"),
    "cp1254": re.compile(r"[A-Za-z][\xf0\xfe\xfd\xdd\xde\xd0]|[\xfe\xde][a-z]"),
}
"""Code pages by what their letters look like in cp1252: signs and Icelandic inside of words."""


def decode_code_page(data: bytes, path: str | None) -> SourceText:
    """The text of a file. What European programs hold is not taken for Japanese."""
    source = texts.decode(data, path, CODE_PAGES_READ)
    if source.encoding in JAPANESE_CODE_PAGES and not _is_japanese(source.text):
        others = [name for name in WESTERN_CODE_PAGES if _round_trips(data, name)]
        source = texts.decode(data, path, others or JAPANESE_CODE_PAGES)
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
        return texts.encode(replace(source, text=text))
    if text.isascii():
        return text.encode("ascii")
    for encoding in CODE_PAGES_WRITTEN:
        data = text.encode(encoding, errors="ignore")
        if decode_code_page(data, None).text == text:
            return data
    return texts.encode(replace(source or SourceText(""), text=text, encoding="utf-8"))


def _is_japanese(text: str) -> bool:
    """Japanese stands in rows; a letter with an accent stands among plain ones."""
    rows = re.findall(r"[^\x00-\x7f]+", text)
    if any("\ue000" <= character <= "\uf8ff" for row in rows for character in row):
        return False  # of nobody's language
    return 2 * sum(len(row) for row in rows if len(row) > 1) > sum(map(len, rows))


def _round_trips(data: bytes, encoding: str) -> bool:
    try:
        return data.decode(encoding).encode(encoding) == data
    except UnicodeError:
        return False
