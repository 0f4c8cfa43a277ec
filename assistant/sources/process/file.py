"""Process files: the values that a drawing or table leaves open, as TOML.

Every part may be left out. Lengths are mm, speeds mm/s, times seconds, angles degrees, masses kg;
names are letters, digits and `_`, a letter first.

    robot = "irb1200-7-0.7"       # the arm that the targets were taught on, or that runs them
    tolerance = 0.05              # mm for joining ends, fitting curves, rounding corners of paths
    unit = "mm"                   # of a drawing, overriding the drawing's own unit
    assumed = ["tip of tool"]     # what nobody measured, for people
    leave_out = ["BORDER"]        # layers that are not wanted; "*" for any letters: ["DIM_*"];
    # also {layer = "CUT", at = [12, 30]}, the contour there; {line_type = "CENTER"} or
    # {block = "A3"}, with a layer or without; {number = 3} in the picture of --plot; {group = 2}
    follow = ["HIDDEN"]           # layers, blocks, line types that are work despite their names
    home = [0, 0, 0, 0, 30, 0]    # of the axes: there a drawing's program begins and ends
    joint_speed = 100             # mm/s of joint moves of a robot program that state a percentage
    joint_percent = 20            # of joint moves, where a controller takes no mm/s

    [program]                     # its interface to other programs of its controller
    as = "Glue_Left"              # the name by which others call it
    main = true                   # false: no main procedure; others call its procedures
    prefix = "left_"              # before every name that it declares, except that one
    local = false                 # true: names that no other program uses are local to its module

    [motion]                      # for a source that does not state its motion
    kind = "linear"               # or "joint"; of a drawing "travel": motions planned in the cell
    speed = 100                   # mm/s
    blend = "fine"                # or mm; left out: paths round corners within the tolerance
    tool = "nozzle"               # a tool of this file, or tool0, the bare flange
    frame = "table"               # a frame of this file, or base, the robot's base frame
    approach = 0                  # mm in a line to locations and to paths, along the tool axis
    retract = 0                   # and away from them
    travel = 200                  # mm/s to the first point of a path, and between contours

    [tools.nozzle]
    tip = [0, 0, 120.5]           # tool centre point in the flange frame
    quaternion = [1, 0, 0, 0]     # w, x, y, z; or else
    # euler_zyx = [0, 90, 0]      # about z, then the new y, then the new x
    mass = 1.2
    centre = [0, 0, 60]           # of gravity; needs a mass
    held = true                   # false: a stationary tool
    on_controller = false         # true: the controller has it already; it is named, not written
    # number = 2                  # its number there, for controllers that count tools
    free_turn = false             # true: its turn about its axis is free, as of a round nozzle

    [frames.table]
    position = [400, 0, 20]       # in the robot's base frame
    euler_zyx = [90, 0, 0]        # or quaternion, as for tools
    held = false                  # true: the robot carries the work piece
    seen = "bracket"              # it is where this object is seen; position: its usual position
    on_controller = false         # and number, as for tools

    [seen]                        # of such frames: see `process.SeenSettings`
    ask = "192.168.0.5:10010"     # server that the program asks as it runs

    [signals.glue]
    kind = "digital"              # or "analog", "group"
    direction = "output"          # or "input"
    number = 8                    # first bit, for controllers that count signals
    bits = 1                      # width of a group

    [lines.line_3]                # line 3 of the controller that a program was written for
    role = "server"               # or "client", "serial"
    port = 10003                  # of TCP; of a serial line the number of the other one's port
    address = "192.168.125.1"     # as server its address, as client the other computer's

    [layers.GLUE]                 # by layer name, compared without case
    process = "gluing"            # for people; the layer's name if left out
    speed = 50                    # along the contours; these four from [motion] if left out
    blend = 1
    tool = "nozzle"
    frame = "table"
    on = {glue = 1}               # outputs set at the start of each contour
    off = {glue = 0}              # and at its end
    delay = 0.2                   # after switching on
    approach = 50                 # above the first point, along the tool axis
    retract = 50                  # above the last point
    travel = 200                  # speed between contours; from [motion] if left out
    direction = [0, 0, -1]        # where the tool points, in the frame
    tangential = false            # true: the tool's x axis follows the contour
    inside_first = true           # contours inside others first; false: for the shortest travel
    offset = 3                    # from the contour to the tool's centre: its radius, half a kerf
    side = "nesting"              # outlines outside, holes inside; or inside, outside, left, right
    way_round = "climb"           # or conventional, clockwise, anticlockwise, drawn
    start = "nearest"             # of closed contours; or corner, longest, point
    lead_in = {arc = 5, angle = 90}    # radius; or {line = 5, angle = 60}, {tangent = 5}
    lead_out = {line = 5}         # on the side of the tool
    overlap = 8                   # by which a closed contour continues over its start
    depth = 12                    # of the last pass below the drawing, along the tool
    passes = 3                    # equal steps down to it
    allowances = [0.5, 0]         # added to the offset, one round for each: rough, then finish
    order = "travel"              # or "drawing"; "text": by the numbers next to contours
    corner_speed = 20             # where the contour turns, and mm before and after there
    corner_angle = 30             # turns by fewer degrees are not corners
    corner_radius = 0             # arcs of up to that radius are corners too
    corner_length = 5
    start_speed = 30              # over the first mm
    start_length = 5
    end_speed = 30                # over the last mm
    end_length = 5
    on_before = {seconds = 0.03}  # `on` during the approach; mm, seconds, or both
    # on_after = {mm = 5}         # `on` that far past the start
    off_before = {mm = 5}         # `off` before the end; mm, seconds, or both
    # off_after = {mm = 5}        # `off` during the retract, or seconds after the end
    # travel_height = 80          # for retract: height above the highest point of the layer
    travel_blend = 10             # mm, of the targets above the work; "fine" if left out
    travel_kind = "linear"        # or "joint"; left out: joint where the tool would wind up

    [placement]                   # of a drawing in the frame of [motion]; moves all that is drawn
    position = [300, 0, 0]        # mm, of its origin
    euler_zyx = [90, 0, 0]        # or quaternion, as for tools
    # or three marks, each as it is drawn and as it was taught in that frame, both in mm:
    # drawing = [[0, 0], [200, 0], [0, 100]]
    # cell = [[412.1, 8.0, 20.3], [412.4, 208.0, 20.1], [312.1, 8.2, 20.2]]
    # misfit = 1.0                # mm that a mark may be off

    [style]                       # of a drawing's program
    procedures = "contour"        # one each, called by that of its layer; or "layer", "none"
    comments = true               # false: no comments about layers and contours

    [tags]                        # attribute tags of locations, by meaning
    name = "NAME"
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, Final

from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Refused, error, has_errors
from assistant.base.near_names import near_name
from assistant.base.source_text import SourceText, decode, read_bytes
from assistant.program import settings_tables
from assistant.program import settings_tables as values
from assistant.program.geometry import BASE, FLANGE, Frame, Load, Pose, Tool
from assistant.program.motion import Speed
from assistant.program.program import Interface, Signal
from assistant.program.settings_tables import (
    ENCODINGS,
    REPAIRED,
    Read,
    Table,
    Wrong,
    listed,
    read_toml,
    shown,
)
from assistant.program.statements import Motion
from assistant.program.undeclared_names import ChannelLine
from assistant.sources.process import SEEN_KEYS as KEYS_OF_SEEN
from assistant.sources.process import (
    SHAPING_KEYS,
    STYLE_KEYS,
    ContourTravel,
    Defaults,
    Layer,
    LeftOut,
    OutputSwitching,
    Process,
    ProgramStyle,
    SpeedProfile,
    SwitchPoint,
    read_left_out,
    seen_of,
    shaping_of,
)
from assistant.sources.process.placement import (
    MOST_MISFIT,
    ONE_PLACEMENT,
    PLACEMENT_KEYS,
    placement_by_marks,
    placement_fault,
)

EXCLUSIVE_KEY = error(
    "CT340", "`{key}` and `{other}` cannot both be", "leave one of them out: {why}"
)
NEEDS_OTHER_KEY = error(
    "CT341", "`{key}` says nothing without `{other}`", "add `{other}`, or delete it"
)
SWITCHED_TOO_EARLY = error(
    "CT342",
    "`{key}` is {wanted:g} mm of the way{how}, of which `{of}` leaves {length:g} mm{corner}",
    "give less, or a larger `{of}`{other}",
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
"""Keys of the process file, each with the field of `SpeedProfile` and its reading."""

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
    # Only tables that state something, so that the defaults of the layer stay.
    return {key: value for key, value in made.items() if value != type(value)()}


def check_contour_motion(table: Table, layer: Layer, *, planned: bool) -> None:
    """Report settings that do not fit the motions to the contours and away from them.

    planned: True if travel is planned through the cell.
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
    corner = {"corner": "", "other": ""}
    if blend:
        corner = {
            "corner": f": `travel_blend` takes {blend:g} mm",
            "other": " or a smaller `travel_blend`",
        }
    # The plunge has the slower of both speeds, see `follow_contour`.
    slow = min(speed.tcp, travel) if isinstance(speed, Speed) else travel
    if (before := switching.on_before) is not None:
        wanted, how = before.mm + before.seconds * slow, f" at {slow:g} mm/s"
        if wanted > max(approach - blend, 0.0):
            said = {"how": how if before.seconds else "", "of": "approach", **corner}
            left = max(approach - blend, 0.0)
            table.say(
                SWITCHED_TOO_EARLY, "on_before", key="on_before", wanted=wanted, length=left, **said
            )
    left = max(retract - blend, 0.0)
    if (after := switching.off_after) is not None and after.mm > left:
        of = "retract" if above.height is None else "travel_height"
        said = {"how": "", "of": of, **corner}
        table.say(
            SWITCHED_TOO_EARLY, "off_after", key="off_after", wanted=after.mm, length=left, **said
        )


