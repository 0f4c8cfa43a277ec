"""Rows that make nodes of the children of a rule."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from assistant.base.diagnostics import Span
from assistant.languages.nodes import Nodes, row, without_place
from tests.tables import every_row


@dataclass(frozen=True)
class Routine:
    kind: str
    local: bool
    name: str
    body: tuple[str, ...] = ()
    result: str | None = None
    span: Span | None = None


@dataclass(frozen=True)
class Pair:
    first: str
    second: str = "none"


class Made(
    Nodes,
    rows={
        "routine": row(Routine, "local? name *body _ result", kind="PROC", name=str.upper),
        "pair": row(Pair),
        "turned": row(Pair, "second? first"),
        "fixed": row(Pair, "", first="a"),
        "listed": without_place(tuple),
    },
):
    def hand_written(self, place: Span | None, children: list[str]) -> Span | None:
        return self.span(place)


PLACE = Span(1, 3)


@every_row(
    ("rule", "children", "node"),
    [
        ("routine", ["LOCAL", "a", "END", "x"], Routine("PROC", True, "A", (), "x", PLACE)),
        (
            "routine",
            [None, "a", "b", "c", "END", None],
            Routine("PROC", False, "A", ("b", "c"), None, PLACE),
        ),
        ("pair", ["a"], Pair("a", "none")),
        ("pair", ["a", "b"], Pair("a", "b")),
        ("turned", ["b", "a"], Pair("a", "b")),
        ("turned", [None, "a"], Pair("a", "")),
        ("fixed", [], Pair("a", "none")),
        ("listed", ["a", "b"], ("a", "b")),
    ],
)
def test_children_are_the_fields_of_a_node(rule: str, children: list[str], node: object) -> None:
    given = list(children)
    assert getattr(Made(), rule)(PLACE, given) == node
    assert given == children


def test_places_are_those_of_the_source() -> None:
    moved = Made(lambda offset: offset + 10)
    assert moved.hand_written(PLACE, []) == Span(11, 13)
    assert moved.hand_written(None, []) is None
    assert moved.routine(PLACE, ["LOCAL", "a", "END", None]).span == Span(11, 13)


def test_a_field_without_a_value_is_told() -> None:
    with pytest.raises(TypeError, match="Pair has no value"):
        row(Pair, "second")
