"""What is reached, against rings and shells in closed form and against trying everything."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Refused
from assistant.cell import link_bodies
from assistant.cell.collision.model import Model
from assistant.cell.planning.space import Space
from assistant.cell.reach_map import (
    ENOUGH_AWAY,
    ENOUGH_CLEAR,
    ENOUGH_LIMITS,
    NumberRange,
    best_postures,
    grid,
    limit_shares,
    parse_directions,
    parse_range,
    reach_map,
)
from assistant.cell.scene import Body, Box, Part, PlacedRobot, Scene, Sphere
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.motion.singularities import distance_from_singularity, jacobian
from assistant.robots.robot_file import read
from tests.cell.gantry import TURN, gantry

SCARA = robots.get("rh-6frh5520")
IRB = robots.get("irb1200-7-0.7")
SHELL = b"""
name = "shell"
title = "Arm without limits"
maker = "nobody"
controller = "none"
languages = []
configuration = "turns"
payload_kg = 5
reach_mm = 700
source = "made for tests"

[lengths_mm]
d1 = 300
a1 = 0
a2 = 400
a3 = 0
d4 = 250
d6 = 80

[axes_deg]
""" + b"\n".join(
    b"J%d = { limits = [-360, 360], speed = 100, zero = 0, home = 10 }" % axis
    for axis in range(1, 7)
)


def alone(robot: robots.Robot, base: Pose = IDENTITY) -> tuple[Scene, PlacedRobot]:
    one = PlacedRobot("arm", robot, base)
    return Scene(robots=(one,)), one


def test_a_scara_reaches_the_ring_that_its_lengths_and_limits_leave():
    """By the law of cosines: the first axis, the second, and a point are a triangle."""
    one, two, most = 325.0, 225.0, (170.0, 145.0)
    points = grid(
        [NumberRange(-600, 600, 23), NumberRange(-600, 600, 29), NumberRange(83, 383, 50)]
    )
    span, line = np.hypot(points[:, 0], points[:, 1]), np.arctan2(points[:, 1], points[:, 0])
    inner = np.sqrt(one**2 + two**2 + 2.0 * one * two * np.cos(np.radians(most[1])))
    ring = (span >= inner) & (span <= one + two)
    cosine = (one**2 + span**2 - two**2) / (2.0 * one * np.maximum(span, 1.0))
    aside = np.arccos(np.clip(cosine, -1.0, 1.0))
    first = np.degrees([line - aside, line + aside])
    first = (first + 180.0) % 360.0 - 180.0
    wanted = ring & (np.abs(first) <= most[0]).any(axis=0)
    wanted &= (points[:, 2] >= 133.0) & (points[:, 2] <= 333.0)
    scene, arm = alone(SCARA)
    found = reach_map(scene, arm, points, parse_directions(["up"], 4), bodies=False)
    assert (found.reached[:, 0] == wanted).all()
    assert np.isinf(found.clearance[wanted]).all()  # nothing is looked at that could be near
    assert 1000 < wanted.sum() < len(wanted) - 1000
    down = reach_map(scene, arm, points[:50], parse_directions(["down"], 4), bodies=False)
    assert not down.reached.any()


@pytest.mark.parametrize("direction", ["down", "1,2,-1", "0,0,1"])
def test_an_arm_without_limits_reaches_a_shell_with_every_direction(direction):
    scene, arm = alone(read(SHELL))
    points = np.random.default_rng(3).uniform([-800, -800, -500], [800, 800, 1100], (2000, 3))
    directions = parse_directions([direction], 3)
    found = reach_map(scene, arm, points, directions, bodies=False)
    wrist = points - 80.0 * directions.axes[0]
    far = np.linalg.norm(wrist - [0, 0, 300], axis=1)
    wanted = (far >= 150.0) & (far <= 650.0)
    sure = np.minimum(np.abs(far - 150.0), np.abs(far - 650.0)) > 1e-3
    assert (found.reached[:, 0] == wanted)[sure].all()
    assert 200 < wanted.sum() < 1800


def test_what_is_in_the_way_takes_away_just_what_is_nearer_than_the_margin():
    """A ball on a gantry, and a box: how far they are apart is plain."""
    ball = Body("ball", (Part(Sphere(20.0)),), parent="gantry.flange")
    wall = Body("wall", (Part(Box((100.0, 200.0, 300.0))),), Pose((50.0, 0.0, 0.0)))
    placed = gantry()
    scene = Scene((ball, wall), (placed,), margin=7.0)
    points = grid(
        [NumberRange(-150, 250, 80), NumberRange(-124, 200, 198), NumberRange(-250, 250, 165)]
    )
    directions = parse_directions(["down"], 1)  # an arm that turns nothing has one orientation
    directions.quaternions[:] = TURN.quaternion
    found = reach_map(scene, placed, points, directions)
    beyond = np.maximum(np.abs(points - [50, 0, 0]) - [50.0, 100.0, 150.0], 0.0)
    clear = np.linalg.norm(beyond, axis=1) - 20.0 - 7.0
    assert (found.reached[:, 0] == (clear > 0.0)).all()
    assert (found.touching[:, 0] == (clear <= 0.0)).all()
    assert found.nearest == {("ball", "wall"): int((clear <= 0.0).sum())}
    reached = clear > 0.0
    wanted = np.minimum(clear[reached], ENOUGH_CLEAR)
    assert np.abs(found.clearance[reached, 0] - wanted).max() < 1e-6
    some = np.flatnonzero(clear < 0.0)
    without = reach_map(scene, placed, points[some], directions, margin=0.0)
    assert (without.reached[:, 0] == (clear[some] > -7.0)).all()
    assert without.reached.any()


def test_base_and_region_moved_together_change_nothing():
    moved = Pose((120.0, -340.0, 55.0), tuple(rotations.from_euler([40.0, 20.0, 10.0])))
    points = np.random.default_rng(1).uniform([200, -400, 100], [700, 400, 700], (200, 3))
    directions = parse_directions(["0.3,0.2,-1"], 6)
    there = rotations.rotate(np.array(moved.quaternion), points) + np.array(moved.position)
    axis = rotations.rotate(np.array(moved.quaternion), directions.axes[0])
    turned = parse_directions([",".join(map(repr, axis.tolist()))], 1)
    turned.quaternions[:] = rotations.multiply(
        np.array(moved.quaternion), directions.quaternions[:, :1]
    )
    scene, arm = alone(IRB)
    one = reach_map(scene, arm, points, parse_directions(["0.3,0.2,-1"], 1), bodies=False)
    other = reach_map(*alone(IRB, moved), there, turned, bodies=False)
    assert (one.reached == other.reached).all()
    assert np.allclose(one.room, other.room, atol=1e-6, equal_nan=True)


@pytest.mark.slow
def test_the_best_way_is_the_best_of_all():
    """Each branch and turn is looked at by itself, with the distances of all its pairs."""
    table = Body("table", (Part(Box((900.0, 900.0, 40.0))),), Pose((700.0, 0.0, 180.0)))
    post = Body("post", (Part(Box((60.0, 60.0, 500.0))),), Pose((430.0, 180.0, 400.0)))
    tool = Body("tool", (Part(Box((30.0, 30.0, 80.0)), Pose((0, 0, 40.0))),), parent="arm.flange")
    placed = link_bodies.place_robot("arm", IRB)
    scene = Scene((table, post, tool), (placed,), allowed=link_bodies.touching_links(placed))
    tip = Pose((10.0, 0.0, 90.0))
    points = np.random.default_rng(5).uniform([250, -250, 210], [650, 350, 600], (30, 3))
    turned = parse_directions(["0.2,0,-1"], 6).quaternions[0]
    found = best_postures(IRB, points, turned, Space(scene, placed, tool=tip), tip)
    model = Model(scene)
    at_world = np.array([item.carrier == 0 for item in model.items])
    outside = at_world[model.one] | at_world[model.other]
    wanted = np.full(len(points), np.nan)
    for n, (point, turn) in enumerate(product(points, turned)):
        place = Pose.of(point, turn) @ tip.inverse()
        joints, valid = IRB.ik([place.position], [place.quaternion])
        for row in joints[0][valid[0]]:
            pairs = np.arange(len(model))
            apart = model.exact(row[None], pairs * 0, pairs) - model.margins
            if apart.min() <= 0.0:
                continue
            room = min(
                1.0,
                float(limit_shares(IRB, row)) / ENOUGH_LIMITS,
                distance_from_singularity(IRB, row[None], tip)[0] / ENOUGH_AWAY,
                apart[outside].min() / ENOUGH_CLEAR,
            )
            wanted[n // 6] = np.nanmax([wanted[n // 6], room])
    assert np.allclose(found.room, wanted, atol=1e-9, equal_nan=True)
    assert (found.reached == np.isfinite(wanted)).all()
    assert 5 < found.reached.sum() < 30
    assert found.touching.any()


def test_the_arm_is_where_the_map_says_it_is():
    tip = Pose((10.0, 5.0, 90.0), tuple(rotations.from_euler([10.0, 20.0, 30.0])))
    points = grid(
        [NumberRange(300, 600, 100), NumberRange(-200, 200, 200), NumberRange(200, 500, 100)]
    )
    directions = parse_directions(["down/40"], 5)
    scene, arm = alone(IRB)
    found = reach_map(scene, arm, points, directions, tip=tip, bodies=False)
    assert found.reached.any()
    for n, d in np.argwhere(found.reached):
        (p,), (q,) = IRB.fk(found.joints[n, d])
        there = Pose.of(p, q) @ tip
        z = rotations.to_matrix(np.array(there.quaternion))[:, 2]
        assert np.abs(np.array(there.position) - points[n]).max() < 1e-4
        assert np.abs(z - directions.axes[d]).max() < 1e-6
        assert IRB.inside(found.joints[n, d])
    assert directions.names == ("down", *(f"down/40@{45 * i}" for i in range(8)))
    tilt = np.degrees(np.arccos(directions.axes[1:] @ [0.0, 0.0, -1.0]))
    assert np.allclose(tilt, 40.0)


# ----------------------------------------------------------------------------- singularities


@pytest.mark.parametrize("name", robots.names())
def test_the_jacobian_is_how_the_tip_moves(name):
    """By moving each joint a little, both ways."""
    robot, tip, small = robots.get(name), Pose((30.0, -20.0, 90.0)), 1e-4
    low, high = np.clip(robot.limits, -170.0, 170.0).T
    rows = np.random.default_rng(2).uniform(low, np.maximum(high, low + 1.0), (20, len(low)))
    found = jacobian(robot, rows, tip)
    for axis in range(rows.shape[1]):
        ends = []
        for sign in (-1.0, 1.0):
            moved = rows.copy()
            moved[:, axis] += sign * small
            p, q = robot.fk(moved)
            ends.append((p + rotations.rotate(q, np.array(tip.position)), q))
        (p, q), (p1, q1) = ends
        step = 2.0 * (small / robot.reach if robot.sliding[axis] else np.radians(small))
        assert np.allclose((p1 - p) / robot.reach / step, found[:, :3, axis], atol=1e-4)
        assert np.allclose(rotations.turns(q, q1) / step, found[:, 3:, axis], atol=1e-4)


def test_a_scara_is_as_far_from_its_singularity_as_its_elbow_is_bent():
    """The product of the singular values is the determinant, l1 l2 sin J2 over the reach²."""
    rows = np.random.default_rng(4).uniform([-170, -145, 133, -360], [170, 145, 333, 360], (99, 4))
    values = np.linalg.svd(jacobian(SCARA, rows), compute_uv=False)
    wanted = 325.0 * 225.0 * np.abs(np.sin(np.radians(rows[:, 1]))) / SCARA.reach**2
    assert np.allclose(values[:, :4].prod(axis=1), wanted)
    stretched = rows.copy()
    stretched[:, 1] = 0.0
    assert distance_from_singularity(SCARA, stretched).max() < 1e-9
    assert np.isnan(distance_from_singularity(SCARA, np.full((1, 4), np.nan))).all()


@pytest.mark.parametrize(
    ("axis", "value"), [(4, 0.0), (2, -90.0 + np.degrees(np.arctan2(42, 351)))]
)
def test_wrist_in_line_and_stretched_elbow_are_singular(axis, value):
    rows = np.random.default_rng(4).uniform(-80, 80, (50, 6))
    rows[:, 4] = 40.0
    assert distance_from_singularity(IRB, rows).min() > 1e-4
    rows[:, axis] = value
    assert distance_from_singularity(IRB, rows).max() < 1e-9


# --------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize(
    "text",
    ["", "1:2", "a:b:c", "5:1:1", "1:5:0", "1:5:-1", "nan", "1:inf:2", "1:2:3:4", "-1e308:1e308:1"],
)
def test_what_is_no_range_is_refused(text):
    with pytest.raises(Refused) as refused:
        parse_range(text, "x")
    assert [f.code for f in refused.value.findings] == ["CK460"]


def test_ranges_have_their_ends():
    assert parse_range("5", "x").values().tolist() == [5.0]
    assert parse_range("-1:1:0.5", "x").values().tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0]
    assert parse_range("0:0.3:0.1", "x").count == 4
    assert parse_range("0:10:4", "x").values().tolist() == [0.0, 4.0, 8.0]


@pytest.mark.parametrize("texts", [["0:1e9:1"], ["0:999:1", "0:999:1", "0:999:1"]])
def test_too_many_points_are_refused(texts):
    with pytest.raises(Refused) as refused:
        grid([parse_range(text, "x") for text in texts])
    assert [f.code for f in refused.value.findings] == ["CK461"]


@pytest.mark.parametrize(
    "text", ["", "sideways", "0,0,0", "1,2", "down/0", "down/181", "down/x", "nan,0,1", "down/"]
)
def test_what_is_no_direction_is_refused(text):
    with pytest.raises(Refused) as refused:
        parse_directions([text], 1)
    assert [f.code for f in refused.value.findings] == ["CK462"]
