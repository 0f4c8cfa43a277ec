"""One layout for every RAPID text: indentation, blanks, blank lines and upper-case keywords.

The layout is RobotStudio's: four columns a level, `CASE` and `ERROR` at the level of what they
belong to, no blanks around operators and commas. Tokens are never added, dropped or respelt,
except that keywords become upper case; comments stay between the tokens where they were. Blanks
are between words, and before a bracket, a string or a sign that begins the first argument after a
keyword or an instruction.

    IF x=1 AND NOT y THEN
        MoveL p1,v100,z10,tool0;  ! comments after aligned lines
        Stop;                     ! stay aligned
    ENDIF
    Foo a,
            b;          a line that goes on is two levels in
"""

from __future__ import annotations

from typing import Final, Literal

from assistant.languages.rapid.reading.scanner import tokens
from assistant.languages.texts import layout
from assistant.languages.texts.layout import Cutter, Segment
from assistant.languages.texts.words import Word

_OPENS: Final = frozenset({"module", "record", "proc", "func", "trap", "for", "while", "test"})
_DIVIDES: Final = frozenset(
    {"else", "elseif", "<eit>", "case", "<cse>", "default", "backward", "error", "undo"}
)
_CLOSES: Final = frozenset(f"end{word}" for word in {*_OPENS, "if"})
_STATEMENT_HOLES: Final = frozenset({"<smt>", "<ddn>", "<tdn>", "<rdn>"})
_ENDED_BY: Final = {
    "elseif": frozenset({"then"}),
    "for": frozenset({"do"}),
    "while": frozenset({"do"}),
    "case": frozenset({":"}),
    "default": frozenset({":"}),
    "if": frozenset({"then", ";", "<smt>"}),
}

_SEGMENT_CUTTER: Final = Cutter(
    words=tokens,
    plain=lambda text, start: tokens(text, rows=False, start=start),
    scopes=frozenset({"local", "task"}),
    opens=_OPENS,
    opening={"if": "then"},
    divides=_DIVIDES,
    closes=_CLOSES,
    alone=(_DIVIDES | _CLOSES | _STATEMENT_HOLES) - _ENDED_BY.keys(),
    end=";",
    ended_by=_ENDED_BY,
    ended_before={"test": frozenset({"case", "<cse>", "default", "endtest"})},
    named=frozenset({"module", "record", "trap"}),
    headed=frozenset({"proc", "func"}),
    bracketed=frozenset({"module", "proc", "func", "error"}),
    label=":",
)


_TokenRole = Literal["operand", "key", "name", "close", "open", "sign", "late", "mark"]
"""name: of an instruction that is called. late: the `%` around a name that is worked out."""

_MARKS: Final[dict[str, _TokenRole]] = {
    **dict.fromkeys(")]}", "close"),
    **dict.fromkeys("([", "open"),
    **dict.fromkeys("+-", "sign"),
    "%": "late",
}
_BETWEEN_OPERANDS: Final = frozenset({"and", "or", "xor", "div", "mod"})
_TRUTH_WORDS: Final = frozenset({"true", "false"})


class _Spacing(layout.Spacing):
    """The tokens of one segment, in order, without its line ends and comments."""

    def __init__(self, segment: Segment) -> None:
        self._calls = segment.form == "plain" and segment.word in ("", "if")
        self._compact_if = self._calls and segment.word == "if"
        self._before: _TokenRole | None = None
        self._in_late = False

    def before(self, token: Word) -> bool:
        """True if a blank precedes the next token."""
        before, role = self._before, _token_role(token)
        ends = before in ("operand", "close")  # of an expression, if no operator follows
        self.begins_statement = (
            # In `IF a b;` the statement begins where an operand follows an operand without an
            # operator.
            self._compact_if
            and ends
            and not self._in_late
            and (role in ("operand", "late") or _starts_statement(token))
        )
        # `%` opens and closes a name that is computed; only the opening one may need a blank before
        # it.
        if role == "late":
            self._in_late = not self._in_late
            self._before = "mark" if self._in_late else "name"
            return self._in_late and before in ("operand", "close", "key")
        if role == "operand" and self._calls and (before is None or self.begins_statement):
            role = "name"
        self._before = role
        match role:
            case "operand" | "name" | "key":
                return before in ("operand", "key", "name", "close")
            case "open" | "sign":
                return before in ("key", "name")
        return False


def _token_role(token: Word) -> _TokenRole:
    if token.kind == "key":
        return "operand" if token.text.lower() in _TRUTH_WORDS else "key"
    return _MARKS.get(token.text, "mark") if token.kind == "mark" else "operand"


def _starts_statement(token: Word) -> bool:
    return token.kind == "key" and token.text.lower() not in _BETWEEN_OPERANDS


def lay_out(text: str) -> str:
    """The text in the one layout, for any text that the grammar takes; idempotent."""
    return layout.lay_out(text, list(_SEGMENT_CUTTER.segments(text)), _STYLE)


def _table_lines(table: str, indent: str, newline: str) -> str:
    """The lines of a table without the last line end: few long replacements, none by line."""
    tight = table.replace(" ", "").replace("\t", "").replace("\r", "")
    # Every line then begins with a line feed, so one `replace` a head indents all its lines.
    tight = "\n" + tight.removesuffix("\n")
    for head in ("CONST robtarget ", "LOCAL CONST robtarget ", "MoveJ ", "MoveL ", "MoveC "):
        tight = tight.replace("\n" + head.replace(" ", ""), "\n" + indent + head)
    return tight[1:].replace("\n", newline)


def _spelt_word(word: Word) -> str:
    match word.kind:
        case "key" | "hole":
            return word.text.upper()
        case "comment":
            return word.text.rstrip()
    return word.text


_STYLE: Final = layout.Style(
    _Spacing,
    _spelt_word,
    _table_lines,
    separate=frozenset({"proc", "func", "trap", "module"}),
    outermost=frozenset({"module"}),
    choosing=frozenset({"test"}),
)
