"""What a language with a statement a line says of itself so that damaged lines are read."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol

from assistant.languages.lalr import Tables
from assistant.languages.recovery.lexemes import Lexeme
from assistant.languages.recovery.mistakes import Slip
from assistant.languages.recovery.wording import listed
from assistant.program.diagnostics import Rule


class Drive(Protocol):
    """Reads a line between two offsets by a rule of the grammar: what nodes make of it, or a Stop.

    words: takes those that were read. Raises ValueError for a number that is too large.
    """

    def __call__(
        self, text: str, at: int, end: int, start: str, nodes: Any, words: list[Lexeme] | None
    ) -> Any: ...


class Missing(NamedTuple):
    """What is put in for a terminal: its text, what is said, the cure and the cost."""

    text: str
    what: str
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
    names. code: offsets of the code of a line, and the rule of the grammar that it is; line: the
    rule of a statement. item: what a line that was read is in a file. mistakes: the usual ones.
    foreign: words of other languages in lower case → what to write, and the cure. branch: what a
    statement may begin behind, inside of a line. keywords: words in upper case → the terminals
    that they may be. words: those that a misspelt one may have been. spelled: a word as it is
    written. begins: whether a word begins a statement. parted: where a blank is missing in a word,
    None for nowhere. is_whole: whether something is a statement. prose: a line that is plain words,
    the first of them its group. missing: what is put in. phrases: what terminals are called;
    unsaid: those that are not said where another one fits. wrong: rule with `what` and `cure`.
    most_words: of a line.
    """

    title: str
    comment: str
    comments: Set[str]
    names: Set[str]
    drive: Drive
    code: Callable[[str], tuple[int, int, str]]
    line: str
    tables: Callable[[str], Tables]
    nodes: Any
    item: Callable[[Any, str], Any]
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
    most_words: int

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
        return "" if len(said) > MOST_SAID else listed(said)
