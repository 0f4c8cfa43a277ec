"""Moves with a process, as plain moves and signals to the equipment.

ArcLStart moves to the start of the seam and lights the arc there, ArcL and ArcC weld on, ArcLEnd
welds up to the end and extinguishes the arc (application manual Arc, 3HAC050988). SpotL and SpotJ
move, stop and start the weld timer of the gun, which reports that it is ready and the gun open.
DispL and DispC begin to dispense at their target with the option `On` and end there with `Off`.
Speeds of welds are mm/s. Spots, beads and brushes were written from memory of their manuals.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

from assistant.languages.patterns import Called
from assistant.languages.rapid.lift import vendor_effects
from assistant.languages.rapid.lift.statements import NameResolver, lift_call
from assistant.languages.rapid.lift.vendor_statements import instruction_of, word_of
from assistant.languages.rapid.tables import signals as table
from assistant.languages.rapid.tables.signals import PROCESS_MOVES, ProcessMove
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import literal_number
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Speed
from assistant.program.passes.implicit_motion_state import stopped
from assistant.program.program import Declaration, Program
from assistant.program.vendor_statements import effect_of

_DEFAULT_RATES: Final = tuple(map(s.NumberLiteral, ("500", "5000", "1000")))
"""The other parts of a speed: deg/s, and of external axes, as every predefined one has them."""
_PLAIN_OPTIONS: Final = frozenset(("wobj", "tload"))
"""Options that any move takes."""


def weld_speeds(program: Program) -> Mapping[str, float]:
    """mm/s of declared welds by lower-case name: the first part of each."""
    first = ((name, _first_number(one)) for name, one in _declared_data(program, table.WELD_DATA))
    return {name: speed for name, speed in first if speed is not None and speed > 0}


def spot_programs(program: Program) -> Mapping[str, float]:
    """Numbers of the programs of declared spots by lower-case name: the first part of each.

    Without those that anything but a weld speaks of, which may change them.
    """
    found = {name: _first_number(one) for name, one in _declared_data(program, table.SPOT_DATA)}
    if not found:
        return {}
    kept = [one for one in program.statements() if isinstance(one, p.Opaque)]
    others: list[p.Opaque | Declaration] = [one for one in kept if not _is_process_call(one)]
    others += program.declarations
    named: Counter[str] = Counter()
    for one in others:
        named.update(effect_of(one).names | effect_of(one).writes)
    # The declaration itself is one mention.
    steady = ((name, number) for name, number in found.items() if named[name] <= 1)
    return {name: number for name, number in steady if number is not None}


def bead_numbers(program: Program) -> Mapping[str, int]:
    """Numbers of the declared beads by lower-case name, in their order."""
    names = dict.fromkeys(name for name, _ in _declared_data(program, table.BEAD_DATA))
    return {name: number for number, name in enumerate(names, 1)}


def _declared_data(program: Program, type: str) -> Iterator[tuple[str, s.Data]]:
    """Declared data of a type, by lower-case name."""
    for declaration in program.declarations:
        # Looking for the word first spares the parse of most texts.
        if type in declaration.text.lower():
            match verbatim.understood(verbatim.items, declaration.text):
                case (s.Data(name=str(name), dimensions=()) as data,) if data.type.lower() == type:
                    yield name.lower(), data


def _first_number(data: s.Data) -> float | None:
    match data.value:
        case s.AggregateNode(items=(first, *_)):
            number = literal_number(first)
            return None if number is None else float(number)
    return None


def _is_process_call(node: p.Opaque) -> bool:
    call = instruction_of(node)
    return call is not None and word_of(call) in PROCESS_MOVES


def _plain_move(
    known: ProcessMove, call: Called[s.Expression], meaning: NameResolver, more: frozenset[str]
) -> p.MoveStatement | None:
    """Return the move of an instruction, None if it states anything that a plain move does not
    have.

    more: options for its process.
    """
    between = known.points + 1
    # Spot welds state no zone: they always stop.
    zone = known.kind != "spot"
    if len(call.given) != between + known.given + zone + 1:
        return None
    options = {name: x for name, x in call.options.items() if name not in known.beside | more}
    if not options.keys() <= _PLAIN_OPTIONS:
        return None
    places, behind = call.given[:between], call.given[between + known.given :]
    given = [*places, *behind] if zone else [*places, s.NameRef("fine"), *behind]
    move = lift_call(Called(known.plain, given, options), meaning)
    return move if isinstance(move, p.MoveStatement) else None


def weld_move(
    call: Called[s.Expression], meaning: NameResolver, speeds: Mapping[str, float]
) -> Iterator[p.Statement]:
    """A move of a weld, and what it does to the arc."""
    known = PROCESS_MOVES[call.word.lower()]
    speed = known.points
    if len(call.given) != speed + 5:
        return
    weld = call.given[speed + 2]
    # ArcLStart moves at the speed of the move, the others at that of the weld.
    if known.part != "start" and isinstance(weld, s.AggregateNode) and weld.items:
        given = [*call.given]
        given[speed] = s.AggregateNode((weld.items[0], *_DEFAULT_RATES))
        call = replace(call, given=given)
    move = _plain_move(known, call, meaning, frozenset())
    if move is None or not isinstance(weld, s.NameRef | s.AggregateNode):
        return
    meaning.used.append((table.ARC_OUTPUT, table.DIGITAL_OUTPUT))
    if known.part != "start" and isinstance(weld, s.NameRef):
        stated = speeds.get(weld.name.lower())
        fast = e.Name(meaning.original(weld.name)) if stated is None else Speed(stated)
        move = replace(move, motion=replace(move.motion, speed=fast))
    if known.part == "middle":
        yield move
    else:
        # The arc is lit and put out where the arm stands.
        yield stopped(move)
        yield p.SetSignal(table.ARC_OUTPUT, e.Number(int(known.part == "start")))


def spot_move(
    call: Called[s.Expression], meaning: NameResolver, programs: Mapping[str, float]
) -> Iterator[p.Statement]:
    """A move to a spot, the number of the weld, and the signals to the gun and from it."""
    known, guns = PROCESS_MOVES[call.word.lower()], vendor_effects.guns(call)
    move = _plain_move(known, call, meaning, frozenset((*table.GUN_OPTIONS, "retract")))
    if move is None or not guns:
        return
    stated = [_spot_program(gun.spot, meaning, programs) for gun in guns]
    numbers = [one for one in stated if one is not None]
    if len(numbers) != len(guns):
        return
    meaning.used += vendor_effects.process_signals(call)
    yield stopped(move)
    for gun, number in zip(guns, numbers, strict=True):
        # The number has to be there when the gun starts.
        yield p.SetSignal(gun.name + table.PROGRAM_SUFFIX, number)
    wide = vendor_effects.retracting(call)
    starts = tuple(gun.name + table.START_SUFFIX for gun in guns)
    yield from (p.SetSignal(name, e.Number(1)) for name in (*wide, *starts))
    yield from (p.WaitSignal(gun.name + table.READY_SUFFIX, e.Number(1)) for gun in guns)
    yield from (p.SetSignal(name, e.Number(0)) for name in (*starts, *wide))


def _spot_program(
    spot: s.Expression | None, meaning: NameResolver, programs: Mapping[str, float]
) -> e.Expression | None:
    """The number that data of a spot begin with, None where nobody knows it."""
    match spot:
        case s.AggregateNode(items=(first, *_)):
            return meaning.expression(first)
        case s.NameRef(name) if name.lower() in programs:
            return e.Number(programs[name.lower()])
    return None


def bead_move(
    call: Called[s.Expression], meaning: NameResolver, numbers: Mapping[str, int]
) -> Iterator[p.Statement]:
    """A move of a bead, and what begins or ends at its target."""
    known = PROCESS_MOVES[call.word.lower()]
    move = _plain_move(known, call, meaning, frozenset(("on", "off")))
    if move is None or call.options.keys() >= {"on", "off"}:
        return
    bead = call.given[known.points + 1]
    number = numbers.get(bead.name.lower()) if isinstance(bead, s.NameRef) else None
    if number is None:
        return
    meaning.used += [
        (table.DISPENSE_OUTPUT, table.DIGITAL_OUTPUT),
        (table.BEAD_OUTPUT, table.GROUP_OUTPUT),
    ]
    yield move
    if "off" in call.options:
        yield p.SetSignal(table.DISPENSE_OUTPUT, e.Number(0))
    else:
        # The number has to be there when the gun opens.
        yield p.SetSignal(table.BEAD_OUTPUT, e.Number(number))
    if "on" in call.options:
        yield p.SetSignal(table.DISPENSE_OUTPUT, e.Number(1))


def paint_move(call: Called[s.Expression], meaning: NameResolver) -> Iterator[p.Statement]:
    """A move with a brush: which one, is set before."""
    move = _plain_move(PROCESS_MOVES[call.word.lower()], call, meaning, frozenset())
    if move is not None:
        yield move


def brush_change(call: Called[s.Expression], meaning: NameResolver) -> Iterator[p.Statement]:
    """`SetBrush` without a place: the number of the brush, at once."""
    if len(call.given) == 1 and call.given[0] is not None and not call.options:
        meaning.used.append((table.BRUSH_OUTPUT, table.GROUP_OUTPUT))
        yield p.SetSignal(table.BRUSH_OUTPUT, meaning.expression(call.given[0]))