NOT_DEFINED = error("CT309", "there is no {kind} `{name}`", "{cure}")
NOT_AN_OUTPUT = error("CT310", "`{name}` is an input and cannot be set", "name an output")
NOT_ITS_VALUE = error("CT311", "the {kind} signal `{name}` cannot be {value}", "write {wanted}")

MOTION_KEYS: Final[Mapping[str, Read]] = {
    "speed": settings_tables.speed,
    "blend": settings_tables.blend,
    "tool": settings_tables.name,
    "frame": settings_tables.name,
}


class DefinedNames:
    """The tools, frames and signals of the file, to find those that others name."""

    def __init__(
        self,
        tools: Mapping[str, Tool],
        frames: Iterable[str],
        signals: Mapping[str, Signal],
    ) -> None:
        self._tools = tools
        self._known = {"tool": [*tools, FLANGE], "frame": [*frames, BASE]}
        self._signals = signals

    def motion(self, table: Table, keys: Mapping[str, Read]) -> dict[str, Any]:
        """The table's values, tools and frames under the names they were defined by."""
        found = table.read(keys)
        for kind, known in self._known.items():
            if kind in found:
                name = self._find(table, kind, kind, found[kind], known)
                if name is None:
                    del found[kind]
                else:
                    found[kind] = name
        return found

    def turns_freely(self, tool: str) -> bool:
        return tool in self._tools and self._tools[tool].free_turn

    def switched(self, table: Table, wanted: Mapping[str, float]) -> Iterable[tuple[str, float]]:
        for given, value in wanted.items():
            name = self._find(table, given, "signal", given, list(self._signals))
            if name is None:
                continue
            signal = self._signals[name]
            if signal.direction == "input":
                table.say(NOT_AN_OUTPUT, given, name=name)
            most = 2**signal.bits - 1
            if signal.kind != "analog" and not (value == int(value) and 0 <= value <= most):
                said = f"{value:g}"
                table.say(
                    NOT_ITS_VALUE,
                    given,
                    kind=signal.kind,
                    name=name,
                    value=said,
                    wanted=f"a whole number, 0 to {most}",
                )
            yield name, value

    @staticmethod
    def _find(table: Table, key: str, kind: str, given: str, known: list[str]) -> str | None:
        for name in known:
            if name.casefold() == given.casefold():
                return name
        near, shown_name = near_name(given, known), shown(given)
        cure = (
            f"write {near}"
            if near
            else f"define [{kind}s.{shown_name}]; there are: {listed(known)}"
        )
        table.say(NOT_DEFINED, key, kind=kind, name=shown_name, cure=cure)
        return None


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
    **CONTOUR_MOTION_KEYS,
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
    ways = contour_motion_of(table, found)
    found.setdefault("travel", defaults.travel)
    motion = Motion(**(usual | parts))
    layer = Layer(
        process,
        motion,
        rounded=rounded,
        own_blend="blend" in parts,
        shaping=shaping,
        **switched,
        **ways,
        **found,
    )
    check_contour_motion(table, layer, planned=defaults.travels)
    return layer


