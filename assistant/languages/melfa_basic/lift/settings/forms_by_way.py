"""Where procedures are divided, so that each way to a label has settings of its own.

Settings may reach a label with other values from above than by a jump. What stands below such a
label is read once for each way, as procedures are for each way of calling them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from assistant.languages.melfa_basic.lift.settings.flow import Flow
from assistant.languages.melfa_basic.lift.settings.held import State
from assistant.languages.melfa_basic.lift.structure.blocks import depths
from assistant.languages.melfa_basic.lift.structure.regions import Region
from assistant.languages.melfa_basic.tree import syntax as s

_WAITS: Final = re.compile(r"W\d+Z?", re.IGNORECASE)
"""Labels that are read together with the lines around them."""


def divided(
    flow: Flow, blocks: Mapping[int, list[int]], whole: frozenset[int] = frozenset()
) -> Flow:
    """The flow with procedures divided at labels; the same one if there is nothing to divide.

    whole: numbers of procedures that stay as they are.
    """
    depth = depths(flow.code, blocks)
    cuts: set[int] = set()
    refused = set(whole)
    made = flow
    while True:
        more: set[int] = set()
        for number, region in enumerate(flow.regions):
            if number in refused:
                continue
            found = _cuts(made, region, depth)
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


def _cuts(flow: Flow, region: Region, depth: list[int]) -> set[int] | None:
    """More labels to divide a procedure at; None if it cannot be divided."""
    ways = _ways(flow, region)
    found = {
        at
        for at, states in ways.items()
        if at not in flow.cuts and flow.is_label(at) and not depth[at] and _differ(states)
    }
    if flow.cuts & set(region.places()):
        found |= _entered(flow, region) - flow.cuts
    if not found:
        return found
    if region.function is not None or any(region.holds(at) for at in flow.odd):
        return None
    if any(depth[at] or _is_wait(flow, at) for at in found):
        return None
    return found


def _ways(flow: Flow, region: Region) -> dict[int, list[State]]:
    """By label, what holds at the end of each line that leads there."""
    found: dict[int, list[State]] = {}
    for at in region.places():
        state = flow.before.get(at)
        after = None if state is None else flow.after(at, state)
        if after is None:
            continue
        for following in flow.following(at, region):
            if following != region.high and flow.is_label(following):
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


def _entered(flow: Flow, region: Region) -> set[int]:
    """Labels that other parts of a divided procedure jump to."""
    starts = sorted({region.low} | {at for at in flow.cuts if region.holds(at)})
    part, number = {}, -1
    for at in region.places():
        number += at in starts
        part[at] = number
    return {
        to
        for at in region.places()
        for to in flow.following(at, region)
        if to in part and part[to] != part[at] and to not in starts
    }


def _is_wait(flow: Flow, at: int) -> bool:
    item = flow.code[at]
    return not isinstance(item, s.Line) or bool(_WAITS.fullmatch(item.label or ""))
