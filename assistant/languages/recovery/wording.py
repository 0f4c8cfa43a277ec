"""Syntax errors in the words of the person who has to fix them.

A table of usual mistakes goes first: each row shows the mistake in small broken programs and says
the cure. What fits no row gets the cure of the change that mended it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Final

from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.base.source_text import SourceText
from assistant.languages.recovery.broken import Broken, Repair
from assistant.languages.recovery.mistakes import Mistake

LONGEST_SHOWN: Final = 30
MOST_SHOWN: Final = 6
"""Things that are listed as what could stand at a place."""
_OUTSIDE: Final = frozenset({"delete", "double", "swap", "hole", "strange", "string"})
"""Kinds of repairs that on the level of the file say that there is no unit."""


@dataclass(frozen=True, slots=True)
class TerminalGroup:
    """Terminals that are named as one thing where all of them fit.

    said: its name. also: what is not named beside it. rest: of what is named beside it, if
    nothing else is.
    """

    terminals: Set[str]
    said: str
    also: Set[str] = frozenset()
    rest: Callable[[str], bool] | None = None


@dataclass(frozen=True, slots=True)
class Wording:
    """names: terminals as people call them; the rest are words written as they are. unsaid: those
    that are never named. kinds: what is named as one thing. operators: named as one where more
    than `few` fit. cures: kind of repair → the cure that goes without saying more. wrong: rule
    with `found`, `expected` and `hint`; missing: with `what` and `hint`; many: with `most`.
    """

    names: Mapping[str, str]
    unsaid: Set[str]
    kinds: Sequence[TerminalGroup]
    operators: Set[str]
    cures: Mapping[str, str]
    mistakes: Sequence[Mistake]
    wrong: Rule
    missing: Rule
    many: Rule
    few: int = 3

    def finding(self, source: SourceText, broken: Broken, repair: Repair) -> Diagnostic:
        """What is wrong at a damaged place, and the cure."""
        start, end = repair.start, repair.end
        hint = ""
        for mistake in self.mistakes:
            moved = mistake.place(broken, repair)
            if moved is not None:
                hint = mistake.cure
                if moved >= 0:
                    start, end = moved, max(end, moved)
                break
        kind = "outside" if broken.at_file_level and repair.kind in _OUTSIDE else repair.kind
        types = repair.what.split()
        if types == ["NAME"] and "NUMBER" in broken.accepted():
            types = [broken.syntax.value]
        brackets = types == ["LPAR", "RPAR"]
        named = "`()`" if brackets else " and ".join(self.name(type) for type in types)
        verb = "are" if len(types) > 1 and not brackets else "is"
        if repair.kind == "insert":
            cure = f"write {named} here"
        elif repair.kind == "close":
            cure = "close what was opened: " + _opened(source, broken, types)
        else:
            of_repair = repair.kind in ("replace", "join")
            return source.finding(
                self.wrong,
                Span(start, max(end, start)),
                found=found_text(broken.text[repair.start : repair.end]),
                expected=named if of_repair else self.expected(broken.accepted()),
                hint=hint or self.cures.get(kind) or f"write {named}",
            )
        span = Span(start, end)
        return source.finding(self.missing, span, what=f"{named} {verb}", hint=hint or cure)

    def name(self, terminal: str) -> str:
        return self.names.get(terminal, f"`{terminal.lstrip('_')}`")

    def expected(self, terminals: Set[str]) -> str:
        """What could stand there, the kinds of things named once."""
        rest = set(terminals) - self.unsaid
        said = []
        for kind in self.kinds:
            if rest >= kind.terminals:
                said.append(kind.said)
                rest -= kind.terminals | kind.also
                if kind.rest is not None:
                    rest = set(filter(kind.rest, rest))
        if len(rest & self.operators) > self.few:
            said.append("an operator")
            rest -= self.operators
        said += sorted(map(self.name, rest))
        if len(said) > MOST_SHOWN:
            said = [*said[:MOST_SHOWN], "…"]
        return or_list(said) or "nothing more"


def or_list(things: Sequence[str]) -> str:
    """Things in words: `a, b or c`."""
    *most, last = things or ("",)
    return f"{', '.join(most)} or {last}" if most else last


def found_text(text: str) -> str:
    """What stands at a place, in words."""
    if text.strip(" \t\r\n") and (not text.strip() or not text[0].isprintable()):
        return f"the character U+{ord(text[0]):04X}"
    text = " ".join(text.split())
    if len(text) > LONGEST_SHOWN:
        text = text[:LONGEST_SHOWN] + "…"
    return f"`{text}`" if text else "the end of the text"


def _opened(source: SourceText, broken: Broken, ends: list[str]) -> str:
    openers = [opener for opener in broken.openers() if opener[1] >= 0][-len(ends) :]
    closing = broken.syntax.blocks.ends
    return ", ".join(
        f"{type.lstrip('_')} of line {source.line_column(begin)[0]} with {closing[type][1:]}"
        for type, begin in reversed(openers)
    )
