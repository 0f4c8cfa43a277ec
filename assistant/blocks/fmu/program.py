"""The model of a program's motion: its simulation as a table that is played."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import Refused
from assistant.blocks.code.templates import (
    number_literal,
    number_literals,
    safe_text,
    source_identifier,
)
from assistant.blocks.fmu import rules
from assistant.blocks.fmu.joints import joint_variables, pose_variables
from assistant.blocks.fmu.model import Model
from assistant.blocks.fmu.variables import Group, Variable
from assistant.blocks.playback import Motion
from assistant.robots import Robot

MOST_TABLE_ROWS: Final = 50_000
"""Of a table: each takes about 300 bytes of source."""

USUAL_PERIOD: Final = 0.002


def usual_period(seconds: float) -> float:
    """Seconds between rows of a motion that takes so long: 0.002, or what fits `MOST_ROWS`.

    In lines between rows of 0.002 s the tool is a twentieth of a millimetre off where an arm
    accelerates most; that grows with the square of the period.
    """
    period = USUAL_PERIOD
    while seconds / period > MOST_TABLE_ROWS - 2:
        period *= 2.5 if f"{period:e}".startswith("2") else 2.0
    return period


def program_model(motion: Motion, robot: Robot, name: str) -> Model:
    """The motion of a program, as `Playback` plays it. name: of the program.

    Raises Refused for a motion that takes no time, or too many rows.
    """
    rows = len(motion.table)
    if not motion.seconds > 0.0:
        raise Refused(rules.NO_MOTION())
    if rows > MOST_TABLE_ROWS:
        least = motion.seconds / (MOST_TABLE_ROWS - 2)
        raise Refused(
            rules.TOO_MANY_ROWS(
                seconds=motion.seconds,
                period=motion.period,
                rows=rows,
                most=MOST_TABLE_ROWS,
                least=least,
            )
        )
    title = f"{safe_text(name)} on {safe_text(robot.title)}"
    return Model(
        identifier=f"{source_identifier(name)}_played",
        title=title,
        description=f"The motion of {title}, which takes {motion.seconds:.3f} s",
        template="program",
        groups=_program_groups(robot),
        told={
            "axes": len(robot.axes),
            "period": number_literal(motion.period),
            "seconds": number_literal(motion.seconds),
            "rows": [number_literals(row) for row in motion.table.tolist()],
        },
        step=motion.period,
        stop=motion.seconds,
    )


def _program_groups(robot: Robot) -> tuple[Group, ...]:
    return (
        Group("SPEED_FACTOR", "Real", "input",
              [Variable("speed_factor", "how fast it is played, 1 for as simulated", 1.0)]),
        Group("JOINTS", "Real", "output", joint_variables(robot, "{}", "joint")),
        Group("POSE", "Real", "output", pose_variables("{}", "pose of the tool")),
        Group("TOOL_SPEED", "Real", "output",
              [Variable("tool_speed", "speed of the tool at speed_factor 1", None, "mm/s")]),
        Group("PROGRAM_TIME", "Real", "output",
              [Variable("program_time", "how far the program is", None, "s")]),
        Group("PROGRESS", "Real", "output",
              [Variable("progress", "how far the program is, 0 to 1")]),
        Group("ENDS", "Integer", "output", [Variable("ends", "how often it came to its end")]),
        Group("REPEAT", "Boolean", "parameter",
              [Variable("repeat", "whether it begins again at its end", start=False)]),
        Group("PLAY", "Boolean", "input",
              [Variable("play", "whether it goes on; else the arm stands", start=True)]),
        Group("RESTART", "Boolean", "input",
              [Variable("restart", "from the begin when this becomes true", start=False)]),
        Group("RUNNING", "Boolean", "output",
              [Variable("running", "whether it goes on and is not at its end")]),
        Group("DONE", "Boolean", "output", [Variable("done", "whether it is at its end")]),
    )  # fmt: skip
