"""What a person shows with: a coloured ball, a light, or a wand of coloured balls.

A wand of balls rather than an ArUco marker: balls are seen from everywhere and not only from before
them, and with the same noise of pixels the turn of the wand below is known to 0.28 degrees in one
frame where that of a marker of 40 mm is known to 0.42 (`tests/vision/pointing/test_exactness.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.program.geometry import Quaternion, Vector

TOOL_DOWN: Final[Quaternion] = (0.0, 1.0, 0.0, 0.0)
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
    """radius: mm. position: of its centre in the frame of the device.

    colour_name: as it is told.
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
    orientation: Quaternion = field(default=TOOL_DOWN)

    @property
    def positions(self) -> Floats:
        """(b, 3) mm of the marks in the frame of the device."""
        return np.array([mark.position for mark in self.marks])

    @property
    def turns_shown(self) -> int:
        """Of the three turns in space, how many the marks show: 0, 2 or 3."""
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
"""What needs no file."""
