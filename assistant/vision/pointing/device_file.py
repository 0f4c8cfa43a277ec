"""Files of pointing devices, and the names of those that need none.

kind = "wand"                       # ball, light or wand
orientation = [0, 1, 0, 0]          # of a ball or light: of the tool at what it shows

[[balls]]                           # of a ball and of a wand
colour = "red"                      # a name, or hue = 0 to 360 with width
radius = 15                         # mm
position = [0, 0, -40]              # mm, in the frame of the device: its tip, z pointing ahead

[light]
largest = 12                        # mm across
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Refused, has_errors
from assistant.base.source_text import decode, read_bytes
from assistant.program import settings_tables
from assistant.program.settings_tables import Table, Wrong, kind_of
from assistant.sources.process.file import ENCODINGS, read_toml
from assistant.vision.pointing import rules
from assistant.vision.pointing.devices import (
    DEVICES,
    HUES,
    TOOL_DOWN,
    Ball,
    Device,
    HueRange,
    Light,
)

LEAST_MARK_DISTANCE: Final = 30.0
"""mm between two marks of a wand: nearer ones hide each other."""
MOST_BALLS_OF_DEVICE: Final = 8


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
    said = top.read(DEVICE_KEYS)
    light = top.table("light").read(LIGHT_KEYS)
    entries = top.content.get("balls", [])
    tables = [
        Table(top.page, ("balls", str(i)), entry)
        for i, entry in enumerate(entries if isinstance(entries, list) else [])
        if isinstance(entry, dict)
    ]
    balls = [_read_ball(table) for table in tables[:MOST_BALLS_OF_DEVICE]]
    if has_errors(top.page.findings):
        raise Refused(*top.page.findings, exit_status=2)
    kind = said.get("kind", "wand" if len(balls) > 1 else "ball")
    lights = (Light(light.get("largest", Light().largest)),)
    marks = lights if kind == "light" else tuple(ball for ball in balls if ball is not None)
    turn = said["orientation"][0] if "orientation" in said else TOOL_DOWN
    device = Device(kind, marks, turn)
    if (wrong := _device_fault(device, kind, len(tables))) is not None:
        what, cure = wrong
        raise Refused(rules.BAD_DEVICE(path=str(path), what=what, cure=cure), exit_status=2)
    return device


def _read_ball(table: Table) -> Ball | None:
    said = table.read(BALL_KEYS)
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
    """What no device has, with what to do."""
    count = len(device.marks)
    if given > MOST_BALLS_OF_DEVICE:
        return f"has {given} balls", f"write {MOST_BALLS_OF_DEVICE} at most"
    if kind == "ball" and count != 1:
        return f"is a ball and has {count} of them", "write [[balls]] once, or kind = `wand`"
    if kind != "wand":
        return None
    if count < 2:
        return f"is a wand with {count} balls", "write [[balls]] for two or three"
    places = device.positions
    for i in range(count):
        for k in range(i):
            if float(((places[i] - places[k]) ** 2).sum()) < LEAST_MARK_DISTANCE**2:
                return (
                    "has two balls that are hardly apart",
                    f"put {LEAST_MARK_DISTANCE:g} mm between them",
                )
            if _hues_overlap(device.marks[i], device.marks[k]):
                return "has two balls of one colour", "give each a colour of its own"
    line = device.turns_shown == 2 and abs(places[:, :2]).max() > 0.0
    if line:
        return "has its balls in one line, which is not its z axis", "put them at x = y = 0"
    return None


def _hues_overlap(one: Ball | Light, other: Ball | Light) -> bool:
    """Whether colours of two balls overlap."""
    if isinstance(one, Light) or isinstance(other, Light):
        return False
    away = abs(one.colour.hue - other.colour.hue) % 360.0
    return min(away, 360.0 - away) < one.colour.width + other.colour.width


def _read_position(value: Any) -> tuple[float, ...]:
    one = settings_tables.number("mm", least=-2000.0, most=2000.0)
    if not isinstance(value, list) or len(value) != 3:
        raise Wrong(f"is {kind_of(value)} and no place", "write three numbers of mm in brackets")
    return tuple(map(one, value))


DEVICE_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "kind": settings_tables.choice("ball", "light", "wand"),
    "orientation": settings_tables.quaternion,
    "balls": lambda value: value,
    "light": lambda value: value,
}
LIGHT_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "largest": settings_tables.number("mm", least=0.5, most=200.0),
}
BALL_KEYS: Final[Mapping[str, settings_tables.Read]] = {
    "colour": settings_tables.choice(*HUES),
    "hue": settings_tables.number("degrees", least=0.0, most=360.0),
    "width": settings_tables.number("degrees", least=1.0, most=60.0),
    "radius": settings_tables.number("mm", least=1.0, most=200.0),
    "position": _read_position,
}
