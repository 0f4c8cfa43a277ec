"""Stereo depth: heights above a plane, from two pictures.

Both pictures are rectified so that rows correspond (Bouguet, as OpenCV's `stereoRectify` has it),
and matched row by row (Hirschmüller, Stereo processing by semi-global matching and mutual
information, 2008).
"""

from __future__ import annotations

from types import ModuleType
from typing import Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.vision.cameras.camera import Camera
from assistant.vision.recognition.outline_matching import pixels_on_plane
from assistant.vision.recognition.photo import Picture, analyse_picture
from assistant.vision.recognition.pose_estimation import Plane

_BLOCK_SIZE: Final = 5
"""Pixels along the side of what is compared."""
_FEWEST_FACE_PIXELS: Final = 300
"""Fewest pixels of a face for a measurement of its depth."""
_DISPARITY_UNITS: Final = 16.0
"""Disparities are whole numbers of these."""


@dataclass(frozen=True, slots=True, eq=False)
class _Depths:
    """points: (h, w, 3) mm in the world of the pixels of the first picture as it was turned, NaN
    where both show no same thing. disparity: (h, w) pixels. pixels: (h, w, 2) of the first picture
    itself.
    """

    points: Floats
    disparity: Floats
    pixels: Floats


def _stereo_depths(
    cv: ModuleType,
    cameras: tuple[Camera, Camera],
    pictures: tuple[Picture, Picture],
    nearest: float,
    farthest: float,
) -> _Depths:
    """Depths between the two distances from the first camera, mm."""
    one, other = cameras
    local = other.pose.inverse() @ one.pose
    turn = rotations.to_matrix(np.array(local.quaternion))
    sizes = one.lens.size
    lenses = [np.array(camera.lens.distortion) for camera in cameras]
    matrices = [camera.lens.matrix for camera in cameras]
    r1, r2, p1, p2, q, _, _ = cv.stereoRectify(
        *(matrices[0], lenses[0], matrices[1], lenses[1], sizes, turn, np.array(local.position)),
        alpha=0,
    )
    straight = []
    maps = None
    for matrix, lens, r, p, picture in zip(
        matrices, lenses, (r1, r2), (p1, p2), pictures, strict=True
    ):
        both = cv.initUndistortRectifyMap(matrix, lens, r, p, sizes, cv.CV_32FC1)
        maps = both if maps is None else maps
        grey = cv.cvtColor(picture, cv.COLOR_BGR2GRAY)
        straight.append(cv.remap(grey, *both, cv.INTER_LINEAR))
    far = abs(float(p2[0, 3]))  # focal length times base
    vertical = abs(float(p2[1, 3])) > far
    if vertical:
        straight = [np.ascontiguousarray(one.T) for one in straight]
        far = abs(float(p2[1, 3]))
    # The first camera may be on either side; what is matched wants it on the left.
    flipped = float(p2[1, 3] if vertical else p2[0, 3]) > 0.0
    if flipped:
        straight = [np.ascontiguousarray(one[:, ::-1]) for one in straight]
    found = match_rows(cv, straight[0], straight[1], far / farthest, far / nearest)
    if flipped:
        found = found[:, ::-1]
    if vertical:
        found = found.T
    signed = np.where(np.isfinite(found), -found if flipped else found, np.nan)
    local_points = cv.reprojectImageTo3D(signed.astype(np.float32), q).astype(np.float64)
    local_points[~np.isfinite(found)] = np.nan
    back = local_points @ r1  # turned back into the frame of the first camera
    points = one.pose.moved(back.reshape(-1, 3)).reshape(back.shape)
    assert maps is not None
    return _Depths(points, np.asarray(found), np.stack(maps, axis=2).astype(np.float64))


def match_rows(cv: ModuleType, left: Picture, right: Picture, least: float, most: float) -> Floats:
    """(h, w) pixels by which things of the left picture (h, w) are farther left in the right one;
    NaN where none is found.
    """
    first = int(np.floor(least)) - 1
    count = int(np.ceil((most - first) / 16.0 + 0.1)) * 16
    matcher = cv.StereoSGBM_create(
        minDisparity=first,
        numDisparities=count,
        blockSize=_BLOCK_SIZE,
        P1=8 * _BLOCK_SIZE**2,
        P2=32 * _BLOCK_SIZE**2,
        disp12MaxDiff=1,
        uniquenessRatio=8,
        speckleWindowSize=80,
        speckleRange=2,
        mode=cv.STEREO_SGBM_MODE_SGBM_3WAY,
    )
    # What is nearer than the picture is wide of its left edge would be lost.
    padded = [cv.copyMakeBorder(one, 0, 0, count + max(first, 0), 0, cv.BORDER_REPLICATE)
              for one in (left, right)]  # fmt: skip
    found = (
        matcher.compute(*padded)[:, count + max(first, 0) :].astype(np.float64) / _DISPARITY_UNITS
    )
    return np.where(found < first + 0.5, np.nan, found)


def _heights_above(found: _Depths, plane: Plane) -> Floats:
    """(h, w) mm of what is seen above a plane."""
    local = plane.pose.inverse().moved(found.points.reshape(-1, 3))
    return np.asarray(local[:, 2].reshape(found.points.shape[:2]))


def face_height(
    cv: ModuleType,
    cameras: tuple[Camera, Camera],
    pictures: tuple[Picture, Picture],
    plane: Plane,
) -> float | None:
    """Return the height in mm of the face of the largest thing in two pictures above its support.

    Return None if too little of it is the same in both: nothing matches on a plain face.
    """
    photo = analyse_picture(cv, cameras[0], pictures[0])
    if not photo.regions:
        return None
    width, height = cameras[0].lens.size
    grid = np.array([[u, v] for u in np.linspace(0, width, 5) for v in np.linspace(0, height, 5)])
    floor = pixels_on_plane(cameras[0], grid, plane, 0.0)
    places = plane.pose.moved(np.column_stack([floor, np.zeros(len(floor))]))
    away = np.linalg.norm(places - np.array(cameras[0].pose.position), axis=1)
    away = away[np.isfinite(away)]
    if not len(away):
        return None
    nearest, farthest = 0.55 * float(away.min()), 1.1 * float(np.percentile(away, 75))
    found = _stereo_depths(cv, cameras, pictures, nearest, max(farthest, 1.5 * nearest))
    mask = np.zeros((height, width), np.uint8)
    largest = photo.regions[int(np.argmax(photo.areas))][0]
    cv.fillPoly(mask, [np.rint(largest).astype(np.int32)], 1)
    mask = cv.erode(mask, np.ones((9, 9), np.uint8))
    u, v = np.moveaxis(np.rint(found.pixels).astype(np.intp), 2, 0)
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    inside &= mask[np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)] > 0
    told = _heights_above(found, plane)[inside]
    told = told[np.isfinite(told)]
    if len(told) < _FEWEST_FACE_PIXELS or len(told) < 0.2 * inside.sum():
        return None
    return float(np.median(told))
