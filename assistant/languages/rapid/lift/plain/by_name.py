"""Data that a program names by a text, as a choice among those that there are.

`GetDataVal name,value;` reads any data of the type of its value, and `SetDataVal` gives it one.
Both become a `TEST` of the text, with a case for each data of that type that all modules see.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.plain.layouts import SETTING_TYPES, RecordLayouts
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite

MOST_NAMES: Final = 40
"""Data among which is chosen; more is no program that anybody reads."""
_READS: Final = "getdataval"
_WRITES: Final = "setdataval"
_NO_SUCH: Final = s.RaiseError(s.NameRef("ERR_SYM_ACCESS"))
"""What both raise for a name that there is no data of (3HAC050917: GetDataVal)."""

DataType = tuple[str, int]
"""Type without aliases, and number of dimensions."""


def with_named_data(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules with such choices, and what there is to be told of each module."""
    words = (_READS, _WRITES)
    told: list[list[Diagnostic]] = [[] for _ in modules]
    every = nodes(tuple(modules))
    if not any(isinstance(n, s.ProcedureCall) and str(n.name).lower() in words for n in every):
        return modules, told
    own = {one.name.lower() for m in modules for one in m.items if isinstance(one, s.Routine)}
    if not own.isdisjoint(words):
        return modules, told
    there, layouts = list(_global_data(modules)), RecordLayouts(modules)
    made = []
    for at, module in enumerate(modules):
        shared = {name.lower(): layouts.base(one.type) for name, one in there}
        shared |= {
            one.name.lower(): layouts.base(one.type)
            for one in module.items
            if isinstance(one, s.Data)
        }
        chosen = _DataChoices(there, layouts, shared, told[at])
        items = tuple(
            chosen.routine(item) if isinstance(item, s.Routine) else item for item in module.items
        )
        same = all(a is b for a, b in zip(items, module.items, strict=True))
        made.append(module if same else replace(module, items=items))
    return made, told


def _global_data(modules: Sequence[s.Module]) -> Iterator[tuple[str, s.Data]]:
    """Data that all modules see, by their names as they are declared."""
    for item in (item for module in modules for item in module.items):
        if isinstance(item, s.Data) and item.scope != "LOCAL":
            yield item.name, item


class _DataChoices:
    """there: data that all modules see. types: of names in a module."""

    def __init__(
        self,
        there: Sequence[tuple[str, s.Data]],
        layouts: RecordLayouts,
        types: Mapping[str, str],
        told: list[Diagnostic],
    ) -> None:
        self.there, self.layouts, self.types, self.told = there, layouts, types, told
        self.dimensions = {name.lower(): len(one.dimensions) for name, one in there}

    def routine(self, routine: s.Routine) -> s.Routine:
        own = {
            one.name.lower(): one
            for one in nodes(routine)
            if isinstance(one, s.Data | s.ParameterNode)
        }

        def visit(node: Any) -> Any:
            if isinstance(node, s.ProcedureCall) and str(node.name).lower() in (_READS, _WRITES):
                return self._choice(node, own) or node
            return node

        made: s.Routine = rewrite(routine, visit, ())
        return made

    def _choice(
        self, node: s.ProcedureCall, own: Mapping[str, s.Data | s.ParameterNode]
    ) -> s.StatementNode | None:
        call = called(node)
        if call is None or call.options or len(call.given) != 2:
            return None
        text, value = call.given
        if text is None or not isinstance(value, s.NameRef):
            return None
        wanted = self._kind(value, own)
        if (
            wanted is None
            or wanted[0] in SETTING_TYPES
            or self.layouts.kind(wanted[0]) in _NO_VALUES
        ):
            return None
        writes = str(node.name).lower() == _WRITES
        found = [
            s.NameRef(name)
            for name, one in self.there
            if (self.layouts.base(one.type), len(one.dimensions)) == wanted
            and name.lower() not in own
            and not (writes and one.storage == "CONST")
            and _may_match(text, name)
        ]
        if len(found) > MOST_NAMES:
            return None
        pairs = ((one, value) if writes else (value, one) for one in found)
        cases = tuple(
            s.TestCase((s.StringLiteral(one.name),), (s.Assignment(*pair, span=node.span),))
            for one, pair in zip(found, pairs, strict=True)
        )
        self.told.append(rules.BY_NAME(what=str(node.name), count=len(found), span=node.span))
        other = replace(_NO_SUCH, span=node.span)
        return s.TestOf(text, cases, (other,), span=node.span) if cases else other

    def _kind(
        self, value: s.NameRef, own: Mapping[str, s.Data | s.ParameterNode]
    ) -> DataType | None:
        low = value.name.lower()
        match own.get(low):
            case s.Data(type=type, dimensions=dimensions):
                return self.layouts.base(type), len(dimensions)
            case s.ParameterNode(type=type, dimensions=dimensions):
                return self.layouts.base(type), dimensions
        if low not in self.types:
            return None
        return self.types[low], self.dimensions.get(low, 0)


_NO_VALUES: Final = ("", "DEVICE", "HANDLE", "OTHER")


def _may_match(text: s.Expression, name: str) -> bool:
    """Whether a text may be a name, by what of its begin and its end is written out."""
    low = name.lower()
    begin, end = _known_edge(text, 0), _known_edge(text, -1)
    if isinstance(text, s.StringLiteral):
        return text.value.lower() == low
    return low.startswith(begin) and low.endswith(end) and len(low) >= len(begin) + len(end)


def _known_edge(text: s.Expression, at: int) -> str:
    while isinstance(text, s.Group | s.Infix):
        if isinstance(text, s.Group):
            text = text.inner
        elif text.operator == "+":
            text = (text.left, text.right)[at]
        else:
            return ""
    return text.value.lower() if isinstance(text, s.StringLiteral) else ""
