"""The track of a program: what its tool goes through, and the pictures of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from assistant.program.expressions import Apply, Binary, Name, Number, TargetValue, Unary
from assistant.program.geometry import Frame, Pose, Target
from assistant.program.motion import FINE, Kind, Path, Speed
from assistant.program.program import Procedure, Program, Variable
from assistant.program.statements import Call, Follow, Motion, Move, MoveCircular
from assistant.report import figures
from assistant.report.track import arc_points, stops, track

MOTION = Motion(Speed(100.0), FINE)
ON_TABLE = Motion(Speed(100.0), FINE, frame="table")


def at(x: float, y: float, z: float = 0.0) -> TargetValue:
    return TargetValue(Target(Pose((x, y, z))))


def program(*body, **parts) -> Program:
    return Program("p", (Procedure("main", tuple(body)),), **parts)


def test_moves_follow_each_other_through_calls():
    inner = Procedure("inner", (Move("linear", at(10, 0), MOTION),))
    whole = program(
        Move("joint", Name("home"), MOTION),
        Call("inner"),
        Move("linear", at(10, 5), MOTION),
        targets={"home": Target(Pose((0.0, 0.0, 0.0)))},
    )
    whole = Program("p", (*whole.procedures, inner), targets=whole.targets)
    way = track(whole)
    assert way.positions.tolist() == [[0, 0, 0], [10, 0, 0], [10, 5, 0]]
    assert way.kinds.tolist() == [Kind.JOINT, Kind.LINEAR, Kind.LINEAR]
    assert way.names == {0: "home"}
    assert way.lengths().tolist() == [0, 10, 15]


def test_moves_to_places_beside_a_target_are_drawn():
    down = Target(Pose((100.0, 0.0, 50.0), (0.0, 0.0, 1.0, 0.0)))
    above = Apply("relative", (Name("Part"), Number(0), Number(0), Unary("-", Name("height"))))
    beside = Apply("offset", (Name("part"), Number(0), Binary("+", Number(2), Number(3))))
    unknown = Apply("offset", (Name("part"), Name("count")))
    way = track(
        program(
            *(Move("linear", where, MOTION) for where in (above, Name("part"), unknown)),
            MoveCircular(beside, above, MOTION),
            targets={"part": down},
            variables={
                "height": Variable("number", Number(30), storage="constant"),
                "count": Variable("number", Number(1)),
            },
        )
    )
    np.testing.assert_allclose(way.positions[:2], [[100, 0, 80], [100, 0, 50]], atol=1e-9)
    np.testing.assert_allclose(way.positions[-1], [100, 0, 80], atol=1e-9)
    assert np.min(np.linalg.norm(way.positions - [100, 5, 50], axis=1)) < 1.0
    assert way.names == {1: "part"}


def test_frames_are_applied_to_moves_and_paths():
    table = Frame(Pose((100.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))  # half a turn about z
    path = Path.of(
        "seam", [[1, 0, 0], [0, 2, 0]], [[1, 0, 0, 0]] * 2, speeds=[Speed(1.0)], frames=["table"]
    )
    way = track(program(Move("linear", at(5, 0), ON_TABLE), Follow(path), frames={"table": table}))
    np.testing.assert_allclose(way.positions, [[95, 0, 0], [99, 0, 0], [100, -2, 0]], atol=1e-12)


def test_arcs_of_moves_and_paths_are_round():
    path = Path.of(
        "half",
        [[0, 10, 0], [-10, 0, 0], [-20, 0, 0]],
        [[1, 0, 0, 0]] * 3,
        kinds=[Kind.VIA, Kind.END, Kind.LINEAR],
        speeds=[Speed(1.0)],
    )
    way = track(program(Move("linear", at(10, 0), MOTION), Follow(path)))
    np.testing.assert_allclose(np.linalg.norm(way.positions[:-1], axis=1), 10.0)
    assert way.positions[:-1, 1].min() >= -1e-9
    other = track(
        program(Move("linear", at(10, 0), MOTION), MoveCircular(at(0, -10), at(-10, 0), MOTION))
    )
    assert other.positions[:, 1].max() <= 1e-9


def test_a_program_that_does_not_move_has_an_empty_track():
    assert len(track(program())) == 0


@given(
    st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(0.5, 100)),
    st.floats(5, 350),
    st.floats(0.1, 0.9),
)
def test_points_of_an_arc_lie_on_its_circle_and_pass_the_via(centre, sweep, part):
    x, y, radius = centre

    def on(degrees: float) -> np.ndarray:
        turn = np.radians(degrees)
        return np.array([x + radius * np.cos(turn), y + radius * np.sin(turn), 7.0])

    points = arc_points(on(0), on(part * sweep), on(sweep))
    offsets = np.linalg.norm(points - [x, y, 7.0], axis=1)
    np.testing.assert_allclose(offsets, radius, rtol=1e-6)
    np.testing.assert_allclose(points[-1], on(sweep), atol=1e-6 * radius)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert length <= np.radians(sweep) * radius


def test_stops_are_numbered_as_findings_number_them():
    ways = program(
        Move("linear", at(1, 0), MOTION),
        MoveCircular(at(2, 0), at(3, 0), MOTION),
        Move("joint", Name("nobody"), MOTION),
        Move("linear", at(4, 0), ON_TABLE),
        frames={"table": Frame(Pose((0.0, 100.0, 0.0)))},
    )
    found = [(one.place, one.numbers, one.positions.tolist()) for one in stops(ways)]
    assert found == [
        (1, (1,), [[1, 0, 0]]),
        (2, (2, 3), [[2, 0, 0], [3, 0, 0]]),
        (4, (5,), [[4, 100, 0]]),
    ]


def test_the_same_track_gives_the_same_picture():
    way = track(program(Move("linear", at(1, 2), MOTION), Move("joint", at(3, 4), MOTION)))
    assert figures.pose_plot(way, "title") == figures.pose_plot(way, "title")


@pytest.mark.slow
def test_an_exchange_is_drawn_without_jumps_between_two_signs_of_one_orientation() -> None:
    seconds, places = np.arange(3.0), np.zeros((3, 3))
    turns = np.array([[0.6, 0.8, 0, 0], [0.6, 0.8, 0, 0], [0.6, 0.8, 0, 0]])
    flipped = turns * [[1], [-1], [1]]
    drawn = figures.exchange_plot(seconds, places, turns, "title")
    assert drawn.startswith(b"\x89PNG")
    assert drawn == figures.exchange_plot(seconds, places, flipped, "title")
    assert b"<svg" in figures.exchange_plot(seconds, places, turns, "title", "svg")
