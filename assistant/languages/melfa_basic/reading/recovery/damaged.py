"""A line that is no MELFA-BASIC: mended word by word, with a finding for each change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.reading.driver import MOST_WORDS, Lexeme, Stop, drive
from assistant.languages.melfa_basic.reading.grammar import grammar
from assistant.languages.melfa_basic.reading.line import code_start, rule_of, step_of
from assistant.languages.melfa_basic.reading.nodes import Nodes
from assistant.languages.melfa_basic.reading.recovery.mistakes import ILLEGAL, Edit
from assistant.languages.melfa_basic.reading.recovery.repairs import candidates
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.diagnostics import Diagnostic, Span
from assistant.program.text import SourceText

MOST_FINDINGS: Final = 5
"""Of one line; more help nobody."""
PARTLY: Final = 4
"""Cost of a change behind which the line still cannot be read to its end."""
AHEAD: Final = 2
"""Words that must be read behind such a change."""
LONGEST: Final = 2000
"""Characters of a line that is mended."""


def mend(
    source: SourceText, start: int, end: int
) -> tuple[s.Line | s.Data | None, tuple[Diagnostic, ...]]:
    """What a damaged line was meant to be, None if nobody knows, and the findings.

    start, end: offsets of the line and of its line end.
    """
    line = Changed(source.text[start:end], start)
    findings: list[Diagnostic] = []
    while len(findings) < MOST_FINDINGS and len(line.text) <= LONGEST:
        read = _read(line)
        if not isinstance(read, Stop):
            return read, tuple(findings)
        edit = _best(line, read)
        if edit is None:
            break
        findings.append(_finding(source, line, edit, end))
        line.change(edit)
    if not findings:
        findings.append(_unread(source, line, end))
    return None, tuple(findings)


class Changed:
    """The text of a line with changes, and where its characters stand in the source."""

    def __init__(self, text: str, base: int) -> None:
        self.text = text
        self.base = base
        self.edits: list[Edit] = []

    def change(self, edit: Edit) -> None:
        self.text = self.text[: edit.start] + edit.text + self.text[edit.end :]
        self.edits.append(edit)

    def tried(self, edit: Edit) -> str:
        return self.text[: edit.start] + edit.text + self.text[edit.end :]

    def place(self, offset: int) -> int:
        """Offset in the source."""
        for edit in reversed(self.edits):
            if offset >= edit.start + len(edit.text):
                offset += edit.end - edit.start - len(edit.text)
            elif offset > edit.start:
                offset = edit.start
        return offset + self.base


class _Placed(Nodes):
    """Nodes that know where they stand in the source, not in the mended line."""

    def __init__(self, place: Callable[[int], int]) -> None:
        self._place = place

    def __getattribute__(self, name: str) -> object:
        method = object.__getattribute__(self, name)
        if name.startswith("_"):
            return method
        place = object.__getattribute__(self, "_place")

        def placed(span: Span | None, children: list[object]) -> object:
            at = None if span is None else Span(place(span.start), place(span.end))
            return method(at, children)

        return placed


def _read(line: Changed) -> s.Line | s.Data | Stop | None:
    text = line.text
    try:
        node = drive(text, *_code(text), _Placed(line.place))
    except ValueError:
        return None
    if isinstance(node, s.Line):
        return replace(node, number=step_of(text, 0, len(text)))
    return node if isinstance(node, s.Data | Stop) else None


def _code(text: str) -> tuple[int, int, str]:
    """Where the code of a line stands, and the rule of the grammar that it is."""
    at, end = code_start(text, 0, len(text)), len(text)
    return at, end, rule_of(text, at, end)


def _best(line: Changed, stop: Stop) -> Edit | None:
    """The cheapest change behind which the line reads on."""
    text = line.text
    read = _words(text)
    found = grammar().tables[stop.start]
    states = found.after((found.first,), (word.type for word in read))
    assert states is not None  # each of them was shifted
    fitting = found.fitting(states)
    if stop.word.type in fitting:  # too many words, or brackets too deep in each other
        return None
    best: tuple[int, Edit] | None = None
    for edit in candidates(text, _code(text)[0], stop, read, fitting):
        if best is not None and edit.cost >= best[0]:
            continue
        cost = _cost(line, edit, stop)
        if cost is not None and (best is None or cost < best[0]):
            best = cost, edit
    return None if best is None else best[1]


def _cost(line: Changed, edit: Edit, stop: Stop) -> int | None:
    """What a change costs, None if it does not help."""
    text = line.tried(edit)
    words = list[Lexeme]()
    again = _stop(text, words)
    if again is None:
        return edit.cost
    before = len(line.text) - stop.word.start
    ahead = sum(len(text) - word.end < before for word in words)
    if edit.end == len(line.text) or len(text) - again.word.start >= before:
        return None
    return None if ahead < AHEAD and edit.cost > 1 else edit.cost + PARTLY


def _stop(text: str, words: list[Lexeme]) -> Stop | None:
    try:
        node = drive(text, *_code(text), Nodes(), words)
    except ValueError:
        return None
    return node if isinstance(node, Stop) else None


def _words(text: str) -> tuple[Lexeme, ...]:
    words = list[Lexeme]()
    _stop(text, words)
    return tuple(words)


def _finding(source: SourceText, line: Changed, edit: Edit, end: int) -> Diagnostic:
    at = line.place(edit.start)
    behind = line.place(edit.end) if edit.end > edit.start else at + 1
    if not edit.text.strip() or edit.end == len(line.text):
        behind = max(at + len(source.text[at:behind].rstrip()), at + 1)
    rule = rules.QUOTES if edit.number == ILLEGAL else rules.SYNTAX
    span = Span(min(at, max(end - 1, 0)), max(min(behind, end), min(at, max(end - 1, 0)) + 1))
    return source.finding(rule, span, what=edit.what, cure=edit.cure)


def _unread(source: SourceText, line: Changed, end: int) -> Diagnostic:
    words = _words(line.text) if len(line.text) <= LONGEST else ()
    at = line.place(words[-1].end if words else _code(line.text)[0])
    at = min(at, max(end - 1, 0))
    if len(line.text) > LONGEST or len(words) > MOST_WORDS:
        what, cure = "the line is longer than any step", "split it, or write `'` before a text"
    elif any(word.type == "LPAR" for word in words) and len(words) > MOST_WORDS // 4:
        what, cure = "brackets stand too deep in each other", "work parts out in lines of their own"
    else:
        what, cure = "the line cannot be read", "write `'` before it if it is a comment"
    return source.finding(rules.SYNTAX, Span(at, at + 1), what=what, cure=cure)
