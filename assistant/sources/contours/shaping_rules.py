"""What is found while contours become ways of a tool beside them."""

from __future__ import annotations

from typing import Final

from assistant.base.diagnostics import error, info, warning

CONTOUR_CROSSING: Final = warning(
    "CT109",
    "a closed contour on layer {layer!r} crosses or touches itself and is followed as drawn",
    "redraw it if it is an outline",
)
OPEN_CONTOUR: Final = error(
    "CT210",
    "an open contour on layer {layer!r} has no inside or outside for the tool to be on",
    'give the layer side = "left" or "right", as it is drawn; closed contours of other sides go to '
    "a layer of their own",
)
NOT_FLAT: Final = error(
    "CT211",
    "a contour on layer {layer!r} is not flat as seen along the tool: its heights are "
    "{apart:.3f} mm apart",
    "draw it flat, give `direction`, or leave out offset, side and leads",
)
CROSSES_ITSELF: Final = error(
    "CT212",
    "a contour on layer {layer!r} crosses or touches itself and has no inside",
    "redraw it so that it does not",
)
OFFSET_COLLAPSED: Final = warning(
    "CT213",
    "a contour on layer {layer!r} is too narrow for an offset of {offset:g} mm: {what} left out",
    "use a narrower tool and a smaller `offset`, or take the contour to another layer",
)
OFFSET_SPLIT: Final = warning(
    "CT214",
    "a contour on layer {layer!r} is too narrow in places for an offset of {offset:g} mm and "
    "falls into {count} ways; the necks between them are left out",
    "use a narrower tool and a smaller `offset`",
)
MATERIAL_LEFT: Final = warning(
    "CT215",
    "the tool comes no nearer than {left:.2f} mm to a place of a contour on layer {layer!r}: "
    "that is too tight for an offset of {offset:g} mm and left out",
    "use a narrower tool and a smaller `offset`",
)
CUTS_INTO: Final = error(
    "CT216",
    "the way beside a contour on layer {layer!r} comes within {apart:.2f} mm of another contour, "
    "and the tool needs {offset:g} mm",
    "move them apart, or use a narrower tool and a smaller `offset`",
)
NO_ROOM: Final = error(
    "CT217",
    "there is no room for the leads of a contour on layer {layer!r}{where}: they would cut into it "
    "or into another one",
    "give shorter ones as `lead_in` and `lead_out`{cure}",
)
SIDES_CHOSEN: Final = info(
    "CT218",
    "the tool is outside of {outside} and inside of {inside} closed contours of layer {layer!r}, "
    "{offset:g} mm away",
    "give `side` if that is not where it should be",
)
START_MARKS: Final = warning(
    "CT219", "{what} on layer {layer!r}", "draw one POINT on each closed contour of the layer"
)
OVERLAP_TOO_LONG: Final = error(
    "CT333",
    "an overlap of {overlap:g} mm is longer than a contour on layer {layer!r}, of {length:.2f} mm",
    "give a smaller `overlap`",
)
LAYERS_MINGLED: Final = warning(
    "CT334",
    "contours of layer {layer!r} lie inside of contours of layers that lie inside of its own: "
    "not every one comes before what is around it",
    "draw them on one layer",
)
