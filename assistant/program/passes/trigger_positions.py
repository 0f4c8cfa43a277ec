"""Trigger positions: outputs set during moves where a language measures it, pulses, and analog
signals.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Set
from dataclasses import replace
from typing import Final

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import doubtful_pulses, sets_on_way
from assistant.program.analysis.motion_use import straight_lengths
from assistant.program.analysis.uses import constant_numbers, constant_value
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.passes.legalisation import Legalisation, Outputs
from assistant.program.passes.motions import declared_value
from assistant.program.program import Program
from assistant.program.rewriting import Body, head, map_bodies, records

_DECIMALS: Final = 3
"""Decimals of computed mm."""
_SHORTEST: Final = 0.01
"""Shortest path, mm, on which positions are measured in mm; a move that only turns the tool has
length 0.
"""
ZERO: Final = e.Number(0)


def with_measured_places(job: Legalisation) -> Program:
    """Return the program with positions measured differently where the result is known to be the
    same.

    Both ends of a path can be expressed as mm from it, and so can other positions of a straight
    move of known length. Other positions stay as they are; a finding reports those that may be
    counted differently.
    """
    program, can = job.program, job.can.outputs
    if can is None:
        return program
    _find_pulses(job, can)
    _find_analog_signals(job, can)
    measures = can.measures
    if not sets_on_way(program):
        return program
    known = straight_lengths(program)
    _find_other_positions(job, can)

    def body(numbers: Mapping[str, e.Number], statements: Body) -> Body:
        return tuple(one(numbers, x) for x in statements)

    def one(numbers: Mapping[str, e.Number], node: p.Statement) -> p.Statement:
        if not isinstance(node, p.MoveStatement) or not node.triggers:
            inner: p.Statement = map_bodies(node, lambda held: body(numbers, held))
            return inner
        length = known.get(id(node))
        triggers = tuple(_measured(x, measures, numbers, length) for x in node.triggers)
        return replace(node, triggers=triggers)

    procedures = ((q, constant_numbers(program, q)) for q in program.procedures)
    return replace(
        program, procedures=tuple(replace(q, body=body(known, q.body)) for q, known in procedures)
    )


def with_constant_values(x: p.Trigger, numbers: Mapping[str, e.Number]) -> p.Trigger:
    """Write truths and constants as numbers and drop a delay of 0. numbers: see
    `constant_numbers`.
    """
    value = e.Number(int(x.value.value)) if isinstance(x.value, e.Truth) else x.value
    ahead = None if x.ahead is None else constant_value(x.ahead, numbers)
    return replace(
        x,
        value=constant_value(value, numbers),
        amount=constant_value(x.amount, numbers),
        pulse=None if x.pulse is None else constant_value(x.pulse, numbers),
        ahead=None if ahead == ZERO else ahead,
    )


def with_ends_apart(job: Legalisation, move: p.MoveStatement) -> Iterator[p.Statement]:
    """The move; after it what it sets at its very end, before it what it sets as it begins.

    Before it only where the language sets fewer outputs on one way. Where the robot does not stop
    at the end, that is a place which others may count otherwise, see `with_measured_places`.
    """
    blend, can = move.motion.blend, job.can.outputs
    if can is None or can.behind is None:
        yield move
        return
    stops = isinstance(blend, Blend) and blend.fine
    behind = [one for one in move.triggers if one.ahead is None and _is_at_end(one)]
    # Outputs at the very end are set after the move, those at the start before it if there are too
    # many.
    left = [one for one in move.triggers if one not in behind]
    most = len(left) if can.most is None else can.most
    first = [one for one in left if is_at_start(one)][: max(0, len(left) - most)]
    for one in first:
        if can.before is not None:
            job.findings.append(can.before(name=one.signal))
        yield p.SetSignal(one.signal, one.value, one.pulse, span=move.span)
    yield replace(move, triggers=tuple(one for one in left if one not in first))
    for one in behind:
        if stops:
            job.findings.append(can.behind(name=one.signal))
        yield p.SetSignal(one.signal, one.value, one.pulse, span=move.span)


def is_at_start(one: p.Trigger) -> bool:
    """True if the output is set as the move begins."""
    return one.measure == "start" and one.amount == ZERO and one.ahead is None


def is_steady(value: e.Expression, signals: Container[str] = ()) -> bool:
    """True if a value stays the same until a statement changes it: it consists of variables and
    numbers.

    signals: names in lower case that are not variables.
    """
    match value:
        case e.Number():
            return True
        case e.Name(name):
            return name.lower() not in signals
        case e.Unary("-", operand):
            return is_steady(operand, signals)
        case e.Binary("+" | "-" | "*" | "/", left, right):
            return is_steady(left, signals) and is_steady(right, signals)
    return False


def by_speed(job: Legalisation, x: p.Trigger, speed: Speed | None) -> p.Trigger:
    """Return a trigger at a time as the mm that a robot of that speed moves in it.

    speed: of the move, None if it is unknown, or not of the tool. A trigger stays unchanged if the
    language supports times, or if it would be after the end of the path.
    """
    can, ahead = job.can.outputs, ZERO if x.ahead is None else x.ahead
    if can is None or can.timed is None or speed is None or speed.tcp <= 0:
        return x
    if not isinstance(x.amount, e.Number) or not isinstance(ahead, e.Number):
        return x
    seconds = ahead.value + (x.amount.value if x.measure == "time" else 0.0)
    if x.measure not in ("end", "time") or not seconds:
        return x
    length = seconds * speed.tcp + (x.amount.value if x.measure == "end" else 0.0)
    # A position after the end of the path cannot be expressed in mm before it.
    if length < 0:
        return x
    when = f"{abs(seconds):g} s {'before' if seconds > 0 else 'behind'}"
    job.findings.append(can.timed(name=x.signal, when=when, speed=f"{speed.tcp:g}"))
    return replace(x, measure="end", amount=e.Number(round(length, _DECIMALS)), ahead=None)


def _is_at_end(x: p.Trigger) -> bool:
    return x.measure == "end" and x.amount == ZERO


def _measured(
    x: p.Trigger,
    measures: Set[p.Measure],
    numbers: Mapping[str, e.Number],
    length: float | None,
) -> p.Trigger:
    amount = constant_value(x.amount, numbers)
    if not isinstance(amount, e.Number):
        return x
    # The ends of a path are the same in any measure.
    if x.measure == "share" and amount.value in (0, 100):
        return replace(x, measure="start" if amount.value == 0 else "end", amount=ZERO)
    if x.measure == "time" and amount.value == 0:
        return replace(x, measure="end", amount=ZERO)
    if x.measure in measures or x.measure == "time" or length is None or length < _SHORTEST:
        return x
    if amount == ZERO and x.measure == "start":
        return x
    done = amount.value if x.measure == "start" else length * amount.value / 100.0
    if not 0.0 <= done <= length:
        return x
    return replace(x, measure="end", amount=e.Number(round(length - done, _DECIMALS)))


# -------------------------------------------------------------------- what may be another place


def _is_foreign(job: Legalisation) -> bool:
    origin = job.program.origin
    return origin is not None and origin.language not in job.can.kin


def _find_pulses(job: Legalisation, can: Outputs) -> None:
    """Pulses of another language's that may begin with the output on."""
    for pulse in doubtful_pulses(job.program) if _is_foreign(job) else ():
        if pulse.value != e.Number(1):
            continue  # it is set back to the other value
        with job.findings.at(pulse.span):
            job.findings.append(can.pulse(name=pulse.signal))


