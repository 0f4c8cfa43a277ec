"""Findings of the exchange of poses by files."""

from __future__ import annotations

from typing import Final

from assistant.program.diagnostics import error

BAD_POSE: Final = error("CN511", "pose {row} cannot be sent: {reason}; none was sent", "{cure}")
NO_ANSWER: Final = error(
    "CN512",
    "no answer to request {number} (`{word}`) within {seconds:g} s: {state}",
    "start the module that `robot-assistant exchange module` writes, from its first line",
)
DECLINED: Final = error(
    "CN513", "the robot did not carry out request {number} (`{word}`): {reason}; {state}", "{cure}"
)
ENDED: Final = error(
    "CN514",
    "the exchange is over: {reason}; nothing was sent",
    "start the program on the controller from its first line, and open a new exchange",
)
BAD_NAME: Final = error(
    "CN515", "`{given}` cannot be the {what} of the module: {reason}", "write {wanted}"
)
BAD_NUMBER: Final = error("CN516", "{given:g} is no {what}", "write {wanted}")

REASONS: Final = {
    "unreadable": ("it could not read the pose", "send finite numbers and a unit quaternion"),
    "unreachable": ("the pose is outside of its reach", "choose a pose that is nearer"),
    "limits": (
        "an axis would leave its limits in that configuration",
        "state another configuration, or none",
    ),
    "number": (
        "another exchange has sent requests in between, or its program was started anew",
        "let one program at a time exchange poses with a robot",
    ),
    "incomplete": (
        "the file arrived with other text than was sent",
        "check that the server keeps files byte for byte",
    ),
    "failed": ("its motion failed", "look at the event log of the controller"),
    "unknown": (
        "its module does not know this request",
        "write the module anew with `robot-assistant exchange module`",
    ),
}
"""Word of an answer → why, and what to do."""
