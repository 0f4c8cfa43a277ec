"""Hand-eye calibration: the pose of a camera on the flange or beside the arm, from poses of both.

In the hand: flange (in the base) · camera (in the flange) · board (in the camera) is the pose of
the board in the base, the same in all views. Beside the arm, with the board on the hand: the pose
of the board on the flange is the same in all views. OpenCV's seven methods are compared; poses that
contradict the others are left out by least median of squares, and a leave-one-out test gives the
standard deviations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.program.geometry import Pose
from assistant.vision import rules
from assistant.vision.opencv import opencv

Mounting = Literal["hand", "stand"]
METHODS: Final = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS", "SHAH", "LI")
_METHODS_WITH_WORLD: Final = ("SHAH", "LI")
"""Methods that find the pose of the board at the same time."""
_ROBUST_METHOD: Final = "PARK"
"""By which samples of the poses are solved: in closed form, and exact for exact poses."""
_FEWEST_POSES: Final = 4
"""Poses; three would do without noise, and would leave nothing to judge by."""
_LEAST_SECOND_TURN: Final = 10.0
"""Degrees about a second axis at least."""
_MOST_HAND_EYE_RESIDUAL: Final = 20.0
"""mm left from which on poses and pictures do not belong together."""
_ROBUST_SAMPLES: Final = 80
"""Samples of `_FEWEST_POSES` poses by which a camera is found that most of the others agree with:
with one pose of four wrong, at least one sample is right in all but 1e-13 of the cases."""
_OUTLIER_SIGMAS: Final = 6.0
"""Robust sigmas from the other poses from which on a pose does not belong to them."""
_OUTLIER_FLOOR: Final = (0.05, 0.01)
"""mm and degrees within which poses are not distinguished: rounding, and a handful of poses that
fit alike.
"""
_MOST_OUTLIERS: Final = 0.25
"""Part of the poses that may be left out."""
_MEDIAN_LENGTH: Final = 1.538
"""Median of the length of three Gaussian numbers of one sigma each."""
_ARM_ACCURACY: Final = 1.0
"""mm that a pose of an arm may be off: the accuracy of arms that were not calibrated."""


@dataclass(frozen=True, slots=True)
class HandEyeSolution:
    """camera: in the flange (hand) or in the base (stand). mm, degrees: root mean square of what
    is left of the poses in all views.
    """

    method: str
    camera: Pose
    mm: float
    degrees: float


@dataclass(frozen=True, slots=True)
class HandEyeFound:
    """The place of a camera at an arm, and how well the poses determine it.

    best: with the least that is left. solutions: of all methods, in their order. held_out: mm and
    degrees that are left in views that were not used, each in its turn. sigma: mm and degrees, one
    sigma of the camera's place. left_out: rows of the poses that do not belong to the others.
    """

    best: HandEyeSolution
    solutions: tuple[HandEyeSolution, ...]
    held_out: tuple[float, float]
    sigma: tuple[float, float]
    left_out: tuple[int, ...] = ()
    findings: tuple[Diagnostic, ...] = ()


def find_hand_eye(
    flanges: Sequence[Pose],
    boards: Sequence[Pose],
    mounting: Mounting,
    names: Sequence[str] = (),
    noise: float = 0.0,
    lens: tuple[float, float] = (0.0, 0.0),
) -> HandEyeFound:
    """Place a camera in the hand of an arm or beside it.

    flanges: in the base. boards: in the camera, of the same moments. names: of the poses, for
    messages; their numbers if left out. noise: mm, one sigma of a board in a picture. lens: one
    sigma of the focal length as a part of it, and of the centre in degrees; both shift all
    boards alike, so that no pose contradicts them.

    By OpenCV's calibrateHandEye and calibrateRobotWorldHandEye, by each of their methods; the one
    with the least left is best. A single pose that contradicts the others is left out and reported.
    Raises Refused for poses that do not determine the camera, or do not belong together.
    """
    if len(flanges) != len(boards) or len(flanges) < _FEWEST_POSES:
        raise Refused(rules.FEW_POSES(count=min(len(flanges), len(boards)), least=_FEWEST_POSES))
    _check_turns(flanges)
    cv = opencv()
    wrong = _outlier_rows(cv, flanges, boards, mounting)
    titles = names or [str(number + 1) for number in range(len(flanges))]
    if len(wrong) > _MOST_OUTLIERS * len(flanges):
        which = ", ".join(titles[row] for row in wrong)
        raise Refused(rules.MANY_WRONG_POSES(count=len(wrong), total=len(flanges), which=which))
    kept = [row for row in range(len(flanges)) if row not in wrong]
    hands, seen = [flanges[row] for row in kept], [boards[row] for row in kept]
    if wrong:
        _check_turns(hands)
    solved = _solutions(cv, hands, seen, mounting)
    best = min(solved, key=lambda one: one.mm)
    if best.mm > _MOST_HAND_EYE_RESIDUAL:
        raise Refused(_methods_differ(solved, best))
    findings = list[Diagnostic]()
    for row, mm, degrees in _outlier_distances(flanges, boards, mounting, best.camera, kept, wrong):
        findings.append(rules.WRONG_POSE(name=titles[row], mm=mm, degrees=degrees))
    if best.mm > _ARM_ACCURACY + _OUTLIER_SIGMAS / 2.0 * noise:
        findings.append(rules.LARGE_HAND_EYE_RESIDUAL(mm=best.mm, explained=noise))
    held_out, sigma = _leave_one_out(cv, hands, seen, mounting, best.method)
    away = float(np.mean([np.linalg.norm(one.position) for one in seen]))
    unsure = float(np.hypot(sigma[0], lens[0] * away)), float(np.hypot(sigma[1], lens[1]))
    return HandEyeFound(best, solved, held_out, unsure, tuple(wrong), tuple(findings))


def _outlier_rows(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting
) -> list[int]:
    """Rows that are far from what most poses agree on (least median of squares).

    Rousseeuw, Least median of squares regression, 1984: of cameras by samples of the poses the one
    that has the smallest median deviation; a row that is `_OUTLIER_SIGMAS` robust sigmas off it is
    wrong.
    """
    count = len(flanges)
    if count <= _FEWEST_POSES:
        return []
    draw = np.random.default_rng(1)
    best, scales = None, (np.inf, np.inf)
    for _ in range(_ROBUST_SAMPLES):
        some = sorted(draw.choice(count, _FEWEST_POSES, replace=False).tolist())
        found = _deviations(cv, flanges, boards, mounting, some)
        if found is not None and _robust_sigma(found[0]) < scales[0]:
            best, scales = found, (_robust_sigma(found[0]), _robust_sigma(found[1]))
    kept = list(range(count))
    for _ in range(10):
        if best is None:
            return []
        limits = [
            _OUTLIER_SIGMAS * max(one, least)
            for one, least in zip(scales, _OUTLIER_FLOOR, strict=True)
        ]
        good = np.flatnonzero((best[0] <= limits[0]) & (best[1] <= limits[1])).tolist()
        if good == kept or len(good) < _FEWEST_POSES:
            break
        kept = good
        best = _deviations(cv, flanges, boards, mounting, kept)
        if best is not None:
            scales = _robust_sigma(best[0][kept]), _robust_sigma(best[1][kept])
    return [row for row in range(count) if row not in kept]


def _robust_sigma(deviations: Floats) -> float:
    """One sigma along an axis, of a sample that may hold wrong values."""
    count = len(deviations)
    few = 1.0 + 5.0 / max(count - _FEWEST_POSES, 1)  # Rousseeuw and Leroy 1987, for small samples
    return float(np.median(deviations)) / _MEDIAN_LENGTH * few


def _deviations(
    cv: Any,
    flanges: Sequence[Pose],
    boards: Sequence[Pose],
    mounting: Mounting,
    some: Sequence[int],
) -> tuple[Floats, Floats] | None:
    """(n,) mm and (n,) degrees of each row from the mean of some, by the camera of those."""
    camera = _solve(
        cv, [flanges[i] for i in some], [boards[i] for i in some], mounting, _ROBUST_METHOD
    )
    if camera is None:
        return None
    p, q = _board_poses(flanges, boards, mounting, camera)
    rows = list(some)
    turned = rotations.angle_between(q, np.tile(_mean_turn(q[rows]), (len(q), 1)))
    return np.linalg.norm(p - np.median(p[rows], axis=0), axis=1), np.asarray(turned)


def _outlier_distances(
    flanges: Sequence[Pose],
    boards: Sequence[Pose],
    mounting: Mounting,
    camera: Pose,
    kept: Sequence[int],
    wrong: Sequence[int],
) -> list[tuple[int, float, float]]:
    """The wrong rows: number, and mm and degrees from where the others put the board."""
    p, q = _board_poses(flanges, boards, mounting, camera)
    there, mean = p[list(kept)].mean(axis=0), _mean_turn(q[list(kept)])
    return [
        (row, float(np.linalg.norm(p[row] - there)), float(rotations.angle_between(q[row], mean)))
        for row in wrong
    ]


def _mean_turn(q: Floats) -> Floats:
    return np.ravel(rotations.canonical(np.linalg.eigh(q.T @ q)[1][:, -1]))


def _methods_differ(solved: Sequence[HandEyeSolution], best: HandEyeSolution) -> Any:
    away = [np.subtract(one.camera.position, best.camera.position) for one in solved]
    turned = [
        float(rotations.angle_between(one.camera.quaternion, best.camera.quaternion))
        for one in solved
    ]
    mm = float(np.linalg.norm(away, axis=1).max())
    return rules.METHODS_DIFFER(mm=mm, degrees=max(turned), residual=best.mm)


def _solutions(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting
) -> tuple[HandEyeSolution, ...]:
    found = []
    for method in METHODS:
        camera = _solve(cv, flanges, boards, mounting, method)
        if camera is not None:
            found.append(
                HandEyeSolution(method, camera, *_pose_residuals(flanges, boards, mounting, camera))
            )
    if not found:
        raise Refused(rules.ONE_ROTATION_AXIS(least=_LEAST_SECOND_TURN))
    return tuple(found)


def _solve(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, method: str
) -> Pose | None:
    """A camera beside the arm is solved as one in the hand, with flanges the other way round."""
    hands = flanges if mounting == "hand" else [one.inverse() for one in flanges]
    try:
        if method in _METHODS_WITH_WORLD:
            turn, place = _solve_with_world(cv, hands, boards, method)
        else:
            number = getattr(cv, f"CALIB_HAND_EYE_{method}")
            turn, place = cv.calibrateHandEye(
                *_rotations_and_positions(hands), *_rotations_and_positions(boards), method=number
            )
    except cv.error:
        return None
    turn, place = np.asarray(turn), np.ravel(place)
    if not (np.isfinite(turn).all() and np.isfinite(place).all()):
        return None
    if abs(np.linalg.det(turn) - 1.0) > 1e-3:
        return None
    return Pose.of(place, np.ravel(rotations.from_matrix(turn)))


def _solve_with_world(
    cv: Any, hands: Sequence[Pose], boards: Sequence[Pose], method: str
) -> tuple[Floats, Floats]:
    """It answers with the flange in the camera, where calibrateHandEye has the camera in it."""
    number = getattr(cv, f"CALIB_ROBOT_WORLD_HAND_EYE_{method}")
    bases = [one.inverse() for one in hands]
    found = cv.calibrateRobotWorldHandEye(
        *_rotations_and_positions(boards), *_rotations_and_positions(bases), method=number
    )
    turn, place = np.asarray(found[2]), np.ravel(found[3])
    return turn.T, -turn.T @ place


def _rotations_and_positions(poses: Sequence[Pose]) -> tuple[list[Floats], list[Floats]]:
    turns = [rotations.to_matrix(np.array(one.quaternion)) for one in poses]
    return turns, [np.array(one.position) for one in poses]


def _pose_residuals(
    flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, camera: Pose
) -> tuple[float, float]:
    """Mm and degrees, root mean square, by which the place differs that should be the same."""
    p, q = _board_poses(flanges, boards, mounting, camera)
    turned = rotations.angle_between(q, np.tile(_mean_turn(q), (len(q), 1)))
    off = p - p.mean(axis=0)
    return float(np.sqrt((off**2).sum(axis=1).mean())), float(np.sqrt((turned**2).mean()))


def _board_poses(
    flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, camera: Pose
) -> tuple[Floats, Floats]:
    """Return the poses of the board: in the base, or on the flange."""
    hands = flanges if mounting == "hand" else [one.inverse() for one in flanges]
    places = [hand @ camera @ board for hand, board in zip(hands, boards, strict=True)]
    return np.array([p.position for p in places]), np.array([p.quaternion for p in places])


def _leave_one_out(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, method: str
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Distance of each view from where all others put the board, and one sigma of the camera's
    place by how much it changes without each view (jackknife), each in mm and degrees.
    """
    found, cameras = list[tuple[float, float]](), list[Pose]()
    for out in range(len(flanges)):
        rest = [i for i in range(len(flanges)) if i != out]
        some = [flanges[i] for i in rest], [boards[i] for i in rest]
        camera = _solve(cv, *some, mounting, method)
        if camera is None:
            continue
        cameras.append(camera)
        p, q = _board_poses(*some, mounting, camera)
        there, turned = _board_poses([flanges[out]], [boards[out]], mounting, camera)
        angle = float(np.ravel(rotations.angle_between(turned, _mean_turn(q)[None]))[0])
        found.append((float(np.linalg.norm(there[0] - p.mean(axis=0))), angle))
    if not found:
        nan = float("nan")
        return (nan, nan), (nan, nan)
    mm, degrees = np.sqrt((np.array(found) ** 2).mean(axis=0))
    count = len(cameras)
    places = np.array([one.position for one in cameras])
    turns = np.array([one.quaternion for one in cameras])
    apart = rotations.angle_between(turns, np.tile(_mean_turn(turns), (count, 1)))
    moved = ((places - places.mean(axis=0)) ** 2).sum()
    sigma = np.sqrt((count - 1) / count * np.array([moved, (apart**2).sum()]))
    return (float(mm), float(degrees)), (float(sigma[0]), float(sigma[1]))


