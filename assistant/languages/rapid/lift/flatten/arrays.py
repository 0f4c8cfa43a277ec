"""Arrays that routines pass on: as arrays of the module, and with their sizes as parameters.

Other languages copy no arrays. `VAR num v{3};` in a routine that calls `norm v;` becomes an array
of the module with a new name, which gets its first values where the routine begins; copies of
routines (`routine_copies`) name it then. Arrays of a routine that may be called while it runs stay
local. `PROC fill(INOUT num list{*})` that asks for `Dim(list,1)` becomes
`fill(INOUT num list{*},num list_count)` if no call of it was read: other languages take arrays of
any size, but cannot ask for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.parameters import absent_value
from assistant.languages.rapid.lift.flatten.record_layout import RecordLayouts
from assistant.languages.rapid.lift.flatten.record_statements import names_in
from assistant.languages.rapid.lift.flatten.routine_copies import call_graph, reentrant_routines
from assistant.languages.rapid.lift.flatten.tree_rewriting import is_literal
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import called_in, inner_names, nodes
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite

_MOST_ALIKE: Final = 4
"""Elements that are given the same value one by one: a loop takes no more steps."""
_NAMING: Final = (s.NameRef, s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def with_shared_arrays(modules: Sequence[s.Module], layouts: RecordLayouts) -> Sequence[s.Module]:
    """The modules whose routines hand over arrays of modules only, where that can be."""
    items = [item for module in modules for item in module.items]
    routines: dict[str, list[s.Routine]] = {}
    for item in items:
        if isinstance(item, s.Routine):
            routines.setdefault(item.name.lower(), []).append(item)
    given = {key for key, own in routines.items() if any(map(_takes_arrays, own))}
    if not given:
        return modules
    every = list(nodes(tuple(modules)))
    taken = TakenNames(one.name for one in every if isinstance(one, _NAMING))
    taken.update(one.variable for one in every if isinstance(one, s.ForLoop))
    # Shared by nested calls, an array would lose its values.
    again = reentrant_routines(call_graph(routines))
    one_of = {key: own[0] for key, own in routines.items() if len(own) == 1}
    made = []
    for module in modules:
        changed: list[s.Item] = []
        for item in module.items:
            if isinstance(item, s.Routine):
                held, item = _with_aggregates_declared(item, one_of, taken)
                changed += held
            if isinstance(item, s.Routine) and item.name.lower() not in again:
                data, item = _with_shared_arrays_of(item, given, layouts, taken)
                changed += data
            changed.append(item)
        same = all(a is b for a, b in zip(changed, module.items, strict=False))
        same = same and len(changed) == len(module.items)
        made.append(module if same else replace(module, items=tuple(changed)))
    return made


def _with_aggregates_declared(
    routine: s.Routine, known: Mapping[str, s.Routine], taken: TakenNames
) -> tuple[list[s.Data], s.Routine]:
    """The arrays that a routine hands over in brackets, as constants, and the routine with them."""
    data: list[s.Data] = []

    def visit(node: Any) -> Any:
        match node:
            case s.ProcedureCall(str(name)) | s.FunctionCall(str(name)):
                callee = known.get(name.lower())
                return node if callee is None else replace(node, arguments=_arguments(node, callee))
        return node

    def _arguments(
        node: s.ProcedureCall | s.FunctionCall, callee: s.Routine
    ) -> tuple[s.Argument, ...]:
        groups = iter([group for group in callee.parameters if not group.optional])
        made: list[s.Argument] = []
        for argument in node.arguments:
            group = next(groups, None) if isinstance(argument, s.Positional) else None
            match group, argument:
                case s.ParameterGroup(_, (s.ParameterNode() as one,)), s.Positional(
                    s.AggregateNode() as value
                ) if one.dimensions > 0 and is_literal(value):
                    sizes = _aggregate_extents(value, one.dimensions)
                    if sizes is not None:
                        name = identifier(f"{callee.name}_{one.name}", taken)
                        taken.add(name)
                        extents = tuple(s.NumberLiteral(str(size)) for size in sizes)
                        data.append(s.Data("", "CONST", one.type, name, extents, value))
                        argument = replace(argument, value=s.NameRef(name))
            made.append(argument)
        return tuple(made)

    changed: s.Routine = rewrite(routine, visit, ())
    return data, changed if data else routine


def _aggregate_extents(value: s.AggregateNode, dimensions: int) -> tuple[int, ...] | None:
    """The extents of an array in brackets; None if its rows are not all as long."""
    if dimensions == 1 or not value.items:
        return (len(value.items),) if value.items else None
    inner = {
        _aggregate_extents(one, dimensions - 1) if isinstance(one, s.AggregateNode) else None
        for one in value.items
    }
    (only,) = inner if len(inner) == 1 else (None,)
    return None if only is None else (len(value.items), *only)


def _takes_arrays(routine: s.Routine) -> bool:
    """True if a routine has an array parameter."""
    return any(
        isinstance(one, s.ParameterNode) and one.dimensions
        for group in routine.parameters
        for one in group.alternatives
    )


def _with_shared_arrays_of(
    routine: s.Routine, given: set[str], layouts: RecordLayouts, taken: TakenNames
) -> tuple[list[s.Data], s.Routine]:
    """The arrays that a routine hands over, and the routine without them."""
    handed = {
        argument.value.name.lower()
        for one in nodes(routine)
        if isinstance(one, s.ProcedureCall | s.FunctionCall)
        and isinstance(one.name, str)
        and one.name.lower() in given
        for argument in one.arguments
        if isinstance(argument, s.Positional | s.Option) and isinstance(argument.value, s.NameRef)
    }
    if not handed:
        return [], routine
    inner = {name.lower() for name in inner_names((routine,))}
    counted = {one.variable.lower() for one in nodes(routine) if isinstance(one, s.ForLoop)}
    names: dict[str, str] = {}
    data: list[s.Data] = []
    first: list[s.StatementNode] = []
    for node in routine.body:
        if not isinstance(node, s.Data) or not node.dimensions or node.name.lower() not in handed:
            continue
        # A value that names local data cannot be computed outside the routine.
        if node.name.lower() in counted or names_in((node.value, node.dimensions)) & inner:
            continue
        name = identifier(f"{routine.name}_{node.name}", taken)
        sizes = [literal_number(size) for size in node.dimensions]
        filling: list[s.StatementNode] = []
        # Each call begins with fresh values, which data of a module has only once.
        if node.storage == "VAR":
            alike = absent_value(layouts.base(node.type), layouts)
            if node.value is not None:
                filling = [s.Assignment(s.NameRef(name), node.value, span=node.span)]
            elif alike is None or not all(isinstance(n, int) and n > 0 for n in sizes):
                continue
            else:
                filling = list(_filled(name, [int(n or 0) for n in sizes], alike, taken, node))
        taken.add(name)
        names[node.name.lower()] = name
        value = None if node.storage == "VAR" else node.value
        data.append(replace(node, scope="", name=name, value=value))
        first += filling
    if not names:
        return [], routine

    def renamed(part: Any) -> Any:
        if isinstance(part, s.NameRef) and part.name.lower() in names:
            return replace(part, name=names[part.name.lower()])
        return part

    own = tuple(
        node
        for node in routine.body
        if not (isinstance(node, s.Data) and node.name.lower() in names)
    )
    changed: s.Routine = rewrite(replace(routine, body=own), renamed, ())
    # Declarations have to come first in a routine.
    at = next((k for k, n in enumerate(own) if not isinstance(n, s.Data | s.CommentLine)), len(own))
    return data, replace(changed, body=(*changed.body[:at], *first, *changed.body[at:]))


def _filled(
    name: str, sizes: Sequence[int], value: s.Expression, taken: TakenNames, node: s.Data
) -> Iterator[s.StatementNode]:
    """The same value for every element, by loops where there are many."""

    def give(index: Sequence[s.Expression]) -> s.StatementNode:
        return s.Assignment(s.Element(s.NameRef(name), tuple(index)), value, span=node.span)

    if math.prod(sizes) <= _MOST_ALIKE:
        for place in product(*(range(1, size + 1) for size in sizes)):
            yield give([s.NumberLiteral(str(at)) for at in place])
        return
    counters = [identifier(one, taken) for one in "ijk"[: len(sizes)]]
    inner = give([s.NameRef(one) for one in counters])
    # From the inside out: the first index counts in the outermost loop.
    for counter, size in reversed(list(zip(counters, sizes, strict=True))):
        first, last = s.NumberLiteral("1"), s.NumberLiteral(str(size))
        inner = s.ForLoop(counter, first, last, None, (inner,), span=node.span)
    yield inner


_COUNT_SUFFIX: Final = "_count"
_DIM: Final = "dim"
_ParameterKey = tuple[str, str]
"""A routine and its parameter, in lower case."""


def with_counts(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules with such parameters, and the findings of each module."""
    told: list[list[Diagnostic]] = [[] for _ in modules]
    items = [one for module in modules for one in module.items]
    routines = {one.name.lower(): one for one in items if isinstance(one, s.Routine)}
    counted = _counted_parameters(routines)
    if not counted:
        return modules, told
    made = []
    for module, findings in zip(modules, told, strict=True):
        parts: list[s.Item] = []
        for one in module.items:
            if not isinstance(one, s.Routine):
                parts.append(one)
                continue
            own = [name for name in _unsized(one) if (one.name.lower(), name) in counted]
            parts.append(_with_counts_of(one, own, routines, counted))
            if own:
                names = ", ".join(f"`{name}{_COUNT_SUFFIX}`" for name in own)
                findings.append(rules.COUNTED(name=one.name, names=names, span=one.span))
        made.append(replace(module, items=tuple(parts)))
    return made, told


