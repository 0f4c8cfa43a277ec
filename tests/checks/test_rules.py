"""What no controller can run is found before a program is written."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from assistant.checks import check
from assistant.program.expressions import Name, TargetValue
from assistant.program.geometry import Pose, Target
from assistant.program.motion import FINE, MAXIMUM_SPEED, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.statements import Branch, Follow, If, Motion, Move, MoveCircular, Statement

MOTION = Motion(Speed(100.0), FINE)


def at(x: float, y: float, z: float = 0.0) -> TargetValue:
    return TargetValue(Target(Pose((x, y, z))))


def codes(*body: Statement, **parts) -> list[str]:
    program = Program("p", (Procedure("main", body),), **parts)
    return [finding.code for finding in check(program)]


def arc(*points: tuple[float, float]) -> tuple[Statement, Statement]:
    start, via, end = (at(*point) for point in points)
    return Move("linear", start, MOTION), MoveCircular(via, end, MOTION)


def arc_path(*points: tuple[float, float]) -> Path:
    positions = [(x, y, 0.0) for x, y in points]
    kinds = [Kind.LINEAR, Kind.VIA, Kind.END]
    return Path.of("seam", positions, [[1, 0, 0, 0]] * 3, kinds=kinds, speeds=[Speed(50.0)])


ARCS = {
    "a quarter": ([(0, 0), (7, 3), (10, 10)], []),
    "all the same": ([(5, 5), (5, 5), (5, 5)], ["CK101"]),
    "via at the end": ([(0, 0), (10, 0), (10, 0)], ["CK101"]),
    "via at the start": ([(0, 0), (0, 0.05), (10, 0)], ["CK101"]),
    "a full circle": ([(0, 0), (10, 10), (0, 0)], ["CK101"]),
    "on one line": ([(0, 0), (5, 0), (10, 0)], ["CK102"]),
    "on one line, via beyond": ([(0, 0), (15, 0), (10, 0)], ["CK102"]),
    "nearly on one line": ([(0, 0), (5, 0.0005), (10, 0)], ["CK102"]),
    "flat but round": ([(0, 0), (5, 0.01), (10, 0)], ["CK103"]),
    "as flat as may be": ([(0, 0), (5, 0.1), (10, 0)], []),
    "three quarters": ([(10, 0), (-10, 0), (0, -10)], ["CK104"]),
    "two thirds": ([(10, 0), (-10, 0), (-5.1, -8.6)], []),
}


@pytest.mark.parametrize("name", ARCS)
def test_arcs_of_moves(name):
    points, expected = ARCS[name]
    assert codes(*arc(*points)) == expected


@pytest.mark.parametrize("name", ARCS)
def test_arcs_of_paths(name):
    points, expected = ARCS[name]
    assert codes(Follow(arc_path(*points))) == expected


def test_an_arc_that_starts_a_path_starts_where_the_move_before_ended():
    path = arc_path((0, 0), (5, 0), (10, 0)).rows(1, 3)
    assert codes(Move("linear", at(0, 0), MOTION), Follow(path)) == ["CK102"]
    assert codes(Move("linear", at(0, 5), MOTION), Follow(path)) == []
    assert codes(Follow(path)) == []


def test_named_targets_count_and_unknown_starts_do_not():
    _, move = arc((0, 0), (5, 0), (10, 0))
    assert codes(move) == []
    start = Move("linear", Name("a"), MOTION)
    assert codes(start, move, targets={"a": Target(Pose())}) == ["CK102"]
    assert codes(start, move) == []


def test_after_a_branch_the_start_is_not_known_but_inside_it_is():
    begin, move = arc((0, 0), (5, 0), (10, 0))
    branch = If((Branch(Name("go"), (begin, move)),))
    assert codes(branch) == ["CK102"]
    assert codes(begin, If((Branch(Name("go"), (Move("joint", at(1, 1), MOTION),)),)), move) == []


@given(st.floats(0.5, 100), st.floats(5, 350), st.floats(0.2, 0.8))
def test_arcs_of_circles_are_fine(radius, sweep, part):
    def on(degrees: float) -> tuple[float, float]:
        turn = math.radians(degrees)
        return radius * math.cos(turn), radius * math.sin(turn)

    points = [on(0), on(part * sweep), on(sweep)]
    apart = min(math.dist(a, b) for a, b in ((points[0], points[1]), points[1:], points[::2]))
    height = radius * (1 - math.cos(math.radians(min(part, 1 - part) * sweep) / 2))
    if apart > 0.2 and height > 0.01:
        found = codes(*arc(*points))
        assert "CK101" not in found and "CK102" not in found
        assume(abs(sweep - 240.0) > 1e-6)
        assert ("CK104" in found) == (sweep > 240.0)
        from_start = (1 - part) * sweep / 2
        assume(abs(from_start - 1.0) > 1e-6)
        assert ("CK103" in found) == (from_start < 1.0)


def test_flat_arcs_of_a_path_are_told_of_together():
    points = [(0, 0)]
    for at in range(5):
        points += [(10 * at + 5, 0.01 + 0.001 * at), (10 * at + 10, 0)]
    positions = [(x, y, 0.0) for x, y in points]
    kinds = [Kind.LINEAR, *[Kind.VIA, Kind.END] * 5]
    quaternions = [[1, 0, 0, 0]] * len(positions)
    path = Path.of("seam", positions, quaternions, kinds=kinds, speeds=[Speed(50.0)])
    (finding,) = check(Program("p", (Procedure("main", (Follow(path),)),)))
    assert (finding.code, finding.place) == ("CK103", "path seam row 2 and 4 more")


@pytest.mark.parametrize("speed", [0.0, -1.0, 1e-9, 0.001, 1e9])
def test_speeds_that_nobody_means(speed):
    motion = Motion(Speed(speed), FINE)
    assert codes(Move("linear", at(0, 0), motion)) == ["CK201"]
    path = Path.of("p", [[0, 0, 0]], [[1, 0, 0, 0]], speeds=[Speed(speed)])
    assert codes(Follow(path)) == ["CK201"]


@pytest.mark.parametrize("radius", [1e-9, 0.0001, -1.0, 1e6])
def test_corner_radii_that_nobody_means(radius):
    assert codes(Move("linear", at(0, 0), Motion(Speed(100.0), Blend(radius)))) == ["CK202"]
    assert codes(blends={"b": Blend(1.0, radius)}) == ["CK202"]


def test_usual_speeds_and_radii_are_fine():
    motions = [Motion(s, b) for s in (Speed(0.01), MAXIMUM_SPEED) for b in (FINE, Blend(0.3))]
    motions.append(Motion(Name("v_glue"), Blend(math.inf)))
    assert codes(*(Move("linear", at(0, 0), motion) for motion in motions)) == []