NUMBER_WITHOUT_CONTROLLER = error(
    "CO328",
    "`{name}` has a number, but is written with the program",
    "write `on_controller = true` too, or leave out `number`",
)
MOST_TOOL_NUMBER: Final = 16
"""Highest number of a tool on controllers that count them (parameters MEXTL1 to MEXTL16)."""

PROGRAM_KEYS: Final[Mapping[str, Read]] = {
    "as": settings_tables.name,
    "main": settings_tables.truth,
    "prefix": settings_tables.name,
    "local": settings_tables.truth,
}
ON_CONTROLLER_KEYS: Final[Mapping[str, Read]] = {
    "on_controller": settings_tables.truth,
    "number": settings_tables.whole(1, MOST_TOOL_NUMBER),
}
"""Keys of a tool or a frame."""


def interface_of(top: Table) -> Interface | None:
    """Return the interface of [program], with the tools and frames that the controller has; None if
    empty.
    """
    found = top.table("program").read(PROGRAM_KEYS)
    there: dict[str, int | None] = {}
    for kind in ("tools", "frames"):
        given = top.content.get(kind)
        for name, said in given.items() if isinstance(given, dict) else ():
            if not isinstance(said, dict):
                continue
            if said.get("on_controller") is True:
                there[name.lower()] = said.get("number")
            elif "number" in said:
                top.page.say(
                    NUMBER_WITHOUT_CONTROLLER, (*top.path, kind, name, "number"), name=name
                )
    if not found and not there:
        return None
    return Interface(
        found.get("as", ""),
        found.get("main", True),
        found.get("prefix", ""),
        found.get("local", False),
        there,
    )


