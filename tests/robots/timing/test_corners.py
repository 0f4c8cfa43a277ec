"""Corners that are cut, against curves worked out by brute force: way, speed, acceleration."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse
from assistant.program.statements import Follow
from assistant.robots.timing import Drive, Simulation, drive_of, simulate
from tests.examples import drawn

ARM = robots.get("irb1200-7-0.7")
LOOSE = Drive(ARM.speeds * 1e3, ARM.speeds * 1e6, math.inf, math.inf)
DOWN = [0.0, 0.0, 1.0, 0.0]
LINE, VIA, END = Kind.LINEAR, Kind.VIA, Kind.END


def along(
    points: object, blend: Blend, speed: float = 500.0, *, kinds: object = None, **options: object
) -> Simulation:
    """A way of lines that starts where a joint move stops; of other kinds if they are given."""
    points = np.array(points, dtype=float)
    kinds = [LINE] * (len(points) - 1) if kinds is None else kinds
    path = Path.of(
        "way",
        np.concatenate([points[:1], points[:1], points[1:]]),
        [DOWN] * (len(points) + 1),
        kinds=np.array([Kind.JOINT, Kind.LINEAR, *kinds]),  # type: ignore[misc]
        speeds=[Speed(speed)],
        blends=[FINE, blend],
        blend=np.array([0, 0] + [1] * (len(points) - 1)),
    )
    program = Program("p", (Procedure("main", (Follow(path),)),))
    return simulate(robots.solve_program(program, ARM), **options)  # type: ignore[arg-type]


def seconds(simulation: Simulation) -> float:
    """Without the joint move to the start."""
    return float(simulation.moves.seconds[1:].sum())


def behind_start(simulation: Simulation) -> np.ndarray:
    return simulation.samples.t > simulation.moves.seconds[0] + 1e-9


def parabola(
    start: object, corner: object, end: object, zone: float, n: int = 10_001
) -> np.ndarray:
    """(n, 3) evenly in the parameter, from the border of the zone to the other."""
    a, c, b = (np.array(one, dtype=float) for one in (start, corner, end))
    first = c + zone * (a - c) / np.linalg.norm(a - c)
    last = c + zone * (b - c) / np.linalg.norm(b - c)
    u = np.linspace(0.0, 1.0, n)[:, None]
    return np.asarray((1 - u) ** 2 * first + 2 * u * (1 - u) * c + u**2 * last)


def length(curve: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())


A, C, B = (400.0, -150.0, 300.0), (400.0, 50.0, 300.0), (400.0, 50.0, 420.0)
SHARP = (440.0, -100.0, 340.0)


@pytest.mark.parametrize("zone", [0.02, 0.3, 1.0, 5.0, 25.0, 60.0])
@pytest.mark.parametrize("end", [B, SHARP, A])
def test_the_way_is_shorter_by_the_corner(zone: float, end: tuple[float, ...]) -> None:
    done = along([A, C, end], Blend(zone))
    curve = parabola(A, C, end, zone)
    sides = [math.dist(A, C), math.dist(C, end)]
    assert done.moves.length[2:].sum() == pytest.approx(
        sum(sides) - 2 * zone + length(curve), abs=2e-3
    )
    assert (done.moves.length[2:] < np.array(sides)).all()


def test_a_zone_ends_half_way() -> None:
    wide, half = (along([A, C, B], Blend(zone)) for zone in (1000.0, 60.0))
    assert seconds(wide) == pytest.approx(seconds(half), rel=1e-9)
    assert np.allclose(wide.moves.length, half.moves.length)


@pytest.mark.parametrize("zone", [0.5, 10.0, 60.0])
def test_the_tool_goes_along_the_lines_and_the_parabola(zone: float) -> None:
    done = along([A, C, B], Blend(zone), period=0.001)
    curve = parabola(A, C, B, zone, 4001)
    at = done.samples.position[behind_start(done)]
    near = np.linalg.norm(at - C, axis=1) < zone * 0.999
    assert np.count_nonzero(near) >= 2
    off = np.linalg.norm(at[near][:, None] - curve[None], axis=2).min(axis=1)
    assert off.max() < 0.02
    y, z = np.clip(at[~near][:, 1], -150, 50), np.clip(at[~near][:, 2], 300, 420)
    lines = np.minimum(np.abs(at[~near][:, 2] - 300) + (at[~near][:, 1] - y) ** 2,
                       np.abs(at[~near][:, 1] - 50) + (at[~near][:, 2] - z) ** 2)  # fmt: skip
    assert lines.max() < 1e-3
    least = np.linalg.norm(curve - C, axis=1).min()
    assert np.linalg.norm(at - C, axis=1).min() >= least - 1e-3
    tip, _ = ARM.fk(done.samples.joints)
    assert np.abs(tip - done.samples.position).max() < 0.15


def test_the_corner_of_an_arc_overlaps_both_ways() -> None:
    centre, radius, zone = np.array([400.0, 0.0, 300.0]), 100.0, 30.0
    angles = np.radians([-90.0, 0.0, 90.0])
    start, via, end = centre + radius * np.stack(
        [np.cos(angles), np.sin(angles), 0 * angles], axis=1
    )
    begin = start - [120.0, 0.0, 0.0]
    done = along([begin, start, via, end], Blend(zone), kinds=[LINE, VIA, END], period=0.001)
    u = np.linspace(0.0, 1.0, 4001)
    line = start - np.outer(zone * (1 - u) ** 2, [1.0, 0.0, 0.0])
    turn = np.radians(-90.0) + zone * u**2 / radius
    arc = centre + radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    curve = line + arc - start
    at = done.samples.position[behind_start(done)]
    some = at[np.linalg.norm(at - start, axis=1) < 20.0]
    assert len(some) > 10
    assert np.linalg.norm(some[:, None] - curve[None], axis=2).min(axis=1).max() < 0.05


def test_a_corner_at_its_speed_takes_the_way_by_the_speed() -> None:
    """With axes that bind nothing the tool goes at what is programmed all the time."""
    for zone in (0.0, 5.0, 50.0):
        done = along([A, C, B], Blend(zone) if zone else FINE, 100.0, drive=LOOSE)
        curve = length(parabola(A, C, B, zone)) if zone else 0.0
        way = math.dist(A, C) + math.dist(C, B) - 2 * zone + curve
        assert way / 100.0 <= seconds(done) <= way / 100.0 * 1.006 + 0.002


def test_joint_moves_overlap() -> None:
    text = """program p

