"""Changes that mend a damaged place, tried on the parser's stack; the best one is the diagnosis."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.reading.recovery import indentation
from assistant.languages.rapid.reading.recovery.broken import (
    CLAUSES,
    ENDS,
    TEXTS,
    Broken,
    Repair,
    put,
)
from assistant.languages.rapid.reading.recovery.left_out import GLUE, MODULE, left_out
from assistant.languages.rapid.reading.recovery.lexemes import END, Lexeme, lexemes
from assistant.languages.rapid.tables.words import RESERVED

INSERTED: Final = (
    *(("COMMA",), ("RPAR",), ("RSQB",), ("RBRACE",), ("_THEN",), ("_DO",), ("COLON",)),
    *(("_ASSIGN",), ("_FROM",), ("_TO",), ("_WITH",), ("LPAR", "RPAR"), ("LPAR",)),
    *(("RPAR", "RPAR"), ("RSQB", "RSQB"), ("RPAR", "SEMICOLON"), ("RSQB", "SEMICOLON")),
    *(("EXP",), ("NAME",), ("SEMICOLON",), ("BACKSLASH",), ("PERCENT",)),
    *(("EXP", "SEMICOLON"), ("LSQB",), ("LBRACE",), ("QMARK",)),
)
OPENERS: Final = (
    *("_IF", "_ELSEIF", "_WHILE", "_FOR", "_TEST", "_CASE", "_PROC", "_FUNC"),
    *("VAR", "CONST", "PERS", "_TRAP", "_RECORD", "_ALIAS", "_MODULE"),
)
ALIKE: Final = (
    *(("_ASSIGN", "EQUAL", "FOREIGN_EQUAL", "COLON", "MINUS"), ("_THEN", "_DO", "SEMICOLON")),
    *(("RPAR", "RSQB", "RBRACE"), ("LPAR", "LSQB", "LBRACE")),
    *(("COMMA", "DOT", "SEMICOLON", "COLON"), ("SLASH", "BACKSLASH")),
)
"""Words that people write for each other."""
FOREIGN: Final[dict[str, tuple[str, ...]]] = {
    "next": ("endfor",),
    "wend": ("endwhile",),
    "endloop": ("endwhile", "endfor"),
    "endswitch": ("endtest",),
    "endselect": ("endtest",),
    "endsub": ("endproc",),
    "enddef": ("endproc",),
    "endprocedure": ("endproc",),
    "endfct": ("endfunc",),
    "end": ("endif", "endfor", "endwhile", "endtest", "endproc", "endfunc", "endtrap", "endmodule"),
    "switch": ("test",),
    "select": ("test",),
    "otherwise": ("default",),
    "elif": ("elseif",),
    "def": ("proc",),
    "procedure": ("proc",),
    "sub": ("proc",),
    "function": ("func",),
}
"""Words of other languages, and those of RAPID for them."""
CONDITION: Final = frozenset(
    "_THEN LESS AT_MOST EQUAL MORE AT_LEAST UNEQUAL OR XOR AND _NOT".split()  # noqa: SIM905
)
"""Words of which an IF has one, most likely."""
STRINGS: Final = frozenset({"FOREIGN_STRING", "BAD_ESCAPE", "OPEN_STRING"})
ITEM: Final = re.compile(
    r"^[ \t]*(?:local[ \t]+|task[ \t]+)?(?:proc|func|trap|record|const|pers|var)[ \t]+\w",
    re.IGNORECASE | re.MULTILINE,
)
MOST_WORDS: Final = 60
"""Words of one statement that are tried one by one."""
ALONG: Final = 6
"""Words of the next line that tell two changes apart."""


def best(broken: Broken) -> Repair:
    """The change that reads on furthest; of several alike the one that people need most often."""
    goal = _goal(broken)
    likely: list[tuple[int, int, Repair]] = []
    ends = broken.word.first or broken.word.type in ENDS
    sure, ended, last, rest = likely.copy(), likely.copy(), likely.copy(), likely.copy()
    for order, (repair, row, weight) in enumerate(_candidates(broken)):
        put = [word.type for word in repair.put]
        reached = broken.reach(repair.keep, put, row) if repair.kept is None else goal + ALONG
        ranked = (min(reached, goal + ALONG), -order, repair)
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
    return left_out(broken)


def _goal(broken: Broken) -> int:
    """Row that a mended statement reaches: the first word of the next line."""
    rows = range(broken.error + 1, len(broken.words))
    return next((row for row in rows if broken.words[row].first), len(broken.words) - 1)


def _candidates(broken: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Changes, the row that reading goes on with, and 0 sure, 1 likely or 2 a last resort."""
    yield from _forgotten_then(broken)
    yield from _closed(broken)
    yield from _braces(broken)
    yield from _semicolons(broken)
    yield from _reworded(broken)
    yield from _replaced(broken)
    yield from _opened(broken)
    yield from _inserted(broken)
    yield from _bracketed(broken)
    yield from _wrapped(broken)
    yield from _deleted(broken)


