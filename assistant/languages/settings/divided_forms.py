"""Where procedures are divided, so that each way to a label has settings of its own.

Settings may reach a label with other values from above than by a jump. What stands below such a
label is read once for each way, as procedures are for each way of calling them.
"""

from __future__ import annotations

from assistant.languages.settings.flow import Flow, State


def divided_flow(flow: Flow, whole: frozenset[int]) -> Flow:
    """The flow with procedures divided at labels; the same one if there is nothing to divide.

    whole: numbers of procedures that stay as they are.
    """
    refused = set(whole)
    made = flow
    while True:
        cuts = set(made.cuts)
        for number, places in enumerate(flow.lines.procedures):
            more = set() if number in refused else _division_labels(made, number)
            if more and not flow.lines.lost.union(more & flow.lines.inner).isdisjoint(places):
                refused.add(number)  # what is read whole would have to be divided
                cuts.difference_update(places)
            else:
                cuts |= more
        if cuts == made.cuts:
            return made
        made = flow.cut(frozenset(cuts)) if cuts else flow


def _division_labels(flow: Flow, number: int) -> set[int]:
    """More labels to divide a procedure at: where ways differ, and where parts lead into others."""
    lines = flow.lines
    places, after = lines.procedures[number], lines.after[number]
    ways: dict[int, list[State]] = {at: [flow.entry] for at in places[:1]}
    for at in places:
        behind = flow.after(at, flow.before[at])
        if behind is None:
            continue
        for following in lines.labels.intersection(after[at]):
            ways.setdefault(following, []).append(behind)
    found = {at for at, states in ways.items() if at not in lines.inner and _differ(states)}
    if number in flow.divided:
        parts = flow.parts[number]
        part = {at: k for k, inside in enumerate(parts) for at in inside}
        led = {to for at in places for to in after[at] if part.get(to, part[at]) != part[at]}
        found |= led.difference(inside[0] for inside in parts)
    return found - flow.cuts


def _differ(states: list[State]) -> bool:
    return any(len({held.value for held in slot}) > 1 for slot in zip(*states, strict=True))
