"""Which variables a file and each of its functions have, of which types and sizes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from assistant.languages.melfa_basic.tables.variables import MARK_VALUE_TYPES, VALUE_TYPES
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import declarations, nodes
from assistant.program.program import ValueType

LETTER_TYPES: Final[dict[str, ValueType]] = {
    "P": "position",
    "J": "joints",
    "C": "text",
    "M": "number",
}
"""Types by the first letter of a name; any other letter is a number's."""


@dataclass(slots=True)
class Scope:
    """types: as declared, or marked by a suffix. sizes: of arrays. names: every variable that is
    met, upper case → as first written. static: those that outlive their function.
    """

    types: dict[str, ValueType] = field(default_factory=dict)
    sizes: dict[str, tuple[int, ...]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    static: set[str] = field(default_factory=set)

    def copy(self) -> Scope:
        return Scope(dict(self.types), dict(self.sizes), dict(self.names), set(self.static))


def scope_of(items: Iterable[s.Entry], functions: Iterable[str]) -> Scope:
    """The variables that some lines hold. functions: upper-case names of the user's own."""
    scope = Scope()
    own = frozenset(functions)
    marked: dict[str, ValueType] = {}
    for item in items:
        if item.statement is None:
            continue
        _declare_variables(scope, item.statement)
        for node in nodes(item.statement):
            if isinstance(node, s.Variable) and node.key not in own and is_variable(node):
                scope.names.setdefault(node.key, node.name)
                if node.suffix:
                    marked.setdefault(node.key, MARK_VALUE_TYPES[node.suffix])
    scope.types = {**marked, **scope.types}
    return scope


def _declare_variables(scope: Scope, statement: s.Statement) -> None:
    for variable, word in declarations(statement):
        if word in VALUE_TYPES:
            scope.types[variable.key] = VALUE_TYPES[word]
        if word in VALUE_TYPES or not word:
            _set_size(scope, variable)
        if isinstance(statement, s.Static):
            scope.static.add(variable.key)


def _set_size(scope: Scope, variable: s.Variable) -> None:
    size = tuple(int(a.value) for a in variable.arguments or () if isinstance(a, s.Number))
    if size and len(size) == len(variable.arguments or ()):
        scope.sizes[variable.key] = size


def is_variable(node: s.Variable) -> bool:
    """Whether a name is no status variable and no function of the language."""
    if node.arguments is not None and function(node.key) is not None:
        return False
    return status(node.key) is None


def letter_type(key: str) -> ValueType:
    """The type of a variable that is declared nowhere; texts have a `$`, but for external ones."""
    if key[:1] == "C" and key[1:2] != "_":
        return "number"
    return LETTER_TYPES.get(key[:1], "number")


def variable_keys(items: Sequence[s.Entry]) -> Iterator[str]:
    """Upper-case names of all variables in some lines."""
    for item in items:
        statement: Any = item.statement if isinstance(item, s.Line) else None
        for node in nodes(statement):
            if isinstance(node, s.Variable):
                yield node.key
