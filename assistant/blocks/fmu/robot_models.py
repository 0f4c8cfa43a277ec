"""FMU models of robots: a simulated arm, the motion of a program, and a live controller.

The arm moves to the joints or pose at its inputs. The motion of a program is its simulation as a
table, which is played, paused and sped up. The live model sends joints to a controller and gets
joints back in each of its cycles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import field
from typing import TYPE_CHECKING, Final

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.blocks import rules
from assistant.blocks.code import number_literal, number_literals, safe_text, source_identifier
from assistant.blocks.fmu.co_simulation import Group, Model, StartValue, Variable
from assistant.controllers.cyclic import Settings
from assistant.controllers.mitsubishi.external_control import PORT, usual_cycle
from assistant.robots import Robot
from assistant.robots.timing import drive_of
from assistant.robots.timing.simulation import samples_of

if TYPE_CHECKING:
    from assistant.robots.timing import Samples, Simulation


_POSE_PARTS: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")


def _joint_variables(
    robot: Robot,
    name: str,
    description: str,
    starts: Iterable[StartValue] | None = None,
    per: str = "",
) -> list[Variable]:
    """One for each axis, its name for `{}`; per: what its unit is divided by, such as `/s`."""
    known = [None] * len(robot.axes) if starts is None else [float(value) for value in starts]
    units = ["mm" if slides else "deg" for slides in robot.sliding]
    return [
        Variable(name.format(axis), f"{description} of {axis}", start, f"{unit}{per}")
        for axis, start, unit in zip(robot.axes, known, units, strict=True)
    ]


def _flag_variables(robot: Robot, name: str, description: str) -> list[Variable]:
    """One that says yes or no for each axis."""
    return [Variable(name.format(axis), description.format(axis)) for axis in robot.axes]


def _pose_variables(
    name: str, description: str, starts: Iterable[float] | None = None
) -> list[Variable]:
    """Position in mm and quaternion of a pose, its part for `{}`."""
    known = [None] * len(_POSE_PARTS) if starts is None else [float(value) for value in starts]
    return [
        Variable(name.format(part), f"{description}, {part}", start, "" if "q" in part else "mm")
        for part, start in zip(_POSE_PARTS, known, strict=True)
    ]


def arm_model(robot: Robot, *, lag: float = 0.0) -> Model:
    """Return the model of an arm that moves to its commanded joints or poses, as `ArmMotion` does.

    lag: seconds of the first-order lag of the joints, start value of `time_constant`. Raises
    Refused for an arm without a closed form.
    """
    title = safe_text(robot.title)
    return Model(
        identifier=f"{source_identifier(robot.name)}_simulated",
        title=f"{title}, simulated",
        description=f"An arm of {title} that follows joints or poses within its limits",
        template="arm",
        groups=_arm_groups(robot, lag),
        robot=robot,
        follows=frozenset({"STARTS"}),
    )


def _arm_groups(robot: Robot, lag: float) -> tuple[Group, ...]:
    drive, home = drive_of(robot), robot.home
    (position,), (quaternion,) = robot.fk(home)
    low, high = robot.limits.T
    return (
        Group("STARTS", "Real", "parameter",
              _joint_variables(robot, "{}_start", "joint at the start", home)),
        Group("SPEED_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_speed_limit", "top speed", drive.speeds, "/s")),
        Group("ACCELERATION_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_acceleration_limit", "acceleration at most",
                              drive.accelerations, "/s2")),
        Group("LOWER_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_lower_limit", "lower limit", low)),
        Group("UPPER_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_upper_limit", "upper limit", high)),
        Group("TIME_CONSTANT", "Real", "parameter",
              [Variable("time_constant", "first order by which joints follow, 0 for none",
                        float(lag), "s")]),
        Group("WANTED_JOINTS", "Real", "input",
              _joint_variables(robot, "{}_wanted", "wanted joint", home)),
        Group("WANTED_POSE", "Real", "input",
              _pose_variables("{}_wanted", "wanted pose of the flange in the base",
                             np.concatenate([position, quaternion]).tolist())),
        Group("JOINTS", "Real", "output", _joint_variables(robot, "{}", "joint")),
        Group("SPEEDS", "Real", "output",
              _joint_variables(robot, "{}_speed", "speed of the motor", per="/s")),
        Group("POSE", "Real", "output", _pose_variables("{}", "pose of the flange in the base")),
        Group("BRANCH", "Integer", "input",
              [Variable("branch", "of the arm for poses; -1 for the nearest one", -1)]),
        Group("CONFIGURATION", "Integer", "output", _configuration_variables()),
        Group("BY_POSE", "Boolean", "input",
              [Variable("by_pose", "whether the wanted pose counts, not the joints", start=False)]),
        Group("REACHABLE", "Boolean", "output",
              [Variable("reachable", "whether what is wanted is inside all limits")]),
        Group("AT_LIMIT", "Boolean", "output",
              _flag_variables(robot, "{}_at_limit", "whether {} stays inside its limit")),
        Group("AT_SPEED", "Boolean", "output",
              _flag_variables(robot, "{}_at_speed", "whether {} goes at its top speed")),
    )  # fmt: skip


def _configuration_variables() -> list[Variable]:
    said = {
        "back": "1 for a wrist behind axis 1, a SCARA: elbow left",
        "down": "1 for an elbow below, a SCARA: 1",
        "flip": "1 for a flipped wrist, a SCARA and five axes: 1",
        "quarter_J1": "quarter turn of J1, from 0",
        "quarter_J4": "quarter turn of J4, from 0",
        "quarter_J6": "quarter turn of J6, from 0",
    }
    return [Variable(name, description) for name, description in said.items()]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Rows of a motion, one each period and the last one at its end.

    table: (n, a + 8) joints, position in mm and quaternion of the tool, its speed in mm/s.
    """

    table: Floats
    period: float
    seconds: float

    @staticmethod
    def of(simulation: Simulation) -> Motion:
        """The samples of a simulation at its period, and where it ends."""
        seconds, period = simulation.seconds, simulation.period
        table = _motion_rows(simulation.samples)
        if seconds > 0.0:
            ends = (simulation.history, seconds, seconds, simulation.robot, simulation.start)
            # A sample at the end itself, or so near to it that nothing is between, gives way.
            kept = math.ceil(seconds / period - 1e-6)
            table = np.concatenate([table[:kept], _motion_rows(samples_of(*ends))[-1:]])
        return Motion(table, period, seconds)

    def at(self, time: float) -> Floats:
        """(a + 8,) between two rows: in lines, and the tool on the shorter turn."""
        row = min(math.floor(time / self.period), len(self.table) - 2)
        start = row * self.period
        end = self.seconds if row == len(self.table) - 2 else (row + 1) * self.period
        part = max(0.0, min(1.0, (time - start) / (end - start)))
        one, two = self.table[row], self.table[row + 1]
        out = one + part * (two - one)
        turn = slice(len(out) - 5, len(out) - 1)
        out[turn] = rotations.between(one[turn], two[turn], part)
        return np.asarray(out)


