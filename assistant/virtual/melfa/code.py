"""A parsed program as rows of statements, with tables of labels, blocks, variables, branches."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field, fields, is_dataclass
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import KEYWORDS, MoveRows, PositionRows
from assistant.languages.melfa_basic.tree.control_flow import block_word
from assistant.virtual.events import Branch, Branches, BranchKey
from assistant.virtual.melfa.values import (
    DEFINED,
    SUFFIXES,
    Bare,
    Failed,
    Kind,
    Position,
    Scope,
    Value,
    eight,
)


@dataclass(frozen=True, slots=True)
class Row:
    """A statement with its label and step number. function: upper-case name, empty for none.

    line: in its file, from 1; 0 where it has none.
    """

    statement: s.Statement | None
    label: str = ""
    number: int | None = None
    function: str = ""
    line: int = 0


@dataclass(slots=True)
class Block:
    """A block of statements. kind: `If`, `For`, `While`, `Select` or `Function`. parts: rows of
    `ElseIf`, `Else`, `Case` and `Default`. end: the row that closes it. loops, branches: its
    nesting depth in blocks of those kinds, itself counted.
    """

    kind: str
    start: int
    parts: list[int] = field(default_factory=list)
    end: int = -1
    loops: int = 0
    branches: int = 0


@dataclass(slots=True)
class Code:
    """A program. inside: the innermost block of each row; opened, parted and closed: blocks by
    the row that opens, divides or closes them (`Next M1,M2` closes two).
    """

    rows: list[Row]
    labels: dict[tuple[str, str], int]
    numbers: dict[int, int]
    opened: dict[int, Block]
    parted: dict[int, Block]
    closed: dict[int, list[Block]]
    inside: list[Block | None]
    functions: dict[str, Block]
    main: Scope
    scopes: dict[str, Scope]
    data: list[tuple[str, tuple[int, ...], Value]]
    definitions: dict[str, s.DefFunction]
    signals: dict[str, s.DefIo]
    path: str = ""
    level: int = 5
    constants: set[str] = field(default_factory=set)
    takes: bool = False

    def place(self, row: int) -> tuple[str, int] | None:
        """The file and the line of a row, None where it has none."""
        return (self.path, self.rows[row].line) if row < len(self.rows) else None

    def target(self, target: s.Target, function: str) -> int:
        """The row that a jump goes to; labels of a function are its own."""
        if isinstance(target.place, int):
            at = self.numbers.get(target.place)
        else:
            name = target.place.upper()
            at = self.labels.get((function, name), self.labels.get(("", name)))
        if at is None:
            raise Failed(3600, f"the jump destination {target.place} does not exist")
        return at

    def function_of(self, block: Block) -> s.Function:
        statement = self.rows[block.start].statement
        assert isinstance(statement, s.Function)
        return statement


_FUNCTION: Final = "Function"
LOOPS: Final = ("For", "While")
_MISMATCH: Final = {"If": 3252, "For": 3230, "While": 3250, "Select": 3254, "Function": 3220}


def code_of(file: s.File) -> Code:
    """Return the tables of a file; raises Failed for unclosed blocks or an invalid line."""
    rows = list(_rows(file))
    code = Code(rows, {}, {}, {}, {}, {}, [], {}, Scope(), {}, list(_position_data(file)), {}, {})
    code.path = (file.source.path or "") if file.source is not None else ""
    code.level = int(file.dialect[-1])
    code.takes = any(isinstance(row.statement, s.FPrm) for row in rows)
    open_: list[Block] = []
    for at, row in enumerate(rows):
        if row.label:
            if (row.function, row.label) in code.labels:
                raise Failed(4440, f"the label {row.label} stands twice")
            code.labels[row.function, row.label] = at
        if row.number is not None:
            code.numbers[row.number] = at
        _blocks(code, open_, at, row.statement)
    if open_:
        raise Failed(_MISMATCH[open_[-1].kind], f"a {open_[-1].kind} is not closed")
    _scopes(code)
    return code


def _rows(file: s.File) -> Iterator[Row]:
    function = ""
    for item in file.items:
        match item:
            case s.Line(statement=statement, label=label, number=number):
                if isinstance(statement, s.Function):
                    function = statement.name.upper()
                line = _code_line(file, item.span)
                yield Row(statement, (label or "").upper(), number, function, line)
                if statement == s.Command("FEnd"):
                    function = ""
            case MoveRows():
                line = _code_line(file, item.span)
                for at in range(len(item)):
                    # Rows of moves are lines that follow each other.
                    here = line + at if line else 0
                    yield Row(_move_row(item, at), "", int(item.steps[at]), function, here)
            case s.Unread(text=text):
                raise Failed(4220, f"`{text}` is no statement")


def _code_line(file: s.File, span: Span | None) -> int:
    """Return the line of a span's beginning, from 1; 0 if it is unknown."""
    if file.source is None or span is None:
        return 0
    return file.source.line_column(span.start)[0]


