"""What is looked for in pictures: points of a thing whose places on it are known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.drawing import Picture
from assistant.vision.opencv import opencv
from assistant.vision.pointing.devices import Device
from assistant.vision.pointing.finding import find_spots

EDGE_MARGIN: Final = 2.0
"""Pixels from the edge of a picture within which a corner is not measured as it is."""
MARKER_BORDER: Final = 6
"""Part of its edge, 1 in so many, that a marker has white around it."""
LEAST_SQUARE_DISTANCE: Final = 0.05
"""Part of its outline by which two squares are apart at least: at more than this, the edge of the
paper around a small marker is taken for the marker.
"""
RIVAL_CONFIDENCE: Final = 0.9
"""Part of the confidence of the surest spot that another one must not have."""


class VisualTarget(Protocol):
    """points: (n, 3) mm in its own frame."""

    @property
    def points(self) -> Floats: ...

    def find(self, picture: Picture, camera: Camera) -> Floats:
        """(n, 2) pixels, NaN for a point that is not seen, or not for sure."""


@dataclass(frozen=True, slots=True)
class Marker:
    """An ArUco marker. size: mm, the edge of its black square.

    Its frame has its origin in the middle, x to the right of the marker, y up and z out of it.
    dictionary: of OpenCV, without `DICT_`.
    """

    number: int
    size: float
    dictionary: str = "4X4_50"

    @property
    def points(self) -> Floats:
        """Of its corners, from the upper left one on clockwise, as OpenCV finds them."""
        signs = np.array([[-1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, -1.0, 0.0]])
        return np.asarray(signs * self.size / 2.0)

    def find(self, picture: Picture, camera: Camera) -> Floats:
        cv = opencv()
        settings = cv.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv.aruco.CORNER_REFINE_SUBPIX
        settings.minMarkerDistanceRate = LEAST_SQUARE_DISTANCE
        detector = cv.aruco.ArucoDetector(self._dictionary(cv), settings)
        corners, numbers, _ = detector.detectMarkers(cv.cvtColor(picture, cv.COLOR_BGR2GRAY))
        none = np.full((4, 2), np.nan)
        found = np.flatnonzero(np.ravel([] if numbers is None else numbers) == self.number)
        if len(found) != 1:  # two of one number are one of them and something else
            return none
        pixels = np.asarray(corners[int(found[0])], dtype=np.float64).reshape(4, 2)
        return pixels if camera.within(pixels, EDGE_MARGIN).all() else none

    @property
    def edge(self) -> float:
        """Of `picture`, in mm."""
        return self.size * (1.0 + 2.0 / MARKER_BORDER)

    def picture(self, dots: int = 240) -> Picture:
        """The marker with a white border of a sixth of its edge, to print or to draw."""
        cv = opencv()
        inner = np.asarray(cv.aruco.generateImageMarker(self._dictionary(cv), self.number, dots))
        return np.repeat(
            np.pad(inner, dots // MARKER_BORDER, constant_values=255)[..., None], 3, axis=2
        )

    def _dictionary(self, cv: Any) -> Any:
        return cv.aruco.getPredefinedDictionary(getattr(cv.aruco, f"DICT_{self.dictionary}"))


@dataclass(frozen=True, slots=True)
class DeviceMarks:
    """Coloured balls or lights of a pointing device."""

    device: Device

    @property
    def points(self) -> Floats:
        return self.device.positions

    def find(self, picture: Picture, camera: Camera) -> Floats:
        pixels = np.full((len(self.device.marks), 2), np.nan)
        for row, found in enumerate(find_spots(picture, camera, self.device.marks)):
            sure = [
                spot for spot in found if spot.confidence >= RIVAL_CONFIDENCE * found[0].confidence
            ]
            if len(sure) == 1 and not sure[0].at_edge:
                pixels[row] = sure[0].place
        return pixels


@dataclass(frozen=True, slots=True, eq=False)
class GivenPoints:
    """Points that something else finds, as a synthetic camera does that projects them."""

    points: Floats

    def find(self, picture: Picture, camera: Camera) -> Floats:  # noqa: ARG002
        return np.full((len(self.points), 2), np.nan)