joints zero [0, 0, 0, 0, 30, 0]
joints one [40, 0, 0, 0, 30, 0]
joints two [40, 0, 40, 0, 30, 0]

procedure main
  move absolute zero speed maximum rotation 100000 deg/s blend fine
  move absolute one speed maximum rotation 100000 deg/s blend ZONE
  move absolute two speed maximum rotation 100000 deg/s blend fine
end
"""
    journeys = (
        robots.solve_program(parse(text.replace("ZONE", zone)), ARM) for zone in ("fine", "80 mm")
    )
    stopped, rounded = (simulate(solution, period=0.0005) for solution in journeys)
    assert rounded.seconds < stopped.seconds - 0.01
    velocity = np.abs(rounded.samples.joint_velocity)
    both = (velocity[:, 0] > 1.0) & (velocity[:, 2] > 1.0)
    assert np.count_nonzero(both) > 10
    for axis, (begin, end) in ((0, (0, -1)), (2, (-1, 0))):
        turning = velocity[both][:, axis]
        assert turning[begin] > 10.0 * turning[end]
    other = np.abs(stopped.samples.joint_velocity)
    assert not ((other[:, 0] > 1.0) & (other[:, 2] > 1.0)).any()
    # In the corner the joints are on a parabola: 40 degrees are the length of either move.
    j1, j3 = rounded.samples.joints[both][:, 0], rounded.samples.joints[both][:, 2]
    at = stopped.moves.length[1:]
    part = [80.0 / one * 40.0 for one in at]
    u = np.sqrt(np.clip(j3 / part[1], 0.0, 1.0))
    assert np.abs(j1 - (40.0 - part[0] * (1.0 - u) ** 2)).max() < 0.1


def test_a_corner_with_another_tool_keeps_the_joints_smooth() -> None:
    text = """program p

