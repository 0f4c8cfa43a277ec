"""Calibrate the cameras of a rig with pictures of a board: lenses, and their poses to each other.

Boards: `chessboard 9x6 25` has 9 × 6 inner corners and squares of 25 mm; `charuco 7x5 40 30` has
7 × 5 squares of 40 mm with markers of 30 mm, of the dictionary 5X5_100 or of one named after them.
Lenses come from OpenCV's calibrateCamera, pairs of cameras from its stereoCalibrate with views of
the same moments; each result states its standard deviations. `calibrate_rig` places the cameras
relative to the first one, or to an arm if poses of its flange are given (`hand_eye`).
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats, Rows, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision import rules
from assistant.vision.cameras.camera import WORLD, Camera, Lens
from assistant.vision.cameras.camera_file import CalibrationRecord, Rig
from assistant.vision.cameras.capture import pairing_finding, pictures_in, read_picture
from assistant.vision.cameras.hand_eye import HandEyeFound, Mounting, find_hand_eye
from assistant.vision.cameras.synthetic_pictures import Picture
from assistant.vision.opencv import opencv, silent

_USUAL_DICTIONARY: Final = "5X5_100"
_BOARD_TEXT: Final = re.compile(
    r"(?P<kind>chessboard|charuco) (?P<columns>\d{1,3})x(?P<rows>\d{1,3}) (?P<square>\d+(?:\.\d+)?)"
    r"(?: (?P<marker>\d+(?:\.\d+)?))?(?: (?P<dictionary>[4-7]X[4-7]_(?:50|100|250|1000)))?"
)
_BOARD_EXAMPLES: Final = "write `chessboard 9x6 25`, or `charuco 7x5 40 30`"
_FEWEST_CORNERS: Final = 6
"""Corners of a view that counts."""


@dataclass(frozen=True, slots=True)
class Board:
    """columns, rows: inner corners of a chessboard, squares of a ChArUco board. square, marker: mm,
    edges.
    """

    kind: Literal["chessboard", "charuco"]
    columns: int
    rows: int
    square: float
    marker: float = 0.0
    dictionary: str = _USUAL_DICTIONARY

    @staticmethod
    def parse(text: str) -> Board:
        """Parse the text of a board; raises Refused (exit status 2)."""
        found = _BOARD_TEXT.fullmatch(" ".join(text.split()))
        if found is None:
            raise _bad_board(text, "it is none of the two forms", _BOARD_EXAMPLES)
        columns, rows = int(found["columns"]), int(found["rows"])
        square, marker = float(found["square"]), float(found["marker"] or 0.0)
        charuco = found["kind"] == "charuco"
        if not (3 <= columns <= 60 and 3 <= rows <= 60 and 0.1 <= square <= 1000.0):
            raise _bad_board(text, "its numbers are those of no board", _BOARD_EXAMPLES)
        if charuco != (0.0 < marker < square):
            raise _bad_board(
                text,
                "a marker is smaller than its square, and only ChArUco has it",
                _BOARD_EXAMPLES,
            )
        if not charuco and found["dictionary"]:
            raise _bad_board(text, "a chessboard has no dictionary", _BOARD_EXAMPLES)
        named = found["dictionary"] or _USUAL_DICTIONARY
        if charuco and columns * rows // 2 > int(named.partition("_")[2]):
            raise _bad_board(text, f"it has more markers than {named}", "name a larger dictionary")
        kind: Literal["chessboard", "charuco"] = "charuco" if charuco else "chessboard"
        return Board(kind, columns, rows, square, marker, named)

    @property
    def across(self) -> tuple[int, int]:
        """Inner corners, along the rows and down."""
        less = 1 if self.kind == "charuco" else 0
        return self.columns - less, self.rows - less

    @property
    def corners(self) -> Floats:
        """(n, 3) mm of its inner corners; x along the rows from the first one, y down them."""
        columns, rows = self.across
        u, v = np.meshgrid(np.arange(columns), np.arange(rows))
        flat = np.column_stack([u.ravel(), v.ravel(), np.zeros(u.size)]).astype(np.float64)
        return np.asarray(flat * self.square)

    def picture(self, dots: int = 60) -> Picture:
        """The board to print or to draw, so many dots a square, without a margin (ChArUco).

        A chessboard has one square more than corners each way.
        """
        cv = opencv()
        if self.kind == "charuco":
            size = self.columns * dots, self.rows * dots
            drawn = self._opencv(cv).generateImage(size, marginSize=0)
            return np.repeat(np.asarray(drawn)[..., None], 3, axis=2)
        squares = np.indices((self.rows + 1, self.columns + 1)).sum(axis=0) % 2
        drawn = np.kron(squares, np.ones((dots, dots))) * 255
        return np.repeat(drawn.astype(np.uint8)[..., None], 3, axis=2)

    @property
    def turned_alike(self) -> bool:
        """True if it looks the same after half a turn: its corners are then ambiguous."""
        return self.kind == "chessboard" and (self.columns + self.rows) % 2 == 0

    @property
    def size(self) -> tuple[float, float]:
        """Mm of `picture`."""
        more = 0 if self.kind == "charuco" else 1
        return (self.columns + more) * self.square, (self.rows + more) * self.square

    @property
    def on_card(self) -> Pose:
        """Its frame, x along the rows and y down them, in that of a card with its picture."""
        width, height = self.size
        return Pose(
            (self.square - width / 2.0, height / 2.0 - self.square, 0.0), (0.0, 1.0, 0.0, 0.0)
        )

    def _opencv(self, cv: Any) -> Any:
        named = cv.aruco.getPredefinedDictionary(getattr(cv.aruco, f"DICT_{self.dictionary}"))
        squares = self.columns, self.rows
        with silent():  # it would say that markers are large for their squares
            return cv.aruco.CharucoBoard(squares, self.square, self.marker, named)


@dataclass(frozen=True, slots=True, eq=False)
class BoardView:
    """Corners of a board in a picture. rows: (n,) of `Board.corners`. pixels: (n, 2)."""

    name: str
    rows: Rows
    pixels: Floats


def find_board(board: Board, picture: Picture, name: str) -> BoardView | None:
    """The board in a picture, None if it is not seen; raises Refused for a mirrored one."""
    cv = opencv()
    grey = cv.cvtColor(picture, cv.COLOR_BGR2GRAY)
    found = (
        _find_charuco(cv, board, grey)
        if board.kind == "charuco"
        else _find_chessboard(cv, board, grey)
    )
    if found is None:
        if board.kind == "charuco":
            mirror = _find_charuco(cv, board, np.ascontiguousarray(grey[:, ::-1]))
            if mirror is not None:
                raise Refused(rules.MIRRORED_BOARD(name=name))
        return None
    rows, pixels = found
    return BoardView(name, rows, pixels)


def _find_charuco(cv: Any, board: Board, grey: Any) -> tuple[Rows, Floats] | None:
    detector = cv.aruco.CharucoDetector(board._opencv(cv))
    corners, ids, _, _ = detector.detectBoard(grey)
    if ids is None or len(ids) < _FEWEST_CORNERS:
        return None
    rows = np.asarray(ids).ravel().astype(np.intp)
    pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    flat = np.ptp(board.corners[rows], axis=0)[:2].min() <= 0.0
    return None if flat else (rows, pixels)


def _find_chessboard(cv: Any, board: Board, grey: Any) -> tuple[Rows, Floats] | None:
    found, corners = cv.findChessboardCornersSB(grey, board.across)
    if not found:
        return None
    pixels = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
    return np.arange(len(pixels), dtype=np.intp), pixels


def _bad_board(text: str, reason: str, cure: str) -> Refused:
    shown = "".join(c if c.isprintable() else "?" for c in text)[:60]
    return Refused(rules.BAD_BOARD(text=shown, reason=reason, cure=cure), exit_status=2)


_FEWEST_VIEWS: Final = 4
"""Fewest views; each adds six unknowns and the lens has nine."""
_LEAST_TILT: Final = 10.0
"""Degrees between the most unlike views of a board below which depth and focal length are one."""
_MOST_FOCAL_SIGMA: Final = 1.0
"""Percent of the focal length, one sigma."""
_LEAST_K3_SIGMAS: Final = 3.0
"""Times its sigma from which on the third coefficient of the distortion is one."""
_MOST_LENS_RESIDUAL: Final = 1.0
"""Pixels that sharp views do not leave."""
_LEAST_COVERAGE: Final = 0.25
"""Part of the picture inside of all corners below which the lens is extrapolated."""
_MOST_CENTRE_SIGMA: Final = 1.0
"""Percent of the width of the picture, one sigma of the centre."""
LENS_PARAMETERS: Final = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
"""Parameters of a lens, in the order of `LensFound.sigma`."""


@dataclass(frozen=True, slots=True, eq=False)
class LensFound:
    """A lens, and how well the views determine it.

    residual: pixels, root mean square over u and v of all corners. of_views: (n,) the same of each
    view. poses: of the board in the camera, one a view. sigma: (9,) one sigma of `LENS_PARAMETERS`,
    0 of one that was left out. coverage: part of the picture, 0 to 1, inside of all corners that
    were seen. noise_mm: one sigma of the place of a board in a view, root mean square over the
    views.
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
    if len(views) < _FEWEST_VIEWS:
        raise Refused(rules.FEW_VIEWS(count=len(views), least=_FEWEST_VIEWS))
    cv = opencv()
    objects = [board.corners[view.rows].astype(np.float32) for view in views]
    pixels = [view.pixels.astype(np.float32)[:, None] for view in views]
    lens, found = _fit_lens(cv, objects, pixels, size)
    sigma = np.ravel(found[5])
    poses = tuple(
        _pose_of_opencv(turn, place) for turn, place in zip(found[3], found[4], strict=True)
    )
    _check_determined(poses, sigma, lens)
    sigma = sigma[: len(LENS_PARAMETERS)]
    percent = float(100.0 * sigma[:2].max() / min(lens.focal))
    # OpenCV divides by corners; here it is the mean of u and v, as noise of pixels is told.
    share = 1.0 / np.sqrt(2.0)
    left = float(found[0]) * share
    unsure = percent > _MOST_FOCAL_SIGMA or left > _MOST_LENS_RESIDUAL
    findings = [rules.POOR_LENS(name=name, residual=left, percent=percent)] if unsure else []
    coverage, centre = _coverage(cv, views, size), float(sigma[2:4].max())
    if coverage < _LEAST_COVERAGE or centre > _MOST_CENTRE_SIGMA / 100.0 * size[0]:
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
    """Return the lens with as many distortion terms as the views determine, and OpenCV's result for
    it.
    """
    for flags in (0, cv.CALIB_FIX_K3, cv.CALIB_FIX_K3 | cv.CALIB_FIX_K2):
        try:
            found = cv.calibrateCameraExtended(objects, pixels, size, None, None, flags=flags)
        except cv.error:
            raise Refused(rules.VIEWS_ALIKE(what="no lens fits them")) from None
        lens = _lens_of_opencv(size, found[1], np.ravel(found[2]))
        told = flags or abs(lens.distortion[4]) > _LEAST_K3_SIGMAS * float(np.ravel(found[5])[8])
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


