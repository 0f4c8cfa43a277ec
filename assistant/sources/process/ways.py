"""How contours are come to, how fast they are followed, and where outputs are set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from assistant.program.motion import FINE, Blend, Speed

OrderKind = Literal["travel", "drawing", "text"]
"""Of contours: as travel is shortest, as they were drawn, by the numbers written beside them."""


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Speeds along a contour where they are not the layer's; None for that one.

    corner: where it turns by `angle` degrees or more, and on arcs of up to `radius` mm that do,
    from `length` mm before to `length` mm behind. start, end: over the first and the last mm.
    """

    corner: Speed | None = None
    angle: float = 30.0
    radius: float = 0.0
    length: float = 5.0
    start: Speed | None = None
    start_length: float = 5.0
    end: Speed | None = None
    end_length: float = 5.0

    @property
    def even(self) -> bool:
        """Whether the whole contour has one speed."""
        return self.corner is None and self.start is None and self.end is None


@dataclass(frozen=True, slots=True)
class SwitchPoint:
    """A place on the way and a time, mm and seconds before or behind the start or the end."""

    mm: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class OutputSwitching:
    """When outputs are set, None for at the start and the end themselves, where the tool stops."""

    on_before: SwitchPoint | None = None
    on_after: SwitchPoint | None = None
    off_before: SwitchPoint | None = None
    off_after: SwitchPoint | None = None


@dataclass(frozen=True, slots=True)
class ContourTravel:
    """Travel between contours.

    height: mm above the highest point of the layer, None for the approach and retract of each
    contour. blend: of the places above the work. kind: None for lines, and joint moves where a
    tool that follows the contours would wind up.
    """

    height: float | None = None
    blend: Blend = FINE
    kind: Literal["joint", "linear"] | None = None


EVEN_SPEED: Final = SpeedProfile()
SWITCHED_AT_ENDS: Final = OutputSwitching()
TRAVEL_BY_APPROACH: Final = ContourTravel()
