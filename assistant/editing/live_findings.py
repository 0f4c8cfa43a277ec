"""Findings of a text while it is typed: of changed parts at once, of the complete program later.

Three states of a text are known: `base`, at which the complete program was last checked; `last`,
the last state without syntax errors; and the text now. The findings that an excerpt of `base` has
more or fewer than the complete program, an excerpt of the text has too: they come from rules that
look at the complete program. A damaged line is read as it was in `last` for everything that
concerns other lines.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.editing.excerpts import Excerpt, Structure, declarations, excerpt, structure
from assistant.editing.text_lines import (
    Hunk,
    LineMoves,
    Lines,
    hunks,
    moved_findings,
    reverted_lines,
)
from assistant.program.editor_support import CachedLineFacts, LineFacts

Quick = Callable[[Excerpt], tuple[Sequence[Diagnostic], Sequence[Diagnostic]]]
"""Check of an excerpt: syntax errors, and all findings."""
Whole = Callable[[str], Sequence[Diagnostic]]
SMALL: Final = 300
"""Lines of a text that is always looked at as a whole by the quick look."""


class State:
    """A text, and the facts of each of its lines."""

    def __init__(self, text: str, remembered: CachedLineFacts, before: State | None = None) -> None:
        """before: another state of the text; what did not change is taken from there."""
        self.text = text
        self.lines = Lines(text)
        self.said = self.lines.lines
        self._remembered = remembered
        self._before = before

    @cached_property
    def facts(self) -> list[LineFacts]:
        before = self._before  # once: another thread may let go of it
        if before is None:
            return self._remembered.all(self.said)
        facts = before.facts.copy()
        for hunk in reversed(hunks(before.said, self.said)):
            new = self.said[hunk.new_first : hunk.new_last]
            facts[hunk.first : hunk.last] = self._remembered.all(new)
        return facts

    @cached_property
    def made_of(self) -> Structure:
        before, facts, borders = self._before, self.facts, frozenset[int]()
        if before is not None:
            moves = LineMoves(hunks(before.said, self.said))
            ends = (moves.line(piece.last) for piece in before.made_of.pieces)
            borders = frozenset(line for line in ends if line is not None)
            self._before = None  # what stood before that one is of no use any more
        return structure(facts, self._remembered.language.folded, borders)

    def prepare(self) -> None:
        """Looks at all lines, so that no key has to wait for that."""
        assert self.made_of is not None

    def excerpt(self, changed: Iterable[int], names: frozenset[str] = frozenset()) -> Excerpt:
        if len(self.said) <= SMALL:
            return self.all
        starts = self.lines.starts
        return excerpt(self.text, starts, self.facts, self.made_of, changed, names)

    @property
    def all(self) -> Excerpt:
        return Excerpt(self.text, self.text, None, frozenset(range(len(self.said))), self.names)

    @cached_property
    def names(self) -> frozenset[str]:
        return frozenset().union(*(one.names for one in self.facts))


@dataclass(frozen=True, slots=True)
class Shown:
    """A state with its findings."""

    state: State
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Unseen:
    """A text whose complete program is still to be checked. last: the last text without damage,
    with its findings.

    known: the text of the last complete check.
    """

    text: str
    last: tuple[str, tuple[Diagnostic, ...]] | None
    known: str | None


@dataclass(frozen=True, slots=True)
class Seen:
    """Return the checked text without its damage; None if that was known already."""

    text: str | None
    findings: tuple[Diagnostic, ...] = ()


class Watch:
    """One text that is typed."""

    def __init__(self, remembered: CachedLineFacts, quick: Quick, whole: Whole) -> None:
        self._remembered, self._quick, self._whole = remembered, quick, whole
        self._base: Shown | None = None
        self._last: Shown | None = None
        self._differences: dict[frozenset[int], _Difference] = {}
        self.current: State | None = None

    def state(self, text: str) -> State:
        if self.current is None or self.current.text != text:
            self.current = self._state(text)
        return self.current

    def findings(self, text: str) -> tuple[Diagnostic, ...]:
        """Return the present findings; check the complete program if that was never done."""
        if self._base is None:
            return self.settled(text)
        return self._now(self.state(text))

    def tried(self, text: str) -> tuple[Diagnostic, ...]:
        """Return the findings that another text would have; nothing is remembered."""
        return self._looked(self._state(text))[0]

    @property
    def is_known(self) -> bool:
        """True if the complete program was checked, possibly in another state."""
        return self._base is not None

    def state_of(self, text: str) -> State:
        """A state of a text, the present one where that has it."""
        current = self.current
        return current if current is not None and current.text == text else self._state(text)

    def unseen(self, text: str) -> Unseen | None:
        """Return the program to check for a text, None if that was done."""
        base, last = self._base, self._last
        known = None if base is None else base.state.text
        if known == text:
            return None
        return Unseen(text, None if last is None else (last.state.text, last.findings), known)

    def look(self, unseen: Unseen) -> Seen:
        """Looks at the whole, for a watch of this text elsewhere."""
        state = self._state(unseen.text)
        if unseen.last is not None:
            text, findings = unseen.last
            state = self._mended(state, Shown(self._state(text), findings))
        if state.text == unseen.known:
            return Seen(None)
        return Seen(state.text, tuple(self._whole(state.text)))

    def settle(self, state: State, findings: Sequence[Diagnostic], at: Shown | None) -> None:
        """Takes what was found in a whole. at: the last sound state when that was begun."""
        self._base, self._differences = Shown(state, tuple(map(_placed, findings))), {}
        if self._last is None or self._last is at:
            self._last = self._base

    @property
    def last(self) -> Shown | None:
        """The last sound state."""
        return self._last

    def settled(self, text: str) -> tuple[Diagnostic, ...]:
        """Return the findings of the complete program."""
        unseen = self.unseen(text)
        seen = Seen(None) if unseen is None else self.look(unseen)
        if seen.text is not None:
            self.settle(self.state_of(seen.text), seen.findings, self._last)
        return self._now(self.state(text))

    def is_settled(self, text: str) -> bool:
        """True if the findings of a text come from a check of the complete program."""
        if self._base is None or self._last is None:
            return False
        sound = (self._base.state.text, self._last.state.text)
        return text == sound[0] or sound[0] == sound[1] != text

    def forget(self) -> None:
        """Something else changed that matters to the findings."""
        self._base, self._differences = None, {}

    def _now(self, state: State) -> tuple[Diagnostic, ...]:
        base, last = self._base, self._last
        assert base is not None and last is not None
        if state.text == base.state.text:
            self._last = base
            return base.findings
        found, damage = self._looked(state)
        if not damage:
            self._last = Shown(state, found)
            return found
        mended = self._without(state, last, damage)
        if mended.text != last.state.text:
            found_there, still = self._looked(mended)
            if not still:
                self._last = last = Shown(mended, found_there)
        return _in_order(self._damaged(state, last, found, damage))

    def _damaged(
        self,
        state: State,
        last: Shown,
        found: Sequence[Diagnostic],
        damage: Sequence[Diagnostic],
    ) -> Iterator[Diagnostic]:
        """Sound lines have what they had; others what is found, the damage on them first."""
        differing = hunks(last.state.said, state.said)
        moves = LineMoves(differing)
        yield from moved_findings(last.findings, moves)
        marked = set(map(_key, damage))
        for finding in found:
            line = None if finding.line is None else finding.line - 1
            changed = line is not None and moves.back(line) is None
            if _key(finding) in marked:
                yield finding if changed else _at_change(finding, differing, state)
            elif changed:
                yield finding

    def _looked(self, state: State) -> tuple[tuple[Diagnostic, ...], list[Diagnostic]]:
        """Findings by an excerpt, and the damage that was not there at the last sound state."""
        base, last = self._base, self._last
        assert base is not None and last is not None
        differing = hunks(base.state.said, state.said)
        if not differing:
            return base.findings, []
        moves = LineMoves(differing)
        part = state.excerpt(_changed(differing, state), _redeclared(differing, base.state, state))
        syntax, every = self._quick(part)
        difference = self._difference(base, moves, differing, part.looked_at)
        found = [
            _placed(one)
            for one in every
            if one.line is not None
            and one.line - 1 in part.looked_at
            and _what(one) not in difference.more
        ]
        for one in moved_findings(base.findings, moves):
            line = None if one.line is None else one.line - 1
            if line not in part.looked_at or (_what(one), moves.back(line)) in difference.less:
                found.append(one)
        known = {_what(one) for one in last.findings}
        damage = [_placed(one) for one in syntax if _what(one) not in known]
        return _in_order(found), damage

    def _difference(
        self, base: Shown, moves: LineMoves, differing: Sequence[Hunk], looked_at: frozenset[int]
    ) -> _Difference:
        """Return the findings that the excerpt of `base` with the same lines shows more and less
        than the complete text.
        """
        old = {line for new in looked_at if (line := moves.back(new)) is not None}
        old |= {line for hunk in differing for line in range(hunk.first, hunk.last)}
        key = frozenset(old)
        if key not in self._differences:
            part = base.state.excerpt(old)
            _, every = self._quick(part)
            self._differences[key] = _compared(base.findings, every, part.looked_at)
        return self._differences[key]

    def _mended(self, state: State, last: Shown) -> State:
        """The text as it is to be looked at as a whole."""
        syntax, _ = self._quick(Excerpt(state.text, state.text, None, frozenset(), frozenset()))
        known = {_what(one) for one in last.findings}
        damage = [one for one in syntax if _what(one) not in known]
        return state if not damage else self._without(state, last, damage)

    def _without(self, state: State, last: Shown, damage: Sequence[Diagnostic]) -> State:
        """The text with damaged changes as they were at the last sound state."""
        before, now = last.state.said, state.said
        differing = hunks(before, now)
        lines = {one.line - 1 for one in damage if one.line is not None}
        lines |= {one.end_line - 1 for one in damage if one.end_line is not None}
        hurt = [h for h in differing if any(h.new_first - 1 <= x <= h.new_last for x in lines)]
        if not hurt or len(hurt) == len(differing):
            return last.state
        end = "\r\n" if "\r\n" in state.text else "\n"
        return self._state(end.join(reverted_lines(before, now, hurt)))

    def _state(self, text: str) -> State:
        return State(text, self._remembered, None if self._base is None else self._base.state)


@dataclass(frozen=True, slots=True)
class _Difference:
    """more: code and message. less: the same, and the line in the base."""

    more: frozenset[tuple[str, str]]
    less: frozenset[tuple[tuple[str, str], int | None]]


def _compared(
    whole: Sequence[Diagnostic], part: Sequence[Diagnostic], looked_at: frozenset[int]
) -> _Difference:
    shown = [one for one in part if one.line is not None and one.line - 1 in looked_at]
    there = {_what(one) for one in whole if (one.line or 0) - 1 in looked_at}
    seen = {(_what(one), None if one.line is None else one.line - 1) for one in shown}
    less = {(_what(one), None if one.line is None else one.line - 1) for one in whole} - seen
    return _Difference(
        frozenset(_what(one) for one in shown if _what(one) not in there), frozenset(less)
    )


def _placed(finding: Diagnostic) -> Diagnostic:
    """A finding by its line and column alone: offsets in an excerpt are others."""
    return finding if finding.line is None else replace(finding, span=None)


def _what(finding: Diagnostic) -> tuple[str, str]:
    return finding.code, finding.message


def _key(finding: Diagnostic) -> tuple[str, str, int | None, int | None]:
    return finding.code, finding.message, finding.line, finding.column


def _in_order(findings: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    once = dict.fromkeys(findings)
    return tuple(sorted(once, key=lambda one: (one.line or 0, one.column or 0)))


def _changed(differing: Sequence[Hunk], state: State) -> set[int]:
    """Lines that are new, and those beside a place where lines are gone."""
    lines: set[int] = set()
    for hunk in differing:
        lines.update(range(hunk.new_first, hunk.new_last))
        if hunk.new_first == hunk.new_last:
            lines.update((hunk.new_first - 1, hunk.new_first))
    return {line for line in lines if 0 <= line < len(state.said)}


def _redeclared(differing: Sequence[Hunk], before: State, now: State) -> frozenset[str]:
    """Names that are declared otherwise than before, or no longer."""
    old = {
        (one.name, one.kind, one.detail, one.scope)
        for hunk in differing
        for _, one in declarations(before.facts[hunk.first : hunk.last])
        if not one.implied
    }
    new = {
        (one.name, one.kind, one.detail, one.scope)
        for hunk in differing
        for _, one in declarations(now.facts[hunk.new_first : hunk.new_last])
        if not one.implied
    }
    folded = now._remembered.language.folded
    return frozenset(folded(name) for name, *_ in old ^ new)


def _at_change(finding: Diagnostic, differing: Sequence[Hunk], state: State) -> Diagnostic:
    """Move damage reported on an unchanged line to the change before it."""
    line = (finding.line or 1) - 1
    before = [hunk for hunk in differing if hunk.new_first <= line]
    hunk = max(before, key=lambda one: one.new_first, default=differing[0])
    at = max(min(hunk.new_last - 1, len(state.said) - 1), 0)
    text = state.said[at]
    start = len(text) - len(text.lstrip())
    end = max(len(text.rstrip()), start + 1)
    return replace(
        finding,
        line=at + 1,
        end_line=at + 1,
        column=start + 1,
        end_column=end + 1,
        excerpt=text,
        span=None,
    )
