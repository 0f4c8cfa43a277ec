"""Findings in a drawing: the table of their rules, and their counts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Rule, error, info, warning

# The file.
NO_DXF = error("DX001", "`{name}` is no DXF drawing: {reason}", "export it again as DXF")
TRUNCATED = error(
    "DX002",
    "`{name}` ends before its end mark, so a part of the drawing is missing",
    "copy or export the file again",
)
BROKEN = error("DX003", "`{name}` cannot be repaired: {reason}", "export it again as DXF")
REPAIRED = warning("DX004", "repaired: {what}", "look whether the drawing is whole, save it anew")
LOST = error("DX005", "repair would drop an entity: {what}", "repair the entity in the CAD system")
NOTED = warning("DX006", "the file is not quite in order: {what}", "save it anew as DXF")
EMPTY = error(
    "DX007",
    "nothing in the drawing can become motion",
    "draw contours on layers of the process file, or points and blocks with attributes, or delete"
    " from leave_out what is work",
)
NO_PROCEDURE_LEFT = error(
    "DX014",
    '`procedures = "none"` leaves nothing that other programs could call, and `main = false`'
    " leaves no main procedure",
    'write `procedures = "layer"` under [style], or leave out `main` under [program]',
)
UNKNOWN_MEANING = error(
    "DX008", "the process file gives a tag for `{meaning}`, which means nothing", "use {known}"
)
UNKNOWN_DEFAULT = error(
    "DX009", "the default {what} `{name}` is not declared", "declare it in the process file"
)
MALFORMED = error("DX010", "`{given}` at group code {code} is no number{more}", "{cure}")
ONLY_DRAFTING = error(
    "DX011",
    "all that could be followed has the name or shape of drafting, not of work: {what}",
    "{cure}, if that is the work",
)

# Units and coordinate systems.
NO_UNITS = warning(
    "DX101",
    "the drawing names no unit ($INSUNITS is {state}); millimetres are assumed{hint}",
    'state it: `unit = "mm"` in the process file, or --unit mm',
)
UNKNOWN_UNITS = error(
    "DX102",
    "unit code {code} of $INSUNITS is not defined",
    'state the unit: `unit = "mm"` in the process file, or --unit mm',
)
OTHER_UCS = info(
    "DX103",
    "a user coordinate system is current; coordinates are those of the world system",
    "give the frame that the world system stands in as the default frame of the process file",
)

OTHER_UNIT = info(
    "DX104",
    "the drawing names {said}, but is read in {given}, as was stated",
    "leave `unit` out to take the drawing's own",
)

# Entities and inserts.
UNUSED = warning(
    "DX201",
    "{count} {kind} on layer `{layer}` cannot become motion",
    "explode or redraw with lines, arcs, polylines or splines what the robot has to follow",
)
LEFT_OUT = info("DX202", "{count} {kind} on layer `{layer}` left out: {reason}")
DEGENERATE = warning(
    "DX203", "{count} {kind} on layer `{layer}` left out: {reason}", "delete or redraw them"
)
IGNORED = info("DX204", "{what} of {count} {kind} on layer `{layer}` ignored")
BAD_ENTITY = error("DX205", "the {kind} cannot be read: {reason}", "redraw the entity")
NO_BLOCK = error(
    "DX206",
    "the block `{block}` does not exist",
    "define the block, delete the insert, or write leave_out = [{{block = {key}}}] at the top of"
    " the process file",
)
RECURSIVE = error(
    "DX207", "the block `{block}` contains itself", "explode the inner insert of the block"
)
EXTERNAL = error(
    "DX208",
    "the block `{block}` stands in another file, which is not read",
    "bind the external reference into the drawing",
)
TOO_MANY = error(
    "DX209",
    "with all its inserts the drawing has more than {most} entities",
    "leave out what the robot does not need",
)
TOO_DEEP = error("DX210", "blocks are nested more than {most} deep", "explode inner blocks")
CLIPPED = error(
    "DX211",
    "the insert of block `{block}` is clipped, which cannot be followed",
    "explode the insert and trim what is in it",
)
DRAFTING = info(
    "DX212",
    "{count} entities are left out, as their names or shapes mean drafting, not work: {what}",
    "to follow them after all, {cure}",
)
MAY_BE_SHEET = error(
    "DX214",
    "the rectangle of {size} mm has the size or form of a sheet of paper or its title block"
    " ({name}): it may be that, or a part",
    'write leave_out = ["border"] at the top of the process file if it is the sheet, or'
    ' follow = ["border"] if it is work',
)
ENDS_ON_BORDER = warning(
    "DX215",
    "{count} lines that end on the border of a sheet, {size} mm, are followed; the first is at {at}"
    " on layer `{layer}`",
    "if they belong to the sheet, write leave_out = [{entry}] at the top of the process file",
)
MAY_BE_EXTENSION_LINES = error(
    "DX216",
    "the {count} lines on layer `{layer}` run along extension lines of the {dimensions} dimensions"
    " there: they may belong to these, or be work",
    'write leave_out = ["{key}"] at the top of the process file if they belong to the dimensions,'
    ' or follow = ["{key}"] if they are work',
)
DRAFTING_FOLLOWED = info(
    "DX213",
    "{count} entities whose names mean drafting are followed, as the process file names their"
    " layer: {what}",
    "to leave them out, write leave_out = [{entry}] at the top of the process file",
)

# Locations.
NOT_A_NUMBER = error("DX301", "{tag} is {given!r}, which is no number", "write a number: 12.5")
COMMA = error("DX302", "{tag} is {given!r}, with a decimal comma", "write {cure}")
NOT_FINITE = error("DX303", "{tag} is {given!r}, which is not finite", "write a number: 12.5")
OUT_OF_RANGE = error("DX304", "{tag} is {given!r}, but has to be {range}", "correct the value")
TWICE = error("DX305", "the attribute {tag} is there twice", "delete one of them")
PARTIAL = error(
    "DX306",
    "the orientation is incomplete: {missing} without a value",
    "give all of {all}, or none of them",
)
TWO_ORIENTATIONS = error("DX307", "both angles and a quaternion are given", "give one of the two")
REPAIRED_QUATERNION = warning(
    "DX308", "the quaternion has length {length:.6f} and is made 1", "give more decimals"
)
NO_QUATERNION = error(
    "DX309",
    "the quaternion has length {length:.6f} instead of 1",
    "give a unit quaternion, scalar first",
)
UNKNOWN_NAME = error(
    "DX310", "{tag} names the {what} `{given}`, which is not declared", "use one of {known}"
)
UNKNOWN_WORD = error("DX311", "{tag} is {given!r}, which is not known", "use one of {known}")
DUPLICATE = warning(
    "DX312", "the location `{given}` is there already; this one is `{name}`", "rename one"
)
MIRRORED = warning(
    "DX313",
    "the location `{name}` is mirrored: x and z of the tool are as drawn, y is turned over",
    "check the orientation",
)
SKEWED = warning(
    "DX314",
    "the location `{name}` is in an unevenly scaled block: the tool's z is as drawn, x near it",
    "check the orientation",
)
FACING = info(
    "DX315",
    "{count} {kind} on layer `{layer}` without orientation: the tool points {reason}",
    "give RX RY RZ or Q1 Q2 Q3 Q4 for another orientation",
)
FACING_UP = warning(
    "DX316",
    "the location `{name}` has its extrusion downwards, so that the tool points up",
    "give an orientation, or draw it from above",
)
SOME_ORDERED = warning(
    "DX317",
    "{ordered} locations state an order, {rest} do not and come last, as drawn",
    "give each location an order",
)
QUICKEST = info(
    "DX322",
    "the {count} locations are visited in an order that takes {after:.2f} s of joint moves at full"
    " speed; it was {before:.2f} s in the order of drawing",
    "give them an order where it matters",
)
SAME_ORDER = warning(
    "DX318", "the order {order} is there twice; these come as drawn", "number them anew"
)
NO_LOCATION = warning(
    "DX319",
    "the attributes of block `{block}` ({tags}) do not make it a location",
    "give it an orientation, speed, blend, tool, frame or motion, or delete the other attributes",
)
MOVING_FRAME = error(
    "DX320",
    "the location cannot be put from frame `{drawing}` into `{frame}`: one of them moves",
    "use a frame that stands still",
)
UNUSED_TAG = warning(
    "DX321", "{count} attributes {tag} of locations are not used", "see the process file's tags"
)

_LONGEST_SHOWN: Final = 80


def shown(text: str) -> str:
    """Return text from a drawing in a form for messages and comments: one line, printable."""
    cut = text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 1] + "…"
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in cut
    )


_MOST_HANDLES: Final = 3
"""Largest number of entities that a count names."""


@dataclass(slots=True)
class Tally:
    """Counts of what is not used, by rule, type, layer and reason: nothing vanishes."""

    counts: dict[tuple[Rule, str, str, str], int] = field(default_factory=dict)
    handles: dict[tuple[Rule, str, str, str], list[str]] = field(default_factory=dict)

    def add(self, rule: Rule, kind: str, layer: str, reason: str = "", handle: str = "") -> None:
        key = (rule, kind, layer, reason)
        self.counts[key] = self.counts.get(key, 0) + 1
        named = self.handles.setdefault(key, [])
        if handle and handle not in named and len(named) < _MOST_HANDLES:
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


NOT_MEASURED = warning(
    "CT369",
    "assumed, and not measured yet: {what}",
    "measure it before an arm moves, write what was measured, and take its name out of `assumed` "
    "at the top of the process file",
)
