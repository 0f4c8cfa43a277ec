"""What instructions with a process are given: guns with what they weld, and their signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.tables import processes as table
from assistant.languages.rapid.tables.processes import MOVES
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.gather import literal_number
from assistant.program.program import Signal


@dataclass(frozen=True, slots=True)
class Gun:
    """A spot welding gun and the data of its weld, None where it states none."""

    name: str
    spot: s.Expression | None


def guns(call: Called[s.Expression]) -> tuple[Gun, ...]:
    """The guns of a spot weld in the order of their arguments; none for any other call."""
    known = MOVES.get(call.word.lower())
    if known is None or known.kind != "spot":
        return ()
    if not known.given:
        named = ((name, spot) for name, spot in call.options.items() if name in table.GUNS)
        return tuple(Gun(f"gun{name[1:]}", spot) for name, spot in named)
    if len(call.given) != known.points + known.given + 2:
        return ()
    gun, spot = call.given[known.points + 1 : known.points + 3]
    if isinstance(gun, s.NameRef):
        return (Gun(gun.name, spot),)
    number = None if gun is None else literal_number(gun)
    return (Gun(f"gun{number}", spot),) if isinstance(number, int) else ()


def retracting(call: Called[s.Expression]) -> tuple[str, ...]:
    """The outputs for guns that open wide behind the weld."""
    wide = "retract" in call.options
    return tuple(gun.name + table.RETRACTS for gun in guns(call)) if wide else ()


def process_signals(call: Called[s.Expression]) -> Iterator[tuple[str, Signal]]:
    """The signals that an instruction with a process sets and waits for."""
    word = call.word.lower()
    kind = "paint" if word == table.BRUSHES else MOVES[word].kind if word in MOVES else ""
    for gun in guns(call):
        yield gun.name + table.PROGRAM, table.NUMBER
        yield gun.name + table.STARTS, table.OUTPUT
        yield gun.name + table.READY, table.INPUT
    yield from ((name, table.OUTPUT) for name in retracting(call))
    yield from _PROCESS_SIGNALS.get(kind, ())


_PROCESS_SIGNALS: Final[Mapping[str, tuple[tuple[str, Signal], ...]]] = {
    "arc": ((table.BURNS, table.OUTPUT),),
    "bead": ((table.FLOWS, table.OUTPUT), (table.BEAD, table.NUMBER)),
    "paint": ((table.BRUSH, table.NUMBER),),
}
