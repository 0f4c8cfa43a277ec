"""Where a camera is on a hand, or where it stands beside an arm, from poses of both.

In the hand: flange (in the base) · camera (in the flange) · board (in the camera) is the board's
place in the base, the same in all views. Beside the arm, with the board on the hand: the board's
place on the flange is the same in all views.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from assistant.program import rotations
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.vision.calibration import rules
from assistant.vision.opencv import opencv

Mounting = Literal["hand", "stand"]
METHODS: Final = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS", "SHAH", "LI")
WORLD_TOO: Final = ("SHAH", "LI")
"""Of these, those that find the place of the board at the same time."""
LEAST: Final = 4
"""Poses; three would do without noise, and would leave nothing to judge by."""
TURN: Final = 10.0
"""Degrees about a second axis at least."""
MOST_LEFT: Final = 20.0
"""mm left from which on poses and pictures do not belong together."""


@dataclass(frozen=True, slots=True)
class Solution:
    """camera: in the flange (hand) or in the base (stand). mm, degrees: root mean square of what
    is left of the poses in all views.
    """

    method: str
    camera: Pose
    mm: float
    degrees: float


@dataclass(frozen=True, slots=True)
class HandEyeFound:
    """best: with the least that is left. solutions: of all methods, in their order. held_out: mm
    and degrees that are left in views that were not used, each in its turn.
    """

    best: Solution
    solutions: tuple[Solution, ...]
    held_out: tuple[float, float]


def find_hand_eye(
    flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting
) -> HandEyeFound:
    """flanges: in the base. boards: in the camera, of the same moments.

    By OpenCV's calibrateHandEye and calibrateRobotWorldHandEye, by each of their methods; the one
    with the least left is best. Raises Refused for poses that do not tell it, or do not belong
    together.
    """
    if len(flanges) != len(boards) or len(flanges) < LEAST:
        raise Refused(rules.FEW_MOTIONS(count=min(len(flanges), len(boards)), least=LEAST))
    _check_turns(flanges)
    cv = opencv()
    solved = _solutions(cv, flanges, boards, mounting)
    best = min(solved, key=lambda one: one.mm)
    if best.mm > MOST_LEFT:
        raise Refused(_unlike(solved, best))
    return HandEyeFound(best, solved, _held_out(cv, flanges, boards, mounting, best.method))


def _unlike(solved: Sequence[Solution], best: Solution) -> Any:
    away = [np.subtract(one.camera.position, best.camera.position) for one in solved]
    turned = [
        float(rotations.angle_between(one.camera.quaternion, best.camera.quaternion))
        for one in solved
    ]
    mm = float(np.linalg.norm(away, axis=1).max())
    return rules.UNLIKE(mm=mm, degrees=max(turned), residual=best.mm)


def _solutions(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting
) -> tuple[Solution, ...]:
    found = []
    for method in METHODS:
        camera = _solved(cv, flanges, boards, mounting, method)
        if camera is not None:
            found.append(Solution(method, camera, *left(flanges, boards, mounting, camera)))
    if not found:
        raise Refused(rules.NO_TURNS(least=TURN))
    return tuple(found)


def _solved(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, method: str
) -> Pose | None:
    """A camera beside the arm is solved as one in the hand, with flanges the other way round."""
    hands = flanges if mounting == "hand" else [one.inverse() for one in flanges]
    try:
        if method in WORLD_TOO:
            turn, place = _with_world(cv, hands, boards, method)
        else:
            number = getattr(cv, f"CALIB_HAND_EYE_{method}")
            turn, place = cv.calibrateHandEye(*_parts(hands), *_parts(boards), method=number)
    except cv.error:
        return None
    turn, place = np.asarray(turn), np.ravel(place)
    if not (np.isfinite(turn).all() and np.isfinite(place).all()):
        return None
    if abs(np.linalg.det(turn) - 1.0) > 1e-3:
        return None
    return Pose.of(place, np.ravel(rotations.from_matrix(turn)))


def _with_world(
    cv: Any, hands: Sequence[Pose], boards: Sequence[Pose], method: str
) -> tuple[Floats, Floats]:
    """It answers with the flange in the camera, where calibrateHandEye has the camera in it."""
    number = getattr(cv, f"CALIB_ROBOT_WORLD_HAND_EYE_{method}")
    bases = [one.inverse() for one in hands]
    found = cv.calibrateRobotWorldHandEye(*_parts(boards), *_parts(bases), method=number)
    turn, place = np.asarray(found[2]), np.ravel(found[3])
    return turn.T, -turn.T @ place


def _parts(poses: Sequence[Pose]) -> tuple[list[Floats], list[Floats]]:
    turns = [rotations.to_matrix(np.array(one.quaternion)) for one in poses]
    return turns, [np.array(one.position) for one in poses]


def left(
    flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, camera: Pose
) -> tuple[float, float]:
    """Mm and degrees, root mean square, by which the place differs that should be the same."""
    p, q = _places(flanges, boards, mounting, camera)
    mean = np.ravel(rotations.canonical(np.linalg.eigh(q.T @ q)[1][:, -1]))
    turned = rotations.angle_between(q, np.tile(mean, (len(q), 1)))
    off = p - p.mean(axis=0)
    return float(np.sqrt((off**2).sum(axis=1).mean())), float(np.sqrt((turned**2).mean()))


def _places(
    flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, camera: Pose
) -> tuple[Floats, Floats]:
    """Of the board: in the base, or on the flange."""
    hands = flanges if mounting == "hand" else [one.inverse() for one in flanges]
    places = [hand @ camera @ board for hand, board in zip(hands, boards, strict=True)]
    return np.array([p.position for p in places]), np.array([p.quaternion for p in places])


def _held_out(
    cv: Any, flanges: Sequence[Pose], boards: Sequence[Pose], mounting: Mounting, method: str
) -> tuple[float, float]:
    """How far each view is from where all others put the board."""
    found = []
    for out in range(len(flanges)):
        rest = [i for i in range(len(flanges)) if i != out]
        some = [flanges[i] for i in rest], [boards[i] for i in rest]
        camera = _solved(cv, *some, mounting, method)
        if camera is None:
            continue
        p, q = _places(*some, mounting, camera)
        there, turned = _places([flanges[out]], [boards[out]], mounting, camera)
        mean = np.ravel(rotations.canonical(np.linalg.eigh(q.T @ q)[1][:, -1]))
        angle = float(np.ravel(rotations.angle_between(turned, mean[None]))[0])
        found.append((float(np.linalg.norm(there[0] - p.mean(axis=0))), angle))
    if not found:
        return float("nan"), float("nan")
    mm, degrees = np.sqrt((np.array(found) ** 2).mean(axis=0))
    return float(mm), float(degrees)


def _check_turns(flanges: Sequence[Pose]) -> None:
    """Raises Refused where the hand does not turn about two axes."""
    first = flanges[0].inverse()
    turns = [np.array((first @ one).quaternion) for one in flanges[1:]]
    vectors = np.array(
        [2.0 * np.degrees(np.arctan2(np.linalg.norm(q[1:]), q[0])) * _unit(q[1:]) for q in turns]
    )
    spread = np.linalg.svd(vectors, compute_uv=False)
    if len(spread) < 2 or spread[1] / np.sqrt(len(vectors)) < TURN / 2.0:
        raise Refused(rules.NO_TURNS(least=TURN))


def _unit(vector: Floats) -> Floats:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


SOURCES: Final[Mapping[str, str]] = {
    "TSAI": "Tsai and Lenz 1989",
    "PARK": "Park and Martin 1994",
    "HORAUD": "Horaud and Dornaika 1995",
    "ANDREFF": "Andreff et al. 1999",
    "DANIILIDIS": "Daniilidis 1999",
    "SHAH": "Shah 2013",
    "LI": "Li, Wang and Wu 2010",
}
"""Of the methods, as OpenCV's documentation names them."""
