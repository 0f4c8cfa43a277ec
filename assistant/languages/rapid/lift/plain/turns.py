"""Quaternions whose four parts are set one by one, as what is set as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from assistant.languages.rapid.lift.plain.assigning import names_in
from assistant.languages.rapid.lift.plain.library import ORIENTATION, QUATERNION
from assistant.languages.rapid.lift.plain.values import Values
from assistant.languages.rapid.tree import syntax as s


def with_joined_quaternions(
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
    if any(names_in(turns[0]) & names_in(value) for value in parts.values()):
        return None
    aggregate = s.AggregateNode(tuple(parts[name] for name in QUATERNION))
    return s.Assignment(turns[0], aggregate, span=group[0].span)  # type: ignore[arg-type]
