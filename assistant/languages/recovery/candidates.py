"""Changes that may mend a damaged place, in the order in which people need them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.lalr import END
from assistant.languages.recovery.broken import Broken, Repair
from assistant.languages.recovery.layout import column
from assistant.languages.recovery.lexemes import STRANGE, Lexeme

MOST_WORDS: Final = 60
"""Words of one statement that are tried one by one."""


def repair_candidates(broken: Broken) -> Iterator[tuple[Repair, int, int]]:
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
    while open_now and len(closers) < MOST_WORDS:
        type, _ = open_now.pop()
        closers.append(ends[type])
        if b.reach(b.base, closers, 0) <= b.error:
            continue
        named = openers[len(open_now) :]
        said = [t for t, begin in reversed(named) if begin >= 0]
        begins = [begin for _, begin in named if begin >= 0]
        place = b.syntax.layout.missing_end(b.text, begins, word.start)
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
    for row in range(b.error, max(b.error - MOST_WORDS, -1), -1):
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
    for row in range(b.error, max(b.error - MOST_WORDS, 0), -1):
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
    for row in range(max(0, b.error - MOST_WORDS), min(b.error + 2, len(b.words))):
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
            for near in (*foreign, *difflib.get_close_matches(word.text.lower(), reserved, 3, 0.7)):
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
