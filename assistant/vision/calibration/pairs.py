"""Where cameras stand to each other, from views of one board that both see at the same moments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.program import rotations
from assistant.program.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.calibration import rules
from assistant.vision.calibration.boards import Board, View
from assistant.vision.calibration.lenses import LEAST
from assistant.vision.cameras.camera import Lens
from assistant.vision.opencv import opencv

MOST_LEFT: Final = 5.0
"""Pixels left from which on two cameras did not see the same."""
TIMES: Final = 5.0
"""Times what the lenses leave, and `ROUGH` pixels, from which on one pair of views did not."""
ROUGH: Final = 1.0
NEAREST: Final = 1.0
"""mm between two cameras; those that are nearer are one."""
FEWEST: Final = 6
"""Corners that both see in a pair of views that counts."""


@dataclass(frozen=True, slots=True)
class PairFound:
    """pose: of the second camera in the frame of the first one. residual: pixels, root mean square
    over u and v. views: pairs that counted.
    """

    pose: Pose
    residual: float
    views: int


def find_pair(
    board: Board,
    lenses: tuple[Lens, Lens],
    views: Sequence[tuple[View, View]],
    names: tuple[str, str] = ("first", "second"),
    lens_residual: float = 0.0,
) -> PairFound:
    """By OpenCV's stereoCalibrate with the lenses as they are.

    names: of the cameras, for messages. lens_residual: pixels that their lenses leave of the same
    views. Raises Refused for too few views, for those that do not belong together, and for two
    cameras that are one.
    """
    cv = opencv()
    objects, seen = list[object](), (list[object](), list[object]())
    counted = list[tuple[View, View]]()
    for pair in views:
        rows = np.intersect1d(pair[0].rows, pair[1].rows)
        if len(rows) < FEWEST:
            continue
        objects.append(board.corners[rows].astype(np.float32))
        counted.append(pair)
        for pixels, view in zip(seen, pair, strict=True):
            places = {int(row): i for i, row in enumerate(view.rows)}
            some = view.pixels[[places[int(row)] for row in rows]]
            pixels.append(some.astype(np.float32)[:, None])
    if len(objects) < LEAST:
        raise Refused(rules.FEW_VIEWS(count=len(objects), least=LEAST))
    optics = [part for lens in lenses for part in (lens.matrix, np.array(lens.distortion))]
    found = cv.stereoCalibrateExtended(
        *(objects, *seen, *optics, lenses[0].size, np.eye(3), np.zeros(3)),
        flags=cv.CALIB_FIX_INTRINSIC,
    )
    turn, place, of_views = np.asarray(found[5]), np.ravel(found[6]), np.asarray(found[-1])
    left = float(found[0]) / np.sqrt(2.0)
    worst = int(np.argmax(of_views.max(axis=1)))
    most = float(of_views.max()) / np.sqrt(2.0)
    if not (left < MOST_LEFT and most < max(ROUGH, TIMES * lens_residual)):
        files = [view.name for view in counted[worst]]
        raise Refused(
            rules.APART(
                one=names[0],
                other=names[1],
                residual=left,
                most=most,
                first=files[0],
                second=files[1],
            )
        )
    if float(np.linalg.norm(place)) < NEAREST:
        raise Refused(rules.ONE_PLACE(one=names[0], other=names[1]))
    into = Pose.of(place, np.ravel(rotations.from_matrix(turn)))
    return PairFound(into.inverse(), left, len(objects))
