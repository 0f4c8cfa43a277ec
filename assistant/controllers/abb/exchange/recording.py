"""What an exchange was asked and answered, row by row, and where the time went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from assistant.controllers.abb.exchange.messages import Answer
from assistant.controllers.recording import Recording
from assistant.program.geometry import Pose

_PLACE, _TURN = ("x", "y", "z"), ("w", "x", "y", "z")
RECORDED_FIELDS: Final[dict[str, Sequence[str]]] = {
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
"""Of a recording: seconds since the beginning, mm, unit quaternions scalar first; NaN for what was
asked where no pose was. The rest is `Spent`."""
NOT_ASKED: Final = float("nan")


@dataclass(frozen=True, slots=True)
class Spent:
    """Where the seconds of a round trip went.

    hand_over: until the request was whole on the controller. waiting: until the answer was seen,
    `motion` among it, which the controller measured itself; what is left of it is the controller's
    and our own looking for files. fetching: of the look that found the answer. looks: how often
    the answer was looked for.
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
