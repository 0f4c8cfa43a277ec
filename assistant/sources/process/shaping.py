"""How the contours of a layer become ways of the tool: sides, starts, leads, passes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, Literal

from assistant.base.diagnostics import error
from assistant.program import settings_tables
from assistant.program.settings_tables import Read, Table, Wrong, kind_of, shown

NO_DEPTH = error("CT330", "`passes` needs a depth that they share", "give `depth` in mm as well")
DEPTH_WITHOUT_RETRACT = error(
    "CT331",
    "with `depth` the tool is in the work: it needs ways in and out of it",
    "give `approach` and `retract` of more than 0 mm",
)
NO_SIDE = error(
    "CT332", "`side` says where the tool is, but nothing on this layer asks for it", "{cure}"
)

MOST_PASSES: Final = 1000
QUARTER_TURN: Final = 90.0
LEAD_FORMS: Final = "write {arc = 5, angle = 90}, {line = 5, angle = 60} or {tangent = 5}"


@dataclass(frozen=True, slots=True)
class Lead:
    """A way onto or off a contour, on the side where the tool is.

    line: mm in a line that meets the contour at an angle in degrees, 0 along it. arc: mm of the
    radius of an arc that touches the contour, over an angle in degrees.
    """

    kind: Literal["line", "arc"]
    size: float
    angle: float = QUARTER_TURN


@dataclass(frozen=True, slots=True)
class Shaping:
    """offset: mm from the contour to the centre of the tool, 0 for the contour itself.

    side: where the tool is: `nesting` is outside of outlines and inside of holes; left and right
    are as an open contour is drawn. way_round: None for as drawn where it is closed, and as
    travel is shortest where it is open. start: of closed contours. overlap: mm that a closed
    contour goes on over its own start. depth: mm below the drawing, along the tool, reached in
    equal `passes`. allowances: mm more than the offset, once around for each.
    """

    offset: float = 0.0
    side: Literal["nesting", "inside", "outside", "left", "right"] = "nesting"
    way_round: Literal["climb", "conventional", "clockwise", "anticlockwise", "drawn"] | None = None
    start: Literal["nearest", "corner", "longest", "point"] = "nearest"
    lead_in: Lead | None = None
    lead_out: Lead | None = None
    overlap: float = 0.0
    depth: float = 0.0
    passes: int = 1
    allowances: tuple[float, ...] = (0.0,)

    @property
    def leads(self) -> tuple[Lead, ...]:
        return tuple(lead for lead in (self.lead_in, self.lead_out) if lead)

    @property
    def sided(self) -> bool:
        """Whether it matters on which side of a closed contour the tool is."""
        return self.sided_open or bool(self.leads)

    @property
    def sided_open(self) -> bool:
        """The same of an open one, which runs on along its tangents without cutting into itself."""
        moved = self.offset > 0.0 or any(self.allowances)
        turned = self.way_round in ("climb", "conventional")
        return moved or turned or any(lead.angle > 0.0 for lead in self.leads)

    @property
    def depths(self) -> tuple[float, ...]:
        """Mm below the drawing of each pass."""
        return tuple(self.depth * (i + 1) / self.passes for i in range(self.passes))


AS_DRAWN: Final = Shaping()


def read_lead(value: Any) -> Lead:
    if not isinstance(value, dict):
        raise Wrong(f"is {kind_of(value)}", LEAD_FORMS)
    kinds = [kind for kind in ("arc", "line", "tangent") if kind in value]
    other = next((key for key in value if key not in ("arc", "line", "tangent", "angle")), None)
    if other is not None:
        raise Wrong(f"has no key {shown(other)}", LEAD_FORMS)
    if len(kinds) != 1:
        raise Wrong("is not one of arc, line and tangent", LEAD_FORMS)
    (kind,) = kinds
    if kind == "tangent" and "angle" in value:
        raise Wrong("runs along the tangent and has no angle", "leave out the angle, or write line")
    try:
        size: float = settings_tables.number("mm", above=0.0)(value[kind])
        angle: float = QUARTER_TURN
        if "angle" in value:
            most = 180.0 if kind == "arc" else 150.0
            angle = settings_tables.number("degrees", above=0.0, most=most)(value["angle"])
    except Wrong as wrong:
        raise Wrong(f"has a number that {wrong.what}", wrong.cure) from None
    if kind == "tangent":
        return Lead("line", size, 0.0)
    return Lead("arc" if kind == "arc" else "line", size, angle)


def read_allowances(value: Any) -> tuple[float, ...]:
    cure = "write mm in brackets, falling to what the last one leaves: [0.5, 0]"
    if not isinstance(value, list) or not value:
        raise Wrong(f"is {kind_of(value)}" if value != [] else "is empty", cure)
    read = settings_tables.number("mm", least=0.0)
    found = tuple(read(entry) for entry in value)
    if any(later >= earlier for earlier, later in pairwise(found)):
        raise Wrong("does not fall", cure)
    return found


SHAPING_KEYS: Final[Mapping[str, Read]] = {
    "offset": settings_tables.number("mm", above=0.0),
    "side": settings_tables.choice("nesting", "inside", "outside", "left", "right"),
    "way_round": settings_tables.choice(
        "climb", "conventional", "clockwise", "anticlockwise", "drawn"
    ),
    "start": settings_tables.choice("nearest", "corner", "longest", "point"),
    "lead_in": read_lead,
    "lead_out": read_lead,
    "overlap": settings_tables.number("mm", least=0.0),
    "depth": settings_tables.number("mm", least=0.0),
    "passes": settings_tables.whole(1, MOST_PASSES),
    "allowances": read_allowances,
}


def shaping_of(table: Table, found: dict[str, Any]) -> Shaping:
    """From the values of a layer's table, which it takes out of them."""
    stated = "side" in found
    shaping = Shaping(**{key: found.pop(key) for key in SHAPING_KEYS if key in found})
    if "passes" in table.content and not shaping.depth:
        table.say(NO_DEPTH, "passes")
    if shaping.depth and not all(found.get(key, 1.0) > 0.0 for key in ("approach", "retract")):
        table.say(DEPTH_WITHOUT_RETRACT, "depth")
    if stated and not shaping.sided:
        cure = "give `offset`, a lead, or `way_round`; or delete `side`"
        table.say(NO_SIDE, "side", cure=cure)
    return shaping
