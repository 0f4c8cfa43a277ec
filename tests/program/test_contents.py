"""What is looked up in programs by its kind, against a look through all of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from hypothesis import given, settings

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Path
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import records
from assistant.program.statement_index import (
    has_record,
    names_in_procedures,
    records_in_body,
    records_in_procedures,
    statements_with,
)
from tests.examples import drawn
from tests.strategies import programs

COUNT = e.Name("count")
TURN = p.Assign(COUNT, e.Binary("+", COUNT, e.Apply("abs", (e.Name("step"),))))
LOOP = p.While(e.Binary("<", COUNT, e.Number(3)), (TURN, p.Wait(e.Elapsed("t"))))
INNER = Procedure("inner", (p.If((p.Branch(e.Truth(True), (LOOP,)),)), p.Call("other")))
OTHER = Procedure("other", (), variables={"own": Variable("number", e.Name("first"))})
PROGRAM = Program("whole", (INNER, OTHER), entry="inner")


def test_statements_are_found_by_what_stands_in_their_heads() -> None:
    found = list(statements_with(PROGRAM, e.Elapsed, e.Apply))
    assert [statement for statement, _ in found] == [TURN, LOOP.body[1]]
    assert [[type(part) for part in parts] for _, parts in found] == [[e.Apply], [e.Elapsed]]


def test_blocks_are_found_as_they_stand() -> None:
    assert list(records_in_body(INNER, p.While)) == [LOOP]


def test_data_of_procedures_belongs_to_what_is_anywhere() -> None:
    assert Counter(names_in_procedures(PROGRAM)) == {"count": 3, "step": 1, "first": 1}
    assert has_record(PROGRAM, e.Elapsed)
    assert not has_record(PROGRAM, p.Message, e.Here)


@settings(max_examples=drawn(25), deadline=None)
@given(programs())
def test_everything_is_found_once(program: Program) -> None:
    everything = [part for q in program.procedures for part in _all((q.body, q.variables))]
    kinds = tuple({type(part) for part in everything})
    by_kind = Counter(type(part) for part in records_in_procedures(program, *kinds))
    assert by_kind == Counter(map(type, everything))
    assert Counter(map(type, records(program.procedures))) == by_kind + Counter(
        type(part) for q in program.procedures for part in (q, *q.parameters)
    )


def _all(value: Any) -> Iterator[Any]:
    """Every record in a value, told by what it is and not by the types of fields."""
    if isinstance(value, tuple):
        for item in value:
            yield from _all(item)
    elif isinstance(value, Mapping):
        yield from _all(tuple(value.values()))
    elif is_dataclass(value) and not isinstance(value, Path):
        yield value
        for field in fields(value):
            if field.compare:
                yield from _all(getattr(value, field.name))
