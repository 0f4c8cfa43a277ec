"""Which texts an expression of RAPID may give, as far as the program alone tells.

A variable may have any text that the program assigns to it anywhere, whenever that is. What reads
texts, cuts them or gets them from elsewhere is not known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes, root

MOST_TEXTS: Final = 60
"""Texts of one expression; of more nobody chooses one by one."""
_READING_INSTRUCTIONS: Final = frozenset(
    {"tpwrite", "errwrite", "errlog", "eventlog", "aliasio", "getdataval", "write", "strlen",
     "strpart", "strfind", "strmatch", "strtoval", "valtostr"}
)  # fmt: skip
"""What is given a text and does not change it, beside routines of the program that take a value."""

TextScope = s.Routine | None
"""Where a name stands: in a routine, or in the modules."""


class KnownTexts:
    """Knows the texts of a program."""

    def __init__(self, modules: Sequence[s.Module]) -> None:
        items = [item for module in modules for item in module.items]
        self.routines: dict[str, s.Routine] = {}
        twice: set[str] = set()
        for item in items:
            if isinstance(item, s.Routine):
                twice |= {item.name.lower()} & self.routines.keys()
                self.routines[item.name.lower()] = item
        self.declared = {i.name.lower(): i for i in items if isinstance(i, s.Data)}
        self.parameters = {
            (id(r), name) for r in self.routines.values() for name in _value_parameters(r)
        }
        self.own = {
            id(item): _declared_names(item) for item in items if isinstance(item, s.Routine)
        }
        self.given: dict[tuple[int, str], list[tuple[TextScope, s.Expression]]] = {}
        self.lost: set[tuple[int, str]] = set()
        """Variables that something changes beside assignments, by scope and lower-case name."""
        for item in items:
            scope = item if isinstance(item, s.Routine) else None
            for node in nodes(item):
                self._look(node, scope)
        for name in twice:
            self.lost |= {key for key in self.given if key[0] == id(self.routines[name])}

    def _key(self, name: str, scope: TextScope) -> tuple[int, str]:
        inside = scope is not None and name.lower() in self.own.get(id(scope), ())
        return (id(scope) if inside else 0), name.lower()

    def _look(self, node: Any, scope: TextScope) -> None:
        match node:
            case s.Assignment(s.NameRef(name), value):
                self.given.setdefault(self._key(name, scope), []).append((scope, value))
            case s.Assignment(target):
                found = root(target)
                if found is not None:
                    self.lost.add(self._key(found.name, scope))
            case s.Data(name=name, value=value, dimensions=()) if value is not None:
                self.given.setdefault(self._key(name, scope), []).append((scope, value))
            case s.ProcedureCall() | s.FunctionCall():
                self._called(node, scope)

    def _called(self, node: s.ProcedureCall | s.FunctionCall, scope: TextScope) -> None:
        word = node.name.lower() if isinstance(node.name, str) else ""
        routine = self.routines.get(word)
        modes: Mapping[str, str] = {}
        places: Iterator[s.ParameterNode | None] = iter(())
        if routine is not None:
            groups = [g for g in routine.parameters if not g.optional]
            places = (_single_parameter(group) for group in groups)
            every = (one for g in routine.parameters for one in g.alternatives)
            modes = {x.name.lower(): x.mode for x in every if isinstance(x, s.ParameterNode)}
        for argument in node.arguments:
            value = getattr(argument, "value", None)
            if isinstance(argument, s.Positional):
                taken = next(places, None)
                name = "" if taken is None else taken.name
            else:
                name = argument.name
            mode = modes.get((name or "").lower())
            if routine is not None and mode == "" and value is not None:
                key = id(routine), str(name).lower()
                self.given.setdefault(key, []).append((scope, value))
            elif isinstance(argument, s.Conditional):
                self.lost.add((id(routine), argument.name.lower()))
            elif word not in _READING_INSTRUCTIONS and (found := root(value)) is not None:
                self.lost.add(self._key(found.name, scope))
                if routine is not None:
                    self.lost.add((id(routine), str(name).lower()))

    # ------------------------------------------------------------------------------ texts

    def of(self, node: s.Expression, scope: TextScope) -> frozenset[str] | None:
        """The texts that an expression may give, None if that is not known."""
        return self._of(node, scope, frozenset())

    def _of(
        self, node: s.Expression, scope: TextScope, asked: frozenset[tuple[int, str]]
    ) -> frozenset[str] | None:
        match node:
            case s.StringLiteral(value):
                return frozenset((value,))
            case s.Group(inner):
                return self._of(inner, scope, asked)
            case s.Infix("+", left, right):
                first, second = self._of(left, scope, asked), self._of(right, scope, asked)
                if first is None or second is None or len(first) * len(second) > MOST_TEXTS:
                    return None
                return frozenset(a + b for a in first for b in second)
            case s.NameRef(name):
                return self._named(name, scope, asked)
        return None

    def _named(
        self, name: str, scope: TextScope, asked: frozenset[tuple[int, str]]
    ) -> frozenset[str] | None:
        key = self._key(name, scope)
        if key in self.lost or key in asked:
            return None
        if key not in self.given and key not in self.parameters:
            return None
        if key[0] == 0 and key[1] not in self.declared:
            return None
        found: frozenset[str] = frozenset()
        for where, value in self.given.get(key, ()):
            texts = self._of(value, where, asked | {key})
            if texts is None or len(found | texts) > MOST_TEXTS:
                return None
            found |= texts
        return found


def _single_parameter(group: s.ParameterGroup) -> s.ParameterNode | None:
    match group.alternatives:
        case (s.ParameterNode() as one,):
            return one
    return None


def _value_parameters(routine: s.Routine) -> Iterator[str]:
    """Parameters that take a value, in lower case, which they have from calls alone."""
    for group in routine.parameters:
        for one in group.alternatives:
            if isinstance(one, s.ParameterNode) and not one.mode:
                yield one.name.lower()


def _declared_names(routine: s.Routine) -> frozenset[str]:
    """What a routine declares, in lower case."""
    return frozenset(
        node.name.lower() for node in nodes(routine) if isinstance(node, s.Data | s.ParameterNode)
    )
