"""Numbers that an expression may have: anywhere in a program, or at one statement.

The values of a variable are those of all that is assigned to it anywhere, of a parameter those of
all calls. What changes in unknown ways, or may have more than a few values, is not known.
At one statement the values follow the control flow, for variables that only one procedure changes,
which nothing calls: a loop that counts with jumps ends by its condition, and so do the values of
what it counts.
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import ControlFlowGraph, Dataflow
from assistant.program.analysis.uses import base_variable
from assistant.program.program import Procedure, Program
from assistant.program.rewriting import Body, map_bodies, records
from assistant.program.vendor_statements import effect_of

MOST_VALUES: Final = 256
"""Values of one variable; more count as any."""
Numbers = frozenset[float] | None
"""None where it may be any number."""
_Place = tuple[str, str]
"""The procedure that owns a variable, empty for the program's, and its name: lower case."""
_NONE: Final[frozenset[float]] = frozenset()
_NO_MORE: Final[Mapping[str, Numbers]] = {}
_WORKED_OUT: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
}


class PossibleValues:
    """The numbers that the variables of a program may hold."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self._own = {
            q.name.lower(): {one.name.lower() for one in q.parameters}
            | {name.lower() for name in q.variables}
            for q in program.procedures
        }
        self._given: dict[_Place, list[tuple[str, e.Expression]]] = {}
        self._any: set[_Place] = set()
        self._counted: set[_Place] = set()
        """Loop variables, and variables that are not plain ones."""
        self._called: set[str] = set()
        for declaration in program.declarations:
            self._any |= {("", name) for name in effect_of(declaration).writes}
        for name, variable in program.variables.items():
            self._begins(("", name.lower()), variable.initial, variable.storage)
        for procedure in program.procedures:
            for name, variable in procedure.variables.items():
                place = procedure.name.lower(), name.lower()
                self._begins(place, variable.initial, variable.storage)
            self._procedure(procedure)
        self._found: dict[_Place, Numbers] = {}

    def of(
        self, value: e.Expression, procedure: Procedure, known: Mapping[str, Numbers] | None = None
    ) -> Numbers:
        """Return the values that an expression may have. known: of variables, in lower case."""
        owner = procedure.name.lower()
        self._settle(set(self._asked(value, owner)))
        return self._of(value, owner, known or {})

    def is_entry_alone(self, procedure: Procedure) -> bool:
        """True if a procedure runs first, and nothing calls it again."""
        name = procedure.name.lower()
        return (self.program.entry or "").lower() == name and name not in self._called

    def followed(self, value: e.Expression, procedure: Procedure) -> set[str]:
        """Plain variables that an expression depends on and that this procedure alone changes."""
        owner, found = procedure.name.lower(), set[str]()
        pending = [*self._asked(value, owner)]
        while pending:
            place = pending.pop()
            given = self._given.get(place)
            if place[1] in found or given is None or place in self._any:
                continue
            if place in self._counted or any(by not in ("", owner) for by, _ in given):
                continue
            found.add(place[1])
            pending += [other for by, one in given for other in self._asked(one, by)]
        return found

    def begun(self, name: str) -> Numbers:
        """Return the values that a variable may have before any assignment: those in its file."""
        given = self._given.get(("", name), ())
        return self._all([(by, one) for by, one in given if not by], _NONE)

    def _settle(self, asked: set[_Place]) -> None:
        """Works out what some variables may hold, and those that it depends on."""
        pending, mine = list(asked), set[_Place]()
        while pending:
            place = pending.pop()
            if place not in mine and place not in self._found and place in self._given:
                mine.add(place)
                pending += [
                    other
                    for owner, value in self._given[place]
                    for other in self._asked(value, owner)
                ]
        # From no values upwards: what depends on itself needs a start.
        self._found |= dict.fromkeys(mine, _NONE)
        # Values only grow, and at most to `MOST_VALUES`, so this ends.
        while True:
            known = {place: self._found[place] for place in mine}
            for place in mine:
                self._found[place] = self._all(self._given[place], known[place])
            if all(known[place] == self._found[place] for place in mine):
                return

    def _asked(self, value: e.Expression, owner: str) -> Iterator[_Place]:
        """The variables that an expression reads."""
        for record in records(value):
            if isinstance(record, e.Name):
                yield self._place(record.name.lower(), owner)

    def _of(
        self, value: e.Expression, owner: str, known: Mapping[str, Numbers] = _NO_MORE
    ) -> Numbers:
        match value:
            case e.Number(number):
                return frozenset((float(number),))
            case e.Name(name) if name.lower() in known:
                return known[name.lower()]
            case e.Name() | e.Index():
                place = self._place(base_variable(value), owner)
                return None if place in self._any else self._found.get(place)
            case e.Apply("round", (inner,)):
                found = self._of(inner, owner, known)
                whole = found is not None and all(one.is_integer() for one in found)
                return found if whole else None
            case e.Unary("-", inner):
                found = self._of(inner, owner, known)
                return None if found is None else frozenset(-one for one in found)
            case e.Binary(sign, left, right) if sign in _WORKED_OUT:
                return _combined(
                    _WORKED_OUT[sign],
                    self._of(left, owner, known),
                    self._of(right, owner, known),
                )
            case e.Binary("/", left, right):
                divisors = self._of(right, owner, known)
                if divisors is not None and 0.0 not in divisors:
                    return _combined(operator.truediv, self._of(left, owner, known), divisors)
        return None

    # -------------------------------------------------------------------------- gathering

    def _place(self, name: str, owner: str) -> _Place:
        return (owner if name in self._own.get(owner, ()) else "", name)

    def _begins(self, place: _Place, initial: e.Expression | None, storage: str) -> None:
        """Add the values in the file to those that the variable may have."""
        self._given.setdefault(place, [])
        # A persistent variable without a value has whatever the controller holds.
        if initial is None and storage == "persistent":
            self._any.add(place)
        for value in _array_elements(initial):
            self._given[place].append((place[0], value))

    def _procedure(self, procedure: Procedure) -> None:
        owner = procedure.name.lower()
        for parameter in procedure.parameters:
            self._given.setdefault((owner, parameter.name.lower()), [])
        for record in records(procedure.body):
            match record:
                case p.Assign(e.Member() as target):
                    # Components are not followed.
                    self._any.add(self._place(base_variable(target), owner))
                case p.Assign(target, value):
                    if not isinstance(target, e.Name):
                        self._counted.add(self._place(base_variable(target), owner))
                    self._give(self._place(base_variable(target), owner), owner, value)
                case p.For(name, e.Number(first), e.Number(last), _, e.Number(step)) if step:
                    place = self._place(name.lower(), owner)
                    self._counted.add(place)
                    turns = (last - first) / step  # no number if both ends are beyond any
                    if not turns < MOST_VALUES:
                        self._any.add(place)
                        continue
                    # After the loop its variable is one step past the end.
                    for turn in range(int(max(turns, -1.0)) + 2):
                        self._give(place, owner, e.Number(first + turn * step))
                case p.For(name):
                    self._any.add(self._place(name.lower(), owner))
                case p.Opaque() | e.Verbatim():
                    writes = effect_of(record).writes
                    self._any |= {self._place(name, owner) for name in writes}
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    self._call(name, arguments, owner)

    def _call(self, name: str, arguments: tuple[e.Expression, ...], owner: str) -> None:
        callee = self.program.procedure(name)
        if callee is None:
            return
        self._called.add(callee.name.lower())
        for parameter, value in itertools.zip_longest(callee.parameters, arguments):
            if parameter is None or value is None:
                continue
            place = callee.name.lower(), parameter.name.lower()
            self._give(place, owner, value)
            # An `inout` parameter hands its values back.
            if parameter.mode == "inout" and (name := base_variable(value)):
                self._give(self._place(name, owner), place[0], e.Name(parameter.name))

    def _give(self, place: _Place, owner: str, value: e.Expression) -> None:
        given = self._given.setdefault(place, [])
        given += ((owner, one) for one in _array_elements(value))

    def _all(self, given: list[tuple[str, e.Expression]], known: Numbers) -> Numbers:
        """The numbers of several expressions, each in its procedure."""
        found = known
        for owner, value in given:
            more = self._of(value, owner)
            if found is None or more is None:
                return None
            found |= more
        return found if found is None or len(found) <= MOST_VALUES else None


def _array_elements(value: e.Expression | None) -> Iterator[e.Expression]:
    """The values of an array; any other is one."""
    if isinstance(value, e.Aggregate):
        for item in value.items:
            yield from _array_elements(item)
    elif value is not None:
        yield value


def _combined(made: Callable[[float, float], float], left: Numbers, right: Numbers) -> Numbers:
    if left is None or right is None or len(left) * len(right) > MOST_VALUES:
        return None
    return frozenset(made(a, b) for a in left for b in right)


State = tuple[Numbers, ...]
"""By the variables that are followed; no numbers where none has been given."""
_HOLDS: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt,
    "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Assumed:
    """Marks a position at which a condition is known to hold, or not to hold."""

    condition: e.Expression
    holds: bool


def numbers_at(
    possible: PossibleValues, value: e.Expression, procedure: Procedure, statement: p.Statement
) -> Numbers:
    """Return the possible values of an expression at a statement of a procedure."""
    found = possible.of(value, procedure)
    # Other procedures may be entered with any values.
    if found is not None or not possible.is_entry_alone(procedure):
        return found
    names = sorted(possible.followed(value, procedure))
    if not names:
        return None
    return _ValuesAlongPaths(possible, procedure, names).at(value, statement)


def numbers_of_all(
    possible: PossibleValues, value: e.Expression, procedure: Procedure
) -> Callable[[p.Statement], Numbers]:
    """Possible values of an expression at each statement of a procedure, by the statement.

    A cycle may begin with whatever the one before left.
    """
    anywhere = possible.of(value, procedure)
    found: dict[int, Numbers] = {}
    if possible.is_entry_alone(procedure) and (
        names := sorted(possible.followed(value, procedure))
    ):
        following = _ValuesAlongPaths(possible, procedure, names, again=True)
        for node, state in following.found.items():
            for part in following.graph.runs[node]:
                found[id(part)] = following.of(value, state)
                state = following.ran(part, state)
    return lambda statement: found.get(id(statement), anywhere)


class _ValuesAlongPaths:
    """The values of some variables along one procedure. names: in lower case. again: whether it
    may begin with any values that they ever have.
    """

    def __init__(
        self, possible: PossibleValues, procedure: Procedure, names: list[str], again: bool = False
    ) -> None:
        self.possible, self.procedure, self.names = possible, procedure, names
        # Conditions become statements, so that each branch knows what has been decided.
        self.graph = ControlFlowGraph(_with_assumptions(procedure.body))
        flow: Dataflow[int, State] = Dataflow(self.graph.after, self.behind, _merged_values)
        begun = (
            possible.of(e.Name(name), procedure) if again else possible.begun(name)
            for name in names
        )
        flow.spread([(self.graph.start, tuple(begun))])
        # Only conditions with the variable on the left are used.
        self.found = flow.found

    def at(self, value: e.Expression, statement: p.Statement) -> Numbers:
        for node, state in self.found.items():
            for part in self.graph.runs[node]:
                if part is statement:
                    return self.of(value, state)
                state = self.ran(part, state)
        return None

    def behind(self, node: int, state: State) -> State:
        for part in self.graph.runs[node]:
            state = self.ran(part, state)
        return state

    def ran(self, part: Any, state: State) -> State:
        match part:
            case p.Assign(e.Name(name), value) if name.lower() in self.names:
                return self.given(name.lower(), self.of(value, state), state)
            case _Assumed(e.Binary(sign, left, right), holds) if sign in _HOLDS:
                return self.assumed(sign, left, right, holds, state)
        return state

    def given(self, name: str, numbers: Numbers, state: State) -> State:
        at = self.names.index(name)
        most = numbers if numbers is not None and len(numbers) <= MOST_VALUES else None
        return (*state[:at], most, *state[at + 1 :])

    def of(self, value: e.Expression, state: State) -> Numbers:
        return self.possible.of(value, self.procedure, dict(zip(self.names, state, strict=True)))

    def assumed(
        self, sign: str, left: e.Expression, right: e.Expression, holds: bool, state: State
    ) -> State:
        """The values of a variable that a condition leaves."""
        match left:
            case e.Name(name) if name.lower() in self.names:
                mine, others = self.of(left, state), self.of(right, state)
                if mine is not None and others is not None:
                    fits = _HOLDS[sign]
                    left_over = frozenset(
                        a for a in mine if any(fits(a, b) == holds for b in others)
                    )
                    return self.given(name.lower(), left_over, state)
        return state


def _merged_values(one: State, two: State) -> State:
    return tuple(
        None if a is None or b is None or len(a | b) > MOST_VALUES else a | b
        for a, b in zip(one, two, strict=True)
    )


def _with_assumptions(body: Body) -> Body:
    """The body with what each condition says where it has been asked."""
    made: list[Any] = []
    for node in body:
        match node:
            case p.If(branches, otherwise):
                changed, before = [], list[Any]()
                for branch in branches:
                    # A branch is entered only if all conditions before it failed.
                    inside = (*before, _Assumed(branch.condition, True))
                    changed.append(replace(branch, body=(*inside, *_with_assumptions(branch.body))))
                    before.append(_Assumed(branch.condition, False))
                rest = (*before, *_with_assumptions(otherwise))
                made.append(replace(node, branches=tuple(changed), otherwise=rest))
            case p.While(condition, inner):
                inside = (_Assumed(condition, True), *_with_assumptions(inner))
                # A `while` is left only when its condition fails.
                made += [replace(node, body=inside), _Assumed(condition, False)]
            case _:
                made.append(map_bodies(node, _with_assumptions))
    return tuple(made)
