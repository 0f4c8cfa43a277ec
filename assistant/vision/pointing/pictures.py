"""What is wrong with a picture as a whole."""

from __future__ import annotations

from typing import Final

import numpy as np

from assistant.base.diagnostics import Diagnostic
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture
from assistant.vision.pointing import rules

DARK_LEVEL: Final = 25.0
"""Grey level that half of a picture which shows something is above."""
SATURATED_LEVEL: Final = 252
"""Grey level from which on a pixel tells no more."""
MOST_SATURATED: Final = 0.3
"""Part of a picture."""


def size_finding(camera: Camera, picture: Picture) -> Diagnostic | None:
    width, height = camera.lens.size
    if picture.shape == (height, width, 3):
        return None
    return rules.UNCALIBRATED_SIZE(
        camera=camera.name,
        width=picture.shape[1],
        height=picture.shape[0],
        wanted_width=width,
        wanted_height=height,
    )


def brightness_finding(camera: Camera, picture: Picture, *, dark: bool) -> Diagnostic | None:
    """dark: whether a dark picture is wrong; a light is seen best in one."""
    brightest = picture[::2, ::2].max(axis=2)
    if dark and float(np.median(brightest)) < DARK_LEVEL:
        return rules.TOO_DARK_PICTURE(camera=camera.name, level=DARK_LEVEL)
    full = float(np.mean(brightest >= SATURATED_LEVEL))
    if full > MOST_SATURATED:
        return rules.TOO_BRIGHT_PICTURE(camera=camera.name, percent=100.0 * full)
    return None
