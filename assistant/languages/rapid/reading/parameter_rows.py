"""Rows of system parameters, as the files `*.cfg` of a controller have them.

    EIO_SIGNAL:

          -Name "doGrip" -SignalType "DO" -Device "Board10" -DeviceMap "5"

An attribute is a word behind `-`, with its value in quotes, a number, or none; a line goes on
behind a backslash. Format: backups of RobotWare 5, 6 and 7.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

_SECTION: Final = re.compile(r"(?m)^([A-Z][A-Z0-9_]*):[ \t]*$")
_HEADER: Final = re.compile(r"\s*[A-Z]+:CFG")
_ATTRIBUTE: Final = re.compile(r'-([A-Za-z]\w*)(?:[ \t]+(?:"([^"\n]*)"|(-?[0-9.][0-9.eE+-]*)))?')


def rows_of(text: str, section: str) -> Iterator[dict[str, str]]:
    """The attributes of each row of a section; those without a value have an empty one."""
    for name, body in sections(text):
        if name == section:
            yield from _attribute_rows(body)


def sections(text: str) -> Iterator[tuple[str, str]]:
    """The sections of a file, each with its name and its text."""
    joined = text.replace("\r\n", "\n").replace("\\\n", " ")
    pieces = _SECTION.split(joined)
    yield from zip(pieces[1::2], pieces[2::2], strict=False)


def all_rows(text: str, prefix: str) -> Iterator[dict[str, str]]:
    """The rows of all sections whose names begin in a way."""
    for name, body in sections(text):
        if name.startswith(prefix):
            yield from _attribute_rows(body)


def is_known(text: str) -> bool:
    """Whether a text looks like a file of system parameters."""
    return _HEADER.match(text) is not None or next(sections(text), None) is not None


def _attribute_rows(body: str) -> Iterator[dict[str, str]]:
    for line in body.split("\n"):
        if line.lstrip().startswith("-"):
            found = _ATTRIBUTE.finditer(line)
            yield {one[1]: one[2] if one[2] is not None else one[3] or "" for one in found}
