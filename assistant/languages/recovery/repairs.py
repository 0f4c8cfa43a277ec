"""Repair of a syntax error: candidate changes, tried on the parser's stack, and the best one.

Candidates come in the order in which people need them: a forgotten block end, a missing semicolon,
a misspelt word, a word inserted, replaced or deleted. The change that lets the parser read on
furthest is the diagnosis. A statement, declaration or head that no change repairs is replaced by a
placeholder.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from itertools import islice
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.near_names import spelled_like
from assistant.languages.lalr import END, Kept, Tables
from assistant.languages.recovery.syntax import STRANGE, Blocks, Lexeme, Syntax, column


@dataclass(frozen=True, slots=True, eq=False)
class HalfBlock:
    """The stack as it was at a head whose last word may be forgotten.

    line_end: of the line that it stands on.
    """

    at: int
    line_end: int
    stack: Kept


class Outline:
    """Beginnings and ends of the units of a text, searched once for all of its damaged places."""

    def __init__(self, blocks: Blocks, text: str) -> None:
        self._blocks, self._text = blocks, text

    @cached_property
    def _begins(self) -> list[int]:
        return [found.start() for found in self._blocks.unit_begin.finditer(self._text)]

    @cached_property
    def _first_end(self) -> int:
        found = self._blocks.unit_end.search(self._text)
        return len(self._text) + 1 if found is None else found.end()

    @cached_property
    def has_items(self) -> bool:
        """True if a declaration or routine begins anywhere."""
        return self._blocks.item.search(self._text) is not None

    def next_unit(self, at: int) -> int | None:
        """Return the offset of the first unit after an offset."""
        row = bisect_right(self._begins, at)
        return self._begins[row] if row < len(self._begins) else None

    def ends_before(self, at: int) -> bool:
        """True if a unit ends before an offset."""
        return self._first_end <= at


@dataclass(frozen=True, slots=True)
class Repair:
    """A change of the stack and of the place where reading goes on.

    kind: a key of `Wording.cures`, or `insert`, `replace`, `join`, `close`. keep: values that
    stay. put: words to shift then. resume: offset to go on from. start, end: the place to show.
    what: the word concerned. kept: a stack to go back to instead of keeping `keep` values.
    """

    kind: str
    keep: int
    put: tuple[Lexeme, ...]
    resume: int
    start: int
    end: int
    what: str = ""
    silent: bool = False
    kept: HalfBlock | None = None


@dataclass(frozen=True, slots=True)
class Broken:
    """A damaged place.

    words: from the begin of the statement to some words behind the error. error: row of the word
    that does not fit. states, types, begins: the parser's stack; of each value on it its terminal
    (empty for a node) and its offset (-1 if it was put in). base: values before the statement.
    kept: heads that may be half. outline: of the text.
    """

    syntax: Syntax
    text: str
    words: list[Lexeme]
    error: int
    tables: Tables
    states: list[int]
    types: tuple[str, ...]
    begins: tuple[int, ...]
    base: int
    kept: tuple[HalfBlock, ...]
    outline: Outline

    @property
    def word(self) -> Lexeme:
        return self.words[self.error]

    @property
    def behind_unit(self) -> bool:
        """True if a unit ends before the place."""
        return self.outline.ends_before(self.word.start)

    @property
    def closes(self) -> bool:
        """True if the word that does not fit begins a line and ends an open block."""
        ends = self.syntax.blocks.ends
        return self.word.first and any(self.word.type == ends[o] for o, _ in self.openers())

    @property
    def at_file_level(self) -> bool:
        return self.error == 0 and self.fits((self.syntax.blocks.unit,))

    @property
    def block(self) -> int:
        """Begin of the line on which the innermost open block begins."""
        begin = max((begin for _, begin in self.openers()), default=0)
        return self.text.rfind("\n", 0, begin) + 1

    @property
    def previous_end(self) -> int:
        """Offset of the end of the word before the error."""
        if self.error:
            return self.words[self.error - 1].end
        return self.syntax.layout.code_end(self.text, self.word.start)

    def accepts(self, terminal: str) -> bool:
        return self.tables.after(self.states, (terminal,)) is not None

    def fits(self, terminals: Iterable[str]) -> bool:
        """True if the statement may consist of these words."""
        return self.tables.after(self.states[: self.base + 1], terminals) is not None

    def accepted(self) -> frozenset[str]:
        return self.tables.fitting(self.states)

    def openers(self) -> list[tuple[str, int]]:
        """Blocks that are open before the statement, the outermost first: word and offset."""
        ends = self.syntax.blocks.ends
        closers = frozenset(ends.values())
        found: list[tuple[str, int]] = []
        for type, begin in zip(self.types[: self.base], self.begins, strict=False):
            if type in ends:
                found.append((type, begin))
            elif type in closers:  # read, but not yet put together
                found.pop()
        return found

    def reach(self, keep: int, put: Iterable[str], index: int) -> int:
        """Row of the first word that does not fit behind a change; -1 if the change does not."""
        stack = self.tables.after(self.states[: keep + 1], put)
        if stack is None:
            return -1
        for row in range(index, len(self.words)):
            if not self.tables.shift(stack, self.words[row].type):
                return row
        return len(self.words)

    def rest_left_out(self) -> Repair:
        at = len(self.text)
        return Repair("hole", self.base, (), at, self.word.start, self.word.end)


_MOST_WORDS: Final = 60
"""Words of one statement that are tried one by one."""


def _repair_candidates(broken: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Changes, the row that reading goes on with, and 0 sure, 1 likely or 2 a last resort."""
    yield from _insert_forgotten_then(broken)
    yield from _close_blocks(broken)
    yield from _replace_braces(broken)
    yield from _insert_semicolon(broken)
    yield from _correct_words(broken)
    yield from _replace_word(broken)
    yield from _insert_opening_word(broken)
    yield from _insert_words(broken)
    yield from _mend_brackets(broken)
    yield from _wrap_in_heads(broken)
    yield from _delete_words(broken)


