"""Copy routines that take tools, frames, signals, devices or arrays, so that each copy names them.

`PROC pick(robtarget p, PERS tooldata t)` called with `tGrip` and with `tSuck` becomes
`pick_tGrip(robtarget p)` and `pick_tSuck(robtarget p)`: moves, waits and files need names that are
known in their scope. A call without an optional parameter gets a copy without it, in which
`Present(x)` is FALSE. A routine with one kind of call keeps its name. Calls with computed arguments
remain, and so does their routine. An array by value is the array itself if the routine does not
change it while it runs, else a copy in an array of the module. A library routine has callers that
were not read: a tool or frame that they pass becomes one of the program, which the caller sets
first; the cell file has to name a signal or the connection of a socket.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.late_binding import accepts_call
from assistant.languages.rapid.lift.flatten.record_layout import (
    READ_ONLY_TYPES,
    SETTING_TYPES,
    RecordLayouts,
)
from assistant.languages.rapid.lift.flatten.tree_rewriting import (
    argument_key,
    is_literal,
    is_table_row,
    substituted,
    with_first_statements,
    with_presence,
    with_routine_names,
    without_dead_branches,
)
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.signals import SIGNAL_TYPES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import inner_names, nodes, root
from assistant.languages.signatures import Parameter
from assistant.program.analysis.uses import recursive_names
from assistant.program.program import TakenNames, identifier
from assistant.program.rewriting import rewrite

Routines = Mapping[str, Sequence[s.Routine]]
"""Those of a program by lower-case name."""
_ANY_TRAP: Final = "trap"
"""All that may run at any time; a word of the language, which no routine has for its name."""


def call_graph(routines: Routines) -> Mapping[str, set[str]]:
    """By routine what it calls, in lower case; empty for a name that is worked out."""
    return {
        key: {name for one in own for name in _called_names(one)} for key, own in routines.items()
    }


def _called_names(routine: s.Routine) -> set[str]:
    return {
        one.name.lower() if isinstance(one.name, str) else ""
        for one in nodes(routine)
        if isinstance(one, s.ProcedureCall | s.FunctionCall)
    }


def reentrant_routines(calls: Mapping[str, set[str]]) -> frozenset[str]:
    """Routines that may be called again while they run; a name that is worked out may be any."""
    return recursive_names({**calls, "": frozenset(calls)})


def _assigned_names(routine: s.Routine) -> set[str]:
    """Names that a routine assigns to, in lower case."""
    targets = (root(one.target) for one in nodes(routine) if isinstance(one, s.Assignment))
    return {one.name.lower() for one in targets if one is not None}


class _ChangedData:
    """Which data routines may change, by names in lower case."""

    def __init__(self, routines: Routines) -> None:
        self._known = routines
        self._own: dict[int, frozenset[str]] = {}
        self._calls: dict[str, set[str]] = {}
        # A trap may run between any two statements.
        traps = [one for own in routines.values() for one in own if one.kind == "TRAP"]
        self._all = {**routines, _ANY_TRAP: traps}

    def of(self, routine: str) -> frozenset[str] | None:
        """All that may be changed until a routine comes back; None if nobody knows."""
        found: set[str] = set()
        seen: set[str] = set()
        pending = [routine, _ANY_TRAP]
        while pending:
            key = pending.pop()
            if key in seen or key not in self._all:
                continue
            seen.add(key)
            if key not in self._calls:
                self._calls[key] = {name for one in self._all[key] for name in _called_names(one)}
            # A name that is computed may be any routine.
            if "" in self._calls[key]:
                return None
            found = found.union(*map(self.own, self._all[key]))
            pending += self._calls[key]
        return frozenset(found)

    def own(self, routine: s.Routine) -> frozenset[str]:
        """Return the names that a routine assigns to, or passes to a routine that may change
        them.
        """
        if id(routine) not in self._own:
            changed = _assigned_names(routine)
            self._own[id(routine)] = frozenset(changed)  # for one that calls itself
            for one in nodes(routine):
                if isinstance(one, s.ProcedureCall | s.FunctionCall):
                    changed |= self.by(one)
            self._own[id(routine)] = frozenset(changed)
        return self._own[id(routine)]

    def by(self, call: s.ProcedureCall | s.FunctionCall) -> set[str]:
        """Return the names that a call passes to a routine that may change them."""
        known = self._known.get(call.name.lower()) if isinstance(call.name, str) else None
        changed: set[str] = set()
        if known is None:
            found = signature(call.name) if isinstance(call.name, str) else None
            alternatives = () if found is None else (a for q in found.slots for a in q.alternatives)
            # Unknown routines, and those that change any of their arguments, may change all of
            # them.
            if found is None or any(a.mode and not _is_only_read(a) for a in alternatives):
                for argument in call.arguments:
                    match argument:
                        case s.Conditional(_, value) | s.Option(_, value) | s.Positional(value):
                            place = root(value)
                    changed |= set() if place is None else {place.name.lower()}
            return changed
        plain = [a.value for a in call.arguments if isinstance(a, s.Positional)]
        options: dict[str, s.Expression] = {}
        for argument in call.arguments:
            match argument:
                case s.Option(name, value) | s.Conditional(name, value) if value is not None:
                    options[name.lower()] = value
        for routine in known:
            own, places = self.own(routine), iter(plain)
            for group in routine.parameters:
                at = None if group.optional else next(places, None)
                for one in group.alternatives:
                    # A parameter by reference that the routine changes is the caller's data.
                    if isinstance(one, s.ParameterNode) and one.mode and one.name.lower() in own:
                        given = root(options.get(one.name.lower(), at))
                        changed |= set() if given is None else {given.name.lower()}
        return changed


def _is_only_read(slot: Parameter) -> bool:
    """True if an instruction only reads an argument that it requires to be persistent."""
    return slot.mode == "PERS" and slot.type in READ_ONLY_TYPES


_CallArguments = tuple[s.Expression | None, ...]
"""Arguments of a call for the parameters that a copy does not have, in their order; None for an
omitted one.
"""


@dataclass(frozen=True, slots=True)
class _CopiedParameter:
    """One of a routine. place: among the required ones, -1 of an optional one."""

    node: s.ParameterNode
    place: int

    @property
    def key(self) -> str:
        return self.node.name.lower()

    @property
    def is_copied(self) -> bool:
        """True if the parameter is an array passed by value."""
        return bool(self.node.dimensions) and not self.node.mode


@dataclass(slots=True)
class _CallPattern:
    """A routine and its copies. ways: the arguments of its calls, and the name of the copy for
    each.

    stays: some call has no matching copy. hidden: its local names, and changed: names that it
    assigns to, in lower case. runs: it has moves in columns, whose settings are names.
    """

    node: s.Routine
    parameters: tuple[_CopiedParameter, ...]
    ways: dict[tuple[str | None, ...], tuple[str, _CallArguments]] = field(default_factory=dict)
    stays: bool = False
    hidden: frozenset[str] = frozenset()
    changed: frozenset[str] = frozenset()
    runs: bool = False

    @staticmethod
    def of(node: s.Routine, parameters: tuple[_CopiedParameter, ...]) -> _CallPattern:
        hidden = frozenset(name.lower() for name in inner_names((node,)))
        runs = any(isinstance(inner, s.MoveRunNode) for inner in nodes(node))
        changed = frozenset(_assigned_names(node))
        return _CallPattern(node, parameters, hidden=hidden, changed=changed, runs=runs)


def _aggregate(*values: s.Expression | float) -> s.AggregateNode:
    """Values in brackets."""
    return s.AggregateNode(
        tuple(s.NumberLiteral(f"{v:g}") if isinstance(v, float | int) else v for v in values)
    )


_ZERO_POSE: Final = _aggregate(_aggregate(0, 0, 0), _aggregate(1, 0, 0, 0))
_TRUE, _FALSE = s.BoolLiteral(True), s.BoolLiteral(False)
_LEAST_LOAD: Final = _aggregate(0.001, _aggregate(0, 0, 0.001), _aggregate(1, 0, 0, 0), 0, 0, 0)
_INITIAL_VALUES: Final = {
    "tooldata": _aggregate(_TRUE, _ZERO_POSE, _LEAST_LOAD),
    "wobjdata": _aggregate(_FALSE, _TRUE, s.StringLiteral(""), _ZERO_POSE, _ZERO_POSE),
}
"""The flange, and the base: what a tool and a work object are before a caller sets them."""


class _UnreadCallers:
    """Arguments of unread callers: one for all parameters with the same type and name.

    data: the declarations for them, by the lower-case name of the first routine with that
    parameter.
    """

    def __init__(self, items: Sequence[s.Item], layouts: RecordLayouts, taken: TakenNames) -> None:
        self._layouts, self._taken = layouts, taken
        self._items = items
        self._given: dict[tuple[str, str], s.NameRef] = {}
        self.data: dict[str, list[s.Data]] = {}

    @cached_property
    def _declared(self) -> frozenset[str]:
        """Names in lower case that mean something else somewhere."""
        found: set[str] = set()
        for node in nodes(tuple(self._items)):
            match node:
                case s.Data() | s.Routine() | s.Record() | s.Alias():
                    found.add(node.name.lower())
                case s.ForLoop(variable=name):
                    found.add(name.lower())
                case s.TargetRunNode(run=run):
                    found.update(run.names.name(row).lower() for row in range(len(run)))
        return frozenset(found)

    def of(self, routine: s.Routine, one: s.ParameterNode, optional: bool) -> s.NameRef | None:
        """Return the argument for a parameter; None if the parameter counts as omitted."""
        type = self._layouts.base(one.type)
        # A device has no neutral value, so that an optional one counts as omitted.
        if optional and type not in _INITIAL_VALUES:
            return None
        key = type, one.name.lower()
        if key not in self._given:
            name = one.name
            # Otherwise the data keeps the parameter's name, by which callers find it.
            if name.lower() in self._declared or any(name.lower() == n for _, n in self._given):
                name = identifier(name, self._taken)
                self._taken.add(name)
            self._given[key] = s.NameRef(name)
            # Signals are named in the cell file, not declared.
            if type not in SIGNAL_TYPES:
                start = _INITIAL_VALUES.get(type)
                storage = "VAR" if start is None else "PERS"
                data = s.Data("", storage, type, name, value=start, span=one.span)
                self.data.setdefault(routine.name.lower(), []).append(data)
        return self._given[key]


_ENTRY: Final = "main"
_MOST_COPIES: Final = 60
"""Maximum copies of one routine; a program with more is unreadable."""
_NAMING: Final = (s.Data, s.Routine, s.Record, s.Alias, s.ParameterNode)


def with_copies(
    modules: Sequence[s.Module], layouts: RecordLayouts, findings: list[tuple[int, Diagnostic]]
) -> Sequence[s.Module]:
    """The modules with such copies; themselves if no routine needs any.

    findings: gets those on routines that nothing calls, each with the place of its module. They
    are left out of a program with a start; a library has data in the place of their callers'.
    """
    return _Copies(modules, layouts, findings).modules()


class _Copies:
    def __init__(
        self,
        modules: Sequence[s.Module],
        layouts: RecordLayouts,
        findings: list[tuple[int, Diagnostic]],
    ) -> None:
        self.all, self.layouts, self.findings = modules, layouts, findings
        items = [item for module in modules for item in module.items]
        found: dict[str, list[s.Routine]] = {}
        for item in items:
            if isinstance(item, s.Routine):
                found.setdefault(item.name.lower(), []).append(item)
        self.calls = call_graph(found)
        self.again = reentrant_routines(self.calls)
        self.routines = {
            name: _CallPattern.of(own[0], parameters)
            for name, own in found.items()
            # Calls are matched by name, so a second routine of the name rules both out.
            if len(own) == 1 and (parameters := self._parameters(own[0]))
        }
        if not self.routines:
            return
        every = list(nodes(tuple(modules)))
        self.taken = TakenNames(one.name for one in every if isinstance(one, _NAMING))
        self.late = [
            one
            for one in every
            if isinstance(one, s.ProcedureCall) and not isinstance(one.name, str)
        ]
        written = (root(one.target) for one in every if isinstance(one, s.Assignment))
        self.written = {one.name.lower() for one in written if one is not None}
        self.starts = _ENTRY in found
        self.callers = _UnreadCallers(items, self.layouts, self.taken)
        self.free: dict[str, list[str]] = {}
        """Arguments of routines without callers, by the routine's lower-case name."""
        self.changes = _ChangedData(found)
        declared = [item for item in items if isinstance(item, s.Data)]
        names = Counter(item.name.lower() for item in declared)
        self.arrays = {
            item.name.lower(): item
            for item in declared
            if item.dimensions and names[item.name.lower()] == 1
        }
        self.added: dict[str, list[s.Data]] = {}
        """By routine in lower case, the arrays that its copies copy others to."""
        for one in every:
            if isinstance(one, s.ProcedureCall | s.FunctionCall) and isinstance(one.name, str):
                self.written |= self.changes.by(one)

    def _parameters(self, routine: s.Routine) -> tuple[_CopiedParameter, ...]:
        """Return the parameters that copies do not have; empty if one of the routine's parameters
        is unknown.
        """
        if routine.kind == "TRAP":
            return ()
        again = routine.name.lower() in self.again
        found: list[_CopiedParameter] = []
        place = 0
        for group in routine.parameters:
            for one in group.alternatives:
                if isinstance(one, s.Placeholder):
                    return ()
                # A routine that may run again while it runs needs each array by value anew.
                if self._is_named(one) or (one.dimensions > 0 and not again):
                    found.append(_CopiedParameter(one, -1 if group.optional else place))
            place += not group.optional
        return tuple(found)

    def _is_named(self, one: s.ParameterNode) -> bool:
        return self.layouts.base(one.type) in SETTING_TYPES or self._is_device(one)

    def _is_device(self, one: s.ParameterNode) -> bool:
        kind = self.layouts.kind(self.layouts.base(one.type))
        return kind == "DEVICE" or (kind == "HANDLE" and bool(one.mode))

    def modules(self) -> Sequence[s.Module]:
        """The modules with the copies behind what they are made of."""
        if not self.routines:
            return self.all
        made: dict[int, s.Item] = {}
        for item in (item for module in self.all for item in module.items):
            if isinstance(item, s.Routine) and item.name.lower() not in self.routines:
                made[id(item)] = self._called(item)
        copies: dict[str, list[s.Routine]] = {name: [] for name in self.routines}
        # Copies call others, whose calls become known only when the copy is made.
        while self._more(copies, made):
            pass
        names = {
            copies[name][0].name.lower(): one.node.name
            for name, one in self.routines.items()
            # With one kind of call the copy takes the place and the name of the routine.
            if len(copies[name]) == 1 and id(one.node) not in made
        }
        whole = []
        for at, module in enumerate(self.all):
            items: list[s.Item] = []
            for item in module.items:
                own = copies.get(item.name.lower(), ()) if isinstance(item, s.Routine) else ()
                kept = made.get(id(item), None if own else item)
                if isinstance(item, s.Routine) and item.name.lower() in self.routines:
                    if self._is_idle(self.routines[item.name.lower()]):
                        self.findings.append((at, rules.UNCALLED(name=item.name, span=item.span)))
                        continue
                    if item.name.lower() in self.free:
                        self.findings.append((at, self._freed(item)))
                items += [] if kept is None else [kept]
                if own and isinstance(item, s.Routine):
                    items += self.added.get(item.name.lower(), ())
                items += own
            items = [with_routine_names(item, names) for item in items] if names else items
            same = len(items) == len(module.items)
            same = same and all(a is b for a, b in zip(items, module.items, strict=True))
            whole.append(module if same else replace(module, items=tuple(items)))
        return whole

    def _more(self, copies: dict[str, list[s.Routine]], made: dict[int, s.Item]) -> bool:
        """Make the outstanding copies, which may call further ones, and finally the routines that
        remain; True if any were made.
        """
        before = sum(map(len, copies.values())) + len(made)
        for name, one in self.routines.items():
            # `ways` is ordered: those behind the number of copies are still to be made.
            for new, given in list(one.ways.values())[len(copies[name]) :]:
                copies[name].append(self._called(self._copy(one, new, given)))
        if sum(map(len, copies.values())) + len(made) == before:
            if self._free(copies, made):
                return True
            # Originals come last: only when no call is left does it show which of them stay.
            for one in self.routines.values():
                if self._is_idle(one):
                    continue
                if (one.stays or self._is_late(one) or not one.ways) and id(one.node) not in made:
                    made[id(one.node)] = self._called(one.node)
        return sum(map(len, copies.values())) + len(made) > before

    def _is_idle(self, one: _CallPattern) -> bool:
        """True if no call passes the devices that a routine requires, so that it is not
        translated.
        """
        devices = any(self._is_free(q) and q.place >= 0 for q in one.parameters)
        return devices and self.starts and not (one.ways or one.stays or self._is_late(one))

    def _is_late(self, one: _CallPattern) -> bool:
        """True if a call by a text may reach a routine; such a call never reaches a function."""
        return one.node.kind == "PROC" and any(accepts_call(one.node, call) for call in self.late)

    def _is_free(self, q: _CopiedParameter) -> bool:
        """True if the parameter is a device, tool or work object, which only callers know."""
        return self._is_device(q.node) or self.layouts.base(q.node.type) in _INITIAL_VALUES

    def _free(self, copies: Mapping[str, Sequence[s.Routine]], made: Mapping[int, s.Item]) -> bool:
        """Give library routines arguments that a calling program sets; True if there were any such
        routines.
        """
        if self.starts:
            return False
        left = {
            name: own
            for name, one in self.routines.items()
            if not (copies[name] or one.stays or id(one.node) in made or self._is_late(one))
            and (own := tuple(filter(self._is_free, one.parameters)))
        }
        # Routines that others here call get their arguments through those, unless all call each
        # other.
        called = {to for name in left for to in self.calls[name] if to != name}
        for name in [name for name in left if name not in called] or list(left)[:1]:
            one = self.routines[name] = _CallPattern.of(self.routines[name].node, left[name])
            given = tuple(self.callers.of(one.node, q.node, q.place < 0) for q in one.parameters)
            new = identifier(one.node.name, self.taken)
            self.taken.add(new)
            way = tuple(None if value is None else argument_key(value) for value in given)
            one.ways[way] = new, given
            pairs = zip(one.parameters, given, strict=True)
            self.free[name] = [
                f"never `\\{q.node.name}`" if value is None else f"`{value.name}`"
                for q, value in pairs
            ]
            self.added.setdefault(name, []).extend(self.callers.data.get(name, ()))
        return bool(left)

    def _freed(self, routine: s.Routine) -> Diagnostic:
        names = ", ".join(self.free[routine.name.lower()])
        return rules.UNREAD_CALLERS(name=routine.name, names=names, span=routine.span)

    # -------------------------------------------------------------------------------- calls

    def _called(self, routine: s.Routine) -> s.Routine:
        """A routine that calls copies."""
        own = {name.lower() for name in inner_names((routine,))}

        def visit(node: Any) -> Any:
            match node:
                case s.ProcedureCall(str(name)) | s.FunctionCall(name):
                    one = self.routines.get(name.lower())
                    return node if one is None else self._call(node, one, own)
            return node

        made: s.Routine = rewrite(routine, visit, ())
        return made

    def _call(
        self, node: s.ProcedureCall | s.FunctionCall, one: _CallPattern, own: set[str]
    ) -> s.ProcedureCall | s.FunctionCall:
        """Return the call of a copy; the call itself if no copy fits it."""
        split = self._split(node, one, own)
        if split is None:
            one.stays = True
            return node
        given, left = split
        way = tuple(None if value is None else argument_key(value) for value in given)
        if way not in one.ways:
            if len(one.ways) >= _MOST_COPIES:
                one.stays = True
                return node
            names = [value.name for value in given if isinstance(value, s.NameRef)]
            name = identifier("_".join([one.node.name, *names]), self.taken)
            self.taken.add(name)
            one.ways[way] = name, given
        name, _ = one.ways[way]
        return replace(node, name=name, arguments=left)

    def _split(
        self, node: s.ProcedureCall | s.FunctionCall, one: _CallPattern, own: set[str]
    ) -> tuple[_CallArguments, tuple[s.Argument, ...]] | None:
        """Return the arguments that a copy does not take, and the remaining ones; None if they are
        unknown.
        """
        plain = [a for a in node.arguments if isinstance(a, s.Positional)]
        required = sum(not group.optional for group in one.node.parameters)
        # Named or missing arguments are not understood, so the call stays.
        if len(plain) != required or any(a.name is not None for a in plain):
            return None
        options: dict[str, s.Expression] = {}
        for argument in node.arguments:
            match argument:
                case s.Option(name, s.Node() as value):
                    options[name.lower()] = value
                case s.Conditional(name):
                    # Only the running program knows if it is there.
                    if any(q.key == name.lower() for q in one.parameters):
                        return None
        given: list[s.Expression | None] = []
        gone: set[int] = set()
        for q in one.parameters:
            one_given = plain[q.place].value if q.place >= 0 else options.get(q.key)
            if one_given is not None and not self._fits(one_given, q, one, own):
                return None
            given.append(one_given)
            if q.place >= 0:
                gone.add(id(plain[q.place]))
        keys = {q.key for q in one.parameters if q.place < 0}
        left = [
            a
            for a in node.arguments
            if id(a) not in gone and not (isinstance(a, s.Option) and a.name.lower() in keys)
        ]
        return tuple(given), tuple(left)

    def _fits(
        self, value: s.Expression, q: _CopiedParameter, one: _CallPattern, own: set[str]
    ) -> bool:
        """True if a copy may have the value in place of the parameter."""
        found = root(value)
        if found is None and q.node.dimensions:
            return False
        if found is None:
            literal = isinstance(value, s.AggregateNode) and not q.node.mode
            fits = literal and is_literal(value) and not one.runs
            return fits and q.key not in one.changed
        low = found.name.lower()
        # A local name of the caller, or one that the routine hides, means something else in the
        # copy.
        if low in own or low in one.hidden - {each.key for each in one.parameters}:
            return False
        if q.node.dimensions:
            array = self.arrays.get(low)
            # Elements and components of arrays have no name of their own.
            return (
                value is found and array is not None and q.node.dimensions == len(array.dimensions)
            )
        # Moves in columns name their settings, so a row of a table cannot stand there.
        if value is not found and (one.runs or not is_table_row(value)):
            return False
        # By value the copy may use the data itself only if nothing changes it meanwhile.
        return bool(q.node.mode) or (low not in self.written and q.key not in one.changed)

    # ------------------------------------------------------------------------------- copies

    def _copy(self, one: _CallPattern, name: str, given: _CallArguments) -> s.Routine:
        """A routine with what it is given in the place of its parameters."""
        values = {q.key: v for q, v in zip(one.parameters, given, strict=True)}
        first: list[s.StatementNode] = []
        for q in one.parameters:
            if (value := values[q.key]) is not None and q.is_copied:
                if self._may_change(one, q, value, given):
                    values[q.key] = held = self._held(one, q, value)
                    first.append(s.Assignment(held, value, span=one.node.span))
        taken = {q.key for q in one.parameters}
        groups = tuple(g for g in one.node.parameters if not _is_any_of(g, taken))
        # Presence first: afterwards the parameter's name stands for its argument.
        known: s.Routine = rewrite(one.node, lambda node: with_presence(node, values), ())
        made: s.Routine = rewrite(known, lambda node: substituted(node, values), ())
        handlers = tuple(replace(h, body=without_dead_branches(h.body)) for h in made.handlers)
        body = with_first_statements(first, without_dead_branches(made.body))
        return replace(made, name=name, parameters=groups, body=body, handlers=handlers)

    def _may_change(
        self, one: _CallPattern, q: _CopiedParameter, value: Any, given: _CallArguments
    ) -> bool:
        """True if an array passed by value may change while the routine runs."""
        low, changed = value.name.lower(), self.changes.of(one.node.name.lower())
        if changed is None or q.key in changed or low in changed:
            return True
        others = zip(one.parameters, given, strict=True)
        return any(
            # Another parameter may be the same array by reference.
            other.node.mode and other.key in changed and _is_name_of(gives, low)
            for other, gives in others
        )

    def _held(self, one: _CallPattern, q: _CopiedParameter, value: Any) -> s.NameRef:
        """An array of the module that another is copied to."""
        array = self.arrays[value.name.lower()]
        name = identifier(f"{one.node.name}_{q.node.name}", self.taken)
        self.taken.add(name)
        data = s.Data("", "VAR", array.type, name, array.dimensions)
        self.added.setdefault(one.node.name.lower(), []).append(data)
        self.arrays[name.lower()] = data
        return s.NameRef(name)


def _is_name_of(value: s.Expression | None, low: str) -> bool:
    found = root(value)
    return found is not None and found.name.lower() == low


def _is_any_of(group: s.ParameterGroup, keys: set[str]) -> bool:
    return any(
        isinstance(a, s.ParameterNode) and a.name.lower() in keys for a in group.alternatives
    )