tool long tip [0, 0, 100]

procedure main
  move joint target [400, -100, 400] [0, 0, 1, 0] speed maximum blend fine
  move linear target [400, 0, 400] [0, 0, 1, 0] speed 300 mm/s blend 20 mm
  move linear target [400, 0, 200] [0, 0, 1, 0] speed 300 mm/s blend fine tool long
end
"""
    done = simulate(robots.solve_program(parse(text), ARM), period=0.0005)
    limits = drive_of(ARM, load=None).accelerations
    change = np.diff(done.samples.joints, n=2, axis=0) / 0.0005**2
    assert (np.abs(change) <= limits * 1.001).all()


COORDINATES = st.tuples(st.floats(320, 450), st.floats(-250, 250), st.floats(200, 450))
WAYS = st.lists(COORDINATES, min_size=3, max_size=6)
SPEEDS = st.floats(20, 5000)
ZONES = st.floats(0.05, 150)


THERE_AND_BACK = [(320.0, 0.0, 200.0), *[(321.0, 0.0, 200.0)] * 2, (320.0, 0.0, 200.0)]


@settings(max_examples=drawn(25), deadline=None)
@example(THERE_AND_BACK, 20.0, 1.0, 2.0, None)
@given(WAYS, SPEEDS, ZONES, st.floats(1.1, 6), st.sampled_from([None, 500.0, 8000.0]))
def test_a_larger_zone_is_never_slower_and_none_is_quicker_than_its_way(
    points: list[tuple[float, float, float]],
    speed: float,
    zone: float,
    more: float,
    acceleration: float | None,
) -> None:
    stop, some, wide = (
        along(points, blend, speed, acceleration=acceleration)
        for blend in (FINE, Blend(zone), Blend(zone * more))
    )
    assert seconds(some) <= seconds(stop) * (1 + 1e-4)
    assert seconds(wide) <= seconds(some) * (1 + 1e-4)
    # A move to where the arm is already is no side of a corner.
    points = [points[0], *(b for a, b in pairwise(points) if b != a)]
    sides = np.linalg.norm(np.diff(points, axis=0), axis=1)
    for done, reach in ((some, zone), (wide, zone * more)):
        zones = np.minimum(reach, np.minimum(sides[:-1], sides[1:]) / 2.0)
        way = sides.sum()
        for i in np.flatnonzero(zones > 1e-3):
            curve = parabola(points[i], points[i + 1], points[i + 2], zones[i], 2001)
            way -= 2 * zones[i] - length(curve)
        assert seconds(done) >= way / speed * (1 - 1e-4) - 1e-6


@settings(max_examples=drawn(15), deadline=None)
@example(THERE_AND_BACK, 20.0, 0.05)
@given(WAYS, SPEEDS, st.sampled_from([0.05, 0.5, 4.0, 20.0, 150.0]))
def test_nothing_passes_its_bounds_in_a_corner(
    points: list[tuple[float, float, float]], speed: float, zone: float
) -> None:
    tool = 4000.0
    total = along(points, Blend(zone), speed, acceleration=tool).seconds
    period = max(total / 20_000, 1e-5)
    done = along(points, Blend(zone), speed, acceleration=tool, period=period)
    samples, drive = done.samples, drive_of(ARM, load=0.0)
    assert (samples.tcp_speed[behind_start(done)] <= speed * (1 + 1e-6)).all()
    velocity = np.diff(samples.joints, axis=0) / period
    assert (np.abs(velocity) <= ARM.speeds * (1 + 1e-6) + 1e-6).all()
    change = np.diff(velocity, axis=0) / period
    assert (np.abs(change) <= drive.accelerations * (1 + 1e-3) + 1e-12 / period**2).all()
    lines = samples.position[behind_start(done)][2:]
    if len(lines) > 2:
        change = np.diff(lines, n=2, axis=0) / period**2
        assert np.linalg.norm(change, axis=1).max() <= tool * 1.001 + 1e-12 / period**2
