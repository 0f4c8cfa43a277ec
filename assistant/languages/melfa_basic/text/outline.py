"""Sections of an emitted program: heading, code and positions."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Final

from assistant.languages.language_types import Numbering, Outline
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, Dialect
from assistant.languages.melfa_basic.text.header import END, MARK

_HEADING: Final = re.compile(rf"(?:(?:[0-9]+ )?'.*\n)*?(?:[0-9]+ )?' {END}\r?\n")
_HEADER_LINE: Final = re.compile(rf"^(?:[0-9]+ )?' {MARK}melfa", re.MULTILINE)
_POSITIONS: Final = re.compile(r"^(?![0-9])", re.MULTILINE)
_STEP_NUMBER: Final = re.compile(r"[0-9]+ ")


def sections(text: str) -> Mapping[str, str]:
    """The comments of the heading, the code, and the values of positions below it."""
    heading = _HEADING.match(text)
    below = heading.end() if heading else 0
    positions = _POSITIONS.search(text, below)
    first = positions.start() if positions else len(text)
    return {"header": text[:below], "code": text[below:first], "positions": text[first:]}


def _header_offset(text: str) -> int:
    """Offset at which the heading begins, after the comments of the program."""
    mark = _HEADER_LINE.search(text)
    return mark.start() if mark else len(text)


def recounted_lines(dialect: Dialect, lines: Sequence[str]) -> list[str]:
    """The lines with steps counted anew: jumps of emitted programs name labels.

    A comment that has no number yet gets one; values of positions have none.
    """
    made, step = [], 0
    for line in lines:
        match = _STEP_NUMBER.match(line)
        if match is None and not line.startswith("'"):
            made.append(line)
            continue
        step += dialect.step
        made.append(f"{step} {line[match.end() :] if match else line}")
    return made


def _step_numbering(name: str) -> Numbering | None:
    return partial(recounted_lines, DIALECTS[name])


OUTLINE: Final = Outline(
    template="melfa/program.prg.j2",
    sections=sections,
    within={
        "comments": ("header", lambda text: text[: _header_offset(text)]),
        "heading": ("header", lambda text: text[_header_offset(text) :]),
    },
    name=lambda _: "",
    rank={"comments": 0, "header": 1, "heading": 1, "code": 2, "positions": 3},
    complete=(("header", "code", "positions"), ("comments", "heading", "code", "positions")),
    item=lambda text: text.strip().startswith(MARK.strip()),
    frame={},
    numbered=_step_numbering,
    blank=False,
    ends="header",
)
