"""Sections of an emitted text, which a template of programs puts in its frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

Numbering = Callable[[Sequence[str]], list[str]]
"""Gives the lines of a text their step numbers."""


@dataclass(frozen=True, slots=True)
class Outline:
    """Sections of the text of a new program, and the lines that a template may write around them.

    template: its file in `templates/`. sections: divides a text into sections by name; together
    they are all of the text except the frame. within: sections that are parts of other sections:
    the name of that section, and the function that takes the part from its text. name: returns the
    name of the program from its text. frame: patterns of lines that a template writes beside
    comments, by name, with `{name}` for the name of the program. rank: order of sections and frame
    lines; those of one rank may change places. complete: alternatives; a template has each section
    and frame line of one of them exactly once. item: true for a comment that readers take for a
    statement about the program. numbered: returns the step numbering of a dialect, None for a
    dialect without numbers. blank: true if a text may have blank lines. ends: the section after
    which a template writes no comments, empty for none.
    """

    template: str
    sections: Callable[[str], Mapping[str, str]]
    within: Mapping[str, tuple[str, Callable[[str], str]]]
    name: Callable[[str], str]
    rank: Mapping[str, int]
    complete: tuple[tuple[str, ...], ...]
    item: Callable[[str], bool]
    frame: Mapping[str, str]
    numbered: Callable[[str], Numbering | None]
    blank: bool
    ends: str = ""