def _forgotten_then(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    if b.word.type not in ("_ELSE", "_ELSEIF", "_ENDIF") or b.accepts(b.word.type) or not b.kept:
        return
    column = indentation.column(b.text, b.word.start)
    alike = [k for k in b.kept if indentation.column(b.text, k.at) == column]
    kept = (alike or b.kept)[-1]
    line = lexemes(b.text, kept.at, kept.line_end, 0)
    head = [word for word in line if word.start < kept.line_end]
    end = head[-1].end
    words = (*head, *put(["_THEN"], end))
    if b.tables.after(kept.stack.states, (word.type for word in words)) is not None:
        yield Repair("insert", 0, words, kept.line_end, end, end, "_THEN", kept=kept), b.error, 0


def _closed(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Blocks whose end is missing before the statement; a wrong end made right."""
    openers = b.openers()
    word = b.words[0]
    own = word.type in ENDS and b.error == 0
    column = indentation.column(b.text, word.start)
    if own and openers:
        right = "_END" + openers[-1][0][1:]
        same = openers[-1][1] >= 0 and column == indentation.column(b.text, openers[-1][1])
        mended = replace(word, type=right)
        yield (
            Repair("replace", b.base, (mended,), word.end, word.start, word.end, right),
            1,
            1 if same else 2,
        )
    closers: list[str] = []
    open_now = list(openers)
    while open_now and len(closers) < MOST_WORDS:
        type, _ = open_now.pop()
        closers.append("_END" + type[1:])
        if b.reach(b.base, closers, 0) <= b.error:
            continue
        named = openers[len(open_now) :]
        said = [t for t, begin in reversed(named) if begin >= 0]
        place = indentation.missing_end(b.text, named, word.start)
        matches = not own or any(
            begin >= 0 and indentation.column(b.text, begin) == column for _, begin in open_now[-1:]
        )
        yield (
            Repair(
                "close",
                b.base,
                put(closers, b.previous_end if b.error == 0 else word.start),
                word.start,
                place,
                place,
                " ".join("_END" + t[1:] for t in said),
                silent=not said,
            ),
            0,
            (0 if word.first else 1) if matches else 2,
        )
        return


def _braces(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Braces around statements, and the `:` of a head, which other languages have."""
    openers, word = b.openers(), b.word
    following = b.words[b.error + 1] if b.error + 1 < len(b.words) else word
    if word.type == "RBRACE" and word.first and openers:
        end = "_END" + openers[-1][0][1:]
        repair = Repair("replace", b.base, _at(word, (end,)), word.end, word.start, word.end, end)
        if following.type in CLAUSES:
            repair = replace(repair, kind="delete", put=(), what="")
        yield repair, b.error + 1, 0
    for row in range(b.error, max(b.error - MOST_WORDS, -1), -1):
        brace = b.words[row]
        alone = row + 1 < len(b.words) and b.words[row + 1].first
        if not alone or brace.type not in ("LBRACE", "COLON"):
            continue
        for type in ("_THEN", "_DO"):
            mended = (*b.words[:row], replace(brace, type=type))
            where = brace.end, brace.start, brace.end
            yield Repair("replace", b.base, mended, *where, type), row + 1, 0
        if brace.type == "LBRACE" and not row:
            where = brace.end, brace.start, brace.end
            yield Repair("delete", b.base, tuple(b.words[:row]), *where), row + 1, 0


def _semicolons(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """The `;` that is missing at the end of a line, or the `)` of a head."""
    for row in range(b.error, max(b.error - MOST_WORDS, 0), -1):
        word, ahead = b.words[row], b.words[row - 1]
        ends = word.first or (row == b.error and word.type in ENDS)
        for type in ("SEMICOLON", "RPAR"):
            if ends and (row == b.error or type == "RPAR" or ahead.type not in GLUE):
                mended = (*b.words[:row], *put([type], ahead.end))
                yield (
                    Repair("insert", b.base, mended, word.start, ahead.end, ahead.end, type),
                    row,
                    0 if row == b.error and type == "SEMICOLON" else 1,
                )


def _reworded(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Words of the language that were misspelt or written in two, and words said twice."""
    for row in range(max(0, b.error - MOST_WORDS), min(b.error + 2, len(b.words))):
        word = b.words[row]
        ahead = b.words[row - 1] if row else None
        if ahead and ahead.text.isalpha() and (ahead.text + word.text).lower() in RESERVED:
            type = _terminal(ahead.text + word.text)
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
            two = (word.text + following).lower() in RESERVED
            foreign = () if two else FOREIGN.get(word.text.lower(), ())
            for near in (*foreign, *difflib.get_close_matches(word.text.lower(), RESERVED, 3, 0.7)):
                type = _terminal(near)
                mended = (*b.words[:row], replace(word, type=type))
                behind = row + 1
                if near in foreign and type in ENDS:  # what it ends may be named behind it
                    while not b.words[behind].first:
                        behind += 1
                resume = b.words[behind - 1].end
                yield (
                    Repair("replace", b.base, mended, resume, word.start, word.end, type),
                    behind,
                    1,
                )


def _terminal(word: str) -> str:
    name = word.upper()
    return name if name in PLAIN else "_" + name


PLAIN: Final = frozenset(
    """LOCAL TASK VAR PERS CONST INOUT SYSMODULE NOVIEW NOSTEPIN VIEWONLY READONLY TRUE FALSE OR
    XOR AND DIV MOD""".split()  # noqa: SIM905
)


def _replaced(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """The word itself for another one."""
    word, row, keep = b.word, b.error + 1, len(b.types)
    repair = Repair("replace", keep, (), word.end, word.start, word.end)
    if word.type in STRINGS:
        for types in (("EXP",), ("EXP", "SEMICOLON")):
            yield replace(repair, kind="string", put=_at(word, types)), row, 1
    if word.type.startswith("FOREIGN_COMMENT"):
        yield replace(repair, kind="comment"), row, 1
    for group in ALIKE:
        if word.type in group:
            for other in group:
                if other not in (word.type, "COLON", "MINUS") and b.accepts(other):
                    yield replace(repair, put=_at(word, (other,)), what=other), row, 1
    used = row < len(b.words) and b.words[row].type in ("_ASSIGN", "DOT", "LBRACE")
    ahead = b.words[b.error - 1].text if b.error else ""
    joined = (ahead + word.text).lower() in RESERVED
    named = used or (b.error and not b.closes and not joined)
    if word.text.lower() in RESERVED and named and b.accepts("NAME"):
        yield replace(repair, kind="reserved", put=(replace(word, type="NAME"),)), row, 1
    if word.type == "STRANGE":
        for types in (("EXP",), ("NAME",)):
            yield replace(repair, kind="strange", put=_at(word, types)), row, 1


def _at(word: Lexeme, types: Iterable[str]) -> tuple[Lexeme, ...]:
    return tuple(replace(word, type=t, text=TEXTS.get(t, word.text)) for t in types)


def _opened(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """The word that a statement or declaration begins with, forgotten."""
    at = b.words[0].start
    if b.words[0].type in CLAUSES:
        return
    for opener in OPENERS:
        if opener == "_IF" and not CONDITION & {word.type for word in b.words}:
            continue
        yield Repair("insert", b.base, put([opener], at), at, at, at, opener), 0, 1


def _inserted(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """A word or two before the one that does not fit."""
    at, end = b.word.start, b.previous_end
    for types in INSERTED:
        if (b.error or types[0] not in TEXTS) and b.accepts(types[0]):
            named = " ".join(types)
            yield (
                Repair("insert", len(b.types), put(types, end), at, end, end, named),
                b.error,
                1,
            )


def _bracketed(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """A bracket of a value that is missing at its begin or stands once too often."""
    if b.word.type != "COMMA" or not b.error:
        return
    ahead, at = b.words[b.error - 1], b.word.start
    if ahead.type == "RSQB":
        mended = tuple(b.words[: b.error - 1])
        yield Repair("delete", b.base, mended, at, ahead.start, ahead.end), b.error, 1
    if ahead.type == "TABLE" and "[" in ahead.text[1:]:
        last = ahead.end - 1
        inner = [w for w in lexemes(b.text, ahead.start + 1, last, 0) if w.end <= last]
        opening = replace(ahead, type="LSQB", text="[", end=ahead.start + 1)
        mended = (*b.words[: b.error - 1], opening, *inner)
        yield Repair("delete", b.base, mended, at, last, ahead.end), b.error, 1
    for row in range(b.error):
        if b.words[row].type == "_ASSIGN":
            end = b.words[row + 1].start
            mended = (*b.words[: row + 1], *put(["LSQB"], end), *b.words[row + 1 : b.error])
            yield Repair("insert", b.base, mended, at, end, end, "LSQB"), b.error, 1


def _wrapped(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    """Routines without a module, statements without a routine."""
    if b.word.type in ENDS and not b.at_file_level:
        return
    at = b.words[0].start
    start, end = b.word.start, b.word.end
    for types in (
        ("_PROC", "NAME", "LPAR", "RPAR"),
        ("_MODULE", "NAME"),
        ("_MODULE", "NAME", "_PROC", "NAME", "LPAR", "RPAR"),
    ):
        if types[0] == "_MODULE" and not b.behind_module and MODULE.search(b.text, start + 1):
            continue
        if types[0] != "_MODULE" or ITEM.search(b.text) or len(types) > 2:
            kind = "behind" if types[0] == "_MODULE" and b.behind_module else "wrap"
            words = " ".join(type for type in types if type[0] == "_")
            wrap = Repair(kind, b.base, put(types, at), at, start, end, words)
            yield wrap, 0, 1


def _deleted(b: Broken) -> Iterator[tuple[Repair, int, int]]:
    word, row, keep = b.word, b.error + 1, len(b.types)
    if word.type == END or b.closes:
        return
    repair = Repair("delete", keep, (), word.end, word.start, word.end)
    operator = row + 1 < len(b.words) and b.words[row + 1].type in GLUE
    if word.type == "_ASSIGN" and not b.error and (operator or b.words[row].type == "NUMBER"):
        name = put(["NAME"], word.start)
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
            1 if word.type == "_ASSIGN" and not b.error else 2,
        )
        yield replace(repair, resume=further.end, end=further.end), row + 1, 2