def _insert_forgotten_then(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    half = b.syntax.blocks.half
    if b.word.type not in half.wanted or b.accepts(b.word.type) or not b.kept:
        return
    # The head in the same column as the end is most likely the one that is half.
    far = column(b.text, b.word.start)
    alike = [k for k in b.kept if column(b.text, k.at) == far]
    kept = (alike or b.kept)[-1]
    line = b.syntax.scanner.lexemes(b.text, kept.at, kept.line_end, 0)
    head = [word for word in line if word.start < kept.line_end]
    end = head[-1].end
    words = (*head, *b.syntax.holes.put([half.last], end))
    if b.tables.after(kept.stack.states, (word.type for word in words)) is not None:
        yield Repair("insert", 0, words, kept.line_end, end, end, half.last, kept=kept), b.error, 0


def _close_blocks(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Blocks whose end is missing before the statement; a wrong end made right."""
    openers = b.openers()
    word = b.words[0]
    ends = b.syntax.blocks.ends
    own = word.type in ends.values() and b.error == 0
    far = column(b.text, word.start)
    if own and openers:
        # A wrong end in the column of its opener was meant for that block.
        right = ends[openers[-1][0]]
        same = openers[-1][1] >= 0 and far == column(b.text, openers[-1][1])
        mended = word._replace(type=right)
        yield (
            Repair("replace", b.base, (mended,), word.end, word.start, word.end, right),
            1,
            1 if same else 2,
        )
    closers: list[str] = []
    open_now = list(openers)
    while open_now and len(closers) < _MOST_WORDS:
        type, _ = open_now.pop()
        closers.append(ends[type])
        # Closing helps only if the parser reads on past the word that does not fit.
        if b.reach(b.base, closers, 0) <= b.error:
            continue
        named = openers[len(open_now) :]
        said = [t for t, begin in reversed(named) if begin >= 0]
        begins = [begin for _, begin in named if begin >= 0]
        place = b.syntax.layout.missing_end(b.text, begins, word.start)
        # An end in the column of the block that stays open was meant for that one.
        matches = not own or any(
            begin >= 0 and column(b.text, begin) == far for _, begin in open_now[-1:]
        )
        yield (
            Repair(
                "close",
                b.base,
                b.syntax.holes.put(closers, b.previous_end if b.error == 0 else word.start),
                word.start,
                place,
                place,
                " ".join(ends[t] for t in said),
                silent=not said,
            ),
            0,
            (0 if word.first else 1) if matches else 2,
        )
        return


def _replace_braces(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Braces around statements, and the `:` of a head, which other languages have."""
    blocks, openers, word = b.syntax.blocks, b.openers(), b.word
    following = b.words[b.error + 1] if b.error + 1 < len(b.words) else word
    if word.type == "RBRACE" and word.first and openers:
        end = blocks.ends[openers[-1][0]]
        repair = Repair(
            "replace", b.base, _at(b, word, (end,)), word.end, word.start, word.end, end
        )
        if following.type in blocks.clauses:
            repair = replace(repair, kind="delete", put=(), what="")
        yield repair, b.error + 1, 0
    # The brace may be some words before the error that it causes.
    for row in range(b.error, max(b.error - _MOST_WORDS, -1), -1):
        brace = b.words[row]
        alone = row + 1 < len(b.words) and b.words[row + 1].first
        if not alone or brace.type not in blocks.braces:
            continue
        for type in blocks.braces[brace.type]:
            mended = (*b.words[:row], brace._replace(type=type))
            where = brace.end, brace.start, brace.end
            yield Repair("replace", b.base, mended, *where, type), row + 1, 0
        if brace.type == "LBRACE" and not row:
            where = brace.end, brace.start, brace.end
            yield Repair("delete", b.base, tuple(b.words[:row]), *where), row + 1, 0


def _insert_semicolon(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """The `;` that is missing at the end of a line, or the `)` of a head."""
    closers, put = b.syntax.blocks.ends.values(), b.syntax.holes.put
    for row in range(b.error, max(b.error - _MOST_WORDS, 0), -1):
        word, ahead = b.words[row], b.words[row - 1]
        ends = word.first or (row == b.error and word.type in closers)
        for type in ("SEMICOLON", "RPAR"):
            if ends and (row == b.error or type == "RPAR" or ahead.type not in b.syntax.glue):
                mended = (*b.words[:row], *put([type], ahead.end))
                yield (
                    Repair("insert", b.base, mended, word.start, ahead.end, ahead.end, type),
                    row,
                    0 if row == b.error and type == "SEMICOLON" else 1,
                )


def _correct_words(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Words of the language that were misspelt or written in two, and words said twice."""
    changes, closers = b.syntax.changes, b.syntax.blocks.ends.values()
    reserved = changes.reserved
    # Words before the error as well: a misspelt word is often read as a name, and fails later.
    for row in range(max(0, b.error - _MOST_WORDS), min(b.error + 2, len(b.words))):
        word = b.words[row]
        ahead = b.words[row - 1] if row else None
        joined = (ahead.text + word.text).lower() if ahead and ahead.text.isalpha() else ""
        if ahead and joined in reserved:
            type = reserved[joined]
            mended = (*b.words[: row - 1], Lexeme(type, type, ahead.start, word.end))
            yield (
                Repair("join", b.base, mended, word.end, ahead.start, word.end, type),
                row + 1,
                0,
            )
        if row > b.error:
            return
        twice = ahead and (ahead.type, ahead.text.lower()) == (word.type, word.text.lower())
        if ahead and twice and word.type not in ("NUMBER", "STRING"):
            rest = b.words[:row]
            yield (
                Repair("double", b.base, tuple(rest), word.end, word.start, word.end),
                row + 1,
                1,
            )
        if word.type == "NAME" and len(word.text) > 2:
            following = b.words[row + 1].text if row + 1 < len(b.words) else ""
            two = (word.text + following).lower() in reserved
            foreign = () if two else changes.foreign.get(word.text.lower(), ())
            for near in (*foreign, *spelled_like(word.text, reserved, 3)):
                type = reserved[near]
                mended = (*b.words[:row], word._replace(type=type))
                behind = row + 1
                if near in foreign and type in closers:  # what it ends may be named behind it
                    while behind < len(b.words) and not b.words[behind].first:
                        behind += 1
                resume = b.words[behind - 1].end
                yield (
                    Repair("replace", b.base, mended, resume, word.start, word.end, type),
                    behind,
                    1,
                )


def _replace_word(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """The word itself for another one."""
    word, row, keep, changes = b.word, b.error + 1, len(b.types), b.syntax.changes
    value = b.syntax.value
    repair = Repair("replace", keep, (), word.end, word.start, word.end)
    if word.type in changes.strings:
        for types in ((value,), (value, "SEMICOLON")):
            yield replace(repair, kind="string", put=_at(b, word, types)), row, 1
    if word.type in changes.comments:
        yield replace(repair, kind="comment"), row, 1
    for group in changes.alike:
        if word.type in group:
            for other in group:
                if other != word.type and other not in changes.unmeant and b.accepts(other):
                    yield replace(repair, put=_at(b, word, (other,)), what=other), row, 1
    used = row < len(b.words) and b.words[row].type in changes.used
    ahead = b.words[b.error - 1].text if b.error else ""
    joined = (ahead + word.text).lower() in changes.reserved
    named = used or (b.error and not b.closes and not joined)
    if word.text.lower() in changes.reserved and named and b.accepts("NAME"):
        yield replace(repair, kind="reserved", put=(word._replace(type="NAME"),)), row, 1
    if word.type == STRANGE:
        for types in ((value,), ("NAME",)):
            yield replace(repair, kind="strange", put=_at(b, word, types)), row, 1


def _at(b: Broken, word: Lexeme, types: Iterable[str]) -> tuple[Lexeme, ...]:
    texts = b.syntax.holes.texts
    return tuple(word._replace(type=t, text=texts.get(t, word.text)) for t in types)


def _insert_opening_word(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """The word that a statement or declaration begins with, forgotten."""
    at = b.words[0].start
    if b.words[0].type in b.syntax.blocks.clauses:
        return
    changes = b.syntax.changes
    for opener in changes.openers:
        needed = changes.needs.get(opener)
        if needed and not needed & {word.type for word in b.words}:
            continue
        put = b.syntax.holes.put([opener], at)
        yield Repair("insert", b.base, put, at, at, at, opener), 0, 1


def _insert_words(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """A word or two before the one that does not fit."""
    at, end = b.word.start, b.previous_end
    holes = b.syntax.holes
    for types in b.syntax.changes.inserted:
        if (b.error or types[0] not in holes.texts) and b.accepts(types[0]):
            named = " ".join(types)
            yield (
                Repair("insert", len(b.types), holes.put(types, end), at, end, end, named),
                b.error,
                1,
            )


def _mend_brackets(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """A bracket of a value that is missing at its begin or stands once too often."""
    if b.word.type != "COMMA" or not b.error:
        return
    ahead, at = b.words[b.error - 1], b.word.start
    if ahead.type == "RSQB":
        mended = tuple(b.words[: b.error - 1])
        yield Repair("delete", b.base, mended, at, ahead.start, ahead.end), b.error, 1
    if ahead.type == b.syntax.changes.table and "[" in ahead.text[1:]:
        last = ahead.end - 1
        words = b.syntax.scanner.lexemes(b.text, ahead.start + 1, last, 0)
        inner = [w for w in words if w.end <= last]
        opening = ahead._replace(type="LSQB", text="[", end=ahead.start + 1)
        mended = (*b.words[: b.error - 1], opening, *inner)
        yield Repair("delete", b.base, mended, at, last, ahead.end), b.error, 1
    for row in range(b.error):
        if b.words[row].type == b.syntax.assign:
            end = b.words[row + 1].start
            mended = (
                *b.words[: row + 1],
                *b.syntax.holes.put(["LSQB"], end),
                *b.words[row + 1 : b.error],
            )
            yield Repair("insert", b.base, mended, at, end, end, "LSQB"), b.error, 1


def _wrap_in_heads(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Routines without a module, statements without a routine."""
    blocks = b.syntax.blocks
    if b.word.type in blocks.ends.values() and not b.at_file_level:
        return
    at = b.words[0].start
    start, end = b.word.start, b.word.end
    for types in b.syntax.changes.wraps:
        whole = types[0] == blocks.unit
        if whole and not b.behind_unit and b.outline.next_unit(start) is not None:
            continue
        if not whole or b.outline.has_items or len(types) > 2:
            kind = "behind" if whole and b.behind_unit else "wrap"
            words = " ".join(type for type in types if type[0] == "_")
            put = b.syntax.holes.put(types, at)
            yield Repair(kind, b.base, put, at, start, end, words), 0, 1


def _delete_words(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    word, row, keep = b.word, b.error + 1, len(b.types)
    if word.type == END or b.closes:
        return
    repair = Repair("delete", keep, (), word.end, word.start, word.end)
    operator = row + 1 < len(b.words) and b.words[row + 1].type in b.syntax.glue
    assigns = word.type == b.syntax.assign and not b.error
    if assigns and (operator or b.words[row].type == "NUMBER"):
        name = b.syntax.holes.put(["NAME"], word.start)
        yield replace(repair, kind="insert", put=(*name, word), end=word.start, what="NAME"), row, 1
    yield repair, row, 2
    if b.error:
        ahead = b.words[b.error - 1]
        rest = tuple(b.words[: b.error - 1])
        yield (
            replace(repair, keep=b.base, put=rest, resume=word.start, start=ahead.start),
            b.error,
            2,
        )
        if (ahead.type, word.type) == ("LPAR", "RPAR"):
            yield replace(repair, keep=b.base, put=rest, start=ahead.start), row, 2
        swapped = (*rest, word, ahead)
        yield replace(repair, kind="swap", keep=b.base, put=swapped, start=ahead.start), row, 2
    if row < len(b.words) and not b.words[row].first:
        further = b.words[row]
        yield (
            replace(repair, kind="swap", put=(further, word), resume=further.end),
            row + 1,
            1 if assigns else 2,
        )
        yield replace(repair, resume=further.end, end=further.end), row + 1, 2


_MOST_SKIPPED_WORDS: Final = 2000
"""Number of words in which the end of a damaged statement is searched."""
_CLOSING_BRACKETS: Final = frozenset({"RPAR", "RSQB", "RBRACE"})


def placeholder(b: Broken) -> Repair:
    """A placeholder for the statement, a whole head for a damaged one."""
    word, syntax = b.word, b.syntax
    blocks, put = syntax.blocks, syntax.holes.put
    blank = Repair("hole", b.base, (), word.end, word.start, max(word.end, word.start + 1))
    if b.at_file_level:
        unit = b.outline.next_unit(word.start)
        if unit is not None:
            return replace(blank, resume=unit, kind="outside")
        silent = () if b.behind_unit else put([blocks.unit, "NAME"], word.start)
        return replace(blank, resume=len(b.text), put=silent, kind="outside")
    opener = b.words[0]
    head = blocks.heads.get(opener.type)
    line_end = b.text.find("\n", word.start)
    line_end = len(b.text) if line_end < 0 else line_end
    if b.closes:
        line_end = word.start
    if head is not None and word.type != END:
        stop = None
        for later in _following_words(b):
            if later.start >= line_end and later is not word:
                break
            if head and later.type == head[-1] and head[-1] in blocks.last:
                stop = later.end
        if not (opener.type == blocks.half.opener and stop is None):
            return replace(blank, put=_complete_head(b, head), resume=stop or line_end)
    resume = _next_statement(b)
    holes = syntax.data_holes if opener.type in syntax.data else syntax.statement_holes
    for type in holes:
        if b.fits((type,)):
            return replace(blank, put=put([type], opener.start), resume=resume)
    return replace(blank, resume=resume)


def _following_words(b: Broken) -> Iterator[Lexeme]:
    """Yield the words from the error on, read only as far as needed."""
    return islice(b.syntax.scanner.words(b.text, b.word.start), _MOST_SKIPPED_WORDS + 1)


def _complete_head(b: Broken, head: tuple[str, ...]) -> tuple[Lexeme, ...]:
    """A whole head, with the names that were read; nothing where none may stand."""
    kept = [b.words[0]]
    for type, word in zip(head, b.words[1 : b.error], strict=False):
        if type != word.type:
            break
        kept.append(word)
    rest = b.syntax.holes.put(head[len(kept) - 1 :], kept[-1].end)
    whole = (*kept, *rest)
    return whole if b.fits([w.type for w in whole]) else ()


def _next_statement(b: Broken) -> int:
    """Return the offset after a damaged statement, or where another one begins."""
    glue = b.syntax.glue
    ahead = b.words[b.error - 1] if b.error else None
    at = b.word.start
    for word in _following_words(b):
        if word.type == "SEMICOLON":
            return word.end
        if word.type == END:
            return word.start
        fresh = word.first and ahead and ahead.type not in glue and word.type not in glue
        if fresh and word.type not in _CLOSING_BRACKETS:
            return word.start
        ahead, at = word, word.start
    return at


_WORDS_AHEAD: Final = 6
"""Words of the next line that tell two changes apart."""


def best_repair(broken: Broken) -> Repair:
    """The change that reads on furthest; of several alike the one that people need most often."""
    goal = _goal_row(broken)
    likely: list[tuple[int, int, Repair]] = []
    ends = broken.word.first or broken.word.type in broken.syntax.blocks.ends.values()
    # By how sure a change is: the groups are asked in this order.
    sure, ended, last, rest = likely.copy(), likely.copy(), likely.copy(), likely.copy()
    for order, (repair, row, weight) in enumerate(_repair_candidates(broken)):
        put = [word.type for word in repair.put]
        reached = (
            # The reach of a change of another stack is not known, and this change is sure.
            broken.reach(repair.keep, put, row) if repair.kept is None else goal + _WORDS_AHEAD
        )
        # Beyond the next line all changes count alike, so that the order of candidates decides.
        ranked = (min(reached, goal + _WORDS_AHEAD), -order, repair)
        if reached > goal:
            (likely if weight < 2 else last).append(ranked)
        elif weight == 0 and reached > broken.error:
            sure.append(ranked)
        elif repair.what == "SEMICOLON" and row == broken.error <= reached and ends:
            ended.append(ranked)
        elif weight == 1 and reached == goal > broken.error:
            rest.append(ranked)
    for group in (likely, sure, ended, last, rest):
        if group:
            return max(group, key=lambda ranked: ranked[:2])[2]
    return placeholder(broken)


def _goal_row(broken: Broken) -> int:
    """Row that a mended statement reaches: the first word of the next line."""
    rows = range(broken.error + 1, len(broken.words))
    return next((row for row in rows if broken.words[row].first), len(broken.words) - 1)
