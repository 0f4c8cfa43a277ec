"""Numbers of errors that Robot Web Services answer, and what to do about each.

Numbers with what they mean: `tests/fixtures/errors` of ichbinmeraj/abb-rws-client, answers of
RobotWare 6.16, 7.21 and 8.1; both dialects share them.
"""

from __future__ import annotations

from typing import Final

HELD: Final = -1073445862
NO_MASTERSHIP: Final = -1073445859
REJECTED: Final = -1073445881
NO_ACCESS: Final = -1073445867
NOT_NOW: Final = -1073442809
NO_MODULE: Final = -1073442813
NO_SYMBOL: Final = -1073442816
NO_RESOURCE: Final = -1073414146
NO_SIGNAL: Final = -1073445866
NO_PATH: Final = -1073438713
NO_VOLUME: Final = -1073438716
NO_FILE: Final = -1073438708
ARGUMENT: Final = -1073445879
NO_STATION: Final = -1073435873
STATION_TAKEN: Final = -1073435870

GRANT_CURE: Final = (
    "give the user the grant in the controller's User Authorization System; in manual mode "
    "request remote access and confirm it on the pendant"
)
RELEASE_CURE: Final = (
    "release the write access where it is held (FlexPendant, RobotStudio or another program), "
    "or wait until what is under way has ended"
)

ERROR_CURES: Final = {
    HELD: RELEASE_CURE,
    NO_MASTERSHIP: RELEASE_CURE,
    STATION_TAKEN: RELEASE_CURE,
    NO_STATION: RELEASE_CURE,
    REJECTED: GRANT_CURE,
    NO_ACCESS: GRANT_CURE,
    NOT_NOW: "stop the programs, or load one and switch the motors on, then run it again",
    NO_MODULE: "check the names of task and module",
    NO_SYMBOL: "check the names of task, module and data",
    NO_RESOURCE: "check the names; the option may be missing on this controller",
    NO_SIGNAL: "check the name of the signal",
    NO_PATH: "check the name of the file",
    NO_VOLUME: "check the folder of the address",
    NO_FILE: "check the name of the file and that its text has no errors",
    ARGUMENT: "check the value and what the controller accepts there",
}
OTHER_CURE: Final = "put right what it says, then run it again"

ERROR_TEXTS: Final = {
    HELD: "the resource is held by someone else",
    NO_MASTERSHIP: "the user does not have the mastership",
    REJECTED: "rejected",
    NOT_NOW: "not allowed in the state that the programs are in",
    NO_FILE: "the file cannot be loaded",
    NO_SYMBOL: "not found",
}
"""For answers that come without a text of their own."""

ABSENT: Final = frozenset({NO_MODULE, NO_SYMBOL, NO_RESOURCE, NO_SIGNAL, NO_PATH})
"""Errors which say that there is no such thing."""
