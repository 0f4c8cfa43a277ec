"""Arrays that routines hand over whole, as arrays of the module: other languages copy none.

`VAR num v{3};` in a routine that calls `norm v;` becomes an array of the module under a name of its
own, which is given its first values where the routine begins. Copies of routines name it then
(`copies.py`). Arrays of a routine that may be called while it runs stay its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Final

from assistant.languages.rapid.lift.plain.assigning import names_in
from assistant.languages.rapid.lift.plain.changing import call_graph, reentrant_routines
from assistant.languages.rapid.lift.plain.layouts import RecordLayouts
from assistant.languages.rapid.lift.plain.optional import absent_value
from assistant.languages.rapid.lift.plain.substituting import is_literal
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.languages.rapid.tree.walk import inner_names, nodes
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite

MOST_ALIKE: Final = 4
"""Elements that are given the same value one by one: a loop takes no more steps."""
_NAMING: Final = (s.NameRef, s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def with_shared_arrays(modules: Sequence[s.Module], layouts: RecordLayouts) -> Sequence[s.Module]:
    """The modules whose routines hand over arrays of modules only, where that can be."""
    items = [item for module in modules for item in module.items]
    routines: dict[str, list[s.Routine]] = {}
    for item in items:
        if isinstance(item, s.Routine):
            routines.setdefault(item.name.lower(), []).append(item)
    given = {key for key, own in routines.items() if any(map(takes_arrays, own))}
    if not given:
        return modules
    every = list(nodes(tuple(modules)))
    taken = TakenNames(one.name for one in every if isinstance(one, _NAMING))
    taken.update(one.variable for one in every if isinstance(one, s.ForLoop))
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


def takes_arrays(routine: s.Routine) -> bool:
    """Whether it is given any."""
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
        if node.name.lower() in counted or names_in((node.value, node.dimensions)) & inner:
            continue
        name = identifier(f"{routine.name}_{node.name}", taken)
        sizes = [literal_number(size) for size in node.dimensions]
        filling: list[s.StatementNode] = []
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
    at = next((k for k, n in enumerate(own) if not isinstance(n, s.Data | s.CommentLine)), len(own))
    return data, replace(changed, body=(*changed.body[:at], *first, *changed.body[at:]))


def _filled(
    name: str, sizes: Sequence[int], value: s.Expression, taken: TakenNames, node: s.Data
) -> Iterator[s.StatementNode]:
    """The same value for every element, by loops where there are many."""

    def give(index: Sequence[s.Expression]) -> s.StatementNode:
        return s.Assignment(s.Element(s.NameRef(name), tuple(index)), value, span=node.span)

    if math.prod(sizes) <= MOST_ALIKE:
        for place in product(*(range(1, size + 1) for size in sizes)):
            yield give([s.NumberLiteral(str(at)) for at in place])
        return
    counters = [identifier(one, taken) for one in "ijk"[: len(sizes)]]
    inner = give([s.NameRef(one) for one in counters])
    for counter, size in reversed(list(zip(counters, sizes, strict=True))):
        first, last = s.NumberLiteral("1"), s.NumberLiteral(str(size))
        inner = s.ForLoop(counter, first, last, None, (inner,), span=node.span)
    yield inner
