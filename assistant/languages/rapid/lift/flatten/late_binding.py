"""Routines and data that a program names by texts, as plain calls and choices.

`%"TOOLS:"+"Close"% n;` calls `Close` if only one module has that. Any other call by a text
(`%"name"%`, `CallByVar`) becomes a choice among up to 80 procedures, in the lifted program.
`GetDataVal name,value;` reads any data of the type of its value, and `SetDataVal` writes it: both
become a `TEST` of the text, with a case for each data of that type that all modules see. For any
other name both raise ERR_SYM_ACCESS (3HAC050917: GetDataVal).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.record_layout import SETTING_TYPES, RecordLayouts
from assistant.languages.rapid.lift.statements import NameResolver
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import called, nodes
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import is_repeatable, rewrite

Remarks = Sequence[tuple[Diagnostic, ...]]


def with_bound_calls(
    modules: Sequence[s.Module], before: Mapping[str, str]
) -> tuple[Sequence[s.Module], Remarks]:
    """The modules with such calls by name, and what is found in each.

    before: the names that texts know routines by which have others now, in lower case.
    """
    if not any(_is_late(node) for node in nodes(tuple(modules))):
        return modules, ((),) * len(modules)
    owners: dict[str, list[tuple[str, s.Routine]]] = {}
    for module in modules:
        for item in module.items:
            if isinstance(item, s.Routine) and item.kind == "PROC":
                low = item.name.lower()
                owners.setdefault(before.get(low, low), []).append((module.name.lower(), item))
    made: list[s.Module] = []
    remarks: list[tuple[Diagnostic, ...]] = []
    for module in modules:
        found: list[Diagnostic] = []
        made.append(rewrite(module, partial(_bound_call, owners, found), ()))
        remarks.append(tuple(found))
    return made, remarks


def _is_late(node: Any) -> bool:
    # A single literal stays a call by name for `choice_of_calls`; only sums are bound here.
    return isinstance(node, s.ProcedureCall) and isinstance(node.name, s.Infix)


def _bound_call(
    owners: Mapping[str, Sequence[tuple[str, s.Routine]]], found: list[Diagnostic], node: Any
) -> Any:
    if not _is_late(node):
        return node
    start, end = _known_end(node.name)
    before, colon, name = end.rpartition(":")
    # Without the colon the end may be part of a longer name.
    if start and not colon:
        return node
    own = [
        routine
        for module, routine in owners.get(name.lower(), ())
        if accepts_call(routine, node) and (start or not colon or before.lower() == module)
    ]
    # None or several: the choice is left to `choice_of_calls`.
    if len(own) != 1:
        return node
    if start and node.span is not None:
        found.append(rules.NAMED_LATE(name=name, span=node.span))
    return replace(node, name=own[0].name)


def accepts_call(routine: s.Routine, call: s.ProcedureCall) -> bool:
    """True if a routine accepts the arguments of a call; any other call is an error."""
    required = sum(not group.optional for group in routine.parameters)
    options = {
        one.name.lower()
        for group in routine.parameters
        if group.optional
        for one in group.alternatives
        if isinstance(one, s.ParameterNode)
    }
    given = [one for one in call.arguments if isinstance(one, s.Positional)]
    named = {one.name.lower() for one in call.arguments if not isinstance(one, s.Positional)}
    return len(given) == required and named <= options


def _known_end(value: Any) -> tuple[bool, str]:
    """Return True for an unknown beginning, and the text that a sum certainly ends with."""
    match value:
        case s.StringLiteral(text):
            return False, text
        case s.Infix("+", left, s.StringLiteral(text)):
            unknown, before = _known_end(left)
            return unknown, before + text
    return True, ""


_MOST_CASES: Final = 80
"""Routines that one call may choose from."""
_END_PROGRAM: Final = p.Stop(end=True)


def choice_of_calls(
    node: p.Opaque, program: Program, meaning: NameResolver
) -> Iterator[p.Statement]:
    """Yield the statements for a call by a text, nothing if it has no equivalent."""
    if node.language != verbatim.LANGUAGE:
        return
    match verbatim.understood(verbatim.statements, node.text):
        case (s.ProcedureCall(name=str(word)) as call,) if word.lower() == "callbyvar":
            match called(call):
                case found if found is not None and not found.options:
                    yield from _choice_by_number(found.given, program, meaning)
        case (s.ProcedureCall(name=s.StringLiteral(text)) as call,):
            given = _plain_arguments(call, meaning)
            known = program.procedure(text.rpartition(":")[2])
            if known is not None and given is not None and len(given) == len(known.parameters):
                yield p.Call(known.name, given)
        case (s.ProcedureCall(name=name) as call,) if not isinstance(name, str):
            given = _plain_arguments(call, meaning)
            said = meaning.expression(name)
            # The text is compared with several names, so it must be safe to compute more than once.
            if given is not None and is_repeatable(said) and not _names_module(said):
                yield from _procedure_choice(
                    said, given, _matching_procedures(said, program, len(given))
                )


def _names_module(text: e.Expression) -> bool:
    """True if a part of a text names a module: its routines have no such names here."""
    match text:
        case e.Text(value):
            return ":" in value
        case e.Binary("+", left, right):
            return _names_module(left) or _names_module(right)
    return False


def _plain_arguments(
    call: s.ProcedureCall, meaning: NameResolver
) -> tuple[e.Expression, ...] | None:
    found = called(call)
    if found is None or found.options or None in found.given:
        return None
    return tuple(meaning.expression(one) for one in found.given if one is not None)


def _matching_procedures(text: e.Expression, program: Program, count: int) -> list[Procedure]:
    """Procedures that may be meant: those whose names begin and end as the text does."""
    begin = last = text
    while isinstance(begin, e.Binary) and begin.operator == "+":
        begin = begin.left
    while isinstance(last, e.Binary) and last.operator == "+":
        last = last.right
    start = begin.value.lower() if isinstance(begin, e.Text) else ""
    end = last.value.lower() if isinstance(last, e.Text) else ""
    return [
        q
        for q in program.procedures
        if q.name.lower().startswith(start)
        and q.name.lower().endswith(end)
        and q.result is None
        and len(q.parameters) == count
        and q.name != program.entry
        and not any(one.mode == "inout" for one in q.parameters)
    ]


def _procedure_choice(
    text: e.Expression, given: tuple[e.Expression, ...], procedures: Sequence[Procedure]
) -> Iterator[p.Statement]:
    if 0 < len(procedures) <= _MOST_CASES:
        cases = (p.Case((e.Text(q.name),), (p.Call(q.name, given),)) for q in procedures)
        yield p.Switch(text, tuple(cases), (_END_PROGRAM,))


def _choice_by_number(
    given: Sequence[s.Expression | None], program: Program, meaning: NameResolver
) -> Iterator[p.Statement]:
    """`CallByVar "name", n`: the routine whose name ends with the number."""
    match given:
        case (s.StringLiteral(start), node) if node is not None:
            number = meaning.expression(node)
            cases = [
                p.Case((e.Number(int(end)),), (p.Call(q.name),))
                for q in program.procedures
                if not q.parameters
                and q.result is None
                and q.name.lower().startswith(start.lower())
                and (end := q.name[len(start) :]).isdecimal()
                # `CallByVar` writes the number without leading zeros.
                and str(int(end)) == end
            ]
            if cases and is_repeatable(number):
                yield p.Switch(number, tuple(cases), (_END_PROGRAM,))


_MOST_NAMES: Final = 40
"""Data among which is chosen; more is no program that anybody reads."""
_READS: Final = "getdataval"
_WRITES: Final = "setdataval"
_NO_SUCH: Final = s.RaiseError(s.NameRef("ERR_SYM_ACCESS"))
"""Error that both instructions raise for a name without data (3HAC050917: GetDataVal)."""

_DataType = tuple[str, int]
"""Type without aliases, and number of dimensions."""


def with_named_data(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """Return the modules with data chosen by name, and the findings of each module."""
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
            # Local data of that name would be assigned in place of the module's.
            and name.lower() not in own
            # A constant cannot be written; its name raises the error.
            and not (writes and one.storage == "CONST")
            and _may_match(text, name)
        ]
        if len(found) > _MOST_NAMES:
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
    ) -> _DataType | None:
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
    """True if a text may equal a name, judged by its literal beginning and end."""
    low = name.lower()
    begin, end = _known_edge(text, 0), _known_edge(text, -1)
    if isinstance(text, s.StringLiteral):
        return text.value.lower() == low
    # The known beginning and end must not overlap in the name.
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
