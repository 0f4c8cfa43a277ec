"""Blocks: the statements that hold others, from the line that opens them to their `end`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, Literal, cast

from lark import Token

from assistant.program.diagnostics import Span
from assistant.program.expressions import FUNCTIONS, Expression
from assistant.program.program import Declaration, Procedure, Variable
from assistant.program.pseudo.declarations import read_parameters
from assistant.program.pseudo.expressions import read_arguments, read_expression
from assistant.program.pseudo.findings import AFTER_ELSE, NAME_OF_FUNCTION, NO_DIVISION, Wrong
from assistant.program.pseudo.rows import RowReader
from assistant.program.pseudo.tables import TableReader
from assistant.program.pseudo.values import read_blend, read_speed
from assistant.program.pseudo.words import Node, read_integer, read_name, read_word, unquoted
from assistant.program.statements import (
    ONE,
    Branch,
    Case,
    For,
    If,
    Opaque,
    Statement,
    Switch,
    While,
)

Division = Literal["elseif", "else", "case"]

_OWNERS: Final = {"elseif": "`if`", "else": "`if` and `switch`", "case": "`switch`"}


class Block:
    """An open block.

    word: how its first line begins. span: of that line. line: its number.
    body: where its next statement goes; None if none may stand there.
    """

    word: str = ""

    def __init__(self, span: Span, line: int) -> None:
        self.span, self.line = span, line
        self.body: list[Statement] | None = []
        self._else_line: int | None = None

    def divide(self, division: Division, tree: Node, line: int) -> None:  # noqa: ARG002
        """Begins the next part; raises Wrong if the block has no such part here."""
        raise Wrong(NO_DIVISION, word=division, block=f"`{self.word}`", owners=_OWNERS[division])

    def close(self, span: Span) -> Statement | None:  # noqa: ARG002
        """The statement of the whole block."""
        return None

    def _only_before_else(self, division: Division, line: int) -> None:
        if self._else_line is not None:
            raise Wrong(AFTER_ELSE, word=division, first=self._else_line)
        if division == "else":
            self._else_line = line


class Ignored(Block):
    """A block whose first line was wrong: its `end` is still its own."""

    def __init__(self, word: str, span: Span, line: int) -> None:
        super().__init__(span, line)
        self.word = word

    def divide(self, *_: object) -> None:
        """Whatever stands in it is read for what is wrong there, and dropped."""


class ProcedureBlock(Block):
    word = "procedure"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        name, parameters, result, unit, local = cast("list[Any]", tree.children)
        self.name = read_name(name)
        self._parameters = read_parameters(parameters)
        self.parameters = [parameter.name for parameter in self._parameters]
        self.variables: dict[str, Variable] = {}
        self._result = None if result is None else str(result)
        if self._result is not None and (function := self.name.lower()) in FUNCTIONS:
            raise Wrong(NAME_OF_FUNCTION, name, name=self.name, function=function)
        self._unit = None if unit is None else read_name(unit)
        self._local = local is not None

    def procedure(self) -> Procedure:
        return Procedure(
            self.name,
            tuple(self.body or ()),
            self._parameters,
            self.variables,
            cast(Any, self._result),
            self._unit,
            self._local,
        )


class IfBlock(Block):
    word = "if"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        self._otherwise: list[Statement] = []
        self._branches: list[tuple[Expression, list[Statement]]] = []
        self._branch(tree)

    def divide(self, division: Division, tree: Node, line: int) -> None:
        if division == "case":
            super().divide(division, tree, line)
        self._only_before_else(division, line)
        if division == "elseif":
            self._branch(tree)
        else:
            self.body = self._otherwise

    def close(self, span: Span) -> Statement:
        branches = tuple(Branch(condition, tuple(body)) for condition, body in self._branches)
        return If(branches, tuple(self._otherwise), span=span)

    def _branch(self, tree: Node) -> None:
        self.body = []
        self._branches.append((read_expression(tree.children[0]), self.body))


class WhileBlock(Block):
    word = "while"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        self._condition = read_expression(tree.children[0])

    def close(self, span: Span) -> Statement:
        return While(self._condition, tuple(self.body or ()), span=span)


class ForBlock(Block):
    word = "for"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        variable, first, *limit = cast("list[Any]", tree.children)
        towards = isinstance(limit[0], Token)
        last, step = (limit[1], None) if towards else limit
        self._variable = read_name(variable)
        self._first, self._last = read_expression(first), read_expression(last)
        self._step: Expression | None = None if towards else ONE
        if step is not None:
            self._step = read_expression(step)

    def close(self, span: Span) -> Statement:
        body = tuple(self.body or ())
        return For(self._variable, self._first, self._last, body, self._step, span=span)


class SwitchBlock(Block):
    word = "switch"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        self._subject = read_expression(tree.children[0])
        self._cases: list[tuple[tuple[Expression, ...], list[Statement]]] = []
        self._otherwise: list[Statement] = []
        self.body = None

    def divide(self, division: Division, tree: Node, line: int) -> None:
        if division == "elseif":
            super().divide(division, tree, line)
        self._only_before_else(division, line)
        if division == "case":
            self.body = []
            self._cases.append((read_arguments(tree.children[0]), self.body))
        else:
            self.body = self._otherwise

    def close(self, span: Span) -> Statement:
        cases = tuple(Case(values, tuple(body)) for values, body in self._cases)
        return Switch(self._subject, cases, tuple(self._otherwise), span=span)


class PathBlock(Block):
    """`follow`: rows, or the tables of a path whose columns are in a file."""

    word = "follow"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        name, file, rows, digest = cast("list[Any]", tree.children)
        self.body = None
        self.sound = True
        self.starts: list[int] = []
        self.rows = RowReader(read_name(name))
        self.table: TableReader | None = None
        if file is not None:
            count = read_integer(cast(Token, rows))
            self.table = TableReader(
                read_name(name), file, unquoted(file), max(count, 0), str(digest)
            )

    def read_column(self, tree: Node) -> None:
        """One entry of one of the tables."""
        assert self.table is not None
        entry = tree.children[0]
        if tree.data == "speed_column":
            self.table.speeds.append(read_speed(entry))
        elif tree.data == "blend_column":
            self.table.blends.append(read_blend(entry))
        elif tree.data == "tool_column":
            self.table.tools.append(read_name(cast(Node, entry)))
        else:
            self.table.frames.append(read_name(cast(Node, entry)))


class OpaqueBlock(Block):
    """A text of several lines in a language of its own."""

    word = "opaque"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        self.body = None
        self._language = read_word(cast(Node, tree.children[0]))
        self.lines: list[str] = []

    def declaration(self) -> Declaration:
        return Declaration(self._language, "\n".join(self.lines))

    def close(self, span: Span) -> Statement:
        return Opaque(self._language, "\n".join(self.lines), span=span)


OPENING: Final[dict[str, Callable[[Node, Span, int], Block]]] = {
    "if_": IfBlock,
    "while_": WhileBlock,
    "for_": ForBlock,
    "switch": SwitchBlock,
    "follow": PathBlock,
}
"""Rule of the first line → block."""

DIVIDING: Final[dict[str, Division]] = {"elseif": "elseif", "else_": "else", "case": "case"}
