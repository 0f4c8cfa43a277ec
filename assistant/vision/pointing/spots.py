"""What a finder gives: where a mark is seen in one picture, how large, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture

if TYPE_CHECKING:
    from assistant.vision.pointing.devices import Ball, Light


@dataclass(frozen=True, slots=True)
class Spot:
    """place: pixel (u, v) at which the mark's middle is projected. radius: pixels.

    angle: radians between its middle and its outline, None of a light. confidence: 0 to 1; of a
    ball the part of its outline that is seen where it should be, of a light how much brighter than
    all else it is. at_edge: it reaches the edge of the picture.
    """

    place: tuple[float, float]
    radius: float
    angle: float | None
    confidence: float
    at_edge: bool = False


def spots(
    picture: Picture, camera: Camera, marks: Sequence[Ball | Light]
) -> list[tuple[Spot, ...]]:
    """What may be each of the marks in a picture, the surest first.

    Raises Refused without OpenCV.
    """
    from assistant.vision.pointing.balls import balls, hues_of
    from assistant.vision.pointing.devices import Light
    from assistant.vision.pointing.lights import lights

    hues = None
    found = []
    for mark in marks:
        if isinstance(mark, Light):
            found.append(lights(picture))
            continue
        hues = hues_of(picture) if hues is None else hues
        found.append(balls(picture, hues, camera, mark))
    return found
