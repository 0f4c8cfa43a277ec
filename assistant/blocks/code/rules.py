"""What is found where code is generated."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error

NO_CLOSED_FORM: Final = error(
    "BL301",
    "{title} has no kinematics in closed form, so no source of it can be written",
    "choose an arm of six axes with a spherical wrist, of five, or a SCARA",
)
ALWAYS_SINGULAR: Final = error(
    "BL302",
    "{title} is near a singularity wherever its limits let it go; no table can prove its source",
    "look at the lengths and the limits of its file",
)
