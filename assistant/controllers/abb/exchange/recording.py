"""What an exchange was asked and answered, in columns."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from assistant.controllers.abb.exchange.messages import Answer
from assistant.program.geometry import Pose

COLUMNS: Final = (
    *("seconds", "number"),
    *("x", "y", "z", "q1", "q2", "q3", "q4", "cf1", "cf4", "cf6", "cfx"),
    *("asked_x", "asked_y", "asked_z", "asked_q1", "asked_q2", "asked_q3", "asked_q4"),
    *("round_trip", "hand_over", "waiting", "fetching", "motion", "looks"),
)
"""Of a recording as a table: mm, unit quaternions scalar first, seconds; asked ones are empty (NaN
in numpy) for a question that named no pose."""


@dataclass(frozen=True, slots=True)
class Spent:
    """Where the seconds of a round trip went.

    hand_over: until the request was whole on the controller. waiting: until the answer was seen,
    `motion` among it, which the controller measured itself; what is left of it is the controller's
    and our own looking for files. fetching: of the look that found the answer. looks: how often
    the answer was looked for.
    """

    hand_over: float = 0.0
    waiting: float = 0.0
    fetching: float = 0.0
    motion: float = 0.0
    looks: int = 0

    @property
    def round_trip(self) -> float:
        return self.hand_over + self.waiting + self.fetching


@dataclass(slots=True)
class Recording:
    """Rows in the order of the answers; grows while an exchange goes on."""

    _rows: list[tuple[float, ...]] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, seconds: float, answer: Answer, spent: Spent, asked: Pose | None = None) -> None:
        """seconds: when the answer was there, since the beginning of the exchange."""
        wanted: Sequence[float] = (np.nan,) * 7
        if asked is not None:
            wanted = (*asked.position, *asked.quaternion)
        now = (*answer.pose.position, *answer.pose.quaternion, *answer.configuration)
        parts = (spent.round_trip, spent.hand_over, spent.waiting, spent.fetching, spent.motion)
        self._rows.append((seconds, answer.number, *now, *wanted, *parts, spent.looks))

    def columns(self) -> Mapping[str, NDArray[np.float64]]:
        """(n,) of each name in COLUMNS."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, len(COLUMNS))
        return dict(zip(COLUMNS, table.T, strict=True))

    @property
    def seconds(self) -> NDArray[np.float64]:
        return self.columns()["seconds"]

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, 3) mm that were answered."""
        columns = self.columns()
        return np.column_stack([columns[name] for name in ("x", "y", "z")])

    @property
    def quaternions(self) -> NDArray[np.float64]:
        """(n, 4) that were answered."""
        columns = self.columns()
        return np.column_stack([columns[name] for name in ("q1", "q2", "q3", "q4")])

    def csv(self) -> bytes:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in self._rows:
            writer.writerow("" if np.isnan(value) else f"{value:.9g}" for value in row)
        return text.getvalue().encode("ascii")

    def npz(self) -> bytes:
        """A numpy archive with an array for each name in COLUMNS."""
        data = io.BytesIO()
        with zipfile.ZipFile(data, "w") as archive:
            for name, column in self.columns().items():
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as file:
                    np.lib.format.write_array(file, column, allow_pickle=False)
        return data.getvalue()
