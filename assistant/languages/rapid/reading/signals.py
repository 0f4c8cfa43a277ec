"""Signals of a controller, as its system parameters state them: `EIO.cfg`.

RobotWare 5 says `Unit` and `UnitMap`, 6 and 7 say `Device` and `DeviceMap`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

from assistant.languages.language_types import ControllerConfiguration
from assistant.languages.rapid.reading.parameter_rows import is_known, rows_of
from assistant.program.program import Signal

SignalKind = Literal["digital", "analog", "group"]
PARAMETER_SIGNAL_TYPES: Final[dict[str, tuple[SignalKind, bool]]] = {
    "DI": ("digital", True),
    "DO": ("digital", False),
    "AI": ("analog", True),
    "AO": ("analog", False),
    "GI": ("group", True),
    "GO": ("group", False),
}
"""Types of signals: what they are, and whether they are inputs."""
DEVICE_BITS: Final = 16
"""Bits of one device are counted from a multiple of this, behind those of the device before."""
_BIT_SPAN: Final = re.compile(r"(\d{1,5})(?:-(\d{1,5}))?")


def signals_of_file(text: str) -> ControllerConfiguration:
    """The signals of a file; those that name no type which there is are among the `unread`.

    Each device has its numbers behind those of the device before, as its map counts them.
    """
    rows, unread = [], []
    for row in rows_of(text, "EIO_SIGNAL"):
        name, kind = (
            row.get("Name", ""),
            PARAMETER_SIGNAL_TYPES.get(row.get("SignalType", "").upper()),
        )
        if kind is None or not name:
            unread.append(name or "a signal without a name")
            continue
        device = row.get("Device", row.get("Unit", "")).lower()
        begin, bits = _bits_of_map(row.get("DeviceMap", row.get("UnitMap", "")))
        rows.append(_SignalRow(name, *kind, device, None if kind[0] == "analog" else begin, bits))
    starts = _first_numbers(rows)
    signals: dict[str, Signal] = {}
    for one in rows:
        number = None if one.begin is None else starts[one.input, one.device] + one.begin
        bits = one.bits if one.kind == "group" else 1
        signals[one.name] = Signal(one.kind, "input" if one.input else "output", number, bits)
    results = {row.get("Res", "").lower() for row in rows_of(text, "EIO_CROSS")} - {""}
    return ControllerConfiguration(signals, frozenset(results), tuple(unread), is_known(text))


@dataclass(frozen=True, slots=True)
class _SignalRow:
    """A signal as it is stated. begin: the bit of its device that it begins with, if it has one."""

    name: str
    kind: SignalKind
    input: bool
    device: str
    begin: int | None
    bits: int


def _bits_of_map(written: str) -> tuple[int | None, int]:
    """First bit and number of bits of a map; no first bit where they do not follow each other."""
    spans = [_BIT_SPAN.fullmatch(part.strip()) for part in written.split(",")]
    read = [(int(span[1]), int(span[2] or span[1])) for span in spans if span is not None]
    if len(read) < len(spans):
        return None, 1
    bits = sum(abs(end - begin) + 1 for begin, end in read)
    rising = all(begin <= end for begin, end in read)
    joined = all(end + 1 == begin for (_, end), (begin, _) in pairwise(read))
    return (read[0][0] if rising and joined else None), bits


def _first_numbers(rows: Sequence[_SignalRow]) -> dict[tuple[bool, str], int]:
    """The number of bit 0 of each device, of its inputs and of its outputs."""
    ends: dict[tuple[bool, str], int] = {}
    for row in rows:
        if row.begin is not None:
            key = row.input, row.device
            ends[key] = max(ends.get(key, 0), row.begin + row.bits)
    starts: dict[tuple[bool, str], int] = {}
    after = {True: 0, False: 0}
    for (is_input, device), end in ends.items():
        starts[is_input, device] = after[is_input]
        after[is_input] += -(-end // DEVICE_BITS) * DEVICE_BITS
    return starts
