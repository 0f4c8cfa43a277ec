"""What is found in the bodies that a robot's file draws."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

NO_PACKAGE: Final = error(
    "CK436",
    "link `{link}` has a mesh in the package `{package}`, and no folder above the URDF holds it",
    'write packages = {{{package} = "FOLDER"}} to the robot, or links = "capsules"',
)
NO_MESH_FILE: Final = error(
    "CK437",
    "link `{link}` has a mesh at `{file}`, which is no file",
    'copy it beside the URDF, or write links = "capsules" to the robot',
)
UNUSED_PACKAGE: Final = warning(
    "CK438",
    "no link of the robot `{name}` has a mesh in the package `{package}`",
    "take it out, or correct its name",
)
FIXED_JOINTS: Final = info(
    "CK439",
    "the joints {joints} of the robot `{name}` are no axes of its arm; what they carry stands as "
    "with them at 0",
)
UNDRAWN_LINKS: Final = info(
    "CK419",
    "the URDF of the robot `{name}` draws nothing on {links}, so that nothing is looked for there",
    'draw them, or write links = "capsules" to the robot',
)
