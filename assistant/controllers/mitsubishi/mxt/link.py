"""What the loop of cyclic control sends to a CR controller in `Mxt`, and what it reads from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, isfinite, radians
from typing import Final, Literal

from assistant.controllers.cyclic import Measured
from assistant.controllers.mitsubishi.mxt import orientation, packet
from assistant.controllers.mitsubishi.mxt.packet import (
    COMMAND_TYPES,
    DATA_FORMS,
    FEEDBACK,
    FILTERED,
)

Mode = Literal["pose", "joint", "pulse"]
Watched = Literal["command", "filtered", "feedback"]
WATCHED_OFFSETS: Final = {"command": 0, "filtered": FILTERED, "feedback": FEEDBACK}
FARTHEST: Final = 1e6
"""mm or radians (pulses are not bounded): what a controller sends beyond is no position."""


@dataclass(frozen=True)
class MxtLink:
    """See `Mxt` for most of it. also: up to three more types of data that the controller sends.

    signals: what signals the controller sends, 0 none, 1 outputs, 2 inputs. first: the first of
    16. mask: which of them are set as outputs to those bits of `word`.
    """

    mode: Mode
    cycle: float
    axes: int = 6
    sliding: tuple[int, ...] = ()
    flags: tuple[int, int] = (0, 0)
    watched: Watched = "feedback"
    also: tuple[int, ...] = ()
    signals: int = 0
    first: int = 0
    mask: int = 0
    word: int = 0
    short: bool = False

    @property
    def speaks_first(self) -> bool:
        return False

    @property
    def recorded(self) -> tuple[str, ...]:
        more = [f"type{kind}_{i}" for kind in self.also for i in range(1, 9)]
        return ("t_count", "c_count", "signals", *more)

    @property
    def size(self) -> int:
        return packet.SHORT_SIZE if self.short else packet.PACKET_SIZE

    def hello(self, count: int) -> bytes:
        """Asks for the commanded position, where a motion has to begin."""
        return self._packed(packet.NULL_COMMAND, 0, COMMAND_TYPES[self.mode], packet.NO_DATA, count)

    def command(self, values: Sequence[float], count: int) -> bytes:
        kind = COMMAND_TYPES[self.mode]
        asked = kind + WATCHED_OFFSETS[self.watched]
        return self._packed(packet.MOVE_COMMAND, kind, asked, self._data(kind, values), count)

    def end(self, values: Sequence[float], count: int) -> bytes:
        kind = COMMAND_TYPES[self.mode]
        asked = kind + WATCHED_OFFSETS[self.watched]
        return self._packed(packet.END_COMMAND, kind, asked, self._data(kind, values), count)

    def read(self, received: bytes) -> Measured | None:
        if len(received) != self.size:
            return None
        fields = packet.PACKET_LAYOUT.unpack(received.ljust(packet.PACKET_SIZE, b"\0"))
        command, send_type, kind, data = fields[0], fields[1], fields[2], fields[4]
        if send_type != kind or command not in (
            packet.NULL_COMMAND,
            packet.MOVE_COMMAND,
            packet.END_COMMAND,
        ):
            return None
        if not 1 <= kind <= 9 or (kind - COMMAND_TYPES[self.mode]) % 3:
            return None
        values = self._values(kind, data)
        if values is None:
            return None
        extra: list[float] = [
            fields[_MISSED_FIELD],
            fields[_COUNTER_FIELD],
            fields[_SIGNAL_WORD_FIELD],
        ]
        for i, asked in enumerate(self.also):
            extra.extend(
                self._more(asked, fields[_MORE_DATA_FIELDS[i] - 2], fields[_MORE_DATA_FIELDS[i]])
            )
        return Measured(values, fields[_COUNTER_FIELD], fields[_MISSED_FIELD], extra=tuple(extra))

    def _packed(self, command: int, kind: int, asked: int, data: bytes, count: int) -> bytes:
        more = [*self.also, 0, 0, 0]
        nothing = packet.NO_DATA
        signals = packet.OUTPUTS if self.mask else packet.NO_SIGNALS
        head = (command, kind, asked, 0, data, signals, self.signals)
        bits = (self.first, self.mask, self.word, 0, count & 0xFFFFFFFF)
        rest = (more[0], 0, nothing, more[1], 0, nothing, more[2], 0, nothing)
        return packet.PACKET_LAYOUT.pack(*head, *bits, *rest)[: self.size]

    def _data(self, kind: int, values: Sequence[float]) -> bytes:
        if self.mode == "pose":
            return packet.pack_data(
                kind, (*values[:3], *orientation.angles_of_quaternion(*values[3:])), self.flags
            )
        if self.mode == "joint":
            return packet.pack_data(
                kind, [self._turned(i, v, radians(v)) for i, v in enumerate(values)]
            )
        return packet.pack_data(kind, values)

    def _values(self, kind: int, data: bytes) -> tuple[float, ...] | None:
        found = DATA_FORMS[kind].unpack(data)
        if self.mode == "pulse":
            return tuple(float(v) for v in found[: self.axes])
        if not all(isfinite(v) and abs(v) < FARTHEST for v in found[:8]):
            return None
        if self.mode == "pose":
            return (*found[:3], *orientation.quaternion_of_angles(*found[3:6]))
        return tuple(self._turned(i, v, degrees(v)) for i, v in enumerate(found[: self.axes]))

    def _turned(self, axis: int, length: float, angle: float) -> float:
        return length if axis + 1 in self.sliding else angle

    def _more(self, asked: int, kind: int, data: bytes) -> list[float]:
        """Eight numbers as they are sent, nan where the controller sent other data."""
        if kind != asked:
            return [float("nan")] * 8
        return [float(v) for v in DATA_FORMS[kind].unpack(data)[:8]]


_COUNTER_FIELD: Final = packet.FIELD_NAMES.index("c_count")
_MISSED_FIELD: Final = packet.FIELD_NAMES.index("t_count")
_SIGNAL_WORD_FIELD: Final = packet.FIELD_NAMES.index("io_data")
_MORE_DATA_FIELDS: Final = tuple(packet.FIELD_NAMES.index(f"data{i}") for i in (1, 2, 3))
