"""Rules of how names, values and routines are used.

Calls (a routine of that name, arguments that fit its signature), names of data, types, components
and errors that nothing declares, and the types of values: aggregates, initial values, assignments,
indices, operands, conditions. One walk over a module; `_RULES_BY_CONSTRUCT` lists the rules of each
node type.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final

from assistant.base.diagnostics import Rule, Severity
from assistant.languages.checks.names import misspelt
from assistant.languages.checks.registry import Found
from assistant.languages.checks.values import Kind, Sizes, Unfit
from assistant.languages.rapid import rules
from assistant.languages.rapid.checks.motions import (
    MOVE_WORDS,
    PREDEFINED_SETTINGS,
    nearest_predefined,
    unknown_setting,
)
from assistant.languages.rapid.checks.rule_context import (
    LOGICAL,
    OPERATORS,
    SIGNAL_TYPES,
    VALUELESS,
    RuleContext,
    Scope,
    scoped_nodes,
)
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.constants import TYPE_ENDING
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.walk import root
from assistant.languages.signatures import Call, Given, Misfit, Parameter, Signature, Slot

CallNode = s.ProcedureCall | s.FunctionCall
_MISFIT_RULES: Final[Mapping[Misfit, Rule]] = {
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
    """Return the signature of a routine of the given modules."""
    slots = tuple(
        Slot(tuple(_parameter(p) for p in named), group.optional)
        for group in routine.parameters
        if (named := [p for p in group.alternatives if isinstance(p, s.ParameterNode)])
    )
    holes = any(isinstance(p, s.Placeholder) for g in routine.parameters for p in g.alternatives)
    return Signature(routine.name, routine.kind, slots, routine.type.lower(), holes)


def _parameter(node: s.ParameterNode) -> Parameter:
    return Parameter(node.name, node.type.lower(), node.mode, node.dimensions)


def _argument_misfits(node: CallNode, call: Call[s.Node], scope: Scope) -> Found:
    """Arguments that are missing, too many, unknown, named wrongly, or given twice."""
    routine = call.routine
    standard = routine is signature(routine.name)
    for what, at, fields in call.misfits(scope.suits, any_name=standard):
        rule = rules.NEW_OPTION if what is Misfit.UNKNOWN and standard else _MISFIT_RULES[what]
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


def _unknown_component(node: s.Component, scope: Scope) -> Found:
    yield from _unknown_data(node.value, scope)
    kind = scope.kind(node.value)
    if kind is None or kind.dimensions:
        return
    components = scope.types.components(kind.type)
    if components is None and not scope.types.atomic(kind.type):
        return
    names = list(components or ())
    if node.name.lower() not in {name.lower() for name in names}:
        hint = f"it has {', '.join(names)}" if names else "use the value itself"
        yield scope.look.finding(
            rules.UNKNOWN_COMPONENT, node, type=kind.type, name=node.name, hint=hint
        )


def _index_count(node: s.Element, scope: Scope) -> Found:
    yield from _unknown_data(node.value, scope)
    kind = scope.kind(node.value)
    if kind is not None and kind.dimensions not in (-1, len(node.indices)):
        yield scope.look.finding(
            rules.INDEX_COUNT, node, count=kind.dimensions, given=len(node.indices)
        )


def _assigned_data(node: s.Assignment, scope: Scope) -> Found:
    yield from _unknown_data(node.target, scope)


def _unknown_data(node: s.Expression, scope: Scope) -> Found:
    """A name that can be no signal and that no given module declares, at its first use."""
    if not isinstance(node, s.NameRef) or scope.find(node.name) is not None:
        return
    low = node.name.lower()
    # A compiled program has a rule of its own for undeclared names.
    if low in predefined.data() or scope.look.compiled:
        return
    if scope.look.first("data", low):
        yield scope.look.finding(rules.UNKNOWN_DATA, node, name=node.name)


def _name_without_value(node: s.NameRef, scope: Scope) -> Found:
    """The name of a routine, of a type or of a module, where data should stand."""
    found = scope.find(node.name)
    if found is not None:
        if found.kind in VALUELESS and not scope.doubtful(found):
            yield scope.look.finding(
                rules.NAME_WITHOUT_VALUE, node, name=node.name, what=VALUELESS[found.kind]
            )
    elif node.name.lower() not in predefined.data():  # of a module, or a signal that is called so
        yield scope.look.finding(
            rules.NAME_WITHOUT_VALUE,
            node,
            name=node.name,
            what="a module",
            severity=Severity.WARNING,
        )


def _unknown_errors(
    node: s.RaiseError | s.Handler | s.Infix | s.TestOf | s.Assignment, scope: Scope
) -> Found:
    """Names of errors: those that are raised, handled, assigned, or compared with a number."""
    named: tuple[s.Expression | None, ...] = ()
    sure = False
    match node:
        case s.RaiseError(value):
            named, sure = (value,), True
        case s.Handler(numbers=numbers):
            named, sure = numbers, True
        case s.Infix(_, left, right):
            named, sure = (left, right), _is_errnum(left, scope) or _is_errnum(right, scope)
        case s.TestOf(subject, cases):
            named = tuple(value for case in cases for value in case.values)
            sure = _is_errnum(subject, scope)
        case s.Assignment(target, value):
            named, sure = (value,), _is_errnum(target, scope)
    for one in named:
        # Predefined errors begin with ERR_, so such a name is meant as one.
        if isinstance(one, s.NameRef) and (sure or one.name.startswith("ERR_")):
            yield from _unknown_data(one, scope)


def _is_errnum(value: s.Expression, scope: Scope) -> bool:
    """True for the number of an error; other numbers may be those of signals."""
    if not isinstance(value, s.NameRef):
        return False
    found, standard = scope.find(value.name), predefined.data().get(value.name.lower())
    type = found.type if found is not None else standard.type if standard is not None else ""
    return type.lower() == "errnum"


def _unknown_type(node: s.Data | s.ParameterNode | s.Routine, scope: Scope) -> Found:
    yield from _unknown_types((node.type,) if node.type else (), node, scope)


def _unknown_component_types(node: s.Record, scope: Scope) -> Found:
    yield from _unknown_types((type for type, _ in node.components), node, scope)


def _unknown_types(names: Iterable[str], node: s.Node, scope: Scope) -> Found:
    for name in names:
        if scope.types.base(name) is not None or not scope.look.first("type", name):
            continue
        near = misspelt(name, scope.types.known(), TYPE_ENDING)
        if near:
            yield scope.look.finding(rules.MISSPELT_TYPE, node, name=name, near=near)
        else:
            unsure = scope.look.task.unsure
            yield scope.look.finding(rules.UNKNOWN_TYPE, node, name=name, severity=unsure)


_UNFIT_RULES: Final[Mapping[Unfit, Rule]] = {
    Unfit.TYPE: rules.WRONG_VALUE,
    Unfit.ELEMENTS: rules.ELEMENT_COUNT,
    Unfit.COMPONENTS: rules.COMPONENT_COUNT,
}
_CONDITION_TYPES: Final = SIGNAL_TYPES | {"bool"}
"""Types of conditions."""


def _initial_value(node: s.Data, scope: Scope) -> Found:
    kind = scope.of(node.type)
    if node.value is not None and kind is not None and not predefined.is_handle(kind.type):
        sizes = tuple(_known_extent(size, scope) for size in node.dimensions)
        yield from _unfit_value(node.value, kind.type, sizes, scope)


def _assigned_value(node: s.Assignment, scope: Scope) -> Found:
    yield from _value_of_kind(node.value, scope.kind(node.target), scope)


def _returned_value(node: s.ReturnFrom, scope: Scope) -> Found:
    routine = scope.routine
    if routine is not None and routine.kind == "FUNC" and node.value is not None:
        yield from _value_of_kind(node.value, scope.of(routine.type), scope)


def _value_of_kind(value: s.Expression, kind: Kind | None, scope: Scope) -> Found:
    if kind is not None and kind.dimensions >= 0:
        yield from _unfit_value(value, kind.type, (None,) * kind.dimensions, scope)


def _unfit_value(value: s.Expression, type: str, sizes: Sizes, scope: Scope) -> Found:
    """Report the faults of a value where a type, or an array of it, is required."""
    for what, part, fields in scope.unfit(value, type, sizes):
        yield scope.look.finding(_UNFIT_RULES[what], part, **fields)


def _known_extent(size: s.Expression, scope: Scope) -> int | None:
    """A dimension that is a literal or a declared constant, None for any other."""
    if isinstance(size, s.NameRef):
        found = scope.find(size.name)
        if found is None or found.kind != "CONST" or scope.doubtful(found):
            return None
        value = found.node.value if isinstance(found.node, s.Data) else None
        return (
            None if value is None or isinstance(value, s.NameRef) else _known_extent(value, scope)
        )
    number = literal_number(size)
    return None if number is None or not math.isfinite(number) else int(number)


def _index_range(node: s.Element, scope: Scope) -> Found:
    """Indices that are known and no element has."""
    kind = scope.kind(node.value)
    if not isinstance(node.value, s.NameRef) or kind is None:
        return
    # Another rule reports the wrong number of indices.
    if kind.dimensions != len(node.indices):
        return
    name = node.value.name
    found = scope.find(name)
    array = found.node if found is not None else None
    declared = array.dimensions if isinstance(array, s.Data) else (None,) * kind.dimensions
    for index, dimension in zip(node.indices, declared, strict=True):
        at = None if isinstance(index, s.Whole) else _known_extent(index, scope)
        most = None if dimension is None else _known_extent(dimension, scope)
        if at is not None and (at < 1 or (most is not None and at > most)):
            to = "" if most is None else f" to {most}"
            yield scope.look.finding(rules.INDEX_RANGE, node, index=at, name=name, to=to)


def _condition_type(node: s.IfBranch | s.CompactIf | s.WhileLoop, scope: Scope) -> Found:
    if node.condition is not None:
        yield from _truth_value(node.condition, scope)


def _truth_value(value: s.Expression, scope: Scope) -> Found:
    kind = scope.kind(value)
    if kind is not None and kind.type not in _CONDITION_TYPES:
        yield scope.look.finding(rules.NO_TRUTH, value, given=kind)


def _negated_operand(node: s.Prefix, scope: Scope) -> Found:
    if node.operator == "NOT":
        yield from _truth_value(node.operand, scope)


def _operand_types(node: s.Infix, scope: Scope) -> Found:
    if node.operator in LOGICAL:
        yield from _truth_value(node.left, scope)
        yield from _truth_value(node.right, scope)
        return
    one, other = scope.read(node.left), scope.read(node.right)
    if one is not None and other is not None and not OPERATORS.join(node.operator, one, other):
        cure = "turn the other into text with `ValToStr` or `NumToStr`"
        text = node.operator == "+" and "string" in (one.type, other.type)
        yield scope.look.finding(
            rules.OPERANDS,
            node,
            operator=node.operator,
            left=one,
            right=other,
            hint=cure if text else "bring both to one type",
        )


def _case_types(node: s.TestOf, scope: Scope) -> Found:
    subject = scope.read(node.subject)
    for value in (value for case in node.cases for value in case.values):
        given = scope.read(value)
        if subject is not None and not OPERATORS.fits(given, subject, read=False):
            yield scope.look.finding(rules.WRONG_VALUE, value, given=given, wanted=subject)


_ROUTINE_KINDS: Final = ("PROC", "FUNC")
_SIGNAL_VALUE_TYPES: Final = frozenset({"num", "dnum", "bool"})
"""Types of values that may be the state of a signal."""


def _procedure_call(node: s.ProcedureCall, scope: Scope) -> Found:
    if isinstance(node.name, str):
        yield from _routine_call(node, node.name, "PROC", scope)


def function_call(node: s.FunctionCall, scope: Scope) -> Found:
    yield from _routine_call(node, node.name, "FUNC", scope)


def _connected_trap(node: s.Connect, scope: Scope) -> Found:
    yield from _unknown_data(node.interrupt, scope)
    if scope.find(node.trap) is None and scope.look.first("routine", node.trap):
        severity = scope.look.task.unsure
        yield scope.look.finding(rules.UNKNOWN_ROUTINE, node, name=node.trap, severity=severity)


def _routine_call(
    node: s.ProcedureCall | s.FunctionCall, name: str, kind: str, scope: Scope
) -> Found:
    found = scope.find(name)
    if found is None:
        routine = signature(name)
        if routine is None:
            yield from _unknown_routine(node, name, kind, scope)
            return
    # Several modules declare it, and any of them may be loaded.
    elif scope.doubtful(found):
        return
    elif found.kind in _ROUTINE_KINDS and isinstance(found.node, s.Routine):
        routine = signature_of(found.node)
    else:
        what = _STORAGE_TEXTS.get(found.kind, f"a {found.kind}")
        yield scope.look.finding(rules.NOT_A_ROUTINE, node, name=name, what=what)
        return
    if routine.kind != kind:
        rule = rules.FUNCTION_ALONE if kind == "PROC" else rules.NO_FUNCTION
        yield scope.look.finding(rule, node, name=routine.name)
        return
    call = call_of(node, routine)
    yield from _argument_misfits(node, call, scope)
    for value, parameters in call.bound():
        yield from _argument_value(value, parameters, routine, scope)


def _unknown_routine(
    node: s.ProcedureCall | s.FunctionCall, name: str, kind: str, scope: Scope
) -> Found:
    if not scope.look.first("routine", name):
        return
    own = [one.name for one in scope.look.task.shared if one.kind == kind]
    # An option may have routines that are not listed: none of those is taken for a slip.
    rows = predefined.rows().items()
    standard = [n for n, (line, option) in rows if line.startswith(kind) and not option]
    near = misspelt(name, [*own, *standard], TYPE_ENDING)
    meant = _routine_signature(near, scope) if near else None
    # A similar name is meant only if the arguments fit it.
    if meant is not None and _fits_routine(node, meant, scope):
        yield scope.look.finding(rules.MISSPELT_ROUTINE, node, name=name, near=meant.name)
    else:
        severity = scope.look.task.unsure
        yield scope.look.finding(rules.UNKNOWN_ROUTINE, node, name=name, severity=severity)


def _routine_signature(name: str, scope: Scope) -> Signature | None:
    found = scope.find(name)
    if found is None:
        return signature(name)
    return signature_of(found.node) if isinstance(found.node, s.Routine) else None


def _fits_routine(node: s.ProcedureCall | s.FunctionCall, routine: Signature, scope: Scope) -> bool:
    """True if the arguments of a call fit another routine; otherwise the call hardly means that
    one.
    """
    call = call_of(node, routine)
    return not any(_argument_misfits(node, call, scope)) and all(
        scope.suiting(value, parameters) for value, parameters in call.bound()
    )


def _argument_value(
    value: s.Expression, parameters: Sequence[Parameter], routine: Signature, scope: Scope
) -> Found:
    if isinstance(value, s.Placeholder) or any(one.mode == "REF" for one in parameters):
        return
    if isinstance(value, s.NameRef) and scope.find(value.name) is None:
        type = parameters[0].type
        if type in PREDEFINED_SETTINGS and nearest_predefined(
            value.name, PREDEFINED_SETTINGS[type][0]
        ):
            if routine.name.lower() not in MOVE_WORDS:  # else the rule of moves has said it
                yield from unknown_setting(scope.look, value, value.name, type)
        elif all(_is_data(one, scope) for one in parameters):
            yield from _unknown_data(value, scope)
    if isinstance(value, s.AggregateNode) and not any(one.mode for one in parameters):
        base = scope.types.base(parameters[0].type)
        if len(parameters) == 1 and base and not parameters[0].dimensions:
            yield from _unfit_value(value, base, (), scope)
        # Parts of the value are compared one by one; as a whole it has no type.
        return
    fit = scope.suiting(value, parameters)
    if not fit:
        yield scope.look.finding(
            rules.WRONG_ARGUMENT,
            value,
            routine=routine.name,
            parameter=parameters[0].name,
            given=scope.kind(value),
            wanted=" or ".join(str(scope.wanted(one)) for one in parameters),
        )
    elif all(one.mode for one in fit):
        yield from _changed_argument(value, fit[0], routine, scope)


def _is_data(parameter: Parameter, scope: Scope) -> bool:
    """True if a name passed for a parameter is certainly data, not a signal or a unit."""
    base = scope.types.base(parameter.type) or ""
    return not scope.types.device(base) and (
        bool(parameter.mode) or base not in _SIGNAL_VALUE_TYPES
    )


def _changed_argument(
    value: s.Expression, parameter: Parameter, routine: Signature, scope: Scope
) -> Found:
    """Report an argument that the routine changes but that is not changeable data."""
    data = root(value)
    storage = _storage_of(data, scope) if data is not None else "value"
    # Moves have a rule of their own for tools and work objects.
    moved = routine.name.lower() in MOVE_WORDS and parameter.type in ("tooldata", "wobjdata")
    if parameter.mode == "PERS" and storage in ("VAR", "CONST", "IN", "FOR"):
        rule = None if moved and storage in ("VAR", "CONST") else rules.NO_PERSISTENT
    elif parameter.mode == "VAR" and storage == "PERS":
        rule = rules.NO_VARIABLE
    else:
        rule = rules.NO_REFERENCE if storage in ("value", "CONST", "FOR") else None
    if rule is not None:
        what = (
            f"`{data.name}`, which is {_STORAGE_TEXTS[storage]}"
            if data is not None
            else _VALUE_TEXT
        )
        words: dict[str, Any] = {"parameter": parameter.name, "mode": parameter.mode, "what": what}
        yield scope.look.finding(rule, value, routine=routine.name, **words)


_VALUE_TEXT: Final = "a value that is calculated or written out"
_STORAGE_TEXTS: Final = {
    "VAR": "a VAR",
    "CONST": "a CONST",
    "PERS": "a PERS",
    "IN": "a parameter that holds a copy",
    "INOUT": "a parameter",
    "FOR": "the variable of a loop",
}


def _storage_of(data: s.NameRef, scope: Scope) -> str:
    found = scope.find(data.name)
    if found is not None:
        return "" if scope.doubtful(found) else found.kind
    standard = predefined.data().get(data.name.lower())
    return standard.storage if standard else ""


_ConstructRules = tuple[Callable[[Any, Scope], Found], ...]

_RULES_BY_CONSTRUCT: Final[Mapping[type, _ConstructRules]] = {
    s.ProcedureCall: (_procedure_call,),
    s.FunctionCall: (function_call,),
    s.NameRef: (_name_without_value,),
    s.Connect: (_connected_trap,),
    s.Component: (_unknown_component,),
    s.Element: (_index_count, _index_range),
    s.Assignment: (_assigned_data, _unknown_errors, _assigned_value),
    s.Data: (_unknown_type, _initial_value),
    s.ParameterNode: (_unknown_type,),
    s.Routine: (_unknown_type,),
    s.Record: (_unknown_component_types,),
    s.RaiseError: (_unknown_errors,),
    s.Handler: (_unknown_errors,),
    s.Infix: (_unknown_errors, _operand_types),
    s.IfBranch: (_condition_type,),
    s.CompactIf: (_condition_type,),
    s.WhileLoop: (_condition_type,),
    s.ReturnFrom: (_returned_value,),
    s.TestOf: (_unknown_errors, _case_types),
    s.Prefix: (_negated_operand,),
}
"""One line adds a rule of a construct."""


def uses_by_construct(look: RuleContext) -> Found:
    for node, scope in look.once(scoped_nodes):
        for rule in _RULES_BY_CONSTRUCT.get(type(node), ()):
            yield from rule(node, scope)
