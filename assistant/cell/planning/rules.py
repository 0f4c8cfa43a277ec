"""What is found when a way through a cell is asked for."""

from __future__ import annotations

from assistant.base.diagnostics import error, info

NO_PLANNER = error(
    "CK440",
    "ways are planned by the library ompl, which is not installed",
    "install the extra: pip install 'robot-assistant[plan]'",
)
PATH_OUTSIDE_LIMITS = error(
    "CK441",
    "the way {where} with {axis} at {value:.6g} {unit}, which its limits of {low:g} to {high:g} "
    "leave out",
    "give joints inside the limits",
)
START_TOUCHES = error(
    "CK442",
    "where the way begins `{one}` touches `{other}`, {deep:.3g} mm deep",
    "begin away from it; two that may touch stand under `allowed` of [world]",
)
GOAL_NOT_REACHED = error(
    "CK443",
    "no branch of the {robot} reaches {goal} inside its limits",
    "move the goal, the body that it belongs to, or the base of the robot",
)
GOAL_TOUCHES = error(
    "CK444",
    "at {goal} `{one}` touches `{other}`, {deep:.3g} mm deep; so in each of the ways to hold the "
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
    "the way keeps `{one}` only {least:.3g} mm from `{other}`, whose margin is {margin:g} mm, as "
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
