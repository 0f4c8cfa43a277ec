"""The packet of `Mxt` as a controller knows it (BFP-A3379-A, 4.2.2): 196 bytes, little-endian."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from assistant.base.arrays import Floats

BLOCK: Final = "V40"
PACKET: Final = np.dtype(
    [
        ("Command", "<u2"),
        ("SendType", "<u2"),
        ("RecvType", "<u2"),
        ("reserve", "<u2"),
        ("dat", BLOCK),
        ("SendIOType", "<u2"),
        ("RecvIOType", "<u2"),
        ("BitTop", "<u2"),
        ("BitMask", "<u2"),
        ("IoData", "<u2"),
        ("TCount", "<u2"),
        ("CCount", "<u4"),
        ("RecvType1", "<u2"),
        ("reserve1", "<u2"),
        ("dat1", BLOCK),
        ("RecvType2", "<u2"),
        ("reserve2", "<u2"),
        ("dat2", BLOCK),
        ("RecvType3", "<u2"),
        ("reserve3", "<u2"),
        ("dat3", BLOCK),
    ]
)
assert PACKET.itemsize == 196
SHORT_FIELDS: Final = 64
"""Bytes that a controller of the CRn-500 series knows: up to the counter."""

POSE: Final = np.dtype([("place", "<f4", 8), ("flags", "<u4", 2)])
JOINT: Final = np.dtype([("angles", "<f4", 8), ("unused", "V8")])
PULSE: Final = np.dtype([("pulses", "<i4", 8), ("unused", "V8")])
POSITION_KINDS: Final[Mapping[int, np.dtype[np.void]]] = {
    1: POSE,
    2: JOINT,
    3: PULSE,
    4: POSE,
    5: JOINT,
    6: PULSE,
    7: POSE,
    8: JOINT,
    9: PULSE,
    10: PULSE,
    11: PULSE,
}
"""Type of data → what it is: 1 to 3 as commanded, 4 to 6 behind the filter, 7 to 9 as fed back,
10 and 11 the currents."""


def eight_axes(values: Floats) -> Floats:
    """Eight numbers, those that are lacking 0."""
    full = np.zeros(8)
    full[: len(values)] = values
    return full
