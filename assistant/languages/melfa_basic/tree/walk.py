"""Nodes of lines, statements and expressions; what these begin with, declare, call and say."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import is_dataclass
from pathlib import PurePath
from typing import Final, TypeVar

from assistant.languages.melfa_basic.tree import syntax as s
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
