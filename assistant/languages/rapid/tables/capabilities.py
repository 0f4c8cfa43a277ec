"""What RAPID can say of what programs ask for."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.motions import corner_of, zone_name
from assistant.languages.rapid.tables.triggers import TRIGGER_MEASURES
from assistant.languages.rapid.tables.words import LEAST_ACCELERATION, LONGEST_STRING, MOST_TARGETS
from assistant.program.passes.legalisation import (
    Acceleration,
    Capabilities,
    Comments,
    Corners,
    Loops,
    Outputs,
    Units,
)

UNITS: Final = Units(
    most=MOST_TARGETS,
    least_most=5,  # room to cut between arcs
    least=2,  # of one target there is no path
    counted="unit",
    part="{:.20}_part{}",
    unit="{:.20}_unit{}",
    path="{}_p",
    straight=False,
    split=rules.SPLIT,
)
ACCELERATION: Final = Acceleration(
    least=LEAST_ACCELERATION,
    cure="AccSet has one value for both",
    cure_of_least="AccSet has one value of 20 percent or more",
)
CORNERS: Final = Corners(size=corner_of, name=zone_name)
LOOPS: Final = Loops(
    refused=rules.COUNTER,
    changed=rules.CHANGED,
    cure="a loop of RAPID has a variable of its own; use another name if that is meant",
)


OUTPUTS: Final = Outputs(
    measures=frozenset(TRIGGER_MEASURES.values()),
    known=True,
    unlike=rules.PLACE_UNLIKE,
    pulse=rules.PULSE_UNLIKE,
)


def capabilities(most_targets: int | None = None) -> Capabilities:
    """most_targets: of one module, None for MOST_TARGETS."""
    return Capabilities(
        kin=frozenset({"rapid"}),
        cannot_say=rules.NO_MEANING,
        changed=rules.CHANGED,
        loops=LOOPS,
        outputs=OUTPUTS,
        comments=Comments(ascii=True),
        acceleration=ACCELERATION,
        longest_message=LONGEST_STRING,
        units=replace(UNITS, most=most_targets) if most_targets else UNITS,
    )
