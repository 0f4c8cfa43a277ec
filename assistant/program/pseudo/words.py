"""Words, lines and grammar of the text form, and the findings about a text that does not fit.

Names, quoted texts and numbers, to text and from it; lines without their comments; the lark grammar
of a line, with the words that would have fitted.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from lark import Token, Tree

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Rule, Span, error
from assistant.base.near_names import spelled_like
from assistant.base.source_text import with_line_feeds
from assistant.program.program import IDENTIFIER
from assistant.resources import read_grammar

if TYPE_CHECKING:
    from lark import Lark
    from lark.lexer import TerminalDef


UNEXPECTED = error("PS101", "{found} cannot stand here", "write {expected}")
UNFINISHED = error("PS102", "the line is not finished", "go on with {expected}")
UNKNOWN_WORD = error("PS103", "no line begins with `{word}`", "{cure}")
BAD_ESCAPE = error(
    "PS104", "`{escape}` is no escape", r"write one of \\ \" \` \n \r \t \x.. \u.... \U........"
)
TOO_DEEP = error("PS105", "the {what} is nested too deeply", "{cure}")
TOO_MANY = error("PS106", "more than {most} findings", "is this a pseudo-program?")

MOST_DEEP: Final = 100
"""Levels of brackets and operators in an expression."""
MOST_BLOCKS: Final = 50
"""Blocks in one another."""

NO_PROGRAM = error(
    "PS201", "the text does not begin with a `program` line", "begin with `program <name>`"
)
SECOND_PROGRAM = error(
    "PS202", "a second `program` line; the first is line {first}", "remove one of them"
)
DUPLICATE = error(
    "PS203",
    "the {kind} `{name}` is declared twice; first in line {first}",
    "rename one of them; names are compared without case",
)
OUTSIDE = error(
    "PS204", "`{word}` stands outside of a procedure", "put it between `procedure` and `end`"
)
INSIDE = error(
    "PS205",
    "`{word}` stands inside the procedure of line {first}",
    "end that procedure first; an `end` may be missing above",
)
LATE_VARIABLE = error(
    "PS206", "a variable is declared after a statement", "move it up below `procedure`"
)

SURPLUS_END = error("PS211", "`end` ends nothing", "remove it, or look for a missing line above")
NOT_ENDED = error("PS212", "`{word}` is never ended", "write `end` where its lines are over")
NO_DIVISION = error("PS213", "`{word}` does not belong to {block}", "`{word}` divides {owners}")
AFTER_ELSE = error("PS214", "`{word}` after the `else` of line {first}", "move it above `else`")
NO_CASE = error("PS215", "a statement before the first `case`", "write a `case` above it")
NO_TEXT = error(
    "PS216", "`{word}` is no line of an opaque text", 'begin it with `|`, or quote it with `"`'
)
NAME_OF_FUNCTION = error(
    "PS217",
    "the procedure `{name}` has the name of the function `{function}`, which calls would mean",
    "choose another name",
)

NUMBER_SIZE = error("PS301", "`{number}` is too large", "write a smaller number")
COUNT = error(
    "PS302", "{count} number{s} in brackets instead of {expected}", "write {expected} numbers"
)
NOT_UNIT = error(
    "PS303", "the quaternion is of length {length:.6g}", "give a unit quaternion [w, x, y, z]"
)
NOT_FINITE = error("PS304", "{what} is not a finite number", "write a finite number")
NOT_ASSIGNABLE = error(
    "PS305", "this cannot be assigned to", "assign to a name, a component or an array element"
)
QUADRANT = error("PS306", "quadrant {number} is beyond -128 to 127", "write the true quadrant")
NO_PLACE = error(
    "PS307",
    "`here` does not say which tool it is of, and in which frame",
    "write both names, as `here(tool0, base)`",
)

INCOMPLETE_ROW = error(
    "PS401", "the first row of a path states no {what}", "state it, as `{example}`"
)
LONE_VIA = error("PS402", "a `via` row without a `to` row after it", "add the end of the arc")
LONE_TO = error("PS403", "a `to` row without a `via` row before it", "add a point of the arc")

NO_FOLDER = error(
    "PS411",
    "the path is in the side table `{name}`, and it is not known where that is",
    "name the folder that holds it",
)
NOT_BARE = error("PS412", "`{name}` is no plain file name", "put the side table beside the text")
NO_TABLE = error(
    "PS413", "the side table `{name}` cannot be read: {reason}", "put it beside the text"
)
OTHER_TABLE = error(
    "PS414",
    "the side table `{name}` is not the one that the text was written with",
    "take the text and its tables from the same place; their sha256 sums differ",
)
BAD_TABLE = error(
    "PS415", "the side table `{name}` is damaged: {reason}", "write the program again"
)


class Wrong(Exception):
    """Something wrong in one line: a rule, its fields, and the columns it is about.

    start, end: offsets in the line; None for the whole line.
    """

    def __init__(self, rule: Rule, at: Token | Tree[Token] | None = None, **fields: Any) -> None:
        super().__init__(rule.code)
        self.rule: Final = rule
        self.fields: Final = fields
        self.start, self.end = _columns(at)


def _columns(at: Token | Tree[Token] | None) -> tuple[int | None, int | None]:
    if isinstance(at, Token):
        return at.start_pos, at.end_pos
    if at is None or at.meta.empty:
        return None, None
    return at.meta.start_pos, at.meta.end_pos


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
    """Return the content of a quoted text; raises Wrong for an unknown escape."""

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
    """Return a text fit for a message: one line, visible, not too long."""
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
    """Return the content of a text that begins with `#`."""
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


@dataclass(slots=True)
class CodeLine:
    """A line without comment and outer blanks, and where it begins in the text, as an offset."""

    text: str
    start: int
    comment: str | None

    @property
    def span(self) -> Span:
        return Span(self.start, self.start + len(self.text))


def code_lines(source: str) -> Iterator[CodeLine]:
    """The lines of a text that say anything, with their comments taken apart."""
    start = 0
    for whole in with_line_feeds(source).split("\n"):
        text = whole.lstrip(" \t\f\r\ufeff" if not start else " \t\f\r")
        begin = start + len(whole) - len(text)
        start += len(whole) + 1
        text = text.rstrip("\r")
        if text.startswith("|") or (text.startswith("opaque") and "|" in text):
            yield CodeLine(text, begin, None)  # whatever stands behind `|` is as it is
            continue
        said, comment = split_comment(text)
        said = said.rstrip()
        if said or comment is not None:
            yield CodeLine(said, begin, comment)


def end_of_line(source: str, start: int) -> int:
    """The offset of the end of the line that an offset stands on."""
    end = with_line_feeds(source).find("\n", start)
    return len(source) if end < 0 else end


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
"""Tokens that could make an expression longer; they are seldom the missing ones."""


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
    """True if a tree has more levels; works without recursion."""
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
        near = spelled_like(word, words, 3, least=0.6)
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
