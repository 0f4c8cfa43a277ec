"""Where things stand best, known by symmetry, and by looking from the other side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from assistant import robots
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell import link_bodies
from assistant.cell.placement import (
    Goals,
    best_base,
    best_place,
    locations,
    shifted,
    targets_of,
    turned_about_z,
)
from assistant.cell.reach_map import NumberRange, grid
from assistant.cell.scene import Body, Box, Mesh, Part, PlacedRobot, Scene
from assistant.program import pseudo
from assistant.program.geometry import Pose
from assistant.robots.robot_file import read
from tests.cell.reach.test_maps import SHELL

DOWN = (0.0, 0.0, 1.0, 0.0)
IRB = robots.get("irb1200-7-0.7")
NOWHERE = NumberRange(0.0, 0.0, 0.0)


def ring(radius: float, count: int = 24) -> Goals:
    """Targets about the z axis, 200 mm high, the tool pointing down."""
    angles = np.arange(count) * (2.0 * np.pi / count)
    points = [radius * np.cos(angles), radius * np.sin(angles), np.full(count, 200.0)]
    quaternions = turned_about_z(np.tile(DOWN, (count, 1)), 1)
    return Goals(tuple(f"p{i}" for i in range(count)), np.stack(points, axis=1), quaternions)


def level(low: float, high: float, step: float) -> Floats:
    return grid([NumberRange(low, high, step), NumberRange(low, high, step), NOWHERE, NOWHERE])


def test_the_base_stands_best_in_the_middle_of_a_ring_that_is_just_reached():
    """The wrist is 80 mm above the targets: at most 649.7 mm away from axis 1, by its lengths."""
    placed = PlacedRobot("arm", read(SHELL), Pose((40.0, -20.0, 0.0)))
    scene = Scene(robots=(placed,))
    found = best_base(scene, placed, level(-100, 100, 20), [ring(640.0)], bodies=False)
    assert found.best is not None
    assert found.best.offset.tolist() == [-40.0, 20.0, 0.0, 0.0]
    assert found.best.pose.position == (0.0, 0.0, 0.0)
    assert [place.reached == found.total for place in found.places].count(True) == 1
    counts = {
        (place.offset[0] + 40.0, place.offset[1] - 20.0): place.reached for place in found.places
    }
    for (x, y), count in counts.items():
        for alike in ((-x, y), (x, -y), (y, x)):
            assert counts.get(alike, count) == count
        far = np.linalg.norm(ring(640.0).positions[:, :2] - [x, y], axis=1)
        assert count == (far <= np.sqrt(650.0**2 - 20.0**2)).sum()


def test_to_move_the_work_piece_is_to_move_the_base_the_other_way():
    tray = Body("tray", (Part(Box((200, 200, 10))),), Pose((450.0, 60.0, 150.0)),
                locations={"a": Pose((-90.0, -90.0, 20.0), DOWN),
                           "b": Pose((90.0, 80.0, 20.0), DOWN)})  # fmt: skip
    placed = PlacedRobot("arm", IRB)
    scene = Scene((tray,), (placed,))
    goals = [locations(scene, "tray")]
    offsets = grid([NumberRange(-100, 300, 100), NumberRange(-200, 200, 100), NOWHERE, NOWHERE])
    one = best_place(scene, placed, "tray", offsets, goals)
    other = best_base(scene, placed, -offsets, goals)
    assert len(one.places) == len(other.places) == 25
    by_base = {tuple(-place.offset): place for place in other.places}
    for place in one.places:
        same = by_base[tuple(place.offset)]
        assert (place.reached, place.worst) == (same.reached, same.worst)
        assert np.allclose(
            [place.room, place.mean, *place.shares], [same.room, same.mean, *same.shares]
        )
    assert {place.reached for place in one.places} == {0, 1, 2}
    merits = [(p.reached, round(p.shares[0], 6)) for p in one.places]
    assert merits == sorted(merits, reverse=True)


def test_what_stands_on_a_body_goes_along_with_it():
    bench = Body("bench", (Part(Box((300, 300, 20))),), Pose((300.0, 0.0, 0.0)))
    vice = Body(
        "vice",
        (Part(Box((50, 50, 50))),),
        Pose((0.0, 0.0, 35.0)),
        parent="bench",
        locations={"jaw": Pose((0.0, 0.0, 100.0), DOWN)},
    )
    far = Body("far", (), Pose((900.0, 0.0, 0.0)), locations={"x": Pose()})
    placed = PlacedRobot("arm", IRB)
    scene = Scene((bench, vice, far), (placed,))
    goals = locations(scene, "bench")
    assert goals.names == ("vice.jaw",)
    assert goals.positions.tolist() == [[300.0, 0.0, 135.0]]
    assert locations(scene).names == ("vice.jaw", "far.x")
    offset = np.array([[200.0, 50.0, 0.0, 90.0]])
    (place,) = best_place(scene, placed, "bench", offset, [goals]).places
    assert place.pose.position == (500.0, 50.0, 0.0)
    moved = replace(bench, pose=shifted(bench.pose, offset[0]))
    there = locations(Scene((moved, vice, far), (placed,)), "bench")
    again = best_place(
        Scene((moved, vice, far), (placed,)), placed, "bench", offset * 0.0, [there]
    ).places[0]
    assert np.allclose([place.room, *place.shares], [again.room, *again.shares])
    assert place.reached == again.reached == 1


def solid(size: float) -> Mesh:
    hull = Box((size, size, size))
    points = (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5) * np.array(hull.size)
    triangles = np.array(
        [
            *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
            *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
        ]
    )
    return Mesh(points, triangles)


@pytest.mark.parametrize("shape", [Box((100, 100, 100)), solid(100.0)])
def test_places_in_something_else_are_left_out(shape):
    """A cube of 40 mm comes from one side, through a cube of 100 mm, and stands on a table."""
    small = Body("small", (Part(Box((40, 40, 40))),), Pose((300.0, 0.0, 20.0)),
                 locations={"top": Pose((0.0, 0.0, 120.0), DOWN)})  # fmt: skip
    wall = Body("wall", (Part(shape),), Pose((500.0, 0.0, 50.0)))
    table = Body("table", (Part(Box((2000, 2000, 20))),), Pose((0.0, 0.0, -10.0)))
    sunk = Body("sunk", (Part(Box((300, 300, 10))),), Pose((300.0, 0.0, 3.0)))
    placed = PlacedRobot("arm", IRB)
    scene = Scene((small, wall, table, sunk), (placed,))
    offsets = grid([NumberRange(0, 400, 10), NOWHERE, NOWHERE, NOWHERE])
    found = best_place(scene, placed, "small", offsets, [locations(scene, "small")])
    kept = sorted(place.offset[0] for place in found.places)
    assert kept == [x for x in range(0, 401, 10) if not 130 < x < 270]
    assert [f.code for f in found.findings] == ["CK467"]
    assert "13 of the 41 places `small` would stand in `wall`" in found.findings[0].message
    free = replace(scene, allowed=frozenset({("small", "wall")}))
    assert not best_place(free, placed, "small", offsets, [locations(scene, "small")]).findings


def test_the_base_is_not_put_into_what_stands_there():
    placed = link_bodies.place_robot("arm", IRB)
    post = Body("post", (Part(Box((100, 100, 1000))),), Pose((600.0, 0.0, 0.0)),
                locations={"top": Pose((0.0, 0.0, 600.0), DOWN)})  # fmt: skip
    scene = Scene((post,), (placed,), allowed=link_bodies.touching_links(placed))
    offsets = grid([NumberRange(0, 600, 100), NOWHERE, NOWHERE, NOWHERE])
    found = best_base(scene, placed, offsets, [locations(scene)])
    assert max(place.offset[0] for place in found.places) == 400.0
    assert [f.code for f in found.findings] == ["CK467"]


def test_what_hangs_on_the_base_goes_along_and_is_no_target():
    placed = PlacedRobot("arm", IRB)
    box = Body("box", (Part(Box((100, 100, 100))),), Pose((-200.0, 0.0, 50.0)), parent="arm.base",
               locations={"lid": Pose()})  # fmt: skip
    wall = Body("wall", (Part(Box((100, 500, 500))),), Pose((-500.0, 0.0, 250.0)),
                locations={"a": Pose((800.0, 0.0, 100.0), DOWN)})  # fmt: skip
    scene = Scene((box, wall), (placed,))
    assert locations(scene).names == ("wall.a",)
    offsets = grid([NumberRange(-300, 0, 50), NOWHERE, NOWHERE, NOWHERE])
    found = best_base(scene, placed, offsets, [locations(scene)])
    assert sorted(place.offset[0] for place in found.places) == [-200.0, -150.0, -100.0, -50.0, 0.0]
    assert "`box` would stand in `wall`" in found.findings[0].message


def test_targets_of_a_program_are_where_its_arm_goes():
    text = """program cell for irb1200-7-0.7

