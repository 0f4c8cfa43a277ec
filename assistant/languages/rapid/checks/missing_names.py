"""Names that modules use and none of them declares, with the types that their uses imply.

A name may be data of another task or of a system module that was not read, a signal of the
controller's configuration, or a routine. The list also has controller states that a program reads,
work objects of mechanical units, and external axes, which a cell has to state.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from assistant.languages.rapid.checks.missing_types import (
    KIND_OF_TYPE,
    WEAK_USE,
    GivenArgument,
    NameUses,
    UndeclaredRecords,
    agree_on_types,
    record_of,
    type_of_row,
    wanted_of,
)
from assistant.languages.rapid.checks.rule_context import (
    LOGICAL,
    NUMBER,
    SIGNAL_TYPES,
    RuleContext,
    Scope,
    Task,
    Types,
)
from assistant.languages.rapid.checks.single_rows import with_single_rows
from assistant.languages.rapid.checks.uses import call_of, signature_of
from assistant.languages.rapid.tables import predefined
from assistant.languages.rapid.tables.constants import (
    CELL_OPTIONS,
    CELL_ROUTINES,
    CONTROLLER_STATES,
    LAST_ERROR,
    TASK_COUNT_SUFFIX,
    TASK_MEETINGS,
    TASK_NUMBER,
    TASK_NUMBER_OPTIONS,
    ZONES,
    ControllerState,
    state_of,
)
from assistant.languages.rapid.tables.equivalents import BLENDS, SPEEDS
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.signals import PROCESS_MOVES, UNTRANSLATED_TYPES, hand_of
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import axes_to_ask as asked_axes
from assistant.languages.rapid.tree.literals import (
    carrying_unit,
    has_no_value,
    literal_number,
    still_frame_name,
    units_can_stand,
)
from assistant.languages.rapid.tree.literals import still_axis_name as place_of_axis
from assistant.languages.rapid.tree.walk import ERRNO, routines_of_handlers, worked_out_task
from assistant.languages.signatures import Signature
from assistant.program import expressions as e
from assistant.program.undeclared_names import CallArgument, Wanted


def wanted(files: Sequence[s.File]) -> tuple[Wanted, ...]:
    """Return the names that the modules of one task use and none declares, in the order of first
    use.
    """
    files = with_single_rows(files)
    task, met, alike = Task(files), dict[str, NameUses](), list[tuple[str, str]]()
    stands = units_can_stand([module for file in files for module in file.modules])
    first = next((file for file in files if file.modules), None)
    if first is None:
        return ()
    records = UndeclaredRecords(Types(RuleContext(first, first.modules[0], task)))
    handling = routines_of_handlers([module for file in files for module in file.modules])
    for file in files:
        for module in file.modules:
            look = RuleContext(file, module, task)
            walk = _ModuleWalk(look, met, records, stands, handling)
            walk.walk()
            alike += walk.alike
    agree_on_types(alike, met)
    types = Types(RuleContext(first, first.modules[0], task))
    # Only after all modules are read is it known which components a type has.
    for one in met.values():
        if one.parts.parts and not one.types:
            owner = records.owner(one.name, one.parts)
            one.types[owner.lower()] += 1
            records.found[owner.lower()].join(one.parts)
    asked = tuple(records.wanted())
    data = wanted_of(met, types, records.solved)
    axes = [place_of_axis(axis) for axis in asked_axes([m for file in files for m in file.modules])]
    still = (
        Wanted(name, "data", "bool", nothing=True) for name in axes if not task.shared.all(name)
    )
    return (*asked, *data, *still)


class _ModuleWalk:
    """Collects the undeclared names of one module. stands: the cell may declare mechanical units
    stationary. handling: routines that run while an error is handled. handles: the current
    statement may run while an error is handled.
    """

    def __init__(
        self,
        look: RuleContext,
        met: dict[str, NameUses],
        records: UndeclaredRecords,
        stands: bool,
        handling: frozenset[str],
    ) -> None:
        self.look, self.met, self.records, self.stands = look, met, records, stands
        self.handling, self.handles = handling, False
        self.alike: list[tuple[str, str]] = []
        """Pairs of undeclared names, in lower case, that have one type."""
        self.types = Types(look)
        self.place = ""

    def walk(self) -> None:
        for item in self.look.module.items:
            match item:
                case s.Routine():
                    scope = Scope(self.types, item)
                    self.result = item.type.lower()
                    # ERRNO has a meaning only while an error is handled.
                    self.handles = item.name.lower() in self.handling
                    self._body(item.body, scope)
                    self.handles = True
                    for handler in item.handlers:
                        self._body(handler.body, scope)
                case s.Data():
                    self._data(item, Scope(self.types))

    # ------------------------------------------------------------------------- statements

    def _body(self, body: Sequence[s.StatementNode], scope: Scope) -> None:
        for statement in body:
            self._at(statement)
            self._statement(statement, scope)

    def _at(self, node: s.Node) -> None:
        origin = self.look.file.origin
        if origin is not None and node.span is not None:
            line, _ = origin.source.line_column(node.span.start)
            name = (origin.source.path or "").replace("\\", "/").rsplit("/", 1)[-1]
            self.place = f"{name}:{line}" if name else str(line)

    def _statement(self, node: s.StatementNode, scope: Scope) -> None:
        match node:
            case s.Data():
                self._data(node, scope)
            case s.Assignment(target, value):
                kind = scope.kind(target)
                given = _value_type(scope.kind(value)) or type_of_row(value)
                # Each side of an assignment tells the type of the other.
                self._expression(target, scope, given, assigned=True)
                self._expression(value, scope, _type_of_kind(kind) or "")
                self._pair(target, value)
            case s.ProcedureCall(str(name)):
                self._call(node, name, scope, "PROC")
            case s.ProcedureCall(late, arguments) if not isinstance(late, str):
                self._expression(late, scope, "string")
                for argument in arguments:
                    self._argument(argument, scope)
            case s.MoveRunNode():
                self._moves(node, scope)
            case s.Connect(interrupt, trap):
                self._expression(interrupt, scope, "intnum", assigned=True)
                if scope.find(trap) is None:
                    self._note(trap, "").routine = "TRAP"
            case s.IfThen(branches, otherwise):
                for branch in branches:
                    if branch.condition is not None:
                        self._expression(branch.condition, scope, "bool")
                    self._body(branch.body, scope)
                self._body(otherwise or (), scope)
            case s.CompactIf(condition, statement):
                self._expression(condition, scope, "bool")
                self._statement(statement, scope)
            case s.WhileLoop(condition, body):
                self._expression(condition, scope, "bool")
                self._body(body, scope)
            case s.ForLoop(_, first, last, step, body):
                for bound in (first, last, step):
                    if bound is not None:
                        self._expression(bound, scope, "num")
                self._body(body, scope.inside(node))
            case s.TestOf(subject, cases, otherwise):
                kinds = [scope.kind(value) for case in cases for value in case.values]
                type = next((_type_of_kind(kind) for kind in kinds if kind is not None), "")
                # Weak: a number in CASE may also be the state of a signal.
                switch = all(map(_is_switch, (v for case in cases for v in case.values)))
                self._expression(subject, scope, type or "", weak=True, switch=switch)
                of = _type_of_kind(scope.kind(subject)) or ""
                for case in cases:
                    for value in case.values:
                        self._expression(value, scope, of)
                    self._body(case.body, scope)
                self._body(otherwise or (), scope)
            case s.ReturnFrom(value) if value is not None:
                self._expression(value, scope, self.result)
            case s.RaiseError(value) if value is not None:
                self._expression(value, scope, "errnum")

    def _data(self, node: s.Data, scope: Scope) -> None:
        self._at(node)
        for extent in node.dimensions:
            self._expression(extent, scope, "num")
        if node.value is not None:
            self._expression(node.value, scope, node.type.lower())
            if self.records.is_open(node.type):
                self.records.row(node.type, node.value, len(node.dimensions), self.place)

    def _moves(self, node: s.MoveRunNode, scope: Scope) -> None:
        types = ("speeddata", "zonedata", "tooldata", "wobjdata")
        for motion in node.run.motions.table:
            given = (motion.speed, motion.zone, motion.tool, motion.frame)
            for name, type in zip(given, types, strict=True):
                if name:
                    self._expression(s.NameRef(name), scope, type)
        for names in (node.run.names, node.run.vias):
            for row in range(len(names)):
                if name := names.name(row):  # of a via, only where the move is circular
                    self._expression(s.NameRef(name), scope, "robtarget")

    def _call(
        self,
        node: s.ProcedureCall | s.FunctionCall,
        name: str,
        scope: Scope,
        kind: str,
        result: str = "",
    ) -> None:
        found, low = scope.find(name), name.lower()
        routine: Signature | None = None
        if found is None:
            routine = signature(name)
            options = [one.name for one in node.arguments if isinstance(one, s.Option)]
            if (state := state_of(low, options)) is not None:
                self._state(state)
                if state is CONTROLLER_STATES["gettaskname"] and any(
                    o.lower() in TASK_NUMBER_OPTIONS for o in options
                ):
                    self._state(TASK_NUMBER)
            # Nothing tells what the routine does, so the cell has to declare it.
            elif routine is None or _is_cell_routine(low, routine):
                self._unread(node, name, scope, kind, result, routine)
                return
        elif isinstance(found.node, s.Routine):
            routine = signature_of(found.node)
        if found is None and low in TASK_MEETINGS:
            self._meets(node, scope)
        if found is None and isinstance(node, s.FunctionCall) and worked_out_task(node):
            self._state(CONTROLLER_STATES["gettaskname"])
        bound = (
            {}
            if routine is None
            else {id(value): parameters for value, parameters in call_of(node, routine).bound()}
        )
        for argument in node.arguments:
            if isinstance(argument, s.Conditional) or argument.value is None:
                continue
            parameters = bound.get(id(argument.value), ())
            # A REF parameter takes the mere name of any object, so the use tells no type.
            if any(one.mode == "REF" for one in parameters) and not any(
                one.type in SIGNAL_TYPES for one in parameters
            ):
                continue
            one = parameters[0] if parameters else None
            type = one.type if one is not None else ""
            # Data of the equipment is not translated, so the cell need not state it.
            if low in PROCESS_MOVES and type in UNTRANSLATED_TYPES:
                continue
            changed = one is not None and one.mode in ("VAR", "INOUT") and type not in SIGNAL_TYPES
            self._expression(
                argument.value,
                scope,
                self._base(type),
                assigned=changed,
                weak=type == "num" and not changed,
            )

    def _meets(self, node: s.ProcedureCall | s.FunctionCall, scope: Scope) -> None:
        """Number of tasks that meet, as cell data, where the task list has no values here."""
        match [one.value for one in node.arguments if isinstance(one, s.Positional)]:
            case [_, s.NameRef(name)]:
                found = scope.find(name)
                listed = None if found is None else found.node
                if isinstance(listed, s.Data) and listed.value is None:
                    self._note(f"{name}{TASK_COUNT_SUFFIX}", "num").usual = 1.0

    def _state(self, state: ControllerState) -> None:
        """Record a controller state as data of the cell, unless it is declared by now."""
        if not self.look.task.shared.all(state.name):
            self._note(state.name, state.type).usual = state.usual

    def _base(self, type: str) -> str:
        """Return the type behind an alias: the number type for an alias of a number."""
        if not type:
            return ""
        return type if type in KIND_OF_TYPE else self.types.base(type) or type

    def _unread(
        self,
        node: s.ProcedureCall | s.FunctionCall,
        name: str,
        scope: Scope,
        kind: str,
        result: str,
        routine: Signature | None,
    ) -> None:
        """routine: what is known of it where the controller has it, None where nothing is."""
        met = self._note(name, result)
        met.routine = met.routine or kind
        for value, parameters in () if routine is None else call_of(node, routine).bound():
            whole = value
            while isinstance(whole, s.Element | s.Component):
                whole = whole.value
            handed = any(one.mode in ("VAR", "INOUT", "PERS") for one in parameters)
            if handed and isinstance(whole, s.NameRef):
                met.sets.setdefault(whole.name)
        given: list[GivenArgument] = []
        for argument in node.arguments:
            self._argument(argument, scope)
            match argument:
                case s.Positional(value):
                    given.append(self._given(value, scope))
                case s.Option(option, None):
                    given.append(GivenArgument(CallArgument("switch", option)))
                case s.Option(option, s.Node() as value):
                    given.append(self._given(value, scope, option))
                case s.Conditional(option, variable):
                    given.append(self._given(variable, scope, option))
        met.calls.append(tuple(given))

    def _given(self, value: s.Expression, scope: Scope, option: str = "") -> GivenArgument:
        """An argument with the type that is declared for it, or the name that has to tell it."""
        kind = scope.kind(value)
        if kind is not None:
            return GivenArgument(CallArgument(_type_of_kind(kind) or "", option, kind.dimensions))
        name, element = value, False
        if isinstance(value, s.Element):
            whole = any(isinstance(index, s.Whole) for index in value.indices)
            name, element = (value, False) if whole else (value.value, True)
        if not isinstance(name, s.NameRef):
            return GivenArgument(CallArgument("", option))
        if name.name.lower() in self.met:
            return GivenArgument(CallArgument("", option), name.name.lower(), element)
        found = scope.find(name.name)
        match None if found is None or scope.doubtful(found) else found.node:
            case s.Data(type=type, dimensions=extents):
                return GivenArgument(
                    CallArgument(type.lower(), option, 0 if element else len(extents))
                )
            case s.ParameterNode(type=type, dimensions=dimensions):
                return GivenArgument(
                    CallArgument(type.lower(), option, 0 if element else dimensions)
                )
        return GivenArgument(CallArgument("", option))

    def _argument(self, argument: s.Argument, scope: Scope) -> None:
        if not isinstance(argument, s.Conditional) and argument.value is not None:
            self._expression(argument.value, scope, "")

    # ------------------------------------------------------------------------ expressions

    def _expression(
        self,
        node: s.Expression,
        scope: Scope,
        type: str,
        *,
        assigned: bool = False,
        weak: bool = False,
        switch: bool | None = None,
    ) -> None:
        """type: that is wanted there, empty if that is not known. weak: it may be another one.

        switch: of a comparison, whether on and off are all that it tells apart.
        """
        match node:
            case s.NameRef(name):
                if self._unknown(name, scope, type):
                    met = self._note(name, type, assigned=assigned, weak=weak)
                    met.compared |= switch is not None
                    met.counted |= not switch
                elif name.lower() == ERRNO and not self.handles and scope.find(name) is None:
                    self._state(LAST_ERROR)
                else:
                    self._without_value(name, scope)
            case s.Component() | s.Element():
                self._part(node, scope, type, assigned)
            case s.Group(inner):
                self._expression(inner, scope, type, weak=weak, switch=switch)
            case s.Prefix(operator, operand):
                self._expression(operand, scope, "bool" if operator == "NOT" else type or "num")
            case s.Infix(operator, left, right):
                self._infix(operator, left, right, scope, type)
            case s.FunctionCall(name):
                self._call(node, name, scope, "FUNC", type)
            case s.AggregateNode(items):
                if self.stands and (unit := carrying_unit(node)):
                    place = still_frame_name(unit)
                    if scope.find(place) is None:
                        self._note(place, "wobjdata")
                base = self.types.base(type) if type else None
                parts = list((self.types.components(base) or {}).values()) if base else []
                for at, item in enumerate(items):
                    of = parts[at].lower() if len(parts) == len(items) else type
                    self._expression(item, scope, of)

    def _infix(
        self, operator: str, left: s.Expression, right: s.Expression, scope: Scope, type: str
    ) -> None:
        if operator in LOGICAL:
            for side in (left, right):
                self._expression(side, scope, "bool")
            return
        if operator in e.RELATIONS or operator == "+":
            self._pair(left, right)
        for side, other in ((left, right), (right, left)):
            known = _value_type(scope.kind(other)) or None
            compared = operator in e.RELATIONS
            # A number that is compared may be the state of a signal.
            weak = compared and (known in ("num", "dionum") or known is None)
            fallback = type if not compared else ""
            switch = operator in ("=", "<>") and _is_switch(other) if compared else None
            self._expression(side, scope, known or fallback or "", weak=weak, switch=switch)

    def _pair(self, one: s.Expression, other: s.Expression) -> None:
        """Two values of one type, each perhaps the mere name of undeclared data."""
        match one, other:
            case s.NameRef(first), s.NameRef(second):
                self.alike.append((first.lower(), second.lower()))
            case _, s.Infix("+", left, right):
                self._pair(one, left)
                self._pair(one, right)

    def _part(self, node: s.Component | s.Element, scope: Scope, type: str, assigned: bool) -> None:
        """A component or element: what it is a part of, and its indices."""
        outer: list[s.Component | s.Element] = []
        value: Any = node
        while isinstance(value, s.Component | s.Element):
            outer.append(value)
            if isinstance(value, s.Element):
                for index in value.indices:
                    if not isinstance(index, s.Whole):
                        self._expression(index, scope, "num")
            value = value.value
        if not isinstance(value, s.NameRef):
            return
        outer.reverse()
        named = [one.name for one in outer if isinstance(one, s.Component)]
        if not self._unknown(value.name, scope, ""):
            self._without_value(value.name, scope)
            found = scope.find(value.name)
            if named and found is not None and self.records.is_open(found.type):
                self.records.note(found.type, named, type, self.place)
            return
        parts = [name.lower() for name in named]
        of = record_of(parts) if parts else type
        met = self._note(value.name, of, assigned=assigned)
        if named and not of:
            met.parts.note(named, type, self.place)
        # The largest index that is used is the least extent.
        if isinstance(outer[0], s.Element):
            numbers = [
                literal_number(i) if not isinstance(i, s.Whole) else None for i in outer[0].indices
            ]
            sizes = [int(n) if isinstance(n, int) and n > 0 else 1 for n in numbers]
            old = [*met.extents, *[1] * (len(sizes) - len(met.extents))]
            met.extents = [max(a, b) for a, b in zip(old, sizes, strict=False)]

    def _without_value(self, name: str, scope: Scope) -> None:
        """A tool, work object or target that another task gives its value."""
        found = scope.find(name)
        if found is not None and isinstance(found.node, s.Data) and has_no_value(found.node):
            self._note(found.node.name, found.node.type.lower())

    def _unknown(self, name: str, scope: Scope, type: str) -> bool:
        low = name.lower()
        if scope.find(name) is not None or hand_of(low) is not None:
            return False
        if low in predefined.data() or low in predefined.types():
            return False
        # A name that only looks like a predefined one is a slip, which a rule reports.
        if type == "speeddata":
            return low not in SPEEDS.predefined
        return not (type == "zonedata" and (low in ZONES or low in BLENDS.predefined))

    def _note(
        self, name: str, type: str, *, assigned: bool = False, weak: bool = False
    ) -> NameUses:
        met = self.met.setdefault(name.lower(), NameUses(name))
        if type:
            met.types[type] += WEAK_USE if weak else 1  # type: ignore[assignment]
        met.assigned |= assigned
        if self.place:
            met.uses.setdefault(self.place)
        return met


def _is_cell_routine(low: str, routine: Signature) -> bool:
    """True if the cell defines the effect of a controller routine. low: its name in lower case."""
    if low in PROCESS_MOVES:
        return False
    return routine.option in CELL_OPTIONS or low in CELL_ROUTINES


def _is_switch(node: s.Expression) -> bool:
    """True for a value that a digital signal has: 0, 1, `low`, `high`."""
    match node:
        case s.Group(inner):
            return _is_switch(inner)
        case s.NameRef(name):
            return name.lower() in ("low", "high")
    return literal_number(node) in (0, 1)


def _value_type(kind: Any) -> str:
    """The type of a value, empty for an unknown one: a signal that is read gives a number."""
    type = _type_of_kind(kind) or ""
    return "num" if type in SIGNAL_TYPES else type


def _type_of_kind(kind: Any) -> str | None:
    if kind is None:
        return None
    return "num" if kind.type == NUMBER else str(kind.type)
