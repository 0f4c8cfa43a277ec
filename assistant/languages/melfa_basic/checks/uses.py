"""What each variable of a statement is there for: read, written, declared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

from assistant.languages.melfa_basic.tables.vocabulary import ANY, commands, function, statements
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import inside

Role = Literal["read", "written", "declared", "either"]
"""What is done with a variable; `either` where a statement may read or write it."""

WORDS: Final = frozenset(
    {
        *(word.upper() for row in statements().values() for word in row.words),
        *("NOERR", "ERR", "P", "J", "S", "L", "F"),
        *("BIT", "BYTE", "WORD", "INTEGER", "DWORD"),
    }
)
"""Words that stand among the arguments of a statement and name no variable."""


@dataclass(frozen=True, slots=True)
class Use:
    """A variable where it stands in a line."""

    variable: s.Variable
    role: Role


def uses(statement: s.Statement | None) -> Iterator[Use]:
    """The variables of a statement, function calls included, with what is done with each."""
    match statement:
        case None:
            return
        case s.If(condition, then, otherwise):
            yield from _read(condition)
            for branch in (then, otherwise):
                if branch is not None and not isinstance(branch, s.Target):
                    yield from uses(branch)
        case s.Motion(_, arguments, type, append):
            yield from _read((arguments, type))
            if append is not None:
                yield from _read(append.condition)
                yield from uses(append.statement)
        case s.Assign(target, value, delay):
            yield from _written(target)
            yield from _read((value, delay))
        case s.For(variable, first, last, step):
            yield Use(variable, "either")  # Next reads it
            yield from _read(variable.arguments)
            yield from _read((first, last, step))
        case s.Const(_, variable, value):
            yield from _written(variable)
            yield from _read(value)
        case s.Input(number, variables):
            yield from _read(number)
            for variable in variables:
                yield from _written(variable)
        case s.FPrm(variables):
            for variable in variables:
                yield Use(variable, "written")
        case s.DefNames(_, variables) | s.Dim(variables):
            for variable in variables:
                yield Use(variable, "declared")
        case s.Static(definition):
            yield from uses(definition)
        case s.DefIo(variable, _, number, mask):
            yield Use(variable, "written")
            yield from _read((number, mask))
        case s.DefFunction(_, _, parameters, value):
            own = {parameter.key for parameter in parameters}
            yield from (use for use in _read(value) if use.variable.key not in own)
        case s.Call(function):
            yield from _read(function.arguments, "either")
        case s.Command(keyword, arguments):
            role: Role = "either" if keyword in commands("gives") else "read"
            yield from (u for u in _read(arguments, role) if not is_word(u.variable))
        case s.Next():
            return  # its variables are those of the loops
        case _:
            yield from _read(statement)


def is_word(variable: s.Variable) -> bool:
    """Whether a bare name among the arguments of a statement is a word of it, as in `Servo Off`."""
    plain = variable.arguments is None and not variable.suffix and not variable.component
    return plain and variable.key in WORDS


def _written(target: s.Variable) -> Iterator[Use]:
    yield Use(target, "written")
    yield from _read(target.arguments)


def _read(node: Any, role: Role = "read") -> Iterator[Use]:
    """The variables of expressions; in the arguments of a call they may be given a value."""
    for inner in _outer(node):
        yield Use(inner, role)
        if inner.arguments:
            yield from _read(inner.arguments, "either" if _gives(inner.key) else "read")


def _gives(name: str) -> bool:
    """Whether a function of the language may give results in its arguments."""
    known = function(name)
    return known is not None and any(a.assigned or a.types == ANY for a in known.arguments)


def _outer(node: Any) -> Iterator[s.Variable]:
    """Variables that stand in no other one's arguments."""
    left = [node]
    while left:
        inner = left.pop()
        if isinstance(inner, s.Variable):
            yield inner
        elif isinstance(inner, tuple):
            left += reversed(inner)
        else:
            left += [getattr(inner, name) for name in inside(type(inner)) or ()]