def _pose_of_opencv(turn: Any, place: Any) -> Pose:
    """The pose that OpenCV writes as a vector of turning (radians) and one of place."""
    vector = np.ravel(np.asarray(turn, dtype=np.float64))
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    return Pose.of(np.ravel(place), np.ravel(rotations.about(axis, np.degrees(angle))))


def _check_determined(poses: Sequence[Pose], sigma: Floats, lens: Lens) -> None:
    """Raises Refused where the views leave open what the lens is."""
    faces = np.array([rotations.to_matrix(np.array(p.quaternion))[:, 2] for p in poses])
    most = float(np.degrees(np.arccos(np.clip((faces @ faces.T).min(), -1.0, 1.0))))
    if most < _LEAST_TILT:
        raise Refused(
            rules.VIEWS_ALIKE(what=f"the board is tilted by {most:.1f} degrees between them")
        )
    focal = lens.focal[0]
    if not np.isfinite(sigma).all() or not 0.0 < focal < 1e6 or sigma[0] > 0.1 * focal:
        raise Refused(rules.VIEWS_ALIKE(what="they leave the focal length open"))
    if not lens.whole:
        raise Refused(rules.VIEWS_ALIKE(what="they leave open what the lens does at the edges"))


_MOST_PAIR_RESIDUAL: Final = 5.0
"""Pixels left from which on two cameras did not see the same."""
_VIEW_RESIDUAL_RATIO: Final = 5.0
"""Times what the lenses leave, and `_VIEW_RESIDUAL_FLOOR` pixels, from which on one pair of views
did not."""
_VIEW_RESIDUAL_FLOOR: Final = 1.0
_LEAST_BASE_LINE: Final = 1.0
"""mm between two cameras; those that are nearer are one."""
_FEWEST_SHARED_CORNERS: Final = 6
"""Corners that both see in a pair of views that counts."""
_MOST_PAIR_SIGMA: Final = (0.5, 0.5)
"""Percent of the base line and degrees, one sigma: depth is wrong by the same percentage."""
_LENS_PARAMETER_COUNT: Final = 9
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
        if len(rows) < _FEWEST_SHARED_CORNERS:
            continue
        objects.append(board.corners[rows].astype(np.float32))
        counted.append(pair)
        for pixels, view in zip(seen, pair, strict=True):
            places = {int(row): i for i, row in enumerate(view.rows)}
            some = view.pixels[[places[int(row)] for row in rows]]
            pixels.append(some.astype(np.float32)[:, None])
    if len(objects) < _FEWEST_VIEWS:
        raise Refused(rules.FEW_VIEWS(count=len(objects), least=_FEWEST_VIEWS))
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
        left < _MOST_PAIR_RESIDUAL
        and most < max(_VIEW_RESIDUAL_FLOOR, _VIEW_RESIDUAL_RATIO * lens_residual)
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
    if base_line < _LEAST_BASE_LINE:
        raise Refused(rules.SAME_CAMERA_POSITION(one=names[0], other=names[1]))
    into = Pose.of(place, np.ravel(rotations.from_matrix(turn)))
    open_ones = free or (
        np.ones(_LENS_PARAMETER_COUNT, np.bool_),
        np.ones(_LENS_PARAMETER_COUNT, np.bool_),
    )
    covariance = left**2 * _pair_covariance(
        cv, objects, optics, (turn, place), found[9:11], open_ones
    )
    along = place / base_line
    mm = float(np.sqrt(along @ covariance[3:, 3:] @ along))
    degrees = float(np.degrees(np.sqrt(np.trace(covariance[:3, :3]))))
    percent = 100.0 * mm / base_line
    findings: tuple[Diagnostic, ...] = ()
    if percent > _MOST_PAIR_SIGMA[0] or degrees > _MOST_PAIR_SIGMA[1]:
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


