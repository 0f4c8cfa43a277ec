"""Reader of damaged texts: each syntax error is mended with the least change and reported once.

The grammar remains the authority. The reader tries every word on the parser's stack before it
shifts it. Where none fits, `repairs` proposes changes, and the reader makes the one that lets the
parser read on furthest. A statement that cannot be mended is omitted, with a placeholder instead.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText
from assistant.languages.grammar import RunInTheWay, Shortened, WordScanner, number_of
from assistant.languages.lalr import END, NOWHERE, Stack, Tables, Word
from assistant.languages.recovery.mistakes import Wording
from assistant.languages.recovery.repairs import Broken, HalfBlock, Outline, Repair, best_repair
from assistant.languages.recovery.syntax import Lexeme, Syntax

MOST_FINDINGS: Final = 50
_FURTHER: Final = 24
"""Words behind an error that a repair is tried on."""
_MOST_MENDS: Final = 2000
"""Repairs, the unsaid ones included, after which a file counts as damaged all over."""


@dataclass(frozen=True, slots=True)
class MendedText:
    """Result of reading a damaged text, None for one that is damaged all over, and the findings."""

    value: Any
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class Reader:
    """Reads damaged texts of a language."""

    words: WordScanner
    syntax: Syntax
    wording: Wording

    def read(
        self, source: SourceText, text: str, short: Shortened, tables: Tables, nodes: Any
    ) -> MendedText | RunInTheWay:
        """Read a damaged text with `nodes`, or return the run that a mended statement reaches into.

        text: of the source, line feeds at its line ends.
        """
        reading = _Reading(self, source, text, short, tables, nodes)
        try:
            return MendedText(reading.value(), tuple(reading.findings))
        except _InTheWay as way:
            return RunInTheWay(way.number)


class _InTheWay(Exception):
    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number: Final = number


class _Reading:
    def __init__(
        self,
        reader: Reader,
        source: SourceText,
        text: str,
        short: Shortened,
        tables: Tables,
        nodes: Any,
    ) -> None:
        self.reader, self.source, self.text, self.short = reader, source, text, short
        self.findings: list[Diagnostic] = []
        self._tables, self._nodes = tables, nodes
        self._stack = Stack(tables.first)
        self._at = 0
        self._quiet_until = -1
        self._kept: list[HalfBlock] = []
        self._outline = Outline(reader.syntax.blocks, text)

    def value(self) -> Any:
        for _ in range(_MOST_MENDS + 1):
            words = self._words()
            wrong = self._tables.drive(self._stack, words, self._nodes, careful=True)
            if wrong is None:
                return self._stack.values[0]
            self._mend(wrong)
        return None

    def _words(self) -> Iterator[Word]:
        states, blocks = self._stack.states, self.reader.syntax.blocks
        noted = blocks.scopes | {blocks.half.opener}
        words = self.reader.words.fitting(self.short.text, self._at, self._tables.rows, states)
        for word in words:
            if word[0] in noted and self._tables.after(states, word[:1]) is not None:
                self._note(word)
            yield word

    def _note(self, word: Word) -> None:
        """Remembers where a half head began: what ends its block tells what it was meant to be."""
        type, _, at, _ = word
        blocks = self.reader.syntax.blocks
        if type in blocks.scopes:
            self._kept.clear()
            return
        text = self.short.text
        stop = text.find(";", at)
        line = text.find("\n", at)
        code = blocks.half.comment.sub("", text[at:stop])
        # The head goes on in the next line without the word that ends it.
        if 0 <= line < stop and blocks.half.word not in code.lower():
            begin, end = self.short.offset(at), self.short.offset(line)
            self._kept.append(HalfBlock(begin, end, self._stack.kept()))

    def _mend(self, wrong: Word) -> None:
        type, said, short_at, _ = wrong
        syntax, stack = self.reader.syntax, self._stack
        first = syntax.runs.get(type, ())
        # A table of rows was read as one word, where only its single rows would fit.
        if any(self._tables.after(stack.states, (t,)) is not None for t in first):
            raise _InTheWay(number_of(said))
        at = len(self.text) if type == END else self.short.offset(short_at)
        base, begin = self._statement(at)
        near = syntax.scanner.lexemes(self.text, begin, at, _FURTHER)
        error = next((i for i, word in enumerate(near) if word.end > at), len(near) - 1)
        broken = Broken(
            syntax,
            self.text,
            near,
            error,
            self._tables,
            stack.states,
            self._tables.types(stack.states),
            self._begins(),
            base,
            tuple(self._kept),
            self._outline,
        )
        # After the last finding the rest of the text is left out.
        full = len(self.findings) >= MOST_FINDINGS
        repair = broken.rest_left_out() if full else best_repair(broken)
        self._say(broken, repair, full=full)
        self._make(broken, repair)

    def _statement(self, at: int) -> tuple[int, int]:
        """Return the number of stack values before the damaged statement, and the offset where it
        begins.
        """
        states, types = self._stack.states, self._tables.types(self._stack.states)
        blocks = self.reader.syntax.blocks
        base = len(types)
        # Back to where a whole statement, item or unit may begin.
        while base and not blocks.starts & self._tables.rows[states[base]].keys():
            base -= 1
            # A clause begins a part of a block: nothing before it belongs to the statement.
            if types[base] in blocks.clauses:
                break
        return base, next((begin for begin in self._begins()[base:] if begin >= 0), at)

    def _begins(self) -> tuple[int, ...]:
        """Offsets of the values of the stack; NOWHERE for one that stands for no text."""
        stack, offset = self._stack, self.short.offset
        types = self._tables.types(stack.states)
        return tuple(
            NOWHERE if begin == NOWHERE or (type and begin == end) else offset(begin)
            for type, begin, end in zip(types, stack.begins, stack.ends, strict=True)
        )

    def _say(self, broken: Broken, repair: Repair, *, full: bool) -> None:
        word, wording = broken.words[broken.error], self.reader.wording
        if repair.silent or (word.start <= self._quiet_until and not full):
            return
        if full:
            if len(self.findings) == MOST_FINDINGS:
                span = Span(word.start, max(word.end, word.start + 1))
                self.findings.append(self.source.finding(wording.many, span, most=MOST_FINDINGS))
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
        go_on = len(self.text) if ended else self._behind_alike(broken, repair)
        inside = self.short.run_around(self.text, go_on)
        if inside is not None:
            raise _InTheWay(inside)
        self._at = self.short.back(go_on)
        place = broken.words[broken.error].start
        if broken.error and go_on <= place:
            before = broken.words[broken.error - 1].end
            if "\n" in self.text[before:place]:  # what was missing stands on an earlier line
                place = before
        line = self.text.find("\n", place)
        ends = len(self.text) if line < 0 else line
        # Errors on the same line mostly follow from this one, so they are not reported.
        self._quiet_until = max(ends, go_on)

    def _behind_alike(self, broken: Broken, repair: Repair) -> int:
        """Return where reading continues: a repair that omits one of many equal words omits the
        rest too.

        While nothing else is within reach, the same change would mend each of them.
        """
        word, words = broken.word, broken.words
        alone = repair.kind in ("hole", "delete") and (repair.resume, broken.error) == (word.end, 0)
        if not alone or repair.keep != len(broken.types) or len(words) <= _FURTHER:
            return repair.resume
        if any(_differs(word, other) for other in words[1:]):
            return repair.resume
        behind = deque((word.end,), _FURTHER + 1)
        for other in self.reader.syntax.scanner.words(self.text, word.end):
            if _differs(word, other):
                break
            behind.append(other.end)
        return behind[0]


def _differs(word: Lexeme, other: Lexeme) -> bool:
    """True unless a word repeats another on the same line."""
    return other.first or (other.type, other.text) != (word.type, word.text)