tool pen tip [0, 0, 80] mass 1 kg centre [0, 0, 40]
frame bench user [500, 0, 100]

target a [0, -100, 200] [0, 0, 1, 0]
target b [0, 100, 200] [0, 0, 1, 0]

procedure main
  move joint a speed 500 mm/s blend fine tool pen frame bench
  move linear b speed 100 mm/s blend fine tool pen frame bench
  move linear a speed 100 mm/s blend fine tool pen frame bench
  move linear a speed 100 mm/s blend fine frame bench
end
"""
    solution = robots.solve_program(pseudo.parse(text), IRB)
    base = Pose((10.0, 20.0, 30.0), (0.5**0.5, 0.0, 0.0, 0.5**0.5))
    found = targets_of(solution, PlacedRobot("arm", IRB, base), 3)
    assert [one.names for one in found.goals] == [("a", "b"), ("a",)]
    assert [one.tip.position[2] for one in found.goals] == [80.0, 0.0]
    wanted = [base @ Pose((500, 0, 100)) @ Pose((0, y, 200), DOWN) for y in (-100, 100)]
    assert np.allclose(found.goals[0].positions, [pose.position for pose in wanted])
    assert found.goals[0].quaternions.shape == (2, 3, 4)
    assert found.unknown == 0


@pytest.mark.parametrize(
    ("name", "offsets", "code"),
    [
        ("nothing", np.zeros((1, 4)), "CK465"),
        ("gripper", np.zeros((1, 4)), "CK465"),
        ("bare", np.zeros((1, 4)), "CK464"),
        ("tray", np.zeros((30_000, 4)), "CK461"),
        ("pedestal", np.zeros((1, 4)), "CK465"),
    ],
)
def test_what_has_no_place_is_refused(name, offsets, code):
    bodies = (
        Body("tray", (), locations={"a": Pose((400.0, 0.0, 300.0), DOWN)}),
        Body("bare", ()),
        Body("pedestal", (), parent="arm.base", locations={"b": Pose()}),
        Body("gripper", (), parent="arm.flange", locations={"tip": Pose()}),
    )
    placed = PlacedRobot("arm", IRB)
    scene = Scene(bodies, (placed,))
    with pytest.raises(Refused) as refused:
        best_place(scene, placed, name, offsets, [locations(scene, name)])
    assert [f.code for f in refused.value.findings] == [code]
