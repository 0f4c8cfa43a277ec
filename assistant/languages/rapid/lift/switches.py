r"""Routines with switches, as other languages are told of them: a switch is a truth.

`PROC p(num n\switch fast)` takes `n` and `fast`; a call that leaves it out gives FALSE, and
`Present(fast)` is `fast` itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.expressions import lift as expression
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.program import Declaration, Procedure, Program
from assistant.program.rewriting import map_spans, rewrite

Lift = Callable[[Iterable[s.Routine]], tuple[Procedure, ...]]
"""Reads routines as procedures, without those that stay as their text."""
Switches = Mapping[str, tuple[str, ...]]
"""Names of switches in their order, by the routine; all in lower case."""


def with_switches(program: Program, lift: Lift) -> Program:
    """The program with those routines as procedures, and what calls them changed."""
    found = {d: r for d in program.declarations if (r := _routine(d)) is not None}
    if not found:
        return program
    switches = {r.name.lower(): tuple(_switches(r)) for r in found.values()}
    made: list[Procedure] = []
    kept: list[Declaration] = []
    for declaration in program.declarations:
        routine = found.get(declaration)
        procedures = () if routine is None else lift((_plain(routine),))
        if not procedures:
            kept.append(declaration)
            if routine is not None:
                del switches[routine.name.lower()]
        span = declaration.span
        for q in procedures:
            body = map_spans(q.body, lambda _, span=span: span)  # type: ignore[misc]
            made.append(replace(q, body=body, span=span))
    whole = replace(program, procedures=(*program.procedures, *made), declarations=tuple(kept))
    return replace(whole, procedures=rewrite(whole.procedures, lambda x: _called(x, switches)))


def _routine(declaration: Declaration) -> s.Routine | None:
    """The routine with switches that a declaration says."""
    if declaration.language != verbatim.LANGUAGE:
        return None
    match verbatim.understood(verbatim.items, declaration.text):
        case (s.Routine() as routine,) if list(_switches(routine)):
            return routine
    return None


SWITCH: Final = "switch"


def _switches(routine: s.Routine) -> Iterable[str]:
    """Names of the optional parameters in lower case; none where one is no switch."""
    names = []
    for group in routine.parameters:
        for one in group.alternatives if group.optional else ():
            if isinstance(one, s.Placeholder) or one.type.lower() != SWITCH:
                return ()
            names.append(one.name.lower())
    return names


def _plain(routine: s.Routine) -> s.Routine:
    """The routine with truths as its last parameters."""
    required = tuple(group for group in routine.parameters if not group.optional)
    names = tuple(_switches(routine))
    truths = tuple(
        s.ParameterGroup(False, (replace(one, mode="", type="bool"),))
        for group in routine.parameters
        for one in (group.alternatives if group.optional else ())
        if isinstance(one, s.ParameterNode)
    )

    def present(x: Any) -> Any:
        match x:
            case s.FunctionCall(name, (s.Positional(s.NameRef(asked), None),)):
                if name.lower() == "present" and asked.lower() in names:
                    return s.NameRef(asked)
        return x

    body = rewrite(routine.body, present, ())
    return replace(routine, parameters=(*required, *truths), body=body)


def _called(x: Any, switches: Switches) -> Any:
    """A call with what it says of each switch."""
    match x:
        case p.Call(name, given) if name.lower() in switches:
            return replace(x, arguments=(*given, *_told((), switches[name.lower()])))
        case e.Apply(name, given) if name.lower() in switches:
            return replace(x, arguments=(*given, *_told((), switches[name.lower()])))
        case p.Opaque(verbatim.LANGUAGE, text):
            match verbatim.understood(verbatim.statements, text):
                case (s.ProcedureCall(str(name), arguments),) if name.lower() in switches:
                    values = _values(arguments, switches[name.lower()], switches)
                    return x if values is None else p.Call(name, values, span=x.span)
        case e.Verbatim(verbatim.LANGUAGE, text):
            match verbatim.understood(verbatim.expression, text):
                case s.FunctionCall(name, arguments) if name.lower() in switches:
                    values = _values(arguments, switches[name.lower()], switches)
                    return x if values is None else e.Apply(name, values)
    return x


def _values(
    arguments: Iterable[s.Argument], names: tuple[str, ...], switches: Switches
) -> tuple[e.Expression, ...] | None:
    """The arguments with a truth for each switch, None where one is given otherwise."""
    plain: list[e.Expression] = []
    told: dict[str, e.Expression] = {}
    for argument in arguments:
        match argument:
            case s.Positional(value, None):
                lifted = expression(value, str)
                plain.append(rewrite(lifted, lambda x: _called(x, switches)))
            case s.Option(name, None) if name.lower() in names:
                told[name.lower()] = e.Truth(True)
            case s.Conditional(name, s.NameRef(asked)) if name.lower() in names:
                told[name.lower()] = e.Name(asked)
            case _:
                return None
    return (*plain, *_told(told, names))


def _told(
    told: Mapping[str, e.Expression] | tuple[()], names: tuple[str, ...]
) -> tuple[e.Expression, ...]:
    known = dict(told)
    return tuple(known.get(name, e.Truth(False)) for name in names)
