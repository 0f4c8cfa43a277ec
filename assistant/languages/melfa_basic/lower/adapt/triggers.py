"""Outputs that moves set on their way in the form that `Wth` and `WthIf` are read back as."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from assistant.languages.melfa_basic import rules
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import Blend
from assistant.program.passes.places import ZERO, plain

if TYPE_CHECKING:
    from assistant.languages.melfa_basic.lower.adapt.context import Context


def with_triggers(context: Context, move: p.MoveStatement) -> Iterator[p.Statement]:
    """The move; behind it what it sets at its very end, if it stops there."""
    triggers = move.triggers
    stops = isinstance(move.motion.blend, Blend) and move.motion.blend.fine
    behind = [one for one in triggers if stops and one.ahead is None and _is_at_end(one)]
    kept = tuple(one for one in triggers if one not in behind)
    yield replace(move, triggers=kept)
    for one in behind:
        context.findings.append(rules.BEHIND(name=one.signal))
        yield p.SetSignal(one.signal, one.value, one.pulse, span=move.span)


def plain_trigger(context: Context, x: p.Trigger) -> p.Trigger:
    """With numbers for constants, and no delay of no time."""
    numbers = context.constants
    value = e.Number(int(x.value.value)) if isinstance(x.value, e.Truth) else x.value
    ahead = None if x.ahead is None else plain(x.ahead, numbers)
    return replace(
        x,
        value=plain(value, numbers),
        amount=plain(x.amount, numbers),
        pulse=None if x.pulse is None else plain(x.pulse, numbers),
        ahead=None if ahead == ZERO else ahead,
    )


def _is_at_end(x: p.Trigger) -> bool:
    return x.measure == "end" and x.amount == ZERO
