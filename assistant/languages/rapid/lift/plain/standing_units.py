r"""Work objects that a mechanical unit carries, as those of a unit that stands still.

Other languages have no frame that moves with an external axis. A cell says where the unit `STN1`
stands, as the frame `STN1_stands`: `[FALSE,FALSE,"STN1",user,object]` is then what stands there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from assistant.base.diagnostics import Diagnostic
from assistant.languages.rapid import rules
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.mechanical_units import can_stand, place_of, unit_of
from assistant.languages.rapid.tree.walk import nodes
from assistant.program.rewriting import rewrite

Remarks = tuple[Diagnostic, ...]


def with_fixed_units(
    modules: Sequence[s.Module],
) -> tuple[Sequence[s.Module], list[list[Diagnostic]]]:
    """The modules with such work objects, and the findings of each."""
    nothing: list[list[Diagnostic]] = [[] for _ in modules]
    places: dict[str, s.AggregateNode] = {}
    for item in (item for module in modules for item in module.items):
        if isinstance(item, s.Data) and isinstance(item.value, s.AggregateNode):
            places[item.name.lower()] = item.value
    units = {unit for module in modules for unit in map(unit_of, nodes(module)) if unit}
    known = {unit: places.get(place_of(unit).lower()) for unit in units}
    if None in known.values() or not units or not can_stand(modules):
        return modules, nothing

    def stood(node: Any) -> Any:
        place = known.get(unit_of(node))
        if place is None:
            return node
        _, _, _, _, object = node.items
        fixed = (s.BoolLiteral(False), s.BoolLiteral(True), s.StringLiteral(""))
        return replace(node, items=(*fixed, _user_frame(place), object))

    made = [rewrite(module, stood, ()) for module in modules]
    return made, [_unit_findings(module) for module in modules]


def _user_frame(place: s.AggregateNode) -> s.Expression:
    """The user frame of what the cell states, which has no object frame."""
    return place.items[3]


def _unit_findings(module: s.Module) -> list[Diagnostic]:
    """A finding for each statement and declaration that says such a work object."""
    return [
        rules.STANDS(unit=unit, frame=place_of(unit), span=node.span)
        for node in nodes(module)
        if isinstance(node, s.Data | s.Assignment) and node.span is not None
        for unit in dict.fromkeys(filter(None, map(unit_of, nodes(node.value))))
    ]
