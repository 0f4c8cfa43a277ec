"""Repair of damaged lines, for languages with one statement a line.

A line that is not a statement is mended word by word, with a finding for each change. Each change
edits the text, which is then read again, because the meaning of a word depends on those before it.
`LineSyntax` is what a language states about itself; candidates come in the order in which they are
preferred at equal cost.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, Final, NamedTuple

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, Span
from assistant.base.near_names import spelled_like
from assistant.base.source_text import SourceText
from assistant.languages.lalr import END
from assistant.languages.line_grammar import LineGrammar
from assistant.languages.nodes import Nodes
from assistant.languages.recovery.mistakes import Edit, Slip, or_list
from assistant.languages.recovery.syntax import Lexeme, Stop


class Missing(NamedTuple):
    """Insertion for a missing terminal: its text, its name in a finding, the cure and the cost."""

    text: str
    named: str
    cure: str
    cost: int


class Phrase(NamedTuple):
    """One name for several terminals. unless: names whose earlier mention suppresses this one."""

    terminals: Set[str]
    said: str
    unless: Set[str] = frozenset()


_MOST_SAID: Final = 4
"""Things that are listed as what could stand at a place."""


@dataclass(frozen=True, slots=True)
class LineSyntax:
    """A language with a statement a line.

    title: its name. comment: mark of one; comments: their terminals. names: terminals of names.
    parts: number of a line between two offsets, offset of its code, and the rule of the grammar
    that this is; line: the rule of a statement. nodes: of a line, from an offset in it to one in
    the source. item: the result of a line that was read, with its number. mistakes: the usual ones.
    foreign: words of other languages in lower case → what to write, and the cure. branch: what may
    precede a statement, inside of a line. keywords: words in upper case → the terminals that they
    may be. words: possible corrections of a misspelt one. spelled: a word as it is written. begins:
    True if a word begins a statement. parted: where a blank is missing in a word, None for nowhere.
    is_whole: True for a statement. prose: a line that is plain words, the first of them its group.
    missing: insertions. phrases: names of terminals; unsaid: those that are omitted where another
    one fits. wrong: rule with `what` and `cure`.
    """

    title: str
    comment: str
    comments: Set[str]
    names: Set[str]
    grammar: LineGrammar
    parts: Callable[[str, int, int], tuple[int | None, int, str]]
    line: str
    nodes: Callable[[Callable[[int], int] | None], Nodes]
    item: Callable[[Any, int | None], Any]
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

    def expected(self, terminals: Collection[str]) -> str:
        """Return the expected terminals in words; empty if none has a name or too many have one."""
        fitting = set(terminals)
        for terminal, others in self.unsaid.items():
            if terminal in fitting:
                fitting -= others
        said: list[str] = []
        for phrase in self.phrases:
            if phrase.terminals & fitting and not phrase.unless & set(said):
                said.append(phrase.said)
        return "" if len(said) > _MOST_SAID else or_list(said)


_CLEAR, NEAR, _UNCLEAR, TEXT, _DELETED, CUT = 1, 2, 5, 6, 7, 9
"""Costs of a change: what is known, guessed, taken out."""
_ALIKE: Final = 0.74
"""Least similarity of two words of which one may be meant for the other."""
_TWO_WORDS: Final = re.compile(r"[ \t]*([A-Za-z]\w*)(?:[ \t]+([A-Za-z]\w*))?")
_TEXT: Final = re.compile(r"(?:[^\W\d]|[.:>-]).*")


def _line_candidates(
    syntax: LineSyntax,
    text: str,
    code: int,
    stop: Stop,
    read: tuple[Lexeme, ...],
    fitting: frozenset[str],
) -> Iterator[Edit]:
    """Changes to a line.

    code: offset of its code. read: the words before the one that does not fit.
    fitting: terminals that would have fitted.
    """
    error = stop.word.start
    yield from _comment_out_prose(syntax, text, code)
    yield from _replace_foreign_words(syntax, text, code, error)
    for mistake in syntax.mistakes:
        if edit := mistake.edit(text, code, error, _CLEAR):
            yield edit
    yield from _correct_words(syntax, stop, read, fitting)
    yield from _another_statement(syntax, text, stop, fitting)
    yield from _insert_word(syntax, text, stop, fitting)
    yield from _delete_words(syntax, text, stop, fitting)


def _comment_out_prose(syntax: LineSyntax, text: str, code: int) -> Iterator[Edit]:
    """A line that is plain words."""
    found = syntax.prose.match(text, code)
    if found and "=" not in found[0] and not syntax.begins(found[1]):
        what, cure = "this is text, not a statement", f"write `{syntax.comment}` before it"
        yield Edit(found.start(1), len(text), syntax.comment, what, cure, NEAR)


def _replace_foreign_words(syntax: LineSyntax, text: str, code: int, error: int) -> Iterator[Edit]:
    """Words of other languages at the begin of a statement."""
    begins = [code, *(found.end() for found in syntax.branch.finditer(text, code, error))]
    for begin in begins:
        found = _TWO_WORDS.match(text, begin)
        if found is None:
            continue
        for size in (2, 1):
            said = " ".join(word for word in found.groups()[:size] if word)
            known = syntax.foreign.get(said.lower())
            if known is not None and found[size] is not None:
                write, cure = known
                start, end = found.start(1), found.end(size)
                what = f"`{text[start:end]}` is no word of {syntax.title}"
                edit = Edit(start, end, write, what, cure, _CLEAR)
                yield edit
                # and without what stands behind it
                yield replace(edit, end=len(text), text=syntax.comment, cost=_UNCLEAR)
                break


def _correct_words(
    syntax: LineSyntax, stop: Stop, read: tuple[Lexeme, ...], fitting: frozenset[str]
) -> Iterator[Edit]:
    """Words that are nearly one of the language; the nearest to the error first."""
    here = [stop.word] if stop.word.type == "NAME" else []
    for word in reversed([word for word in (*read, *here) if word.type in syntax.names]):
        written = word.text
        # A word of the language that fitted is spelled well.
        if written.upper() in syntax.keywords and word is not stop.word:
            continue
        if (size := syntax.parted(written)) is not None:
            what = f"`{written}` has no blank behind `{written[:size]}`"
            parted, cure = f"{written[:size]} {written[size:]}", "write a blank between the two"
            yield Edit(word.start, word.end, parted, what, cure, NEAR)
        known = syntax.words
        # At the error only words that would fit are meant.
        if word is stop.word:
            known = [w for w, types in syntax.keywords.items() if fitting & set(types)]
        for near in spelled_like(written, known, 3, _ALIKE):
            meant = syntax.spelled(near)
            what = f"`{written}` is not known: is it `{meant}`?"
            cost = NEAR + (word is not stop.word)
            yield Edit(word.start, word.end, meant, what, f"write `{meant}`", cost)


def _another_statement(
    syntax: LineSyntax, text: str, stop: Stop, fitting: frozenset[str]
) -> Iterator[Edit]:
    """A second statement behind a whole one."""
    start = stop.word.start
    if END not in fitting or stop.word.type == END:
        return
    try:
        node = syntax.grammar.read(text, start, len(text), syntax.line, syntax.nodes(None), None)
    except ValueError:
        return
    if syntax.is_whole(node):
        second = text[start:].partition(syntax.comment)[0].strip()
        what, cure = "a line holds one statement", f"put `{second}` on a line of its own"
        yield Edit(start, len(text), syntax.comment, what, cure, NEAR)


def _insert_word(
    syntax: LineSyntax, text: str, stop: Stop, fitting: frozenset[str]
) -> Iterator[Edit]:
    """A word put in before the one that does not fit."""
    at, word = stop.word.start, stop.word
    # At the end of the code the word follows the last one directly.
    behind = len(text[:at].rstrip()) if word.type in (END, *syntax.comments) else at
    for terminal, (written, named, cure, cost) in syntax.missing.items():
        if terminal in fitting and not (terminal == "EQUALS" and "=" in text[:at]):
            found = text[word.start : word.end]
            before = f" before `{found}`" if found and word.type != "COMMENT" else ""
            yield Edit(behind, behind, written, f"{named} is missing{before}", cure, cost)


def _delete_words(
    syntax: LineSyntax, text: str, stop: Stop, fitting: frozenset[str]
) -> Iterator[Edit]:
    """The word that does not fit, or all that stands from it on."""
    start, end = stop.word.start, max(stop.word.end, stop.word.start + 1)
    mark = syntax.comment
    word = text[start:end]
    listed = syntax.expected(fitting)
    also = f"; expected {listed}" if listed else ""
    if stop.word.type == END:
        what = "the line ends too early" + also
        yield Edit(start, start, mark, what, "complete the statement", CUT)
        return
    what = f"`{word}` cannot stand here{also}"
    if word == ")":
        yield Edit(start, end, "", "a `)` has no `(`", "take it out, or write the `(`", NEAR)
    yield Edit(start, end, "", what, f"take `{word}` out, or write what it should be", _DELETED)
    if END in fitting and _TEXT.match(text, start):
        said, cure = "text stands behind the statement", f"write `{mark}` before a comment"
        yield Edit(start, len(text), mark, said, cure, TEXT)
    cure = f"write one statement a line; text behind it needs a `{mark}` before it"
    yield Edit(start, len(text), mark, what, cure, CUT)


_MOST_FINDINGS: Final = 5
"""Greatest number of findings of one line; more do not help."""
_PARTLY: Final = 4
"""Cost of a change behind which the line still cannot be read to its end."""
_AHEAD: Final = 2
"""Words that must be read behind such a change."""
_MOST_MENDED: Final = 500
"""Damaged lines of a file that are looked into; a file with more is no program."""
_LONGEST: Final = 2000
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
        if before < _MOST_MENDED:
            return self.mend(source, start, end)
        at = min(why.word.start, max(end - 1, start))
        word = source.text[at : max(why.word.end, at + 1)].strip()
        what, cure = f"`{word}` cannot stand here", "correct what is found before it first"
        return None, (source.finding(self.syntax.wrong, Span(at, at + 1), what=what, cure=cure),)

    def mend(self, source: SourceText, start: int, end: int) -> tuple[Any, tuple[Diagnostic, ...]]:
        """Return the intended node of a damaged line, None if it is unknown, and the findings.

        start, end: offsets of the line and of its line end.
        """
        line = _ChangedLine(source.text[start:end], start)
        findings: list[Diagnostic] = []
        while len(findings) < _MOST_FINDINGS and len(line.text) <= _LONGEST:
            # Changes shift offsets: nodes and findings refer to the text of the source.
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
        """Read a line: its node, a Stop at the first word that does not fit, None for a number too
        large.
        """
        syntax = self.syntax
        number, at, rule = syntax.parts(text, 0, len(text))
        try:
            node = syntax.grammar.read(text, at, len(text), rule, nodes, words)
        except ValueError:
            return None
        return node if isinstance(node, Stop) else syntax.item(node, number)

    def _best(self, line: _ChangedLine, stop: Stop) -> Edit | None:
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
        for edit in _line_candidates(self.syntax, text, code, stop, read, fitting):
            # No candidate costs less than its own change, so dearer ones need no reading.
            if best is not None and edit.cost >= best[0]:
                continue
            cost = self._cost(line, edit, stop)
            if cost is not None and (best is None or cost < best[0]):
                best = cost, edit
        return None if best is None else best[1]

    def _cost(self, line: _ChangedLine, edit: Edit, stop: Stop) -> int | None:
        """Return the cost of a change; None if it does not help."""
        text = edit.of(line.text)
        words = list[Lexeme]()
        again = self._read(text, self.syntax.nodes(None), words)
        if not isinstance(again, Stop):
            return edit.cost
        # The number of words after the error that are read.
        before = len(line.text) - stop.word.start
        ahead = sum(len(text) - word.end < before for word in words)
        # The change does not help if it only drops the rest, or if reading stops no later than
        # before.
        if edit.end == len(line.text) or len(text) - again.word.start >= before:
            return None
        return None if ahead < _AHEAD and edit.cost > 1 else edit.cost + _PARTLY

    def _words(self, text: str) -> tuple[Lexeme, ...]:
        words = list[Lexeme]()
        self._read(text, self.syntax.nodes(None), words)
        return tuple(words)

    def _finding(self, source: SourceText, line: _ChangedLine, edit: Edit, end: int) -> Diagnostic:
        at = line.place(edit.start)
        behind = line.place(edit.end) if edit.end > edit.start else at + 1
        if not edit.text.strip() or edit.end == len(line.text):
            behind = max(at + len(source.text[at:behind].rstrip()), at + 1)
        last = max(end - 1, 0)
        span = Span(min(at, last), max(min(behind, end), min(at, last) + 1))
        rule = edit.rule or self.syntax.wrong
        return source.finding(rule, span, what=edit.what, cure=edit.cure)

    def _unread(self, source: SourceText, line: _ChangedLine, end: int) -> Diagnostic:
        syntax, most = self.syntax, self.syntax.grammar.most_words
        words = self._words(line.text) if len(line.text) <= _LONGEST else ()
        _, code, _ = syntax.parts(line.text, 0, len(line.text))
        at = line.place(words[-1].end if words else code)
        at = min(at, max(end - 1, 0))
        if len(line.text) > _LONGEST or len(words) > most:
            what = "the line is longer than any step"
            cure = f"split it, or write `{syntax.comment}` before a text"
        elif len(words) > most // 4 and any(word.type == "LPAR" for word in words):
            what = "brackets stand too deep in each other"
            cure = "work parts out in lines of their own"
        else:
            what = "the line cannot be read"
            cure = f"write `{syntax.comment}` before it if it is a comment"
        return source.finding(syntax.wrong, Span(at, at + 1), what=what, cure=cure)


class _ChangedLine:
    """The text of a line with changes, and the source offsets of its characters."""

    def __init__(self, text: str, base: int) -> None:
        self.text = text
        self.base = base
        self.edits: list[Edit] = []

    def change(self, edit: Edit) -> None:
        self.text = edit.of(self.text)
        self.edits.append(edit)

    def place(self, offset: int) -> int:
        """Offset in the source."""
        # The last change first: each is counted in the text that the ones before it had made.
        for edit in reversed(self.edits):
            if offset >= edit.start + len(edit.text):
                offset += edit.end - edit.start - len(edit.text)
            elif offset > edit.start:
                offset = edit.start
        return offset + self.base
