"""What is done along the contours of a layer, as a process file says it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from assistant.base.diagnostics import error
from assistant.program import settings_tables
from assistant.program.settings_tables import Read, Table, shown
from assistant.program.statements import Motion
from assistant.sources.process import Defaults, Layer, way_keys
from assistant.sources.process.known import MOTION_KEYS, DefinedNames
from assistant.sources.process.shaping import SHAPING_KEYS, shaping_of

TANGENTIAL_FREE_TURN = error(
    "CT322",
    "the x axis of `{name}` cannot follow the contour: its turn is free",
    "leave out `tangential`, or `free_turn` of the tool",
)

LAYER_KEYS: Final[Mapping[str, Read]] = {
    "process": settings_tables.text,
    **MOTION_KEYS,
    "on": settings_tables.switches,
    "off": settings_tables.switches,
    "delay": settings_tables.number("seconds", least=0.0),
    "approach": settings_tables.number("mm", least=0.0),
    "retract": settings_tables.number("mm", least=0.0),
    "travel": settings_tables.speed,
    "direction": settings_tables.direction,
    "tangential": settings_tables.truth,
    "inside_first": settings_tables.truth,
    **SHAPING_KEYS,
    **way_keys.CONTOUR_MOTION_KEYS,
}


def layer_of(name: str, table: Table, defaults: Defaults, names: DefinedNames) -> Layer:
    found = names.motion(table, LAYER_KEYS)
    parts = {key: found.pop(key) for key in MOTION_KEYS if key in found}
    usual = {key: getattr(defaults.motion, key) for key in MOTION_KEYS}
    switched: dict[str, Any] = {
        key: tuple(names.switched(table.table(key), found.pop(key)))
        for key in ("on", "off")
        if key in found
    }
    tool = parts.get("tool", defaults.tool)
    if found.get("tangential", False) and names.turns_freely(tool):
        table.say(TANGENTIAL_FREE_TURN, "tangential", name=tool)
    shaping = shaping_of(table, found)
    process = found.pop("process", shown(name))
    rounded = defaults.blend is None and "blend" not in parts
    ways = way_keys.contour_motion_of(table, found)
    motion = Motion(**(usual | parts))
    layer = Layer(process, motion, rounded=rounded, shaping=shaping, **switched, **ways, **found)
    way_keys.check_contour_motion(table, layer, planned=defaults.travels)
    return layer
