"""Facts that the cell file states in the place of the controller: its state, task and still axes.

`GetTaskName()` becomes `controller_task` if the declarations of the cell have that: another
controller has no RobotWare, operating mode or task of such names. `CJointT` that names the arm of
the program's task loses the name; a program that names several tasks reads several arms, of which
only its own is known. External axes that the cell states to stand still get 9E9, as axes that are
missing do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, Final

import numpy as np

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.library import function_call
from assistant.languages.rapid.tables.constants import (
    CELL_MODULE,
    CONTROLLER_STATES,
    LAST_ERROR,
    STATE_BY_NAME,
    SYSTEM_INFO_NAMES,
    TASK_NUMBER,
    TASK_NUMBER_OPTIONS,
    UNUSED,
    state_of,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import (
    EXTERNAL_AXES,
    FIRST_EXTERNAL_COLUMN,
    stated_axes,
    still_axes,
    still_axis_name,
)
from assistant.languages.rapid.tree.walk import (
    ERRNO,
    TASK_NAME,
    called,
    nodes,
    routines_of_handlers,
)
from assistant.program.rewriting import rewrite


def with_cell_states(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """Return the modules with controller states read from the cell's data; unchanged if the cell
    states none.
    """
    known = {
        item.name.lower()
        for module in modules
        if module.name.lower().startswith(CELL_MODULE.lower())
        for item in module.items
        if isinstance(item, s.Data) and item.name.lower() in STATE_BY_NAME
    }
    if not known:
        return modules
    own = {item.name.lower() for m in modules for item in m.items if isinstance(item, s.Routine)}

    def visit(node: Any) -> Any:
        match node:
            case s.FunctionCall(str(name)) | s.ProcedureCall(str(name)):
                return node if name.lower() in own else _cell_answer(node, known) or node
        return node

    if LAST_ERROR.name in known:
        modules = _with_cell_errors(modules)
    return tuple(rewrite(module, visit, ()) for module in modules)


def _with_cell_errors(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules that ask for the last error of the cell where they handle none."""
    handling = routines_of_handlers(modules)

    def visit(node: Any) -> Any:
        if isinstance(node, s.NameRef) and node.name.lower() == ERRNO:
            return s.NameRef(LAST_ERROR.name, span=node.span)
        return node

    def item(one: s.Item) -> s.Item:
        # Routines that handlers call see the error itself.
        if not isinstance(one, s.Routine) or one.name.lower() in handling:
            return one
        body = rewrite(one.body, visit, ())
        return one if body is one.body else replace(one, body=body)

    return [replace(module, items=tuple(map(item, module.items))) for module in modules]


def _task_number_variable(options: Mapping[str, s.Expression | None]) -> s.Expression | None:
    """The variable that takes the number of the task, if that is all that is asked besides."""
    match [(name.lower(), value) for name, value in options.items()]:
        case [(name, (s.NameRef() | s.Component() | s.Element()) as value)] if (
            name in TASK_NUMBER_OPTIONS
        ):
            return value
    return None


def _cell_answer(
    node: s.FunctionCall | s.ProcedureCall, known: Set[str]
) -> s.Expression | s.StatementNode | None:
    """Return the cell's value for a call; None for a call with another meaning or with further
    effects.
    """
    options = [one.name for one in node.arguments if isinstance(one, s.Option)]
    state = state_of(str(node.name), options)
    if state is None or state.name not in known:
        return None
    call = called(node)
    if call is None or len(call.given) != state.arguments or None in call.given:
        return None
    value: s.Expression = s.NameRef(state.name)
    numbered = _task_number_variable(call.options)
    if (
        numbered is not None
        and TASK_NUMBER.name in known
        and state is CONTROLLER_STATES["gettaskname"]
    ):
        value = function_call("text_and_number", value, s.NameRef(TASK_NUMBER.name), numbered)
    elif state.name not in SYSTEM_INFO_NAMES and not state.options.issuperset(call.options):
        return None
    if isinstance(node, s.FunctionCall):
        return value
    # The instruction assigns to its last argument.
    *_, target = call.given
    if not isinstance(target, s.NameRef | s.Component | s.Element):
        return None
    return s.Assignment(target, value, span=node.span)


TASK_READS: Final = frozenset(("crobt", "cjointt", "ctool", "cwobj"))
"""Functions in lower case that read of the arm of a task, and state which."""
_REFERENCE: Final = "taskref"
_SUFFIX: Final = "id"
"""Suffix of the predefined variable that refers to a task, `T_ROB1Id` of `T_ROB1`."""
OWN_TASK: Final = CONTROLLER_STATES["gettaskname"].name
"""The data of the cell that holds the name of the program's own task."""


