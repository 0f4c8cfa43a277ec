"""Pointing devices: a coloured ball, a light, or a wand of coloured balls; and their files.

A wand of balls rather than an ArUco marker: balls are seen from all sides, and with the same noise
of pixels the rotation of the wand below is known to 0.28 degrees in one frame where that of a
marker of 40 mm is known to 0.42 (`tests/vision/pointing/test_exactness.py`).

kind = "wand"                       # ball, light or wand
orientation = [0, 1, 0, 0]          # of a ball or light: of the tool at the position it shows

[[balls]]                           # of a ball and of a wand
colour = "red"                      # a name, or hue = 0 to 360 with width
radius = 15                         # mm
position = [0, 0, -40]              # mm, in the frame of the device: its tip, z pointing ahead

[light]
largest = 12                        # mm across
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import decode, read_bytes
from assistant.cell.link_bodies import capsule_between
from assistant.cell.scene import Sphere
from assistant.program import settings_tables
from assistant.program.geometry import Pose, Quaternion, Vector
from assistant.program.settings_tables import ENCODINGS, Table, Wrong, kind_of, read_toml
from assistant.vision import rules
from assistant.vision.cameras.synthetic_pictures import Colour, VisibleBody

_TOOL_DOWN: Final[Quaternion] = (0.0, 1.0, 0.0, 0.0)
"""A tool that points down, its x along that of the world."""


@dataclass(frozen=True, slots=True)
class HueRange:
    """hue: degrees on the circle of colours, red being 0, green 120 and blue 240. width: degrees
    to both sides. saturation, value: the least of both, 0 to 1.
    """

    hue: float
    width: float = 25.0
    saturation: float = 0.4
    value: float = 0.15


HUES: Final = {
    "red": HueRange(0.0, 18.0),
    "orange": HueRange(30.0, 11.0),
    "yellow": HueRange(58.0, 16.0),
    "green": HueRange(120.0, 38.0),
    "cyan": HueRange(180.0, 20.0),
    "blue": HueRange(230.0, 30.0),
    "magenta": HueRange(310.0, 30.0),
}


@dataclass(frozen=True, slots=True)
class Ball:
    """A ball. radius: mm. position: of its centre in the frame of the device.

    colour_name: its name in reports.
    """

    colour: HueRange
    radius: float
    position: Vector = (0.0, 0.0, 0.0)
    colour_name: str = ""


@dataclass(frozen=True, slots=True)
class Light:
    """A lamp, or the spot of a laser. largest: mm across, as it is seen."""

    largest: float = 12.0
    position: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Device:
    """Marks whose places in the frame of the device are known.

    The frame's origin is the place that is shown. Its z goes out of the tip, as that of a tool
    that would work there; so marks of a wand have negative z. With marks that are not in one line
    the device shows its orientation. With marks in one line it shows the direction of z, and x
    points as far along the x of the world as that leaves it (along y where z is within 20 degrees
    of x). A single mark shows a place, and the orientation is the one given here.
    """

    name: str
    marks: tuple[Ball | Light, ...]
    orientation: Quaternion = field(default=_TOOL_DOWN)

    @property
    def positions(self) -> Floats:
        """(b, 3) mm of the marks in the frame of the device."""
        return np.array([mark.position for mark in self.marks])

    @property
    def turns_shown(self) -> int:
        """Number of the three turns in space that the marks show: 0, 2 or 3."""
        away = self.positions - self.positions.mean(axis=0)
        return (0, 2, 3, 3)[np.linalg.matrix_rank(away, tol=1.0)]

    @property
    def mark_names(self) -> tuple[str, ...]:
        return tuple(
            "light" if isinstance(mark, Light) else f"{mark.colour_name} ball".strip()
            for mark in self.marks
        )


def ball(colour: str = "red", radius: float = 20.0) -> Device:
    """A ball whose centre is the place that is shown."""
    return Device("ball", (Ball(HUES[colour], radius, colour_name=colour),))


def light(largest: float = 12.0) -> Device:
    return Device("light", (Light(largest),))


def wand() -> Device:
    """Red and green are 200 mm apart on a stick, the tip 40 mm before red; blue is at its side."""
    places = {"red": (0.0, 0.0, -40.0), "green": (0.0, 0.0, -240.0), "blue": (90.0, 0.0, -140.0)}
    marks = (Ball(HUES[name], 15.0, place, name) for name, place in places.items())
    return Device("wand", tuple(marks))


DEVICES: Final[Mapping[str, Callable[[], Device]]] = {"ball": ball, "light": light, "wand": wand}
"""Devices that need no file."""


_LEAST_MARK_DISTANCE: Final = 30.0
"""mm between two marks of a wand: nearer ones hide each other."""
_MOST_BALLS_OF_DEVICE: Final = 8


def device_of(text: str) -> Device:
    """A device by its name, or by the file that describes it; raises Refused and Unreadable."""
    if text in DEVICES:
        return DEVICES[text]()
    if not text.endswith(".toml"):
        cure = f"write one of {', '.join(DEVICES)}, or name a file that ends in .toml"
        raise Refused(rules.BAD_DEVICE(what=f"`{text}` is not known", cure=cure), exit_status=2)
    return read_device(text)


def read_device(path: str | FilePath) -> Device:
    """The device of a file; raises Unreadable, or Refused with a finding for each wrong key."""
    source = decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS)
    top = read_toml(source)
    said = top.read(_DEVICE_KEYS)
    light = top.table("light").read(_LIGHT_KEYS)
    entries = top.content.get("balls", [])
    tables = [
        Table(top.page, ("balls", str(i)), entry)
        for i, entry in enumerate(entries if isinstance(entries, list) else [])
        if isinstance(entry, dict)
    ]
    balls = [_read_ball(table) for table in tables[:_MOST_BALLS_OF_DEVICE]]
    if has_errors(top.page.findings):
        raise Refused(*top.page.findings, exit_status=2)
    kind = said.get("kind", "wand" if len(balls) > 1 else "ball")
    lights = (Light(light.get("largest", Light().largest)),)
    marks = lights if kind == "light" else tuple(ball for ball in balls if ball is not None)
    turn = said["orientation"][0] if "orientation" in said else _TOOL_DOWN
    device = Device(kind, marks, turn)
    if (wrong := _device_fault(device, kind, len(tables))) is not None:
        what, cure = wrong
        raise Refused(rules.BAD_DEVICE(path=str(path), what=what, cure=cure), exit_status=2)
    return device


def _read_ball(table: Table) -> Ball | None:
    said = table.read(_BALL_KEYS)
    if "hue" in said:
        colour, name = HueRange(said["hue"], said.get("width", HueRange(0.0).width)), "coloured"
    elif "colour" in said:
        colour, name = HUES[said["colour"]], said["colour"]
    else:
        table.say(rules.BAD_DEVICE, what="has a ball without a colour", cure="write colour or hue")
        return None
    if "radius" not in said:
        table.say(rules.BAD_DEVICE, what="has a ball without a radius", cure="write its mm")
        return None
    return Ball(colour, said["radius"], said.get("position", (0.0, 0.0, 0.0)), name)


def _device_fault(device: Device, kind: str, given: int) -> tuple[str, str] | None:
    """Return a fault that no device may have, with its cure."""
    count = len(device.marks)
    if given > _MOST_BALLS_OF_DEVICE:
        return f"has {given} balls", f"write {_MOST_BALLS_OF_DEVICE} at most"
    if kind == "ball" and count != 1:
        return f"is a ball and has {count} of them", "write [[balls]] once, or kind = `wand`"
    if kind != "wand":
        return None
    if count < 2:
        return f"is a wand with {count} balls", "write [[balls]] for two or three"
    places = device.positions
    for i in range(count):
        for k in range(i):
            if float(((places[i] - places[k]) ** 2).sum()) < _LEAST_MARK_DISTANCE**2:
                return (
                    "has two balls that are hardly apart",
                    f"put {_LEAST_MARK_DISTANCE:g} mm between them",
                )
            if _hues_overlap(device.marks[i], device.marks[k]):
                return "has two balls of one colour", "give each a colour of its own"
    line = device.turns_shown == 2 and abs(places[:, :2]).max() > 0.0
    if line:
        return "has its balls in one line, which is not its z axis", "put them at x = y = 0"
    return None


def _hues_overlap(one: Ball | Light, other: Ball | Light) -> bool:
    """True if the colours of two balls overlap."""
    if isinstance(one, Light) or isinstance(other, Light):
        return False
    away = abs(one.colour.hue - other.colour.hue) % 360.0
    return min(away, 360.0 - away) < one.colour.width + other.colour.width


def _read_position(value: Any) -> tuple[float, ...]:
    one = settings_tables.number("mm", least=-2000.0, most=2000.0)
    if not isinstance(value, list) or len(value) != 3:
        raise Wrong(f"is {kind_of(value)} and no place", "write three numbers of mm in brackets")
    return tuple(map(one, value))


_DEVICE_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "kind": settings_tables.choice("ball", "light", "wand"),
    "orientation": settings_tables.quaternion,
    "balls": lambda value: value,
    "light": lambda value: value,
}
_LIGHT_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "largest": settings_tables.number("mm", least=0.5, most=200.0),
}
_BALL_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "colour": settings_tables.choice(*HUES),
    "hue": settings_tables.number("degrees", least=0.0, most=360.0),
    "width": settings_tables.number("degrees", least=1.0, most=60.0),
    "radius": settings_tables.number("mm", least=1.0, most=200.0),
    "position": _read_position,
}


_BALL_PAINTS: Final[dict[str, Colour]] = {
    "red": (210, 30, 30),
    "orange": (230, 120, 20),
    "yellow": (220, 210, 30),
    "green": (40, 180, 40),
    "cyan": (30, 190, 190),
    "blue": (30, 70, 210),
    "magenta": (200, 40, 180),
}
_STICK_PAINT: Final[Colour] = (70, 70, 72)
_STICK_RADIUS: Final = 3.0
"""mm, radius of a stick between two balls."""


def bodies_of_device(device: Device, pose: Pose) -> list[VisibleBody]:
    """The balls of a device at a pose in the world, and sticks from the first one to each other."""
    balls = [mark for mark in device.marks if isinstance(mark, Ball)]
    found = [
        VisibleBody(
            Sphere(one.radius),
            pose @ Pose(one.position),
            _BALL_PAINTS.get(one.colour_name, (200, 200, 200)),
        )
        for one in balls
    ]
    for one in balls[1:]:
        part = capsule_between(np.array(balls[0].position), np.array(one.position), _STICK_RADIUS)
        found.append(VisibleBody(part.shape, pose @ part.pose, _STICK_PAINT))
    return found
