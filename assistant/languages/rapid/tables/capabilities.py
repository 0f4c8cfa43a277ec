"""What RAPID can say of what programs ask for."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.languages.rapid import rules
from assistant.languages.rapid.tables.words import MOST_TARGETS
from assistant.program.passes.legalising import Capabilities, Units

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


def capabilities(most_targets: int | None = None) -> Capabilities:
    """most_targets: of one module, None for MOST_TARGETS."""
    return Capabilities(
        kin=frozenset({"rapid"}),
        cannot_say=rules.NO_MEANING,
        units=replace(UNITS, most=most_targets) if most_targets else UNITS,
    )
