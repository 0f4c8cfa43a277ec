"""Keypoints with descriptors: what a surface with a texture is known by.

SIFT (Lowe, 2004) as OpenCV has it, its descriptors with square roots of their parts (Arandjelović
and Zisserman, 2012). A face that is learnt is looked at from aside as well, by drawing it so
(Morel and Yu, ASIFT, 2009).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats, Rows

if TYPE_CHECKING:
    from types import ModuleType

MOST_KEYPOINTS: Final = 4000
"""Keypoints of a picture in which objects are looked for."""
MOST_LEARNT_KEYPOINTS: Final = 700
"""Keypoints of one look at a face that is learnt."""
NEAREST_RATIO: Final = 0.82
"""Distance to the nearest descriptor by that to the nearest one of another place, at most."""
FARTHEST_DESCRIPTOR: Final = 180.0
"""Distance of descriptors that are of one thing: of 512 between those that share nothing."""
LEARNT_TILTS: Final = ((1.0, 0.0), (1.6, 0.0), (1.6, 45.0), (1.6, 90.0), (1.6, 135.0))
"""How much a face is shortened by being looked at from aside, and along which direction."""

Grey = NDArray[np.uint8]
Descriptors = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Keypoints:
    """pixels: (n, 2); descriptors: (n, 128); sizes: (n,) pixels across what each one describes."""

    pixels: Floats
    descriptors: Descriptors
    sizes: Floats

    def __len__(self) -> int:
        return len(self.pixels)


def find_keypoints(
    cv: ModuleType, grey: Grey, most: int = MOST_KEYPOINTS, mask: Grey | None = None
) -> Keypoints:
    """Of a picture (h, w) of grey levels; mask: where they are looked for."""
    points, found = cv.SIFT_create(
        nfeatures=most, contrastThreshold=0.02, enable_precise_upscale=True
    ).detectAndCompute(grey, mask)
    if not points:
        return Keypoints(np.zeros((0, 2)), np.zeros((0, 128), np.uint8), np.zeros(0))
    rooted = np.sqrt(found / np.maximum(found.sum(axis=1, keepdims=True), 1e-9))
    return Keypoints(
        np.array([p.pt for p in points], dtype=np.float64),
        np.clip(np.rint(512.0 * rooted), 0, 255).astype(np.uint8),
        np.array([p.size for p in points], dtype=np.float64),
    )


def face_keypoints(cv: ModuleType, grey: Grey) -> Keypoints:
    """Keypoints of a flat face, also as they are when it is looked at from aside; pixels of it."""
    looks = [_to_face_pixels(find_keypoints(cv, one, MOST_LEARNT_KEYPOINTS, mask), turned) for one, mask, turned in
             _tilted_faces(cv, grey)]  # fmt: skip
    return Keypoints(
        np.concatenate([one.pixels for one in looks]),
        np.concatenate([one.descriptors for one in looks]),
        np.concatenate([one.sizes for one in looks]),
    )


def _tilted_faces(cv: ModuleType, grey: Grey) -> Iterator[tuple[Grey, Grey | None, Floats]]:
    """The face as it looks from aside, where it is in that picture, and the map (2, 3) to it."""
    height, width = grey.shape
    for tilt, along in LEARNT_TILTS:
        if tilt == 1.0:
            yield grey, None, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
            continue
        c, s = np.cos(np.radians(along)), np.sin(np.radians(along))
        turn = np.array([[c, s], [-s, c]])
        map = np.diag([1.0 / tilt, 1.0]) @ turn
        corners = np.array([[0, 0], [width, 0], [width, height], [0, height]]) @ map.T
        low, high = corners.min(axis=0), corners.max(axis=0)
        size = tuple(int(v) for v in np.ceil(high - low))
        whole = np.column_stack([map, -low])
        # What is shortened must not alias.
        sigma = 0.8 * np.sqrt(tilt**2 - 1.0)
        turned = cv.GaussianBlur(grey, (0, 0), sigma / 2.0)
        seen = cv.warpAffine(turned, whole, size, borderMode=cv.BORDER_REPLICATE)
        mask = cv.warpAffine(np.full_like(grey, 255), whole, size)
        yield seen, cv.erode(mask, np.ones((5, 5), np.uint8)), whole


def _to_face_pixels(found: Keypoints, map: Floats) -> Keypoints:
    """Pixels in the face itself."""
    pixels = np.linalg.solve(map[:, :2], (found.pixels - map[:, 2]).T).T
    return Keypoints(np.asarray(pixels, dtype=np.float64), found.descriptors, found.sizes)


def match_keypoints(
    cv: ModuleType, seen: Keypoints, known: Descriptors, owners: Rows, places: Floats
) -> tuple[Rows, Rows]:
    """Rows of `seen` and the rows of `known` that look like them.

    owners: (m,) number of the object of each known descriptor; places: (m, 3) mm where it is on
    it. A look at the same place from elsewhere is no rival: the nearest of another object or of
    another place of the same one is.
    """
    if not len(seen) or len(known) < 2:
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    nearest = min(2 * len(LEARNT_TILTS), len(known))
    matcher = cv.FlannBasedMatcher({"algorithm": 1, "trees": 4}, {"checks": 160})
    cv.setRNGSeed(1)
    found = matcher.knnMatch(seen.descriptors.astype(np.float32), known.astype(np.float32), nearest)
    at = np.array([[m.trainIdx for m in row] + [-1] * (nearest - len(row)) for row in found])
    gap = np.array([[m.distance for m in row] + [np.inf] * (nearest - len(row)) for row in found])
    best = at[:, 0]
    spread = np.array([np.ptp(places[owners == o], axis=0).max() for o in range(owners.max() + 1)])
    away = np.linalg.norm(places[at] - places[best][:, None], axis=2)
    rival = (owners[at] != owners[best][:, None]) | (away > 0.03 * spread[owners[best]][:, None])
    second = np.where(rival, gap, np.inf).min(axis=1)
    second = np.where(np.isfinite(second), second, gap[:, -1] * 1.02)
    good = (gap[:, 0] < NEAREST_RATIO * second) & (gap[:, 0] < FARTHEST_DESCRIPTOR)
    return np.nonzero(good)[0], best[good]
