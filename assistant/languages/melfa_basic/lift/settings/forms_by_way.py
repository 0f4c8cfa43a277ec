"""Where procedures are divided, so that each way to a label has settings of its own.

Settings may reach a label with other values from above than by a jump. What stands below such a
label is read once for each way, as procedures are for each way of calling them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant.languages.melfa_basic.lift.settings.flow import Flow
from assistant.languages.melfa_basic.lift.settings.held import State
from assistant.languages.melfa_basic.tree import syntax as s

_WAITS: Final = re.compile(r"W\d+Z?", re.IGNORECASE)
"""Labels that are read together with the lines around them."""


def divided(flow: Flow, depth: Sequence[int], whole: frozenset[int] = frozenset()) -> Flow:
    """The flow with procedures divided at labels; the same one if there is nothing to divide.

    depth: of each line in blocks. whole: numbers of procedures that stay as they are.
    """
    cuts: set[int] = set()
    refused = set(whole)
    made = flow
    while True:
        more: set[int] = set()
        for number, region in enumerate(flow.regions):
            if number in refused:
                continue
            found = _cuts(made, number, depth)
            if found is None:
                refused.add(number)
                cuts = {at for at in cuts if not region.holds(at)}
                more = {-1}  # the rest is looked at anew without them
                break
            more |= found
        if not more:
            return made
        cuts |= more - {-1}
        made = flow.cut(frozenset(cuts)) if cuts else flow


def _cuts(flow: Flow, number: int, depth: Sequence[int]) -> set[int] | None:
    """More labels to divide a procedure at; None if it cannot be divided."""
    region = flow.regions[number]
    ways = _ways(flow, number)
    found = {
        at
        for at, states in ways.items()
        if at not in flow.cuts and flow.is_label(at) and not depth[at] and _differ(states)
    }
    if flow.cuts & set(region.places()):
        found |= _entered(flow, number) - flow.cuts
    if not found:
        return found
    if region.function is not None or any(region.holds(at) for at in flow.odd):
        return None
    if any(depth[at] or _is_wait(flow, at) for at in found):
        return None
    return found


def _ways(flow: Flow, number: int) -> dict[int, list[State]]:
    """By label, what holds at the end of each line that leads there."""
    region = flow.regions[number]
    found: dict[int, list[State]] = {}
    for at in region.places():
        after = flow.after(at, flow.before[at])
        if after is None:
            continue
        for following in flow.ways[number][at]:
            if flow.is_label(following):
                found.setdefault(following, []).append(after)
    if region.low in found:
        found[region.low].append(flow.entry)
    return found


def _differ(states: list[State]) -> bool:
    return any(
        any(held.value is not slot[0].value for held in slot)
        and len({repr(held.value) for held in slot}) > 1
        for slot in zip(*states, strict=True)
    )


def _entered(flow: Flow, number: int) -> set[int]:
    """Labels that other parts of a divided procedure jump to."""
    region = flow.regions[number]
    starts = sorted({region.low} | {at for at in flow.cuts if region.holds(at)})
    part, count = {}, -1
    for at in region.places():
        count += at in starts
        part[at] = count
    return {
        to
        for at in region.places()
        for to in flow.ways[number][at]
        if to in part and part[to] != part[at] and to not in starts
    }


def _is_wait(flow: Flow, at: int) -> bool:
    item = flow.code[at]
    return not isinstance(item, s.Line) or bool(_WAITS.fullmatch(item.label or ""))