def _move_row(rows: MoveRows, at: int) -> s.Motion:
    columns = (rows.start, rows.via, rows.end)
    named = [int(column[at]) for column in columns if column[at] >= 0]
    targets = tuple(s.Variable(f"{rows.stem}{number}") for number in named)
    return s.Motion(KEYWORDS[int(rows.kinds[at])], targets)


def _position_data(file: s.File) -> Iterator[tuple[str, tuple[int, ...], Value]]:
    """Variables that the file lists, with their values."""
    for item in file.items:
        match item:
            case PositionRows():
                for at in range(len(item)):
                    values = eight(tuple(float(v) for v in item.values[at]))
                    one, two = (int(flag) for flag in item.flags[at])
                    yield f"{item.stem}{item.numbers[at]}".upper(), (), Position(values, (one, two))
            case s.Data(variable=variable, value=value):
                made = constant(value)
                if made is not None:
                    yield variable.key, _position_numbers(variable), made


def _position_numbers(variable: s.Variable) -> tuple[int, ...]:
    """Subscripts, or extents."""
    return tuple(int(a.value) for a in variable.arguments or () if isinstance(a, s.Number))


def constant(node: s.Expression) -> Value | None:
    """The value of a constant, None for the form of a variable that has none: `(…)(,)`."""
    match node:
        case s.Number(value=value) | s.String(value=value):
            return value
        case s.Unary(operator="-", operand=s.Number(value=value)):
            return -value
        case s.Unary(operator="+", operand=s.Number(value=value)):
            return value
        case s.Constant(values=values, flags=None):
            return Bare(eight(values))
        case s.Constant(values=values, flags=(None, None)):
            return None
        case s.Constant(values=values, flags=flags):
            return Position(eight(values), flags or (None, None))
    raise Failed(4220, "a value that is no constant")


# ----------------------------------------------------------------------------------- blocks


def _blocks(code: Code, open_: list[Block], at: int, statement: s.Statement | None) -> None:
    word = block_word(statement)
    kind = _FUNCTION if isinstance(statement, s.Function) else word.opens
    part = word.parts
    if part:
        if not open_ or open_[-1].kind != part:
            raise Failed(_MISMATCH[part], f"a part of a {part} stands outside of one")
        open_[-1].parts.append(at)
        code.parted[at] = open_[-1]
    ends = (_FUNCTION,) if statement == s.Command("FEnd") else word.closes
    for end in ends:
        if not open_ or open_[-1].kind != end:
            raise Failed(_MISMATCH[end], f"the end of a {end} stands without its beginning")
        block = open_.pop()
        block.end = at
        code.closed.setdefault(at, []).append(block)
    # The rows that open and close a block are outside of it.
    code.inside.append(open_[-1] if open_ else None)
    if kind:
        block = Block(kind, at)
        block.loops = sum(b.kind in LOOPS for b in open_) + (kind in LOOPS)
        block.branches = sum(b.kind == "If" for b in open_) + (kind == "If")
        code.opened[at] = block
        open_.append(block)
        if isinstance(statement, s.Function):
            code.functions[statement.name.upper()] = block


# ----------------------------------------------------------------------------------- scopes


def _scopes(code: Code) -> None:
    """Types and extents; those of a function behind those of the program."""
    for name in code.functions:
        code.scopes[name] = Scope()
    marked: dict[str, Kind] = {}
    before = True
    for row in code.rows:
        # Variables named before the first function belong to the program.
        before = before and not isinstance(row.statement, s.Function)
        scope = code.scopes[row.function] if row.function else code.main
        _declare_variables(code, scope, row.statement)
        for node in nodes(row.statement):
            if isinstance(node, s.Variable):
                if node.suffix:
                    marked.setdefault(node.key, SUFFIXES[node.suffix])
                if before:
                    code.main.declared.add(node.key)
    code.main.declared.update(name for name, _, _ in code.data)
    # A mark states the type for all parts of the program, unless a definition does.
    for scope in (code.main, *code.scopes.values()):
        for name, kind in {**marked, **code.main.kinds}.items():
            scope.kinds.setdefault(name, kind)


