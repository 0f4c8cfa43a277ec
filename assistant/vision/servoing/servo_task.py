"""A servo task: its file, and the guard, control law and eyes that it asks for.

law = "image"                     # or "pose"
cameras = ["hand"]                # of the camera file; without it, all of them

[target]                          # to be reached: a marker, a device of balls, or a position
marker = 7                        # number; size: mm of its black edge
size = 60
# device = "balls.toml"           # or: coloured balls
# position = [300, 0, 100]        # or: a pose in the base of the robot, with its quaternion

[mark]                            # what fixed cameras see of the tool: marker or device,
device = "ball"                   # with its position and quaternion on the flange

[tool]                            # the tip on the flange
position = [0, 0, 100]

[goal]                            # of the tip in the frame of the target
position = [0, 0, 120]
quaternion = [0, 1, 0, 0]

[limits]                          # speed mm/s, turning degrees/s, part of each axis' speed, …
box = [[100, -200, 50], [450, 200, 600]]   # in which the tip stays

[servo]                           # gain, tolerances, times
[base]                            # pose of the base of the robot in the world of the cameras
[drawn]                           # where the target is drawn, if pictures of a cell are
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import Any, Final, Literal

from assistant.base.arrays import Floats
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.cell.body_tables import PLACE_KEYS, pose_of
from assistant.cell.cell_file import read_scene
from assistant.cell.scene import FLANGE, PlacedRobot, Scene
from assistant.program import settings_tables
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.settings_tables import ENCODINGS, Table, Wrong, kind_of, read_toml
from assistant.robots import Robot
from assistant.vision import rules
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.cameras.camera_file import Rig
from assistant.vision.cameras.synthetic_pictures import Card, VisibleBody, bodies_of_scene
from assistant.vision.opencv import opencv
from assistant.vision.pointing.devices import bodies_of_device, device_of
from assistant.vision.servoing.bounds import Bounds, Guard
from assistant.vision.servoing.control_laws import (
    ControlLaw,
    ImageInHand,
    ImageToHand,
    PoseInHand,
    PoseToHand,
)
from assistant.vision.servoing.live_cameras import LiveEyes, SoughtTargets
from assistant.vision.servoing.servo_loop import Eyes, ServoSettings
from assistant.vision.servoing.simulation import DrawnEyes, ServoWorld
from assistant.vision.servoing.visual_targets import DeviceMarks, Marker, VisualTarget
from assistant.vision.servoing.visual_targets import VisualTarget as Sought

_DICTIONARY_SIZES: Final = (50, 100, 250, 1000)
_DICTIONARIES: Final = tuple(
    f"{n}X{n}_{count}" for n in (4, 5, 6, 7) for count in _DICTIONARY_SIZES
)
"""Dictionaries of markers, as OpenCV names them."""


@dataclass(frozen=True, slots=True)
class ServoFile:
    """law: by what is led. cameras: names, () for all of them. target: what is seen and led to, or
    place: where it is in the base. mark: what is seen of the tool; mount: its frame on the flange.
    tip: on the flange. goal: the tip in the frame of the target. base: of the robot in the world.
    drawn: the target in the world, where pictures are drawn; None if it is not.
    """

    law: Literal["image", "pose"] = "image"
    cameras: tuple[str, ...] = ()
    target: VisualTarget | None = None
    place: Pose = IDENTITY
    mark: VisualTarget | None = None
    mount: Pose = IDENTITY
    tip: Pose = IDENTITY
    goal: Pose = IDENTITY
    base: Pose = IDENTITY
    drawn: Pose | None = None
    bounds: Bounds = field(default_factory=Bounds)
    settings: ServoSettings = field(default_factory=ServoSettings)


def read_servo(path: str | FilePath, *, led_elsewhere: bool = False) -> ServoFile:
    """A file of servoing; raises Unreadable, or Refused with a finding for each wrong key.

    led_elsewhere: where it leads to is not for the file to say.
    """
    data = read_bytes(path, most=SETTINGS_FILE)
    source = decode(data, str(path), ENCODINGS)
    return _servo_in(source, FilePath(path).parent, led_elsewhere=led_elsewhere)


def _servo_in(
    source: SourceText, folder: FilePath = FilePath(), *, led_elsewhere: bool = False
) -> ServoFile:
    """folder: in which files of devices stand."""
    top = read_toml(source)
    said = top.read(_SERVO_KEYS)
    tables = {name: top.table(name) for name in _TABLE_KEYS}
    read = {name: tables[name].read(keys) for name, keys in _TABLE_KEYS.items()}
    if not read["target"] and not led_elsewhere:
        top.say(
            rules.BAD_SERVO_FILE, what="has no [target]", cure="write what is led to, or a place"
        )
    target = _read_target(tables["target"], read["target"], folder)
    mark = _read_target(tables["mark"], read["mark"], folder)
    if read["mark"] and mark is None:
        what, cure = "has a [mark] that nobody sees", "write marker, or device"
        tables["mark"].say(rules.BAD_SERVO_FILE, what=what, cure=cure)
    if not read["goal"] and not led_elsewhere:
        top.say(rules.BAD_SERVO_FILE, what="has no [goal]", cure="write where the tip goes to")
    limits = dict(read["limits"])
    if has_errors(top.page.findings):
        raise Refused(*top.page.findings, exit_status=2)
    return ServoFile(
        law=said.get("law", "image"),
        cameras=said.get("cameras", ()),
        target=target,
        place=_read_pose(read["target"]),
        mark=mark,
        mount=_read_pose(read["mark"]),
        tip=_read_pose(read["tool"]),
        goal=_read_pose(read["goal"]),
        base=_read_pose(read["base"]),
        drawn=_read_pose(read["drawn"]) if read["drawn"] else None,
        bounds=Bounds(**limits),
        settings=ServoSettings(**read["servo"]),
    )


def _read_pose(said: Mapping[str, Any]) -> Pose:
    return pose_of(said) if any(key in said for key in PLACE_KEYS) else IDENTITY


def _read_target(table: Table, said: Mapping[str, Any], folder: FilePath) -> VisualTarget | None:
    """Return the target of a table, None if the table names no target."""
    if "marker" in said and "device" in said:
        what, cure = "has a marker and a device in one table", "keep one of them"
        table.say(rules.BAD_SERVO_FILE, what=what, cure=cure)
    if "device" in said:
        name = said["device"]
        return DeviceMarks(device_of(str(folder / name) if name.endswith(".toml") else name))
    if "marker" not in said:
        return None
    if "size" not in said:
        table.say(
            rules.BAD_SERVO_FILE, what="has a marker without a size", cure="write mm of its edge"
        )
        return None
    dictionary = said.get("dictionary", _DICTIONARIES[0])
    if said["marker"] >= int(dictionary.partition("_")[2]):
        what = f"has marker {said['marker']}, which {dictionary} has not"
        table.say(rules.BAD_SERVO_FILE, what=what, cure="name its dictionary, or another marker")
        return None
    return Marker(said["marker"], said["size"], dictionary)


def _read_box(value: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    if not isinstance(value, list) or len(value) != 2:
        raise Wrong(f"is {kind_of(value)} and no box", "write two corners: [[x, y, z], [x, y, z]]")
    least, most = map(settings_tables.position, value)
    return least, most


def _positive_number(unit: str) -> settings_tables.Read:
    return settings_tables.number(unit, above=0.0)


_TARGET_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "marker": settings_tables.whole(0, 999),
    "size": settings_tables.number("mm", least=1.0, most=2000.0),
    "dictionary": settings_tables.choice(*_DICTIONARIES),
    "device": settings_tables.text,
    **PLACE_KEYS,
}
_TABLE_KEYS: Final[Mapping[str, Mapping[str, settings_tables.Read]]] = {
    "target": _TARGET_KEYS,
    "mark": _TARGET_KEYS,
    **dict.fromkeys(("tool", "goal", "base", "drawn"), PLACE_KEYS),
    "limits": {
        "speed": _positive_number("mm/s"),
        "turning": _positive_number("degrees/s"),
        "part": _positive_number(""),
        "to_speed": _positive_number("seconds"),
        "margin": settings_tables.number("degrees", least=0.0),
        "box": _read_box,
    },
    "servo": {
        "gain": _positive_number(""),
        "share": _positive_number(""),
        "pixels": _positive_number("pixels"),
        "distance": _positive_number("mm"),
        "turn": _positive_number("degrees"),
        "hold": settings_tables.whole(1, 100),
        "stale": _positive_number("seconds"),
        "timeout": _positive_number("seconds"),
        "condition": _positive_number(""),
        "opening": _positive_number("seconds"),
    },
}
_SERVO_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "law": settings_tables.choice("image", "pose"),
    "cameras": settings_tables.texts,
    **dict.fromkeys(_TABLE_KEYS, lambda value: value),
}


_FEWEST_FOR_ONE_CAMERA: Final = 4
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
        few = thing is not None and len(thing.points) < _FEWEST_FOR_ONE_CAMERA
        if few and cameras < 2:
            least = _FEWEST_FOR_ONE_CAMERA
            what = f"has a [{name}] of fewer than {least} points, which one camera does not place"
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
    """Return the bodies that represent a target in simulation, in its frame."""
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
