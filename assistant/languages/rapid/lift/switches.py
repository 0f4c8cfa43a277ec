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
from assistant.program.diagnostics import Span
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
    lifted = {d: lift((_plain(r),)) for d, r in found.items()}
    switches = {r.name.lower(): tuple(_switches(r)) for d, r in found.items() if lifted[d]}
    made = (_placed(q, d.span) for d, procedures in lifted.items() for q in procedures)
    kept = tuple(d for d in program.declarations if not lifted.get(d))
    whole = replace(program, procedures=(*program.procedures, *made), declarations=kept)
    return replace(whole, procedures=rewrite(whole.procedures, lambda x: _called(x, switches)))


def _placed(procedure: Procedure, span: Span | None) -> Procedure:
    """A procedure that stands where its declaration did."""
    return replace(procedure, body=map_spans(procedure.body, lambda _: span), span=span)


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
        case p.Call(name, given) | e.Apply(name, given) if name.lower() in switches:
            return replace(x, arguments=(*given, *_told({}, switches[name.lower()])))
        case p.Opaque(verbatim.LANGUAGE, text):
            match verbatim.understood(verbatim.statements, text):
                case (s.ProcedureCall(str(name), arguments),):
                    values = _values(name, arguments, switches)
                    return p.Call(name, values, span=x.span) if values else x
        case e.Verbatim(verbatim.LANGUAGE, text):
            match verbatim.understood(verbatim.expression, text):
                case s.FunctionCall(name, arguments):
                    values = _values(name, arguments, switches)
                    return e.Apply(name, values) if values else x
    return x


def _values(
    name: str, arguments: Iterable[s.Argument], switches: Switches
) -> tuple[e.Expression, ...]:
    """The arguments with a truth for each switch; none where one is given otherwise."""
    names = switches.get(name.lower(), ())
    plain: list[e.Expression] = []
    told: dict[str, e.Expression] = {}
    for argument in arguments:
        match argument:
            case s.Positional(value, None):
                lifted = expression(value, str)
                plain.append(rewrite(lifted, lambda x: _called(x, switches)))
            case s.Option(option, None) if option.lower() in names:
                told[option.lower()] = e.Truth(True)
            case s.Conditional(option, s.NameRef(asked)) if option.lower() in names:
                told[option.lower()] = e.Name(asked)
            case _:
                return ()
    return (*plain, *_told(told, names)) if names else ()


def _told(told: Mapping[str, e.Expression], names: Iterable[str]) -> Iterable[e.Expression]:
    return (told.get(name, e.Truth(False)) for name in names)
