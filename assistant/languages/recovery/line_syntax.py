"""What a language with a statement a line says of itself so that damaged lines are read."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from assistant.base.diagnostics import Rule
from assistant.languages.line_grammar import LineGrammar
from assistant.languages.nodes import Nodes
from assistant.languages.recovery.mistakes import Slip
from assistant.languages.recovery.wording import or_list


class Missing(NamedTuple):
    """What is put in for a terminal: its text, what it is called, the cure and the cost."""

    text: str
    named: str
    cure: str
    cost: int


class Phrase(NamedTuple):
    """What terminals are called, once for all of them. unless: said of others already."""

    terminals: Set[str]
    said: str
    unless: Set[str] = frozenset()


MOST_SAID: Final = 4
"""Things that are listed as what could stand at a place."""


@dataclass(frozen=True, slots=True)
class LineSyntax:
    """A language with a statement a line.

    title: what it is called. comment: mark of one; comments: their terminals. names: terminals of
    names. parts: number of a line between two offsets, offset of its code, and the rule of the
    grammar that this is; line: the rule of a statement. nodes: of a line, from an offset in it to
    one in the source. item: what a line that was read is with its number. mistakes: the usual ones.
    foreign: words of other languages in lower case → what to write, and the cure. branch: what a
    statement may begin behind, inside of a line. keywords: words in upper case → the terminals
    that they may be. words: those that a misspelt one may have been. spelled: a word as it is
    written. begins: whether a word begins a statement. parted: where a blank is missing in a word,
    None for nowhere. is_whole: whether something is a statement. prose: a line that is plain words,
    the first of them its group. missing: what is put in. phrases: what terminals are called;
    unsaid: those that are not said where another one fits. wrong: rule with `what` and `cure`.
    """

    title: str
    comment: str
    comments: Set[str]
    names: Set[str]
    grammar: LineGrammar
    parts: Callable[[str, int, int], tuple[int | None, int, str]]
    line: str
    nodes: Callable[[Callable[[int], int] | None], Nodes]
    item: Callable[[Any, int | None], Any]
    mistakes: Sequence[Slip]
    foreign: Mapping[str, tuple[str, str]]
    branch: re.Pattern[str]
    keywords: Mapping[str, tuple[str, ...]]
    words: Sequence[str]
    spelled: Callable[[str], str]
    begins: Callable[[str], bool]
    parted: Callable[[str], int | None]
    is_whole: Callable[[Any], bool]
    prose: re.Pattern[str]
    missing: Mapping[str, Missing]
    phrases: Sequence[Phrase]
    unsaid: Mapping[str, Set[str]]
    wrong: Rule

    def expected(self, terminals: Collection[str]) -> str:
        """What may follow, empty where nothing has a name or too much has."""
        fitting = set(terminals)
        for terminal, others in self.unsaid.items():
            if terminal in fitting:
                fitting -= others
        said: list[str] = []
        for phrase in self.phrases:
            if phrase.terminals & fitting and not phrase.unless & set(said):
                said.append(phrase.said)
        return "" if len(said) > MOST_SAID else or_list(said)