@dataclass(frozen=True, slots=True, eq=False)
class BoardPictures:
    """Pictures of one camera. views: of each picture, None where the board is not found."""

    name: str
    size: tuple[int, int]
    files: tuple[str, ...]
    views: tuple[BoardView | None, ...]
    findings: tuple[Diagnostic, ...]


@dataclass(frozen=True, slots=True)
class RigFound:
    """lenses, pairs: by camera; pairs to the first one. hand_eye: of the first, where poses were
    given.
    """

    rig: Rig
    lenses: Mapping[str, LensFound]
    pairs: Mapping[str, PairFound]
    hand_eye: HandEyeFound | None
    findings: tuple[Diagnostic, ...]


def find_board_in_folder(board: Board, name: str, folder: str | FilePath) -> BoardPictures:
    """Finds the board in the pictures of a folder; raises Refused for one that holds none."""
    files = pictures_in(folder) if FilePath(folder).is_dir() else []
    if not files:
        raise Refused(rules.NO_PICTURES(name=name, folder=folder), exit_status=2)
    size, views, findings = (0, 0), list[BoardView | None](), list[Diagnostic]()
    for number, file in enumerate(files):
        picture = read_picture(file)
        given = picture.shape[1], picture.shape[0]
        if number and given != size:
            told = [f"{w} × {h}" for w, h in (given, size)]
            finding = rules.UNEQUAL_SIZES(name=file, given=told[0], wanted=told[1])
            raise Refused(finding, exit_status=2)
        size = given
        views.append(find_board(board, picture, str(file)))
        if views[-1] is None:
            findings.append(rules.NO_BOARD(name=file))
    names = tuple(file.name for file in files)
    return BoardPictures(name, size, names, tuple(views), tuple(findings))


