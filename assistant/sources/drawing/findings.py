"""What can be found wrong with a drawing: the table of its rules, and how it is counted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from assistant.program.diagnostics import Diagnostic, Rule, Severity

E, W, I = Severity.ERROR, Severity.WARNING, Severity.INFO  # noqa: E741

# The file.
NO_DXF = Rule("DX001", E, "`{name}` is no DXF drawing: {reason}", "export it again as DXF")
TRUNCATED = Rule(
    "DX002",
    E,
    "`{name}` ends before its end mark, so a part of the drawing is missing",
    "copy or export the file again",
)
BROKEN = Rule("DX003", E, "`{name}` cannot be repaired: {reason}", "export it again as DXF")
REPAIRED = Rule("DX004", W, "repaired: {what}", "look whether the drawing is whole, save it anew")
LOST = Rule(
    "DX005", E, "repair would drop an entity: {what}", "repair the entity in the CAD system"
)
NOTED = Rule("DX006", W, "the file is not quite in order: {what}", "save it anew as DXF")
EMPTY = Rule(
    "DX007",
    E,
    "nothing in the drawing can become motion",
    "draw contours on layers of the process file, or points and blocks with attributes",
)
UNKNOWN_MEANING = Rule(
    "DX008", E, "the process file gives a tag for `{meaning}`, which means nothing", "use {known}"
)
UNKNOWN_DEFAULT = Rule(
    "DX009", E, "the default {what} `{name}` is not declared", "declare it in the process file"
)

# Units and coordinate systems.
NO_UNITS = Rule(
    "DX101",
    W,
    "the drawing names no unit ($INSUNITS is {state}); millimetres are assumed{hint}",
    'state it: `unit = "mm"` in the process file, or --unit mm',
)
UNKNOWN_UNITS = Rule(
    "DX102",
    E,
    "unit code {code} of $INSUNITS is not defined",
    'state the unit: `unit = "mm"` in the process file, or --unit mm',
)
OTHER_UCS = Rule(
    "DX103",
    I,
    "a user coordinate system is current; coordinates are those of the world system",
    "give the frame that the world system stands in as the default frame of the process file",
)

OTHER_UNIT = Rule(
    "DX104",
    I,
    "the drawing names {said}, but is read in {given}, as was stated",
    "leave `unit` out to take the drawing's own",
)

# Entities and inserts.
UNUSED = Rule(
    "DX201",
    W,
    "{count} {kind} on layer `{layer}` cannot become motion",
    "explode or redraw with lines, arcs, polylines or splines what the robot has to follow",
)
LEFT_OUT = Rule("DX202", I, "{count} {kind} on layer `{layer}` left out: {reason}")
DEGENERATE = Rule(
    "DX203", W, "{count} {kind} on layer `{layer}` left out: {reason}", "delete or redraw them"
)
IGNORED = Rule("DX204", I, "{what} of {count} {kind} on layer `{layer}` ignored")
BAD_ENTITY = Rule("DX205", E, "the {kind} cannot be read: {reason}", "redraw the entity")
NO_BLOCK = Rule(
    "DX206", E, "the block `{block}` does not exist", "define the block or delete the insert"
)
RECURSIVE = Rule(
    "DX207", E, "the block `{block}` contains itself", "explode the inner insert of the block"
)
EXTERNAL = Rule(
    "DX208",
    E,
    "the block `{block}` stands in another file, which is not read",
    "bind the external reference into the drawing",
)
TOO_MANY = Rule(
    "DX209",
    E,
    "with all its inserts the drawing has more than {most} entities",
    "leave out what the robot does not need",
)
TOO_DEEP = Rule("DX210", E, "blocks are nested more than {most} deep", "explode inner blocks")
CLIPPED = Rule(
    "DX211",
    E,
    "the insert of block `{block}` is clipped, which cannot be followed",
    "explode the insert and trim what is in it",
)

# Locations.
NOT_A_NUMBER = Rule("DX301", E, "{tag} is {given!r}, which is no number", "write a number: 12.5")
COMMA = Rule("DX302", E, "{tag} is {given!r}, with a decimal comma", "write {cure}")
NOT_FINITE = Rule("DX303", E, "{tag} is {given!r}, which is not finite", "write a number: 12.5")
OUT_OF_RANGE = Rule("DX304", E, "{tag} is {given!r}, but has to be {range}", "correct the value")
TWICE = Rule("DX305", E, "the attribute {tag} is there twice", "delete one of them")
PARTIAL = Rule(
    "DX306",
    E,
    "the orientation is incomplete: {missing} without a value",
    "give all of {all}, or none of them",
)
TWO_ORIENTATIONS = Rule("DX307", E, "both angles and a quaternion are given", "give one of the two")
REPAIRED_QUATERNION = Rule(
    "DX308", W, "the quaternion has length {length:.6f} and is made 1", "give more decimals"
)
NO_QUATERNION = Rule(
    "DX309",
    E,
    "the quaternion has length {length:.6f} instead of 1",
    "give a unit quaternion, scalar first",
)
UNKNOWN_NAME = Rule(
    "DX310", E, "{tag} names the {what} `{given}`, which is not declared", "use one of {known}"
)
UNKNOWN_WORD = Rule("DX311", E, "{tag} is {given!r}, which is not known", "use one of {known}")
DUPLICATE = Rule(
    "DX312", W, "the location `{given}` is there already; this one is `{name}`", "rename one"
)
MIRRORED = Rule(
    "DX313",
    W,
    "the location `{name}` is mirrored: x and z of the tool are as drawn, y is turned over",
    "check the orientation",
)
SKEWED = Rule(
    "DX314",
    W,
    "the location `{name}` is in an unevenly scaled block: the tool's z is as drawn, x near it",
    "check the orientation",
)
FACING = Rule(
    "DX315",
    I,
    "{count} {kind} on layer `{layer}` without orientation: the tool points {reason}",
    "give RX RY RZ or Q1 Q2 Q3 Q4 for another orientation",
)
FACING_UP = Rule(
    "DX316",
    W,
    "the location `{name}` has its extrusion downwards, so that the tool points up",
    "give an orientation, or draw it from above",
)
SOME_ORDERED = Rule(
    "DX317",
    W,
    "{ordered} locations state an order, {rest} do not and come last, as drawn",
    "give each location an order",
)
SAME_ORDER = Rule(
    "DX318", W, "the order {order} is there twice; these come as drawn", "number them anew"
)
NO_LOCATION = Rule(
    "DX319",
    W,
    "the attributes of block `{block}` ({tags}) do not make it a location",
    "give it an orientation, speed, blend, tool, frame or motion, or delete the other attributes",
)
MOVING_FRAME = Rule(
    "DX320",
    E,
    "the location cannot be put from frame `{drawing}` into `{frame}`: one of them moves",
    "use a frame that stands still",
)
UNUSED_TAG = Rule(
    "DX321", W, "{count} attributes {tag} of locations are not used", "see the process file's tags"
)

LONGEST_SHOWN: Final = 80


def shown(text: str) -> str:
    """Text from a drawing as it may stand in a message or comment: one line, printable."""
    cut = text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 1] + "…"
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in cut
    )


MOST_HANDLES: Final = 3
"""How many entities a count names."""


@dataclass(slots=True)
class Tally:
    """Counts of what is not used, by rule, type, layer and reason: nothing vanishes."""

    counts: dict[tuple[Rule, str, str, str], int] = field(default_factory=dict)
    handles: dict[tuple[Rule, str, str, str], list[str]] = field(default_factory=dict)

    def add(self, rule: Rule, kind: str, layer: str, reason: str = "", handle: str = "") -> None:
        key = (rule, kind, layer, reason)
        self.counts[key] = self.counts.get(key, 0) + 1
        named = self.handles.setdefault(key, [])
        if handle and handle not in named and len(named) < MOST_HANDLES:
            named.append(handle)

    def findings(self) -> Iterator[Diagnostic]:
        """One finding for each rule, type, layer and reason, in order of appearance."""
        for key, count in self.counts.items():
            rule, kind, layer, reason = key
            named = ", ".join("#" + h for h in self.handles[key])
            more = " …" if count > len(self.handles[key]) else ""
            yield rule(
                place=f"{kind} {named}{more}".strip() if named else kind,
                count=count,
                kind=kind,
                layer=shown(layer),
                reason=reason,
                what=reason,
                tag=kind,
            )
