"""Rows of a language: what is read by one is written by it, and what fits none is neither.

The language of these tests has calls, numbers, and names, which are texts.
"""

from __future__ import annotations

from assistant.languages.patterns import (
    Called,
    FunctionRow,
    MotionRow,
    Reading,
    Row,
    Rows,
    Slot,
    Writing,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from tests.tables import every_row

Node = Called["Node"] | float | str


def is_call(node: Node) -> Called[Node] | None:
    return node if isinstance(node, Called) else None


def literal(node: Node) -> float | None:
    return None if isinstance(node, Called | str) else node


def expression(node: Node, _: Slot) -> e.Expression | None:
    return e.Name(node) if isinstance(node, str) else e.Number(literal(node) or 0)


def signal(node: Node, slot: Slot) -> str | None:
    """A name that begins as the direction does that the slot tells."""
    fits = isinstance(node, str) and node.startswith(slot.of)
    return str(node) if fits else None


READING: Reading[Node] = Reading({"value": expression, "signal": signal}, is_call, literal)
WRITING: Writing[Node] = Writing(
    {
        "value": lambda x, _: x.name if isinstance(x, e.Name) else x.value,
        "signal": signal,
    },
    lambda call: call,
    lambda number: number,
)
ROWS = Rows(
    Row(r"Until {condition} \Most:={timeout?}", p.WaitUntil),
    Row("See {signal:signal in}, {value}", p.WaitSignal),
    Row("Watch {signal:signal out}, {value}", p.WaitSignal),
    Row(r"Blink \Up \Long:={pulse=0.2}, {signal}", p.SetSignal, value=e.Number(1)),
    Row("Push {acceleration}, 100", p.SetAcceleration, deceleration=e.Name("{acceleration}")),
    Row("Halt", p.Stop),
    MotionRow("Slide {target}, {speed}, {blend}, {tool:signal}", p.Move, kind="linear"),
    FunctionRow("bitand", "Narrow(Both(Wide({a}), Wide({b})))"),
    FunctionRow("atan2", "Turn({y}, {x})"),
    also=(Row("More {target}", p.Assign, value=e.Binary("+", e.Name("{target}"), e.Number(1))),),
)


def call(word: str, *given: Node, leading: bool = False, **options: Node | None) -> Called[Node]:
    return Called(word, list(given), options, leading)


BOTH_WAYS: list[tuple[Called[Node], object]] = [
    (call("Until", "ready"), p.WaitUntil(e.Name("ready"))),
    (call("Until", "ready", Most=5), p.WaitUntil(e.Name("ready"), e.Number(5))),
    (call("See", "in_1", 1), p.WaitSignal("in_1", e.Number(1))),
    (call("Watch", "out_1", 0), p.WaitSignal("out_1", e.Number(0))),
    (
        call("Blink", "out_1", leading=True, Up=None, Long=2),
        p.SetSignal("out_1", e.Number(1), e.Number(2)),
    ),
    (call("Push", 50, 100), p.SetAcceleration(e.Number(50), e.Number(50))),
    (call("Halt"), p.Stop()),
    (
        call("Slide", "a", "slow", "wide", "torch"),
        p.Move("linear", e.Name("a"), p.Motion(e.Name("slow"), e.Name("wide"), "torch")),
    ),
    (call("Turn", "b", "a"), e.Apply("atan2", (e.Name("b"), e.Name("a")))),
    (
        call("Narrow", call("Both", call("Wide", "a"), call("Wide", 7))),
        e.Apply("bitand", (e.Name("a"), e.Number(7))),
    ),
]


@every_row(("said", "record"), BOTH_WAYS)
def test_a_row_is_read_and_written(said: Called[Node], record: object) -> None:
    assert ROWS.read(said, READING) == record
    assert ROWS.write(record, WRITING) == said


def test_the_case_of_words_does_not_count_and_what_is_missing_has_its_default() -> None:
    short = call("BLINK", "out_1", leading=True, up=None)
    assert ROWS.read(short, READING) == p.SetSignal("out_1", e.Number(1), e.Number(0.2))


def test_a_row_that_is_only_read_is_not_written() -> None:
    more = p.Assign(e.Name("n"), e.Binary("+", e.Name("n"), e.Number(1)))
    assert ROWS.read(call("More", "n"), READING) == more
    assert ROWS.write(more, WRITING) is None
    assert "more" in ROWS
    assert "more" not in ROWS.written
    assert p.Assign not in ROWS.records


@every_row(
    "said",
    [
        call("Other"),
        call("Until"),  # without what it needs
        call("Until", "ready", 1),  # with more than it has
        call("Until", "ready", Least=5),
        call("Until", "ready", Most=None),  # an option without its value
        call("Blink", "out_1", Long=2),  # without its switch
        call("Blink", "out_1", Up=1),  # a switch with a value
        call("See", "out_1", 1),  # a signal that is none of this kind
        call("Push", 50, 90),  # another number
        call("Narrow", call("Either", call("Wide", "a"), call("Wide", 7))),
        call("Narrow", "a"),
    ],
)
def test_what_fits_no_row_is_not_read(said: Called[Node]) -> None:
    assert ROWS.read(said, READING) is None


@every_row(
    "record",
    [
        p.Stop(end=True),  # a field that no slot says
        p.SetSignal("out_1", e.Number(0), e.Number(2)),  # another value
        p.SetSignal("out_1", e.Number(1)),  # nothing for a slot that is needed
        p.SetAcceleration(e.Number(50), e.Number(60)),
        p.WaitSignal("other", e.Number(1)),
        p.Wait(e.Number(1)),
        p.Move("linear", e.Name("a"), p.Motion(e.Name("slow"), e.Name("wide"), "torch", "desk")),
        p.Move("joint", e.Name("a"), p.Motion(e.Name("slow"), e.Name("wide"), "torch")),
        e.Apply("atan2", (e.Name("b"),)),
        e.Apply("sin", (e.Name("b"),)),
    ],
)
def test_what_no_row_says_is_not_written(record: object) -> None:
    assert ROWS.write(record, WRITING) is None
