"""Findings of the data link, data link control mode, external control and the monitor."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Refused, error
from assistant.base.installation import missing_extra

BAD_LINE: Final = error(
    "CN611",
    "`{target}` is no communication line: {reason}",
    "write `host:port`, `listen:address:port`, or a serial port as `/dev/ttyS0` or `COM3`",
)
NO_SERIAL: Final = missing_extra(
    "CN612",
    "serial lines need pyserial, which is not installed",
    "serial",
)
NO_LINE: Final = error(
    "CN613",
    "the line {target} cannot be opened: {reason}; nothing was sent",
    "check the cable, the address, the rate, and that the line is for data link (CPRCE.. = 2)",
)
LINE_LOST: Final = error(
    "CN614",
    "the line {target} failed while {doing}: {reason}; {state}",
    "check the controller and the cable, then begin anew",
)
LINE_GARBLED: Final = error(
    "CN615",
    "what came over {target} makes no sense: {answer}; {state}",
    "check the rate, the parity and which program sends on that line",
)
UNSENDABLE: Final = error(
    "CN616", "{what} cannot be sent over a data link: {reason}; nothing was sent", "{cure}"
)
BAD_FORM: Final = error(
    "CN617",
    "`{field}` names no value that a program prints",
    "write status variables or variables as they are printed: `M_TIMER | P_CURR | J_FBC`",
)
OUT_OF_LIMITS: Final = error(
    "CN621",
    "point {number} turns J{axis} to {value:g}, which is outside of {low:g} to {high:g}; nothing "
    "was sent",
    "change the trajectory, or state the limits of the arm that is there",
)
BAD_POINTS: Final = error("CN622", "the trajectory cannot be sent: {reason}", "{cure}")
TOO_FAR: Final = error(
    "CN623",
    "point {number} turns J{axis} by {step:g} at once, more than {most:g}; nothing was sent",
    "put points between, or allow larger steps",
)
STALLED: Final = error(
    "CN624",
    "the arm stood still for {seconds:g} s, {left} of {count} points were not reached",
    "look at the controller's error, then begin anew",
)
SILENT: Final = error(
    "CN625",
    "no status came over {target} for {seconds:g} s; {state}",
    "look at the controller: an emergency stop, an error or a stop ends the stream",
)
NOT_READY: Final = error(
    "CN626",
    "data link control mode cannot begin: {reason}; nothing was started",
    "{cure}",
)
ENDED: Final = error(
    "CN627",
    "the programs on the controller ended by themselves; {state}",
    "look at the controller's error, then begin anew",
)
NOT_ENDED: Final = error(
    "CN628",
    "data link control mode did not end as it was asked to; {state}",
    "look at the arm, and stop the programs on the controller",
)


BAD_SETTING: Final = error(
    "CN731",
    "`{name}` of the real-time control cannot be {value}: {reason}; nothing was sent",
    "give another one",
)
WRONG_KIND: Final = error(
    "CN732",
    "a trajectory of {kind} cannot be followed in {mode} mode; nothing was sent",
    "open the controller in the mode of the trajectory",
)
NO_MONITOR: Final = error(
    "CN733",
    "{address} sends no monitor data: {reason}; nothing was moved",
    "check the address, MONMODE = 1 and MONPORT on the controller, and the firewall",
)
MONITOR_SILENT: Final = error(
    "CN734",
    "the monitor data of {address} ended: nothing came for {seconds:.2f} s; nothing was moved",
    "look at the controller and the cable; another program may have asked for the data, which the "
    "controller sends to the last one only",
)


def require(name: str, value: object, right: bool, reason: str) -> None:
    """Raises Refused for a setting that is not right. reason: what it is, if it is."""
    if not right:
        raise Refused(BAD_SETTING(name=name, value=value, reason=reason), exit_status=2)
