r"""Positions that a program reads of the arm of a named task, which is its controller's arm.

`CJointT(\TaskName:="T_ROB1")` becomes `CJointT()`: another controller has one arm and no tasks of
such names. A program that names several tasks reads several arms, of which only its own is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.states import STATES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.calls import TASK_NAME
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite

TASK_READS: Final = frozenset(("crobt", "cjointt", "ctool", "cwobj"))
"""Functions in lower case that read of the arm of a task, and state which."""
_REFERENCE: Final = "taskref"
_SUFFIX: Final = "id"
"""Suffix of the predefined variable that refers to a task, `T_ROB1Id` of `T_ROB1`."""
OWN_TASK: Final = STATES["gettaskname"].name
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
