"""The lens of a camera from views of a board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.calibration import rules
from assistant.vision.calibration.boards import Board, BoardView
from assistant.vision.cameras.camera import Lens
from assistant.vision.opencv import opencv

FEWEST_VIEWS: Final = 4
"""Views; each gives six unknowns of its own and the lens has nine."""
LEAST_TILT: Final = 10.0
"""Degrees between the most unlike views of a board below which depth and focal length are one."""
MOST_FOCAL_SIGMA: Final = 1.0
"""Percent of the focal length, one sigma."""
LEAST_K3_SIGMAS: Final = 3.0
"""Times its sigma from which on the third coefficient of the distortion is one."""
MOST_LENS_RESIDUAL: Final = 1.0
"""Pixels that sharp views do not leave."""
LEAST_COVERAGE: Final = 0.25
"""Part of the picture inside of all corners below which the lens is extrapolated."""
MOST_CENTRE_SIGMA: Final = 1.0
"""Percent of the width of the picture, one sigma of the centre."""
LENS_PARAMETERS: Final = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
"""Parameters of a lens, in the order of `LensFound.sigma`."""


@dataclass(frozen=True, slots=True, eq=False)
class LensFound:
    """A lens, and how well the views determine it.

    residual: pixels, root mean square over u and v of all corners. of_views: (n,) the same of each
    view. poses: of the board in the camera, one a view. sigma: (9,) one sigma of `PARAMETERS`, 0 of
    one that was left out. coverage: part of the picture, 0 to 1, inside of all corners that were
    seen. noise_mm: one sigma of the place of a board in a view, root mean square over the views.
    """

    lens: Lens
    residual: float
    of_views: Floats
    poses: tuple[Pose, ...]
    sigma: Floats
    coverage: float
    noise_mm: float
    findings: tuple[Diagnostic, ...] = ()


def find_lens(
    board: Board, views: Sequence[BoardView], size: tuple[int, int], name: str = "camera"
) -> LensFound:
    """Focal lengths, centre and distortion; raises Refused for views that do not determine them.

    name: of the camera, for messages.

    By OpenCV's calibrateCamera (Zhang, A flexible new technique for camera calibration, 2000).
    Distortion of high order is left out where the views do not tell it: it would bend the picture
    wildly where there was no board.
    """
    if len(views) < FEWEST_VIEWS:
        raise Refused(rules.FEW_VIEWS(count=len(views), least=FEWEST_VIEWS))
    cv = opencv()
    objects = [board.corners[view.rows].astype(np.float32) for view in views]
    pixels = [view.pixels.astype(np.float32)[:, None] for view in views]
    lens, found = _fit_lens(cv, objects, pixels, size)
    sigma = np.ravel(found[5])
    poses = tuple(
        pose_of_opencv(turn, place) for turn, place in zip(found[3], found[4], strict=True)
    )
    _check_determined(poses, sigma, lens)
    sigma = sigma[: len(LENS_PARAMETERS)]
    percent = float(100.0 * sigma[:2].max() / min(lens.focal))
    # OpenCV divides by corners; here it is the mean of u and v, as noise of pixels is told.
    share = 1.0 / np.sqrt(2.0)
    left = float(found[0]) * share
    unsure = percent > MOST_FOCAL_SIGMA or left > MOST_LENS_RESIDUAL
    findings = [rules.POOR_LENS(name=name, residual=left, percent=percent)] if unsure else []
    coverage, centre = _coverage(cv, views, size), float(sigma[2:4].max())
    if coverage < LEAST_COVERAGE or centre > MOST_CENTRE_SIGMA / 100.0 * size[0]:
        findings.append(rules.UNCOVERED_PICTURE(name=name, percent=100.0 * coverage, centre=centre))
    of_views = np.ravel(found[7]) * share
    places = np.reshape(found[6], (len(views), 6))[:, 3:]
    noise = float(np.sqrt((places**2).sum(axis=1).mean()))
    return LensFound(lens, left, of_views, poses, sigma, coverage, noise, tuple(findings))


def _coverage(cv: Any, views: Sequence[BoardView], size: tuple[int, int]) -> float:
    """Part of the picture inside of the convex hull of all corners."""
    corners = np.concatenate([view.pixels for view in views]).astype(np.float32)
    return float(cv.contourArea(cv.convexHull(corners))) / (size[0] * size[1])


def _fit_lens(cv: Any, objects: Any, pixels: Any, size: tuple[int, int]) -> tuple[Lens, Any]:
    """The lens with the most of distortion that is told, and what OpenCV answers with it."""
    for flags in (0, cv.CALIB_FIX_K3, cv.CALIB_FIX_K3 | cv.CALIB_FIX_K2):
        try:
            found = cv.calibrateCameraExtended(objects, pixels, size, None, None, flags=flags)
        except cv.error:
            raise Refused(rules.VIEWS_ALIKE(what="no lens fits them")) from None
        lens = _lens_of_opencv(size, found[1], np.ravel(found[2]))
        told = flags or abs(lens.distortion[4]) > LEAST_K3_SIGMAS * float(np.ravel(found[5])[8])
        if told and lens.whole:
            break
    return lens, found


def _lens_of_opencv(size: tuple[int, int], matrix: Floats, k: Floats) -> Lens:
    return Lens(
        size,
        (float(matrix[0, 0]), float(matrix[1, 1])),
        (float(matrix[0, 2]), float(matrix[1, 2])),
        (float(k[0]), float(k[1]), float(k[2]), float(k[3]), float(k[4])),
    )


def pose_of_opencv(turn: Any, place: Any) -> Pose:
    """The pose that OpenCV writes as a vector of turning (radians) and one of place."""
    vector = np.ravel(np.asarray(turn, dtype=np.float64))
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    return Pose.of(np.ravel(place), np.ravel(rotations.about(axis, np.degrees(angle))))


def _check_determined(poses: Sequence[Pose], sigma: Floats, lens: Lens) -> None:
    """Raises Refused where the views leave open what the lens is."""
    faces = np.array([rotations.to_matrix(np.array(p.quaternion))[:, 2] for p in poses])
    most = float(np.degrees(np.arccos(np.clip((faces @ faces.T).min(), -1.0, 1.0))))
    if most < LEAST_TILT:
        raise Refused(
            rules.VIEWS_ALIKE(what=f"the board is tilted by {most:.1f} degrees between them")
        )
    focal = lens.focal[0]
    if not np.isfinite(sigma).all() or not 0.0 < focal < 1e6 or sigma[0] > 0.1 * focal:
        raise Refused(rules.VIEWS_ALIKE(what="they leave the focal length open"))
    if not lens.whole:
        raise Refused(rules.VIEWS_ALIKE(what="they leave open what the lens does at the edges"))
