"""Where on a contour outputs are set that are not set at its ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Rule, error
from assistant.program.expressions import Number
from assistant.program.statements import SetSignal, Statement, Trigger, Wait
from assistant.sources.process import Layer
from assistant.sources.process.ways import SwitchPoint

CONTOUR_TOO_SHORT = error(
    "CT220",
    "a contour of layer {layer!r} is {length:.2f} mm long, too short for {what}",
    "give less of it, or put the contour on a layer of its own",
)
SWITCHED_OFF_TOO_LATE = error(
    "CT221",
    "the seconds of `off_before` are {wanted:.2f} mm of a contour of layer {layer!r}, of whose last"
    " move {length:.2f} mm lie before that place",
    "give `mm` alone, or fewer seconds",
)

SAME_POSITION: Final = 1e-6
"""mm that make no other place."""
TRIGGER_DECIMALS: Final = 3
"""Of mm on the way of a move."""


class NoRoomForOutputs(ValueError):
    """What a contour has no room for: the rule, and fields of its finding but the layer."""

    def __init__(self, rule: Rule, **fields: Any) -> None:
        super().__init__()
        self.rule: Final = rule
        self.fields: Final = fields


@dataclass(slots=True)
class ContourOutputs:
    """Of one contour.

    first, last: what the moves to the start and up from the end set on their way. on_way: by the
    row of the path that ends the move. before, after: statements at the start and at the end.
    """

    first: tuple[Trigger, ...] = ()
    last: tuple[Trigger, ...] = ()
    on_way: dict[int, tuple[Trigger, ...]] = field(default_factory=dict)
    before: list[Statement] = field(default_factory=list)
    after: list[Statement] = field(default_factory=list)


def number_literal(value: float) -> Number:
    """A whole number where it is one."""
    return Number(int(value) if value == int(value) else value)


def divided_at(layer: Layer, total: float) -> tuple[float, ...]:
    """Mm from the start at which a move is divided, as one move sets at one place only.

    total: of the contour.
    """
    on, off = layer.switching.on_after, layer.switching.off_before
    if on is None or off is None:
        return ()
    return ((on.mm + total - off.mm) / 2.0,)


def contour_outputs(layer: Layer, lengths: Floats, up: float, speeds: Floats) -> ContourOutputs:
    """What is set where along a contour.

    lengths, speeds: mm and mm/s of the rows of its path, (n,). up: mm of the way up from its end.
    Raises Unfit for what has no room on it.
    """
    made, said = ContourOutputs(), layer.switching
    total = float(lengths.sum())
    on = said.on_after.mm if said.on_after is not None else 0.0
    off = said.off_before.mm if said.off_before is not None else 0.0
    if on + off >= total and (on or off):
        parts = (("on_after", on), ("off_before", off))
        raise NoRoomForOutputs(
            CONTOUR_TOO_SHORT,
            length=total,
            what=" and ".join(f"{k} of {v:g} mm" for k, v in parts if v),
        )
    if said.on_before is not None:
        made.first = tuple(_triggers_at(layer.on, said.on_before))
    elif said.on_after is not None:
        _note_triggers(made, lengths, on, _triggers_at(layer.on, said.on_after))
    else:
        made.before += _signal_statements(layer.on)
    if layer.delay > 0.0:
        made.before.append(Wait(number_literal(layer.delay)))
    if said.off_before is not None:
        row = _note_triggers(made, lengths, total - off, _triggers_at(layer.off, said.off_before))
        ahead = said.off_before.seconds * float(speeds[row])
        room = total - off - float(lengths[:row].sum())
        if ahead > room:
            raise NoRoomForOutputs(SWITCHED_OFF_TOO_LATE, wanted=ahead, length=room)
    elif said.off_after is not None and said.off_after.mm:
        up_to = SwitchPoint(up - said.off_after.mm)
        made.last = tuple(_triggers_at(layer.off, up_to))
    else:
        if said.off_after is not None:
            made.after.append(Wait(number_literal(said.off_after.seconds)))
        made.after += _signal_statements(layer.off)
    return made


def _note_triggers(
    made: ContourOutputs, lengths: Floats, place: float, triggers: Iterable[Trigger]
) -> int:
    """Notes what is set at mm from the start at the row whose move leads there, and gives it.

    A place between two moves is the beginning of the second one, which a corner does not move.
    """
    ends = np.cumsum(lengths)
    row = min(int(np.searchsorted(ends, place + SAME_POSITION, "right")), len(ends) - 1)
    left = number_literal(round(float(ends[row]) - place, TRIGGER_DECIMALS))
    found = tuple(
        Trigger(one.signal, one.value, left, one.measure, ahead=one.ahead) for one in triggers
    )
    made.on_way[row] = (*made.on_way.get(row, ()), *found)
    return row


def _triggers_at(values: Iterable[tuple[str, float]], at: SwitchPoint) -> Iterator[Trigger]:
    ahead = number_literal(at.seconds) if at.seconds else None
    for signal, value in values:
        yield Trigger(
            signal,
            number_literal(value),
            number_literal(round(at.mm, TRIGGER_DECIMALS)),
            "end",
            ahead=ahead,
        )


def _signal_statements(values: Iterable[tuple[str, float]]) -> Iterator[SetSignal]:
    return (SetSignal(signal, number_literal(value)) for signal, value in values)
