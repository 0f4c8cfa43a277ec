"""A text as what stands on lines of their own: statements, headings, ends of blocks, comments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from assistant.languages.texts.laying_out import Form, Segment
from assistant.languages.texts.words import Word


@dataclass(frozen=True, slots=True)
class Cutter:
    """Cuts texts of a language into segments; words are given in lower case.

    words: of a text, tables of alike lines as one of kind `rows`. plain: of a table that begins at
    an offset, taken apart. scopes: may stand before the word that says what a segment is. opens,
    divides, closes: what words do to blocks; opening: a word that opens one if another ends its
    segment. alone: words that are segments of their own. end: ends any other segment, unless
    ended_by or ended_before lists what ends it, or what it ends before. named: words of a heading
    that ends with a name; headed: of one that goes on behind it. bracketed: words of headings
    that end with a pair of parentheses, if one follows. label: stands behind the name of a place.
    """

    words: Callable[[str], Iterator[Word]]
    plain: Callable[[str, int], Iterator[Word]]
    scopes: frozenset[str]
    opens: frozenset[str]
    opening: Mapping[str, str]
    divides: frozenset[str]
    closes: frozenset[str]
    alone: frozenset[str]
    end: str
    ended_by: Mapping[str, frozenset[str]]
    ended_before: Mapping[str, frozenset[str]]
    named: frozenset[str]
    headed: frozenset[str]
    bracketed: frozenset[str]
    label: str

    def segments(self, text: str) -> Iterator[Segment]:
        """The segments of a text that the grammar takes; of any other text some segments."""
        read = list(self.words(text))
        at, breaks = 0, 1
        while at < len(read):
            item = read[at]
            match item.kind:
                case "newline":
                    at, breaks = at + 1, breaks + 1
                    continue
                case "comment" | "rows" | "header":
                    form: Form = item.kind
                    yield Segment(form, "", [item], breaks)
                    at, breaks = at + 1, int(item.kind == "rows")
                case _:
                    end = self._end(read, at)
                    inside = read[at:end]
                    word = self._word(inside)
                    yield Segment(self._form(word, inside), word, inside, breaks)
                    at, breaks = end, 0

    def _word(self, inside: list[Word]) -> str:
        for item in inside:
            if item.kind in ("key", "hole") and item.text.lower() not in self.scopes:
                return item.text.lower()
            if item.kind not in ("key", "newline", "comment"):
                break
        return ""

    def _form(self, word: str, inside: list[Word]) -> Form:
        if word in self.opens or inside[-1].text.lower() == self.opening.get(word):
            return "opens"
        if word in self.divides:
            return "divides"
        return "closes" if word in self.closes else "plain"

    def _end(self, read: list[Word], start: int) -> int:
        """Index behind the last item of the segment that begins at an index."""
        seen = self._significant(read, start)
        at = next(seen)
        word = read[at].text.lower()
        if word in self.scopes:
            at = next(seen, at)
            word = read[at].text.lower()
        if word in self.ended_before:
            for following in seen:
                if read[following].text.lower() in self.ended_before[word]:
                    break
                at = following
            return at + 1
        if word in self.named or word in self.headed or word in self.bracketed:
            return self._end_of_heading(read, at, word)
        if word in self.alone:
            return at + 1
        stops = self.ended_by.get(word, {self.end})
        label = read[at].kind == "word"
        for number, following in enumerate(seen):
            text = read[following].text.lower()
            at = following
            if text in stops or (label and number == 0 and text == self.label):
                break
        return at + 1

    def _end_of_heading(self, read: list[Word], at: int, word: str) -> int:
        """Behind the parentheses of a heading, or behind its name if it has none."""
        depth, last = 0, at
        names = 1 if word in self.named else 0
        for following in self._significant(read, at + 1):
            text = read[following].text
            if text == "(" and word in self.bracketed:
                depth += 1
            elif text == ")" and depth:
                depth -= 1
                if not depth:
                    return following + 1
            elif not depth:
                if word in self.headed:
                    pass
                elif names:
                    names -= 1
                else:
                    return last + 1
            last = following
        return last + 1

    def _significant(self, read: list[Word], start: int) -> Iterator[int]:
        """Indices of what the grammar sees; a table in a statement is taken apart on the way."""
        at = start
        while at < len(read):
            item = read[at]
            if item.kind == "rows":  # its first line ends the statement that stands before it
                length = item.text.find("\n") + 1 or len(item.text)
                first = self.plain(item.text[:length], item.start)
                rest = Word("rows", item.text[length:], item.start + length)
                read[at : at + 1] = [*first, *([rest] if rest.text else [])]
                continue
            if item.kind not in ("newline", "comment"):
                yield at
            at += 1