def _declare_variables(code: Code, scope: Scope, statement: s.Statement | None) -> None:
    match statement:
        case s.DefNames(type=type_, variables=variables) if type_ in DEFINED:
            for variable in variables:
                scope.kinds[variable.key] = DEFINED[type_]
                _array_size(scope, variable)
        case s.Dim(variables=variables):
            for variable in variables:
                _array_size(scope, variable)
        case s.Const(type=type_, variable=variable):
            scope.declared.add(variable.key)
            if scope is code.main:
                code.constants.add(variable.key)
            if type_ in DEFINED:
                scope.kinds[variable.key] = DEFINED[type_]
        case s.Static(definition=definition):
            scope.static |= {variable.key for variable in definition.variables}
            _declare_variables(code, scope, definition)
        case s.DefFunction(name=name):
            code.definitions[name.upper()] = statement
        case s.DefIo(variable=variable):
            code.signals[variable.key] = statement
        case s.Function(parameters=parameters):
            for parameter in parameters or ():
                if parameter.suffix:
                    scope.kinds[parameter.name.upper()] = SUFFIXES[parameter.suffix]


def _array_size(scope: Scope, variable: s.Variable) -> None:
    scope.declared.add(variable.key)
    if variable.arguments:
        scope.sizes[variable.key] = _position_numbers(variable)


def nodes(node: Any) -> Iterator[Any]:
    """A node and all below it."""
    if isinstance(node, tuple):
        for one in node:
            yield from nodes(one)
    elif is_dataclass(node):
        yield node
        for part in fields(node):
            yield from nodes(getattr(node, part.name))


def branches(files: Sequence[s.File]) -> Branches:
    """Every way that a statement can go on; raises Failed where blocks do not close."""
    found: dict[BranchKey, Branch] = {}
    for file in files:
        code = code_of(file)
        for at, row in enumerate(code.rows):
            for way, said in _branch_ways(code, at, row.statement):
                found[code.path, at, way] = Branch(code.path, row.line, said)
    return found


def _was_waited_for(code: Code, at: int, parts: Sequence[s.Statement | None]) -> bool:
    """True if the statement before a block waits until one of its conditions holds.

    Only an input that changes between the two statements, as a key that is let go, leads past all
    of them: no run has to try that.
    """
    match code.rows[at - 1].statement if at else None:
        case s.Command(keyword=word, arguments=(condition,)) if word.upper() == "WAIT":
            asked = [part.condition for part in parts if isinstance(part, s.If | s.ElseIf)]
            return list(_alternatives(condition)) == asked
    return False


def _alternatives(condition: s.Expression | None) -> Iterator[s.Expression | None]:
    """Yield the conditions that `Or` joins."""
    match condition:
        case s.Binary(operator=word, left=left, right=right) if word.upper() == "OR":
            yield from _alternatives(left)
            yield from _alternatives(right)
        case _:
            yield condition


def _branch_ways(code: Code, at: int, statement: s.Statement | None) -> Iterator[tuple[int, str]]:
    match statement:
        case s.If(then=None):
            parts = [code.rows[part].statement for part in code.opened[at].parts]
            yield 0, "If met"
            for way, part in enumerate(parts, 1):
                yield way, "ElseIf met" if isinstance(part, s.ElseIf) else "Else"
            if not parts or isinstance(parts[-1], s.ElseIf):
                if not _was_waited_for(code, at, [statement, *parts]):
                    yield len(parts) + 1, "If not met"
        case s.DefAct():
            yield from ((0, "interrupt"), (1, "no interrupt"))
        case s.If():
            yield from ((0, "If met"), (1, "If not met"))
        case s.For(first=first, last=last):
            if not (isinstance(first, s.Number) and isinstance(last, s.Number)):
                yield from ((0, "For entered"), (1, "For passed"))
        case s.Select():
            parts = [code.rows[part].statement for part in code.opened[at].parts]
            for way, part in enumerate(parts):
                yield way, f"Case {way + 1}" if isinstance(part, s.Case) else "Default"
            if not parts or isinstance(parts[-1], s.Case):
                yield len(parts), "no Case"
        case s.OnJump(targets=targets):
            for way, target in enumerate(targets, 1):
                if target is not None:
                    yield way, f"{statement.keyword} {way}"
            yield 0, f"no {statement.keyword}"
        case s.Command(keyword=keyword, arguments=arguments) if keyword.upper() == "WHILE":
            if not isinstance(arguments[0], s.Number):
                yield from ((0, "While met"), (1, "While not met"))
