"""Arc welding: moves at the speed of the weld, and an output that is on while the arc burns.

ArcLStart moves to the start of the seam and lights the arc there, ArcL and ArcC weld on, ArcLEnd
welds up to the end and puts it out (application manual Arc, 3HAC050988).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift.instructions import Meaning, of_call
from assistant.languages.rapid.tables.welding import BESIDE, BURNS, MOVES, SIGNAL
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import numbers
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Speed
from assistant.program.passes.stops import stopped
from assistant.program.program import Program

_USUAL: Final = tuple(map(s.NumberLiteral, ("500", "5000", "1000")))
"""The other parts of a speed: deg/s, and of external axes, as every predefined one has them."""


def weld_speeds(program: Program) -> Mapping[str, float]:
    """mm/s of declared welds by lower-case name: the first part of each."""
    found: dict[str, float] = {}
    for declaration in program.declarations:
        match verbatim.understood(verbatim.items, declaration.text):
            case (s.Data(type=type, name=str(name), value=value, dimensions=()),) if (
                type.lower() == "welddata"
            ):
                match numbers(value):
                    case [int() | float() as speed, *_] if speed > 0:
                        found[name.lower()] = float(speed)
    return found


def welded(
    call: Called[s.Expression], meaning: Meaning, speeds: Mapping[str, float]
) -> Iterator[p.Statement]:
    """A move of a weld, and what it does to the arc."""
    known = MOVES[call.word.lower()]
    options = {name: x for name, x in call.options.items() if name not in BESIDE}
    if len(call.given) != known.points + 5 or not options.keys() <= {"wobj", "tload"}:
        return
    points, (speed, _, weld, zone, tool) = call.given[: known.points], call.given[known.points :]
    if known.part != "start" and isinstance(weld, s.AggregateNode) and weld.items:
        speed = s.AggregateNode((weld.items[0], *_USUAL))
    move = of_call(Called(known.plain, [*points, speed, zone, tool], options), meaning)
    if not isinstance(move, p.MoveStatement) or not isinstance(weld, s.NameRef | s.AggregateNode):
        return
    meaning.used.append((BURNS, SIGNAL))
    if known.part != "start" and isinstance(weld, s.NameRef):
        stated = speeds.get(weld.name.lower())
        fast = e.Name(meaning.original(weld.name)) if stated is None else Speed(stated)
        move = replace(move, motion=replace(move.motion, speed=fast))
    if known.part == "middle":
        yield move
    else:
        yield stopped(move)
        yield p.SetSignal(BURNS, e.Number(int(known.part == "start")))
