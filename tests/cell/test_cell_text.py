"""A scene as a cell file, read back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assistant import robots
from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.cell_file import read_scene
from assistant.cell.link_bodies import place_robot, touching_links
from assistant.cell.scene import (
    Body,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Mesh,
    Part,
    Scene,
    Shape,
    Sphere,
)
from assistant.cell.scene_export import cell_files
from assistant.program.geometry import Pose
from tests.examples import drawn

SAMPLES = Path(__file__).parents[2] / "samples" / "cell"
sizes = st.floats(1e-3, 1e4)
corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    place = draw(st.tuples(*[st.floats(-1e4, 1e4)] * 3))
    turn = np.array(draw(st.tuples(*[st.floats(0.1, 1.0)] * 4)))
    return Pose.of(np.array(place), rotations.canonical(turn))


def block(size: float, off: float) -> Mesh:
    hull = Convex(corners * size).hull
    return Mesh(hull.points, hull.triangles, off=off)


shapes: st.SearchStrategy[Shape] = st.one_of(
    st.tuples(sizes, sizes, sizes).map(Box),
    sizes.map(Sphere),
    st.builds(Cylinder, sizes, sizes),
    st.builds(Capsule, sizes, sizes),
    st.floats(1.0, 1e4).map(lambda size: Convex(corners * size)),
    st.builds(block, st.floats(1.0, 1e4), st.floats(0.0, 10.0)),
)
parts = st.one_of(st.builds(Part, shapes), st.builds(Part, shapes, poses()))
outputs = st.none() | st.tuples(
    st.sampled_from(["grip", "hand 1", 'a "b" \\', "a\n\x00b"]), st.sampled_from([0.0, 1.0])
)
bodies = st.builds(
    Body,
    st.just(""),
    st.lists(parts, min_size=1, max_size=3).map(tuple),
    poses(),
    st.sampled_from(["world", "arm.flange", "arm.J2", "bench"]),
    st.none() | st.tuples(*[st.integers(0, 255)] * 3),
    st.none() | st.floats(0.0, 100.0),
    st.dictionaries(st.sampled_from(["corner", "Top", "x_1"]), poses(), max_size=2),
    taken=outputs,
    released=outputs,
)
ARM = place_robot("arm", robots.get("rv-2aj"), Pose((100.0, 0.0, 50.0), (0.6, 0.0, 0.0, 0.8)))
UNKNOWN = replace(block(10.0, 0.0), within=lambda points: points[:, 0] > 0.0)
OWN = touching_links(ARM)


def back(scene: Scene, folder: Path) -> tuple[Scene, tuple[Diagnostic, ...]]:
    for name, data in cell_files(scene, "cell", folder).items():
        (folder / name).write_bytes(data)
    return read_scene(folder / "cell.toml")


def surface(shape: Shape) -> object:
    """What two shapes have alike that are the same; corners in any order."""
    match shape:
        case Convex():
            return sorted(shape.hull.points.tolist())
        case Mesh():
            alike = shape.points[shape.triangles]
            turned = [min(t, t[1:] + t[:1], t[2:] + t[:2]) for t in alike.tolist()]
            return sorted(turned), shape.solid, shape.off
    return shape


def near(one: Pose, other: Pose) -> bool:
    """The quaternion is brought to length 1 once more."""
    same = np.abs(np.array(one.quaternion) - other.quaternion).max() < 1e-15
    return bool(same) and one.position == other.position


@given(st.lists(bodies, max_size=4), poses(), st.floats(0.0, 50.0))
@settings(
    max_examples=drawn(20),
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_what_is_written_reads_as_the_same(
    tmp_path: Path, some: list[Body], bench: Pose, margin: float
) -> None:
    some = [replace(body, name=f"b{i}") for i, body in enumerate(some)]
    allowed = {("arm.J1", body.name) for body in some[:2]} | OWN
    given = Scene(tuple(some), (ARM,), {"bench": bench}, frozenset(allowed), margin)
    read, findings = back(given, tmp_path)
    assert findings == ()
    assert (read.margin, read.allowed) == (given.margin, given.allowed)
    assert near(read.frames["bench"], bench)
    assert near(read.robots[0].base, ARM.base)
    assert read.robots[0].links == ARM.links
    for one, other in zip(given.bodies, read.bodies, strict=True):
        for key in ("name", "parent", "colour", "margin", "taken", "released"):
            assert getattr(one, key) == getattr(other, key)
        assert near(one.pose, other.pose)
        assert one.locations.keys() == other.locations.keys()
        assert all(near(pose, other.locations[key]) for key, pose in one.locations.items())
        for part, again in zip(one.parts, other.parts, strict=True):
            assert surface(part.shape) == surface(again.shape)
            assert near(part.pose, again.pose)
    assert cell_files(read, "cell", tmp_path).keys() == cell_files(given, "cell", tmp_path).keys()


def test_an_open_mesh_stays_open(tmp_path: Path) -> None:
    whole = block(10.0, 0.0)
    scene = Scene((Body("lid", (Part(Mesh(whole.points, whole.triangles[1:], solid=False)),)),))
    read, findings = back(scene, tmp_path)
    assert [finding.code for finding in findings] == ["CK408"]
    assert surface(read.bodies[0].parts[0].shape) == surface(scene.bodies[0].parts[0].shape)


def test_files_of_robots_are_named_from_where_it_stands(tmp_path: Path) -> None:
    from tests.cell.test_urdf_bodies import CHAIN, scene_of, shape, urdf

    (tmp_path / "arms").mkdir()
    (tmp_path / "new").mkdir()
    drawn = {"l2": shape('<sphere radius="0.05"/>')}
    first, _ = scene_of(tmp_path / "arms", urdf(CHAIN, drawn), "position = [1, 2, 3]")
    read, _ = back(first, tmp_path / "new")
    assert 'robot = "../arms/arm.urdf"' in (tmp_path / "new" / "cell.toml").read_text()
    assert read.robots[0].links == first.robots[0].links
    assert read.robots[0].base == first.robots[0].base


def test_charts_of_robots_are_named_from_where_it_stands(tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    cell = '[robots.arm]\nrobot = "rv-2aj"\nexplored = "arm.npz"\nunknown = "free"\n'
    (tmp_path / "cell.toml").write_text(cell)
    scene, _ = read_scene(tmp_path / "cell.toml", explored=False)
    text = cell_files(scene, "cell", tmp_path / "new")["cell.toml"].decode()
    assert text == cell.replace("arm.npz", "../arm.npz")


def test_a_sample_stays_as_it_is(tmp_path: Path) -> None:
    first, _ = read_scene(SAMPLES / "clamped.toml")
    read, _ = back(first, tmp_path)
    assert [(b.name, b.parts, b.pose, b.parent) for b in read.bodies] == [
        (b.name, b.parts, b.pose, b.parent) for b in first.bodies
    ]
    assert (read.allowed, read.robots[0].links) == (first.allowed, first.robots[0].links)


@pytest.mark.parametrize(
    ("scene", "code"),
    [
        (Scene((Body("my body", (Part(Sphere(1.0)),)),)), "CK416"),
        (Scene((Body("a", (Part(Sphere(1.0)),), locations={"x y": Pose()}),)), "CK416"),
        (Scene(robots=(place_robot("arm", replace(ARM.robot)),)), "CK415"),
        (Scene((Body("a", (Part(UNKNOWN),)),)), "CK418"),
    ],
    ids=["name", "location", "robot", "space"],
)
def test_what_no_cell_file_can_say_is_refused(tmp_path: Path, scene: Scene, code: str) -> None:
    with pytest.raises(Refused) as refused:
        cell_files(scene, "cell", tmp_path)
    (finding,) = refused.value.findings
    assert finding.code == code
    assert finding.cure
