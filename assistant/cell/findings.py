"""Findings of the cell room: cell files, drawings, link meshes, charts, plans and reach."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning
from assistant.base.installation import missing_extra

NO_LIBRARY = missing_extra(
    "CK400",
    "{what} handled by the library {name}, which is not installed",
    "cell",
)
NO_PARENT = error(
    "CK401",
    "body `{name}` stands in `{parent}`, which the cell has not",
    "write one of {known}, or the name of another body",
)
CIRCULAR_PARENTS = error(
    "CK402", "body `{name}` stands in itself, by way of `{parent}`", "let one of them name `world`"
)
NO_BODY = error(
    "CK403", "there is no body `{name}`", "write the name of a body or link of the cell"
)
NO_ROBOT = error(
    "CK413", "there is no robot `{name}`", "choose one of {names}, or name a robot file beside it"
)
NO_SHAPE = error("CK404", "`{name}` has {what}", "{cure}")
SAME_BODY = error(
    "CK405", "bodies `{name}` and `{other}` differ only in upper and lower case", "rename one"
)
LONELY_TOOL = error(
    "CK406", "the tool `{name}` is no body of the cell", "give it a shape under [bodies]"
)
NO_MESH = error("CK407", "this is no mesh that is read: {reason}", "{cure}")
OPEN_MESH = warning(
    "CK408",
    "the mesh is open at {count} edges, so that nothing is inside it",
    "close it, or read it as `convex`",
)
INSIDE_OUT = warning(
    "CK409", "the triangles of the mesh face inwards; they are turned round", "export it again"
)
NO_AREA = warning(
    "CK410", "{count} of {total} triangles have no area and are left out", "repair the mesh"
)
SIMPLIFIED = warning(
    "CK411",
    "the mesh has {given:,} triangles; it is simplified to {kept:,}, at most {mm:.2g} mm thicker",
    "export it coarser",
)
NO_UNIT = info(
    "CK412",
    "the file says no unit; its numbers are taken as {unit}",
    'write unit = "mm" or another',
)
NO_SIZE = error("CK414", "this {what} is no body: {reason}", "give it finite sizes above 0 mm")


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


NO_PLANNER = missing_extra(
    "CK440",
    "ways are planned by the library ompl, which is not installed",
    "plan",
)
PATH_OUTSIDE_LIMITS = error(
    "CK441",
    "the way {where} with {axis} at {value:.6g} {unit}, which its limits of {low:g} to {high:g} "
    "leave out",
    "give joints inside the limits",
)
START_TOUCHES = error(
    "CK442",
    "where the way begins `{one}` touches `{other}`, {deep} mm deep",
    "begin away from it; two that may touch stand under `allowed` of [world]",
)
GOAL_NOT_REACHED = error(
    "CK443",
    "no branch of the {robot} reaches {goal} inside its limits",
    "move the goal, the body that it belongs to, or the base of the robot",
)
GOAL_TOUCHES = error(
    "CK444",
    "at {goal} `{one}` touches `{other}`, {deep} mm deep; so in each of the ways to hold the "
    "arm there ({count})",
    "move the goal away from it; two that may touch stand under `allowed` of [world]",
)
NO_PATH = error(
    "CK445",
    "no way to {goal} was found in {seconds:.3g} s; the nearest approach is {apart:.0f} mm away, "
    "with the joints at {joints}; from there {what}",
    "allow more time, a smaller margin, or go by a place between",
)
LESS_MARGIN = info(
    "CK446",
    "the way keeps `{one}` only {least} mm from `{other}`, whose margin is {margin:g} mm, as "
    "it is that near where the way {where}",
    "move the target, or state a smaller margin in the cell file",
)
PATH_TILTED = error(
    "CK447",
    "where the way {where}, the tool is tilted by {angle:.3g} degrees, which a cone of "
    "{most:g} degrees leaves out",
    "turn the tool there, or allow a wider cone",
)
STOPS_AT_CORNERS = info(
    "CK448",
    "the way stops at {count} of its {total} corners: rounded, they would come too near to a body "
    "or tilt the tool too far",
    "nothing, or plan with a larger margin or cone",
)
WRONG_JOINT_COUNT = error(
    "CK449",
    "{what} has {given} finite joints, the {robot} has {wanted}",
    "give a number for each axis",
)
FEWER_LINES = info(
    "CK485",
    "{count} of the {total} moves of the way are joint moves: on straight lines there the arm "
    "would come too near to a body, leave its branch or its limits, or not move its tip at all",
    "nothing, or go by places between",
)
SENSELESS_VALUE = error(
    "CK486",
    "for the way {what} is {value}",
    "give {wanted}",
)


NO_REGION = error(
    "CK460",
    "the region is {what}",
    "state x, y and z as LOW:HIGH:STEP in mm, or as one number",
)
TOO_MANY_POINTS = error(
    "CK461",
    "{count:,} {what} are more than the {most:,} that are looked at",
    "take a larger step or cell, or a smaller range",
)
NO_DIRECTION = error(
    "CK462",
    "`{given}` is no direction of a tool",
    "write down, up, x,y,z, or a cone such as down/30: the direction and 8 others that are tilted "
    "from it by so many degrees",
)
NOTHING_REACHED = warning(
    "CK463",
    "nothing of the region is reached{why}",
    "move the region, take other directions, or state the tip of the tool",
)
NO_TARGETS = error(
    "CK464",
    "{what} has nothing that the tool goes to",
    "name a program with targets, or give bodies locations in the cell file",
)
NO_MOVABLE_BODY = error(
    "CK465",
    "there is no body `{name}` that stands in the world and could stand elsewhere",
    "choose one of {names}",
)
NO_PLACE = error(
    "CK466",
    "no place of {count:,} reaches everything; the best one, {best}, reaches {reached} of {total}, "
    "and not `{first}`",
    "take other ranges, fewer targets, or an arm that reaches farther",
)
OVERLAPPING_PLACES = info(
    "CK467",
    "at {count:,} of the {total:,} places `{one}` would stand in `{other}`; they are left out",
    "nothing; two that may touch stand under `allowed` of [world]",
)
NO_TURNS = error(
    "CK468", "{count} turns of the tool cannot be tried", "state a number from 1 to {most}"
)
NOT_SWEPT = info(
    "CK469",
    "{what}, so that what it sweeps there is not counted",
    "see docs/simulating.md for what is timed",
)
