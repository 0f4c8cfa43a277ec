"""Statements of a program with records, as those of one with plain data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lift.plain.layouts import SETTINGS, Path
from assistant.languages.rapid.lift.plain.scopes import Datum, Program, parameters
from assistant.languages.rapid.lift.plain.values import Kind, Spread, Unsaid, Values
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes

Nodes = tuple[s.StatementNode, ...]
_ONCE: Final = (s.Assignment, s.ProcedureCall, s.ReturnFrom)


class Bodies:
    """The statements of one routine.

    kept: statements that stay as they are written, by `id`, with why; they are in what is made.
    """

    def __init__(self, program: Program, routine: s.Routine, kept: dict[int, str]) -> None:
        self.program, self.routine, self.kept = program, routine, kept
        self.names: dict[str, Datum] = {
            one.name.lower(): program.datum_of(one) for one in parameters(routine)
        }
        data = [node for node in routine.body if isinstance(node, s.Data)]
        self.names |= {node.name.lower(): program.datum(node) for node in data}
        self.values = Values(program, self.names, self._called)
        self.before: list[s.StatementNode] | None = None
        self.alone: s.Expression | None = None
        """A value that is used at once, before anything else is called."""
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
        return tuple(said for node in body for said in self._statement(node))

    def _statement(self, node: s.StatementNode) -> list[s.StatementNode]:
        before, self.before = self.before, []
        try:
            made = list(self._said(node))
            return [_at(one, node) for one in self.before] + made
        except Unsaid as unsaid:
            self.kept[id(node)] = unsaid.why
            return [node]
        finally:
            self.before = before

    def _said(self, node: s.StatementNode) -> Iterator[s.StatementNode]:
        plain = self.values.plain
        match node:
            case s.Data():
                yield from declared(node, self.names[node.name.lower()], self.values)
            case s.Assignment(target, value):
                yield from self._assigned(node, target, value)
            case s.ProcedureCall(name, arguments):
                yield replace(node, arguments=self.values.arguments(name, arguments))
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
        """A value that a block asks for, as it is written where it cannot be said.

        again: it is asked for where nothing can be called before.
        """
        held = self.before
        self.before = None if again else held
        try:
            return self.values.plain(condition)
        except Unsaid:
            return condition
        finally:
            self.before = held

    def _assigned(
        self, node: s.Assignment, target: Any, value: s.Expression
    ) -> Iterator[s.StatementNode]:
        kind = self.values.kind(target)
        if kind is None or not self.values.is_record(kind) or self._is_setting(target, kind):
            type = None if kind is None else kind[0]
            variable = self.values.plain(target)
            yield replace(node, target=variable, value=self.values.given(value, type))
            return
        if self._both_stay(target) and self._both_stay(value):
            yield node
            return
        places = self.values.spread(target, kind)
        self.alone = value
        yield from self._copied(node, places, self.values.spread(value, kind), kind)

    def _is_setting(self, target: Any, kind: Kind) -> bool:
        """Whether a tool, frame, speed or zone is assigned that is one variable."""
        return kind[0] in SETTINGS and not self.values.is_apart(target)

    def _both_stay(self, node: Any) -> bool:
        """Whether a variable is a component of data that is not taken apart."""
        base, _, path = self.values.steps(node)
        datum = None if base is None else self.values.find(base.name)
        return datum is not None and not datum.names and path != ("trans",)

    def _copied(
        self, node: s.StatementNode, places: Spread, parts: Spread, kind: Kind
    ) -> Iterator[s.StatementNode]:
        """Each part assigned; by way of variables where a part that was assigned is asked for."""
        changed: set[str] = set()
        later = list(places)
        asked = {path: _names_in(parts[path]) for path in later}
        clashes = False
        for path in later:
            clashes |= not changed.isdisjoint(asked[path] | _indices_of(places[path]))
            changed |= _roots(places[path])
        if clashes and kind[1]:
            raise Unsaid("it reads parts of what it assigns")
        if not clashes:
            for path in later:
                yield s.Assignment(places[path], parts[path], span=node.span)  # type: ignore[arg-type]
            return
        types = {one.path: one.type for one in self.program.layouts.parts(kind[0]) or ()}
        held = {path: self._variable("_".join(("new", *path)), types[path]) for path in later}
        for path in later:
            yield s.Assignment(held[path], parts[path], span=node.span)
        for path in later:
            yield s.Assignment(places[path], held[path], span=node.span)  # type: ignore[arg-type]

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
        places: Mapping[Path, s.Expression] = {p: s.NameRef(name) for p, name in result.items()}
        self.alone = value
        yield from self._copied(node, places, self.values.spread(value, kind), kind)
        yield replace(node, value=None)

    def _called(self, call: s.FunctionCall) -> Spread:
        """Calls a function that gives back a record before the statement at hand."""
        routine = self.program.routines[call.name.lower()]
        result = self.program.result(routine)
        if self.before is None or not result:
            raise Unsaid(f"`{call.name}` gives back a record where it cannot be called before")
        arguments = self.values.arguments(call.name, call.arguments)
        self.before.append(s.ProcedureCall(call.name, arguments))
        types = {one.path: one.type for one in self.program.layouts.parts(routine.type) or ()}
        made: dict[Path, s.Expression] = {}
        if self.alone is call:
            return {path: s.NameRef(name) for path, name in result.items()}
        for path, name in result.items():
            held = self._variable(name, types[path])
            self.before.append(s.Assignment(held, s.NameRef(name)))
            made[path] = held
        return made


def declared(node: s.Data, datum: Datum, values: Values) -> Iterator[s.Data]:
    """What is declared instead of some data; raises Unsaid for a value that cannot be said."""
    program = values.program
    if not datum.names:
        value = None if node.value is None else values.given(node.value, datum.type)
        yield replace(node, type=program.plain_type(node.type), value=value)
        return
    spread: Spread = {}
    if node.value is not None:
        spread = values.spread(node.value, (datum.type, datum.dimensions))
    if program.stays(node):
        yield node
    for part in program.layouts.parts(datum.type) or ():
        name, value = datum.names[part.path], spread.get(part.path)
        yield replace(node, type=part.type, name=name, value=value)


def _at(made: s.StatementNode, node: s.StatementNode) -> s.StatementNode:
    return made if made.span is not None else replace(made, span=node.span)


def _names_in(value: Any) -> set[str]:
    return {node.name.lower() for node in nodes(value) if isinstance(node, s.NameRef)}


def _roots(place: Any) -> set[str]:
    while not isinstance(place, s.NameRef):
        place = place.value
    return {place.name.lower()}


def _indices_of(place: Any) -> set[str]:
    found: set[str] = set()
    while not isinstance(place, s.NameRef):
        if isinstance(place, s.Element):
            found |= _names_in(place.indices)
        place = place.value
    return found
