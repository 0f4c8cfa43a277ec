"""Words of a text by one regular expression that is made of the terminals of a grammar."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field

from assistant.languages.grammar import Grammar
from assistant.languages.lalr import END, Rows, Word


def terminals_pattern(
    grammar: Grammar,
    frequent: Iterable[str] = (),
    before: Mapping[str, str] | None = None,
    behind: Mapping[str, str] | None = None,
    without: Set[str] = frozenset(),
) -> re.Pattern[str]:
    """The terminals of a grammar, each a group, in the order in which they are tried.

    frequent: terminals tried first. before, behind: other groups, tried before and behind the rest.
    """
    known = {name: grammar.terminals[name].regexp for name in grammar.order}
    first = {name: known[name] for name in frequent}
    rows = {**first, **(before or {}), **known, **(behind or {})}
    listed = (f"(?P<{name}>{regexp})" for name, regexp in rows.items() if name not in without)
    return re.compile("|".join(listed), re.MULTILINE)


@dataclass(frozen=True, slots=True)
class WordScanner:
    """Reads words for the tables of a grammar.

    scanner: has a group for each terminal and finds something at every place. ignored: terminals
    between words. noted: ignored where there is no room for them. made: patterns of some terminals.
    """

    grammar: Grammar
    scanner: re.Pattern[str]
    ignored: Set[str]
    noted: Set[str]
    made: dict[frozenset[str | None], re.Pattern[str]] = field(default_factory=dict)

    def sound(self, text: str, rows: Rows, states: list[int]) -> Iterator[Word]:
        """The words of a text that is thought to be sound.

        states: of the stack that they are read on.
        """
        ignored, noted = self.ignored, self.noted
        for match in self.scanner.finditer(text):
            type = match.lastgroup or ""
            if type in ignored or (type in noted and type not in rows[states[-1]]):
                continue
            yield type, match[0], match.start(), match.end()
        yield END, "", len(text), len(text)

    def fitting(self, text: str, at: int, rows: Rows, states: list[int]) -> Iterator[Word]:
        """The words behind an offset, each as what there is room for, if it can be read so."""
        while match := self.scanner.match(text, at):
            type = match.lastgroup or ""
            row = rows[states[-1]]
            at = match.end()
            if type in self.ignored or (type in self.noted and type not in row):
                continue
            if type not in row and (fits := self._only(row).match(text, match.start())):
                match, type, at = fits, fits.lastgroup or "", fits.end()
            yield type, match[0], match.start(), at
        yield END, "", len(text), len(text)

    def _only(self, terminals: Iterable[str | None]) -> re.Pattern[str]:
        """Some terminals, in the order in which they are tried."""
        wanted = frozenset(terminals)
        if wanted not in self.made:
            others = frozenset(self.grammar.order) - wanted
            self.made[wanted] = terminals_pattern(
                self.grammar, without=others, behind={"NOTHING": r"(?!)"}
            )
        return self.made[wanted]
