"""What each variable of a statement is there for: read, written, declared."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Literal

from assistant.languages.melfa_basic.tables.vocabulary import ANY, commands, function, statements
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import inside

Role = Literal["read", "written", "declared", "either"]
"""What is done with a variable; `either` where a statement may read or write it."""

ARGUMENT_WORDS: Final = frozenset(
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


FIELD_ROLES: Final[Mapping[tuple[type, str], Role]] = {
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
    """The variables of a statement or of expressions, function calls included, in their order.

    In the arguments of a call they may be given a value. role: where the node says nothing else.
    """
    left: list[tuple[Any, Role]] = [(node, role)]
    while left:
        node, role = left.pop()
        kind: Any = type(node)
        if kind is s.Variable:
            yield Use(node, role)
            if node.arguments and role != "declared":
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
    return tuple((name, FIELD_ROLES.get((kind, name))) for name in inside(kind) or ())


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
    """Whether a bare name among the arguments of a statement is a word of it, as in `Servo Off`."""
    plain = variable.arguments is None and not variable.suffix and not variable.component
    return plain and variable.key in ARGUMENT_WORDS


def _gives_results(name: str) -> bool:
    """Whether a function of the language may give results in its arguments."""
    known = function(name)
    return known is not None and any(a.assigned or a.types == ANY for a in known.arguments)
