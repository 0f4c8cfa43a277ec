"""What is found when it is asked what an arm reaches."""

from __future__ import annotations

from assistant.program.diagnostics import error, warning

NO_REGION = error(
    "CK460",
    "the region is {what}",
    "state x, y and z as LOW:HIGH:STEP in mm, or as one number",
)
TOO_MANY = error(
    "CK461",
    "{count:,} {what} are more than the {most:,} that are looked at",
    "take a larger step, or a smaller range",
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
