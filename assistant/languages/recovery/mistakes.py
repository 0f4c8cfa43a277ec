"""Rows of the tables of usual mistakes, and how a damaged place is told to be one.

`Mistake` for statements that a repair of words has mended, `Slip` for lines, which it mends itself.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.diagnostics import Rule
from assistant.languages.recovery.edits import Edit

if TYPE_CHECKING:
    from assistant.languages.recovery.broken import Broken, Repair


@dataclass(frozen=True, slots=True)
class Mistake:
    """A row of the table.

    example: a statement, an item or a file, `¦` at the place that a finding must show.
    before: regular expression for what ends at the error, or with `block` stands anywhere from
    the begin of the open block on; its group `at`, if it has one, is the place.
    after: for what begins at the error. repair: for the kind and the word of the change that
    mends it, `insert SEMICOLON`. shown: for what begins at the place that the change shows.
    here: the place is the word that does not fit.
    """

    cure: str
    example: str
    before: str = ""
    after: str = ""
    repair: str = ""
    shown: str = ""
    within: Literal["statement", "line", "block"] = "statement"
    here: bool = False

    def place(self, broken: Broken, repair: Repair) -> int | None:
        """Offset to show, -1 for that of the repair; None if it is another mistake."""
        text, error = broken.text, broken.word.start
        if self.repair and not re.fullmatch(self.repair, f"{repair.kind} {repair.what}".strip()):
            return None
        if self.shown and not re.compile(self.shown, _FLAGS).match(text, repair.start):
            return None
        if self.after and not re.compile(self.after, _FLAGS).match(text, error):
            return None
        if self.before:
            begin = self._begin(broken, repair)
            ahead = text[begin:error]
            if self.within == "block":
                found = re.compile(self.before, _FLAGS).search(ahead)
            else:
                found = _ending(rf"(?:{self.before})\s*", ahead)
            if found is None:
                return None
            if "at" in found.re.groupindex:
                return begin + found.start("at")
        return error if self.here else -1

    def _begin(self, broken: Broken, repair: Repair) -> int:
        """Where the text that `before` looks at begins."""
        if self.within == "line":
            end = broken.syntax.layout.code_end(broken.text, broken.word.start)
            return broken.text.rfind("\n", 0, end) + 1
        if self.within == "block":
            return broken.block if repair.kept is None else repair.kept.at
        return broken.words[0].start


@dataclass(frozen=True, slots=True)
class Slip:
    r"""A row of a table of usual mistakes in a line.

    what, cure: of the finding; `{0}` is what `at` matched, `{1}` its first group. example: a line,
    `¦` at the place that is shown. at: how the text from the error on begins. write: what stands
    in place of it while the line is read on. before: how the line up to the error ends, counted
    from the begin of its code on; with `back`, what it matched counts as the text from the error
    on, or its group `at`. rule: of the finding, None for the usual one.
    """

    what: str
    cure: str
    example: str
    at: str
    write: str
    before: str = ""
    back: bool = False
    rule: Rule | None = None

    def edit(self, text: str, start: int, error: int, cost: int) -> Edit | None:
        """What to put where, None if it is another mistake.

        start, error: offsets of the code's begin and of the word that does not fit.
        """
        begin = error
        if self.before:
            found = _ending(self.before, text[start:error])
            if found is None:
                return None
            if self.back:
                begin = start + found.start("at" if "at" in found.re.groupindex else 0)
        match = re.compile(self.at, _FLAGS).match(text, begin)
        if match is None:
            return None
        groups = (match[0].strip(), *(group or "" for group in match.groups()))
        what, cure = self.what.format(*groups), self.cure.format(*groups)
        write = match.expand(self.write)
        return Edit(match.start(), match.end(), write, what, cure, cost, self.rule)


_FLAGS: Final = re.IGNORECASE


def _ending(before: str, text: str) -> re.Match[str] | None:
    """What a text ends with."""
    return re.compile(rf"(?:{before})\Z", _FLAGS).search(text)
