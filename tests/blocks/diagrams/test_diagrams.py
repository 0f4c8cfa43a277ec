"""Diagrams that are stepped: order, delays, periods, what is wrong with them, real time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import Block, Diagram, Port, RealTime, run
from assistant.blocks.rules import NO_PORT


class Time(Block):
    def __init__(self, name: str = "time", *, period: float | None = None) -> None:
        super().__init__(name, (), [Port("seconds", unit="s")], period=period)

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[float]:
        return [now]


class Sum(Block):
    def __init__(self, name: str = "sum") -> None:
        super().__init__(name, [Port("a"), Port("b")], [Port("sum")])

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[Floats]:
        return [given[0] + given[1]]


class Held(Block):
    direct = False

    def __init__(self, name: str = "held") -> None:
        super().__init__(name, [Port("next")], [Port("value")])
        self.value = np.zeros(1)
        self.open = self.begun = 0

    def begin(self) -> None:
        self.open += 1
        self.begun += 1

    def end(self) -> None:
        self.open -= 1

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[Floats]:
        return [self.value]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        self.value = given[0]


def counting() -> tuple[Diagram, Held]:
    """The sum of all times until now, in a loop with a delay."""
    diagram = Diagram()
    time, total, held = (diagram.add(one) for one in (Time(), Sum(), Held()))
    diagram.wire(time, (total, "a"))
    diagram.wire(held, (total, "b"))
    diagram.wire(total, held)
    assert isinstance(held, Held)
    return diagram, held


def test_a_loop_with_a_delay_adds_up() -> None:
    diagram, held = counting()
    ran = run(diagram, 1.0, 0.1)
    assert ran.seconds == pytest.approx(np.arange(11) * 0.1)
    assert ran["sum.sum"] == pytest.approx(np.cumsum(np.arange(11) * 0.1))
    assert ran["held.value"][1:] == pytest.approx(ran["sum.sum"][:-1])
    assert held.open == 0


def test_a_block_with_a_period_holds_its_output() -> None:
    diagram = Diagram()
    diagram.add(Time(period=0.3))
    ran = run(diagram, 0.8, 0.1)
    assert ran["time.seconds"] == pytest.approx([0.0] * 3 + [0.3] * 3 + [0.6] * 3)


def test_what_fits_not_is_refused() -> None:
    diagram, _ = counting()
    with pytest.raises(Refused, match="BL101"):
        diagram.add(Time())
    with pytest.raises(Refused, match="BL103"):
        diagram.wire(diagram.blocks[0], (diagram.blocks[1], "a"))
    with pytest.raises(Refused, match="BL115"):
        diagram.wire(diagram.blocks[0], diagram.blocks[1])
    with pytest.raises(Refused, match="BL102"):
        diagram.wire(diagram.blocks[0], (diagram.blocks[1], "z"))
    with pytest.raises(Refused, match="BL109"):
        diagram.wire(Time("other"), diagram.blocks[2])
    with pytest.raises(Refused, match="BL108"):
        run(diagram, 1.0, 0.0)
    with pytest.raises(Refused, match="BL108"):
        run(diagram, np.inf, 0.1)
    lonely = Diagram()
    lonely.add(Sum())
    with pytest.raises(Refused, match="BL104"):
        run(lonely, 1.0, 0.1)
    for period in (0.25, np.nan, np.inf, -0.1):
        uneven, held = Diagram(), Held()
        uneven.wire(uneven.add(Time(period=period)), uneven.add(held))
        with pytest.raises(Refused, match="BL108"):
            run(uneven, 1.0, 0.1)
        assert not held.begun  # nothing is opened before that


def test_a_loop_without_a_delay_is_told_by_its_blocks() -> None:
    diagram = Diagram()
    one, two = diagram.add(Sum("one")), diagram.add(Sum("two"))
    diagram.wire(one, (two, "a"), (two, "b"))
    diagram.wire(two, (one, "a"), (one, "b"))
    with pytest.raises(Refused, match=r"BL107.*`one`.*`two`"):
        run(diagram, 1.0, 0.1)


def test_a_block_that_fails_ends_the_others() -> None:
    class Wrong(Sum):
        def give(self, now: float, given: Sequence[Floats]) -> Sequence[Floats]:
            return [np.zeros(2)] if now > 0.45 else [given[0]]

    diagram = Diagram()
    time, held, wrong = (diagram.add(one) for one in (Time(), Held(), Wrong("wrong")))
    diagram.wire(time, (wrong, "a"), (wrong, "b"))
    diagram.wire(wrong, held)
    with pytest.raises(Refused, match=r"BL110.*`wrong` failed at 0.5 s"):
        run(diagram, 1.0, 0.1)
    assert held.open == 0


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (lambda: None, "TypeError"),
        (lambda: [][1], "IndexError: list index out of range"),
        (lambda: Path("/nowhere").stat(), "FileNotFoundError"),
        (lambda: next(iter(())), "StopIteration"),
        (lambda: 1 / 0, "division by zero"),
    ],
)
def test_whatever_an_own_block_raises_is_told_with_its_name(
    given: Callable[[], Sequence[Floats]], told: str
) -> None:
    class Own(Block):
        def give(self, now: float, signals: Sequence[Floats]) -> Sequence[Floats]:
            return given()

    diagram = Diagram()
    diagram.add(Own("own", [], [Port("value")]))
    with pytest.raises(Refused, match=f"BL110.*`own` failed at 0 s: {told}") as found:
        run(diagram, 1.0, 0.1)
    assert found.value.__cause__ is not None  # the line of the own code


def test_what_ended_a_run_is_told_before_what_its_end_met() -> None:
    class Lost(Sum):
        def give(self, now: float, given: Sequence[Floats]) -> Sequence[Floats]:
            raise Refused(NO_PORT(block="first", kind="output", name="x", known="y"))

        def end(self) -> None:
            raise Refused(NO_PORT(block="second", kind="output", name="x", known="y"))

    diagram = Diagram()
    lost, held = diagram.add(Lost("lost")), diagram.add(Held())
    diagram.wire(diagram.add(Time()), (lost, "a"), (lost, "b"))
    diagram.wire(lost, held)
    with pytest.raises(Refused, match=r"`first`.*`second`"):
        run(diagram, 1.0, 0.1)
    assert held.open == 0


def test_one_name_confirms_no_other_that_it_holds() -> None:
    diagram = Diagram()
    diagram.add(Time()).moves = "cell"
    for names in ("cell-2", ["cell-2"], ()):
        with pytest.raises(Refused, match="BL111"):
            run(diagram, 0.1, 0.1, moving=names)
    assert len(run(diagram, 0.1, 0.1, moving="cell").seconds) == 2


def test_sizes_that_differ_are_an_error_and_units_a_warning() -> None:
    class Six(Block):
        def __init__(self) -> None:
            super().__init__("six", [Port("joints", 6, "deg")])

    diagram = Diagram()
    time, six = diagram.add(Time()), diagram.add(Six())
    diagram.wire(time, six)
    with pytest.raises(Refused, match="BL105"):
        run(diagram, 1.0, 0.1)

    class Degrees(Block):
        def __init__(self) -> None:
            super().__init__("degrees", [Port("angle", 1, "deg")])

        def give(self, now: float, given: Sequence[Floats]) -> Sequence[Floats]:
            return []

    other = Diagram()
    other.wire(other.add(Time()), other.add(Degrees()))
    assert [one.code for one in run(other, 0.2, 0.1).findings] == ["BL106"]


def test_real_time_waits_for_each_step_and_tells_how_late_it_was() -> None:
    diagram, _ = counting()
    ran = run(diagram, 0.2, 0.01, clock=RealTime())
    assert len(ran.seconds) == 21
    assert (ran.lateness >= 0.0).all()
    assert ran.late == (ran.lateness > 0.005).sum()


def test_a_run_ends_when_who_watches_says_so() -> None:
    diagram, _ = counting()
    assert len(run(diagram, 1.0, 0.1, watch=lambda now: now < 0.35).seconds) == 4


@pytest.mark.parametrize("pace", [0.0, -1.0, np.nan, np.inf])
def test_time_goes_on(pace: float) -> None:
    with pytest.raises(ValueError, match="pace"):
        RealTime(pace)
