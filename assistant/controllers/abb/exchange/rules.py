"""Findings of the exchange of poses by files."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, warning

BAD_POSE: Final = error("CN511", "pose {row} cannot be sent: {reason}; none was sent", "{cure}")
NO_ANSWER: Final = error(
    "CN512",
    "no answer to request {number} (`{word}`) within {seconds:g} s: {state}",
    "start the module that `robot-assistant exchange module` writes, with --plain for plain files, "
    "from its first line",
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
ELSEWHERE: Final = error(
    "CN517",
    "after request {number} the robot is {distance} from the pose that was requested: it is at "
    "{stands}, requested was {asked}",
    "look at the robot, and at what else writes into the folder of the exchange",
)
UNCHECKED: Final = warning(
    "CN518",
    "the module on the controller writes no checksum: a request that is changed on its way is only "
    "noticed once the robot is there",
    "write the module anew with `robot-assistant exchange module`",
)
BUSY: Final = error(
    "CN519",
    "{who} exchanges poses with the robot since {since}; nothing was sent",
    "wait until that exchange is over; if its process has died, `exchange stop` ends it",
)
CLAIM_GONE: Final = error(
    "CN520",
    "another process has ended this exchange; the robot may still move",
    "start the program on the controller from its first line, and open a new exchange",
)
BAD_ANSWER: Final = error(
    "CN521",
    "the answer to request {number} (`{word}`) cannot be read or has a wrong checksum; the robot "
    "may have carried it out",
    "look at the robot, and at what else writes into the folder of the exchange",
)
STALE: Final = error(
    "CN522",
    "`{name}` of an earlier question or answer cannot be deleted; nothing was sent",
    "delete the file, and give the user the grant to write to the controller's disks",
)

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
    "unchecked": (
        "the request carried no checksum",
        "write the module anew with `robot-assistant exchange module`",
    ),
    "failed": ("its motion failed", "look at the event log of the controller"),
    "unknown": (
        "its module does not know this request",
        "write the module anew with `robot-assistant exchange module`",
    ),
}
"""Word of an answer → why, and what to do."""
