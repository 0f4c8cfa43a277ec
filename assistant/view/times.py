"""How long a program takes and how far it goes, procedure by procedure, for the page."""

from __future__ import annotations

from collections.abc import Sequence

from assistant.base.source_text import visible
from assistant.report.timing import Statement, seconds_of
from assistant.robots.timing import Simulation
from assistant.view.motion import Record


def procedure_times(simulation: Simulation, every: Sequence[Statement]) -> Record:
    """seconds: of the program, in words. procedures: of each how long a call of it takes, with what
    it calls; its own motion statements, and how many mm and seconds these lead, each gone through
    once. unknown: what the times do not hold. every: the motion statements.
    """
    own: dict[str, list[Statement]] = {}
    for one in every:
        own.setdefault(one.procedure, []).append(one)
    return {
        "seconds": seconds_of(simulation.duration),
        "procedures": [
            {
                "name": visible(name),
                "seconds": seconds_of(duration),
                "moves": len(own.get(name, ())),
                "length": sum(one.length for one in own.get(name, ())),
                "moving": sum(one.seconds for one in own.get(name, ())),
            }
            for name, duration in simulation.procedures.items()
        ],
        "unknown": [visible(str(one)) for one in simulation.unknown],
    }
