"""Findings of real-time external control and of the real-time monitor."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Refused, error

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