def with_own_task(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """Return the modules whose reads name no task, and the findings of each module."""
    told: list[list[Diagnostic]] = [[] for _ in modules]
    own = {one.name.lower() for m in modules for one in m.items if isinstance(one, s.Routine)}
    calls = [
        node
        for node in nodes(tuple(modules))
        if isinstance(node, s.FunctionCall) and node.name.lower() in TASK_READS - own
    ]
    named = {task.lower() for call in calls if (task := _named_task(call)) is not None}
    if not named:
        return modules, told
    stated = _own_task_name(modules)
    # Without the cell's word, a single name in the program is taken for its own task.
    mine = stated or (next(iter(named)) if len(named) == 1 else "")
    made = []
    for module, findings in zip(modules, told, strict=True):

        def item(one: s.Item, findings: list[Diagnostic] = findings) -> Any:
            return rewrite(
                one, lambda node: _without_own_task(node, mine, not stated, findings, own), ()
            )

        made.append(replace(module, items=tuple(map(item, module.items))))
    return made, told


def _own_task_name(modules: Sequence[s.Module]) -> str:
    """The task that the cell states, in lower case; empty if it states none."""
    for item in (item for module in modules for item in module.items):
        match item:
            case s.Data(name=name, value=s.StringLiteral(task)) if name.lower() == OWN_TASK:
                return task.lower()
    return ""


def _without_own_task(
    node: Any, mine: str, assumed: bool, findings: list[Diagnostic], own: set[str]
) -> Any:
    if not isinstance(node, s.FunctionCall) or node.name.lower() not in TASK_READS - own:
        return node
    task = _named_task(node)
    if task is None or task.lower() != mine:
        return node
    if assumed:
        findings.append(rules.OWN_TASK(task=task, span=node.span))
    return without_task(node)


def without_task(call: s.FunctionCall) -> s.FunctionCall:
    """A read without the option that names a task."""
    left = (one for one in call.arguments if not _is_task_option(one))
    return replace(call, arguments=tuple(left))


def _is_task_option(argument: s.Argument) -> bool:
    return isinstance(argument, s.Option) and argument.name.lower() in (_REFERENCE, TASK_NAME)


def _named_task(call: s.FunctionCall) -> str | None:
    """The task whose arm is read, None if none is named or its name is worked out."""
    for argument in call.arguments:
        match argument:
            case s.Option(option, s.StringLiteral(name)) if option.lower() == TASK_NAME:
                return name
            case s.Option(option, s.NameRef(name)) if option.lower() == _REFERENCE:
                if name.lower().endswith(_SUFFIX):
                    return name[: -len(_SUFFIX)]
    return None


_NO_AXIS: Final = s.NumberLiteral("9E9")
_REPORTED_NODES: Final = (
    s.Data,
    s.Assignment,
    s.ProcedureCall,
    s.TargetRunNode,
    s.MoveRunNode,
    s.ReturnFrom,
)


def with_still_axes(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules without such axes, and the findings of each."""
    still = still_axes(modules)
    if not still:
        return modules, [[] for _ in modules]
    said = {still_axis_name(axis) for axis in still}
    columns = [FIRST_EXTERNAL_COLUMN + EXTERNAL_AXES.index(axis) for axis in still]

    def stood(node: Any) -> Any:
        if stated_axes(node).isdisjoint(still):
            return node
        if isinstance(node, s.TargetRunNode | s.MoveRunNode):
            # The columns belong to the tree that was read.
            values = np.array(node.run.values, copy=True)
            values[:, columns] = UNUSED
            return replace(node, run=replace(node.run, values=values))  # type: ignore[arg-type]
        *others, last = node.items
        places = zip(EXTERNAL_AXES, last.items, strict=True)
        items = tuple(_NO_AXIS if axis in still else item for axis, item in places)
        return replace(node, items=(*others, replace(last, items=items)))

    made = []
    for module in modules:
        items = tuple(
            rewrite(item, stood, ())
            for item in module.items
            if not (isinstance(item, s.Data) and item.name.lower() in said)
        )
        made.append(replace(module, items=items))
    return made, [_still_axis_findings(module, still) for module in modules]


def _still_axis_findings(module: s.Module, still: frozenset[str]) -> list[Diagnostic]:
    """A finding for each statement and declaration that states a place of such an axis."""
    found: list[Diagnostic] = []
    for node in nodes(module):
        if isinstance(node, _REPORTED_NODES) and node.span is not None:
            inner = [node] if isinstance(node, s.TargetRunNode | s.MoveRunNode) else nodes(node)
            axes = sorted(frozenset().union(*map(stated_axes, inner)) & still)
            found += (rules.STILL_AXIS(axis=axis, span=node.span) for axis in axes)
    return found
