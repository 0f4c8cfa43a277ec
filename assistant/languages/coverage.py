"""Coverage of a vendor program by the pseudo-program, construct by construct.

A construct that the pseudo-program can express is supported; a statement with an expression that
only the vendor language can express is partial; the rest is kept verbatim, so that it is written
back but cannot be translated.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any, Final, Literal

from assistant.base.data_classes import dataclass
from assistant.languages.language import Language
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Program
from assistant.program.rewriting import head, records

_Level = Literal["supported", "partial", "verbatim"]

_LEVELS: Final[tuple[_Level, ...]] = ("supported", "partial", "verbatim")


@dataclass(frozen=True, slots=True)
class Construct:
    """Count of a construct at each level. name: as the vendor language spells it."""

    name: str
    supported: int = 0
    partial: int = 0
    verbatim: int = 0

    @property
    def count(self) -> int:
        return self.supported + self.partial + self.verbatim


def coverage(language: Language[Any], trees: Sequence[Any]) -> tuple[Construct, ...]:
    """Count the constructs of some trees, the most frequent first.

    Each tree is counted separately; none has syntax errors.
    """
    return total([map(_one, _constructs(language, tree)) for tree in trees])


def total(tables: Iterable[Iterable[Construct]]) -> tuple[Construct, ...]:
    """Several tables as one; names differ by more than case."""
    found: dict[str, Construct] = {}
    for one in chain.from_iterable(tables):
        row = found.get(one.name.lower(), Construct(one.name))
        counts = {level: getattr(row, level) + getattr(one, level) for level in _LEVELS}
        found[one.name.lower()] = replace(row, **counts)
    return tuple(sorted(found.values(), key=lambda c: (-c.count, c.name.lower())))


def _one(found: tuple[str, _Level, int]) -> Construct:
    name, level, count = found
    supported, partial, verbatim = (count if level == one else 0 for one in _LEVELS)
    return Construct(name, supported, partial, verbatim)


def _constructs(language: Language[Any], tree: Any) -> Iterator[tuple[str, _Level, int]]:
    program = language.lift(tree)
    text = language.render(tree)
    for statement in program.statements():
        count = len(statement.path) if isinstance(statement, p.Follow) else 1
        yield _name(language, statement, text), _level(statement), count
    for name, table in _tables(program):
        if table:
            yield name, "supported", len(table)
    for procedure in program.procedures:
        yield "routine", "supported", 1
        yield from (("variable", "supported", 1) for _ in procedure.variables)
    for declaration in program.declarations:
        yield _kept(language, declaration.text), "verbatim", 1


def _tables(program: Program) -> Iterator[tuple[str, Any]]:
    yield "tool", program.tools
    yield "frame", program.frames
    yield "speed", program.speeds
    yield "blend", program.blends
    yield "target", program.targets
    yield "joint target", program.joint_targets
    yield "variable", program.variables


_NAMED: Final[dict[type, str]] = {
    p.Assign: "assignment",
    p.Comment: "comment",
    p.Label: "label",
    p.Call: "call of an own routine",
}
"""Constructs that do not begin with a word of the language."""

_WORD: Final = re.compile(r"\s*(?:\d+\s+)?([A-Za-z_]\w*)")


def _name(language: Language[Any], statement: p.Statement, text: str) -> str:
    named = _NAMED.get(type(statement))
    if named is not None:
        return named
    if isinstance(statement, p.Opaque):
        return _kept(language, statement.text)
    span = statement.span
    # A step number may stand before the first word.
    word = _WORD.match(text, span.start, span.end) if span is not None else None
    return word[1] if word else type(statement).__name__


def _kept(language: Language[Any], text: str) -> str:
    return language.declares(text) or _first_words(text)


_ASSIGNED: Final = re.compile(r"[A-Za-z_]\w*[%!#&$]?(?:[({.][^=]*[)}\w])?\s*:?=(?!=)")
_CALLED: Final = re.compile(r"[A-Za-z_]\w*\s*\(.*\)\s*;?", re.DOTALL)
_MARKED: Final = re.compile(r"\*[A-Za-z_]\w*|[A-Za-z_]\w*:(?!=)")


def _first_words(text: str) -> str:
    """Return the construct of a verbatim text, by its first word."""
    for form, name in ((_ASSIGNED, "assignment"), (_MARKED, "label")):
        if form.match(text):
            return name
    if _CALLED.fullmatch(text):
        return _NAMED[p.Call]
    word = re.search(r"[A-Za-z_]\w*|[^\sA-Za-z_]", text[:80])
    return word[0] if word else "nothing"


def _level(statement: p.Statement) -> _Level:
    if isinstance(statement, p.Opaque):
        return "verbatim"
    return "partial" if _holds_verbatim(statement) else "supported"


def _holds_verbatim(statement: p.Statement) -> bool:
    """True if one of the statement's own expressions is verbatim; its bodies have their own."""
    return any(isinstance(part, e.Verbatim) for part in records(head(statement)))
