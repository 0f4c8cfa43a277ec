"""Two runs that agree, and what makes two of them differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assistant.program.geometry import Pose
from assistant.virtual.events import Event, Moved, Reported, Run, Said, Stopped, Switched, Waited
from assistant.virtual.proving.comparison import Rounding, difference

MOVE = Moved("linear", Pose((400.0, 0.0, 300.0)), Pose((0.0, 0.0, 100.0)), speed=100.0, blend=10.0)
ARC = replace(MOVE, kind="circular", via=Pose((410.0, 10.0, 300.0)))
JOINTS = Moved("joint", None, Pose(), joints=(0.0, 10.0, 20.0, 0.0, 90.0, 0.0))
BITS = {"dogrip": (4,), "goslot": (16, 17, 18)}


def run(*events: Event, ended: str = "end") -> Run:
    return Run(events, ended)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (MOVE, replace(MOVE, flange=Pose((400.01, 0.0, 300.0)), blend=0.0)),
        (replace(MOVE, speed=None), MOVE),
        (replace(MOVE, kind="joint"), replace(MOVE, kind="joint", speed=None, percent=10.0)),
        (JOINTS, replace(JOINTS, joints=(0.0, 10.0, 20.01, 0.0, 90.0, 0.0))),
        (Waited(0.5), Waited(0.5000001)),
        (Stopped(), Stopped()),
    ],
)
def test_events_that_are_the_same(first: Event, second: Event) -> None:
    assert difference(run(first), run(second)) is None


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        (MOVE, replace(MOVE, flange=Pose((400.03, 0.0, 300.0))), "another flange, 0.03 mm"),
        (
            MOVE,
            replace(MOVE, flange=Pose(MOVE.flange.position, (0.999998, 0.002, 0.0, 0.0))),  # type: ignore[union-attr]
            "another flange, 0.00 mm and 0.23 degrees",
        ),
        (ARC, replace(ARC, via=Pose((410.0, -10.0, 300.0))), "another place on the way"),
        (MOVE, replace(MOVE, tool=Pose()), "another tool, 100.00 mm"),
        (MOVE, replace(MOVE, speed=101.0), "another speed"),
        (MOVE, replace(MOVE, speed=None), "another speed"),
        (MOVE, replace(MOVE, blend=20.0), "a wider corner"),
        (MOVE, replace(MOVE, kind="joint"), "another kind of motion"),
        (JOINTS, replace(JOINTS, joints=(0.0, 10.0, 20.1, 0.0, 90.0, 0.0)), "other joints"),
        (Waited(0.5), Waited(0.6), "another delay"),
        (MOVE, Stopped(), "another event"),
    ],
)
def test_events_that_differ(first: Event, second: Event, said: str) -> None:
    found = difference(run(Waited(1.0), first), run(Waited(1.0), second))
    assert found is not None
    assert found.startswith(f"event 2: {said}")


def test_what_one_of_them_does_not_do() -> None:
    assert difference(run(MOVE), run()) == (
        "event 1: linear to (400.00, 0.00, 300.00) at 100.0 blend 10.0, and ended as `end`"
    )
    assert difference(run(), run(Waited(2.0))) == "event 1: ended as `end`, and 2 s"
    assert difference(run(), run(ended="error")) == "ended as `end`, and ended as `error`"


def test_texts_and_delays_of_no_time_do_nothing() -> None:
    assert difference(run(Said("part"), Waited(0.0)), run()) is None


def test_signals_by_name_and_by_number() -> None:
    named = run(Switched("dogrip", 1), Switched("goslot", 5), Switched("goslot", 4))
    bits = [Switched("4", 1), Switched("16", 1), Switched("17", 0), Switched("18", 1)]
    assert difference(named, run(*bits, Switched("16", 0)), BITS) is None
    assert difference(named, run(*bits), BITS) is not None
    assert difference(named, run(*bits, Switched("17", 1)), BITS) is not None


def test_a_signal_that_is_set_to_what_it_is_does_nothing() -> None:
    twice = run(Switched("dogrip", 1), Switched("dogrip", 1))
    assert difference(twice, run(Switched("4", 1)), BITS) is None
    assert difference(run(Switched("dogrip", 0)), run(), BITS) is not None  # it may have been 1
    whole_byte = run(Switched("4", 1), Switched("20", 0))  # 20 is no signal of the program
    assert difference(run(Switched("dogrip", 1)), whole_byte, BITS) is None


def test_runs_that_never_end() -> None:
    assert difference(run(MOVE, ended="stopped"), run(MOVE, ended="steps")) is None
    assert difference(run(MOVE, ended="stopped"), run(MOVE, MOVE, ended="steps")) is not None
    assert difference(run(MOVE, ended="stopped"), run(MOVE)) is not None
    assert difference(run(MOVE, MOVE, ended="steps"), run(MOVE, ended="steps")) is None
    for ended in ("end", "stopped", "error"):
        assert difference(run(MOVE, MOVE, ended="steps"), run(MOVE, ended=ended)) is not None
        assert difference(run(MOVE, ended=ended), run(MOVE, MOVE, ended="unknown")) is not None
    assert difference(run(MOVE, ended="steps"), run(MOVE, MOVE)) is None
    halts = run(MOVE, Stopped(), Stopped(), Stopped(), ended="steps")
    assert difference(run(MOVE, Stopped(end=True)), halts) is None
    assert difference(run(Stopped(end=True)), halts) is not None
    assert difference(run(MOVE, Stopped(end=True)), run(MOVE)) is not None


def test_messages_for_people_are_no_difference() -> None:
    assert difference(run(MOVE, Reported("error", "a"), Said("b")), run(MOVE)) is None


def test_far_away_places_are_as_exact_as_single_precision() -> None:
    far = replace(MOVE, flange=Pose((9.0e9, 0.0, 300.0)))
    assert difference(run(far), run(replace(MOVE, flange=Pose((9.0e9 + 500, 0.0, 300.0))))) is None
    assert difference(run(far), run(replace(MOVE, flange=Pose((9.0e9 + 9e4, 0.0, 300.0)))))


def test_single_precision_of_a_target_and_of_its_turn_is_no_difference() -> None:
    """RAPID holds both in single precision, whatever its text prints."""
    prints = Rounding(value=6e-5, angle=1e-6, joint=6e-5)
    rng = np.random.default_rng(7)
    for _ in range(200):
        turn = rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        place = rng.uniform(-900.0, 900.0, 3)
        exact = replace(MOVE, flange=Pose.of(place, turn))
        held = Pose.of(place.astype(np.float32), turn.astype(np.float32))
        moved = Pose((0.0, 0.0, -100.0))
        assert exact.flange is not None
        pairs = (exact.flange, held), (exact.flange @ moved, held @ moved)
        for one, two in pairs:
            ours, theirs = replace(MOVE, flange=one), replace(MOVE, flange=two)
            assert difference(run(ours), run(theirs), rounding=prints) is None
