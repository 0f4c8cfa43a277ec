"""Parameters of routines that other languages lack: optional, unused, and the error number.

A procedure with the optional parameters `num by` and `switch fast` gets required ones instead: a
truth that is TRUE if `by` is given, `by` itself, and `fast` as a truth; the truth is left out if
all calls give `by`, or none. A parameter of data that only equipment takes is left out if the
routine never uses it. A routine that only handlers call and that asks for `ERRNO` gets the error as
a parameter: `note;` becomes `note ERRNO;`, as other languages know the error only where it is
handled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.rapid.lift.flatten.record_layout import (
    SETTING_TYPES,
    SPEED_AND_ZONE,
    RecordLayouts,
)
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.signals import PROCESS_DATA_TYPES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import ERRNO, called_in, nodes, routines_of_handlers
from assistant.program.rewriting import rewrite

_SWITCH: Final = "switch"
_PRESENT: Final = "present"
_ZERO: Final = s.NumberLiteral("0")
_NOWHERE: Final = s.AggregateNode(
    (
        s.AggregateNode((_ZERO, _ZERO, _ZERO)),
        s.AggregateNode((s.NumberLiteral("1"), _ZERO, _ZERO, _ZERO)),
    )
)
_OUTSIDE: Final = s.AggregateNode((s.NumberLiteral("9E9"),) * 6)
_ABSENT_VALUES: Final[Mapping[str, s.Expression]] = {
    "num": _ZERO,
    "bool": s.BoolLiteral(False),
    "string": s.StringLiteral(""),
    "pose": _NOWHERE,
    "robtarget": s.AggregateNode((*_NOWHERE.items, s.AggregateNode((_ZERO,) * 4), _OUTSIDE)),
    "jointtarget": s.AggregateNode((s.AggregateNode((_ZERO,) * 6), _OUTSIDE)),
}
"""Values passed where an optional value is omitted; nothing reads them."""


@dataclass(frozen=True, slots=True)
class _Parameter:
    """An optional parameter that becomes a required one.

    given: the truth that says whether it is there, None if it always is. absent: a value for a
    call that leaves it out, None if every call gives it. never: no call does.
    """

    node: s.ParameterNode
    given: str | None = None
    absent: s.Expression | None = None
    never: bool = False

    @property
    def is_switch(self) -> bool:
        return self.node.type.lower() == _SWITCH


_Parameters = Mapping[str, _Parameter]
"""By lower-case name."""


def with_required(
    modules: Sequence[s.Module], layouts: RecordLayouts, name: Callable[[str], str]
) -> Sequence[s.Module]:
    """Return the modules without optional parameters, as far as their types have an equivalent.

    name: returns a unique name.
    """
    routines: dict[str, list[s.Routine]] = {}
    for item in (item for module in modules for item in module.items):
        if isinstance(item, s.Routine):
            routines.setdefault(item.name.lower(), []).append(item)
    # Calls are matched by name, so a second routine of the name rules both out.
    wanted = {
        key: own[0]
        for key, own in routines.items()
        if len(own) == 1 and any(group.optional for group in own[0].parameters)
    }
    if not wanted:
        return modules
    asked = _OptionUses(modules, wanted)
    made: dict[str, _Parameters] = {}
    added: list[s.Data] = []
    for key, routine in wanted.items():
        made[key] = dict(_required_parameters(routine, asked, layouts, name, added))
    changed = []
    for at, module in enumerate(modules):
        items = [
            _required_routine(item, made, wanted) if isinstance(item, s.Routine) else item
            for item in module.items
        ]
        # Data for absent arguments belongs to no module in particular; the first one declares it.
        data = added if at == 0 else []
        same = not data and all(a is b for a, b in zip(items, module.items, strict=True))
        changed.append(module if same else replace(module, items=(*data, *items)))
    return changed


class _OptionUses:
    """Which optional parameters calls give: how often, and how often by what the caller has."""

    def __init__(self, modules: Sequence[s.Module], routines: Mapping[str, s.Routine]) -> None:
        self.calls: dict[str, int] = dict.fromkeys(routines, 0)
        self.given: dict[tuple[str, str], int] = {}
        self.handed_on: set[tuple[str, str]] = set()
        for node in nodes(tuple(modules)):
            if not isinstance(node, s.ProcedureCall | s.FunctionCall):
                continue
            if not isinstance(node.name, str) or node.name.lower() not in routines:
                continue
            key = node.name.lower()
            self.calls[key] += 1
            for argument in node.arguments:
                match argument:
                    case s.Option(name):
                        place = key, name.lower()
                        self.given[place] = self.given.get(place, 0) + 1
                    case s.Conditional(name):
                        self.handed_on.add((key, name.lower()))

    def ever(self, routine: str, name: str) -> bool:
        return (routine, name) in self.given or (routine, name) in self.handed_on

    def always(self, routine: str, name: str) -> bool:
        count = self.given.get((routine, name), 0)
        return count > 0 and count == self.calls[routine]


def _required_parameters(
    routine: s.Routine,
    asked: _OptionUses,
    layouts: RecordLayouts,
    name: Callable[[str], str],
    added: list[s.Data],
) -> Iterator[tuple[str, _Parameter]]:
    """The optional parameters of a routine that become required ones."""
    key = routine.name.lower()
    for group in routine.parameters:
        for one in group.alternatives if group.optional else ():
            if not isinstance(one, s.ParameterNode):
                continue
            low, type = one.name.lower(), layouts.base(one.type)
            if type == _SWITCH:
                yield low, _Parameter(one)
                continue
            # Every call gives it, so no truth is needed.
            if asked.always(key, low):
                yield low, _Parameter(one)
                continue
            absent = absent_value(type, layouts)
            if absent is None or one.dimensions < 0:
                continue
            # No call gives it: the parameter goes, and its name becomes local data.
            if not asked.ever(key, low):
                yield low, _Parameter(one, absent=absent, never=True)
                continue
            # By reference a call has to pass data, not a literal.
            if one.mode or one.dimensions:
                held = name(f"{routine.name}_{one.name}_none")
                sizes = (s.NumberLiteral("1"),) * one.dimensions
                added.append(s.Data("", "PERS" if one.mode == "PERS" else "VAR", type, held, sizes))
                absent = s.NameRef(held)
            yield low, _Parameter(one, name(f"{one.name}_given"), absent)


def absent_value(type: str, layouts: RecordLayouts) -> s.Expression | None:
    """Return a value of a type, None if no value of the type can be written."""
    if type in _ABSENT_VALUES:
        return _ABSENT_VALUES[type]
    if type in SETTING_TYPES - SPEED_AND_ZONE or layouts.parts(type) is None:
        return None
    inner = [absent_value(layouts.base(of), layouts) for _, of in layouts.components(type)]
    known = tuple(one for one in inner if one is not None)
    return s.AggregateNode(known) if len(known) == len(inner) else None


def _required_routine(
    routine: s.Routine, made: Mapping[str, _Parameters], wanted: Mapping[str, s.Routine]
) -> s.Routine:
    """A routine with required parameters, whose calls give all that others require."""
    own = made.get(routine.name.lower(), {})

    def change(part: Any) -> Any:
        match part:
            case s.FunctionCall(str(word), (s.Positional(s.NameRef(asked), None),)) if (
                word.lower() == _PRESENT and asked.lower() in own
            ):
                return _presence_parameter(own[asked.lower()])
            case s.ProcedureCall(str(name), given) | s.FunctionCall(str(name), given) if (
                parameters := made.get(name.lower())
            ):
                callee = wanted[name.lower()]
                arguments = _arguments(callee, parameters, given, own)
                return part if arguments is None else replace(part, arguments=arguments)
        return part

    changed = rewrite(routine, change, ())
    if own:
        groups = tuple(one for group in routine.parameters for one in _groups(group, own))
        # Dead branches may still mention the parameter, which has to be declared somewhere.
        local = tuple(
            s.Data("", "VAR", one.node.type, one.node.name)
            for one in own.values()
            if one.never and not one.is_switch and _mentions(routine.body, one.node.name)
        )
        changed = replace(changed, parameters=groups, body=(*local, *changed.body))
    return changed


def _mentions(body: Any, name: str) -> bool:
    low = name.lower()
    return any(isinstance(n, s.NameRef) and n.name.lower() == low for n in nodes(body))


def _presence_parameter(parameter: _Parameter) -> s.Expression:
    if parameter.is_switch:
        return s.NameRef(parameter.node.name)
    if parameter.given is not None:
        return s.NameRef(parameter.given)
    return s.BoolLiteral(not parameter.never)


def _groups(group: s.ParameterGroup, own: _Parameters) -> Iterator[s.ParameterGroup]:
    """The required parameters that a group becomes, and what of it stays optional."""
    if not group.optional:
        yield group
        return
    left: list[s.ParameterNode | s.Placeholder] = []
    for one in group.alternatives:
        known = own.get(one.name.lower()) if isinstance(one, s.ParameterNode) else None
        if known is None:
            left.append(one)
        elif known.is_switch:
            yield s.ParameterGroup(False, (replace(known.node, type="bool", mode=""),))
        elif not known.never:
            if known.given is not None:
                yield s.ParameterGroup(False, (s.ParameterNode("", "bool", known.given),))
            yield s.ParameterGroup(False, (known.node,))
    if left:
        yield replace(group, alternatives=tuple(left))


def _arguments(
    callee: s.Routine, parameters: _Parameters, given: Sequence[s.Argument], caller: _Parameters
) -> tuple[s.Argument, ...] | None:
    """Arguments in the order of the parameters; None for a call that nobody understands.

    caller: the optional parameters of the routine that calls.
    """
    plain = [one for one in given if isinstance(one, s.Positional)]
    named: dict[str, s.Option | s.Conditional] = {}
    for argument in given:
        if not isinstance(argument, s.Positional):
            named[argument.name.lower()] = argument
    places = iter(plain)
    made: list[s.Argument] = []
    for group in callee.parameters:
        if not group.optional:
            place = next(places, None)
            if place is None:
                return None
            # Positions are all that is left of named arguments, as the order is that of the
            # parameters.
            made.append(replace(place, name=None))
            continue
        for one in group.alternatives:
            if not isinstance(one, s.ParameterNode):
                return None
            low = one.name.lower()
            option, known = named.pop(low, None), parameters.get(low)
            if known is None:
                made += () if option is None else (option,)
            elif (said := _argument_values(known, option, caller)) is None:
                return None
            else:
                made += map(s.Positional, said)
    return None if named or next(places, None) is not None else tuple(made)


def _argument_values(
    known: _Parameter, argument: s.Option | s.Conditional | None, caller: _Parameters
) -> tuple[s.Expression, ...] | None:
    """Return the arguments passed for a parameter; None if the argument is not understood."""
    there: s.Expression = s.BoolLiteral(argument is not None)
    value: s.Expression | None = None
    match argument:
        case s.Option(_, value):
            pass
        case s.Conditional(_, s.NameRef(name)) if name.lower() in caller:
            there, value = _presence_parameter(caller[name.lower()]), s.NameRef(name)
            # The caller has no such parameter any more.
            if caller[name.lower()].never:
                value = known.absent
        case s.Conditional():
            return None
        case None:
            value = known.absent
    if known.is_switch:
        return (there,)
    if known.never:
        return ()
    if value is None:
        return None
    return (value,) if known.given is None else (there, value)


@dataclass(frozen=True, slots=True)
class _Removed:
    """Places of required parameters that are left out, and names of optional ones in lower case."""

    places: frozenset[int]
    options: frozenset[str]


def without_unused_parameters(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules without such parameters, and without what calls give for them."""
    routines = [item for m in modules for item in m.items if isinstance(item, s.Routine)]
    if not any(
        _is_equipment_data(group, frozenset()) for one in routines for group in one.parameters
    ):
        return modules
    own = frozenset(i.name.lower() for m in modules for i in m.items if isinstance(i, s.Record))
    names = Counter(one.name.lower() for one in routines)
    unused = {id(one): _unused_places(one, own) for one in routines if names[one.name.lower()] == 1}
    # A call by a computed name cannot be given fewer arguments: its routine is not known.
    if not any(unused.values()) or any(map(_is_late_bound, nodes(tuple(modules)))):
        return modules
    gone = {
        one.name.lower(): _removed_parameters(one, unused[id(one)])
        for one in routines
        if id(one) in unused
    }

    def item(node: s.Item) -> Any:
        left = rewrite(node, lambda part: _with_used_arguments(part, gone), ())
        if isinstance(left, s.Routine) and unused.get(id(node)):
            kept = (g for at, g in enumerate(left.parameters) if at not in unused[id(node)])
            return replace(left, parameters=tuple(kept))
        return left

    return [replace(m, items=tuple(map(item, m.items))) for m in modules]