def _unsized(routine: s.Routine) -> list[str]:
    """Names in lower case of the required parameters that are lists of any size."""
    found = []
    for group in routine.parameters:
        match group.alternatives:
            case (s.ParameterNode(name=name, dimensions=1),) if not group.optional:
                found.append(name.lower())
    return found


@dataclass(frozen=True, slots=True)
class _PassedArray:
    """A list that a call hands on: whose parameter it is, and which one it becomes."""

    given: _ParameterKey
    taken: _ParameterKey


def _passed_arrays(routines: dict[str, s.Routine]) -> Iterator[_PassedArray]:
    for low, routine in routines.items():
        own = set(_unsized(routine))
        for node in nodes((routine.body, routine.handlers)):
            if isinstance(node, s.ProcedureCall | s.FunctionCall) and isinstance(node.name, str):
                callee = routines.get(node.name.lower())
                for value, name in _argument_pairs(node, callee):
                    whole = _whole_array(value)
                    if callee is not None and whole in own and name in _unsized(callee):
                        yield _PassedArray((low, whole), (callee.name.lower(), name))


def _argument_pairs(
    call: s.ProcedureCall | s.FunctionCall, callee: s.Routine | None
) -> Iterator[tuple[s.Expression, str]]:
    """The values of a call with the names of their required parameters in lower case."""
    given = [one.value for one in call.arguments if isinstance(one, s.Positional)]
    groups = [] if callee is None else [one for one in callee.parameters if not one.optional]
    for value, group in zip(given, groups, strict=False):
        for one in group.alternatives:
            if isinstance(one, s.ParameterNode):
                yield value, one.name.lower()


