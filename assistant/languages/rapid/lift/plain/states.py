"""What the controller tells of itself, as what the cell file says of it.

`GetTaskName()` becomes `controller_task` where the cell's declarations have that: another
controller has no tasks of such names, no RobotWare and no operating mode of its kind.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from typing import Any

from assistant.languages.rapid.lift.plain.library import function_call
from assistant.languages.rapid.tables.states import (
    BY_NAME,
    LAST_ERROR,
    NUMBERS,
    OF_OPTIONS,
    STATES,
    TASK_NUMBER,
    state_of,
)
from assistant.languages.rapid.tables.words import CELL_MODULE
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import called
from assistant.languages.rapid.tree.walk import ERRNO, of_handlers
from assistant.program.rewriting import rewrite


def with_cell_states(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules that ask the cell's data; themselves where the cell says nothing of it."""
    known = {
        item.name.lower()
        for module in modules
        if module.name.lower().startswith(CELL_MODULE.lower())
        for item in module.items
        if isinstance(item, s.Data) and item.name.lower() in BY_NAME
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
    handling = of_handlers(modules)

    def visit(node: Any) -> Any:
        if isinstance(node, s.NameRef) and node.name.lower() == ERRNO:
            return s.NameRef(LAST_ERROR.name, span=node.span)
        return node

    def item(one: s.Item) -> s.Item:
        if not isinstance(one, s.Routine) or one.name.lower() in handling:
            return one
        body = rewrite(one.body, visit, ())
        return one if body is one.body else replace(one, body=body)

    return [replace(module, items=tuple(map(item, module.items))) for module in modules]


def _task_number_variable(options: Mapping[str, s.Expression | None]) -> s.Expression | None:
    """The variable that takes the number of the task, if that is all that is asked besides."""
    match [(name.lower(), value) for name, value in options.items()]:
        case [(name, (s.NameRef() | s.Component() | s.Element()) as value)] if name in NUMBERS:
            return value
    return None


def _cell_answer(
    node: s.FunctionCall | s.ProcedureCall, known: Set[str]
) -> s.Expression | s.StatementNode | None:
    """What a call gives of what is known, None for any other one, and for one that does more."""
    options = [one.name for one in node.arguments if isinstance(one, s.Option)]
    state = state_of(str(node.name), options)
    if state is None or state.name not in known:
        return None
    call = called(node)
    if call is None or len(call.given) != state.arguments or None in call.given:
        return None
    value: s.Expression = s.NameRef(state.name)
    numbered = _task_number_variable(call.options)
    if numbered is not None and TASK_NUMBER.name in known and state is STATES["gettaskname"]:
        value = function_call("text_and_number", value, s.NameRef(TASK_NUMBER.name), numbered)
    elif state.name not in OF_OPTIONS and not state.options.issuperset(call.options):
        return None
    if isinstance(node, s.FunctionCall):
        return value
    *_, target = call.given
    if not isinstance(target, s.NameRef | s.Component | s.Element):
        return None
    return s.Assignment(target, value, span=node.span)
