"""Tables that describe a language to error recovery, and the words and layout of damaged text.

Terminals have the names of the grammar. Marks have the names that lark gives them: `SEMICOLON`,
`COMMA`, `LPAR` and `RPAR`, `LSQB` and `RSQB`, `LBRACE` and `RBRACE`, `COLON`, `DOT`; a value begins
with `NAME`, `NUMBER`, `STRING` and others. `Scanner` reads words without a parser, also words that
the grammar does not know; `Layout` shows by indentation where the end of a block was forgotten.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import Final, NamedTuple

from assistant.base.data_classes import dataclass
from assistant.languages.lalr import END

STRANGE: Final = "STRANGE"
"""The type of what no terminal begins with."""


class Lexeme(NamedTuple):
    """type: a terminal of the grammar, END, or one of what is no terminal. first: on its line.

    start, end: offsets in the source; alike for what a repair puts in.
    """

    type: str
    text: str
    start: int
    end: int
    first: bool = False


class Stop(NamedTuple):
    """A word that does not fit.

    word: after the last one its type is END. start: rule of the grammar.
    """

    word: Lexeme
    start: str


@dataclass(frozen=True, slots=True)
class Scanner:
    """Finds words by one regular expression, a group a type. silent: types between words."""

    pattern: re.Pattern[str]
    silent: Set[str]

    def lexemes(self, text: str, start: int, stop: int, further: int) -> list[Lexeme]:
        """Return the words from one offset to another and a few further, END after the last of the
        text.
        """
        found: list[Lexeme] = []
        beyond = 0
        for word in self.words(text, start):
            found.append(word)
            beyond += word.type != END and word.start >= stop
            if beyond > further:
                break
        return found

    def words(self, text: str, start: int) -> Iterator[Lexeme]:
        """Yield the words from an offset on, END after the last; read only as far as needed."""
        end = -1
        for match in self.pattern.finditer(text, start):
            type = match.lastgroup or STRANGE
            if type in self.silent:
                continue
            begin, end = match.span()
            yield Lexeme(type, match[0], begin, end, _begins_line(text, begin))
        # Blanks and comments at the end of the text are not part of it.
        end = _code_end(text, start) if end < 0 else end
        yield Lexeme(END, "", end, end, True)


@dataclass(frozen=True, slots=True)
class Holes:
    """Terminals that stand for what is not there. texts: what each is written as."""

    texts: Mapping[str, str]

    def put(self, types: Iterable[str], at: int) -> tuple[Lexeme, ...]:
        """Words of no width at an offset."""
        return tuple(Lexeme(type, self.texts.get(type, ""), at, at) for type in types)


def _begins_line(text: str, at: int) -> bool:
    """True if only blanks precede an offset on its line."""
    while at and text[at - 1] != "\n":
        if not text[at - 1].isspace():
            return False
        at -= 1
    return True


def _code_end(text: str, at: int) -> int:
    """Return the offset of the end of the last word before an offset."""
    while at and text[at - 1].isspace():
        at -= 1
    return at


_TAB: Final = 4
_LINE: Final = re.compile(r"^([ \t]*)([A-Za-z_]\w*)([^\r\n]*)", re.MULTILINE)


def column(text: str, at: int) -> int:
    """Return the column of a word; -1 if it is not the first of its line."""
    ahead = text[text.rfind("\n", 0, at) + 1 : at]
    return -1 if ahead.strip() else len(ahead.expandtabs(_TAB))


@dataclass(frozen=True, slots=True)
class Layout:
    """First words of lines, in lower case, and what they do to blocks.

    openers: → whether the rest of the line leaves a block open. closers: → the opener that each
    closes. clauses: those that stand as far from the left as the opener. before: those that may
    stand before an opener. code: a line up to its comment.
    """

    openers: Mapping[str, re.Pattern[str]]
    closers: Mapping[str, str]
    clauses: Set[str]
    before: Set[str]
    code: re.Pattern[str]

    def code_end(self, text: str, at: int) -> int:
        """Return the offset of the end of the code before an offset: only blanks and comments
        follow it.
        """
        while True:
            begin = text.rfind("\n", 0, at) + 1
            line = self.code.match(text[begin:at])
            code = line[0].rstrip() if line else ""
            if code or not begin:
                return begin + len(code)
            at = begin - 1

    def missing_end(self, text: str, begins: Sequence[int], at: int) -> int:
        """Return where the end of open blocks was forgotten, as far as indentation shows; else
        `at`.

        begins: offsets of the blocks, the outermost first.
        """
        if not begins:
            return self.code_end(text, at)
        open_blocks: list[tuple[int, str]] = []
        # Depths at which some line is deeper than its opener: only there indentation is reliable.
        indented: set[int] = set()
        for start, far, word, rest in _code_lines(text, begins[0], at):
            if open_blocks and far > open_blocks[-1][0]:
                indented.add(len(open_blocks))
            if (closed := self.closers.get(word)) is not None:
                kinds = [kind for _, kind in open_blocks]
                if kinds[-1:] == [closed] and open_blocks[-1][0] == far:
                    indented.discard(len(open_blocks))
                    open_blocks.pop()
                    continue
                # The end of an outer block, in its column, while an inner one is open.
                if (far, closed) in open_blocks and len(open_blocks) in indented:
                    return self.code_end(text, start)
                while open_blocks and open_blocks.pop()[1] != closed:
                    pass
                continue
            # A line as far out as the opener shows that the block has ended above.
            outside = open_blocks and far <= open_blocks[-1][0] and len(open_blocks) in indented
            if outside and word not in self.clauses:
                return self.code_end(text, start)
            if word in self.before:
                word, _, rest = rest.strip().partition(" ")
                word = word.lower()
            if word in self.openers and self.openers[word].search(rest):
                open_blocks.append((far, word))
                indented.discard(len(open_blocks))
        return self.code_end(text, at)


def _code_lines(text: str, start: int, stop: int) -> Iterator[tuple[int, int, str, str]]:
    """Offset, indentation, first word in lower case and the rest of each line of code."""
    begin = text.rfind("\n", 0, start) + 1
    for match in _LINE.finditer(text, begin):
        if match.start(2) >= stop:
            return
        blank, word, rest = match.groups()
        yield match.start(2), len(blank.expandtabs(_TAB)), word.lower(), rest


Types = tuple[str, ...]
"""Terminals in a row."""


@dataclass(frozen=True, slots=True)
class HalfHead:
    """Head of a block that is still a complete statement if its last word is forgotten.

    opener: its first word. last: the forgotten one. word: that one as it is written, in lower case.
    wanted: words that occur in such a block only. comment: regular expression.
    """

    opener: str
    last: str
    word: str
    wanted: Set[str]
    comment: re.Pattern[str]


@dataclass(frozen=True, slots=True)
class Blocks:
    """Words that open, divide and close blocks.

    ends: the word that opens a block → the one that closes it. clauses: words that divide one.
    scopes: blocks that no statement extends beyond. unit: the block that a file consists of, whose
    begin, end and the begin of whose items are regular expressions. starts: words that only a
    complete statement, item or unit may begin with. heads: the words that follow one that opens a
    block or a part of one. last: words that end a head. braces: the openers of blocks in other
    languages, and their meaning.
    """

    ends: Mapping[str, str]
    clauses: Set[str]
    scopes: Set[str]
    unit: str
    unit_begin: re.Pattern[str]
    unit_end: re.Pattern[str]
    item: re.Pattern[str]
    starts: Set[str]
    heads: Mapping[str, Types]
    last: Set[str]
    braces: Mapping[str, Types]
    half: HalfHead


@dataclass(frozen=True, slots=True)
class Changes:
    """Words that people forget, confuse and take from elsewhere.

    inserted: words before one that does not fit. openers: words that a statement or declaration
    begins with; needs: those of which it has one, most likely. alike: groups of words that are
    written for each other; unmeant: those that no one means. wraps: what is missing around
    statements and items. reserved: words of the language in lower case → terminal. foreign: words
    of other languages → those meant. strings, comments: types of the strings and comments of other
    languages. used: words after a name that is used. table: values in one word.
    """

    inserted: tuple[Types, ...]
    openers: Types
    needs: Mapping[str, Set[str]]
    alike: tuple[Types, ...]
    unmeant: Set[str]
    wraps: tuple[Types, ...]
    reserved: Mapping[str, str]
    foreign: Mapping[str, Types]
    strings: Set[str]
    comments: Set[str]
    used: Set[str]
    table: str


@dataclass(frozen=True, slots=True)
class Syntax:
    """assign: the word between a variable and its value. value: the hole for a value. data: words
    that a declaration begins with. statement_holes, data_holes: terminals that replace an omitted
    one. glue: words that a line may end or begin with in the middle of a statement. runs: marks of
    text already read → words that each could begin with.
    """

    scanner: Scanner
    holes: Holes
    blocks: Blocks
    changes: Changes
    layout: Layout
    assign: str
    value: str
    data: Set[str]
    statement_holes: Types
    data_holes: Types
    glue: Set[str]
    runs: Mapping[str, Types]