def _whole_array(value: Any) -> str:
    """Return the name of an array passed complete, in lower case, empty for anything else."""
    match value:
        case s.NameRef(name) | s.Element(s.NameRef(name), (s.Whole(),)):
            return name.lower()
    return ""


def _counted_parameters(routines: dict[str, s.Routine]) -> frozenset[_ParameterKey]:
    """Return the array parameters whose size the program reads and whose arguments come from
    outside callers.
    """
    called = {name for one in routines.values() for name in called_in((one.body, one.handlers))}
    late = any(
        isinstance(node, s.ProcedureCall) and not isinstance(node.name, str)
        for node in nodes(tuple(routines.values()))
    )
    # Only callers that were not read can give sizes that nobody knows.
    outer = [name for name in routines if name not in called and name != "main"]
    found = {(name, each) for name in outer for each in _unsized(routines[name])}
    # A call by name may pass arrays anywhere, and a program with `main` has no unread callers.
    handed = [] if late or "main" in routines or not found else [*_passed_arrays(routines)]
    if not handed and (late or "main" in routines):
        return frozenset()
    # Sizes are handed down to what those routines call.
    while more := {one.taken for one in handed if one.given in found} - found:
        found |= more
    asked = {(low, each) for low, one in routines.items() for each in _unsized(one)
             if any(_is_size(node, each) for node in nodes((one.body, one.handlers)))}  # fmt: skip
    # And asked for on behalf of what needs them.
    while more := {one.given for one in handed if one.taken in asked} - asked:
        asked |= more
    return frozenset(found & asked)


def _is_size(node: Any, name: str) -> bool:
    match node:
        case s.FunctionCall(str(word), (s.Positional(s.NameRef(of)), s.Positional(one))):
            first = isinstance(one, s.NumberLiteral) and one.text == "1"
            return word.lower() == _DIM and of.lower() == name and first
    return False


def _with_counts_of(
    routine: s.Routine,
    own: list[str],
    routines: dict[str, s.Routine],
    counted: frozenset[_ParameterKey],
) -> s.Routine:
    """A routine that has the sizes of its lists, and hands sizes on."""

    def size(value: s.Expression) -> s.Expression:
        whole = _whole_array(value)
        if whole in own:
            return s.NameRef(whole + _COUNT_SUFFIX)
        return s.FunctionCall(
            "Dim", (s.Positional(s.NameRef(whole)), s.Positional(s.NumberLiteral("1")))
        )

    def visit(node: Any) -> Any:
        match node:
            case s.FunctionCall(_, (s.Positional(s.NameRef(of)), _)) if _is_size(node, of.lower()):
                return s.NameRef(of.lower() + _COUNT_SUFFIX) if of.lower() in own else node
            case s.ProcedureCall(str(name)) | s.FunctionCall(str(name)):
                callee = routines.get(name.lower())
                more = [
                    s.Positional(size(value))
                    for value, taken in _argument_pairs(node, callee)
                    if (name.lower(), taken) in counted
                ]
                return replace(node, arguments=(*node.arguments, *more)) if more else node
        return node

    body, handlers = rewrite((routine.body, routine.handlers), visit, ())
    if not own and body is routine.body and handlers is routine.handlers:
        return routine
    added = (s.ParameterGroup(False, (s.ParameterNode("", "num", n + _COUNT_SUFFIX),)) for n in own)
    return replace(routine, body=body, handlers=handlers, parameters=(*routine.parameters, *added))
