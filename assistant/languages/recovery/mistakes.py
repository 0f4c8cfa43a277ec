"""Messages of syntax errors: tables of usual mistakes, and words for the rest.

Each row of a table shows a mistake in small broken programs and states its cure: `Mistake` for
statements that a repair of words has mended, `Slip` for lines, which it mends itself by an `Edit`.
An error that fits no row gets the cure of the change that mended it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence, Set
from typing import Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.base.source_text import SourceText
from assistant.languages.recovery.repairs import Broken, Repair


@dataclass(frozen=True, slots=True)
class Edit:
    """A change that may turn a line into one of the language, and the words of its finding.

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
        """Return the offset where the text that `before` searches begins."""
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
    """Match a pattern at the end of a text."""
    return re.compile(rf"(?:{before})\Z", _FLAGS).search(text)


_LONGEST_SHOWN: Final = 30
_MOST_SHOWN: Final = 6
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
        """Return the finding at a damaged place, with its cure."""
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
        # If a number fits as well as a name, any value does.
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
                found=_found_text(broken.text[repair.start : repair.end]),
                expected=named if of_repair else self.expected(broken.accepted()),
                hint=hint or self.cures.get(kind) or f"write {named}",
            )
        span = Span(start, end)
        return source.finding(self.missing, span, what=f"{named} {verb}", hint=hint or cure)

    def name(self, terminal: str) -> str:
        return self.names.get(terminal, f"`{terminal.lstrip('_')}`")

    def expected(self, terminals: Set[str]) -> str:
        """Return what may be at the place, in words; each kind of terminal is named once."""
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
        if len(said) > _MOST_SHOWN:
            said = [*said[:_MOST_SHOWN], "…"]
        return or_list(said) or "nothing more"


def or_list(things: Sequence[str]) -> str:
    """Things in words: `a, b or c`."""
    *most, last = things or ("",)
    return f"{', '.join(most)} or {last}" if most else last


def _found_text(text: str) -> str:
    """Return the text at a place, in words."""
    if text.strip(" \t\r\n") and (not text.strip() or not text[0].isprintable()):
        return f"the character U+{ord(text[0]):04X}"
    text = " ".join(text.split())
    if len(text) > _LONGEST_SHOWN:
        text = text[:_LONGEST_SHOWN] + "…"
    return f"`{text}`" if text else "the end of the text"


def _opened(source: SourceText, broken: Broken, ends: list[str]) -> str:
    openers = [opener for opener in broken.openers() if opener[1] >= 0][-len(ends) :]
    closing = broken.syntax.blocks.ends
    return ", ".join(
        f"{type.lstrip('_')} of line {source.line_column(begin)[0]} with {closing[type][1:]}"
        for type, begin in reversed(openers)
    )