def _is_equipment_data(group: s.ParameterGroup, own: frozenset[str]) -> bool:
    """True if a parameter is of data for equipment only. own: records of the program."""
    match group.alternatives:
        case (s.ParameterNode(type=type),) if type.lower() not in own:
            known = predefined.types().get(type.lower())
            open_ = known is not None and known.kind == "RECORD" and known.components is None
            return open_ or type.lower() in PROCESS_DATA_TYPES
    return False


def _unused_places(routine: s.Routine, own: frozenset[str]) -> frozenset[int]:
    """Places in the list of parameters of those that the body never names."""
    opaque = {at for at, group in enumerate(routine.parameters) if _is_equipment_data(group, own)}
    if not opaque:
        return frozenset()
    named = {
        one.name.lower()
        for one in nodes((routine.body, routine.handlers))
        if isinstance(one, s.NameRef)
    }
    return frozenset(
        at
        for at in opaque
        if not any(
            isinstance(one, s.ParameterNode) and one.name.lower() in named
            for one in routine.parameters[at].alternatives
        )
    )


def _removed_parameters(routine: s.Routine, unused: frozenset[int]) -> _Removed:
    required = [at for at, group in enumerate(routine.parameters) if not group.optional]
    optional = (routine.parameters[at] for at in unused if routine.parameters[at].optional)
    names = (one for group in optional for one in group.alternatives)
    return _Removed(
        frozenset(place for place, at in enumerate(required) if at in unused),
        frozenset(one.name.lower() for one in names if isinstance(one, s.ParameterNode)),
    )


