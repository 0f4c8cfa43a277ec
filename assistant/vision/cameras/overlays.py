"""What is drawn over pictures for people who look at them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture
from assistant.vision.opencv import opencv

AXIS_LENGTH: Final = 100.0
"""mm of an axis."""
AXIS_COLOURS: Final = ((40, 40, 220), (40, 180, 40), (220, 90, 40))
"""Blue, green, red; of x, y, z."""
AXIS_CHORDS: Final = 16
"""Chords of an axis, which the lens bends."""


def with_axes(camera: Camera, picture: Picture) -> Picture:
    """The axes of the frame that the camera stands in, 100 mm each, and the camera's own centre."""
    cv = opencv()
    out = picture.copy()
    u, v = (round(value) for value in camera.lens.centre)
    cv.drawMarker(out, (u, v), (255, 255, 255), cv.MARKER_CROSS, 14, 1)
    for axis, colour in enumerate(AXIS_COLOURS):
        points = np.outer(np.linspace(0.0, AXIS_LENGTH, AXIS_CHORDS + 1), np.eye(3)[axis])
        _draw_axis(cv, out, camera.project(points), colour, "xyz"[axis])
    return out


def _draw_axis(
    cv: Any, picture: Picture, pixels: Floats, colour: tuple[int, int, int], name: str
) -> None:
    seen = pixels[np.isfinite(pixels).all(axis=1)]
    if len(seen) < 2 or np.abs(seen).max() > 1e5:
        return
    places = np.round(seen).astype(np.int32)
    cv.polylines(picture, [places[:, None]], False, colour, 2, cv.LINE_AA)
    end = (int(places[-1, 0]) + 4, int(places[-1, 1]) + 4)
    cv.putText(picture, name, end, cv.FONT_HERSHEY_SIMPLEX, 0.6, colour, 2, cv.LINE_AA)
