"""Changes to the text of a line, and the table of usual mistakes that says them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from assistant.program.diagnostics import Rule


@dataclass(frozen=True, slots=True)
class Edit:
    """A change to a line that is to make it one of the language, and what to say about it.

    rule: of the finding, None for the usual one.
    """

    start: int
    end: int
    text: str
    what: str
    cure: str
    cost: int = 0
    rule: Rule | None = None

    def of(self, text: str) -> str:
        """A line with this change."""
        return text[: self.start] + self.text + text[self.end :]


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
            found = re.compile(rf"(?:{self.before})\Z", _FLAGS).search(text[start:error])
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
