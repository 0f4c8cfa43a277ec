"""What is found in drawings that are read for bodies."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

NO_SOLID: Final = info("CK430", "{count} {kind} on layer `{layer}` left out: {reason}")
SOLID_NOT_READ: Final = warning(
    "CK431",
    "{count} {kind} on layer `{layer}` cannot be read as bodies: {reason}",
    "convert them to a mesh in the CAD system, or export them as STL",
)
PARTLY_READ: Final = warning(
    "CK432",
    "{count} {kind} on layer `{layer}` read without their {reason}",
    "convert them to a mesh in the CAD system, or export them as STL",
)
NO_BODY_DRAWN: Final = error(
    "CK433",
    "nothing in the drawing is a body",
    "draw meshes, 3D faces, or closed polylines and circles with a thickness",
)
BODY_RENAMED: Final = info("CK434", "the body `{given}` is called `{name}`")
BODY_TWICE: Final = error(
    "CK435",
    "the drawing of the cell has a body `{name}` as well",
    "rename the block or layer of the drawing, or the body",
)
