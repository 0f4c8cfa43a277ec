"""Times of moves, against numbers worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.program.motion import FINE, Blend, Kind, Path, Speed
from assistant.program.program import Procedure, Program
from assistant.program.pseudo import parse
from assistant.program.statements import Follow
from assistant.robots.arms import Serial
from assistant.robots.timing import Drive, Simulation, drive_of, simulate
from tests.examples import drawn

ARM = robots.get("irb1200-7-0.7")
DOWN = [0.0, 0.0, 1.0, 0.0]
LOOSE = Drive(ARM.speeds * 1e3, ARM.speeds * 1e6, math.inf, math.inf)
"""Axes that bind nothing."""
HEAD = """program p

target a [300, -500, 400] [0, 0, 1, 0]
target b [300, 500, 400] [0, 0, 1, 0]
target c [300, -460, 400] [0, 0, 1, 0]
target d [300, -500, 300] [0, 0, 1, 0]
target o [400, 0, 400] [0, 0, 1, 0]
target turned [400, 0, 400] [0, 0.7071067811865476, 0.7071067811865476, 0]
target left [0, 400, 400] [0, 0, 1, 0]
target middle [282.842712474619, 282.842712474619, 400] [0, 0, 1, 0]
joints zero [0, 0, 0, 0, 30, 0]
joints there [90, 30, 0, 0, 30, 0]

