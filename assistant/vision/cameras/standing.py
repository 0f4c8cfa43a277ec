"""Where a camera that is carried stands in the world, while the robots of its cell have joints."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.scene import Body, Scene
from assistant.program.geometry import Pose
from assistant.vision.cameras.camera import Camera


def camera_in_world(
    camera: Camera, scene: Scene, joints: Mapping[str, Floats] | None = None
) -> Camera:
    """The camera in the world, of robots by name at joints (a,), the others in their home.

    Its parent is the world, a link or flange of a robot (`arm.flange`), a body or a frame. Raises
    Refused (exit status 2) for a parent that the scene has not.
    """
    carriers = Carriers(scene.robots)
    body = Body(f"camera {camera.name}", (), camera.pose, camera.parent)
    number, pose = carrier_of(scene, body, carriers)
    origins, turns = carriers.at(scene_joints(scene, joints))
    turn = rotations.from_matrix(turns[0, number])
    parent = Pose.of(origins[0, number], np.ravel(turn))
    return Camera(camera.name, camera.lens, parent @ pose)


def scene_joints(scene: Scene, joints: Mapping[str, Floats] | None = None) -> Floats:
    """(1, n) joints of all robots of a scene, as `Carriers` takes them."""
    given = dict(joints or {})
    rows = [np.asarray(given.get(p.name, p.robot.home), dtype=np.float64) for p in scene.robots]
    return np.concatenate([np.zeros(0), *rows])[None]
