"""Findings of the learning room: LN0 of learned maps, LN1 of the calibration of arms."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

NO_MAP: Final = error(
    "LN001", "this is no learned map: {reason}", "learn one with `robot-assistant learn`"
)
OTHER_MAP_VERSION: Final = error(
    "LN002",
    "the map has version {version:g} of its format, and {known} is read",
    "learn it again, or read it where it was learnt",
)
OTHER_MAP_TASK: Final = error(
    "LN003",
    "the map has learnt {learnt}, and {asked} is asked for",
    "go on with the robot, joints, points and cameras that it was begun with",
)
NO_TARGET: Final = error(
    "LN004",
    "the target is no picture of the tool: {reason}",
    "show the target to all cameras, every point of the tool",
)
TARGET_TOO_FAR: Final = error(
    "LN005",
    "nothing like the target was learnt: it is {times:.1f} times as far from the nearest unit as "
    "the neighbours of that are",
    "show targets inside the space that was learnt, or let the map learn there as well",
)
TOOL_RARELY_SEEN: Final = error(
    "LN006",
    "the tool was seen by all cameras in {seen} of {total} trials",
    "move the cameras so that they see the tool at all joints of the ranges, or narrow these",
)
BOX_NOT_REACHED: Final = error(
    "LN007",
    "{robot} reaches {share:.0%} of the box with the tool {rule}",
    "move the box or make it smaller",
)
BAD_RANGE: Final = error(
    "LN008",
    "{axis} cannot learn between {low:g} and {high:g}: a {robot} has it between {least:g} and "
    "{most:g}",
    "write a lower and a higher value inside these limits",
)
FEW_POINTS: Final = error(
    "LN009",
    "what is seen of the tool, {points}, does not tell {needed} joints",
    "name points apart from each other and aside of the last axis (one tells 3, two tell 5, three "
    "tell 6 joints), or add `--tool free` to learn only the place, without its orientation",
)
BAD_LATTICE: Final = error(
    "LN010",
    "no lattice of {units} units in {dimensions} dimensions is learnt",
    "choose 1 to 6 counts of at least 2, and {most:,} units at most",
)
BAD_PICTURE_SHAPE: Final = error(
    "LN011",
    "the arm was seen at numbers of shape {shape}, and {wanted} are wanted",
    "answer a row for each row of joints: u, v of each camera, point by point",
)
TOOL_LOST: Final = error(
    "LN012",
    "the tool is out of sight after movement {movement}; it has stopped",
    "look at what hides it, and move the arm back into sight",
)
TARGET_MISSED: Final = warning(
    "LN013",
    "the tool is seen {seen:.2g} px off after {movements} movements, {usual:.2g} are usual there",
    "let the map go on learning, and look at tool and cameras",
)
UNITS_WITHOUT_WINS: Final = warning(
    "LN014",
    "{share:.0%} of the units have not won yet",
    "learn for more steps, or with fewer units",
)
BAD_BOX: Final = error(
    "LN015",
    "the box {reason}",
    "write it as x, y and z of the base in mm, each as LOW:HIGH",
)
NO_AXIS: Final = error("LN016", "{robot} has no joint `{axis}`", "choose among {known}")
NO_LENGTH: Final = error("LN017", "{robot} has no length `{name}`", "choose among {known}")
FEW_ROWS: Final = error(
    "LN023",
    "the recordings have {count} rows of a moving arm, and {least} are needed",
    "record more, in all of the space that is to be learnt",
)
BEYOND_RANGES: Final = warning(
    "LN024",
    "for {share:.1%} of the places the learned posture has {where} beyond its range: the joint "
    "stays at its end, and the point is up to {worst:.0f} mm off; elsewhere {rest:.2g} mm at most",
    "learn with wider ranges than the places that you use need, or keep away from the borders: "
    "most movements there are refused (LN022)",
)
INCOMPLETE_TOOL_RULE: Final = error(
    "LN018",
    "no tool is held {rule} {what}",
    "name a box and how the tool is held there, all joints free, or one point that may be held "
    "anyhow",
)
BAD_HELD_JOINT: Final = error(
    "LN019",
    "{axis} cannot stay at {value:g}: {reason}",
    "hold joints inside their limits, and let one learn at least",
)
TARGET_UNLIKE_TOOL: Final = error(
    "LN020",
    "the target does not look like the tool: its picture is {times:.1f} times as far beside those "
    "that were learnt as is explained",
    "show the same points to all cameras; if one of them has moved, let the map go on learning",
)
UNEXPLAINED_MISS: Final = error(
    "LN021",
    "the tool is seen {seen:.3g} px from the target after movement {movement}, and {most:.3g} px "
    "are explained at most; it has stopped",
    "look at what has changed of tool, robot and cameras, and let the map go on learning",
)
TARGET_BEYOND_RANGE: Final = error(
    "LN022",
    "the target needs {axis} {over:.2g} degrees (mm) beyond {end:g}, the end of what was learnt; "
    "{where}",
    "show a target inside the ranges, or learn the map with a wider range of {axis}",
)


BAD_HEADER: Final = error(
    "LN100",
    "the header of the measured poses {reason}",
    "write the columns {columns}, with the unit in each name",
)
NOT_A_NUMBER: Final = error(
    "LN101", "column `{name}` holds {value}, which is no number", "measure the pose again"
)
ROW_LEFT_OUT: Final = warning(
    "LN102",
    "row {rows} is left out: {reason}",
    "measure the pose again, or take the row out",
)
TOO_FEW_POSES: Final = error(
    "LN103",
    "{count} poses are too few for {parameters} parameters",
    "measure at least {needed}, or estimate less with --estimate zeros",
)
POSES_ALIKE: Final = error(
    "LN104",
    "the poses are all alike: no axis moves by more than {most:.2g} {unit}",
    "turn every axis through most of its range; `robots poses` suggests poses",
)
AXES_HARDLY_MOVE: Final = warning(
    "LN105",
    "{axes} hardly move: less than {least:g} degrees (mm) over all poses",
    "add poses that turn them; `robots poses` suggests some",
)
JOINTS_OUTSIDE_LIMITS: Final = error(
    "LN106",
    "{axis} is {value:.6g} in row {row}, outside {low:g} to {high:g} ({count} such rows)",
    "look at robot, order and unit of the columns; the arm cannot have been there",
)
MISREAD_POSES: Final = error(
    "LN107",
    "the nominal arm misses what is measured by {now}, but by {then} if {what}",
    "{cure}",
)
OTHER_ROBOT: Final = error(
    "LN108",
    "the poses are not of {robot} ({now:.4g} mm off), but fit {other} ({then:.4g} mm)",
    "name the robot that was measured",
)
NO_SMALL_ERRORS: Final = error(
    "LN109",
    "no small errors of {robot} explain the measured poses: {left:.4g} mm are left",
    "look at robot, columns and units, and whether tool and base stood still meanwhile",
)
OUTLIERS: Final = warning(
    "LN110",
    "row {row} is {mm:.3g} mm{turn} off what the other rows say, and is left out",
    "measure it again",
)
TOO_MANY_OUTLIERS: Final = error(
    "LN111",
    "{count} of {total} rows do not fit the others",
    "look at what moved meanwhile: base, tool, camera or tracker",
)
PARAMETER_HELD: Final = info(
    "LN112",
    "{name} is held at {value:.6g} {unit}: {reason}",
    "say what is known with --tool or --in-base, or measure other poses",
)
LARGE_CORRECTION: Final = warning(
    "LN113",
    "{name} would be {value:.4g} {unit} off, more than assembly explains",
    "look at robot, units and columns before the corrected file is used",
)
OVER_FITTED: Final = warning(
    "LN114",
    "poses that were held out are {out:.3g} mm off, those of the fit {inside:.3g} mm",
    "measure more poses, or estimate less with --estimate",
)
NO_GAIN: Final = warning(
    "LN115",
    "the correction does not help poses that were held out: {after:.3g} mm, before {before:.3g} mm",
    "keep the robot file that there is, or measure more exactly",
)
FREE_CHAIN_FITS_BETTER: Final = info(
    "LN116",
    "{left:.3g} mm remain in poses held out, which lengths and zeros of the robot file cannot say;"
    " a free chain of axes leaves {free:.3g} mm",
    "write it with --estimate chain",
)
NO_FILE_LENGTHS: Final = error(
    "LN117",
    "{robot} has no lengths that a robot file says",
    "estimate its zeros with --estimate zeros, or all with --estimate chain",
)
NO_MEASURING_CAMERAS: Final = error(
    "LN118", "the poses hold pixels, and {reason}", "name the cameras with --cameras cameras.toml"
)
SOLVED_NUMERICALLY: Final = info(
    "LN119",
    "the axes of the corrected arm no longer meet, so that it is solved numerically{names}",
    "use --estimate lengths for an arm in closed form",
)
RESIDUAL_ABOVE_NOISE: Final = warning(
    "LN120",
    "the residual is {ratio:.2g} times the stated noise",
    "look for what the model leaves out, or state the noise of the measurement",
)
POINTS_MOVED: Final = warning(
    "LN123",
    "from row {row} on all points are {mm:.3g} mm off what they were before",
    "look at what moved then: base, tool, camera or tracker",
)
TOO_FEW_CANDIDATES: Final = error(
    "LN121",
    "{found} of {wanted} poses could be found{where}",
    "ask for fewer, or for a larger part of the room",
)
COUPLED_AXIS: Final = error(
    "LN122",
    "axis 3 of {robot} turns with J2, which no free chain of axes says",
    "use --estimate lengths or zeros",
)
