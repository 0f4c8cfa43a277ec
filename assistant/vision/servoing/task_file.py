"""Files of servoing: what is led where, by which cameras, and what the arm may do meanwhile.

law = "image"                     # or "pose"
cameras = ["hand"]                # of the file of cameras; without it, all of them

[target]                          # what is led to: a marker, a device of balls, or a place
marker = 7                        # number; size: mm of its black edge
size = 60
# device = "balls.toml"           # or: coloured balls
# position = [300, 0, 100]        # or: a place in the base of the robot, with its quaternion

[mark]                            # what cameras that stand see of the tool: marker or device,
device = "ball"                   # with its position and quaternion on the flange

[tool]                            # the tip on the flange
position = [0, 0, 100]

[goal]                            # of the tip in the frame of the target
position = [0, 0, 120]
quaternion = [0, 1, 0, 0]

[limits]                          # speed mm/s, turning degrees/s, part of each axis' speed, …
box = [[100, -200, 50], [450, 200, 600]]   # in which the tip stays

[servo]                           # gain, tolerances, times
[base]                            # where the base of the robot stands in the world of the cameras
[drawn]                           # where the target is drawn, if pictures of a cell are
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, Final, Literal

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.cell.body_tables import PLACE_KEYS, pose_of
from assistant.program import settings_tables
from assistant.program.geometry import IDENTITY, Pose
from assistant.program.settings_tables import Table, Wrong, kind_of
from assistant.sources.process.file import ENCODINGS, read_toml
from assistant.vision.pointing.device_file import device_of
from assistant.vision.servoing import rules
from assistant.vision.servoing.bounds import Bounds
from assistant.vision.servoing.loop import ServoSettings
from assistant.vision.servoing.things import DeviceMarks, Marker, VisualTarget

DICTIONARY_SIZES: Final = (50, 100, 250, 1000)
DICTIONARIES: Final = tuple(f"{n}X{n}_{count}" for n in (4, 5, 6, 7) for count in DICTIONARY_SIZES)
"""Of markers, as OpenCV names them."""


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
    return servo_in(source, FilePath(path).parent, led_elsewhere=led_elsewhere)


def servo_in(
    source: SourceText, folder: FilePath = FilePath(), *, led_elsewhere: bool = False
) -> ServoFile:
    """folder: in which files of devices stand."""
    top = read_toml(source)
    said = top.read(SERVO_KEYS)
    tables = {name: top.table(name) for name in TABLE_KEYS}
    read = {name: tables[name].read(keys) for name, keys in TABLE_KEYS.items()}
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
    """What is looked for, None if the table names nothing that is."""
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
    dictionary = said.get("dictionary", DICTIONARIES[0])
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


TARGET_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "marker": settings_tables.whole(0, 999),
    "size": settings_tables.number("mm", least=1.0, most=2000.0),
    "dictionary": settings_tables.choice(*DICTIONARIES),
    "device": settings_tables.text,
    **PLACE_KEYS,
}
TABLE_KEYS: Final[Mapping[str, Mapping[str, settings_tables.Read]]] = {
    "target": TARGET_KEYS,
    "mark": TARGET_KEYS,
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
SERVO_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "law": settings_tables.choice("image", "pose"),
    "cameras": settings_tables.texts,
    **dict.fromkeys(TABLE_KEYS, lambda value: value),
}
