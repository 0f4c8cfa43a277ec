"""What is wrong with blocks that have something to do with the world: arms, grippers, cameras."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error

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
