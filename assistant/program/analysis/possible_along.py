"""Which numbers an expression may come to at one place, along the ways that lead there.

For variables that one procedure alone changes, which nothing calls: a loop that counts with jumps
ends by its condition, and so do the values of what it counts.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import Dataflow
from assistant.program.analysis.graph import ControlFlowGraph
from assistant.program.analysis.possible import MOST_VALUES, Numbers, PossibleValues
from assistant.program.program import Procedure
from assistant.program.rewriting import Body, map_bodies

State = tuple[Numbers, ...]
"""By the variables that are followed; no numbers where none has been given."""
_HOLDS: Final[Mapping[str, Callable[[float, float], bool]]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt,
    "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Assumed:
    """Stands where a condition is known to hold, or not to."""

    condition: e.Expression
    holds: bool


def numbers_at(
    possible: PossibleValues, value: e.Expression, procedure: Procedure, statement: p.Statement
) -> Numbers:
    """What an expression of a statement may come to where that stands in a procedure."""
    found = possible.of(value, procedure)
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
        self.graph = ControlFlowGraph(_with_assumptions(procedure.body))
        flow: Dataflow[int, State] = Dataflow(self.graph.after, self.behind, _merged_values)
        begun = (
            possible.of(e.Name(name), procedure) if again else possible.begun(name)
            for name in names
        )
        flow.spread([(self.graph.start, tuple(begun))])
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
                    inside = (*before, _Assumed(branch.condition, True))
                    changed.append(replace(branch, body=(*inside, *_with_assumptions(branch.body))))
                    before.append(_Assumed(branch.condition, False))
                rest = (*before, *_with_assumptions(otherwise))
                made.append(replace(node, branches=tuple(changed), otherwise=rest))
            case p.While(condition, inner):
                inside = (_Assumed(condition, True), *_with_assumptions(inner))
                made += [replace(node, body=inside), _Assumed(condition, False)]
            case _:
                made.append(map_bodies(node, _with_assumptions))
    return tuple(made)
