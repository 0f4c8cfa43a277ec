"""Statements and declarations with records as those with plain data.

An array that is assigned values in brackets gets one assignment for each element, up to 120. Four
assignments to the parts of a quaternion become one of the quaternion. Moves in columns become
single moves where their speeds or zones are computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.flatten.cell_facts import OWN_TASK, without_task
from assistant.languages.rapid.lift.flatten.data_names import (
    NO_AXIS,
    Datum,
    ProgramData,
    parameter_nodes,
    predefined_value,
)
from assistant.languages.rapid.lift.flatten.library import (
    ORIENTATION,
    QUATERNION,
    function_call,
    is_written_out,
    library_call,
    quaternion_angles,
)
from assistant.languages.rapid.lift.flatten.record_layout import (
    SETTING_TYPES,
    SPEED_AND_ZONE,
    TOOL,
    ComponentPath,
    NotExpressible,
    RecordValue,
)
from assistant.languages.rapid.lift.flatten.record_values import (
    ASSEMBLED_TYPES,
    NO_EXTERNAL_AXES,
    POSITION_FUNCTION,
    Kind,
    Values,
    assembled_parts,
    takes_configuration,
    with_configuration,
)
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.languages.rapid.tree.syntax import CIRCULAR, PLAIN_MOVES, TARGET_PARTS, MoveRun
from assistant.languages.rapid.tree.walk import lists, nodes, root, worked_out_task


def flat_declarations(node: s.Data, datum: Datum, values: Values) -> Iterator[s.Data]:
    """Yield the declarations that replace some data; raises NotExpressible for a value without an
    equivalent.
    """
    program = values.program
    if not datum.names:
        value = None if node.value is None else values.given(node.value, datum.type)
        yield replace(node, type=program.plain_type(node.type), value=value)
        return
    spread: RecordValue = {}
    if node.value is None and node.name.lower() in program.moving:  # set before anything uses it
        node = replace(node, value=predefined_value("tool0" if datum.type == TOOL else "wobj0"))
    if node.value is not None:
        spread = values.spread(node.value, (datum.type, datum.dimensions))
    if program.stays(node):
        yield node
    for part in program.layouts.parts(datum.type) or ():
        name, value = datum.names[part.path], spread.get(part.path)
        yield replace(node, type=part.type, name=name, value=value)


_ArrayCell = tuple[tuple[int, ...], s.Expression]
"""The indices and the value of an element."""
_MOST_ELEMENTS: Final = 120
"""Maximum elements of an array whose assignment in brackets is split; a larger one stays one
statement.
"""


def _differs_in_size(value: s.AggregateNode, sizes: Sequence[s.Expression]) -> bool:
    """True if brackets hold more or fewer values than the array has elements."""
    if not sizes:
        return False
    first, *others = sizes
    extent = literal_number(first)
    if extent is not None and extent != len(value.items):
        return True
    inner = (one for one in value.items if isinstance(one, s.AggregateNode))
    return any(_differs_in_size(one, others) for one in inner)


def _element_assignments(
    node: s.Assignment, kind: Kind | None, variable: Callable[[str, str], s.NameRef]
) -> Iterator[s.Assignment]:
    """Yield an assignment, split into one for each element if it assigns values in brackets to an
    array.

    kind: of the target. variable: returns a new variable of a type; values pass through variables
    if one of them reads an element of the same array.
    """
    match node:
        case s.Assignment(s.NameRef(name), s.AggregateNode() as value) if kind and kind[1]:
            rows = list(_array_cells(value, kind[1]))
            if len(rows) <= _MOST_ELEMENTS:
                if name.lower() in names_in(value):
                    # An element may be overwritten before a later value reads it, so all values are
                    # computed first.
                    held = [(index, variable("new", kind[0])) for index, _ in rows]
                    for (_, place), (_, cell) in zip(held, rows, strict=True):
                        yield replace(node, target=place, value=cell)
                    rows = [*held]
                for index, cell in rows:
                    numbers = tuple(s.NumberLiteral(str(at)) for at in index)
                    yield replace(node, target=s.Element(s.NameRef(name), numbers), value=cell)
                return
    yield node


def _array_cells(value: s.AggregateNode, depth: int) -> Iterator[_ArrayCell]:
    """The values of an array in brackets, each with its indices."""
    for at, item in enumerate(value.items, 1):
        if depth == 1 or not isinstance(item, s.AggregateNode):
            yield (at,), item
        else:
            yield from (((at, *index), cell) for index, cell in _array_cells(item, depth - 1))


def names_in(value: Any) -> set[str]:
    """Every name in an expression, in lower case."""
    return {node.name.lower() for node in nodes(value) if isinstance(node, s.NameRef)}


def _assigned_names(place: Any) -> set[str]:
    """The data that an assignment changes, in lower case."""
    while not isinstance(place, s.NameRef):
        place = place.value
    return {place.name.lower()}


def _index_names(place: Any) -> set[str]:
    """Names in the indices of what is assigned, in lower case."""
    found: set[str] = set()
    while not isinstance(place, s.NameRef):
        if isinstance(place, s.Element):
            found |= names_in(place.indices)
        place = place.value
    return found


def _with_joined_quaternions(
    values: Values, body: Sequence[s.StatementNode]
) -> Iterator[s.StatementNode]:
    """The statements; the four parts of a quaternion that are set one by one as a whole."""
    at = 0
    while at < len(body):
        group = body[at : at + len(QUATERNION)]
        whole = _quaternion_assignment(values, group)
        yield body[at] if whole is None else whole
        at += 1 if whole is None else len(group)


def _quaternion_assignment(
    values: Values, group: Sequence[s.StatementNode]
) -> s.StatementNode | None:
    parts: dict[str, s.Expression] = {}
    turns: list[s.Expression] = []
    for node in group:
        match node:
            case s.Assignment(s.Component(s.Component(_, turn) as whole, name), value) if (
                turn.lower() == ORIENTATION
            ):
                parts[name.lower()] = value
                turns.append(whole)
    if sorted(parts) != list(QUATERNION) or any(one != turns[0] for one in turns):
        return None
    if values.whole_turn(turns[0]) is None:
        return None
    # A part that reads the quaternion would see the old one, where single assignments see the new.
    if any(names_in(turns[0]) & names_in(value) for value in parts.values()):
        return None
    aggregate = s.AggregateNode(tuple(parts[name] for name in QUATERNION))
    return s.Assignment(turns[0], aggregate, span=group[0].span)  # type: ignore[arg-type]


def changes_speeds_or_zones(files: Sequence[s.File]) -> bool:
    """True if a program assigns to a speed or zone that is one value."""
    written = {
        target.name.lower()
        for file in files
        for node in nodes(file.modules)
        if isinstance(node, s.Assignment) and (target := root(node.target)) is not None
    }
    return any(
        isinstance(node, s.Data)
        and node.type.lower() in SPEED_AND_ZONE
        and node.name.lower() in written
        for file in files
        for node in nodes(file.modules)
    )


def _has_parted_settings(run: MoveRun, find: Callable[[str], Datum | None]) -> bool:
    """True if moves in columns name a speed or zone that is split. find: returns data by name."""
    named = {name for how in run.motions.table for name in (how.speed, how.zone)}
    return any(found is not None and found.names for found in map(find, named))


def _single_moves(run: MoveRun) -> Iterator[s.ProcedureCall]:
    """The moves of a run."""
    for row in range(len(run)):
        kind, how = int(run.kinds[row]), run.motions[row]
        named = [run.vias.name(row)] if kind == CIRCULAR else []
        named += [] if run.values is not None else [run.names.name(row)]
        given: list[s.Expression] = [s.NameRef(name) for name in named]
        if run.values is not None:
            given.append(_target_literal(run.values[row].tolist()))
        given += [s.NameRef(name) for name in (how.speed, how.zone, how.tool)]
        arguments: list[s.Argument] = [s.Positional(one) for one in given]
        if how.frame:
            arguments.append(s.Option("WObj", s.NameRef(how.frame)))
        yield s.ProcedureCall(PLAIN_MOVES[kind], tuple(arguments))


def _target_literal(values: Sequence[float]) -> s.AggregateNode:
    parts = (values[start:stop] for start, stop in TARGET_PARTS)
    return s.AggregateNode(
        tuple(s.AggregateNode(tuple(map(_number_literal, part))) for part in parts)
    )


def _number_literal(value: float) -> s.Expression:
    written = s.NumberLiteral(repr(abs(value)))
    return s.Prefix("-", written) if value < 0 else written


Nodes = tuple[s.StatementNode, ...]


class RoutineBody:
    """The statements of one routine.

    kept: statements that stay as they are written, by `id`, with why; they are in what is made.
    """

    def __init__(self, program: ProgramData, routine: s.Routine, kept: dict[int, str]) -> None:
        self.program, self.routine, self.kept = program, routine, kept
        self.names: dict[str, Datum] = {
            one.name.lower(): program.datum_of(one) for one in parameter_nodes(routine)
        }
        # a declaration in a block is an error (RA220), and a name like any other
        data = [node for body in lists(routine) for node in body if isinstance(node, s.Data)]
        self.names |= {node.name.lower(): program.datum(node) for node in data}
        self.values = Values(
            program, self.names, self._called, self._built, self._asked_before, self._of_own_task
        )
        self.before: list[s.StatementNode] | None = None
        self.alone: s.Expression | None = None
        """A value that is used at once, before anything else is called."""
        self.direct: s.Expression | None = None
        """A value that is assigned as it is."""
        self.added: list[s.Data] = []

    def whole(self) -> s.Routine:
        """The routine with plain data."""
        routine = self.routine
        body = self.block(routine.body)
        handlers = tuple(replace(h, body=self.block(h.body)) for h in routine.handlers)
        body = (*self.added, *body)
        groups = tuple(one for group in routine.parameters for one in self._groups(group))
        return replace(routine, parameters=groups, body=body, handlers=handlers)

    def _groups(self, group: s.ParameterGroup) -> Iterator[s.ParameterGroup]:
        match group.alternatives:
            case (s.ParameterNode() as one,) if not group.optional:
                datum = self.program.datum_of(one)
                types = {
                    part.path: part.type for part in self.program.layouts.parts(datum.type) or ()
                }
                if not datum.names:
                    whole = self.program.plain_type(one.type)
                    yield replace(group, alternatives=(replace(one, type=whole),))
                for path, name in datum.names.items():
                    yield replace(group, alternatives=(replace(one, name=name, type=types[path]),))
            case _:
                yield group

    def block(self, body: Sequence[s.StatementNode]) -> Nodes:
        return tuple(
            said
            for node in _with_joined_quaternions(self.values, body)
            for said in self._statement(node)
        )

    def _statement(self, node: s.StatementNode) -> list[s.StatementNode]:
        # Statements may be inside others: each collects what has to run before it apart.
        before, self.before = self.before, []
        around, self.program.at = self.program.at, node.span
        try:
            made = list(self._said(node))
            return [_at_span(one, node) for one in self.before] + made
        # Kept as a vendor statement; its reason becomes the finding.
        except NotExpressible as unsaid:
            self.kept[id(node)] = unsaid.why
            return [node]
        finally:
            self.before, self.program.at = before, around

    def _said(self, node: s.StatementNode) -> Iterator[s.StatementNode]:
        plain = self.values.plain
        match node:
            case s.Data():
                yield from flat_declarations(node, self.names[node.name.lower()], self.values)
            case s.Assignment(target, value):
                yield from self._assigned(node, target, value)
            # The library's form is flattened once more, as its arguments may be records.
            case s.ProcedureCall(str()) if (own := library_call(self.values, node)) is not node:
                yield from self._said(own)
            case s.ProcedureCall(str(name)) if raised := _raise_statements(
                node, self.values.is_own(name)
            ):
                for one in raised:
                    yield from self._said(one)
            case s.ProcedureCall(name, arguments):
                said = name if isinstance(name, str) else plain(name)
                yield replace(node, name=said, arguments=self.values.arguments(name, arguments))
            case s.MoveRunNode(run) if _has_parted_settings(run, self.values.find):
                for move in _single_moves(run):
                    yield from self._said(move)
            case s.ReturnFrom(value) if value is not None:
                yield from self._returned(node, value)
            case s.RaiseError(value) if value is not None:
                yield replace(node, value=plain(value))
            case s.IfThen(branches, otherwise):
                made = []
                for at, branch in enumerate(branches):
                    condition = branch.condition
                    if condition is not None:
                        condition = self._asked(condition, again=at > 0)
                    made.append(replace(branch, condition=condition, body=self.block(branch.body)))
                other = None if otherwise is None else self.block(otherwise)
                yield replace(node, branches=tuple(made), otherwise=other)
            case s.CompactIf(condition, inner):
                said = self.block((inner,))
                if len(said) == 1:
                    yield replace(node, condition=self._asked(condition), statement=said[0])
                else:
                    branch = s.IfBranch(self._asked(condition), said)
                    yield s.IfThen((branch,), span=node.span)
            case s.ForLoop(variable, first, last, step, body):
                low, high = self._asked(first), self._asked(last)
                by = None if step is None else self._asked(step)
                # The loop variable hides data of its name inside the loop only.
                key = variable.lower()
                hidden = self.names.get(key)
                self.names[key] = Datum(variable, "num")
                said = self.block(body)
                del self.names[key]
                if hidden is not None:
                    self.names[key] = hidden
                yield replace(node, first=low, last=high, step=by, body=said)
            case s.WhileLoop(condition, body):
                yield replace(
                    node, condition=self._asked(condition, again=True), body=self.block(body)
                )
            case s.TestOf(subject, cases, otherwise):
                chosen = tuple(
                    replace(
                        case,
                        # Values of a CASE are compared one after the other, with no statement
                        # between them.
                        values=tuple(self._asked(one, again=True) for one in case.values),
                        body=self.block(case.body),
                    )
                    for case in cases
                )
                other = None if otherwise is None else self.block(otherwise)
                yield replace(node, subject=self._asked(subject), cases=chosen, otherwise=other)
            case _:
                yield node

    def _asked(self, condition: s.Expression, again: bool = False) -> Any:
        """Return the flat form of a block's condition or value, unchanged if it has no equivalent.

        again: the block evaluates it where no statement can run first.
        """
        held = self.before
        # Statements before the block cannot prepare a value that is evaluated repeatedly.
        self.before = None if again else held
        try:
            return self.values.plain(condition)
        # The condition stays; the blocks in it are flattened all the same.
        except NotExpressible:
            return condition
        finally:
            self.before = held

    def _assigned(
        self, node: s.Assignment, target: Any, value: s.Expression
    ) -> Iterator[s.StatementNode]:
        kind = self.values.kind(target)
        if (place := self.values.whole_turn(target)) is not None:
            yield self._turned(node, s.Component(place, ORIENTATION), value)
            return
        if kind is not None and kind[0] in ASSEMBLED_TYPES and isinstance(value, s.AggregateNode):
            if not is_written_out(value):
                yield from self._put_together(node, target, kind[0], value)
                return
        # RAPID stops the program at this assignment.
        if self._never_fits(node):
            yield s.Word("EXIT", span=node.span)
            return
        value = library_call(self.values, value)
        if kind is None or not self.values.is_record(kind) or self._is_setting(target, kind):
            type = None if kind is None else kind[0]
            variable = self.values.plain(target)
            self.direct = value
            said = self.values.given(value, type)
            # The assigned component is not there, but computing its value may call a routine.
            if variable is NO_AXIS:
                yield from self._still_called(said, node)
                return
            yield from _element_assignments(
                replace(node, target=variable, value=said), kind, self._variable
            )
            return
        if (made := self._configured(target, value)) is not None:
            for part, given in made:
                yield from self._assigned(replace(node, target=part), part, given)
            return
        # Whole components of data that is not split can be assigned as they are.
        if kind[0] != "extjoint" and self._both_stay(target) and self._both_stay(value):
            yield node
            return
        places = self.values.spread(target, kind)
        # The value is read only by the assignments that follow at once, so that a result needs no
        # copy.
        self.alone = value
        yield from self._copied(node, places, self.values.spread(value, kind), kind)

    def _configured(self, target: Any, value: Any) -> list[tuple[Any, s.Expression]] | None:
        """Return the assignments that give a target a configuration, None for any other
        assignment.
        """
        if self.program.has_axes or not takes_configuration(target, value):
            return None
        return list(with_configuration(target, value, self._variable("configured", "robtarget")))

    def _never_fits(self, node: s.Assignment) -> bool:
        """Report an array that is assigned too many or too few values in brackets; True if so."""
        match node:
            case s.Assignment(s.NameRef(name), s.AggregateNode() as value):
                datum = self.values.find(name)
                if datum is not None and _differs_in_size(value, datum.sizes):
                    found = rules.WRONG_SIZE(array=name, span=node.span)
                    self.program.remarks.append(found)
                    return True
        return False

    def _is_setting(self, target: Any, kind: Kind) -> bool:
        """True if the target is a tool, frame, speed or zone held in one variable."""
        return kind[0] in SETTING_TYPES and not self.values.is_apart(target)

    def _turned(self, node: s.Assignment, turn: s.Component, value: Any) -> s.StatementNode:
        """An orientation given to a target or pose that has angles."""
        match value:
            case s.FunctionCall(str(name), arguments) if (
                name.lower() == "orientzyx" and not self.values.is_own(name)
            ):
                given = self.values.arguments("OrientZYX", arguments)
                return replace(node, target=turn, value=replace(value, arguments=given))
        if (other := self.values.whole_turn(value)) is not None:
            return replace(node, target=turn, value=s.Component(other, ORIENTATION))
        spread = self.values.spread(value, ("orient", 0))
        held = {path: self._held(one) for path, one in spread.items()}
        angles = [self.values.plain(one) for one in quaternion_angles(held)]
        return replace(node, target=turn, value=function_call("OrientZYX", *angles))

    def _held(self, value: s.Expression) -> s.Expression:
        """Return a number that is used several times, unchanged or as a new variable."""
        if isinstance(value, s.NameRef | s.NumberLiteral) or is_written_out(value):
            return value
        if self.before is None:
            raise NotExpressible("it is worked out where nothing can be called before")
        variable = self._variable("turn", "num")
        self.before.append(s.Assignment(variable, value))
        return variable

    def _put_together(
        self, node: s.Assignment, target: Any, type: str, value: s.AggregateNode
    ) -> Iterator[s.StatementNode]:
        """A target or pose that is worked out, part by part."""
        place: s.NameRef | s.Component | s.Element = self.values.plain(target)
        if isinstance(place, s.NameRef) and self.values.find(place.name) is None:
            self.names[place.name.lower()] = Datum(place.name, type)  # a part with a name now
        value = self._without_axes(type, value)
        own = names_in(place)
        # Parts that are assigned first must not change what the later ones read.
        if own & names_in(value):
            place = self._variable("new", type)
        for part, given in assembled_parts(type, place, value):
            if part is place and is_written_out(given):
                yield replace(node, target=place, value=given)
            else:
                yield from self._assigned(replace(node, target=part), part, given)
        if own & names_in(value):
            yield replace(node, target=self.values.plain(target), value=place)

    def _without_axes(self, type: str, value: s.AggregateNode) -> s.AggregateNode:
        """Return a target in brackets without the positions of external axes that the cell does not
        have.
        """
        *rest, extax = value.items
        named = isinstance(extax, s.NameRef | s.Component)
        if type == "pose" or self.program.has_axes or not named:
            return value
        self.program.outside.append((self.program.at, "extax"))
        return replace(value, items=(*rest, NO_EXTERNAL_AXES))

    def _both_stay(self, node: Any) -> bool:
        """True if a variable is a component of data that is not split."""
        base, _, path = self.values.steps(node)
        datum = None if base is None else self.values.find(base.name)
        return datum is not None and not datum.names and path != ("trans",)

    def _copied(
        self, node: s.StatementNode, places: RecordValue, parts: RecordValue, kind: Kind
    ) -> Iterator[s.StatementNode]:
        """Yield an assignment for each part, through variables if one part reads another that was
        assigned.
        """
        changed: set[str] = set()
        if not places.keys() <= parts.keys():
            raise NotExpressible("what it is given is of another type")
        for path, place in places.items():
            if place is NO_AXIS:
                yield from self._still_called(parts[path], node)
        later = [path for path, place in places.items() if place is not NO_AXIS]
        asked = {path: names_in(parts[path]) for path in later}
        clashes = False
        for path in later:
            clashes |= not changed.isdisjoint(asked[path] | _index_names(places[path]))
            changed |= _assigned_names(places[path])
        # Held copies are single variables, which no array fits into.
        if clashes and kind[1]:
            raise NotExpressible("it reads parts of what it assigns")
        if not clashes:
            for path in later:
                one: Any = s.Assignment(places[path], parts[path], span=node.span)  # type: ignore[arg-type]
                yield from _element_assignments(one, kind, self._variable)
            return
        types = {one.path: one.type for one in self.program.layouts.parts(kind[0]) or ()}
        held = {path: self._variable("_".join(("new", *path)), types[path]) for path in later}
        for path in later:
            yield s.Assignment(held[path], parts[path], span=node.span)
        for path in later:
            yield s.Assignment(places[path], held[path], span=node.span)  # type: ignore[arg-type]

    def _still_called(self, value: Any, node: s.StatementNode) -> Iterator[s.StatementNode]:
        """Yield what remains of a number that nothing takes: the call of a routine that may have
        effects.
        """
        own = {n.name.lower() for n in nodes(value) if isinstance(n, s.FunctionCall)}
        # A routine that only computes has no effect and can be left out.
        if not all(map(self.program.only_works_out, own & self.program.own)):
            yield s.Assignment(self._variable("unused", "num"), value, span=node.span)

    def _variable(self, wanted: str, type: str) -> s.NameRef:
        name = self.program.name(wanted)
        self.added.append(s.Data("", "VAR", type, name))
        self.names[name.lower()] = Datum(name, type)
        return s.NameRef(name)

    def _returned(self, node: s.ReturnFrom, value: s.Expression) -> Iterator[s.StatementNode]:
        result = self.program.result(self.routine)
        if not result:
            yield replace(node, value=self.values.given(value, self.routine.type))
            return
        kind = self.program.layouts.base(self.routine.type), 0
        places: Mapping[ComponentPath, s.Expression] = {
            p: s.NameRef(name) for p, name in result.items()
        }
        self.alone = value
        yield from self._copied(node, places, self.values.spread(value, kind), kind)
        yield replace(node, value=None)

    def _called(self, call: s.FunctionCall) -> RecordValue:
        """Calls a function that gives back a record before the statement at hand."""
        if call.name.lower() == POSITION_FUNCTION:
            return self._place(call)
        routine = self.program.routines[call.name.lower()]
        result = self.program.result(routine)
        if self.before is None or not result:
            raise NotExpressible(
                f"`{call.name}` gives back a record where it cannot be called before"
            )
        arguments = self.values.arguments(call.name, call.arguments)
        self.before.append(s.ProcedureCall(call.name, arguments))
        types = {one.path: one.type for one in self.program.layouts.parts(routine.type) or ()}
        made: dict[ComponentPath, s.Expression] = {}
        # A second call of the function would overwrite its results, but here they are read before
        # it.
        if self.alone is call:
            return {path: s.NameRef(name) for path, name in result.items()}
        for path, name in result.items():
            held = self._variable(name, types[path])
            self.before.append(s.Assignment(held, s.NameRef(name)))
            made[path] = held
        return made

    def _built(self, type: str, value: s.AggregateNode) -> s.Expression:
        """A target or pose that is put together before the statement at hand."""
        if self.before is None:
            raise NotExpressible(f"it puts a {type} together where nothing can be done before")
        held = self._variable("built", type)
        self.before += self._put_together(s.Assignment(held, value), held, type, value)
        return held

    def _asked_before(self, type: str, call: s.FunctionCall) -> s.Expression:
        """A variable with what a function that asks gives; the call where nothing can be before."""
        if self.before is None or self._is_direct(call):
            return call
        held = self._variable("answer", type)
        self.before.append(s.Assignment(held, call))
        return held

    def _of_own_task(self, call: s.FunctionCall) -> s.FunctionCall:
        """Return a read of the arm of the same task, after a check of a computed task name."""
        own = self.program.data_of(OWN_TASK)
        name = worked_out_task(call)
        # Without the cell's task name, or where no check can run before, the call stays as it is.
        if own is None or name is None or self.before is None:
            return call
        other = s.Infix("<>", name, s.NameRef(own.name))
        error = s.RaiseError(s.NameRef("ERR_TASKNAME"))
        self.before.append(s.IfThen((s.IfBranch(other, (error,)),)))
        return without_task(call)

    def _is_direct(self, call: s.FunctionCall) -> bool:
        return isinstance(self.direct, s.FunctionCall) and self.direct.span == call.span

    def _place(self, call: s.FunctionCall) -> RecordValue:
        """Return the position of the robot, read before the current statement."""
        if self.before is None:
            raise NotExpressible(
                f"`{call.name}` gives back a record where it cannot be read before"
            )
        held = self._variable("stands", "robtarget")
        here = replace(call, name="CRobT", arguments=self.values.arguments("CRobT", call.arguments))
        self.before.append(s.Assignment(held, here))
        return {(axis,): s.Component(s.Component(held, "trans"), axis) for axis in "xyz"}


def _raise_statements(node: s.ProcedureCall, own: bool) -> Sequence[s.ProcedureCall | s.RaiseError]:
    """`ErrRaise` as what it does: a message in the event log, and the error of that name.

    None of any other call, and of a name that is worked out. own: the program has such a routine.
    """
    match node:
        case s.ProcedureCall(
            str(word), (s.Positional(s.StringLiteral(name)), s.Positional(number), *texts)
        ) if word.lower() == "errraise" and not own and name.isidentifier():
            given = (s.Positional(number), s.Option("W"), *texts)
            report = s.ProcedureCall("ErrLog", given, span=node.span)
            return report, s.RaiseError(s.NameRef(name), span=node.span)
    return ()


def _at_span(made: s.StatementNode, node: s.StatementNode) -> s.StatementNode:
    return made if made.span is not None else replace(made, span=node.span)
