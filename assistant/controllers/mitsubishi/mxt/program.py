"""The program on the controller that waits for real-time external control."""

from __future__ import annotations

import ipaddress
from typing import Final

from assistant.base.diagnostics import Refused
from assistant.controllers.mitsubishi.mxt.link import Mode
from assistant.controllers.mitsubishi.mxt.packet import COMMAND_TYPES
from assistant.controllers.mitsubishi.mxt.rules import BAD_SETTING

LONGEST_FILTER: Final = 10_000
"""ms; the manual states no most, and no one smooths longer."""


def program(pc: str, mode: Mode = "joint", *, filter_ms: int = 0, file: int = 1) -> str:
    """The text, with step numbers, which every version of MELFA-BASIC takes.

    pc: the address of this machine as the controller sees it; packets of others are not heard.
    filter_ms: time constant with which the controller smooths what it is told; the arm is behind by
    about as much. file: 1 to 8. Raises Refused for what cannot be.
    """
    if not 0 <= filter_ms <= LONGEST_FILTER:
        reason = f"it is milliseconds from 0 to {LONGEST_FILTER}"
        refusal = BAD_SETTING(name="filter_ms", value=filter_ms, reason=reason)
        raise Refused(refusal, exit_status=2)
    if file not in range(1, 9):
        refusal = BAD_SETTING(name="file", value=file, reason="it is 1 to 8")
        raise Refused(refusal, exit_status=2)
    try:
        address = ipaddress.IPv4Address(pc)
    except ValueError:
        reason = "it is four numbers with dots"
        refusal = BAD_SETTING(name="pc", value=repr(pc), reason=reason)
        raise Refused(refusal, exit_status=2) from None
    smoothed = f",{filter_ms}" if filter_ms else ""
    lines = (
        f'OPEN "ENET:{address}" AS #{file}',
        f"MXT {file},{COMMAND_TYPES[mode] - 1}{smoothed}",
        f"CLOSE #{file}",
        "END",
    )
    return "".join(f"{10 * i} {line}\r\n" for i, line in enumerate(lines, 1))
