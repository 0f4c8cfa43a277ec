"""Sender of poses, the base of both protocols: check, send one by one, compare, and record.

A path of poses is checked before the first is sent; each answer is compared with the requested pose
and recorded as a row, with the time that each part of the round trip took.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import ArrayLike

from assistant.base import rotations
from assistant.base.arrays import Floats, reals
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules as common
from assistant.controllers.abb.exchange import rules
from assistant.controllers.abb.exchange.files import Answer, Claim, Configuration, Files
from assistant.controllers.controller import Programs
from assistant.controllers.recording import Recording
from assistant.program.geometry import Pose
from assistant.program.motion import Kind, Path
from assistant.program.se3 import AnyPose, AnyPoses, Unit, are_columns, columns_of, pose_of

_PLACE, _TURN = ("x", "y", "z"), ("w", "x", "y", "z")
_RECORDED_FIELDS: Final[dict[str, Sequence[str]]] = {
    "seconds": (),
    "number": (),
    "position": _PLACE,
    "quaternion": _TURN,
    "configuration": ("cf1", "cf4", "cf6", "cfx"),
    "asked_position": _PLACE,
    "asked_quaternion": _TURN,
    "round_trip": (),
    "hand_over": (),
    "waiting": (),
    "fetching": (),
    "motion": (),
    "looks": (),
}
"""Fields of a recording: seconds since the beginning, mm, unit quaternions scalar first; NaN for
the requested values of a request without a pose. The rest is `Spent`.
"""
NOT_ASKED: Final = float("nan")


@dataclass(frozen=True, slots=True)
class Spent:
    """Breakdown of the seconds of a round trip.

    hand_over: until the request was complete on the controller. waiting: until the answer was seen,
    including `motion`, which the controller measured itself; the remainder is the polling for files
    by the controller and by this computer. fetching: of the poll that found the answer. looks:
    number of polls for the answer.
    """

    hand_over: float = 0.0
    waiting: float = 0.0
    fetching: float = 0.0
    motion: float = 0.0
    looks: int = 0

    @property
    def round_trip(self) -> float:
        return self.hand_over + self.waiting + self.fetching


def record_answer(
    recording: Recording, seconds: float, answer: Answer, spent: Spent, asked: Pose | None
) -> None:
    """A row for an answer."""
    recording.add(
        seconds,
        answer.number,
        answer.pose.position,
        answer.pose.quaternion,
        answer.configuration,
        asked.position if asked is not None else (NOT_ASKED,) * 3,
        asked.quaternion if asked is not None else (NOT_ASKED,) * 4,
        spent.round_trip,
        spent.hand_over,
        spent.waiting,
        spent.fetching,
        spent.motion,
        spent.looks,
    )


Check = Callable[[Floats, Floats], Mapping[int, str]]
"""Positions (n, 3) mm and quaternions (n, 4) → why rows, from 0, must not be sent."""
Progress = Callable[[int, int, Answer], None]
"""Called with the number of answered poses, the number of all, and the last answer."""

UNREADABLE_AFTER: Final = 1.0
"""Seconds after which an answer that cannot be read stays unreadable: a damaged transfer is read
again until then."""
_UNIT_TOLERANCE: Final = 1e-3
"""Most that the length of a quaternion may differ from 1; it is normalised."""
_LARGEST_CONFIGURATION: Final = 99_999_999
"""cfx of arms that have several digits; cf1, cf4 and cf6 are quarters of a turn."""
_ROWS: Final = "state positions (n, 3) in mm and quaternions (n, 4)"
_FARTHEST: Final = 100_000.0
"""Largest coordinate in mm: no robot reaches beyond."""
_ARRIVAL_TOLERANCE: Final = 1.0
"""Most mm and degrees between a requested pose and the answered one, of a robot at rest."""


class PoseSender(ABC):
    """Base of both protocols: poses are checked, sent, answered and recorded.

    A context manager: entering claims the exchange, leaving it because of an error breaks it off.

    programs: an open session. prefix: of the claim. longest: seconds for one motion. poll: seconds
    between two looks for an answer. check: called before poses are sent.
    """

    def __init__(
        self, programs: Programs, prefix: str, longest: float, poll: float, check: Check | None
    ) -> None:
        self.programs = programs
        self._files = Files(programs)
        self._claim = Claim(self._files, prefix)
        self.recording: Final = Recording(_RECORDED_FIELDS)
        self.spent = Spent()
        """Times of the last round trip."""
        self.stopped: Answer | None = None
        """Answer of the robot to a stop."""
        self.ended = ""
        """Why the exchange is over and in which state the robot is; "" while it goes on."""
        self.checked: bool | None = None
        """True if the answers have checksums, None where that is not known."""
        self._longest, self._poll = longest, poll
        self._check = check
        self._begin = time.monotonic()

    def __enter__(self) -> Self:
        self._begin = time.monotonic()
        self._claim.take()
        try:
            self.current_pose()
        except BaseException:
            with suppress(Refused):
                self._claim.free()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            if error is not None and not self.ended:
                self._break_off(error)
        finally:
            try:
                self._claim.free()
            # The claim stays if the session is lost; the error that ended the exchange tells more.
            except Refused:
                if error is None:
                    raise

    def _break_off(self, error: BaseException) -> None:
        """Halt the robot after an error, over a new connection where the session is unusable."""
        try:
            # A line that was lost, or Ctrl-C in the middle of a command.
            if isinstance(error, common.Lost) or not isinstance(error, Exception):
                self.programs.__exit__(None, None, None)
                self.programs.__enter__()
            self._halt()
        except Refused as refused:
            reasons = "; ".join(finding.message for finding in refused.findings)
            self.ended = f"the exchange could not be ended, and the robot may still move: {reasons}"
        except BaseException:
            self.ended = "the end was interrupted, and the robot may still move"
            raise
        if isinstance(error, Refused):
            error.add_note(self.ended)

    @abstractmethod
    def _halt(self) -> None:
        """End the exchange, state in `ended` whether the robot may still move; raises Refused."""

    @contextmanager
    def _claimed(self) -> Iterator[None]:
        """Hold the claim, for one request where it was not taken for all of them."""
        if self._claim.held:
            yield
            return
        self._claim.take()
        try:
            yield
        finally:
            with suppress(Refused):
                self._claim.free()

    @property
    def _place(self) -> str:
        return str(self.programs.address)

    @property
    @abstractmethod
    def stands(self) -> bool:
        """True if the exchange has ended and the robot is known to stand still."""

    @abstractmethod
    def current_pose(self) -> Answer:
        """Return the pose of the robot, once its program takes the request."""

    @abstractmethod
    def _move(self, pose: Pose, configuration: Configuration | None, through: bool) -> Answer:
        """Send a pose that was checked, and wait for its answer."""

    def move_to(
        self,
        pose: AnyPose,
        *,
        unit: Unit | None = None,
        configuration: Configuration | None = None,
        through: bool = False,
    ) -> Answer:
        """Move the robot to a pose in a line; return its pose once it has stopped there.

        pose: a `Pose` in mm, or an SE3, matrix or row of seven with the unit of its position.
        through: return as soon as the program continues, so that the arm passes a pose through the
        zone of the module if the next one arrives in time. configuration: None to let the
        controller choose the nearest one. Raises Refused if the pose must not be sent, or the robot
        does not go there; it then stays where it was.
        """
        if not isinstance(pose, Pose):
            pose = pose_of(pose, unit=unit)
        positions, quaternions = _checked_poses([pose.position], [pose.quaternion], self._check)
        return self._move(Pose.of(positions[0], quaternions[0]), configuration, through)

    def follow(
        self,
        trajectory: AnyPoses,
        *,
        unit: Unit | None = None,
        configurations: Sequence[Configuration] | None = None,
        through: bool = False,
        progress: Progress | None = None,
    ) -> Recording:
        """Move the robot to all poses in their order, each once the one before is answered.

        trajectory: a path of lines, or poses of any form of `assistant.pose.columns`: SE3 of
        roboticstoolbox, matrices, columns (n, 3) mm and (n, 4). unit: of their positions, needed
        for SE3, matrices and rows of seven. All of them are checked before the first is sent.
        Returns `recording`, which holds what came before an error too.
        """
        if isinstance(trajectory, Path):
            arcs = np.flatnonzero(np.isin(trajectory.kinds, (Kind.VIA, Kind.END)))
            if arcs.size:
                raise Refused(
                    _bad_pose(int(arcs[0]), "it is a part of an arc", "divide arcs into lines")
                )
        # Numbers of columns are judged below, with the row that must not be sent.
        plain = unit is None and are_columns(trajectory)
        columns = trajectory if plain else columns_of(trajectory, unit=unit)
        positions, quaternions = _checked_poses(columns[0], columns[1], self._check)
        if configurations is not None and len(configurations) != len(positions):
            raise Refused(
                _bad_pose(
                    min(len(configurations), len(positions)),
                    f"there are {len(positions)} poses and {len(configurations)} configurations",
                    "state one for each pose, or none",
                )
            )
        for row in range(len(positions)):
            configuration = configurations[row] if configurations is not None else None
            pose = Pose.of(positions[row], quaternions[row])
            answer = self._move(pose, configuration, through)
            if progress is not None:
                progress(row + 1, len(positions), answer)
        return self.recording

    def _compare(
        self, number: int, answer: Answer, pose: Pose, configuration: Configuration | None
    ) -> None:
        """Raise Refused if the robot is not at the pose that it was sent to."""
        distance = float(np.linalg.norm(np.subtract(answer.pose.position, pose.position)))
        angle = float(rotations.angle_between(answer.pose.quaternion, pose.quaternion))
        quarters = 0
        if configuration is not None:  # at the edge of a quarter the controller tells either
            pairs = zip(answer.configuration[:3], configuration[:3], strict=True)
            quarters = max(abs(one - int(other)) for one, other in pairs)
        if distance <= _ARRIVAL_TOLERANCE and angle <= _ARRIVAL_TOLERANCE and quarters <= 1:
            return
        off = [f"{distance:.1f} mm and {angle:.1f} degrees"]
        if quarters > 1:
            off.append(f"and by configuration {answer.configuration} instead of {configuration}")
        raise Refused(
            rules.ELSEWHERE(
                place=self._place,
                number=number,
                distance=" ".join(off),
                stands=position_text(answer.pose),
                asked=position_text(pose),
            )
        )


def _checked_poses(
    positions: ArrayLike, quaternions: ArrayLike, check: Check | None
) -> tuple[Floats, Floats]:
    """Return the columns of poses that may be sent; raises Refused for the first that must not."""
    place, turn = _columns(positions, 3), _columns(quaternions, 4)
    if len(place) != len(turn):
        reason = f"there are {len(place)} positions and {len(turn)} quaternions"
        raise Refused(_bad_pose(min(len(place), len(turn)), reason, "state both for each pose"))
    if not len(place):
        return place, turn
    finite = np.isfinite(place).all(axis=1) & np.isfinite(turn).all(axis=1)
    near = (np.abs(place) <= _FARTHEST).all(axis=1)
    unit = np.abs(np.sqrt((turn * turn).sum(axis=1)) - 1.0) <= _UNIT_TOLERANCE
    for good, reason, cure in (
        (finite, "it holds a number that is not finite", "correct the number"),
        (near, f"it is farther than {_FARTHEST:g} mm away", "state positions in mm"),
        (unit, "its quaternion is not of unit length", "state unit quaternions (w, x, y, z)"),
    ):
        wrong = np.flatnonzero(~good)
        if wrong.size:
            raise Refused(_bad_pose(int(wrong[0]), reason, cure))
    turn = rotations.canonical(turn)
    refused = dict(check(place, turn)) if check is not None else {}
    if refused:
        row = min(refused)
        more = f" ({len(refused)} poses are refused)" if len(refused) > 1 else ""
        raise Refused(_bad_pose(row, refused[row] + more, "choose a pose that may be sent"))
    return place, turn


def checked_configuration(given: Configuration | None) -> None:
    """Raise Refused for one that is stated and is not the four whole numbers of a robtarget."""
    if given is None:
        return
    whole = len(given) == 4 and all(
        isinstance(one, (int, float, np.integer))
        and abs(one) <= _LARGEST_CONFIGURATION
        and one == int(one)
        for one in given
    )
    if not whole:
        reason = f"its configuration is {given!r:.60}"
        raise Refused(_bad_pose(0, reason, "state four whole numbers: cf1, cf4, cf6, cfx"))


def _columns(rows: ArrayLike, width: int) -> Floats:
    """Rows of so many numbers; raises Refused for others."""
    try:
        found = reals(rows)
    except ValueError as error:
        raise Refused(_bad_pose(0, f"it is no row of numbers ({error})", _ROWS)) from None
    if found.size == 0:
        return found.reshape(0, width)
    if found.ndim != 2 or found.shape[1] != width:
        raise Refused(_bad_pose(0, f"its columns are of the shape {found.shape}", _ROWS))
    return found


def position_text(pose: Pose) -> str:
    """The position of a pose, in words."""
    x, y, z = pose.position
    return f"({x:g}, {y:g}, {z:g}) mm"


def _bad_pose(row: int, reason: str, cure: str) -> Diagnostic:
    """The finding that a row, from 0, cannot be sent."""
    return rules.BAD_POSE(row=row + 1, reason=reason, cure=cure)