def calibrate_rig(
    board: Board,
    looked: Sequence[BoardPictures],
    *,
    flanges: Sequence[Pose] | None = None,
    mounting: Mounting = "stand",
    flange: str = "flange",
    today: datetime.date | None = None,
) -> RigFound:
    """The cameras of a rig, the first one at the world's origin unless the arm tells where it is.

    flanges: poses of the flange in the base, one a picture. mounting: of the first camera, in the
    hand or beside the arm; its pose is then in the flange, or in the base, where the others stand
    as well. flange: how the file calls the flange. Raises Refused where pictures do not tell it.
    """
    if board.turned_alike and (len(looked) > 1 or flanges is not None):
        raise Refused(rules.AMBIGUOUS_BOARD(columns=board.columns, rows=board.rows), exit_status=2)
    findings = [finding for one in looked for finding in one.findings]
    lenses = {
        one.name: find_lens(board, [v for v in one.views if v is not None], one.size, one.name)
        for one in looked
    }
    findings += [finding for found in lenses.values() for finding in found.findings]
    first = looked[0]
    found = _place_on_arm(first, lenses[first.name], flanges, mounting)
    findings += () if found is None else found.findings
    place = Pose() if found is None else found.best.camera
    carried = found is not None and mounting == "hand"
    pairs = {one.name: _place_pair(board, first, one, lenses) for one in looked[1:]}
    findings += [finding for pair in pairs.values() for finding in pair.findings]
    parent = flange if carried else WORLD
    cameras = {first.name: Camera(first.name, lenses[first.name].lens, place, parent)}
    for one in looked[1:]:
        pose = place @ pairs[one.name].pose
        cameras[one.name] = Camera(one.name, lenses[one.name].lens, pose, parent)
    records = _calibration_records(
        lenses, pairs, found, today or datetime.datetime.now().astimezone().date()
    )
    return RigFound(Rig(cameras, records), lenses, pairs, found, tuple(findings))


