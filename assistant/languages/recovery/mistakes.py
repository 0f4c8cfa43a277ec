"""A row of a table of usual mistakes, and how a damaged place is told to be one."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from assistant.languages.recovery.broken import Broken, Repair


@dataclass(frozen=True, slots=True)
class Mistake:
    """A row of the table.

    examples: statements, items or whole files with `¦` at the place that a finding must show.
    before: regular expression for what ends at the error, or with `block` stands anywhere from
    the begin of the open block on; its group `at`, if it has one, is the place.
    after: for what begins at the error. repair: for the kind and the word of the change that
    mends it, `insert SEMICOLON`. shown: for what begins at the place that the change shows.
    here: the place is the word that does not fit.
    """

    cure: str
    examples: tuple[str, ...]
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
            pattern = self.before if self.within == "block" else rf"(?:{self.before})\s*\Z"
            found = re.compile(pattern, _FLAGS).search(text[begin:error])
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


_FLAGS: Final = re.IGNORECASE
