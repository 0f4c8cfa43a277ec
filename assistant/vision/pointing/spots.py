"""What a finder gives: where a mark is seen in one picture, how large, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MarkSpot:
    """place: pixel (u, v) at which the mark's middle is projected. radius: pixels.

    angle: radians between its middle and its outline, None of a light. confidence: 0 to 1; of a
    ball the part of its outline that is seen where it should be, of a light how much brighter than
    all else it is. at_edge: it reaches the edge of the picture.
    """

    place: tuple[float, float]
    radius: float
    angle: float | None
    confidence: float
    at_edge: bool = False
