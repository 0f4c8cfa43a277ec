"""What runs after what in a program, and what holds there along every way."""

from __future__ import annotations

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.dataflow import Dataflow, postorder, reachable
from assistant.program.analysis.definite_assignment import AssignmentAnalysis
from assistant.program.expressions import Effect
from assistant.program.program import Procedure, Program
from tests.tables import every_row

LOOP = {1: [2], 2: [3, 5], 3: [4], 4: [2], 5: [], 6: [5]}


def test_what_can_be_come_to() -> None:
    assert reachable([3], LOOP.__getitem__) == {2, 3, 4, 5}
    assert reachable([], LOOP.__getitem__) == set()


def test_nodes_stand_behind_those_that_follow_them() -> None:
    order = postorder(LOOP)
    assert sorted(order) == sorted(LOOP)
    assert order.index(5) < order.index(2) < order.index(1)
    assert order.index(5) < order.index(6)


def test_ways_that_meet_are_joined_until_nothing_changes() -> None:
    made = {1: {"a"}, 3: {"b"}, 4: {"c"}}
    flow = Dataflow(LOOP, lambda node, held: held | made.get(node, set()), set[str].__or__)
    flow.spread([(1, set())])
    loop = {"a", "b", "c"}
    assert flow.found == {1: set(), 2: loop, 3: loop, 4: loop, 5: loop}
    flow.spread([(6, {"d"})])
    assert flow.found[5] == {*loop, "d"}


def test_what_never_ends_passes_nothing_on() -> None:
    flow = Dataflow[int, bool](LOOP, lambda node, held: None if node == 3 else held, bool.__or__)
    flow.spread([(1, True)])
    assert set(flow.found) == {1, 2, 3, 5}


GIVE_A = p.Assign(e.Name("a"), e.Number(1))
GIVE_B = p.Assign(e.Name("b"), e.Number(1))
READ_A = p.Assign(e.Name("b"), e.Name("A"))
IF_C = p.Branch(e.Name("c"), (GIVE_A,))


@every_row(
    ("body", "read", "given"),
    [
        ((GIVE_A, READ_A), "", "ab"),
        ((READ_A,), "a", "b"),
        ((p.If((IF_C,)), READ_A), "ac", "b"),
        ((p.If((IF_C,), (GIVE_A,)), READ_A), "c", "ab"),
        ((p.While(e.Name("c"), (GIVE_A,)), READ_A), "ac", "b"),
        ((p.Goto("on"), READ_A, p.Label("on"), GIVE_A), "", "a"),
        # on every way to a label, also from below
        ((GIVE_A, p.Label("again"), READ_A, p.Goto("again")), "", None),
        ((p.Label("again"), READ_A, GIVE_A, p.Goto("again")), "a", None),
        ((p.Goto("on"), p.Label("by"), READ_A, p.Label("on"), GIVE_A, p.Goto("by")), "", None),
        ((GIVE_A, p.Return(), READ_A), "", "a"),
        ((p.While(e.Truth(True), (GIVE_A,)), READ_A), "", None),
        # kept text may go to a label that it names
        (
            (p.Opaque("x", "go", effect=Effect(frozenset(["on"]))), GIVE_A, p.Label("on"), READ_A),
            "a",
            "b",
        ),
    ],
)
def test_what_is_read_before_it_has_a_value(
    body: tuple[p.Statement, ...], read: str, given: str | None
) -> None:
    procedure = Procedure("main", body)
    run = AssignmentAnalysis(Program("p", (procedure,))).run(procedure)
    assert run.read - {"on"} == set(read)
    assert run.given == (None if given is None else frozenset(given))
