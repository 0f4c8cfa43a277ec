"""What numbers may be."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any


@dataclass(frozen=True, slots=True)
class Limits:
    """What a literal number may be.

    above: low itself is too low. number: of the error that a controller shows, 0 for the usual one.
    """

    what: str
    low: float
    high: float
    above: bool = False
    cure: str = ""
    number: int = 0

    def holds(self, value: float) -> bool:
        return self.low <= value <= self.high and not (self.above and value == self.low)

    def words(self, value: float, number: int) -> dict[str, Any]:
        """The fields of a finding about a value that is none of these. number: the usual error."""
        return {
            "what": self.what,
            "value": f"{value:g}",
            "range": self.range,
            "number": self.number or number,
            "cure": self.cure or f"write {self.range}",
        }

    @property
    def range(self) -> str:
        if self.high == inf:
            return f"above {self.low:g}" if self.above else f"{self.low:g} or more"
        begin = f"above {self.low:g} and at most" if self.above else f"{self.low:g} to"
        return f"{begin} {self.high:g}"
