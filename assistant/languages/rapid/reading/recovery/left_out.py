"""What is put in place of a statement, declaration or head that cannot be mended."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.reading.recovery.broken import Broken, Repair, put
from assistant.languages.rapid.reading.recovery.lexemes import END, Lexeme, lexemes

HEADS: Final[dict[str, tuple[str, ...]]] = {
    "_IF": ("EXP", "_THEN"),
    "_ELSEIF": ("EXP", "_THEN"),
    "_ELSE": (),
    "_WHILE": ("EXP", "_DO"),
    "_FOR": ("NAME", "_FROM", "EXP", "_TO", "EXP", "_DO"),
    "_TEST": ("EXP", "_CASE", "EXP", "COLON"),
    "_CASE": ("EXP", "COLON"),
    "_DEFAULT": ("COLON",),
    "_ERROR": (),
    "_PROC": ("NAME", "LPAR", "RPAR"),
    "_FUNC": ("NAME", "NAME", "LPAR", "RPAR"),
    "_TRAP": ("NAME",),
    "_MODULE": ("NAME",),
}
"""What stands behind a word that opens a block or a part of one."""
LAST: Final = frozenset({"_THEN", "_DO", "COLON", "RPAR"})
"""Words that end a head."""
DATA: Final = frozenset({"VAR", "CONST", "PERS", "TASK", "LOCAL"})
GLUE: Final = frozenset(
    """COMMA LPAR LSQB LBRACE _ASSIGN BACKSLASH PLUS MINUS STAR SLASH LESS AT_MOST EQUAL MORE
    AT_LEAST UNEQUAL OR XOR AND DIV MOD DOT COLON QMARK""".split()  # noqa: SIM905
)
"""Words that a line may end or begin with in the middle of a statement."""
MODULE: Final = re.compile(r"^[ \t]*(?:module[ \t]+\w|%%%)", re.IGNORECASE | re.MULTILINE)
MOST_WORDS: Final = 2000
"""Words that the end of a damaged statement is looked for in."""


def left_out(b: Broken) -> Repair:
    """A placeholder for the statement, a whole head for a damaged one."""
    word = b.word
    blank = Repair("hole", b.base, (), word.end, word.start, max(word.end, word.start + 1))
    if b.at_file_level:
        module = MODULE.search(b.text, word.start + 1)
        if module:
            return replace(blank, resume=module.start(), kind="outside")
        silent = () if b.behind_module else put(["_MODULE", "NAME"], word.start)
        return replace(blank, resume=len(b.text), put=silent, kind="outside")
    words = b.words[: b.error] + lexemes(b.text, word.start, word.start, MOST_WORDS)
    opener = words[0]
    head = HEADS.get(opener.type)
    line_end = b.text.find("\n", word.start)
    line_end = len(b.text) if line_end < 0 else line_end
    if b.closes:
        line_end = word.start
    if head is not None and word.type != END:
        stop = None
        for later in words[b.error :]:
            if later.start >= line_end and later is not word:
                break
            if head and later.type == head[-1] and head[-1] in LAST:
                stop = later.end
        if not (opener.type == "_IF" and stop is None):
            return replace(blank, put=_head(b, words, head), resume=stop or line_end)
    resume = _next_statement(words, b.error)
    types = ("DDN",) if opener.type in DATA else ("SMT", "RDN", "DDN")
    for type in types:
        if b.fits((type,)):
            return replace(blank, put=put([type], opener.start), resume=resume)
    return replace(blank, resume=resume)


def _head(b: Broken, words: list[Lexeme], head: tuple[str, ...]) -> tuple[Lexeme, ...]:
    """A whole head, with the names that were read; nothing where none may stand."""
    kept = [words[0]]
    for type, word in zip(head, words[1 : b.error], strict=False):
        if type != word.type:
            break
        kept.append(word)
    rest = put(head[len(kept) - 1 :], kept[-1].end)
    whole = (*kept, *rest)
    return whole if b.fits([w.type for w in whole]) else ()


def _next_statement(words: list[Lexeme], error: int) -> int:
    """Offset behind the `;` of a damaged statement, or where another one begins."""
    for row in range(error, len(words)):
        word = words[row]
        if word.type == "SEMICOLON":
            return word.end
        if word.type == END:
            return word.start
        fresh = word.first and row and words[row - 1].type not in GLUE and word.type not in GLUE
        if fresh and word.type not in ("RPAR", "RSQB", "RBRACE"):
            return word.start
    return words[-1].start
