"""Parser of the text form: lines through the grammar, blocks by a stack, findings collected.

A block is a statement that holds others, from the line that opens it to its `end`.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from pathlib import Path as FilePath
from typing import Any, Final, Literal, cast

from lark import Token

from assistant.base.budgets import READING, within
from assistant.base.diagnostics import Diagnostic, Refused, Rule, Span, has_errors
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.program.expressions import FUNCTIONS, Expression
from assistant.program.program import Declaration, Procedure, Program, Variable
from assistant.program.pseudo.declarations import (
    read_declaration,
    read_header,
    read_parameters,
    read_variable,
)
from assistant.program.pseudo.expressions import (
    read_arguments,
    read_blend,
    read_expression,
    read_speed,
)
from assistant.program.pseudo.path_rows import RowReader, SideTables, TableReader, path_faults
from assistant.program.pseudo.statements import read_statement
from assistant.program.pseudo.words import (
    AFTER_ELSE,
    BLOCK_WORDS,
    DUPLICATE,
    FIRST_WORDS,
    INSIDE,
    LATE_VARIABLE,
    MOST_BLOCKS,
    NAME_OF_FUNCTION,
    NO_CASE,
    NO_DIVISION,
    NO_PROGRAM,
    NO_TEXT,
    NOT_ENDED,
    OUTSIDE,
    SECOND_PROGRAM,
    SURPLUS_END,
    TOO_DEEP,
    TOO_MANY,
    CodeLine,
    Node,
    Wrong,
    code_lines,
    end_of_line,
    first_word,
    parse_line,
    read_integer,
    read_name,
    read_raw,
    read_word,
    shortened,
    unquoted,
)
from assistant.program.statements import (
    ONE,
    Branch,
    Case,
    Comment,
    Follow,
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

    word: first word of its first line. span: of that line. line: its number. body: receives its
    next statement; None if a statement is not allowed here.
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


class _Ignored(Block):
    """A block whose first line was wrong: its `end` is still its own."""

    def __init__(self, word: str, span: Span, line: int) -> None:
        super().__init__(span, line)
        self.word = word

    def divide(self, *_: object) -> None:
        """Ignore the division; its content is checked for errors, and dropped."""


class _ProcedureBlock(Block):
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


class _IfBlock(Block):
    word = "if"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        self._otherwise: list[Statement] = []
        self._branches: list[tuple[Expression, list[Statement]]] = []
        self._branch(tree)

    def divide(self, division: Division, tree: Node, line: int) -> None:
        if division == "case":
            # The base class raises: a `case` has no place in an `if`.
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


class _WhileBlock(Block):
    word = "while"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        self._condition = read_expression(tree.children[0])

    def close(self, span: Span) -> Statement:
        return While(self._condition, tuple(self.body or ()), span=span)


class _ForBlock(Block):
    word = "for"

    def __init__(self, tree: Node, span: Span, line: int) -> None:
        super().__init__(span, line)
        variable, first, *limit = cast("list[Any]", tree.children)
        towards = isinstance(limit[0], Token)
        last, step = (limit[1], None) if towards else limit
        # `towards` counts in either direction: the loop states no step.
        self._variable = read_name(variable)
        self._first, self._last = read_expression(first), read_expression(last)
        self._step: Expression | None = None if towards else ONE
        if step is not None:
            self._step = read_expression(step)

    def close(self, span: Span) -> Statement:
        body = tuple(self.body or ())
        return For(self._variable, self._first, self._last, body, self._step, span=span)


class _SwitchBlock(Block):
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


class _PathBlock(Block):
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


class _OpaqueBlock(Block):
    """A text of several lines in a vendor language."""

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


_OPENING: Final[dict[str, Callable[[Node, Span, int], Block]]] = {
    "if_": _IfBlock,
    "while_": _WhileBlock,
    "for_": _ForBlock,
    "switch": _SwitchBlock,
    "follow": _PathBlock,
}
"""Rule of the first line → block."""

_DIVIDING: Final[dict[str, Division]] = {"elseif": "elseif", "else_": "else", "case": "case"}


_MOST_FINDINGS: Final = 100
"""After so many the rest is not read: the text is of another kind."""


def read(path: str | FilePath) -> Program:
    """The program of a file, its side tables beside it; raises Unreadable or Refused."""
    source = decode(read_bytes(path), str(path), ("utf-8-sig", "utf-8"))
    return parse(source, side_tables=FilePath(path).parent)


def parse(text: SourceText | str, *, side_tables: SideTables = None) -> Program:
    """The program that a text says.

    side_tables: the folder of the files that the text refers to, or their bytes by name;
    None takes the folder of the text's own file, if that is known.
    Comments where the program has no place for them move to the nearest one below which what
    they are about stands. Raises Refused with every finding, in order of lines.
    """
    source = text if isinstance(text, SourceText) else SourceText(text)
    if side_tables is None and source.path:
        side_tables = FilePath(source.path).parent
    with within(READING, source.path, len(source.text)):
        return _Reader(source, side_tables).program()


class _Reader:
    """The state of reading one text: what is open, what is declared, what is wrong."""

    def __init__(self, source: SourceText, side_tables: SideTables) -> None:
        self._source, self._side_tables = source, side_tables
        self._findings: list[Diagnostic] = []
        self._header: dict[str, str | None] | None = None
        self._header_line = 0
        self._comments: list[str] = []
        self._pending: list[CodeLine] = []
        self._tables: dict[str, dict[str, Any]] = {}
        self._first: dict[tuple[str, str], int] = {}
        self._declarations: list[Declaration] = []
        self._procedures: list[Procedure] = []
        self._stack: list[Block] = []

    def program(self) -> Program:
        odd = self._source.odd_characters()
        self._findings += islice((one for one in odd if has_errors([one])), _MOST_FINDINGS)
        for line in code_lines(self._source.text):
            self._guarded(self._line, line)
        for block in reversed(self._stack):
            self._find(NOT_ENDED, block.span, word=block.word)
        self._keep_pending()
        if self._header is None and not self._findings:
            self._find(NO_PROGRAM, Span(0, 0))
        if self._findings:
            raise Refused(*sorted(self._findings, key=lambda f: (f.line or 0, f.column or 0)))
        assert self._header is not None
        tables: dict[str, Any] = self._tables
        return Program(
            name=cast(str, self._header["name"]),
            procedures=tuple(self._procedures),
            entry=self._header["entry"],
            robot=self._header["robot"],
            comments=tuple(self._comments),
            declarations=tuple(self._declarations),
            **tables,
        )

    # ------------------------------------------------------------------------------ lines

    def _line(self, line: CodeLine) -> None:
        block = self._stack[-1] if self._stack else None
        if isinstance(block, _PathBlock):
            self._path_line(block, line)
        elif isinstance(block, _OpaqueBlock):
            self._opaque_line(block, line)
        elif not line.text:
            self._comment(line)
        elif block is None:
            self._declaration(line)
        else:
            self._statement(block, line)

    def _guarded(self, read: Callable[[CodeLine], None], line: CodeLine) -> None:
        """Reads a line; what is wrong with it becomes a finding."""
        try:
            read(line)
        except Wrong as wrong:
            self._wrong(wrong, line.span)

    def _wrong(self, wrong: Wrong, line: Span) -> None:
        span = line
        if wrong.start is not None and wrong.end is not None:
            span = Span(line.start + wrong.start, line.start + wrong.end)
        self._find(wrong.rule, span, **wrong.fields)

    def _find(self, rule: Rule, span: Span, **fields: Any) -> None:
        self._findings.append(self._source.finding(rule, span, **fields))
        if len(self._findings) >= _MOST_FINDINGS:
            last = self._source.finding(TOO_MANY, span, most=_MOST_FINDINGS)
            raise Refused(*self._findings, last)

    def _number(self, line: CodeLine) -> int:
        return self._source.line_column(line.start)[0]

    # --------------------------------------------------------------------------- comments

    def _comment(self, line: CodeLine) -> None:
        """Keeps the comment of a line: above the program, or as a statement."""
        if line.comment is None:
            return
        # A block without a body, as a `follow`, hands its comment to the block around it.
        for block in reversed(self._stack):
            if block.body is not None:
                end = line.span.end
                block.body.append(Comment(line.comment, span=Span(line.start, end)))
                return
        self._pending.append(line)

    def _keep_pending(self) -> None:
        """Comments above a declaration belong to the program as a whole."""
        self._comments += [line.comment for line in self._pending if line.comment is not None]
        self._pending.clear()

    # ---------------------------------------------------------------- outside of procedures

    def _declaration(self, line: CodeLine) -> None:
        word = first_word(line.text)
        # Reported once: the first finding explains the lines that follow.
        if self._header is None and word != "program" and not self._findings:
            self._find(NO_PROGRAM, line.span)
        if word == "end":
            raise Wrong(SURPLUS_END)
        if word in FIRST_WORDS["statement"] and word not in FIRST_WORDS["declaration"]:
            self._find(OUTSIDE, line.span, word=word)
            # The block is read to its `end`, so that its lines give no findings of their own.
            if word in BLOCK_WORDS:
                self._stack.append(_Ignored(word, line.span, self._number(line)))
            return
        if word != "procedure":
            self._keep_pending()
            self._comments += [] if line.comment is None else [line.comment]
        try:
            tree = parse_line("declaration", line.text)
            if tree.data == "procedure":
                self._procedure(tree, line)
                return
        except Wrong:
            # The `end` of a procedure with a faulty head must not end anything else.
            if word == "procedure" and not self._stack:
                self._stack.append(_Ignored(word, line.span, self._number(line)))
            raise
        if tree.data == "program":
            self._program(tree, line)
        elif tree.data == "variable":
            name, variable = read_variable(tree)
            self._declare("variables", name, variable, line)
        elif tree.data == "opaque":
            self._opaque(tree, line)
        else:
            declared = read_declaration(tree)
            assert declared is not None
            self._declare(*declared, line)

    def _program(self, tree: Node, line: CodeLine) -> None:
        if self._header is not None:
            raise Wrong(SECOND_PROGRAM, first=self._header_line)
        self._header, self._header_line = read_header(tree), self._number(line)

    def _declare(self, table: str, name: str, value: object, line: CodeLine) -> None:
        self._once(_KINDS[table], name, line)
        self._tables.setdefault(table, {})[name] = value

    def _once(self, kind: str, name: str, line: CodeLine, scope: str = "") -> None:
        number = self._number(line)
        first = self._first.get((f"{scope}{kind}", name.lower()))
        if first is not None:
            raise Wrong(DUPLICATE, kind=kind, name=shortened(name), first=first)
        self._first[f"{scope}{kind}", name.lower()] = number

    def _procedure(self, tree: Node, line: CodeLine) -> None:
        block = _ProcedureBlock(tree, line.span, self._number(line))
        self._stack.append(block)
        assert block.body is not None
        for above in (*self._pending, line):
            if above.comment is not None:
                block.body.append(Comment(above.comment, span=above.span))
        self._pending.clear()
        for name in block.parameters:
            self._once("variable", name, line, scope=f"{block.line} ")
        self._once("procedure", block.name, line)

    # ------------------------------------------------------------------------- statements

    def _statement(self, block: Block, line: CodeLine) -> None:
        word = first_word(line.text)
        outer = self._stack[0]
        if word in FIRST_WORDS["declaration"] and word not in FIRST_WORDS["statement"]:
            if not _is_assignment(line.text):
                self._find(INSIDE, line.span, word=word, first=outer.line)
                # An `end` is missing above: the procedure is read as if all blocks were closed.
                if word == "procedure":
                    self._stack.clear()
                    self._guarded(self._declaration, line)
                return
        try:
            tree = parse_line("statement", line.text)
            self._read(tree, block, line)
        except Wrong:
            # The faulty line opens a block whose `end` is still to come.
            if word in BLOCK_WORDS and self._stack[-1] is block:
                self._stack.append(_Ignored(word, line.span, self._number(line)))
            raise

    def _read(self, tree: Node, block: Block, line: CodeLine) -> None:
        rule = str(tree.data)
        if rule == "end":
            self._end(line)
            self._comment(line)
        elif rule in _DIVIDING:
            block.divide(_DIVIDING[rule], tree, self._number(line))
            self._comment(line)
        elif block.body is None:
            raise Wrong(NO_CASE)
        elif rule in _OPENING:
            if len(self._stack) > MOST_BLOCKS:
                raise Wrong(TOO_DEEP, what="block", cure="move the inner ones to procedures")
            opened = _OPENING[rule](tree, line.span, self._number(line))
            self._comment(line)
            self._stack.append(opened)
        else:
            self._comment(line)
            if rule == "variable":
                self._variable(tree, block, line)
            elif rule == "opaque":
                self._opaque(tree, line)
            else:
                statement = read_statement(tree, line.span)
                assert statement is not None, rule
                block.body.append(statement)

    def _variable(self, tree: Node, block: Block, line: CodeLine) -> None:
        name, variable = read_variable(tree)
        if isinstance(block, _Ignored):
            return
        if not isinstance(block, _ProcedureBlock) or any(
            not isinstance(statement, Comment) for statement in block.body or ()
        ):
            raise Wrong(LATE_VARIABLE)
        self._once("variable", name, line, scope=f"{block.line} ")
        block.variables[name] = variable

    def _end(self, line: CodeLine) -> None:
        block = self._stack.pop()
        span = Span(block.span.start, line.span.end)
        if isinstance(block, _ProcedureBlock):
            self._procedures.append(block.procedure())
        elif isinstance(block, _OpaqueBlock) and not self._stack:
            self._declarations.append(block.declaration())
        elif isinstance(block, _PathBlock):
            self._follow(block, span)
        else:
            self._put(block.close(span))

    def _put(self, statement: Statement | None) -> None:
        if statement is None or not self._stack:
            return
        body = self._stack[-1].body
        if body is not None:
            body.append(statement)

    # ----------------------------------------------------------------------- opaque texts

    def _opaque(self, tree: Node, line: CodeLine) -> None:
        language, text = cast("list[Any]", tree.children)
        if text is None:
            self._stack.append(_OpaqueBlock(tree, line.span, self._number(line)))
        elif self._stack:
            self._put(Opaque(read_word(language), read_raw(text), span=line.span))
        else:
            self._declarations.append(Declaration(read_word(language), read_raw(text)))

    def _opaque_line(self, block: _OpaqueBlock, line: CodeLine) -> None:
        self._comment(line)
        if line.text == "end":
            self._end(line)
        elif line.text.startswith(("|", '"')):
            said = parse_line("raw", line.text).children[0]
            block.lines.append(read_raw(cast(Token, said)))
        elif line.text:
            raise Wrong(NO_TEXT, word=shortened(line.text))

    # ------------------------------------------------------------------------------ paths

    def _path_line(self, block: _PathBlock, line: CodeLine) -> None:
        if line.comment is not None:
            self._comment(line)
        if line.text == "end":
            self._end(line)
        elif line.text:
            try:
                self._row(block, line)
            except Wrong:
                block.sound = False
                raise

    def _row(self, block: _PathBlock, line: CodeLine) -> None:
        if block.table is not None:
            block.read_column(parse_line("column", line.text))
            return
        word = first_word(line.text)
        # A statement cannot be a row: the path ends here.
        if word in FIRST_WORDS["statement"] or word == "procedure":  # an `end` is missing above
            self._find(NOT_ENDED, block.span, word="follow")
            self._stack.pop()
            self._line(line)
            return
        block.rows.read(line.text)
        block.starts.append(line.start)

    def _follow(self, block: _PathBlock, span: Span) -> None:
        # Columns with a faulty row do not fit: its finding is enough.
        if not block.sound:
            return
        if block.table is not None:
            try:
                path = block.table.path(self._side_tables)
            except Wrong as wrong:
                self._wrong(wrong, block.span)
                return
        else:
            path = block.rows.path()
            for row, rule, fields in path_faults(path):
                start = block.starts[row]
                self._find(rule, Span(start, end_of_line(self._source.text, start)), **fields)
        self._put(Follow(path, span=span))


_KINDS: Final = {
    "tools": "tool",
    "frames": "frame",
    "speeds": "speed",
    "blends": "blend",
    "signals": "signal",
    "targets": "target",
    "joint_targets": "joint target",
    "variables": "variable",
}
"""Table of the program → what a person calls its entries."""


def _is_assignment(text: str) -> bool:
    """True if a line that begins with a word of declarations assigns to a variable of that name."""
    rest = text[len(first_word(text)) :].lstrip()
    return rest.startswith(("=", ".", "["))
