r"""Blanks between the tokens of one line of RAPID: between words, and nowhere else but where a
bracket, a string or a sign behind a keyword or an instruction begins its first argument.
"""

from __future__ import annotations

from typing import Final, Literal

from assistant.languages.texts import layout
from assistant.languages.texts.layout import Segment
from assistant.languages.texts.words import Word

TokenRole = Literal["operand", "key", "name", "close", "open", "sign", "late", "mark"]
"""name: of an instruction that is called. late: the `%` around a name that is worked out."""

_MARKS: Final[dict[str, TokenRole]] = {
    **dict.fromkeys(")]}", "close"),
    **dict.fromkeys("([", "open"),
    **dict.fromkeys("+-", "sign"),
    "%": "late",
}
_BETWEEN_OPERANDS: Final = frozenset({"and", "or", "xor", "div", "mod"})
_TRUTH_WORDS: Final = frozenset({"true", "false"})


class Spacing(layout.Spacing):
    """The tokens of one segment, in order, without its line ends and comments."""

    def __init__(self, segment: Segment) -> None:
        self._calls = segment.form == "plain" and segment.word in ("", "if")
        self._compact_if = self._calls and segment.word == "if"
        self._before: TokenRole | None = None
        self._in_late = False

    def before(self, token: Word) -> bool:
        """Whether a blank stands before the next token."""
        before, role = self._before, _token_role(token)
        ends = before in ("operand", "close")  # of an expression, if no operator follows
        self.begins_statement = (
            self._compact_if
            and ends
            and not self._in_late
            and (role in ("operand", "late") or _starts_statement(token))
        )
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


def _token_role(token: Word) -> TokenRole:
    if token.kind == "key":
        return "operand" if token.text.lower() in _TRUTH_WORDS else "key"
    return _MARKS.get(token.text, "mark") if token.kind == "mark" else "operand"


def _starts_statement(token: Word) -> bool:
    return token.kind == "key" and token.text.lower() not in _BETWEEN_OPERANDS
