"""The grammar of the text form, and what it says about a line that does not fit it."""

from __future__ import annotations

import difflib
import re
from functools import cache
from typing import TYPE_CHECKING, Final, Literal

from lark import Token, Tree

from assistant.program.pseudo.findings import (
    MOST_DEEP,
    TOO_DEEP,
    UNEXPECTED,
    UNFINISHED,
    UNKNOWN_WORD,
    Wrong,
)
from assistant.program.pseudo.words import Node, shortened
from assistant.resources import read_grammar

if TYPE_CHECKING:
    from lark import Lark
    from lark.lexer import TerminalDef

Start = Literal["declaration", "statement", "row", "attributes", "column", "raw"]

BLOCK_WORDS: Final = ("if", "while", "for", "switch", "follow")
"""First words of statements that `end` ends."""

_BOTH: Final = ("local", "constant", "variable", "persistent", "opaque")
FIRST_WORDS: Final[dict[str, tuple[str, ...]]] = {
    "declaration": (
        *("program", "tool", "frame", "speed", "blend", "signal", "target", "joints", "procedure"),
        *_BOTH,
    ),
    "statement": (
        *("move", "follow", "wait", "set", "open", "close", "acceleration", "override", "call"),
        *("if", "elseif", "else", "while", "for", "switch", "case", "end", "stop", "exit"),
        *("return", "label", "goto", "message", "restart", "travel"),
        *_BOTH,
    ),
    "row": ("joint", "linear", "via", "to"),
    "column": ("speed", "blend", "tool", "frame"),
}
"""The words that a line can begin with, by start rule."""

_SPOKEN: Final = {
    "NAME": "a name",
    "QUOTED_NAME": "a name",
    "WORD": "a name",
    "OPEN": "`[]`",
    "STRING": '"a text"',
    "NUMBER": "a number",
    "SIGNED": "a number",
    "INTEGER": "a whole number",
    "DIGEST": "64 hexadecimal digits",
    "RAW": "`|` and a text",
    "$END": "the end of the line",
    "TIMES": "`*`",
    "COMPARISON": "`<`",
    "TRUTH": "a name",
    "INFINITE": "a number",
    "NAN": "a number",
    "WITHOUT_ENTRY": "`without entry`",
    "FREE_TURN": "`free turn`",
}
_MOST_EXPECTED: Final = 8
_GOING_ON: Final = frozenset(f"`{word}`" for word in ("or", "xor", "and", "=", "+", "-", "*", "^"))
"""What could make an expression longer; seldom what is missing."""


def parse_line(start: Start, text: str) -> Node:
    """The tree of one line; raises Wrong with the column of what does not fit."""
    from lark import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

    try:
        tree = _grammar().parse(text, start=start)
    except UnexpectedInput as error:
        position: int = len(text)
        found = ""
        if isinstance(error, UnexpectedToken) and error.token.type != "$END":
            position, found = error.token.start_pos or 0, str(error.token)
        elif isinstance(error, UnexpectedCharacters):
            position = error.pos_in_stream or 0
            found = text[position]
        expected = getattr(error, "accepts", None) or getattr(error, "allowed", None) or set()
        raise _wrong(start, text, position, found, set(expected)) from None
    if len(text) > MOST_DEEP and _is_deeper(tree, MOST_DEEP):
        raise Wrong(TOO_DEEP, what="expression", cure="split it into several")
    return tree


def first_word(text: str) -> str:
    found = re.match(r"\s*(\w+)", text)
    return found[1] if found else ""


def _is_deeper(tree: Node, most: int) -> bool:
    """Whether a tree has more levels; looked at without recursion."""
    level = [tree]
    for _ in range(2 * most):  # two rules of the grammar to one of an expression, at the most
        level = [child for node in level for child in node.children if isinstance(child, Tree)]
        if not level:
            return False
    return True


@cache
def _grammar() -> Lark:
    from lark import Lark

    return Lark(
        read_grammar("pseudo.lark"),
        parser="lalr",
        start=["declaration", "statement", "row", "attributes", "column", "raw"],
        maybe_placeholders=True,
        propagate_positions=True,
        edit_terminals=_whole_words_only,
    )


def _whole_words_only(terminal: TerminalDef) -> None:
    """Keeps a keyword from matching the beginning of a longer word."""
    from lark.lexer import PatternRE, PatternStr

    if isinstance(terminal.pattern, PatternStr) and terminal.pattern.value[-1].isalnum():
        terminal.pattern = PatternRE(re.escape(terminal.pattern.value) + r"(?!\w)")
        terminal.priority = 1


def _wrong(start: Start, text: str, position: int, found: str, expected: set[str]) -> Wrong:
    word = first_word(text)
    after = len(text) - len(text.lstrip()) + len(word)
    words = FIRST_WORDS.get(start, ())
    if word and word not in words and not text[after:position].strip():
        near = difflib.get_close_matches(word.lower(), words, n=3)
        cure = " or ".join(f"`{n}`" for n in near or words[:_MOST_EXPECTED])
        whole = Token("WORD", word, after - len(word), end_pos=after)
        return Wrong(UNKNOWN_WORD, whole, word=shortened(word), cure=f"write {cure}")
    spoken = _spoken(expected)
    if not found:
        here = Token("END", "", max(len(text.rstrip()) - 1, 0), end_pos=len(text.rstrip()))
        return Wrong(UNFINISHED, here, expected=spoken)
    here = Token("FOUND", found, position, end_pos=position + len(found))
    return Wrong(UNEXPECTED, here, found=f"`{shortened(found)}`", expected=spoken)


def _spoken(expected: set[str]) -> str:
    """The terminals in words that a person would write."""
    patterns = {t.name: t.pattern for t in _grammar().terminals}
    said = set()
    for name in expected:
        if name in _SPOKEN:
            said.add(_SPOKEN[name])
        elif name in patterns:
            plain = patterns[name].value.removesuffix(r"(?!\w)")
            words = plain[1:-1].split("|") if "|" in plain else [plain]
            said.update("`" + word.replace("\\", "") + "`" for word in words)
    said = (said - _GOING_ON) or said
    order = sorted(said, key=lambda s: (s.startswith("`"), s))
    more = ["…"] if len(order) > _MOST_EXPECTED else []
    return ", ".join(order[:_MOST_EXPECTED] + more) or "something else"