def _with_used_arguments(node: Any, gone: Mapping[str, _Removed]) -> Any:
    """A call without the arguments that nobody takes any more; anything else as it is."""
    if not isinstance(node, s.ProcedureCall | s.FunctionCall) or not isinstance(node.name, str):
        return node
    left_out = gone.get(node.name.lower())
    if left_out is None or not (left_out.places or left_out.options):
        return node
    return replace(node, arguments=tuple(_used_arguments(node.arguments, left_out)))


def _used_arguments(arguments: Sequence[s.Argument], left_out: _Removed) -> Iterator[s.Argument]:
    place = -1
    for argument in arguments:
        if isinstance(argument, s.Positional):
            place += 1
            if place in left_out.places:
                continue
        elif argument.name.lower() in left_out.options:
            continue
        yield argument


def _is_late_bound(node: Any) -> bool:
    """True if a call passes arguments to a routine whose name is computed."""
    late = isinstance(node, s.ProcedureCall) and not isinstance(node.name, str)
    return late and bool(node.arguments)


_ERROR_PARAMETER: Final = "error_number"


def with_passed_errors(modules: Sequence[s.Module]) -> Sequence[s.Module]:
    """The modules whose handlers hand the error over; themselves where no routine asks for it."""
    routines = [one for module in modules for one in module.items if isinstance(one, s.Routine)]
    asking = _error_readers(routines, routines_of_handlers(modules))
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
            return s.NameRef(_ERROR_PARAMETER, span=node.span)
        return node

    def item(one: s.Item) -> s.Item:
        if not isinstance(one, s.Routine):
            return one
        made = replace(one, handlers=rewrite(one.handlers, handed("ERRNO"), ()))
        if one.name.lower() not in asking:
            return made if made.handlers is not one.handlers else one
        body = rewrite(rewrite(one.body, asked, ()), handed(_ERROR_PARAMETER), ())
        parameter = s.ParameterGroup(False, (s.ParameterNode("", "num", _ERROR_PARAMETER),))
        return replace(made, body=body, parameters=(*one.parameters, parameter))

    return [replace(module, items=tuple(map(item, module.items))) for module in modules]


def _error_readers(routines: Sequence[s.Routine], handling: frozenset[str]) -> frozenset[str]:
    """Names in lower case of routines that handlers alone call and that ask for their error.

    None where one of them is called by a name that is worked out, or from anywhere else.
    """
    bodies = {one.name.lower(): one for one in routines}
    # The name of the new parameter must be free everywhere.
    if any(
        isinstance(n, s.NameRef) and n.name.lower() == _ERROR_PARAMETER
        for n in nodes(tuple(routines))
    ):
        return frozenset()
    # A call by a computed name may reach a routine without handing the error over.
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
    # A caller that is no handler has no error to hand over.
    outside = {
        name for one in routines if one.name.lower() not in asking for name in called_in(one.body)
    }
    return frozenset() if asking & outside else frozenset(asking)


def _asks_error(body: Any) -> bool:
    return any(isinstance(node, s.NameRef) and node.name.lower() == ERRNO for node in nodes(body))
