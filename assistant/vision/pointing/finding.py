"""Marks of a device in one picture."""

from __future__ import annotations

from collections.abc import Sequence

from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture
from assistant.vision.pointing.balls import find_balls, hues_of
from assistant.vision.pointing.devices import Ball, Light
from assistant.vision.pointing.lights import find_lights
from assistant.vision.pointing.spots import MarkSpot


def find_spots(
    picture: Picture, camera: Camera, marks: Sequence[Ball | Light]
) -> list[tuple[MarkSpot, ...]]:
    """What may be each of the marks in a picture, the surest first.

    Raises Refused without OpenCV.
    """
    hues = None
    found = []
    for mark in marks:
        if isinstance(mark, Light):
            found.append(find_lights(picture))
            continue
        hues = hues_of(picture) if hues is None else hues
        found.append(find_balls(picture, hues, camera, mark))
    return found