TWO_ORIENTATIONS = error(
    "CT306", "`{name}` gives its orientation twice", "keep either quaternion or euler_zyx"
)
NO_MASS = error(
    "CT307", "`{name}` has a centre of gravity but no mass", "give `mass` in kg as well"
)
RESERVED = error("CT308", "`{name}` is always {meaning}", "give yours another name")
NO_LINE = error(
    "CT321",
    "`{name}` is no communication line",
    "name it line_1 to line_8, and give its role, port and, but for a serial one, its address",
)
NO_MAIN = error(
    "CT346",
    "a program without a main procedure does not go home",
    "leave out `home`, or `main = false` under [program]",
)
ONE_BIT = error("CT312", "the {kind} signal `{name}` has no bits", 'write kind = "group"')


MOST_SIGNAL_NUMBER: Final = 65535
"""Highest signal number of a CR controller (network inputs and outputs included)."""

TOP_TABLES: Final = (
    "program",
    "motion",
    "tools",
    "frames",
    "seen",
    "signals",
    "lines",
    "layers",
    "tags",
)

TOP_KEYS: Final[Mapping[str, Read]] = {
    "robot": values.text,
    "tolerance": values.tolerance,
    "joint_speed": values.number("mm/s", above=0.0),
    "joint_percent": values.number("percent", least=1.0, most=100.0),
}
"""Keys of the top that hold one value."""

