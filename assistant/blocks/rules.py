"""Findings of the blocks room, in the order of their codes.

BL1: block diagrams and their runs. BL2: connections of blocks. BL3: generated code. BL4: FMUs.
BL5: blocks for arms, grippers and cells.
"""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, warning

SAME_BLOCK_NAME = error("BL101", "two blocks are called `{name}`", "rename one of them")
NO_PORT = error("BL102", "block `{block}` has no {kind} `{name}`", "write one of {known}")
TWO_WIRES = error(
    "BL103", "two wires lead to `{port}` of `{block}`", "take one of them out, or add the signals"
)
NO_WIRE = error("BL104", "nothing leads to `{port}` of `{block}`", "wire it, or give it a constant")
OTHER_SIGNAL_SIZE = error(
    "BL105",
    "`{start}` gives {given} numbers, and `{end}` takes {wanted}",
    "wire a signal of the same size",
)
OTHER_SIGNAL_UNIT = warning(
    "BL106", "`{start}` is in {given}, and `{end}` is taken as {wanted}", "convert it in between"
)
ALGEBRAIC_LOOP = error(
    "BL107",
    "blocks {names} wait for each other within a step",
    "put a delay or another block that is not direct into the loop",
)
BAD_STEP = error("BL108", "{what} is {value} s", "{cure}")
BLOCK_OF_NO_DIAGRAM = error(
    "BL109", "block `{name}` is of no diagram", "add it before it is wired, each block to one"
)
BLOCK_FAILED = error(
    "BL110", "block `{name}` failed at {now:g} s: {reason}", "look at what it is given"
)
MOTION_NOT_CONFIRMED = error(
    "BL111",
    "block `{block}` moves the arm of `{name}`, and nobody confirmed it; nothing was begun",
    "look that nobody is near, then run it with moving=[{name!r}]",
)
BAD_TIMES = error(
    "BL112",
    "the times of block `{block}` {reason}",
    "give a time in seconds for each row, each later than the one before",
)
NO_START = error(
    "BL113",
    "the arm `{robot}` is to start at {given}, outside its limits",
    "give {count} joints within {ranges}, or none to start at home",
)
WHICH_PORT = error(
    "BL115", "block `{block}` has {count} {kind}s, and none of them is named", "write {known}"
)
NO_SIGNAL = error("BL116", "the run has no signal `{name}`", "choose one of {known}")
NEEDS_CLOCK = error(
    "BL114",
    "block `{block}` steps with a clock, and none is given",
    "give it a clock, such as bd.clock(0.01)",
)


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


NO_COMPILER: Final = warning(
    "BL401",
    "there is no C compiler here, so the FMU holds its source only",
    "install one (gcc, clang or the Python package ziglang) and write it again, or compile "
    "sources/model.c where it is to run",
)
NO_CROSS_COMPILER: Final = warning(
    "BL402",
    "there is no compiler here that makes libraries for {platform}",
    "install {what}, or write the FMU again on such a machine",
)
NOT_COMPILED: Final = error(
    "BL403",
    "{compiler} does not compile the FMU: {reason}",
    "look at what that compiler needs, or have another one first in PATH",
)
TOO_MANY_ROWS: Final = error(
    "BL404",
    "{seconds:.0f} s at {period:g} s make {rows} rows, more than {most}",
    "take a period of {least:g} s or longer",
)
NO_MOTION: Final = error(
    "BL405", "the program takes no time, so there is no motion to play", "let it move the arm"
)
NO_LIVE_CONTROLLER: Final = error(
    "BL406",
    "{title} has a controller {controller}, which no live FMU speaks with",
    "choose an arm of a CR controller, or lead this one from Python",
)
BAD_CYCLE: Final = error(
    "BL407", "{value:g} s is no cycle of a controller", "give 0.001 to 0.1 seconds"
)
PARTLY_PLAYED: Final = warning(
    "BL408",
    "the FMU plays the program as far as it is known before it runs: {what}",
    "state its places in numbers, and look at a run of it beside the FMU",
)


START_TOO_FAR: Final = error(
    "BL501",
    "block `{block}` is to begin at {axis} {value:.2f}, {away:.2f} from where the arm stands",
    "begin the setpoints where the arm is, or at most {most:g} degrees or mm from there",
)
TWO_LEADERS: Final = error(
    "BL502",
    "blocks `{block}` and `{other}` both lead the arm of `{name}`",
    "let one block lead it, and choose between setpoints before",
)
NOT_OPERATED: Final = error(
    "BL503",
    "`{name}` at {address} keeps files, and tells and sets nothing else",
    "name an address by which the controller can be looked at and operated",
)
ARM_OUTSIDE_BOUNDS: Final = error(
    "BL504",
    "the arm of block `{block}` stands outside of its bounds: {what}",
    "bring it inside by hand, or give bounds that hold where it stands",
)
GRIP_NOT_CONFIRMED: Final = error(
    "BL505",
    "the gripper of block `{block}` was to {what}, and did not confirm it within {seconds:g} s",
    "look at the gripper, its air and the inputs that confirm it",
)
OPEN_AND_CLOSED: Final = error(
    "BL506",
    "the gripper of block `{block}` says that it is open and closed at once",
    "look at its sensors and at the names of the inputs",
)
NO_ROBOT_IN_CELL: Final = error(
    "BL507",
    "no single robot `{name}` stands in the cell of block `{block}`",
    "name one of {known}",
)