def _check_turns(flanges: Sequence[Pose]) -> None:
    """Raises Refused where the hand does not turn about two axes."""
    first = flanges[0].inverse()
    turns = [np.array((first @ one).quaternion) for one in flanges[1:]]
    vectors = np.array(
        [
            2.0 * np.degrees(np.arctan2(np.linalg.norm(q[1:]), q[0])) * _unit_vector(q[1:])
            for q in turns
        ]
    )
    spread = np.linalg.svd(vectors, compute_uv=False)
    if len(spread) < 2 or spread[1] / np.sqrt(len(vectors)) < _LEAST_SECOND_TURN / 2.0:
        raise Refused(rules.ONE_ROTATION_AXIS(least=_LEAST_SECOND_TURN))


def _unit_vector(vector: Floats) -> Floats:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


_METHOD_SOURCES: Final[Mapping[str, str]] = {
    "TSAI": "Tsai and Lenz 1989",
    "PARK": "Park and Martin 1994",
    "HORAUD": "Horaud and Dornaika 1995",
    "ANDREFF": "Andreff et al. 1999",
    "DANIILIDIS": "Daniilidis 1999",
    "SHAH": "Shah 2013",
    "LI": "Li, Wang and Wu 2010",
}
"""Sources of the methods, as OpenCV's documentation names them."""
