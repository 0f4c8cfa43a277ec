"""The ledger of a simulation: what each move takes, and what is not known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from assistant.base.arrays import Floats
from assistant.robots.timing.on_way import OutputTime, output_times
from assistant.robots.timing.pieces import Segment
from assistant.robots.timing.plan import Plan
from assistant.robots.timing.simulation import MoveTimes, Unknown


@dataclass(frozen=True, slots=True, eq=False)
class _LedgerEntry:
    """Columns of the rows of one motion statement."""

    kind: NDArray[np.uint8]
    row: NDArray[np.int32]
    length: Floats
    turn: Floats
    seconds: Floats
    binds: NDArray[np.uint8]
    total: float


class Ledger:
    """Takes down the moves as they are timed, each as it took the longest, and notes.

    entries, outputs: by procedure and number of the motion statement. notes: procedure and what is
    not known there → how often it was met.
    """

    def __init__(self) -> None:
        self.entries: dict[tuple[str, int], _LedgerEntry] = {}
        self.outputs: dict[tuple[str, int], tuple[OutputTime, ...]] = {}
        self.notes: dict[tuple[str, str], int] = {}

    def note(self, procedure: str, what: str) -> None:
        self.notes[procedure, what] = self.notes.get((procedure, what), 0) + 1

    def moved(self, pieces: Sequence[Segment], skipped: int, plan: Plan) -> None:
        """Enters the moves of pieces, but for the first `skipped`, as a plan has them."""
        profile, at = plan.profile, -skipped
        for piece in pieces:
            first, last = max(at, 0), at + len(piece.moves)
            at = last
            if last <= 0:
                continue
            rows, seconds = slice(first, last), profile.seconds[first:last]
            total = float(seconds.sum())
            before = self.entries.get((piece.procedure, piece.number))
            if before is not None and before.total >= total:
                continue
            times = output_times(plan, rows, piece.triggers, piece.procedure, piece.number)
            self.outputs[piece.procedure, piece.number] = tuple(times) if piece.triggers else ()
            left = len(piece.moves) - (last - first)
            self.entries[piece.procedure, piece.number] = _LedgerEntry(
                piece.moves.kinds[left:],
                np.arange(left, len(piece.moves), dtype=np.int32),
                profile.lengths[rows],
                profile.turns[rows],
                seconds,
                profile.binds[rows],
                total,
            )

    def move_times(self, procedures: Sequence[str]) -> MoveTimes:
        """All that was entered, in order of text; procedures: their names in that order."""
        place = {name: index for index, name in enumerate(procedures)}
        keys = sorted(self.entries, key=lambda key: (place[key[0]], key[1]))
        entries = [self.entries[key] for key in keys]
        counts = [len(entry.row) for entry in entries]

        def column(name: str, dtype: type) -> NDArray[np.generic]:
            parts = [getattr(entry, name) for entry in entries]
            return np.concatenate([np.empty(0, dtype), *parts]).astype(dtype)

        return MoveTimes(
            procedures=tuple(procedures),
            procedure=np.repeat([place[name] for name, _ in keys], counts).astype(np.int32),
            number=np.repeat([number for _, number in keys], counts).astype(np.int32),
            row=column("row", np.int32),  # type: ignore[arg-type]
            kind=column("kind", np.uint8),  # type: ignore[arg-type]
            length=column("length", np.float64),  # type: ignore[arg-type]
            turn=column("turn", np.float64),  # type: ignore[arg-type]
            seconds=column("seconds", np.float64),  # type: ignore[arg-type]
            binds=column("binds", np.uint8),  # type: ignore[arg-type]
        )

    def output_times(self, procedures: Sequence[str]) -> tuple[OutputTime, ...]:
        """All that moves set on their way, in order of text."""
        place = {name: index for index, name in enumerate(procedures)}
        keys = sorted(self.outputs, key=lambda key: (place[key[0]], key[1]))
        return tuple(one for key in keys for one in self.outputs[key])

    def unknown(self) -> tuple[Unknown, ...]:
        return tuple(Unknown(where, what, times) for (where, what), times in self.notes.items())
