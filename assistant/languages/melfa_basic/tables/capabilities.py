"""Capabilities of the dialects for the constructs of programs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.languages.melfa_basic.tables.equivalents import TRIGGER_MEASURES
from assistant.languages.melfa_basic.tables.variables import MOST_PULSES, is_external
from assistant.program.passes.legalisation import (
    Arrays,
    Capabilities,
    Comments,
    FiveAxes,
    Motions,
    Mounts,
    Outputs,
    Positions,
    Procedures,
    Switches,
    Units,
    Variables,
)

if TYPE_CHECKING:
    from assistant.robots import Robot

_UNITS: Final = Units(
    most=30_000,  # its steps end at 32767, and the heading takes some
    least_most=2,
    least=1,
    counted="procedure",
    part="{}_part_{}",
    unit="",
    path="{}",
    straight=True,
    most_steps=LAST_STEP - 700,
    first=6,
    steps={"speed": 2, "blend": 1, "tool": 1, "frame": 1},
    split=rules.SPLIT,
)
_ARRAYS: Final = Arrays(dimensions=3, elements=999, listed=frozenset({"position", "joints"}))
"""COSIMIR help, Dim."""
_VARIABLES: Final = Variables(
    external=is_external,
    persistent=rules.PERSISTENT,
    carried=rules.CARRIED,
    repeated=rules.REPEATED,
)
_COMMENTS: Final = Comments(most_bytes=100, message=rules.MESSAGE)
_OUTPUTS: Final = Outputs(
    measures=frozenset(measure for measure, _ in TRIGGER_MEASURES.values()),
    known=False,
    unlike=rules.PLACE_UNLIKE,
    pulse=rules.PULSE_UNLIKE,
    scaled=rules.REGISTER_UNITS,
    behind=rules.BEHIND,
    timed=rules.BY_SPEED,
    most_pulses=MOST_PULSES,
    waiting=rules.PULSE_WAITS,
    most=1,
    before=rules.SET_BEFORE,
)
_FIVE_AXES: Final = FiveAxes(
    unreachable=rules.UNREACHABLE, over_the_back=rules.OVER_THE_BACK, to_base=rules.TO_BASE
)
_MOUNTS: Final = Mounts(
    held=rules.HELD, load=rules.LOAD, joined=rules.FRAME_JOINED, bent=rules.FIVE_AXIS_TOOL
)
_FARTHEST: Final = 1e6
"""mm or degrees; no robot reaches there, and a controller refuses the number."""
_NOMINAL_TCP: Final = 5000.0
"""Speed in mm/s for 100 percent of joint speed if no robot is named."""


def positions(robot: Robot | None) -> Positions:
    return Positions(
        decimals=poses.PLACES,
        farthest=_FARTHEST,
        not_finite=rules.NOT_FINITE,
        branches=partial(poses.rounded_configurations, robot=robot),
        external=2,
        joints=6 if robot is None else min(len(robot.axes), 6),
        own=tuple if robot is None else robot.own_joints,
        mounts=_MOUNTS,
    )


def motions(robot: Robot | None) -> Motions:
    known = None if robot is None else robot.tcp_speed
    return Motions(
        fastest=_NOMINAL_TCP if known is None else known,
        unknown=rules.UNKNOWN,
        percent=rules.JOINT_PERCENT,
        computed_percent=rules.COMPUTED_PERCENT,
        speed_part=rules.SPEED_PARTS,
        blend_part=rules.BLEND_PARTS,
    )


def capabilities(
    dialect: Dialect, robot: Robot | None = None, most_targets: int | None = None
) -> Capabilities:
    """most_targets: of one unit, None for the language's own limit."""
    return Capabilities(
        kin=frozenset(DIALECTS),
        cannot_say=rules.CANNOT_SAY,
        no_fit=rules.NO_FIT,
        ended=rules.ENDED,
        units=_UNITS if most_targets is None else replace(_UNITS, most=most_targets),
        procedures=Procedures(
            functions=dialect.functions,
            as_variables=rules.AS_VARIABLES,
            recursive=rules.RECURSIVE,
            longest=dialect.line - len(f"{LAST_STEP} "),
            longest_name=dialect.names,
        ),
        arrays=_ARRAYS,
        variables=_VARIABLES,
        switches=Switches(nested=dialect.nested_select),
        outputs=_OUTPUTS,
        comments=_COMMENTS,
        five_axes=_FIVE_AXES if robot is not None and robot.five_axis else None,
    )
