"""Calls of RAPID as rows of its tables have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.tree import syntax as s

TASK_NAME: Final = "taskname"
"""The option that names the task whose arm a function reads of."""


def called(node: s.Node) -> Called[s.Expression] | None:
    """The call that a node is, without a word where that is worked out.

    None for another node, or with an argument that a routine hands on.
    """
    if not isinstance(node, s.FunctionCall | s.ProcedureCall):
        return None
    given: list[s.Expression] = []
    options: dict[str, s.Expression | None] = {}
    for argument in node.arguments:
        match argument:
            case s.Positional(value, None):
                given.append(value)
            case s.Option(name, value):
                options.setdefault(name.lower(), value)
            case _:
                return None
    word = node.name if isinstance(node.name, str) else ""
    return Called(word, given, options)


def positional(call: s.FunctionCall | s.ProcedureCall) -> list[s.Expression]:
    """The values that are given by their places."""
    return [one.value for one in call.arguments if isinstance(one, s.Positional)]


def option(call: s.FunctionCall | s.ProcedureCall, *names: str) -> s.Option | None:
    """The first option of one of some names, which are in lower case."""
    given = (one for one in call.arguments if isinstance(one, s.Option))
    return next((one for one in given if one.name.lower() in names), None)


def name_of(value: s.Expression | None) -> str:
    """The name that an expression is, empty for any other one."""
    return value.name if isinstance(value, s.NameRef) else ""


def function_call(call: Called[s.Expression]) -> s.FunctionCall:
    return s.FunctionCall(call.word, arguments(call))


def arguments(call: Called[s.Expression]) -> tuple[s.Argument, ...]:
    given = [s.Positional(node) for node in call.given if node is not None]
    options = [s.Option(name, node) for name, node in call.options.items()]
    parts: tuple[Sequence[s.Argument], ...] = (given, options)
    first, second = reversed(parts) if call.leading else parts
    return (*first, *second)


def worked_out_task(call: s.FunctionCall) -> s.Expression | None:
    """The name of the task whose arm is read, None where it is written out or left out."""
    for argument in call.arguments:
        match argument:
            case s.Option(option, s.Node() as name) if option.lower() == TASK_NAME:
                return None if isinstance(name, s.StringLiteral) else name
    return None
