"""Scenes as glTF, read back by trimesh."""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh

from assistant import robots
from assistant.cell.link_bodies import place_robot
from assistant.cell.scene import Body, Box, Capsule, Convex, Cylinder, Part, Scene, Shape, Sphere
from assistant.cell.scene_export import gltf
from assistant.program.geometry import Pose


@pytest.mark.parametrize(
    ("shape", "volume", "size"),
    [
        (Box((100.0, 200.0, 300.0)), 6e6, (100, 200, 300)),
        (Sphere(50.0), 4 / 3 * np.pi * 50**3, (100, 100, 100)),
        (Cylinder(50.0, 80.0), np.pi * 50**2 * 80, (100, 100, 80)),
        (Capsule(50.0, 80.0), np.pi * 50**2 * 80 + 4 / 3 * np.pi * 50**3, (100, 100, 180)),
        (Convex(np.diag([0.0, 60, 60, 60])[:, 1:]), 60**3 / 6, (60, 60, 60)),
    ],
)
def test_shapes_are_whole_and_face_outwards(
    shape: Shape, volume: float, size: tuple[float, float, float]
) -> None:
    pose = Pose((1000.0, 0.0, 500.0))
    data = gltf(Scene((Body("thing", (Part(shape),), pose, colour=(255, 0, 128)),)))
    mesh = trimesh.load_scene(io.BytesIO(data), file_type="glb").to_mesh()
    assert mesh.volume * 1e9 == pytest.approx(volume, rel=0.02)
    x, y, z = size
    assert mesh.extents * 1000 == pytest.approx((x, z, y), rel=0.01)  # y is upwards
    if not isinstance(shape, Convex):
        assert mesh.bounds.mean(axis=0) * 1000 == pytest.approx((1000, 500, 0), abs=0.01)


def test_an_arm_stands_as_its_joints_say_and_carries_its_tool() -> None:
    robot = robots.get("irb1200-7-0.7")
    arm = place_robot("arm", robot, Pose((200.0, 0.0, 0.0)))
    tool = Body("nozzle", (Part(Sphere(10.0)),), Pose((0.0, 0.0, 100.0)), "arm.flange")
    joints = np.array([20.0, 30.0, -10.0, 40.0, 50.0, 60.0])
    loaded = trimesh.load_scene(
        io.BytesIO(gltf(Scene((tool,), (arm,)), {"arm": joints})), file_type="glb"
    )
    assert {"cell", "arm", "arm J3", "arm flange", "nozzle", "arm.J2"} <= set(loaded.graph.nodes)
    x, z, y = loaded.graph.get("nozzle")[0][:3, 3] * 1000
    position, turn = robot.fk(joints[None])
    tip = Pose((200.0, 0.0, 0.0)) @ Pose.of(position[0], turn[0]) @ Pose((0.0, 0.0, 100.0))
    assert (x, -y, z) == pytest.approx(tip.position, abs=1e-3)


def test_an_empty_scene_is_a_file_too() -> None:
    assert gltf(Scene())[:4] == b"glTF"