def _find_analog_signals(job: Legalisation, can: Outputs) -> None:
    """Uses of another language's analog signals: no program says what their values mean."""
    analog = {n.lower(): n for n, one in job.program.signals.items() if one.kind == "analog"}
    if not analog or not _is_foreign(job):
        return
    for statement in job.program.statements():
        names = {one.signal.lower() for one in p.outputs(statement)}
        names |= {x.name.lower() for x in records(head(statement)) if isinstance(x, e.Name)}
        if isinstance(statement, p.WaitSignal):
            names.add(statement.signal.lower())
        with job.findings.at(statement.span):
            job.findings.extend(can.scaled(name=analog[name]) for name in sorted(names & {*analog}))


def _find_other_positions(job: Legalisation, can: Outputs) -> None:
    """Report positions whose measure languages may count differently."""
    if not (_is_foreign(job) or (job.program.origin is None and not can.known)):
        return
    blends = job.program.blends
    before: Blend | e.Name = FINE
    for move in job.program.statements():
        if isinstance(move, p.Follow) and len(move.path):
            before = declared_value(move.path.blends[move.path.blend[-1]], blends)
        if not isinstance(move, p.MoveStatement):
            continue
        blend = declared_value(move.motion.fixed[1], blends)
        with job.findings.at(move.span):
            for one in move.triggers:
                what = _difference_of_position(move, one, blend, before)
                if what is not None:
                    job.findings.append(can.unlike(name=one.signal, what=what))
        before = blend


def _difference_of_position(
    move: p.MoveStatement, x: p.Trigger, blend: Blend | e.Name, before: Blend | e.Name
) -> str | None:
    """Why a place may not be counted alike, None if it is on a straight line between corners.

    before: how the move before ends, in whose corner this one begins.
    """
    stops = isinstance(blend, Blend) and blend.fine
    number = x.amount.value if isinstance(x.amount, e.Number) else None
    if x.measure == "time" or (x.measure == "start" and number == 0):
        return None
    if stops and ((x.measure == "end" and number == 0) or (x.measure == "share" and number == 100)):
        return None
    if not isinstance(move, p.Move) or move.kind == "joint":
        return "an arc" if isinstance(move, p.MoveCircular) else "a joint move"
    if x.measure == "end" and not (isinstance(before, Blend) and before.fine):
        return "a move that begins in a rounded corner"
    radius = blend.radius if isinstance(blend, Blend) else None
    if stops or (
        radius is not None and x.measure == "end" and number is not None and number > radius
    ):
        return None
    return "a move with a rounded corner"
