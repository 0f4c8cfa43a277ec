"""The error that a handler asks a routine about, as a parameter of the routine.

`ERROR note; TRYNEXT;` with `ERRNO` in `note` becomes `note ERRNO;`, and `note` asks its parameter:
other languages know the error where it is handled, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import ERRNO, called_in, nodes, of_handlers
from assistant.program.rewriting import rewrite

ERROR_PARAMETER: Final = "error_number"


def with_passed_errors(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules whose handlers hand the error over; themselves where no routine asks for it."""
    routines = [one for module in modules for one in module.items if isinstance(one, s.Routine)]
    asking = _error_readers(routines, of_handlers(modules))
    if not asking:
        return modules

    def handed(error: str) -> Callable[[Any], Any]:
        def visit(node: Any) -> Any:
            match node:
                case s.ProcedureCall(str(name)) | s.FunctionCall(str(name)):
                    if name.lower() in asking:
                        more = s.Positional(s.NameRef(error))
                        return replace(node, arguments=(*node.arguments, more))
            return node

        return visit

    def asked(node: Any) -> Any:
        if isinstance(node, s.NameRef) and node.name.lower() == ERRNO:
            return s.NameRef(ERROR_PARAMETER, span=node.span)
        return node

    def item(one: s.Item) -> s.Item:
        if not isinstance(one, s.Routine):
            return one
        made = replace(one, handlers=rewrite(one.handlers, handed("ERRNO"), ()))
        if one.name.lower() not in asking:
            return made if made.handlers is not one.handlers else one
        body = rewrite(rewrite(one.body, asked, ()), handed(ERROR_PARAMETER), ())
        parameter = s.ParameterGroup(False, (s.ParameterNode("", "num", ERROR_PARAMETER),))
        return replace(made, body=body, parameters=(*one.parameters, parameter))

    return [replace(module, items=tuple(map(item, module.items))) for module in modules]


def _error_readers(routines: Sequence[s.Routine], handling: frozenset[str]) -> frozenset[str]:
    """Names in lower case of routines that handlers alone call and that ask for their error.

    None where one of them is called by a name that is worked out, or from anywhere else.
    """
    bodies = {one.name.lower(): one for one in routines}
    if any(
        isinstance(n, s.NameRef) and n.name.lower() == ERROR_PARAMETER
        for n in nodes(tuple(routines))
    ):
        return frozenset()
    if any(isinstance(n, s.ProcedureCall) and not isinstance(n.name, str)
           for n in nodes(tuple(routines))):  # fmt: skip
        return frozenset()
    asking = {name for name in handling if name in bodies and _asks_error(bodies[name].body)}
    while True:  # those that hand it on
        more = {
            name
            for name in handling - asking
            if name in bodies and asking.intersection(called_in(bodies[name].body))
        }
        if not more:
            break
        asking |= more
    outside = {
        name for one in routines if one.name.lower() not in asking for name in called_in(one.body)
    }
    return frozenset() if asking & outside else frozenset(asking)


def _asks_error(body: Any) -> bool:
    return any(isinstance(node, s.NameRef) and node.name.lower() == ERRNO for node in nodes(body))
