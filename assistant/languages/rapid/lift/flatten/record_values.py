"""Expressions with records as expressions with plain data.

`Kinds` gives the type of an expression, `Values` the plain expression or the parts of a record.
Targets and poses are compared by the numbers that other languages have for them. A target, joint
target or pose that is computed in brackets stays one value: `j:=[[0,0,n,0,30,0],outside];` becomes
a value of numbers alone, and `j.robax.rax_3:=n;`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any, Final, Protocol

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.cell_facts import TASK_READS
from assistant.languages.rapid.lift.flatten.data_names import (
    NO_AXIS,
    NO_AXIS_TEXT,
    Datum,
    Names,
    ProgramData,
    arm_maximum,
    is_unused_axis,
    predefined_component,
    predefined_type,
    predefined_value,
)
from assistant.languages.rapid.lift.flatten.library import (
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
from assistant.languages.rapid.lift.flatten.record_layout import (
    SPEED_AND_ZONE,
    ComponentPath,
    NotExpressible,
    Part,
    RecordValue,
    component_value,
    cross_product,
    element,
    grouped,
    in_brackets,
)
from assistant.languages.rapid.tables.predefined import signature
from assistant.languages.rapid.tables.signals import PROCESS_DATA_TYPES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number

Kind = tuple[str, int]
"""A type without aliases, and of how many dimensions."""
_POS: Final = "pos"
_ORIENT: Final = "orient"


class Kinds:
    """Expressions where some names mean something.

    names: of the routine, in front of those of the program.
    """

    def __init__(self, program: ProgramData, names: Names) -> None:
        self.program, self.layouts, self.names = program, program.layouts, names

    def is_own(self, name: str) -> bool:
        return name.lower() in self.program.own

    def find(self, name: str) -> Datum | None:
        low = name.lower()
        return self.names[low] if low in self.names else self.program.data_of(low)

    def kind(self, node: Any) -> Kind | None:
        """Return the type and dimensions of an expression, None if they are unknown."""
        match node:
            case s.NameRef(name):
                found = self.find(name)
                if found is not None:
                    return (found.type, found.dimensions) if found.type else None
                standard = predefined_type(name)
                return (self.layouts.base(standard), 0) if standard else None
            case s.Component(value, name):
                of = self.kind(value)
                inner = None if of is None else self.layouts.component(of[0], name)
                return None if inner is None else (inner, 0)
            # Open indices (`*`) leave dimensions.
            case s.Element(value, indices):
                of = self.kind(value)
                left = sum(isinstance(index, s.Whole) for index in indices)
                return None if of is None else (of[0], left)
            case s.Group(inner):
                return self.kind(inner)
            case s.FunctionCall() if (said := library_call(self, node)) is not node:
                return self.kind(said)
            case s.FunctionCall(str(name)):
                own = self.program.routines.get(name.lower())
                if own is not None:
                    return self.layouts.base(own.type), 0
                # A routine of the program hides the controller's.
                known = None if name.lower() in self.program.own else signature(name)
                return (known.result, 0) if known is not None and known.result else None
            # `*` of orientations is their product, not a scaling.
            case s.Infix("*", left, right) if (_ORIENT, 0) in (self.kind(left), self.kind(right)):
                return _ORIENT, 0
            # A vector times a number, or two vectors, is a vector again (the cross product).
            case s.Infix("+" | "-" | "*" | "/", left, right):
                return (_POS, 0) if (_POS, 0) in (self._side(left), self._side(right)) else None
            case s.Prefix("-" | "+", operand):
                return self.kind(operand)
            case (
                s.BoolLiteral()
                | s.Prefix("NOT")
                | s.Infix("=" | "<>" | "<" | "<=" | ">" | ">=" | "AND" | "OR" | "XOR")
            ):
                return "bool", 0
        return None

    def is_record(self, kind: Kind | None) -> bool:
        """True if the kind is a record that is split."""
        return kind is not None and self.layouts.parts(kind[0]) is not None

    def _side(self, node: Any) -> Kind | None:
        """Return the kind of one side of an operator: values in brackets are a position there."""
        return (_POS, 0) if isinstance(node, s.AggregateNode) else self.kind(node)

    def whole_turn(self, node: Any) -> s.Variable | None:
        """The plain target or pose that a node is the orientation of; None for any other."""
        raise NotImplementedError


_CONJUNCTIONS: Final = {"=": "AND", "<>": "OR"}
"""Operators that join the comparisons of parts."""
_JOINT_TARGET: Final = "jointtarget"
_COMPARED_TYPES: Final = frozenset(("robtarget", "pose", _JOINT_TARGET))
_ANGLES: Final = ("X", "Y", "Z")
_NEAR_FUNCTION: Final = "pose_near"
"""Library function: true if a pose equals numbers within 0.005 mm and 0.05 degrees."""


class _ComparedValues(Protocol):
    """Protocol for values whose parts are compared, see `Values`."""

    program: ProgramData

    def is_record(self, kind: Kind | None) -> bool: ...

    def plain(self, node: Any) -> Any: ...

    def spread(self, node: Any, kind: Kind) -> RecordValue: ...


def _compared_records(
    values: _ComparedValues, operator: str, left: Any, right: Any, kind: Kind
) -> s.Expression:
    """Return the comparison of two records, targets or poses, part by part; as one comparison if
    the parts of one are unknown.
    """
    if values.is_record(kind):
        first, second = values.spread(left, kind), values.spread(right, kind)
        types = {one.path: one.type for one in values.program.layouts.parts(kind[0]) or ()}
        each = [
            _compared_records(values, operator, first[path], second[path], (types[path], 0))
            if types.get(path) in _COMPARED_TYPES
            else s.Infix(operator, first[path], second[path])
            for path in first
        ]
        return s.Group(reduce(lambda one, two: s.Infix(_CONJUNCTIONS[operator], one, two), each))
    type, program = kind[0], values.program
    # Other controllers hold a pose with other digits than the written numbers, so equality is near.
    for place, written in ((left, right), (right, left)):
        match written:
            case s.AggregateNode((s.AggregateNode(where), s.AggregateNode(turn))) if (
                type == "pose" and is_written_out(written) and len(where) == 3 and len(turn) == 4
            ):
                whole = values.plain(place)
                if isinstance(whole, s.NameRef | s.Component | s.Element):
                    program.remarks.append(rules.NEARLY(span=program.at))
                    return _near_pose(values, operator, whole, where, turn)
    sides = [values.plain(left), values.plain(right)]
    named = [one for one in sides if isinstance(one, s.NameRef | s.Component | s.Element)]
    # Parts can be named only of data; with external axes the parts do not say everything.
    if len(named) < len(sides) or (type != "pose" and program.has_axes):
        return s.Infix(operator, *sides)
    if type == "robtarget":
        program.remarks.append(rules.COMPARED(span=program.at))
    one, two = (map(values.plain, _compared_parts(place, type)) for place in named)
    return _compared_pairs(operator, list(zip(one, two, strict=True)))


def _near_pose(
    values: _ComparedValues,
    operator: str,
    place: s.NameRef | s.Component | s.Element,
    where: Sequence[s.Expression],
    turn: Sequence[s.Expression],
) -> s.Expression:
    """A pose that is compared with numbers, which the other controller has with other digits."""
    numbers = (*where, *turn)
    near = values.plain(function_call(_NEAR_FUNCTION, place, *numbers))
    return near if operator == "=" else s.Prefix("NOT", near)


def _compared_pairs(operator: str, pairs: Sequence[tuple[Any, Any]]) -> s.Expression:
    """Return the condition that all parts of two values are equal, or that any differs."""
    each: list[s.Expression] = [s.Infix(operator, one, two) for one, two in pairs]
    return s.Group(reduce(lambda one, two: s.Infix(_CONJUNCTIONS[operator], one, two), each))


def _compared_parts(
    place: s.NameRef | s.Component | s.Element, type: str
) -> Sequence[s.Expression]:
    """Return the compared parts of a target or pose: its position, and the angles of its
    orientation.
    """
    if type == _JOINT_TARGET:
        robax = s.Component(place, "robax")
        return [s.Component(robax, f"rax_{axis}") for axis in range(1, 7)]
    trans, turn = s.Component(place, "trans"), s.Positional(s.Component(place, "rot"))
    where: list[s.Expression] = [s.Component(trans, axis) for axis in "xyz"]
    turned = [s.FunctionCall("EulerZYX", (s.Option(one), turn)) for one in _ANGLES]
    return [*where, *turned]


_TARGET_PARTS: Final = {
    "pose": ("trans", ORIENTATION),
    "robtarget": ("trans", ORIENTATION, "robconf", "extax"),
    "jointtarget": ("robax", "extax"),
}
ASSEMBLED_TYPES: Final = frozenset(_TARGET_PARTS)
"""Types whose values in brackets are lowered part by part for other languages."""
_DEFAULT_PARTS: Final = {"trans": (0, 0, 0), ORIENTATION: (1, 0, 0, 0)}
_CONFIGURATION: Final = "robconf"
NO_EXTERNAL_AXES: Final = s.AggregateNode((s.NumberLiteral("9E9"),) * 6)
"""Positions of external axes that the cell does not have."""
_EXTERNAL_AXES: Final = tuple(f"eax_{letter}" for letter in "abcdef")
_ROBOT_AXES: Final = tuple(f"rax_{axis}" for axis in range(1, 7))


def assembled_parts(
    type: str, place: Any, value: s.AggregateNode
) -> Iterator[tuple[Any, s.Expression]]:
    """Yield the assignments that give a variable its value, as targets and values; the complete
    value first.

    Raises NotExpressible if a part of it has no equivalent.
    """
    items = dict(zip(_TARGET_PARTS[type], value.items, strict=False))
    if len(items) != len(value.items) or len(items) != len(_TARGET_PARTS[type]):
        raise NotExpressible("it has another number of components")
    if type == "jointtarget":
        yield from _joint_parts(place, items)
        return
    outer = [items[name] for name in ("robconf", "extax") if name in items]
    # Configuration and axes cannot be assigned apart: the first assignment has to bring both.
    match outer:
        case [s.Component(one, "robconf"), s.Component(two, "extax")] if one == two:
            yield place, one
        case [s.Component(one, "robconf"), outside] if outside == NO_EXTERNAL_AXES:
            yield place, one
        # The configuration is literal, so the target starts as one that is written out.
        case [conf, s.NameRef() | s.Component() as outside] if is_written_out(conf):
            first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
            yield place, s.AggregateNode((*first, conf, NO_EXTERNAL_AXES))
            yield s.Component(place, "extax"), outside
        case [conf, s.AggregateNode(axes)] if is_written_out(conf) and len(axes) == len(
            _EXTERNAL_AXES
        ):
            first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
            none = s.NumberLiteral("9E9")
            written = tuple(one if is_written_out(one) else none for one in axes)
            yield place, s.AggregateNode((*first, conf, s.AggregateNode(written)))
            for axis, worked_out in zip(_EXTERNAL_AXES, axes, strict=True):
                if not is_written_out(worked_out):
                    yield s.Component(s.Component(place, "extax"), axis), worked_out
        case _ if all(map(is_written_out, outer)):
            first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
            yield place, s.AggregateNode((*first, *outer))
        case _:
            raise NotExpressible("its configuration is worked out")
    for name in ("trans", ORIENTATION):
        yield s.Component(place, name), items[name]


def takes_configuration(target: Any, value: Any) -> bool:
    """True if a target takes the configuration of another target, or a literal one."""
    match target, value:
        case s.Component(_, name), s.Component(_, other):
            return (name.lower(), other.lower()) == (_CONFIGURATION, _CONFIGURATION)
        case s.Component(_, name), s.AggregateNode():
            return name.lower() == _CONFIGURATION and is_written_out(value)
    return False


def with_configuration(
    target: s.Component, value: s.Expression, held: s.NameRef
) -> Iterator[tuple[Any, s.Expression]]:
    """Yield the assignments that do so, as targets and values; external axes are lost.

    held: a variable for a target.
    """
    # The other target brings its configuration along; position and orientation are set back after
    # it.
    if isinstance(value, s.Component):
        yield held, value.value
    else:
        first = (_number_aggregate(_DEFAULT_PARTS[name]) for name in ("trans", ORIENTATION))
        yield held, s.AggregateNode((*first, value, NO_EXTERNAL_AXES))
    for name in ("trans", ORIENTATION):
        yield s.Component(held, name), s.Component(target.value, name)
    yield target.value, held


def _joint_parts(place: Any, items: dict[str, s.Expression]) -> Iterator[tuple[Any, s.Expression]]:
    match items["robax"], items["extax"]:
        case s.Component(one, "robax"), s.Component(two, "extax") if one == two:
            yield place, one
        case s.AggregateNode(angles), outside if is_written_out(outside) and len(angles) == 6:
            none = s.NumberLiteral("0")
            written = tuple(one if is_written_out(one) else none for one in angles)
            yield place, s.AggregateNode((s.AggregateNode(written), outside))
            for axis, angle in zip(_ROBOT_AXES, angles, strict=True):
                if not is_written_out(angle):
                    yield s.Component(s.Component(place, "robax"), axis), angle
        case _:
            raise NotExpressible("its axes are worked out as a whole")


def _number_aggregate(values: tuple[int, ...]) -> s.AggregateNode:
    return s.AggregateNode(tuple(s.NumberLiteral(str(value)) for value in values))


POSITION_FUNCTION: Final = "cpos"
"""The function that gives a position alone."""
_TASK_LIST_TYPE: Final = "tasks"
"""The type of lists of tasks, which stay as they are."""
_TEXT_FUNCTION: Final = "valtostr"
_QUOTE: Final = s.FunctionCall("ByteToStr", (s.Positional(s.NumberLiteral("34")), s.Option("Char")))
"""Quotation mark before and after a text that ValToStr writes."""

CallParts = Callable[[s.FunctionCall], RecordValue]
"""The parts of what a function of the program gives back, which is called before."""

AggregateVariable = Callable[[str, s.AggregateNode], s.Expression]
"""A variable of a type with a target or pose that is put together before."""


CallVariable = Callable[[str, s.FunctionCall], s.Expression]
"""A variable of a type with what a function gives that is called before."""
# Each becomes a statement, so its answer is held in a variable before the statement that uses it.
_ASKING_FUNCTIONS: Final = {
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
    """Expressions with the meaning of their names.

    names: those of the routine, which precede those of the program. called, built, hold: see
    `CallParts`, `AggregateVariable`, `CallVariable`.

    own_task: turns a read of the arm of a computed task into a read for the same task.
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
        """Return the flat form of an expression that is not a record; raises NotExpressible."""
        node = library_call(self, node)
        match node:
            # The pseudo-program has angles where RAPID has a quaternion, so a part of it is
            # computed.
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
                # Records compare part by part.
                if operator in _CONJUNCTIONS:
                    kind = self.kind(left) or self.kind(right)
                    if kind is not None and (self.is_record(kind) or kind[0] in _COMPARED_TYPES):
                        return _compared_records(self, operator, left, right, kind)
                return replace(node, left=self.plain(left), right=self.plain(right))
            case s.FunctionCall("EulerZYX", (s.Option() as axis, s.Positional(turn))) if (
                place := self.whole_turn(turn)
            ):
                own = s.Positional(s.Component(place, ORIENTATION))
                return replace(node, arguments=(axis, own))
            case s.FunctionCall(name, (s.Positional(value),)) if (
                name.lower() == _TEXT_FUNCTION and (shown := self._shown(value))
            ):
                return shown
            case s.FunctionCall(str(name), ()) if not self.is_own(name) and (
                known := arm_maximum(name.lower())
            ):
                found = rules.TAKEN_FOR(what=name, value=known.text, span=self.program.at)
                self.program.remarks.append(found)
                return known
            case s.FunctionCall(name, arguments):
                # Arrays have a fixed extent, so the question has a constant answer.
                size = self._size(node)
                if size is not None:
                    return size
                made = replace(node, arguments=self.arguments(name, arguments))
                if str(name).lower() in TASK_READS and not self.is_own(name):
                    made = self.own_task(made)
                type = _ASKING_FUNCTIONS.get(str(name).lower(), "")
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
                    # Inside a split record: the orientation is a part of its own there.
                    except NotExpressible:
                        return None
        return None

    def _shown(self, value: Any) -> s.Expression | None:
        """Return the text that ValToStr writes; None for values that other languages write in the
        same way, such as numbers.
        """
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
            return s.Group(sum_of_texts([_QUOTE, value, _QUOTE]))
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
        # An instruction without a parameter that it changes takes values, so a record may be put
        # together in brackets.
        reading = known is not None and not any(
            one.mode for slot in known.slots for one in slot.alternatives
        )
        made: list[s.Argument] = []
        types = iter(() if known is None else (one.alternatives[0].type for one in known.required))
        for argument in arguments:
            type = next(types, "") if isinstance(argument, s.Positional) else ""
            match argument:
                # Its name has to stay: the instruction mounts it, or means the list itself.
                case s.Positional(value) | s.Option(_, value) if (
                    type == _TASK_LIST_TYPE or self._mounted(value)
                ):
                    made.append(argument)
                case s.Positional(s.AggregateNode() as value) if type in ASSEMBLED_TYPES and (
                    not is_written_out(value)
                ):
                    made.append(replace(argument, value=self.built(type, value)))
                # Moves may state a speed or zone by its parts.
                case s.Positional(value) if type in SPEED_AND_ZONE:
                    made.append(replace(argument, value=self.given(value, type)))
                case s.Positional(value) | s.Option(_, value) if value is not None:
                    whole = reading or (self.kind(value) or ("", 0))[0] in PROCESS_DATA_TYPES
                    said = self.given(value, None) if whole else self.plain(value)
                    made.append(replace(argument, value=said))
                case _:
                    made.append(argument)
        return tuple(made)

    def _mounted(self, value: Any) -> bool:
        """True if a value is the name of a tool or work object that the program changes."""
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
        """True if a value is a split variable, or computed from one."""
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
        """Return data, or a part of it, that is not a split record; raises NotExpressible."""
        base, index, path = self.steps(node)
        if base is None:
            return node
        datum = self.find(base.name)
        # Predefined data is not in the program: its component is its constant value.
        if datum is None and path and not index:
            return predefined_component(self.layouts, base.name, path) or self._indexed(node)
        if datum is None or not datum.names or (not path and datum.value is not None):
            return self._inside(self._indexed(node))
        # The shortest path with a name wins: the rest are components of that variable.
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
                # One set of indices at most, on the outermost data; arrays inside records have no
                # flat form.
                case s.Element(value, indices) if not index:
                    index = tuple(i if isinstance(i, s.Whole) else self.plain(i) for i in indices)
                    node = value
                case _:
                    return None, (), ()
        return node, index, tuple(reversed(path))

    # ---------------------------------------------------------------------------- spread

    def spread(self, node: Any, kind: Kind) -> RecordValue:
        """The parts of a record, or of an array of records; raises NotExpressible."""
        type, dimensions = kind
        parts = self.layouts.parts(type)
        if parts is None:
            raise NotExpressible("nobody knows its parts")
        node = library_call(self, node)
        if kind == (_ORIENT, 0) and (place := self.whole_turn(node)) is not None:
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
            case s.Infix(operator, left, right) if type == _POS:
                return self._spread_worked_out(operator, left, right)
            case s.Prefix("-" | "+" as operator, operand) if type == _POS:
                inside = self.spread(operand, kind)
                return {path: s.Prefix(operator, s.Group(one)) for path, one in inside.items()}
            case s.Infix("*", left, right) if type == _ORIENT:
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
        """Return a part of a variable; RAPID's unused value for an external axis that the cell does
        not have.
        """
        if not is_unused_axis(node, self.program.unused):
            return node
        self.program.outside.append((self.program.at, node.name.lower()))
        return NO_AXIS

    def _spread_worked_out(self, operator: str, left: Any, right: Any) -> RecordValue:
        """Positions that are added, or multiplied by a number or each other as vectors."""
        kinds = self._side(left), self._side(right)
        both = kinds == ((_POS, 0), (_POS, 0))
        if operator in "+-" and both:
            first, second = (in_brackets(self.spread(side, (_POS, 0))) for side in (left, right))
            return {way: s.Infix(operator, first[way], second[way]) for way in first}
        if operator in "*/" and not both and (_POS, 0) in kinds:
            if kinds[0] == (_POS, 0):
                by = grouped(self.plain(right))
                first = in_brackets(self.spread(left, (_POS, 0)))
                return {way: s.Infix(operator, one, by) for way, one in first.items()}
            # A number divided by a vector is no value.
            if operator == "*":
                by = grouped(self.plain(left))
                second = in_brackets(self.spread(right, (_POS, 0)))
                return {way: s.Infix(operator, by, one) for way, one in second.items()}
        if operator == "*" and both:
            a, b = (in_brackets(self.spread(side, (_POS, 0))) for side in (left, right))
            return cross_product(a, b)
        raise NotExpressible("it works with whole positions")
