"""Words of the text form: names, quoted texts and numbers, as text and back."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Final, TypeAlias

from lark import Token, Tree

from assistant.program.program import IDENTIFIER
from assistant.program.pseudo.findings import BAD_ESCAPE, COUNT, NUMBER_SIZE, Wrong

Node: TypeAlias = Tree[Token]

KEYWORDS: Final = frozenset(
    {
        *("acceleration", "attach", "call", "case", "close", "constant", "detach", "else"),
        *("elseif", "end", "exit", "false", "fine", "follow", "for", "full", "goto", "if", "inf"),
        *("inout", "interrupt", "interrupts", "joints", "label", "local", "maximum", "message"),
        *("move", "nan", "not", "opaque", "open", "override", "persistent", "pose", "restart"),
        *("return", "send", "set", "stop", "switch", "target", "travel", "true", "until"),
        *("variable", "verbatim", "wait", "while"),
    }
)
"""Words that mean something where a name may stand too; a name like them is quoted."""

_WORD: Final = re.compile(r"[A-Za-z][A-Za-z0-9_.\-]*")
_ESCAPE: Final = re.compile(r"\\(x[0-9A-Fa-f]{2}|u[0-9A-Fa-f]{4}|U[0-9A-Fa-f]{8}|.|$)", re.DOTALL)
_SHORT: Final = {"n": "\n", "r": "\r", "t": "\t", "\\": "\\", '"': '"', "`": "`"}
_LONG: Final = {"\n": "\\n", "\r": "\\r", "\t": "\\t", "\\": "\\\\"}


def name_text(name: str) -> str:
    """A name, in backquotes if it would not be read as one."""
    if IDENTIFIER.fullmatch(name) and name not in KEYWORDS:
        return name
    return quoted(name, "`")


def word_text(word: str) -> str:
    """The name of a robot or a language, quoted if it is of unusual letters."""
    return word if _WORD.fullmatch(word) else quoted(word)


def quoted(text: str, mark: str = '"') -> str:
    """The text between marks, whatever it holds; no line end, no invisible character stays."""
    return mark + "".join(_escaped(c, mark) for c in text) + mark


def unquoted(token: Token) -> str:
    """What a quoted text says; raises Wrong for an unknown escape."""

    def meant(found: re.Match[str]) -> str:
        body = found[1]
        if body in _SHORT:
            return _SHORT[body]
        if len(body) > 1 and int(body[1:], 16) <= 0x10FFFF:
            return chr(int(body[1:], 16))
        raise Wrong(BAD_ESCAPE, token, escape=found[0])

    return _ESCAPE.sub(meant, token[1:-1])


def read_name(tree: Node) -> str:
    token = tree.children[0]
    assert isinstance(token, Token)
    return unquoted(token) if token.type == "QUOTED_NAME" else str(token)


def read_word(tree: Node) -> str:
    token = tree.children[0]
    assert isinstance(token, Token)
    return unquoted(token) if token.type == "STRING" else str(token)


def number_text(number: float) -> str:
    """The shortest text that gives the same float; whole numbers without a point."""
    text = repr(float(number))
    if text == "nan":
        return "_"
    return text.removesuffix(".0")


def numbers_text(numbers: Iterable[float]) -> str:
    return "[" + ", ".join(map(number_text, numbers)) + "]"


def read_number(token: Token) -> float:
    """A float; `_` and `nan` are NaN. Raises Wrong for what only overflow makes infinite."""
    if token == "_":  # noqa: S105 - a number, no secret
        return math.nan
    number = float(token)
    if math.isinf(number) and not token.endswith("inf"):
        raise Wrong(NUMBER_SIZE, token, number=shortened(token))
    return number


def read_integer(token: Token) -> int:
    """Raises Wrong beyond what a float holds: no controller's number reaches further."""
    if math.isinf(float(token)):
        raise Wrong(NUMBER_SIZE, token, number=shortened(token))
    return int(token)


def read_numbers(tree: Node, *counts: int) -> tuple[float, ...]:
    """The numbers in brackets; raises Wrong if there are not as many as one of the counts."""
    tokens = [t for t in tree.children if isinstance(t, Token)]
    if counts and len(tokens) not in counts:
        expected = " or ".join(map(str, counts))
        plural = "" if len(tokens) == 1 else "s"
        raise Wrong(COUNT, tree, count=len(tokens), s=plural, expected=expected)
    return tuple(map(read_number, tokens))


def shortened(text: str, most: int = 24) -> str:
    """As it can stand in a message: of one line, visible, not too long."""
    text = "".join(_escaped(c, "") for c in text[: most + 1])
    return text if len(text) <= most else text[: most - 1] + "…"


# ------------------------------------------------------------------------ comments and raw lines


_COMMENT: Final = re.compile(r"""(?:[^"`#]|"(?:[^"\\]|\\.)*+"|`(?:[^`\\]|\\.)*+`)*+(?=#)""")
_QUOTED_COMMENT: Final = re.compile(r'"(?:[^"\\]|\\.)*+"')


def comment_text(comment: str) -> str:
    """`# comment`, or `#"comment"` if it holds what a line cannot show."""
    if _is_plain(comment) and comment == comment.strip():
        return f"# {comment}".rstrip()
    return "#" + quoted(comment)


def read_comment(text: str) -> str:
    """What a text that begins with `#` says."""
    said = text[1:].strip()
    if text.startswith('#"') and _QUOTED_COMMENT.fullmatch(said):
        try:
            return unquoted(Token("STRING", said))
        except Wrong:
            return said  # somebody's own comment that looks like a quoted one
    return said


def split_comment(line: str) -> tuple[str, str | None]:
    """A line without its comment, and the comment's text if there is one."""
    found = _COMMENT.match(line) if "#" in line else None
    if found is None:
        return line, None
    return line[: found.end()], read_comment(line[found.end() :])


def raw_text(text: str) -> str:
    """One line of opaque text: `| text` as it is, quoted if a line cannot show it."""
    if text and not (_is_plain(text) and text == text.rstrip()):
        return quoted(text)
    return f"| {text}".rstrip()


def read_raw(token: Token) -> str:
    return unquoted(token) if token.type == "STRING" else token[1:].removeprefix(" ")


def _is_plain(text: str) -> bool:
    return text.replace("\t", " ").isprintable()


def _escaped(character: str, mark: str) -> str:
    if character == mark:
        return "\\" + mark
    if character in _LONG:
        return _LONG[character]
    if character.isprintable():
        return character
    code = ord(character)
    return (
        f"\\x{code:02x}"
        if code < 0x100
        else f"\\u{code:04x}"
        if code < 0x10000
        else f"\\U{code:08x}"
    )
