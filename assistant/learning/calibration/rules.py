"""What is found in measured poses, and in what an arm's calibration makes of them."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

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
