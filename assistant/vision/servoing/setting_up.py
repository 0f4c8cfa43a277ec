"""From a file of servoing, cameras and an arm to what the loop goes round with."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Final

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.cell.cell_file import read_scene
from assistant.cell.scene import FLANGE, PlacedRobot, Scene
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots import Robot
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.drawing import Card, VisibleBody, bodies_of_scene
from assistant.vision.opencv import opencv
from assistant.vision.pointing.showing import bodies_of_device
from assistant.vision.servoing import rules
from assistant.vision.servoing.bounds import Guard
from assistant.vision.servoing.image_based import ImageInHand, ImageToHand
from assistant.vision.servoing.law import ControlLaw
from assistant.vision.servoing.live import LiveEyes, SoughtTargets
from assistant.vision.servoing.loop import Eyes
from assistant.vision.servoing.pose_based import PoseInHand, PoseToHand
from assistant.vision.servoing.synthetic import DrawnEyes, ServoWorld
from assistant.vision.servoing.task_file import ServoFile
from assistant.vision.servoing.things import DeviceMarks, Marker
from assistant.vision.servoing.things import VisualTarget as Sought

FEWEST_FOR_ONE_CAMERA: Final = 4
"""Points by which one camera alone tells a pose."""


@dataclass(frozen=True, slots=True, eq=False)
class ServoSetup:
    """cameras: with their poses in the base of the arm, or on its flange. in_hand: whether one of
    them is carried.
    """

    file: ServoFile
    rig: Rig
    robot: Robot
    cameras: tuple[Camera, ...]
    in_hand: bool
    guard: Guard
    law: ControlLaw

    @property
    def title(self) -> str:
        based = {"image": "image-based", "pose": "position-based"}[self.file.law]
        return f"{based}, {'eye in hand' if self.in_hand else 'eye to hand'}"


def set_up_servo(file: ServoFile, rig: Rig, robot: Robot) -> ServoSetup:
    """Raises Refused (exit status 2) for what does not fit together, and without OpenCV."""
    opencv()
    chosen = [rig[name] for name in file.cameras or rig.cameras]
    carried = [camera for camera in chosen if camera.parent != WORLD]
    for camera in carried:
        if camera.parent.rpartition(".")[2] != FLANGE:
            raise _mixed_cameras(camera, "an arm is led by a camera on its flange only")
        if len(chosen) > 1:
            raise _mixed_cameras(camera, "others are looked through, too")
    guard = Guard(robot, file.bounds, file.tip)
    goal = file.goal @ file.tip.inverse()
    if carried:
        if file.target is None:
            raise _bad_servo_file(
                "has a [target] that a camera in the hand does not see", "write a marker"
            )
        made = ImageInHand if file.law == "image" else PoseInHand
        law: ControlLaw = made(file.target, goal)
        return ServoSetup(file, rig, robot, tuple(carried), True, guard, law)
    if file.mark is None:
        raise _bad_servo_file(
            "has no [mark], by which cameras that stand see the tool", "write one"
        )
    _check_points(file, len(chosen))
    back = file.base.inverse()
    cameras = tuple(replace(camera, pose=back @ camera.pose) for camera in chosen)
    wanted = goal if file.target is not None else file.place @ goal
    if file.law == "image":
        law = ImageToHand(file.mark, file.mount, wanted, file.target)
    else:
        law = PoseToHand(file.mark, file.mount, wanted, file.target, file.tip)
    return ServoSetup(file, rig, robot, cameras, False, guard, law)


def _check_points(file: ServoFile, cameras: int) -> None:
    """Raises Refused for what one camera alone does not tell."""
    for name, thing in (("mark", file.mark), ("target", file.target)):
        few = thing is not None and len(thing.points) < FEWEST_FOR_ONE_CAMERA
        if few and cameras < 2:
            what = f"has a [{name}] of fewer than {FEWEST_FOR_ONE_CAMERA} points, which one camera does not place"
            raise _bad_servo_file(what, "use a marker, or two cameras")


@contextmanager
def open_eyes(setting: ServoSetup, joints: Callable[[], Floats]) -> Iterator[Eyes]:
    """The cameras, or drawn pictures where their sources are cell files.

    joints: (a,) where the arm is, to draw it there. Raises Refused and Unreadable.
    """
    rig, sources = setting.rig, setting.rig.sources
    named = [sources.get(camera.name, "") for camera in setting.cameras]
    cells = {source for source in named if source.lower().endswith(".toml")}
    if cells and cells == set(named) and len(cells) == 1:
        yield _drawn_eyes(setting, rig.folder / cells.pop(), joints)
        return
    looked = SoughtTargets(setting.file.target, None if setting.in_hand else setting.file.mark)
    with LiveEyes(setting.cameras, sources, looked, rig.folder) as live:
        yield live


def _drawn_eyes(setting: ServoSetup, cell: FilePath, joints: Callable[[], Floats]) -> DrawnEyes:
    scene, _ = read_scene(cell)
    placed = _robot_in_cell(scene, setting.robot, cell)
    back = placed.base.inverse()

    def still(now: Floats) -> Sequence[VisibleBody]:
        things = bodies_of_scene(scene, {placed.name: now})
        return [replace(thing, pose=back @ thing.pose) for thing in things]

    file = setting.file
    at = None if file.drawn is None else back @ file.drawn
    target = None if file.target is None else (file.target, at or IDENTITY)
    mark = None if file.mark is None or setting.in_hand else (file.mark, file.mount)
    return DrawnEyes(
        setting.cameras,
        ServoWorld(setting.robot, joints, target, mark),
        () if at is None else _bodies_of_target(file.target),
        _bodies_of_target(file.mark),
        still,
    )


def _robot_in_cell(scene: Scene, robot: Robot, cell: FilePath) -> PlacedRobot:
    """The robot of a cell that is led."""
    found = [one for one in scene.robots if one.robot.name == robot.name]
    if len(found) > 1:
        found = [one for one in found if one.name == scene.runs] or found[:1]
    if not found:
        raise _bad_servo_file(f"is for `{robot.name}`, which `{cell}` has not", "name its cell")
    return found[0]


def _bodies_of_target(thing: Sought | None) -> Sequence[VisibleBody]:
    """What stands for something that is looked for, in its own frame."""
    match thing:
        case Marker():
            picture = thing.picture()
            edge = thing.edge
            return [VisibleBody(Card((edge, edge), picture), IDENTITY)]
        case DeviceMarks():
            return bodies_of_device(thing.device, Pose())
        case _:
            return ()


def _mixed_cameras(camera: Camera, why: str) -> Refused:
    finding = rules.MIXED_CAMERAS(camera=camera.name, parent=camera.parent, why=why)
    return Refused(finding, exit_status=2)


def _bad_servo_file(what: str, cure: str) -> Refused:
    return Refused(rules.BAD_SERVO_FILE(what=what, cure=cure), exit_status=2)
