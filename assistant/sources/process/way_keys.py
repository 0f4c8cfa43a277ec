"""Keys of a layer that say how its contours are come to, followed and switched."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from assistant.base.diagnostics import error
from assistant.program import settings_tables
from assistant.program.motion import Speed
from assistant.program.settings_tables import Read, Table, Wrong
from assistant.sources.process import Layer
from assistant.sources.process.ways import ContourTravel, OutputSwitching, SpeedProfile, SwitchPoint

EXCLUSIVE_KEY = error(
    "CT340", "`{key}` and `{other}` cannot both be", "leave one of them out: {why}"
)
NEEDS_OTHER_KEY = error(
    "CT341", "`{key}` says nothing without `{other}`", "add `{other}`, or delete it"
)
SWITCHED_TOO_EARLY = error(
    "CT342",
    "`{key}` is {wanted:g} mm of the way{how}, of which `{of}` leaves {length:g} mm",
    "give less, or a larger `{of}`",
)
JOINT_TRAVEL_AT_WORK = error(
    "CT343",
    'travel_kind = "joint" would lead from the work and to it by joint moves',
    "give `approach` and `retract` over 0, or a `travel_height`",
)
TRAVEL_BLEND_TOO_WIDE = error(
    "CT344",
    "`travel_blend` of {blend:g} mm cuts corners that are {length:g} mm above the work",
    "give less, or a larger `travel_height`, or `approach` and `retract` without one",
)
PLANNED_CONTOUR_TRAVEL = error(
    "CT345",
    'with kind = "travel" under [motion] the ways between contours are planned through the cell',
    "leave out `travel_kind`, or `kind` under [motion]",
)

SPEED_KEYS: Final[Mapping[str, tuple[str, Read]]] = {
    "corner_speed": ("corner", settings_tables.speed),
    "corner_angle": ("angle", settings_tables.number("degrees", above=0.0, most=180.0)),
    "corner_radius": ("radius", settings_tables.number("mm", least=0.0)),
    "corner_length": ("length", settings_tables.number("mm", least=0.0)),
    "start_speed": ("start", settings_tables.speed),
    "start_length": ("start_length", settings_tables.number("mm", above=0.0)),
    "end_speed": ("end", settings_tables.speed),
    "end_length": ("end_length", settings_tables.number("mm", above=0.0)),
}
"""Keys of the process file, each with the field of `Pace` and its reading."""

TRAVEL_KEYS: Final[Mapping[str, tuple[str, Read]]] = {
    "travel_height": ("height", settings_tables.number("mm", above=0.0)),
    "travel_blend": ("blend", settings_tables.blend),
    "travel_kind": ("kind", settings_tables.choice("joint", "linear")),
}

REQUIRED_KEYS: Final[Mapping[str, str]] = {
    "corner_angle": "corner_speed",
    "corner_radius": "corner_speed",
    "corner_length": "corner_speed",
    "start_length": "start_speed",
    "end_length": "end_speed",
    "on_before": "on",
    "on_after": "on",
    "off_before": "off",
    "off_after": "off",
}
"""Keys that mean nothing without another one."""

EXCLUSIVE_KEYS: Final = (
    ("on_before", "on_after", "outputs are set once"),
    ("off_before", "off_after", "outputs are set once"),
    ("on_after", "delay", "the arm cannot wait at the start for what is set behind it"),
    ("retract", "travel_height", "the tool leaves the work up to that height"),
)


def switch_point_reader(*units: str) -> Read:
    """A table of one or both units, `mm` and `seconds`, none below 0 and one over it."""
    wanted = " or ".join(f"{{{unit} = {n}}}" for unit, n in zip(units, ("5", "0.03"), strict=False))

    def read(value: Any) -> SwitchPoint:
        if not isinstance(value, dict):
            raise Wrong(f"is {settings_tables.kind_of(value)}", f"write {wanted}")
        for unit, given in value.items():
            if unit not in units:
                raise Wrong(f"has `{settings_tables.shown(unit)}`", f"write {wanted}")
            try:
                settings_tables.number(unit, least=0.0)(given)
            except Wrong as wrong:
                raise Wrong(f"has `{unit}`, which {wrong.what}", wrong.cure) from None
        if not any(value.values()):
            raise Wrong("says no place", f"write {wanted}")
        return SwitchPoint(**{unit: float(given) for unit, given in value.items()})

    return read


SWITCHING_KEYS: Final[Mapping[str, Read]] = {
    "on_before": switch_point_reader("mm", "seconds"),
    "on_after": switch_point_reader("mm"),
    "off_before": switch_point_reader("mm", "seconds"),
    "off_after": switch_point_reader("mm", "seconds"),
}

CONTOUR_MOTION_KEYS: Final[Mapping[str, Read]] = {
    "order": settings_tables.choice("travel", "drawing", "text"),
    **{key: read for key, (_, read) in SPEED_KEYS.items()},
    **{key: read for key, (_, read) in TRAVEL_KEYS.items()},
    **SWITCHING_KEYS,
}


def contour_motion_of(table: Table, found: dict[str, Any]) -> dict[str, Any]:
    """`pace`, `above` and `switching` of a layer from its keys, which are taken out of `found`."""
    for key, other in REQUIRED_KEYS.items():
        if key in found and other not in table.content:
            table.say(NEEDS_OTHER_KEY, key, key=key, other=other)
    for key, other, why in EXCLUSIVE_KEYS:
        if key in found and other in found:
            table.say(EXCLUSIVE_KEY, key, key=key, other=other, why=why)
    if found.get("off_after", SwitchPoint()).mm and found["off_after"].seconds:
        table.say(EXCLUSIVE_KEY, "off_after", key="mm", other="seconds", why="one says where it is")
    pace = {field: found.pop(key) for key, (field, _) in SPEED_KEYS.items() if key in found}
    above = {field: found.pop(key) for key, (field, _) in TRAVEL_KEYS.items() if key in found}
    switching = {key: found.pop(key) for key in SWITCHING_KEYS if key in found}
    made = {
        "pace": SpeedProfile(**pace),
        "above": ContourTravel(**above),
        "switching": OutputSwitching(**switching),
    }
    return {key: value for key, value in made.items() if value != type(value)()}


def check_contour_motion(table: Table, layer: Layer, *, planned: bool) -> None:
    """What does not fit the ways to the contours and from them.

    planned: whether travel is, through the cell.
    """
    above, switching, speed = layer.above, layer.switching, layer.motion.speed
    approach, retract, travel = layer.approach, layer.retract, layer.travel.tcp
    if above.kind is not None and planned:
        table.say(PLANNED_CONTOUR_TRAVEL, "travel_kind")
    if above.kind == "joint" and above.height is None and not (approach > 0.0 and retract > 0.0):
        table.say(JOINT_TRAVEL_AT_WORK, "travel_kind")
    blend = above.blend.radius or 0.0
    lowest = min(approach, retract) if above.height is None else above.height
    if above.height is not None:
        approach, retract = min(approach, above.height), above.height
    if blend > lowest:
        table.say(TRAVEL_BLEND_TOO_WIDE, "travel_blend", blend=blend, length=lowest)
    slow = min(speed.tcp, travel) if isinstance(speed, Speed) else travel
    if (before := switching.on_before) is not None:
        wanted, how = before.mm + before.seconds * slow, f" at {slow:g} mm/s"
        if wanted > max(approach - blend, 0.0):
            said = {"how": how if before.seconds else "", "of": "approach"}
            left = max(approach - blend, 0.0)
            table.say(
                SWITCHED_TOO_EARLY, "on_before", key="on_before", wanted=wanted, length=left, **said
            )
    left = max(retract - blend, 0.0)
    if (after := switching.off_after) is not None and after.mm > left:
        said = {"how": "", "of": "retract" if above.height is None else "travel_height"}
        table.say(
            SWITCHED_TOO_EARLY, "off_after", key="off_after", wanted=after.mm, length=left, **said
        )
