"""What is put in place of a statement, declaration or head that cannot be mended."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import Final

from assistant.languages.lalr import END
from assistant.languages.recovery.broken import Broken, Repair
from assistant.languages.recovery.lexemes import Lexeme

MOST_SKIPPED_WORDS: Final = 2000
"""Words that the end of a damaged statement is looked for in."""
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
    """The words from the error on, read as far as they are asked for."""
    return islice(b.syntax.scanner.words(b.text, b.word.start), MOST_SKIPPED_WORDS + 1)


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
    """Offset behind the end of a damaged statement, or where another one begins."""
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
