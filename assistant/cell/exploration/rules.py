"""What is found in charts of explored space and in what explores."""

from __future__ import annotations

from assistant.base.diagnostics import error, info, warning

NO_MAP = error(
    "CK450", "this is no chart of explored space: {reason}", "save it again with what explored"
)
NEWER_MAP = error(
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
NO_EXPLORING_ROBOT = error(
    "CK457", "there is no robot `{name}` in the cell", "choose one of {names}"
)
WRONG_CELL_SIZE = error("CK458", "cells cannot be {size} mm", "give a length in mm above 0")
NOT_RECORDED = error(
    "CK480",
    "the recording has no joints {names}, which a {robot} has",
    "record the joints of that arm, as `robot-assistant monitor --log` does",
)
NO_RECORDED_COLUMN = error(
    "CK481",
    "the recording has no column {name}",
    "write one of {known}; `robot-assistant monitor` records signals that it is told",
)
BLANK_ROWS = warning(
    "CK482", "{count} of {total} rows lack joints and tell nothing", "record all joints"
)
RECORDED_OUTSIDE_LIMITS = error(
    "CK483",
    "{axis} is at {value:g} {unit} in the recording, and a {robot} has it between {low:g} and "
    "{high:g}",
    "take the recording of that arm, in degrees, or name its robot",
)
TIMES_NOT_ASCENDING = error(
    "CK484",
    "the seconds of the recording do not ascend, so that what was before a contact is not known",
    "record each time into a file of its own",
)
NOTHING_UNKNOWN = error(
    "CK490",
    "`unknown` says what becomes of space that a chart does not know, and `{name}` has no chart",
    'write explored = "….npz" as well, or leave `unknown` out',
)
CHART_BODY_NAME = error(
    "CK491",
    "`{name}` is what the body is called that a chart of explored space gives the cell",
    "rename the one of the cell file",
)
OTHER_HIDDEN_ROBOT = error(
    "CK487",
    "`{name}` is a {other} in {hidden}, and a {robot} in {cell}",
    "give the robot the same model in both cell files",
)
STANDS_ELSEWHERE = error(
    "CK488",
    "the robots of {hidden} are not those of {cell}, or `{name}` stands elsewhere there",
    "give both cell files the same robots, at the same places",
)
CELLS_TOO_LARGE = warning(
    "CK489",
    "cells of {size:g} mm are too large for `{name}`: where it has been is not all known to be "
    "free",
    "explore with cells of {better:.3g} mm at most",
)
SKIN_IN_UNKNOWN = info(
    "CK497",
    "space that nobody explored is kept free of `{name}` but for its skin: {skin:.4g} mm of what "
    "it moves may be in it",
    "explore with smaller cells for a thinner skin, and move slowly at first",
)
MANY_PATHS = error(
    "CK492",
    "the program may go several ways, so that nobody knows where it has been",
    "record the joints while it runs, with `robot-assistant monitor --log`, for `explore recorded`",
)
CHART_ONLY_HERE = error(
    "CK493",
    "the chart of `{name}` tells of the space about where it stands, and of no other place",
    "leave `explored` out of the cell file, and explore where the robot is put",
)
