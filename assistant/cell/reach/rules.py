"""What is found when it is asked what an arm reaches, and where things stand best."""

from __future__ import annotations

from assistant.base.diagnostics import error, info, warning

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
