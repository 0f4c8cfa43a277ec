"""Expressions of a program with records, as those of one with plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any, Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.plain.assembling import ASSEMBLED_TYPES
from assistant.languages.rapid.lift.plain.comparing import (
    COMPARED_TYPES,
    CONJUNCTIONS,
    compared_records,
)
from assistant.languages.rapid.lift.plain.kinds import ORIENT, POS, Kind, Kinds
from assistant.languages.rapid.lift.plain.layouts import SPEED_AND_ZONE, ComponentPath, Part
from assistant.languages.rapid.lift.plain.library import (
    ORIENTATION,
    QUATERNION,
    QUATERNION_PRODUCT,
    TEXT_WRITERS,
    WHOLE_TYPES,
    function_call,
    is_written_out,
    library_call,
    quaternion_parts,
    sum_of_texts,
)
from assistant.languages.rapid.lift.plain.outside import NO_AXIS, NO_AXIS_TEXT, is_unused_axis
from assistant.languages.rapid.lift.plain.own_task import TASK_READS
from assistant.languages.rapid.lift.plain.scopes import Names, ProgramData, predefined_type
from assistant.languages.rapid.lift.plain.spreads import (
    NotExpressible,
    RecordValue,
    component_value,
    cross_product,
    element,
    grouped,
    in_brackets,
)
from assistant.languages.rapid.lift.plain.standard import (
    arm_maximum,
    predefined_component,
    predefined_value,
)
from assistant.languages.rapid.tables.processes import DATA
from assistant.languages.rapid.tables.signatures import signature
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number

POSITION_FUNCTION: Final = "cpos"
TASK_LIST_TYPE: Final = "tasks"
"""The type of lists of tasks, which stay as they are."""
"""The function that gives a position alone."""
TEXT_FUNCTION: Final = "valtostr"
QUOTE: Final = s.FunctionCall("ByteToStr", (s.Positional(s.NumberLiteral("34")), s.Option("Char")))
"""What stands before and after a text that ValToStr writes."""

CallParts = Callable[[s.FunctionCall], RecordValue]
"""The parts of what a function of the program gives back, which is called before."""

AggregateVariable = Callable[[str, s.AggregateNode], s.Expression]
"""A variable of a type with a target or pose that is put together before."""


CallVariable = Callable[[str, s.FunctionCall], s.Expression]
"""A variable of a type with what a function gives that is called before."""
ASKING_FUNCTIONS: Final = {
    "uinumentry": "num", "uidnumentry": "num", "uimessagebox": "num",
    "readstr": "string", "readnum": "num",
}  # fmt: skip
"""Functions in lower case that wait for somebody or something, with the types of their results.

