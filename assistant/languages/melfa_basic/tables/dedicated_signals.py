"""Signals that a controller has uses of its own for, as it leaves the factory."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

_HANDS: Final = range(900, 908)
"""Signals of the hands: valves, and the switches that check them."""

DEDICATED_SIGNALS: Final = MappingProxyType({
    "input": MappingProxyType({
        0: "stops all programs (STOP)",
        1: "switches the motors off (SRVOFF)",
        2: "resets errors (ERRRESET)",
        3: "starts the programs (START)",
        4: "switches the motors on (SRVON)",
        5: "gives the right of operation (IOENA)",
        **dict.fromkeys(_HANDS, "checks a hand"),
    }),
    "output": MappingProxyType({
        0: "tells that a program runs (START)",
        1: "tells that the motors are on (SRVON)",
        2: "tells of an error (ERRRESET)",
        3: "tells of the right of operation (IOENA)",
        **dict.fromkeys(_HANDS, "drives a hand"),
    }),
})  # fmt: skip
"""What each number is for, with the parameter that states it (manuals of CR1, CR750-D and CR800-D:
dedicated inputs and outputs)."""
