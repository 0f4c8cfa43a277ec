"""Which argument of a call is for which parameter, and which have no counterpart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from assistant.languages.checks.slips import misspelt
from assistant.languages.rapid.checks import use_rules as rules
from assistant.languages.rapid.checks.kinds import Scope
from assistant.languages.rapid.checks.module_view import Look
from assistant.languages.rapid.tables.signatures import Parameter, Signature, Slot, signature
from assistant.languages.rapid.tables.words import TYPE_ENDING
from assistant.languages.rapid.tree import syntax as s
from assistant.program.diagnostics import Diagnostic

Found = Iterator[Diagnostic]
Call = s.ProcedureCall | s.FunctionCall


@dataclass(frozen=True, slots=True)
class Bound:
    """A value and the parameters that it may be for: several where they exclude each other."""

    value: s.Expression
    parameters: tuple[Parameter, ...]

    @staticmethod
    def of(arguments: Sequence[s.Argument], routine: Signature) -> Iterator[Bound]:
        required = iter(routine.required if _counted(arguments, routine) else ())
        options = _options(routine)
        for argument in arguments:
            if isinstance(argument, s.Positional):
                slot = next(required, None)
                if slot is not None:
                    yield Bound(argument.value, slot.alternatives)
            elif isinstance(argument, s.Option) and argument.value is not None:
                found = options.get(argument.name.lower())
                if found is not None and found[1].type != "switch":
                    yield Bound(argument.value, (found[1],))


def _counted(arguments: Sequence[s.Argument], routine: Signature) -> bool:
    """Whether there are as many plain arguments as there are to be, so that each has its place."""
    given = sum(isinstance(argument, s.Positional) for argument in arguments)
    return routine.open or given == len(routine.required)


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


def _options(routine: Signature) -> dict[str, tuple[Slot, Parameter]]:
    return {one.name.lower(): (slot, one) for slot in routine.optional for one in slot.alternatives}


def bind(call: Call, routine: Signature, scope: Scope) -> Found:
    """Arguments that are missing, too many, unknown, named wrongly, or given twice."""
    standard = routine is signature(routine.name)
    look = scope.look
    yield from _required(call, routine, scope)
    options = _options(routine)
    taken: dict[int, s.Option] = {}
    for argument in call.arguments:
        if isinstance(argument, s.Positional):
            continue
        found = options.get(argument.name.lower())
        if found is not None and isinstance(argument, s.Option):
            slot, parameter = found
            yield from _valued(argument, parameter, routine, look)
            before = taken.setdefault(id(slot), argument)
            if before is not argument:
                yield look.finding(
                    rules.EXCLUSIVE,
                    argument,
                    routine=routine.name,
                    one=before.name,
                    other=argument.name,
                )
        elif found is None and not routine.open:
            rule = rules.NEW_OPTION if standard else rules.UNKNOWN_OPTION
            yield look.finding(
                rule,
                argument,
                routine=routine.name,
                option=argument.name,
                hint=_hint(argument.name, [one.name for _, one in options.values()]),
            )


def _hint(name: str, options: Sequence[str]) -> str:
    near = misspelt(name, options, TYPE_ENDING)
    if near:
        return f"write `\\{near}`"
    names = ", ".join("`\\" + one + "`" for one in options)
    return f"it has {names}" if names else "leave it out"


def _valued(argument: s.Option, parameter: Parameter, routine: Signature, look: Look) -> Found:
    if parameter.type == "switch":
        rule = rules.SWITCH_WITH_VALUE if argument.value is not None else None
    else:
        rule = rules.OPTION_WITHOUT_VALUE if parameter.type and argument.value is None else None
    if rule is not None:
        yield look.finding(
            rule, argument, routine=routine.name, option=argument.name, type=parameter.type
        )


def _required(call: Call, routine: Signature, scope: Scope) -> Found:
    look = scope.look
    given = [a for a in call.arguments if isinstance(a, s.Positional)]
    slots = routine.required
    known = {one.name.lower() for slot in slots for one in slot.alternatives}
    for argument, slot in zip(given, slots, strict=False):
        name = (argument.name or "").lower()
        sure = name in known or routine is not signature(routine.name)
        if name and sure and name not in {one.name.lower() for one in slot.alternatives}:
            yield look.finding(
                rules.WRONG_NAME,
                argument,
                routine=routine.name,
                name=argument.name,
                parameter=slot.alternatives[0].name,
            )
    if routine.open or any(isinstance(a.value, s.Placeholder) for a in given):
        return
    if len(given) > len(slots):
        yield look.finding(
            rules.TOO_MANY,
            given[len(slots)],
            routine=routine.name,
            given=len(given),
            usage=usage(routine),
        )
    elif len(given) < len(slots):
        yield look.finding(
            rules.MISSING,
            call,
            routine=routine.name,
            parameters=_missing([a.value for a in given], slots, scope),
            usage=usage(routine),
        )


def _missing(given: Sequence[s.Expression], slots: Sequence[Slot], scope: Scope) -> str:
    """The one parameter without which the types fit, else how many are missing."""
    if len(slots) == 1:
        return _named(slots[0])
    if len(slots) == len(given) + 1:
        gaps = [
            gap
            for i, gap in enumerate(slots)
            if all(map(scope.suits, given, (*slots[:i], *slots[i + 1 :])))
        ]
        if len(gaps) == 1:
            return _named(gaps[0])
    return f"{len(slots) - len(given)} of its {len(slots)} arguments"


def _named(slot: Slot) -> str:
    return " or ".join(f"`{one.name}`" for one in slot.alternatives)


def usage(routine: Signature) -> str:
    """The arguments that a routine must be given, as a call would have them."""
    names = ", ".join(slot.alternatives[0].name for slot in routine.required)
    if routine.kind == "FUNC":
        return f"{routine.name}({names})"
    return f"{routine.name} {names}".rstrip()
