"""The arguments of calls beside the signatures of routines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from assistant.base.diagnostics import Rule
from assistant.languages.checks.names import misspelt
from assistant.languages.checks.registry import Found
from assistant.languages.rapid.checks import use_rules as rules
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tables.words import TYPE_ENDING
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.signatures import Call, Given, Misfit, Parameter, Signature, Slot

CallNode = s.ProcedureCall | s.FunctionCall
MISFIT_RULES: Final[Mapping[Misfit, Rule]] = {
    Misfit.MISSING: rules.MISSING_ARGUMENTS,
    Misfit.TOO_MANY: rules.TOO_MANY,
    Misfit.OTHER_NAME: rules.WRONG_NAME,
    Misfit.UNKNOWN: rules.UNKNOWN_OPTION,
    Misfit.EXCLUSIVE: rules.EXCLUSIVE,
    Misfit.NO_VALUE: rules.OPTION_WITHOUT_VALUE,
    Misfit.SWITCH_WITH_VALUE: rules.SWITCH_WITH_VALUE,
}


def call_of(node: CallNode, routine: Signature) -> Call[s.Node]:
    return Call([_given_argument(argument) for argument in node.arguments], routine)


def _given_argument(argument: s.Argument) -> Given[s.Node]:
    match argument:
        case s.Positional(value, name):
            hole = isinstance(value, s.Placeholder)
            return Given(argument, value, name or "", hole=hole)
        case s.Option(name, value):
            return Given(argument, value, name, optional=True)
        case s.Conditional(name):
            return Given(argument, None, name, optional=True, handed_on=True)


def signature_of(routine: s.Routine) -> Signature:
    """How a routine of the given modules is called."""
    slots = tuple(
        Slot(tuple(_parameter(p) for p in named), group.optional)
        for group in routine.parameters
        if (named := [p for p in group.alternatives if isinstance(p, s.ParameterNode)])
    )
    holes = any(isinstance(p, s.Placeholder) for g in routine.parameters for p in g.alternatives)
    return Signature(routine.name, routine.kind, slots, routine.type.lower(), holes)


def _parameter(node: s.ParameterNode) -> Parameter:
    return Parameter(node.name, node.type.lower(), node.mode, node.dimensions)


def argument_misfits(node: CallNode, call: Call[s.Node], scope: Scope) -> Found:
    """Arguments that are missing, too many, unknown, named wrongly, or given twice."""
    routine = call.routine
    standard = routine is signature(routine.name)
    for what, at, fields in call.misfits(scope.suits, any_name=standard):
        rule = rules.NEW_OPTION if what is Misfit.UNKNOWN and standard else MISFIT_RULES[what]
        if what is Misfit.UNKNOWN:
            names = [one.name for _, one in call.options.values()]
            fields["hint"] = _option_hint(fields["option"], names)
        usage = _call_usage(routine)
        yield scope.look.finding(rule, at or node, routine=routine.name, usage=usage, **fields)


def _option_hint(name: str, options: Sequence[str]) -> str:
    near = misspelt(name, options, TYPE_ENDING)
    if near:
        return f"write `\\{near}`"
    names = ", ".join("`\\" + one + "`" for one in options)
    return f"it has {names}" if names else "leave it out"


def _call_usage(routine: Signature) -> str:
    """The arguments that a routine must be given, as a call would have them."""
    names = ", ".join(slot.alternatives[0].name for slot in routine.required)
    if routine.kind == "FUNC":
        return f"{routine.name}({names})"
    return f"{routine.name} {names}".rstrip()
