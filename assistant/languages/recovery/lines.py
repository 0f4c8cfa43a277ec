"""A line that is no statement: mended word by word, with a finding for each change.

For languages with a statement a line. Each change is one of the text, which is then read again:
what a word is depends on those before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic, Span
from assistant.base.source_text import SourceText
from assistant.languages.nodes import Nodes
from assistant.languages.recovery.edits import Edit
from assistant.languages.recovery.lexemes import Lexeme, Stop
from assistant.languages.recovery.line_candidates import line_candidates
from assistant.languages.recovery.line_syntax import LineSyntax

MOST_FINDINGS: Final = 5
"""Of one line; more help nobody."""
PARTLY: Final = 4
"""Cost of a change behind which the line still cannot be read to its end."""
AHEAD: Final = 2
"""Words that must be read behind such a change."""
MOST_MENDED: Final = 500
"""Damaged lines of a file that are looked into; a file with more is no program."""
LONGEST: Final = 2000
"""Characters of a line that is mended."""


@dataclass(frozen=True, slots=True)
class LineReader:
    """Mends lines of a language."""

    syntax: LineSyntax

    def read(
        self, source: SourceText, start: int, end: int, why: Stop, before: int
    ) -> tuple[Any, tuple[Diagnostic, ...]]:
        """The same as `mend`, but for the lines of a file that is damaged all over.

        why: where the line stops being one. before: findings of the lines before it.
        """
        if before < MOST_MENDED:
            return self.mend(source, start, end)
        at = min(why.word.start, max(end - 1, start))
        word = source.text[at : max(why.word.end, at + 1)].strip()
        what, cure = f"`{word}` cannot stand here", "correct what is found before it first"
        return None, (source.finding(self.syntax.wrong, Span(at, at + 1), what=what, cure=cure),)

    def mend(self, source: SourceText, start: int, end: int) -> tuple[Any, tuple[Diagnostic, ...]]:
        """What a damaged line was meant to be, None if nobody knows, and the findings.

        start, end: offsets of the line and of its line end.
        """
        line = ChangedLine(source.text[start:end], start)
        findings: list[Diagnostic] = []
        while len(findings) < MOST_FINDINGS and len(line.text) <= LONGEST:
            read = self._read(line.text, self.syntax.nodes(line.place))
            if not isinstance(read, Stop):
                return read, tuple(findings)
            edit = self._best(line, read)
            if edit is None:
                break
            findings.append(self._finding(source, line, edit, end))
            line.change(edit)
        if not findings:
            findings.append(self._unread(source, line, end))
        return None, tuple(findings)

    def _read(self, text: str, nodes: Nodes, words: list[Lexeme] | None = None) -> Any:
        """What a line says, a Stop where it stops being one, None for a number too large."""
        syntax = self.syntax
        number, at, rule = syntax.parts(text, 0, len(text))
        try:
            node = syntax.grammar.read(text, at, len(text), rule, nodes, words)
        except ValueError:
            return None
        return node if isinstance(node, Stop) else syntax.item(node, number)

    def _best(self, line: ChangedLine, stop: Stop) -> Edit | None:
        """The cheapest change behind which the line reads on."""
        text = line.text
        read = self._words(text)
        tables = self.syntax.grammar.tables[stop.start]
        states = tables.after((tables.first,), (word.type for word in read))
        assert states is not None  # each of them was shifted
        fitting = tables.fitting(states)
        if stop.word.type in fitting:  # too many words, or brackets too deep in each other
            return None
        best: tuple[int, Edit] | None = None
        _, code, _ = self.syntax.parts(text, 0, len(text))
        for edit in line_candidates(self.syntax, text, code, stop, read, fitting):
            if best is not None and edit.cost >= best[0]:
                continue
            cost = self._cost(line, edit, stop)
            if cost is not None and (best is None or cost < best[0]):
                best = cost, edit
        return None if best is None else best[1]

    def _cost(self, line: ChangedLine, edit: Edit, stop: Stop) -> int | None:
        """What a change costs, None if it does not help."""
        text = edit.of(line.text)
        words = list[Lexeme]()
        again = self._read(text, self.syntax.nodes(None), words)
        if not isinstance(again, Stop):
            return edit.cost
        before = len(line.text) - stop.word.start
        ahead = sum(len(text) - word.end < before for word in words)
        if edit.end == len(line.text) or len(text) - again.word.start >= before:
            return None
        return None if ahead < AHEAD and edit.cost > 1 else edit.cost + PARTLY

    def _words(self, text: str) -> tuple[Lexeme, ...]:
        words = list[Lexeme]()
        self._read(text, self.syntax.nodes(None), words)
        return tuple(words)

    def _finding(self, source: SourceText, line: ChangedLine, edit: Edit, end: int) -> Diagnostic:
        at = line.place(edit.start)
        behind = line.place(edit.end) if edit.end > edit.start else at + 1
        if not edit.text.strip() or edit.end == len(line.text):
            behind = max(at + len(source.text[at:behind].rstrip()), at + 1)
        last = max(end - 1, 0)
        span = Span(min(at, last), max(min(behind, end), min(at, last) + 1))
        rule = edit.rule or self.syntax.wrong
        return source.finding(rule, span, what=edit.what, cure=edit.cure)

    def _unread(self, source: SourceText, line: ChangedLine, end: int) -> Diagnostic:
        syntax, most = self.syntax, self.syntax.grammar.most_words
        words = self._words(line.text) if len(line.text) <= LONGEST else ()
        _, code, _ = syntax.parts(line.text, 0, len(line.text))
        at = line.place(words[-1].end if words else code)
        at = min(at, max(end - 1, 0))
        if len(line.text) > LONGEST or len(words) > most:
            what = "the line is longer than any step"
            cure = f"split it, or write `{syntax.comment}` before a text"
        elif len(words) > most // 4 and any(word.type == "LPAR" for word in words):
            what = "brackets stand too deep in each other"
            cure = "work parts out in lines of their own"
        else:
            what = "the line cannot be read"
            cure = f"write `{syntax.comment}` before it if it is a comment"
        return source.finding(syntax.wrong, Span(at, at + 1), what=what, cure=cure)


class ChangedLine:
    """The text of a line with changes, and where its characters stand in the source."""

    def __init__(self, text: str, base: int) -> None:
        self.text = text
        self.base = base
        self.edits: list[Edit] = []

    def change(self, edit: Edit) -> None:
        self.text = edit.of(self.text)
        self.edits.append(edit)

    def place(self, offset: int) -> int:
        """Offset in the source."""
        for edit in reversed(self.edits):
            if offset >= edit.start + len(edit.text):
                offset += edit.end - edit.start - len(edit.text)
            elif offset > edit.start:
                offset = edit.start
        return offset + self.base