@dataclass(slots=True)
class Playback:
    """A motion that is played. repeat: again from the begin at the end.

    time: how far it is, in seconds of the program. ends: how often it came to its end.
    """

    motion: Motion
    repeat: bool = False
    time: float = 0.0
    ends: int = 0
    _before: bool = field(default=False, repr=False)
    _lost: float = field(default=0.0, repr=False)

    def step(
        self, seconds: float, *, play: bool = True, restart: bool = False, factor: float = 1.0
    ) -> Floats:
        """The row (a + 8,) after a step.

        play: whether it goes on. restart: from the begin, where it was false before. factor: how
        fast it is played; what is not above 0 holds it.
        """
        if restart and not self._before:
            self.time = self._lost = 0.0
        self._before = restart
        end = self.motion.seconds
        if play and factor > 0.0 and self.time < end:
            self._on(seconds * factor)
            if self.time >= end:
                self.ends += 1
                self.time = math.fmod(self.time, end) if self.repeat else end
                self._lost = 0.0
        return self.motion.at(self.time)

    def _on(self, seconds: float) -> None:
        """Adds to the time, with what rounding loses (Kahan, 1965): steps are many and short."""
        more = seconds - self._lost
        later = self.time + more
        self._lost = (later - self.time) - more
        self.time = later


def _motion_rows(samples: Samples) -> Floats:
    return np.column_stack(
        [samples.joints, samples.position, samples.quaternion, samples.tcp_speed]
    )


_MOST_TABLE_ROWS: Final = 50_000
"""Rows of a table: each takes about 300 bytes of source."""

_USUAL_PERIOD: Final = 0.002


def usual_period(seconds: float) -> float:
    """Seconds between rows of a motion that takes so long: 0.002, or what fits `_MOST_TABLE_ROWS`.

    In lines between rows of 0.002 s the tool is a twentieth of a millimetre off where an arm
    accelerates most; that grows with the square of the period.
    """
    period = _USUAL_PERIOD
    while seconds / period > _MOST_TABLE_ROWS - 2:
        period *= 2.5 if f"{period:e}".startswith("2") else 2.0
    return period


