"""What a controller says where its arm cannot go."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.robots.robot import Robot
from assistant.virtual.events import Place
from assistant.virtual.motion.goals import Reason, Refusal

RAPID_REFUSALS: Final[Mapping[Reason, str]] = {
    "reach": "50050: the position is outside of reach",
    "joints": "50027: joint {axis} is out of its range",
    "configuration": "50080: the position cannot be reached in the configuration of the target",
    "nowhere": "50050: where the motion leads is not known",
}
"""ABB, Operating manual Trouble shooting IRC5 (3HAC020738), 5 xxxx."""
MELFA_REFUSALS: Final[Mapping[Reason, str]] = {
    "reach": "error 2602: the destination is outside of reach",
    "joints": "error 2602: joint {axis} is past its limit at the destination",
    "configuration": "error 2602: the destination cannot be reached with its structure flags",
    "nowhere": "error 2802: where the motion leads is not known",
}
"""CR750/CR751 troubleshooting, BFP-A8871: 2602 `DSTN pos. exceeds the limit`."""
CORNER_PATH_FAILURE: Final = "50024: corner path failure, the arm stops in the point"
"""Of RAPID: the next motion comes too late for the corner."""


def refusal_message(refusal: Refusal, robot: Robot, place: Place | None) -> str:
    """Why a motion is refused, with the place of its statement."""
    table = RAPID_REFUSALS if "rapid" in robot.languages else MELFA_REFUSALS
    text = table[refusal.reason].format(axis=refusal.axis)
    return text if place is None else f"{place[0]}:{place[1]}: {text}".lstrip(":")
