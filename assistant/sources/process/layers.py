"""What is done along the contours of a layer, as a process file says it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from assistant.base.diagnostics import error
from assistant.program import settings_tables
from assistant.program.settings_tables import Read, Table, shown
from assistant.program.statements import Motion
from assistant.sources.process import Defaults, Layer, way_keys
from assistant.sources.process.known import MOTION, Known
from assistant.sources.process.shaping import SHAPING, shaping_of

TURNS_FREELY = error(
    "CT322",
    "the x axis of `{name}` cannot follow the contour: its turn is free",
    "leave out `tangential`, or `free_turn` of the tool",
)

LAYER: Final[Mapping[str, Read]] = {
    "process": settings_tables.text,
    **MOTION,
    "on": settings_tables.switches,
    "off": settings_tables.switches,
    "delay": settings_tables.number("seconds", least=0.0),
    "approach": settings_tables.number("mm", least=0.0),
    "retract": settings_tables.number("mm", least=0.0),
    "travel": settings_tables.speed,
    "direction": settings_tables.direction,
    "tangential": settings_tables.truth,
    "inside_first": settings_tables.truth,
    **SHAPING,
    **way_keys.KEYS,
}


def layer_of(name: str, table: Table, defaults: Defaults, names: Known) -> Layer:
    found = names.motion(table, LAYER)
    parts = {key: found.pop(key) for key in MOTION if key in found}
    usual = {key: getattr(defaults.motion, key) for key in MOTION}
    switched: dict[str, Any] = {
        key: tuple(names.switched(table.table(key), found.pop(key)))
        for key in ("on", "off")
        if key in found
    }
    tool = parts.get("tool", defaults.tool)
    if found.get("tangential", False) and names.turns_freely(tool):
        table.say(TURNS_FREELY, "tangential", name=tool)
    shaping = shaping_of(table, found)
    process = found.pop("process", shown(name))
    rounded = defaults.blend is None and "blend" not in parts
    ways = way_keys.ways_of(table, found)
    motion = Motion(**(usual | parts))
    layer = Layer(process, motion, rounded=rounded, shaping=shaping, **switched, **ways, **found)
    way_keys.check_ways(table, layer, planned=defaults.travels)
    return layer
