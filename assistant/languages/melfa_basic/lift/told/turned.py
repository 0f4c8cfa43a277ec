"""Positions with separate angles, in separate statements.

`Mvs P1+(0,0,5,0,0,30)` moves to a position whose angles are worked out one by one. Other languages
turn a position by an assignment; so it is worked out in front of the statement that names it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeGuard

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.rewriting import Body, head, map_head, records


def with_turned_positions(
    statements: Sequence[p.Statement], held: Callable[[], e.Name]
) -> Body | None:
    """The statements with such positions in assignments.

    held: a position that nothing else names. None where a statement names several such positions,
    or one in a condition.
    """
    made: list[p.Statement] = []
    for one in statements:
        turned = [x for x in records(head(one)) if _is_turned(x)]
        if not turned:
            made.append(one)
        elif len(turned) > 1 or not isinstance(one, p.Assign | p.Move | p.MoveCircular):
            return None
        else:
            made += _in_two_statements(one, turned[0], held)
    return tuple(made)


def _in_two_statements(
    one: p.Assign | p.Move | p.MoveCircular, turned: e.Apply, held: Callable[[], e.Name]
) -> list[p.Statement]:
    place, *angles = turned.arguments
    if isinstance(one, p.Assign) and one.value == turned:
        base = place.arguments[0] if isinstance(place, e.Apply) else place
        if base == one.target and _names_in(tuple(angles)) <= _names_in(base):
            moved = [] if place == one.target else [replace(one, value=place)]
            return [*moved, replace(one, value=e.Apply("oriented", (one.target, *angles)))]
        if _names_in(one.target).isdisjoint(_names_in(turned)):
            turned = e.Apply("oriented", (one.target, *angles))
            return [replace(one, value=place), replace(one, value=turned)]
    name = held()

    def named(x: e.Expression) -> e.Expression:
        return name if x == turned else x

    return [
        p.Assign(name, place, span=one.span),
        p.Assign(name, e.Apply("oriented", (name, *angles)), span=one.span),
        map_head(one, named),
    ]


def _names_in(value: object) -> set[str]:
    return {x.name.lower() for x in records(value) if isinstance(x, e.Name)}


def _is_turned(x: object) -> TypeGuard[e.Apply]:
    return isinstance(x, e.Apply) and x.function == "oriented"
