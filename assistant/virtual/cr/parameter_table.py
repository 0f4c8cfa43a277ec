"""The parameters of a virtual CR controller: values, which are protected, which were changed.

The table `parameters.tsv` has those that mean something here, or that tools ask for, with the
settings of BFP-A4288 and BFP-A3379 where those tell any; COM2 to COM8 lead to lines of the network.
Which parameters a controller protects no manual at hand tells: here those of the origin are.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Final

from assistant.virtual.cr.store import CrRefusal

if TYPE_CHECKING:
    from assistant.robots import Robot

VALUE_SEPARATOR: Final = ", "
PARAMETER_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)", re.ASCII)
PARAMETER_CHARACTERS: Final = re.compile(r"[ -:<-~]*", re.ASCII)
"""A value takes part in answers: no semicolon and no control character."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """values: as the controller is delivered. protected: can be read and written by PAR and PAW,
    by PNR and PRM only behind the keyword.
    """

    name: str
    values: tuple[str, ...]
    protected: bool = False


class Parameters:
    """robot, language, slots: what some of them tell."""

    def __init__(self, robot: Robot, language: str, slots: int) -> None:
        own = [
            Parameter("RLNG", ("1" if language == "melfa-basic-4" else "2",)),
            Parameter("TASKMAX", (str(slots),)),
            Parameter("MEJAR", tuple(f"{float(v):.2f}" for p in robot.limits for v in p)),
            Parameter("JSAFE", _safe_joints(robot)),
        ]
        self._rows: Mapping[str, Parameter] = {row.name: row for row in (*_parameter_table(), *own)}
        self._values: dict[str, tuple[str, ...]] = {}

    def __getitem__(self, name: str) -> tuple[str, ...]:
        """The values of a parameter that there is."""
        return self._values.get(name, self._rows[name].values)

    def read(self, name: str, *, all_levels: bool) -> tuple[str, ...]:
        """Raises CrRefusal 7080 where there is none, or it is protected."""
        row = self._rows.get(name)
        if row is None or (row.protected and not all_levels):
            raise CrRefusal(7080)
        return self[name]

    def write(self, name: str, text: str, *, all_levels: bool) -> None:
        """Raises CrRefusal: 7040 where it is protected, 7081 for values that it cannot have."""
        row = self._rows.get(name)
        if row is None:
            raise CrRefusal(7081)
        if row.protected and not all_levels:
            raise CrRefusal(7040)
        values = tuple(part.strip() for part in text.split(","))
        fits = len(values) == len(row.values) and PARAMETER_CHARACTERS.fullmatch(text)
        if not fits or not all(map(_formatted_like, values, row.values)):
            raise CrRefusal(7081)
        self._values[name] = values

    def undo(self, name: str) -> None:
        """What it was delivered with; raises CrRefusal 7080."""
        if name not in self._rows:
            raise CrRefusal(7080)
        self._values.pop(name, None)

    def undo_all(self) -> None:
        self._values.clear()

    @property
    def changed(self) -> list[str]:
        """Names of those that are not as delivered."""
        return [n for n, v in self._values.items() if v != self._rows[n].values]


def _formatted_like(value: str, before: str) -> bool:
    """A number stays a number."""
    return bool(PARAMETER_NUMBER.fullmatch(value)) or not PARAMETER_NUMBER.fullmatch(before)


def _safe_joints(robot: Robot) -> tuple[str, ...]:
    """The joints J1 to J8 of the safe position."""
    angles = dict(zip(robot.places, robot.home, strict=True))
    return tuple(f"{float(angles.get(at, 0.0)):.2f}" for at in range(8))


@cache
def _parameter_table() -> tuple[Parameter, ...]:
    text = files(__package__).joinpath("parameters.tsv").read_text(encoding="ascii")
    rows = csv.DictReader(io.StringIO(text), delimiter="\t", quoting=csv.QUOTE_NONE)
    return tuple(
        Parameter(
            row["name"],
            tuple(value.strip() for value in row["values"].split(",")),
            row["level"] == "key",
        )
        for row in rows
    )