DRAWING_KEYS: Final[Mapping[str, Read]] = {
    "unit": values.unit,
    "leave_out": read_left_out,
    "follow": values.texts,
    "assumed": values.texts,
    "home": values.axes,
}
"""Keys of the top that only a drawing needs."""
PLACEMENT_TABLE: Final = "placement"
STYLE_TABLE: Final = "style"
DRAWING_TABLES: Final = (PLACEMENT_TABLE, STYLE_TABLE)
"""Tables that only a drawing needs."""

ORIENTATION_KEYS: Final[Mapping[str, Read]] = {
    "quaternion": values.quaternion,
    "euler_zyx": values.euler_zyx,
    "held": values.truth,
    **ON_CONTROLLER_KEYS,
}
TOOL_KEYS: Final[Mapping[str, Read]] = {
    "tip": values.position,
    **ORIENTATION_KEYS,
    "free_turn": values.truth,
    "mass": values.number("kg", above=0.0),
    "centre": values.position,
}
FRAME_KEYS: Final[Mapping[str, Read]] = {
    "position": values.position,
    **ORIENTATION_KEYS,
    "seen": values.text,
}
DEFAULT_MOTION_KEYS: Final[Mapping[str, Read]] = {
    "kind": values.choice("joint", "linear", "travel"),
    **MOTION_KEYS,
    "approach": values.number("mm", least=0.0),
    "retract": values.number("mm", least=0.0),
    "travel": values.speed,
}
SIGNAL_KEYS: Final[Mapping[str, Read]] = {
    "kind": values.choice("digital", "analog", "group"),
    "direction": values.choice("output", "input"),
    "number": values.whole(0, MOST_SIGNAL_NUMBER),
    "bits": values.whole(1, values.MOST_BITS),
}
LINE_KEYS: Final[Mapping[str, Read]] = {
    "role": values.choice("server", "client", "serial"),
    "port": values.whole(1, 65535),
    "address": values.text,
}


def read_process(path: str | FilePath) -> Process:
    """Read a process file; `findings` of the result hold the warnings.

    Raises Unreadable if it is not TOML, Refused, with every finding, if the content has errors.
    """
    return parse_process(decode(read_bytes(path, most=SETTINGS_FILE), str(path), ENCODINGS))


def parse_process(source: SourceText) -> Process:
    """Parse a process file from text, like `read_process`."""
    return process_in(read_toml(source))


def process_in(top: Table, beside: Sequence[str] = ()) -> Process:
    """The process file's tables of a document that may hold other keys beside them.

    Such a document is no drawing: it states lengths in mm, and has no layers to leave out.
    """
    page = top.page
    keys = {**dict.fromkeys((*TOP_TABLES, *beside), _read_unchanged), **TOP_KEYS}
    drawn = {**DRAWING_KEYS, **dict.fromkeys(DRAWING_TABLES, _read_unchanged)}
    found = top.read(keys if beside else {**keys, **drawn})
    tools = {n: _read_tool(n, t) for n, t in top.table("tools").named()}
    frames = {n: _read_frame(n, t) for n, t in top.table("frames").named()}
    signals = {n: _read_signal(n, t) for n, t in top.table("signals").named()}
    lines = dict(one for n, t in top.table("lines").named() for one in _read_line(n, t))
    seen = seen_of(top.table("seen").read(KEYS_OF_SEEN), page.source.path)
    interface = interface_of(top)
    if "home" in found and interface is not None and not interface.main:
        top.say(NO_MAIN, "home")
    names = DefinedNames(tools, frames, signals)
    defaults = Defaults(**names.motion(top.table("motion"), DEFAULT_MOTION_KEYS))
    layers = {
        layer: layer_of(layer, table, defaults, names)
        for layer, table in top.table("layers").named(identifiers=False)
    }
    tags = top.table("tags").read(_tag_keys(top))
    directed = (n for n, t in top.table("signals").named() if "direction" in t.content)
    placement = (
        _read_placement(top.table(PLACEMENT_TABLE))
        if not beside and PLACEMENT_TABLE in top.content
        else None
    )
    style = {} if beside else top.table(STYLE_TABLE).read(STYLE_KEYS)
    findings = tuple(sorted(page.findings, key=lambda f: f.line or 0))
    if has_errors(findings):
        raise Refused(*findings)
    plain = {key: found[key] for key in (*TOP_KEYS, *DRAWING_KEYS) if key in found}
    entries = plain.pop("leave_out", ())
    plain["leave_out"] = tuple(one for one in entries if isinstance(one, str))
    plain["left_out"] = tuple(one for one in entries if isinstance(one, LeftOut))
    return Process(
        *(defaults, tools, frames, signals, layers, tags),
        lines=lines,
        placement=placement,
        interface=interface,
        undirected=frozenset(signals).difference(directed),
        seen=seen,
        style=ProgramStyle(**style),
        findings=findings,
        **plain,
    )