def _calibration_records(
    lenses: Mapping[str, LensFound],
    pairs: Mapping[str, PairFound],
    hand_eye: HandEyeFound | None,
    day: datetime.date,
) -> dict[str, CalibrationRecord]:
    records = {name: CalibrationRecord(day, round(one.residual, 4)) for name, one in lenses.items()}
    for name, pair in pairs.items():
        records[name] = replace(records[name], pair=round(pair.residual, 4))
    if hand_eye is not None:
        name, best = next(iter(lenses)), hand_eye.best
        mm, degrees = round(best.mm, 4), round(best.degrees, 5)
        records[name] = replace(records[name], mm=mm, degrees=degrees)
    return records


def with_sources(rig: Rig, sources: Mapping[str, str]) -> Rig:
    """The rig with where the pictures of its cameras come from."""
    return replace(rig, sources=dict(sources))


def _place_pair(
    board: Board, first: BoardPictures, other: BoardPictures, lenses: Mapping[str, LensFound]
) -> PairFound:
    if len(first.views) != len(other.views):
        raise Refused(_uneven_views(first, other.name, len(other.views)))
    pairing = pairing_finding(first.name, first.files, other.name, other.files)
    if pairing is not None:
        raise Refused(pairing)
    both = [
        (one, two)
        for one, two in zip(first.views, other.views, strict=True)
        if one is not None and two is not None
    ]
    found = lenses[first.name], lenses[other.name]
    residual = max(one.residual for one in found)
    both_lenses = found[0].lens, found[1].lens
    free = found[0].sigma > 0.0, found[1].sigma > 0.0
    return find_pair(board, both_lenses, both, (first.name, other.name), residual, free)


def _place_on_arm(
    looked: BoardPictures, lens: LensFound, flanges: Sequence[Pose] | None, mounting: Mounting
) -> HandEyeFound | None:
    if flanges is None:
        return None
    if len(flanges) != len(looked.views):
        raise Refused(_uneven_views(looked, "poses of the arm", len(flanges)))
    seen = [i for i, view in enumerate(looked.views) if view is not None]
    names = [f"{i + 1} ({looked.files[i]})" for i in seen]
    focal, centre = max(lens.lens.focal), float(lens.sigma[2:4].max())
    unsure = float(lens.sigma[:2].max()) / focal, float(np.degrees(centre / focal))
    hands = [flanges[i] for i in seen]
    return find_hand_eye(hands, lens.poses, mounting, names, lens.noise_mm, unsure)


def _uneven_views(looked: BoardPictures, others: str, count: int) -> Diagnostic:
    here = len(looked.views)
    return rules.UNEVEN_VIEWS(name=looked.name, others=others, count=here, other=count)
