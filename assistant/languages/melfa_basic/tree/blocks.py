"""The words that open, part and close the blocks of a program."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

from assistant.languages import line_blocks
from assistant.languages.line_blocks import NO_WORD, Blocks, BlockWord
from assistant.languages.melfa_basic.tree import syntax as s

CLOSING: Final = {"Next": "For", "WEnd": "While", "EndIf": "If", "End Select": "Select"}
"""Word → the kind of block that it closes."""
_BLOCK_COMMANDS: Final[Mapping[str, BlockWord]] = {
    **{word: BlockWord(closes=(kind,)) for word, kind in CLOSING.items()},
    "While": BlockWord("While", "loop"),
    "Else": BlockWord(parts="If", certain=True),
    "Default": BlockWord(parts="Select", certain=True),
    "FEnd": BlockWord(bounds="ends"),
}
_BLOCK_STATEMENTS: Final[Mapping[type, BlockWord]] = {
    s.For: BlockWord("For", "loop"),
    s.Select: BlockWord("Select", "choice"),
    s.ElseIf: BlockWord(parts="If"),
    s.Case: BlockWord(parts="Select"),
    s.Function: BlockWord(bounds="begins"),
}


def block_word(statement: s.Statement | None) -> BlockWord:
    """What a statement is to blocks; `Next M1,M2` closes two loops."""
    match statement:
        case s.Command("While", (condition, *_)) if _always_holds(condition):
            return BlockWord("While", "loop", certain=True)
        case s.Command(keyword=keyword):
            return _BLOCK_COMMANDS.get(keyword, NO_WORD)
        case s.If(then=None):
            return BlockWord("If")
        case s.Next(variables=variables):
            return BlockWord(closes=("For",) * max(1, len(variables)))
    return _BLOCK_STATEMENTS.get(type(statement), NO_WORD)


_COMPARISONS: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt,
    "<=": operator.le, ">=": operator.ge,
}  # fmt: skip


def _always_holds(condition: s.Expression | None) -> bool:
    """True for `1` and for comparisons of numbers that hold, such as `1=1`."""
    match condition:
        case s.Number(value=value):
            return bool(value)
        case s.Binary(sign, s.Number(value=one), s.Number(value=two)) if sign in _COMPARISONS:
            return _COMPARISONS[sign](one, two)
    return False


def is_block_word(statement: s.Statement | None) -> bool:
    """Whether a statement opens, parts or closes a block."""
    return block_word(statement).is_of_block


def statement_of(item: object) -> s.Statement | None:
    """The statement of a line, None for what has none."""
    return item.statement if isinstance(item, s.Line) else None


def blocks_of(code: Sequence[object], places: Iterable[int] | None = None) -> Blocks:
    """The blocks of the lines at some places, of all if none are given."""
    chosen = range(len(code)) if places is None else places
    return line_blocks.blocks_of((at, block_word(statement_of(code[at]))) for at in chosen)