def _read_unchanged(value: Any) -> Any:
    return value


def _tag_keys(top: Table) -> dict[str, Read]:
    """The meanings that attributes of a drawing can have."""
    if "tags" not in top.content:
        return {}
    from assistant.sources.drawing.attributes import TAG_MEANINGS

    return dict.fromkeys(TAG_MEANINGS, values.text)


def _read_tool(name: str, table: Table) -> Tool:
    found = table.read(TOOL_KEYS)
    if name.casefold() == FLANGE:
        table.say(RESERVED, name=name, meaning="the bare flange")
    if "centre" in found and "mass" not in table.content:
        table.say(NO_MASS, "centre", name=name)
    load = Load(found["mass"], found.get("centre", (0.0, 0.0, 0.0))) if "mass" in found else None
    free = found.get("free_turn", False)
    return Tool(_read_pose(name, table, found, "tip"), load, found.get("held", True), free)


def _read_frame(name: str, table: Table) -> Frame:
    found = table.read(FRAME_KEYS)
    if name.casefold() == BASE:
        table.say(RESERVED, name=name, meaning="the robot's own base")
    held, seen = found.get("held", False), found.get("seen", "")
    return Frame(user=_read_pose(name, table, found, "position"), held=held, seen=seen)


def _read_placement(table: Table) -> Pose | None:
    """None with a finding where the table is wrong."""
    found = table.read(PLACEMENT_KEYS)
    wrong = placement_fault(table.content)
    if wrong is not None:
        table.say(ONE_PLACEMENT, what=wrong)
    # A key that was refused has its finding already.
    if wrong is not None or len(found) < len(table.content):
        return None
    if "drawing" not in found:
        return _read_pose(PLACEMENT_TABLE, table, found, "position")
    placed = placement_by_marks(found["drawing"], found["cell"], found.get("misfit", MOST_MISFIT))
    table.say(placed.rule, **placed.fields)
    return placed.pose


def _read_pose(name: str, table: Table, found: Mapping[str, Any], position: str) -> Pose:
    if "quaternion" in table.content and "euler_zyx" in table.content:
        table.say(TWO_ORIENTATIONS, "euler_zyx", name=name)
    turn = found.get("euler_zyx", Pose().quaternion)
    if "quaternion" in found:
        turn, length = found["quaternion"]
        if abs(length - 1.0) > values.EXACT_LENGTH:
            table.say(REPAIRED, "quaternion", key="quaternion", length=length)
    return Pose(found.get(position, (0.0, 0.0, 0.0)), turn)


def _read_line(name: str, table: Table) -> Iterator[tuple[int, ChannelLine]]:
    found, number = table.read(LINE_KEYS), re.fullmatch(r"(?i)line_([1-8])", name)
    # A serial line has no address.
    if number is None or len(found) < len(LINE_KEYS) - (found.get("role") == "serial"):
        table.say(NO_LINE, name=name)
    else:
        yield int(number[1]), ChannelLine(**found)


def _read_signal(name: str, table: Table) -> Signal:
    found = table.read(SIGNAL_KEYS)
    kind = found.get("kind", "digital")
    if found.get("bits", 1) != 1 and kind != "group":
        table.say(ONE_BIT, "bits", name=name, kind=kind)
    return Signal(kind, found.get("direction", "output"), found.get("number"), found.get("bits", 1))
