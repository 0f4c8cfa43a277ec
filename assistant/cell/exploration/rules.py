"""What is found in maps of explored space and in what explores."""

from __future__ import annotations

from assistant.program.diagnostics import error, warning

NO_MAP = error(
    "CK450", "this is no chart of explored space: {reason}", "save it again with what explored"
)
NEWER = error(
    "CK451",
    "the chart is of version {version:g}, and {known} is the newest that is known here",
    "update robot-assistant",
)
OTHER_GRID = error(
    "CK452",
    "the charts do not fit each other: one has {one}, the other {other}",
    "explore both with the same robot and the same size of cells",
)
TOO_FINE = error(
    "CK453",
    "cells of {size:g} mm are too small: what the robot can reach has {count:,} of them, more than "
    "{most:,}",
    "take larger cells",
)
TOO_COARSE = warning(
    "CK454",
    "no cell of {size:g} mm fits into `{name}`, so that it explores nothing",
    "take cells of {better:.3g} mm at most",
)
OPEN_BODY = warning(
    "CK455",
    "`{name}` has an open mesh, which nothing is inside of, so that it explores nothing",
    "close the mesh, or read it as `convex`",
)
NOT_CLEAR = error(
    "CK456",
    "the robot is in contact where it starts from, so that it explores nothing",
    "bring it to where it touches nothing, and begin there",
)
NO_ROBOT = error("CK457", "there is no robot `{name}` in the cell", "choose one of {names}")
NO_SIZE = error("CK458", "cells cannot be {size} mm", "give a length in mm above 0")
