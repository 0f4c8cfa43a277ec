"""Lights in a picture: the spot of a laser or a lamp, brighter than all that is near it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.vision.cameras.drawing import Picture
from assistant.vision.opencv import opencv
from assistant.vision.pointing.spots import MarkSpot

LIGHT_SMOOTHING: Final = 1.0
"""Pixels, sigma, before bright places are looked for."""
LEAST_BRIGHTNESS: Final = 60.0
"""Grey levels above what is around it."""
SURROUNDINGS_WIDTH: Final = 31
"""Pixels across which the usual brightness of a place is taken, by its median."""
MOST_LIGHTS: Final = 6
WEIGHED_RADII: Final = 2.0
"""Times its radius around a spot in which its brightness is weighed, and 3 pixels more."""
LEAST_FILL: Final = 0.55
"""Part of its box that a round spot fills at least; a disc fills 0.79."""


def find_lights(picture: Picture) -> tuple[MarkSpot, ...]:
    """What may be the light in a picture, the surest first.

    How large it may be is told in mm, which only the distance compares with: see `locating`.
    """
    cv2 = opencv()
    bright = picture.max(axis=2).astype(np.float32)
    soft = cv2.GaussianBlur(bright, (0, 0), LIGHT_SMOOTHING)
    small = cv2.resize(soft, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    usual = cv2.medianBlur(np.round(small).astype(np.uint8), SURROUNDINGS_WIDTH // 2 | 1)
    height, width = bright.shape
    ground = cv2.resize(usual, (width, height), interpolation=cv2.INTER_LINEAR).astype(np.float32)
    above = soft - ground
    peak = float(above.max())
    if peak < LEAST_BRIGHTNESS:
        return ()
    mask = (above > peak / 2.0).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    found = []
    for i in np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind="stable")[:MOST_LIGHTS] + 1:
        spot = _measure_light(bright, labels, int(i), stats[i], above)
        if spot is not None:
            found.append(spot)
    return tuple(sorted(found, key=lambda spot: -spot.confidence))


def _measure_light(
    bright: Any, labels: Any, number: int, stats: Any, above: Any
) -> MarkSpot | None:
    """The middle of a spot, weighed by what it is brighter than the ring around it."""
    x, y, w, h, area = (int(v) for v in stats[:5])
    fill = area / (w * h)
    if fill < LEAST_FILL or max(w, h) > 3 * min(w, h):
        return None
    radius = float(np.sqrt(area / np.pi))
    reach = WEIGHED_RADII * radius + 3.0
    place: Floats = np.array([x + (w - 1) / 2.0, y + (h - 1) / 2.0])
    height, width = bright.shape
    for _ in range(3):
        low = np.maximum(np.floor(place - reach), 0).astype(int)
        high = np.minimum(np.ceil(place + reach), (width - 1, height - 1)).astype(int)
        part = bright[low[1] : high[1] + 1, low[0] : high[0] + 1].astype(np.float64)
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        away = np.hypot(u - place[0], v - place[1])
        ring = (away > reach - 1.5) & (away <= reach + 0.5)
        if not ring.any():
            return None
        weight = np.where(away <= reach, np.maximum(part - np.median(part[ring]), 0.0), 0.0)
        weight[weight < 0.04 * weight.max()] = 0.0
        total = weight.sum()
        if not total > 0.0:
            return None
        place = np.array([(weight * u).sum(), (weight * v).sum()]) / total
    own = above[labels == number]
    confidence = min(1.0, float(own.max()) / (2.0 * LEAST_BRIGHTNESS)) * min(1.0, fill / 0.7)
    least, most = place - (reach - 0.5), place + (reach - 0.5)
    at_edge = bool((least < 0.0).any() or (most > (width - 1, height - 1)).any())
    return MarkSpot((float(place[0]), float(place[1])), radius, None, confidence, at_edge)
