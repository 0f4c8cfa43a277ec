"""Sizes of arrays that callers give to a library, as parameters beside the arrays.

`PROC fill(INOUT num list{*})` that asks for `Dim(list,1)` becomes `fill(INOUT num list{*},num
list_count)` where nothing that was read calls it: other languages have arrays of any size as
parameters, and no way to ask for that size.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import called_in, nodes
from assistant.program.rewriting import rewrite

COUNT_SUFFIX: Final = "_count"
_DIM: Final = "dim"
ParameterKey = tuple[str, str]
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
                names = ", ".join(f"`{name}{COUNT_SUFFIX}`" for name in own)
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

    given: ParameterKey
    taken: ParameterKey


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
    """The list that is handed over as a whole, empty for anything else."""
    match value:
        case s.NameRef(name) | s.Element(s.NameRef(name), (s.Whole(),)):
            return name.lower()
    return ""


def _counted_parameters(routines: dict[str, s.Routine]) -> frozenset[ParameterKey]:
    """The parameters whose size is asked for, and that callers outside give."""
    called = {name for one in routines.values() for name in called_in((one.body, one.handlers))}
    late = any(
        isinstance(node, s.ProcedureCall) and not isinstance(node.name, str)
        for node in nodes(tuple(routines.values()))
    )
    outer = [name for name in routines if name not in called and name != "main"]
    found = {(name, each) for name in outer for each in _unsized(routines[name])}
    handed = [] if late or "main" in routines or not found else [*_passed_arrays(routines)]
    if not handed and (late or "main" in routines):
        return frozenset()
    while more := {one.taken for one in handed if one.given in found} - found:
        found |= more
    asked = {(low, each) for low, one in routines.items() for each in _unsized(one)
             if any(_is_size(node, each) for node in nodes((one.body, one.handlers)))}  # fmt: skip
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
    counted: frozenset[ParameterKey],
) -> s.Routine:
    """A routine that has the sizes of its lists, and hands sizes on."""

    def size(value: s.Expression) -> s.Expression:
        whole = _whole_array(value)
        if whole in own:
            return s.NameRef(whole + COUNT_SUFFIX)
        return s.FunctionCall(
            "Dim", (s.Positional(s.NameRef(whole)), s.Positional(s.NumberLiteral("1")))
        )

    def visit(node: Any) -> Any:
        match node:
            case s.FunctionCall(_, (s.Positional(s.NameRef(of)), _)) if _is_size(node, of.lower()):
                return s.NameRef(of.lower() + COUNT_SUFFIX) if of.lower() in own else node
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
    added = (s.ParameterGroup(False, (s.ParameterNode("", "num", n + COUNT_SUFFIX),)) for n in own)
    return replace(routine, body=body, handlers=handlers, parameters=(*routine.parameters, *added))
