"""Answers of a language for editors: the words of a line, and the names and blocks that it
declares, opens and ends.

All answers are about a single line, so that a change of one leaves the others valid.
`assistant/editing` combines them, for example to find the end of a procedure. The grammar of a
language remains the authority on what is correct.
"""

from __future__ import annotations

import abc
from collections.abc import Iterable, Mapping
from dataclasses import field
from functools import lru_cache
from typing import Any, Literal, NamedTuple

from assistant.base.data_classes import dataclass

WordKind = Literal[
    "comment", "keyword", "number", "string", "name", "operator", "label", "property"
]
DeclaredKind = Literal[
    "module", "program", "procedure", "function", "interrupt", "record", "type", "variable",
    "constant", "target", "parameter", "label", "step",
]  # fmt: skip
Scope = Literal["task", "file", "routine"]
"""Who sees a declaration: all files of the task, its own file, its own routine."""


class Word(NamedTuple):
    """A word of a line. start, end: characters from its begin."""

    kind: WordKind
    start: int
    end: int
    text: str


@dataclass(frozen=True, slots=True)
class Declaration:
    """A declaration in a line. start, end: its name in the line. detail: its type, or parameters.

    implied: True if its first use declares it; others are definite declarations. fixed: True if it
    never changes.
    """

    name: str
    kind: DeclaredKind
    start: int
    end: int
    scope: Scope = "file"
    detail: str = ""
    implied: bool = False
    fixed: bool = False


@dataclass(frozen=True, slots=True)
class LineFacts:
    """Facts of a single line.

    names: names that it uses or declares, as `folded`. begins, ends: a routine. opens: number of
    blocks it opens minus those it closes. stays: True if it holds the file together, even if other
    lines are left out. complete: True if the next line is another statement.
    """

    words: tuple[Word, ...] = ()
    names: frozenset[str] = frozenset()
    declares: tuple[Declaration, ...] = ()
    begins: bool = False
    ends: bool = False
    opens: int = 0
    stays: bool = False
    complete: bool = True


@dataclass(frozen=True, slots=True)
class KnownWord:
    """A word that every program of a language may use.

    sort: `keyword`, `type`, `instruction`, `function`, `variable` or `target`. detail: how it is
    written, in one line. about: what it does, in the neutral words of the pseudo-program, or else.
    """

    name: str
    sort: str
    detail: str = ""
    about: str = ""


class Editable(abc.ABC):
    """Answers of a language for editors."""

    mark: str
    """Begins a comment to the end of the line."""
    folds: bool = True
    """True if names that differ in case alone are the same."""
    brackets: tuple[tuple[str, str], ...] = (("(", ")"), ("[", "]"))
    blocks: tuple[tuple[str, str], ...] = ()
    """Words that open and close a block, for indentation; in lower case."""

    def folded(self, name: str) -> str:
        return name.lower() if self.folds else name

    @abc.abstractmethod
    def facts(self, line: str) -> LineFacts:
        """Return the facts of a single line; it accepts any text, including one that is not a
        program.
        """

    @abc.abstractmethod
    def known(self) -> Mapping[str, KnownWord]:
        """Words that mean something in every program, as `folded`."""

    @abc.abstractmethod
    def no_name(self, name: str, instead_of: str) -> str:
        """Why something cannot be called so, to be read behind "the name"; empty if it can."""

    def declarations(self, name: str) -> tuple[str, ...]:  # noqa: ARG002
        """Lines that declare a name as one kind of thing each; whichever fits is offered."""
        return ()

    declared_last: bool = False
    """True if such lines are at the end of a text, not in front of its routines."""

    def members(self, detail: str) -> Mapping[str, str]:  # noqa: ARG002
        """Parts of what was declared with that detail, each with its type."""
        return {}

    def options(self, name: str) -> Mapping[str, str]:  # noqa: ARG002
        """Optional arguments of an instruction or function, with what they take."""
        return {}

    def colours(self) -> Mapping[str, str]:
        """Return patterns of words recognised by their form, by their scopes in TextMate grammars.

        They are in the order in which they are tried; `known` lists the other words.
        """
        return {}


@dataclass(frozen=True, slots=True)
class CachedLineFacts:
    """Facts of lines that were asked before: most lines of a text stay as they are."""

    language: Editable
    _ask: Any = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_ask", lru_cache(maxsize=1 << 16)(self.language.facts))

    def all(self, lines: Iterable[str]) -> list[LineFacts]:
        return list(map(self._ask, lines))


def names_among(words: Iterable[Word], folded: Any) -> frozenset[str]:
    """The names among words, as a language folds them."""
    return frozenset(folded(word.text) for word in words if word.kind in ("name", "label"))