procedure main
"""


def run(*moves: str, **options: object) -> Simulation:
    text = HEAD + "".join(f"  {move}\n" for move in moves) + "end\n"
    return simulate(robots.solve_program(parse(text), ARM), **options)  # type: ignore[arg-type]


def last(simulation: Simulation) -> float:
    return float(simulation.moves.seconds[-1])


def test_a_metre_is_speed_up_cruise_and_slow_down() -> None:
    done = run(
        "move joint a speed maximum blend fine",
        "move linear b speed 100 mm/s blend fine",
        acceleration=500.0,
    )
    assert last(done) == pytest.approx(1000 / 100 + 100 / 500, abs=1e-6)
    assert done.moves.length[-1] == pytest.approx(1000)
    assert done.bound_by(done.moves.binds[-1]) == "speed"


def test_a_short_move_never_reaches_its_speed() -> None:
    done = run(
        "move joint a speed maximum blend fine",
        "move linear c speed 1000 mm/s blend fine",
        acceleration=1000.0,
    )
    assert last(done) == pytest.approx(2 * math.sqrt(40 / 1000), abs=1e-6)
    assert done.bound_by(done.moves.binds[-1]) == "acceleration"


def test_a_turn_on_the_spot_takes_the_speed_of_reorientation() -> None:
    done = run(
        "move joint o speed maximum blend fine",
        "move linear turned speed 1000 mm/s rotation 30 deg/s blend fine",
    )
    # Only J6 turns, whose 600 deg/s take 0.032 s.
    assert last(done) == pytest.approx(90 / 30 + 30 / 600 * 0.032, abs=1e-6)
    assert done.moves.turn[-1] == pytest.approx(90)
    assert done.bound_by(done.moves.binds[-1]) == "reorientation"


def test_an_axis_bounds_a_circle_about_it() -> None:
    slow = Drive(np.where(np.arange(6) == 0, 10.0, 1e5), LOOSE.accelerations, math.inf, math.inf)
    moves = (
        "move joint o speed maximum blend fine",
        "move circular via middle to left speed 5000 mm/s rotation 1000000 deg/s blend fine",
    )
    done = run(*moves, drive=slow)
    arc = done.moves.kind == Kind.VIA
    both = done.moves.seconds[arc | (done.moves.kind == Kind.END)].sum()
    assert both == pytest.approx(90 / 10, rel=1e-3)
    assert done.bound_by(done.moves.binds[-1]) == "J1"
    assert done.moves.length[1:].sum() == pytest.approx(400 * math.pi / 2)
    faster = run(*moves, drive=replace(slow, speeds=slow.speeds * 3))
    assert faster.moves.seconds[1:].sum() == pytest.approx(both / 3, rel=1e-3)


def test_axes_arrive_together_at_their_percentage() -> None:
    done = run(
        "move absolute zero speed 100 mm/s joint 50 % blend fine",
        "move absolute there speed 100 mm/s joint 10 % blend fine",
    )
    # J1: 90 degrees at 28.8 deg/s, accelerated to 288 deg/s within 0.032 s.
    assert last(done) == pytest.approx(90 / 28.8 + 0.1 * 0.032, abs=1e-6)
    assert done.bound_by(done.moves.binds[-1]) == "percent"
    velocity = done.samples.joint_velocity[-150]
    assert velocity[0] == pytest.approx(28.8) and velocity[1] == pytest.approx(28.8 / 3)


def test_a_joint_move_in_mm_per_second_is_never_faster_than_that() -> None:
    done = run("move absolute there speed 200 mm/s blend fine")
    assert done.samples.tcp_speed.max() == pytest.approx(200, rel=0.001)
    assert last(done) > done.moves.length[-1] / 200
    assert run("move absolute there speed maximum blend fine").samples.tcp_speed.max() > 500


def test_a_corner_is_passed_as_its_zone_and_the_acceleration_allow() -> None:
    moves = (
        "move joint c speed maximum blend fine",
        "move linear a speed 1000 mm/s blend 10 mm",
        "move linear d speed 1000 mm/s blend fine",
    )
    a, v = 1000.0, math.sqrt(2 * 10 * 1000 / math.sqrt(2))
    expected = 2 * 10 / v  # along a parabola of one acceleration
    for length in (30.0, 90.0):
        peak = math.sqrt(a * length + v * v / 2)
        expected += (2 * peak - v) / a
    done = run(*moves, acceleration=a)
    assert done.moves.seconds[1:].sum() == pytest.approx(expected, rel=1e-3)
    stopped = run(*(move.replace("10 mm", "fine") for move in moves), acceleration=a)
    by_hand = 2 * math.sqrt(0.04) + 2 * math.sqrt(0.1)
    assert stopped.moves.seconds[1:].sum() == pytest.approx(by_hand, abs=1e-6)
    wide = run(*(move.replace("10 mm", "500 mm") for move in moves), acceleration=a)
    half = math.sqrt(2 * 20 * 1000 / math.sqrt(2))
    at = np.linalg.norm(wide.samples.position - [300, -500, 400], axis=1)
    inside = wide.samples.tcp_speed[(at < 20) & (wide.samples.t > 0.5)]
    assert inside.max() == pytest.approx(half, rel=0.05), "a zone ends half way"
    assert inside.min() == pytest.approx(half / math.sqrt(2), rel=0.02), "in its middle"


def test_override_and_acceleration_of_the_program_count() -> None:
    done = run(
        "move joint a speed maximum blend fine",
        "override 50 %",
        "acceleration 20 % deceleration 40 %",
        "move linear b speed 200 mm/s blend fine",
        acceleration=500.0,
    )
    up, down = 100 / 100, 100 / 200
    assert last(done) == pytest.approx(up + down + (1000 - 50 * up - 50 * down) / 100, abs=1e-6)


def test_the_speed_of_the_robot_bounds_lines() -> None:
    known = replace(LOOSE, tcp_speed=100.0)
    done = run(
        "move joint a speed maximum blend fine",
        "move linear b speed maximum blend fine",
        drive=known,
        acceleration=None,
    )
    assert last(done) == pytest.approx(10.0, rel=0.01)
    assert done.bound_by(done.moves.binds[-1]) == "speed of the robot"


def test_another_tool_does_not_make_a_way() -> None:
    text = HEAD.replace("target a", "tool long tip [0, 0, 100]\n\ntarget a", 1) + (
        "  move joint o speed maximum blend fine tool long\n"
        "  move linear target [400, 0, 500] [0, 0, 1, 0] speed 100 mm/s blend fine\nend\n"
    )
    done = simulate(robots.solve_program(parse(text), ARM))
    assert len(done.moves) == 2
    assert done.moves.length[-1] == pytest.approx(0.0, abs=1e-6)
    assert last(done) == pytest.approx(0.0, abs=1e-6)


def test_accelerations_are_those_of_the_catalogue_where_it_has_them() -> None:
    known = robots.get("rv-4frl")
    assert known.accelerations is not None
    assert np.array_equal(drive_of(known).accelerations, known.accelerations)
    assert ARM.accelerations is None
    assert np.allclose(drive_of(ARM).accelerations * 0.1, ARM.speeds)


POINTS = st.lists(
    st.tuples(st.floats(300, 450), st.floats(-300, 300), st.floats(200, 500)),
    min_size=2,
    max_size=6,
)


def along(points: list[tuple[float, float, float]], speed: float, blend: Blend) -> Simulation:
    path = Path.of("way", points, [DOWN] * len(points), speeds=[Speed(speed)], blends=[blend])
    program = Program("p", (Procedure("main", (Follow(path),)),))
    return simulate(robots.solve_program(program, ARM))


@settings(max_examples=drawn(40), deadline=None)
@given(POINTS, st.floats(5, 2000), st.floats(1.01, 5), st.sampled_from([FINE, Blend(5.0)]))
def test_no_move_is_faster_than_its_speed_nor_slower_for_more(
    points: list[tuple[float, float, float]], speed: float, more: float, blend: Blend
) -> None:
    slow, fast = along(points, speed, blend), along(points, speed * more, blend)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert (slow.moves.length[1:] <= lengths + 1e-6).all()
    assert blend is not FINE or np.allclose(slow.moves.length[1:], lengths, atol=1e-6)
    assert (slow.moves.seconds >= slow.moves.length / speed - 1e-9).all()
    assert fast.seconds <= slow.seconds + 1e-9
    assert along(points, speed, FINE).seconds >= slow.seconds - 1e-9


@settings(max_examples=drawn(20), deadline=None)
@given(POINTS, st.floats(50, 5000))
def test_no_axis_passes_its_speed(points: list[tuple[float, float, float]], speed: float) -> None:
    done = along(points, speed, Blend(10.0))
    turned = np.abs(done.samples.joint_velocity)
    assert (turned <= ARM.speeds * (1 + 1e-9)).all()


def test_a_path_of_columns_takes_as_long_as_its_moves() -> None:
    turn = np.linspace(0, 20 * np.pi, 20001)
    points = np.stack([450 + 80 * np.cos(turn), 80 * np.sin(turn), 300 + turn], axis=1)
    done = along(points.tolist(), 100.0, Blend(1.0))
    assert len(done.moves) == 20001
    way = done.moves.length[1:].sum()
    assert done.moves.seconds[1:].sum() == pytest.approx(way / 100, rel=0.01)


def test_a_chain_of_links_takes_as_long_as_its_closed_form() -> None:
    home = np.array([-40.0, 20.0, 10.0, 0.0, 60.0, -40.0])
    known = replace(ARM, home=home)
    chain = Serial.of_links(known.arm.links(), np.radians(known.limits + known.zero[:, None]))
    position, quaternion = known.fk(home)
    ways = np.array([[0.0, 0, 0], [0, 300, 40], [40, 350, 0], [80, 300, 0], [0, 0, 0]])
    kinds = np.array([Kind.JOINT, Kind.LINEAR, Kind.VIA, Kind.END, Kind.LINEAR])
    path = Path.of(
        "way", position + ways, np.repeat(quaternion, 5, 0), kinds=kinds, speeds=[Speed(1000.0)]
    )
    program = Program("p", (Procedure("main", (Follow(path),)),))
    one, other = (
        simulate(robots.solve_program(program, arm)) for arm in (known, replace(known, arm=chain))
    )
    assert other.unknown == one.unknown == ()
    assert other.moves.seconds == pytest.approx(one.moves.seconds, rel=1e-4, abs=1e-9)
    assert other.samples.joints == pytest.approx(one.samples.joints, abs=0.01)


def test_an_arc_within_reach_is_gone_along_by_the_arm_too() -> None:
    angles = np.radians([230, 240, 130])
    circle = [[500 + 150 * math.cos(a), 150 * math.sin(a), 300] for a in angles]
    way = [[400, -150, 300], *circle, [400, 150, 300], [400, 150, 400]]
    kinds = [Kind.JOINT, Kind.LINEAR, Kind.VIA, Kind.END, Kind.LINEAR, Kind.LINEAR]
    path = Path.of("way", way, [DOWN] * 6, kinds=kinds, speeds=[Speed(100.0)])
    program = Program("p", (Procedure("main", (Follow(path),)),))
    done = simulate(robots.solve_program(program, ARM))
    assert done.unknown == ()
    tip, _ = ARM.fk(done.samples.joints)
    assert tip == pytest.approx(done.samples.position, abs=0.1)


def test_a_computed_way_out_of_reach_is_told_of_and_spoils_no_other() -> None:
    arrays = (
        "constant places position[2] = [target [-400, 30, 300] [0, 0, 1, 0], "
        "target [-400, 30, 400] [0, 0, 1, 0]]\nvariable at number = 1\n\nprocedure main\n"
    )
    text = HEAD.replace("target o [400, 0, 400]", "target o [400, 30, 300]")
    text = text.replace("procedure main\n", arrays) + (
        "  move joint o speed maximum blend fine\n"
        "  at = 1\n  move linear places[at] speed 100 mm/s blend fine\n"
        "  move linear places[2] speed 100 mm/s blend fine\nend\n"
    )
    done = simulate(robots.solve_program(parse(text), ARM))
    assert [one.what.partition(":")[0] for one in done.unknown] == ["move 2"]
    assert "one branch" in done.unknown[0].what
    tip, _ = ARM.fk(done.samples.joints)
    times = np.cumsum(done.moves.seconds)
    across = (done.samples.t > times[0]) & (done.samples.t < times[1])
    apart = np.abs(tip - done.samples.position).max(axis=1)
    assert apart[~across].max() < 0.1
    assert apart[across].max() > 1.0