Other languages have a statement for each."""


def _call_in_place(type: str, value: s.FunctionCall) -> s.Expression:  # noqa: ARG001
    return value


def _no_aggregate_variable(type: str, value: s.AggregateNode) -> s.Expression:  # noqa: ARG001
    raise NotExpressible(f"it puts a {type} together where nothing can be done before")


class Values(Kinds):
    """Expressions where some names mean something.

    names: of the routine, in front of those of the program. called, built, hold: see `Called`,
    `Built`, `Held`. own_task: makes a read of the arm of a task that is worked out one of its own.
    """

    def __init__(
        self,
        program: ProgramData,
        names: Names,
        called: CallParts,
        built: AggregateVariable | None = None,
        hold: CallVariable | None = None,
        own_task: Callable[[s.FunctionCall], s.FunctionCall] = lambda call: call,
    ) -> None:
        super().__init__(program, names)
        self.called, self.own_task = called, own_task
        self.hold = _call_in_place if hold is None else hold
        self.built = _no_aggregate_variable if built is None else built

    # ----------------------------------------------------------------------------- plain

    def plain(self, node: Any) -> Any:
        """An expression that is no record; raises Unsaid."""
        node = library_call(self, node)
        match node:
            case s.Component(turn, name) if name.lower() in QUATERNION and (
                place := self.whole_turn(turn)
            ):
                return self.plain(quaternion_parts(place)[(name.lower(),)])
            case s.NameRef() | s.Component() | s.Element():
                return self._variable(node)
            case s.AggregateNode(items):
                return replace(node, items=tuple(self.given(one, None) for one in items))
            case s.Group(inner):
                return replace(node, inner=self.plain(inner))
            case s.Prefix(_, operand):
                return replace(node, operand=self.plain(operand))
            case s.Infix(operator, left, right):
                if operator in CONJUNCTIONS:
                    kind = self.kind(left) or self.kind(right)
                    if kind is not None and (self.is_record(kind) or kind[0] in COMPARED_TYPES):
                        return compared_records(self, operator, left, right, kind)
                return replace(node, left=self.plain(left), right=self.plain(right))
            case s.FunctionCall("EulerZYX", (s.Option() as axis, s.Positional(turn))) if (
                place := self.whole_turn(turn)
            ):
                own = s.Positional(s.Component(place, ORIENTATION))
                return replace(node, arguments=(axis, own))
            case s.FunctionCall(name, (s.Positional(value),)) if name.lower() == TEXT_FUNCTION and (
                shown := self._shown(value)
            ):
                return shown
            case s.FunctionCall(str(name), ()) if not self.is_own(name) and (
                known := arm_maximum(name.lower())
            ):
                found = rules.TAKEN_FOR(what=name, value=known.text, span=self.program.at)
                self.program.remarks.append(found)
                return known
            case s.FunctionCall(name, arguments):
                size = self._size(node)
                if size is not None:
                    return size
                made = replace(node, arguments=self.arguments(name, arguments))
                if str(name).lower() in TASK_READS and not self.is_own(name):
                    made = self.own_task(made)
                type = ASKING_FUNCTIONS.get(str(name).lower(), "")
                return self.hold(type, made) if type and not self.is_own(name) else made
        return node

    def whole_turn(self, node: Any) -> s.Variable | None:
        """The plain target or pose that a node is the orientation of; None for any other."""
        match node:
            case s.Component(value, name) if name.lower() == ORIENTATION:
                kind = self.kind(value)
                if kind is not None and kind[0] in WHOLE_TYPES and not kind[1]:
                    try:
                        return self._variable(value)  # type: ignore[no-any-return]
                    except NotExpressible:
                        return None
        return None

    def _shown(self, value: Any) -> s.Expression | None:
        """What ValToStr writes, but for what other languages write alike: numbers."""
        kind = self.kind(value)
        if self.is_record(kind):
            assert kind is not None
            return self._text(self.spread(value, kind), kind[0], ())
        type = "string" if self._is_text(value) else kind[0] if kind and not kind[1] else ""
        if type in (*TEXT_WRITERS, "string") or self.layouts.components(type):
            return self._text_of(self.plain(value), type)
        return NO_AXIS_TEXT if self._inside(value) is NO_AXIS else None

    def _is_text(self, value: Any) -> bool:
        match value:
            case s.StringLiteral():
                return True
            case s.Group(inner):
                return self._is_text(inner)
            case s.Infix("+", left, right):
                return self._is_text(left) or self._is_text(right)
        return self.kind(value) == ("string", 0)

    def _text(self, spread: RecordValue, type: str, path: ComponentPath) -> s.Expression:
        if path in spread:
            return self._text_of(spread[path], type)
        parts: list[s.Expression] = []
        for name, of in self.layouts.components(type):
            mark = s.StringLiteral("," if parts else "[")
            parts += (mark, self._text(spread, of, (*path, name.lower())))
        return s.Group(sum_of_texts([*parts, s.StringLiteral("]")]))

    def _text_of(self, value: Any, type: str) -> s.Expression:
        """The text of a plain value, by the type that the place says."""
        base = self.layouts.base(type)
        if value is NO_AXIS:
            return NO_AXIS_TEXT
        if base == "string":
            return s.Group(sum_of_texts([QUOTE, value, QUOTE]))
        if base in TEXT_WRITERS:
            return function_call(TEXT_WRITERS[base], value)
        parts: RecordValue = {
            (name.lower(),): s.Component(value, name) for name, _ in self.layouts.components(base)
        }
        return self._text(parts, base, ()) if parts else function_call("ValToStr", value)

    def _size(self, call: s.FunctionCall) -> s.Expression | None:
        """The extent that `Dim(list,1)` asks for, None of what is no declared array."""
        match call:
            case s.FunctionCall(
                word, (s.Positional(s.NameRef(name), None), s.Positional(place, None))
            ) if word.lower() == "dim" and "dim" not in self.program.own:
                datum, at = self.find(name), literal_number(place)
                sizes = () if datum is None else datum.sizes
                if isinstance(at, int) and 1 <= at <= len(sizes):
                    return sizes[at - 1]
        return None

    def arguments(self, name: Any, arguments: Sequence[s.Argument]) -> tuple[s.Argument, ...]:
        """Those of a call; records in brackets for a routine that every controller has."""
        own = self.program.routines.get(name.lower()) if isinstance(name, str) else None
        if own is not None:
            return tuple(self._handed(own, arguments))
        strange = not isinstance(name, str) or name.lower() in self.program.own
        known = None if strange else signature(name)
        reading = known is not None and not any(
            one.mode for slot in known.slots for one in slot.alternatives
        )
        made: list[s.Argument] = []
        types = iter(() if known is None else (one.alternatives[0].type for one in known.required))
        for argument in arguments:
            type = next(types, "") if isinstance(argument, s.Positional) else ""
            match argument:
                case s.Positional(value) | s.Option(_, value) if (
                    type == TASK_LIST_TYPE or self._mounted(value)
                ):
                    made.append(argument)
                case s.Positional(s.AggregateNode() as value) if type in ASSEMBLED_TYPES and (
                    not is_written_out(value)
                ):
                    made.append(replace(argument, value=self.built(type, value)))
                case s.Positional(value) if type in SPEED_AND_ZONE:
                    made.append(replace(argument, value=self.given(value, type)))
                case s.Positional(value) | s.Option(_, value) if value is not None:
                    whole = reading or (self.kind(value) or ("", 0))[0] in DATA
                    said = self.given(value, None) if whole else self.plain(value)
                    made.append(replace(argument, value=said))
                case _:
                    made.append(argument)
        return tuple(made)

    def _mounted(self, value: Any) -> bool:
        """Whether a value is the name of a tool or work object that the program changes."""
        match value:
            case s.NameRef(name) if name.lower() in self.program.moving:
                return self.find(name) is self.program.data_of(name.lower())
        return False

    def _handed(self, own: s.Routine, arguments: Sequence[s.Argument]) -> Sequence[s.Argument]:
        """Arguments for a routine of the program, a record part by part."""
        required = iter(group for group in own.parameters if not group.optional)
        made: list[s.Argument] = []
        for argument in arguments:
            match argument:
                case s.Positional(value):
                    group = next(required, None)
                    one = None if group is None else group.alternatives[0]
                    if not isinstance(one, s.ParameterNode):
                        raise NotExpressible("nobody knows what it is given to")
                    datum = self.program.datum_of(one)
                    if datum.names:
                        spread = self.spread(value, (datum.type, max(one.dimensions, 0)))
                        made += (s.Positional(spread[path]) for path in datum.names)
                    else:
                        made.append(replace(argument, value=self.given(value, datum.type)))
                case s.Option(_, value) if value is not None:
                    made.append(replace(argument, value=self.plain(value)))
                case _:
                    made.append(argument)
        return made

    def given(self, node: Any, type: str | None) -> Any:
        """A value; a record that is taken apart in brackets. type: of an aggregate, if known."""
        kind = self.kind(node)
        match node:
            case s.AggregateNode() if type in ASSEMBLED_TYPES and not is_written_out(node):
                return self.built(str(type), node)
            case s.AggregateNode(items) if type and (inner := self.layouts.components(type)):
                if len(items) == len(inner):
                    pairs = zip(items, inner, strict=True)
                    said = tuple(self.given(item, of) for item, (_, of) in pairs)
                    return replace(node, items=said)
            case s.NameRef() | s.Component() | s.Element() | s.Group() | s.Infix() if (
                kind is not None and self.is_record(kind) and self.is_apart(node)
            ):
                return self._together(self.spread(node, kind), kind[0], ())
            case s.FunctionCall(str(name)) if kind is not None and kind[0] in SPEED_AND_ZONE:
                if name.lower() in self.program.routines:
                    return self._together(self.spread(node, kind), kind[0], ())
        return self.plain(node)

    def is_apart(self, node: Any) -> bool:
        """Whether a value is one of a variable that is taken apart, or worked out of some."""
        match node:
            case s.Group(inner):
                return self.is_apart(inner)
            case s.Infix(_, left, right):
                return self.is_apart(left) or self.is_apart(right)
            case s.NameRef() | s.Component() | s.Element():
                try:
                    self._variable(node)
                except NotExpressible:
                    return True
        return False

    def _together(self, spread: RecordValue, type: str, path: ComponentPath) -> s.Expression:
        """Parts as one value in brackets."""
        if path in spread:
            return spread[path]
        inner = self.layouts.components(type)
        items = (self._together(spread, of, (*path, name.lower())) for name, of in inner)
        return s.AggregateNode(tuple(items))

    def _variable(self, node: Any) -> Any:
        """Data or a part of it that is no record that is taken apart; raises Unsaid."""
        base, index, path = self.steps(node)
        if base is None:
            return node
        datum = self.find(base.name)
        if datum is None and path and not index:
            return predefined_component(self.layouts, base.name, path) or self._indexed(node)
        if datum is None or not datum.names or (not path and datum.value is not None):
            return self._inside(self._indexed(node))
        for length in range(1, len(path) + 1):
            name = datum.names.get(tuple(one.lower() for one in path[:length]))
            if name is not None:
                made = element(s.NameRef(name), index)
                return self._inside(reduce(s.Component, path[length:], made))
        raise NotExpressible(f"`{base.name}` is a record, which is used as a whole here")

    def _indexed(self, node: Any) -> Any:
        """A variable that stays, with plain indices."""
        match node:
            case s.Component(value):
                return replace(node, value=self._indexed(value))
            case s.Element(value, indices):
                said = tuple(i if isinstance(i, s.Whole) else self.plain(i) for i in indices)
                return replace(node, value=self._indexed(value), indices=said)
        return node

    def steps(
        self, node: Any
    ) -> tuple[s.NameRef | None, tuple[s.Expression | s.Whole, ...], tuple[str, ...]]:
        """The name, plain indices, and components that a variable is; no name of any other."""
        path: list[str] = []
        index: tuple[s.Expression | s.Whole, ...] = ()
        while not isinstance(node, s.NameRef):
            match node:
                case s.Component(value, name) if not index:
                    path.append(name)
                    node = value
                case s.Element(value, indices) if not index:
                    index = tuple(i if isinstance(i, s.Whole) else self.plain(i) for i in indices)
                    node = value
                case _:
                    return None, (), ()
        return node, index, tuple(reversed(path))

    # ---------------------------------------------------------------------------- spread

    def spread(self, node: Any, kind: Kind) -> RecordValue:
        """The parts of a record, or of an array of records; raises Unsaid."""
        type, dimensions = kind
        parts = self.layouts.parts(type)
        if parts is None:
            raise NotExpressible("nobody knows its parts")
        node = library_call(self, node)
        if kind == (ORIENT, 0) and (place := self.whole_turn(node)) is not None:
            return {path: self.plain(one) for path, one in quaternion_parts(place).items()}
        match node:
            case s.Group(inner):
                return self.spread(inner, kind)
            case s.AggregateNode(items) if dimensions:
                rows = [self.spread(item, (type, dimensions - 1)) for item in items]
                return {
                    one.path: s.AggregateNode(tuple(row[one.path] for row in rows)) for one in parts
                }
            case s.AggregateNode(items):
                return self._spread_items(items, type)
            case s.NameRef() | s.Component() | s.Element():
                return self._spread_variable(node, kind)
            case s.Infix(operator, left, right) if type == POS:
                return self._spread_worked_out(operator, left, right)
            case s.Prefix("-" | "+" as operator, operand) if type == POS:
                inside = self.spread(operand, kind)
                return {path: s.Prefix(operator, s.Group(one)) for path, one in inside.items()}
            case s.Infix("*", left, right) if type == ORIENT:
                return self.spread(function_call(QUATERNION_PRODUCT, left, right), kind)
            case s.FunctionCall(str(name)) if name.lower() in (
                *self.program.routines,
                POSITION_FUNCTION,
            ):
                return self.called(node)
        raise NotExpressible("what it gives is a record")

    def _spread_items(self, items: Sequence[Any], type: str) -> RecordValue:
        inner = self.layouts.components(type)
        if len(items) != len(inner):
            raise NotExpressible("it has another number of components")
        found: dict[ComponentPath, s.Expression] = {}
        whole = {one.path for one in self.layouts.parts(type) or ()}
        for item, (name, of) in zip(items, inner, strict=True):
            if (name.lower(),) in whole:
                found[(name.lower(),)] = self.given(item, of)
            else:
                part = self.spread(item, (self.layouts.base(of), 0))
                found |= {(name.lower(), *path): value for path, value in part.items()}
        return found

    def _spread_variable(self, node: Any, kind: Kind) -> RecordValue:
        parts = self.layouts.parts(kind[0]) or ()
        base, index, path = self.steps(node)
        if base is None:
            raise NotExpressible("it has indices of its components")
        datum = self.find(base.name)
        if datum is None:
            known = predefined_value(base.name.lower())
            if known is None or index:
                raise NotExpressible(f"nothing tells the parts of `{base.name}`")
            whole = self.spread(known, (predefined_type(base.name), 0))
            return component_value(whole, path)
        if datum.names:
            key = tuple(one.lower() for one in path)
            found = {}
            for length in range(len(key)):  # inside a part that is one variable
                if key[: length + 1] in datum.names:
                    return self._components(self.plain(node), parts)
            for way, name in datum.names.items():
                if way[: len(key)] == key:
                    found[way[len(key) :]] = element(s.NameRef(name), index)
            if found:
                return found
        if path:
            return self._components(self._indexed(node), parts)
        if datum.value is not None and not index and not datum.dimensions:
            return self.spread(datum.value, kind)
        raise NotExpressible(f"`{base.name}` is used as a whole")

    def _components(self, node: Any, parts: Iterable[Part]) -> RecordValue:
        """The parts of a value that stays one variable."""
        return {one.path: self._inside(reduce(s.Component, one.path, node)) for one in parts}

    def _inside(self, node: Any) -> Any:
        """A part of a variable; what RAPID has for an external axis that there is none of."""
        if not is_unused_axis(node, self.program.unused):
            return node
        self.program.outside.append((self.program.at, node.name.lower()))
        return NO_AXIS

    def _spread_worked_out(self, operator: str, left: Any, right: Any) -> RecordValue:
        """Positions that are added, or multiplied by a number or each other as vectors."""
        kinds = self._side(left), self._side(right)
        both = kinds == ((POS, 0), (POS, 0))
        if operator in "+-" and both:
            first, second = (in_brackets(self.spread(side, (POS, 0))) for side in (left, right))
            return {way: s.Infix(operator, first[way], second[way]) for way in first}
        if operator in "*/" and not both and (POS, 0) in kinds:
            if kinds[0] == (POS, 0):
                by = grouped(self.plain(right))
                first = in_brackets(self.spread(left, (POS, 0)))
                return {way: s.Infix(operator, one, by) for way, one in first.items()}
            if operator == "*":
                by = grouped(self.plain(left))
                second = in_brackets(self.spread(right, (POS, 0)))
                return {way: s.Infix(operator, by, one) for way, one in second.items()}
        if operator == "*" and both:
            a, b = (in_brackets(self.spread(side, (POS, 0))) for side in (left, right))
            return cross_product(a, b)
        raise NotExpressible("it works with whole positions")
