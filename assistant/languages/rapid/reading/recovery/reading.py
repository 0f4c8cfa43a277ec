"""Reading on behind syntax errors: each is mended with the least change, and said once.

The grammar stays the authority. Every word is tried on the parser's stack before it is shifted;
where none fits, `repairs` proposes changes, and the one that lets the parser read on furthest is
made. What can be mended in no way becomes a placeholder, as the pendant writes them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, Final

from assistant.languages.lalr import END, NOWHERE, Stack, Word
from assistant.languages.rapid import rules
from assistant.languages.rapid.reading.driver import words
from assistant.languages.rapid.reading.files import with_line_feeds
from assistant.languages.rapid.reading.grammar import grammar
from assistant.languages.rapid.reading.nodes import Nodes
from assistant.languages.rapid.reading.recovery import wording
from assistant.languages.rapid.reading.recovery.broken import CLAUSES, Broken, HalfIf, Repair
from assistant.languages.rapid.reading.recovery.lexemes import lexemes
from assistant.languages.rapid.reading.recovery.repairs import best
from assistant.languages.rapid.reading.shortened import RunInTheWay, Shortened
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText

MOST_FINDINGS: Final = 50
FURTHER: Final = 24
"""Words behind an error that a repair is tried on."""
MOST_MENDS: Final = 2000
"""Repairs, the unsaid ones included, after which a file counts as damaged all over."""
ROUTINES: Final = frozenset({"_PROC", "_FUNC", "_TRAP"})
NOTED: Final = ROUTINES | {"_IF"}


def read_damaged(
    source: SourceText, short: Shortened, start: str, nodes: Nodes
) -> tuple[Any, tuple[Diagnostic, ...]] | RunInTheWay:
    """What `nodes` make of a damaged file, and what is wrong with it."""
    reading = _Reading(source, short, start, nodes)
    try:
        return reading.tree(), tuple(reading.findings)
    except _Way as way:
        return RunInTheWay(way.number)


class _Way(Exception):
    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number: Final = number


class _Reading:
    def __init__(self, source: SourceText, short: Shortened, start: str, nodes: Nodes) -> None:
        self.source, self.short = source, short
        self.text = with_line_feeds(source.text)
        self.findings: list[Diagnostic] = []
        self._tables = grammar().tables[start]
        self._stack = Stack(self._tables.first)
        self._nodes = nodes
        self._at = 0
        self._quiet_until = -1
        self._kept: list[HalfIf] = []

    def tree(self) -> Any:
        for _ in range(MOST_MENDS + 1):
            words = self._words()
            wrong = self._tables.drive(self._stack, words, self._nodes, careful=True)
            if wrong is None:
                return self._stack.values[0]
            self._mend(wrong)
        return self._nodes.start(None, [None])  # damaged all over

    def _words(self) -> Iterator[Word]:
        states = self._stack.states
        for word in words(self.short.text, self._at, self._tables.rows, states):
            if word[0] in NOTED and self._tables.after(states, word[:1]) is not None:
                self._note(word)
            yield word

    def _note(self, word: Word) -> None:
        """Remembers where an IF without THEN began: its ENDIF tells what it was meant to be."""
        type, _, at, _ = word
        if type in ROUTINES:
            self._kept.clear()
        elif type == "_IF":
            text = self.short.text
            stop = text.find(";", at)
            line = text.find("\n", at)
            code = re.sub(r"![^\n]*", "", text[at:stop])
            if 0 <= line < stop and "then" not in code.lower():
                begin, end = self.short.offset(at), self.short.offset(line)
                self._kept.append(HalfIf(begin, end, self._stack.kept()))

    def _mend(self, wrong: Word) -> None:
        type, said, short_at, _ = wrong
        if type in ("TARGETS", "MOVES"):
            first = ("NAME",) if type == "MOVES" else ("CONST", "LOCAL")
            if any(self._tables.after(self._stack.states, (t,)) is not None for t in first):
                raise _Way(int(said[1:-1]))
        at = len(self.text) if type == END else self.short.offset(short_at)
        base, begin = self._statement(at)
        near = lexemes(self.text, begin, at, FURTHER)
        error = next((i for i, word in enumerate(near) if word.end > at), len(near) - 1)
        stack = self._stack
        broken = Broken(
            self.text,
            near,
            error,
            self._tables,
            stack.states,
            self._tables.types(stack.states),
            self._begins(),
            base,
            tuple(self._kept),
        )
        full = len(self.findings) >= MOST_FINDINGS
        repair = broken.rest_left_out() if full else best(broken)
        self._say(broken, repair, full=full)
        self._make(broken, repair)

    def _statement(self, at: int) -> tuple[int, int]:
        """How much of the stack stands before the damaged statement, and where that begins."""
        states, types = self._stack.states, self._tables.types(self._stack.states)
        base = len(types)
        while base and not STARTS & self._tables.rows[states[base]].keys():
            base -= 1
            if types[base] in CLAUSES:
                break
        return base, next((begin for begin in self._begins()[base:] if begin >= 0), at)

    def _begins(self) -> tuple[int, ...]:
        """Offsets of the values of the stack; -1 for one that stands for no text."""
        stack, offset = self._stack, self.short.offset
        types = self._tables.types(stack.states)
        return tuple(
            NOWHERE if begin == NOWHERE or (type and begin == end) else offset(begin)
            for type, begin, end in zip(types, stack.begins, stack.ends, strict=True)
        )

    def _say(self, broken: Broken, repair: Repair, *, full: bool) -> None:
        word = broken.words[broken.error]
        if repair.silent or (word.start <= self._quiet_until and not full):
            return
        if full:
            if len(self.findings) == MOST_FINDINGS:
                span = Span(word.start, max(word.end, word.start + 1))
                self.findings.append(self.source.finding(rules.MANY, span, most=MOST_FINDINGS))
            return
        self.findings.append(wording.finding(self.source, broken, repair))

    def _make(self, broken: Broken, repair: Repair) -> None:
        """Changes the stack and goes on behind the damaged place."""
        if repair.kept is not None:
            self._stack.go_back(repair.kept.stack)
            self._kept.remove(repair.kept)
        else:
            self._stack.keep(repair.keep)
        for word in repair.put:
            at = self.short.back(word.start)
            shifted = word.type, word.text, at, at + word.end - word.start
            self._tables.drive(self._stack, (shifted,), self._nodes)
        ended = broken.word.type == END and repair.resume >= broken.word.start
        go_on = len(self.text) if ended else repair.resume
        inside = self.short.run_around(self.text, go_on)
        if inside is not None:
            raise _Way(inside)
        self._at = self.short.back(go_on)
        place = broken.words[broken.error].start
        if broken.error and go_on <= place:
            before = broken.words[broken.error - 1].end
            if "\n" in self.text[before:place]:  # what was missing stands on an earlier line
                place = before
        line = self.text.find("\n", place)
        ends = len(self.text) if line < 0 else line
        self._quiet_until = max(ends, go_on)


STARTS: Final = frozenset({"_FOR", "_RECORD", "_MODULE"})
"""Words that only a whole statement, item or module may begin with."""