def program_model(motion: Motion, robot: Robot, name: str) -> Model:
    """The motion of a program, as `Playback` plays it. name: of the program.

    Raises Refused for a motion that takes no time, or too many rows.
    """
    rows = len(motion.table)
    if not motion.seconds > 0.0:
        raise Refused(rules.NO_MOTION())
    if rows > _MOST_TABLE_ROWS:
        least = motion.seconds / (_MOST_TABLE_ROWS - 2)
        raise Refused(
            rules.TOO_MANY_ROWS(
                seconds=motion.seconds,
                period=motion.period,
                rows=rows,
                most=_MOST_TABLE_ROWS,
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
        Group("JOINTS", "Real", "output", _joint_variables(robot, "{}", "joint")),
        Group("POSE", "Real", "output", _pose_variables("{}", "pose of the tool")),
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


_LOCAL_HOST: Final = "127.0.0.1"
"""Address of a virtual controller, the default host."""
USUAL_SPEED_SHARE, USUAL_RISE_SHARE = 0.5, 0.2
"""Default parts of the arm's speeds and accelerations."""


def live_model(robot: Robot, *, cycle: float | None = None) -> Model:
    """Return the model of a controller that is guided cycle by cycle.

    cycle: seconds, None for the default of the controller. Raises Refused for an arm without a
    closed form, a robot of another maker, and an invalid cycle.
    """
    if not robot.controller.startswith("CR"):
        raise Refused(rules.NO_LIVE_CONTROLLER(title=robot.title, controller=robot.controller))
    usual = usual_cycle(robot.controller)
    seconds = usual if cycle is None else cycle
    if not 0.001 <= seconds <= 0.1:
        raise Refused(rules.BAD_CYCLE(value=seconds), exit_status=2)
    title, drive = safe_text(robot.title), drive_of(robot)
    return Model(
        identifier=f"{source_identifier(robot.name)}_live",
        title=f"{title}, live",
        description=f"A controller of {title} in real-time external control, joints each cycle",
        template="live",
        groups=_live_groups(robot),
        robot=robot,
        told={
            "cycle": number_literal(seconds),
            "tables": [
                ("TOP_SPEEDS", number_literals(drive.speeds)),
                ("TOP_RISES", number_literals(drive.accelerations)),
                ("AT_PLACE", robot.places),
            ],
        },
        step=seconds,
        any_step=False,
        copies=False,
        libraries=("ws2_32",),
    )


def _live_groups(robot: Robot) -> tuple[Group, ...]:
    drive, usual = drive_of(robot), Settings()
    low, high = robot.limits.T
    return (
        Group("SPEED_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_speed_limit", "top speed",
                              USUAL_SPEED_SHARE * drive.speeds, "/s")),
        Group("ACCELERATION_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_acceleration_limit", "acceleration at most",
                              USUAL_RISE_SHARE * drive.accelerations, "/s2")),
        Group("LOWER_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_lower_limit", "lower limit", low)),
        Group("UPPER_LIMITS", "Real", "parameter",
              _joint_variables(robot, "{}_upper_limit", "upper limit", high)),
        Group("TIMEOUT", "Real", "parameter",
              [Variable("timeout", "without an answer until it is given up", usual.timeout, "s")]),
        Group("APPROACH", "Real", "parameter",
              [Variable("approach", "how far, in degrees or mm, the first goal may be",
                        usual.approach)]),
        Group("LAG", "Real", "parameter",
              [Variable("lag", "that the arm may be behind, at its speed limits", usual.lag, "s")]),
        Group("SLACK", "Real", "parameter",
              [Variable("slack", "degrees or mm that it may be off beside that", usual.slack)]),
        Group("WANTED_JOINTS", "Real", "input",
              _joint_variables(robot, "{}_wanted", "wanted joint", robot.home)),
        Group("JOINTS", "Real", "output", _joint_variables(robot, "{}", "measured joint")),
        Group("COMMANDS", "Real", "output",
              _joint_variables(robot, "{}_command", "commanded joint")),
        Group("POSE", "Real", "output",
              _pose_variables("{}", "measured pose of the flange in the base")),
        Group("LONGEST_DELAY", "Real", "output",
              [Variable("longest_delay", "from an answer to the next packet", None, "s")]),
        Group("PORT", "Integer", "parameter", [Variable("port", "of the controller, UDP", PORT)]),
        Group("CYCLES", "Integer", "output", [Variable("cycles", "packets that were answered")]),
        Group("LATE_STEPS", "Integer", "output",
              [Variable("late_steps", "packets later than half a cycle behind an answer")]),
        Group("LOST", "Integer", "output", [Variable("lost", "packets that were not answered")]),
        Group("GARBLED", "Integer", "output", [Variable("garbled", "answers without sense")]),
        Group("SHORT_PACKETS", "Boolean", "parameter",
              [Variable("short_packets", "of 64 bytes, for the CRn-500 series", start=False)]),
        Group("ENABLE", "Boolean", "input",
              [Variable("enable", "whether the arm goes to what is wanted; else it comes to rest",
                        start=False)]),
        Group("CONFIRMED", "Boolean", "output",
              [Variable("confirmed", "whether motion was confirmed at the start")]),
        Group("VIRTUAL", "Boolean", "output",
              [Variable("virtual", "whether the controller is on this machine")]),
        Group("MOVING", "Boolean", "output",
              [Variable("enabled", "whether the arm goes to what is wanted")]),
        Group("REFUSED", "Boolean", "output",
              [Variable("refused", "whether what is wanted is too far away to begin")]),
        Group("AT_LIMIT", "Boolean", "output",
              _flag_variables(robot, "{}_at_limit", "whether {} stays inside its limit")),
        Group("CONTROLLER", "String", "parameter",
              [Variable("controller", "name or address; a real one is named here", _LOCAL_HOST)]),
        Group("CONFIRM", "String", "parameter",
              [Variable("confirm", "the same as controller: the arm may move", "")]),
    )  # fmt: skip
