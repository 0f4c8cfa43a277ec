"""Where cameras stand to each other, from views of one board that both see at the same moments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Truths
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision.calibration import rules
from assistant.vision.calibration.boards import Board, BoardView
from assistant.vision.calibration.lenses import FEWEST_VIEWS
from assistant.vision.cameras.camera import Lens
from assistant.vision.opencv import opencv

MOST_PAIR_RESIDUAL: Final = 5.0
"""Pixels left from which on two cameras did not see the same."""
VIEW_RESIDUAL_RATIO: Final = 5.0
"""Times what the lenses leave, and `ROUGH` pixels, from which on one pair of views did not."""
VIEW_RESIDUAL_FLOOR: Final = 1.0
LEAST_BASE_LINE: Final = 1.0
"""mm between two cameras; those that are nearer are one."""
FEWEST_SHARED_CORNERS: Final = 6
"""Corners that both see in a pair of views that counts."""
MOST_PAIR_SIGMA: Final = (0.5, 0.5)
"""Percent of the base line and degrees, one sigma: depth is wrong by the same percentage."""
LENS_PARAMETER_COUNT: Final = 9
"""Parameters of a lens: two focal lengths, the centre, five of the distortion."""


@dataclass(frozen=True, slots=True)
class PairFound:
    """Pose of the second camera in the frame of the first one.

    residual: pixels, root mean square over u and v. views: pairs that counted. sigma_mm, sigma_deg:
    one sigma of the length of the base line and of the turn between the cameras, with what the
    lenses leave open.
    """

    pose: Pose
    residual: float
    views: int
    sigma_mm: float
    sigma_deg: float
    findings: tuple[Diagnostic, ...] = ()

    @property
    def base_line(self) -> float:
        """Mm between the cameras."""
        return float(np.linalg.norm(self.pose.position))


def find_pair(
    board: Board,
    lenses: tuple[Lens, Lens],
    views: Sequence[tuple[BoardView, BoardView]],
    names: tuple[str, str] = ("first", "second"),
    lens_residual: float = 0.0,
    free: tuple[Truths, Truths] | None = None,
) -> PairFound:
    """Place two cameras by OpenCV's stereoCalibrate with the lenses as they are.

    names: of the cameras, for messages. lens_residual: pixels that their lenses leave of the same
    views. free: (9,) for each camera, which parameters of its lens were found from these views and
    share their noise; all if left out. Raises Refused for too few views, for those that do not
    belong together, and for two cameras that are one.
    """
    cv = opencv()
    objects, seen = list[object](), (list[object](), list[object]())
    counted = list[tuple[BoardView, BoardView]]()
    for pair in views:
        rows = np.intersect1d(pair[0].rows, pair[1].rows)
        if len(rows) < FEWEST_SHARED_CORNERS:
            continue
        objects.append(board.corners[rows].astype(np.float32))
        counted.append(pair)
        for pixels, view in zip(seen, pair, strict=True):
            places = {int(row): i for i, row in enumerate(view.rows)}
            some = view.pixels[[places[int(row)] for row in rows]]
            pixels.append(some.astype(np.float32)[:, None])
    if len(objects) < FEWEST_VIEWS:
        raise Refused(rules.FEW_VIEWS(count=len(objects), least=FEWEST_VIEWS))
    optics = [part for lens in lenses for part in (lens.matrix, np.array(lens.distortion))]
    found = cv.stereoCalibrateExtended(
        *(objects, *seen, *optics, lenses[0].size, np.eye(3), np.zeros(3)),
        flags=cv.CALIB_FIX_INTRINSIC,
    )
    turn, place, of_views = np.asarray(found[5]), np.ravel(found[6]), np.asarray(found[-1])
    left = float(found[0]) / np.sqrt(2.0)
    worst = int(np.argmax(of_views.max(axis=1)))
    most = float(of_views.max()) / np.sqrt(2.0)
    if not (
        left < MOST_PAIR_RESIDUAL
        and most < max(VIEW_RESIDUAL_FLOOR, VIEW_RESIDUAL_RATIO * lens_residual)
    ):
        files = [view.name for view in counted[worst]]
        raise Refused(
            rules.LARGE_PAIR_RESIDUAL(
                one=names[0],
                other=names[1],
                residual=left,
                most=most,
                first=files[0],
                second=files[1],
            )
        )
    base_line = float(np.linalg.norm(place))
    if base_line < LEAST_BASE_LINE:
        raise Refused(rules.SAME_CAMERA_POSITION(one=names[0], other=names[1]))
    into = Pose.of(place, np.ravel(rotations.from_matrix(turn)))
    open_ones = free or (
        np.ones(LENS_PARAMETER_COUNT, np.bool_),
        np.ones(LENS_PARAMETER_COUNT, np.bool_),
    )
    covariance = left**2 * _pair_covariance(
        cv, objects, optics, (turn, place), found[9:11], open_ones
    )
    along = place / base_line
    mm = float(np.sqrt(along @ covariance[3:, 3:] @ along))
    degrees = float(np.degrees(np.sqrt(np.trace(covariance[:3, :3]))))
    percent = 100.0 * mm / base_line
    findings: tuple[Diagnostic, ...] = ()
    if percent > MOST_PAIR_SIGMA[0] or degrees > MOST_PAIR_SIGMA[1]:
        one, other = names
        said = rules.UNCERTAIN_PAIR(one=one, other=other, mm=mm, percent=percent, degrees=degrees)
        findings = (said,)
    return PairFound(into.inverse(), left, len(objects), mm, degrees, findings)


def _pair_covariance(
    cv: Any,
    objects: Sequence[Any],
    optics: Sequence[Any],
    between: tuple[Floats, Floats],
    boards: tuple[Any, Any],
    free: tuple[Truths, Truths],
) -> Floats:
    """Covariance (6, 6) of the turn (radians) and place (mm) between two cameras at 1 px of noise.

    The noise of all corners is carried through both steps to first order: the lenses are found from
    each camera's own views, then the place of the second camera and those of the boards with the
    lenses as they are.
    """
    vector, _ = cv.Rodrigues(between[0])
    count = len(objects)
    by_lens: tuple[list[Floats], list[Floats]] = ([], [])
    by_board: tuple[list[Floats], list[Floats]] = ([], [])
    placed: tuple[list[Floats], list[Floats]] = ([], [])
    for number, (corners, turn, place) in enumerate(zip(objects, *boards, strict=True)):
        _, one = cv.projectPoints(corners, turn, place, *optics[:2])
        found = cv.composeRT(turn, place, vector, between[1].reshape(3, 1))
        _, two = cv.projectPoints(corners, *found[:2], *optics[2:])
        # composeRT answers ∂r/∂(r1, t1, r2, t2), then ∂t/∂(r1, t1, r2, t2).
        pairs = zip(found[2:6], found[6:10], strict=True)
        changes = [two[:, :3] @ a + two[:, 3:6] @ b for a, b in pairs]
        boarded = one[:, :6], np.hstack(changes[:2])
        paired = np.zeros((len(one), 6)), np.hstack(changes[2:])
        for i, seen in enumerate((one, two)):
            by_lens[i].append(seen[:, 6:][:, free[i]])
            by_board[i].append(_columns_of_board(seen[:, :6], number, count))
            placed[i].append(np.hstack([paired[i], _columns_of_board(boarded[i], number, count)]))
    pair = _least_squares_inverse(np.vstack(placed[0] + placed[1]))[:6]
    parts = []
    for part, lens, board in zip(np.hsplit(pair, 2), by_lens, by_board, strict=True):
        slopes = np.vstack(lens)
        lens_found = _least_squares_inverse(np.hstack([slopes, np.vstack(board)]))[
            : slopes.shape[1]
        ]
        parts.append(part - part @ slopes @ lens_found)
    through = np.hstack(parts)
    return np.asarray(through @ through.T)


def _columns_of_board(columns: Floats, number: int, count: int) -> Floats:
    """Columns (n, 6) of one board among those of all of them."""
    wide = np.zeros((len(columns), 6 * count))
    wide[:, 6 * number : 6 * number + 6] = columns
    return wide


def _least_squares_inverse(slopes: Floats) -> Floats:
    """(k, n) by which least squares answer n measurements with k unknowns."""
    scale = np.linalg.norm(slopes, axis=0)
    scaled = slopes / scale
    return np.asarray(np.linalg.solve(scaled.T @ scaled, scaled.T) / scale[:, None])
