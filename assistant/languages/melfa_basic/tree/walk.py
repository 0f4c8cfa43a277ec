"""Nodes of lines, statements and expressions: what they declare, read, write, call and report.

Commands of the maker's own, such as force control, have no equivalent in other languages: a
program there calls a routine that the cell supplies, and the states that belong to it become data
which these routines read and write.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from functools import cache
from pathlib import PurePath
from typing import Any, Final, Literal, TypeVar

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Span
from assistant.languages.language_types import Part
from assistant.languages.melfa_basic.tables.vocabulary import ANY, commands, function, statements
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import PositionRows
from assistant.languages.nodes import Walk

N = TypeVar("N")

_WALK: Final = Walk(is_dataclass)
nodes: Final = _WALK.nodes
inside: Final = _WALK.inside

_WORDS: Final[dict[type, str]] = {
    s.Include: "#Include", s.DefAct: "Def Act", s.DefFunction: "Def FN", s.DefIo: "Def Io",
}  # fmt: skip


SUFFIXES: Final = (".PRG", ".MB4", ".MB5", ".MB6")
"""Program names in upper case; the first file wins where several have the same name."""


def word_of(statement: s.Statement | None) -> str:
    """The word that a statement begins with, as the tools spell it; empty if it has none."""
    match statement:
        case s.Command(keyword=keyword) | s.Motion(keyword=keyword) | s.Jump(keyword=keyword):
            return keyword
        case s.DefNames(type=kind) | s.DefOther(kind=kind):
            return f"Def {kind}"
        case None | s.Assign():
            return ""
    return _WORDS.get(type(statement), type(statement).__name__)


def declarations(statement: s.Statement | None) -> Iterator[tuple[s.Variable, str]]:
    """The variables that a statement declares, with the word of their type, empty for none."""
    match statement:
        case s.Static(definition):
            yield from declarations(definition)
        case s.DefNames(type, variables):
            yield from ((variable, type) for variable in variables)
        case s.Dim(variables):
            yield from ((variable, "") for variable in variables)
        case s.DefIo(variable):
            yield variable, ""
        case s.Const(type, variable, value):
            yield variable, type or ("Char" if isinstance(value, s.String) else "")


def statements_in(statement: s.Statement | s.Target | None) -> Iterator[s.Statement]:
    """The statement of a line and those of its branches, if it is an `If` on one line."""
    if statement is not None and not isinstance(statement, s.Target):
        yield statement
    if isinstance(statement, s.If):
        yield from statements_in(statement.then)
        yield from statements_in(statement.otherwise)


def lines_with(items: Iterable[object], kind: type[N]) -> Iterator[tuple[s.Line, N]]:
    """The lines whose statement is of a kind, each with it."""
    for item in items:
        if isinstance(item, s.Line) and isinstance(item.statement, kind):
            yield item, item.statement


def program_name(tree: s.File) -> str:
    """The name that other programs call a file by, empty if it has none."""
    path = tree.source.path if tree.source else None
    return PurePath(path.replace("\\", "/")).stem if path else ""


def program_stem(name: str) -> str:
    """The name of a program without the suffix of its file, which a call may have."""
    return name[:-4] if name.upper().endswith(SUFFIXES) else name


def program_key(name: str) -> str:
    """The name by which a program is found: in upper case, without the suffix of its file."""
    return program_stem(name).upper()


def named_programs(file: s.File) -> Iterator[tuple[s.Line, str, int | None]]:
    """Programs that a file names: the line, the name, and the slot it is run or loaded in.

    None for CallP, which stays in its own slot; 0 for a slot that is worked out.
    """
    for item in file.items:
        if not isinstance(item, s.Line):
            continue
        for statement in statements_in(item.statement):
            match statement:
                case s.CallP(program=s.String(name)):
                    yield item, name, None
                case s.Command("XRun" | "XLoad", (slot, s.String(name), *_)):
                    yield item, name, int(literal(slot) or 0)
                case s.Include(program=name):
                    yield item, name, None


def awaited_programs(file: s.File) -> list[tuple[s.Line, str]]:
    """Programs that a file calls and that come back to it, by the lines that call them."""
    return [
        (line, name)
        for line, name, slot in named_programs(file)
        if slot is None and not isinstance(line.statement, s.Include)
    ]


def literal(value: s.Expression | None) -> float | None:
    """The number that an expression is, None if it is no plain number."""
    match value:
        case s.Number(number):
            return number
        case s.Unary("+" | "-" as sign, s.Number(number)):
            return -number if sign == "-" else number
    return None


Role = Literal["read", "written", "declared", "either"]
"""Use of a variable; `either` where a statement may read or write it."""

_ARGUMENT_WORDS: Final = frozenset(
    {
        *(word.upper() for row in statements().values() for word in row.words),
        *("NOERR", "ERR", "P", "J", "S", "L", "F"),
        *("BIT", "BYTE", "WORD", "INTEGER", "DWORD"),
    }
)
"""Words that stand among the arguments of a statement and name no variable."""


@dataclass(frozen=True, slots=True)
class Use:
    """A variable and its role in a line."""

    variable: s.Variable
    role: Role


_FIELD_ROLES: Final[Mapping[tuple[type, str], Role]] = {
    (s.Assign, "target"): "written",
    (s.Const, "variable"): "written",
    (s.DefIo, "variable"): "written",
    (s.DefNames, "variables"): "declared",
    (s.Dim, "variables"): "declared",
    (s.For, "variable"): "either",  # Next reads it
    (s.FPrm, "variables"): "written",
    (s.Input, "variables"): "written",
}
"""Statement and field → what is done with the variables there; others are read."""


def uses(node: Any, role: Role = "read") -> Iterator[Use]:
    """Yield the variables of a statement or of expressions, function calls included, in their
    order.

    The arguments of a call may receive a value. role: where the node states no other.
    """
    # A stack instead of recursion: every check runs through all nodes of a program.
    left: list[tuple[Any, Role]] = [(node, role)]
    while left:
        node, role = left.pop()
        kind: Any = type(node)
        if kind is s.Variable:
            yield Use(node, role)
            if node.arguments and role != "declared":
                # The value of an array's subscript is read, but a function may return something in
                # its argument.
                left.append((node.arguments, "either" if _gives_results(node.key) else "read"))
        elif kind is tuple:
            left += [(inner, role) for inner in reversed(node)]
        elif kind in _OWN_KINDS:
            yield from _own_uses(node)
        else:
            left += [(getattr(node, name), own or role) for name, own in _fields(kind)]


@cache
def _fields(kind: type) -> tuple[tuple[str, Role | None], ...]:
    """Fields that may hold nodes, the last one first, with what is done with what is in them."""
    return tuple((name, _FIELD_ROLES.get((kind, name))) for name in inside(kind) or ())


_OWN_KINDS: Final = frozenset({s.Next, s.Append, s.Call, s.DefFunction, s.Command})


def _own_uses(node: Any) -> Iterator[Use]:
    """Uses in what is not read field by field."""
    match node:
        case s.Append(statement, condition):
            yield from uses((condition, statement))
        case s.Call(function):
            yield from uses(function.arguments, "either")
        case s.DefFunction(_, _, parameters, value):
            own = {parameter.key for parameter in parameters}
            yield from (use for use in uses(value) if use.variable.key not in own)
        case s.Command(keyword, arguments):
            given = uses(arguments, "either" if keyword in commands("gives") else "read")
            yield from (use for use in given if not is_argument_word(use.variable))
        case s.Next():
            return  # its variables are those of the loops


def is_argument_word(variable: s.Variable) -> bool:
    """True if a bare name among the arguments of a statement is a word of it, as in `Servo Off`."""
    plain = variable.arguments is None and not variable.suffix and not variable.component
    return plain and variable.key in _ARGUMENT_WORDS


def _gives_results(name: str) -> bool:
    """True if a function of the language may return results in its arguments."""
    known = function(name)
    return known is not None and any(a.assigned or a.types == ANY for a in known.arguments)


def timer_number(node: Any) -> int | None:
    """The number of the timer that a node is: 0 for one that is worked out, None for none."""
    match node:
        case s.Variable(key="M_TIMER", arguments=(s.Number(value=number),)):
            # Only a plain number names one timer; anything else may be any of them.
            return int(number) if float(number).is_integer() and number >= 1 else 0
        case s.Variable(key="M_TIMER"):
            return 0
    return None


def timer_variable(word: str, number: int) -> s.Variable:
    return s.Variable(word, "", (s.Number(number),))


FORCE_COMMANDS: Final = ("Fsc", "FsGChg", "FsLog", "FsOutLog", "FsCTrg")
"""Commands of the force sensor (manual of the force sense function)."""
_FORCE_STATES: Final = ("P_FS", "M_FS")
"""Prefixes of the status variables that these commands read and write."""


def supplied_routine(command: s.Command) -> tuple[str, tuple[s.Expression, ...]] | None:
    """The routine that a command asks for and what it is given; None for any other command."""
    if command.keyword not in FORCE_COMMANDS:
        return None
    first, rest = command.arguments[:1], command.arguments[1:]
    match first:
        case (s.Word(text=way) | s.Variable(name=way, arguments=None),) if (
            way.upper() in _SWITCH_WORDS
        ):
            name, given = f"{command.keyword}{way.capitalize()}", rest
        case _:
            name, given = command.keyword, command.arguments
    plain = tuple(argument for argument in given if argument is not None)
    return (name, plain) if len(plain) == len(given) else None


_SWITCH_WORDS: Final = ("ON", "OFF")


def is_force_state(key: str) -> bool:
    """True if a name in upper case is a status variable of the force sensor."""
    return key.startswith(_FORCE_STATES)


def supplied_data_name(name: str) -> str:
    """The variable that such a state is elsewhere: `PFsStf0` of `P_FsStf0`."""
    return name.replace("_", "", 1)


_CLOSING_COMMANDS: Final = frozenset(
    {"Else", "EndIf", "WEnd", "Default", "End Select", "FEnd", "End", "Return"}
)
"""Commands that only close or divide a block, or end a program or subroutine."""


def report_parts(file: s.File) -> Iterator[Part]:
    """Yield data and statements in the order of the text; moves are all lifted."""
    for item in file.items:
        match item:
            case s.Data(variable=variable, span=Span() as span):
                yield Part(span, variable.name)
            case PositionRows(span=Span() as span):
                lines = None if item.places is None else item.places + span.start
                yield Part(span, count=len(item), lines=lines)
            case s.Line(statement=s.Command(keyword=word)) if word in _CLOSING_COMMANDS:
                pass
            case s.Line(statement=None | s.Motion() | s.ElseIf() | s.Next() | s.Case()):
                pass
            case s.Line(span=Span() as span):
                yield Part(span)
