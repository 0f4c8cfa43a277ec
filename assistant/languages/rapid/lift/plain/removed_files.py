"""Files that are removed, for controllers that remove none: they stay there, empty.

Such a file is opened for writing and closed, also where the program removes it only if it is there,
as no other controller can ask for that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.plain.exchanging import rewritten
from assistant.languages.rapid.lift.plain.scopes import FreshNames
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import mentions, nodes

REMOVE_INSTRUCTION: Final = "removefile"
IS_FILE: Final = "isfile"


def with_emptied_files(
    modules: Sequence[s.Module], files: Sequence[s.File]
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules of some files without such statements, and the findings of each."""
    nothing: list[list[Diagnostic]] = [[] for _ in modules]
    own = {i.name.lower() for m in modules for i in m.items if isinstance(i, s.Routine)}
    if {REMOVE_INSTRUCTION, IS_FILE} & own or not mentions(files, (REMOVE_INSTRUCTION,)):
        return modules, nothing
    name = FreshNames(modules)("removed")
    made = [rewritten(module, lambda node: _emptied(node, name)) for module in modules]
    for at, module in enumerate(modules):
        if made[at] is not module and name in _opened_names(made[at]):
            data = s.Data("LOCAL", "VAR", "iodev", name)
            made[at] = replace(made[at], items=(data, *made[at].items))
        nothing[at] += _removed_file_findings(module)
    return made, nothing


def _emptied(node: s.StatementNode, name: str) -> Iterator[s.StatementNode]:
    match node:
        case s.ProcedureCall(str(word), (s.Positional(path, None),)) if (
            word.lower() == REMOVE_INSTRUCTION
        ):
            channel = s.Positional(s.NameRef(name))
            opened = (s.Positional(path), channel, s.Option("Write", None))
            yield s.ProcedureCall("Open", opened, span=node.span)
            yield s.ProcedureCall("Close", (channel,), span=node.span)
        case s.IfThen((s.IfBranch(condition, body),), None) if _only_removes_existing(
            condition, _without_comments(body), name
        ):
            yield from body
        case _:
            yield node


def _without_comments(body: Sequence[s.StatementNode]) -> list[s.StatementNode]:
    return [one for one in body if not isinstance(one, s.CommentLine)]


def _only_removes_existing(condition: Any, body: Sequence[Any], name: str) -> bool:
    """True if a branch does nothing but remove the file that it asks for."""
    match condition, body:
        case (
            s.FunctionCall(str(word), (s.Positional(file, None), *_)),
            [s.ProcedureCall("Open", (s.Positional(path), s.Positional(s.NameRef(one)), *_)), _],
        ):
            return (word.lower(), one) == (IS_FILE, name) and file == path
        case s.Group(inner) | s.Infix("=", inner, s.BoolLiteral(True)), _:
            return _only_removes_existing(inner, body, name)
    return False


def _removed_file_findings(module: s.Module) -> Iterator[Diagnostic]:
    for node in nodes(module):
        if isinstance(node, s.ProcedureCall) and str(node.name).lower() == REMOVE_INSTRUCTION:
            yield rules.LEFT_OUT(
                what=str(node.name), loss="the file stays on the controller, and is empty",
                cure="see that nothing asks whether it is there", span=node.span,
            )  # fmt: skip


def _opened_names(module: s.Module) -> set[str]:
    """Names of what a module opens."""
    calls = (one for one in nodes(module) if isinstance(one, s.ProcedureCall))
    given = (x for one in calls if one.name == "Open" for x in one.arguments[1:2])
    values = (x.value for x in given if isinstance(x, s.Positional))
    return {value.name for value in values if isinstance(value, s.NameRef)}
