"""What changing a code line in place has to know of MELFA-BASIC."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from assistant.languages.melfa_basic.reading.parser import statement as read
from assistant.languages.melfa_basic.text.layout.tokens import tokens
from assistant.languages.melfa_basic.text.printer import line as printed
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.texts import changed_lines
from assistant.languages.texts.words import Word


def of_line(item: s.Line) -> changed_lines.Line:
    """What a line says: its code is the line without number and comment."""
    code = s.Line(label=item.label, statement=item.statement)
    return changed_lines.Line(item.number, None if code == s.Line() else code, item.comment)


@dataclass(frozen=True, slots=True)
class Code(changed_lines.Code):
    """upper: keywords are in upper case."""

    upper: bool

    def printed(self, code: s.Line | None) -> str:
        return "" if code is None else printed(code, self.upper)

    def words(self, text: str) -> Sequence[Word]:
        return tokens(text)

    def key(self, word: Word) -> str | float:
        """The value of a number; any other text without blanks in lower case."""
        if word.kind == "NUMBER":
            return float(word.text)
        return "".join(word.text.split()).casefold()

    def says(self, text: str, code: s.Line | None) -> bool:
        return read(text) == code
