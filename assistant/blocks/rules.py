"""What is wrong with connections of blocks."""

from __future__ import annotations

from assistant.base.diagnostics import error

NO_STATEMENTS = error(
    "BL201",
    "`{name}` at {address} carries out no single statements",
    "name a controller of Mitsubishi's CR family, by the address of its controller link",
)
OUT_OF_LIMITS = error(
    "BL202",
    "block `{block}` is to go to J{axis} {value:.2f}, outside {low:g} to {high:g}",
    "give it joints that {robot} reaches",
)
TARGET_NOT_FINITE = error(
    "BL203", "block `{block}` is to go to a place of numbers that are none", "look at its source"
)
OUT_OF_LOCK_STEP = error(
    "BL204",
    "a virtual controller does not keep step with the model: {reason}",
    "look at its program, or run the model in real time",
)
NO_SETPOINT_MODE = error(
    "BL205", "`{name}` cannot be led step by step by `{by}`", "write one of {known}"
)
NO_STATUS_STREAM = error(
    "BL206",
    "`{name}` at {address} has no data link that tells where its arm is",
    "name a controller that has one, by the address of its controller link",
)
STEP_TOO_FAR = error(
    "BL207",
    "block `{block}` is to go {step:.2f} {unit} in one step, and {most:g} are allowed",
    "give it smaller steps, or let the block allow larger ones",
)
STEP_TOO_FAST = error(
    "BL208",
    "block `{block}` is to move {axis} by {speed:.2f} a second, and {most:.2f} are allowed",
    "give it smaller steps, or open its connection with a larger percentage",
)
NO_JOINTS_NEARBY = error(
    "BL209",
    "block `{block}` is to take the tool to {point}, where no joints near the last ones bring it",
    "keep it inside of the reach of {robot}, and away from singular postures",
)
SETPOINTS_BEHIND = error(
    "BL210",
    "the arm does not come after: {count} steps of the model have not gone out to it",
    "make fewer or smaller steps, and look whether its controller lets it move",
)
BAD_QUATERNION = error(
    "BL211",
    "the quaternion of block `{block}` is {length:.4g} long, which is not a rotation",
    "give w, x, y, z of a unit quaternion",
)
NO_FIVE_AXIS_ANGLES = error(
    "BL212",
    "the quaternion of block `{block}` has no A and B on the five axes of {robot}: {reason}",
    "give a tool axis in the vertical plane through axis 1 and the position, or X, Y, Z, A, B, C",
)
