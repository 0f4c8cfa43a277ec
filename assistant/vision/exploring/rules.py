"""The findings of an arm that explores the space about it by moving."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, warning

STILL_TOUCHING: Final = error(
    "VS220",
    "the contact did not end on the way back, {back:.0f} mm long; the arm has been stopped",
    "free the arm by hand, and check the source of the contact",
)
START_OUTSIDE_BOUNDS: Final = error(
    "VS221",
    "the arm explores only inside its bounds, and {what}",
    "move the arm into its bounds, or state wider ones",
)
EMPTY_BOX: Final = error(
    "VS222",
    "none of {count:,} random postures has the flange in the box, so there is nowhere to move",
    "move the box to where the arm reaches, or make it larger",
)
NO_CONTACT_PICTURE: Final = error(
    "VS223",
    "no picture of camera `{camera}` came within {seconds:g} s, so contacts cannot be seen",
    "check the camera, and begin again",
)
BAD_REGION: Final = error(
    "VS224",
    "the region {region} is not in the picture of camera `{camera}`, which is {size}",
    "write LEFT,TOP,RIGHT,BOTTOM in pixels of that picture",
)
EXPLORATION_TIME_OVER: Final = warning(
    "VS225",
    "the time is over after {moves} moves",
    "explore again with the same chart, which goes on from there",
)
