"""What is found where a scene is written as a cell file."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info

UNNAMED_ROBOT: Final = error(
    "CK415",
    "the robot `{name}` is neither of the catalogue nor of a file, so no cell file can name it",
    "read it from a robot file that the cell file names",
)
UNWRITABLE_NAME: Final = error(
    "CK416",
    "a cell file cannot hold the name `{name}`",
    "write a letter of A to Z, and letters, digits and `_` behind it",
)
TABLE_LEFT_OUT: Final = info(
    "CK417",
    "[{table}] of the cell file is not of its world, and not written",
    "copy it, where it is needed",
)
CHART_BODY: Final = error(
    "CK418",
    "the body `{name}` is space that a chart tells of, which no cell file holds",
    "leave it out",
)
