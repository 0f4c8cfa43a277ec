"""The unit of a drawing, and how many millimetres it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.length_units import UNITS
from assistant.sources.drawing.findings import NO_UNITS, OTHER_UNIT, UNKNOWN_UNITS

if TYPE_CHECKING:
    from ezdxf.document import Drawing

SURVEY_FOOT: Final = 1_200_000.0 / 3937.0
"""mm; 1200/3937 m by its definition of 1893."""
INCH: Final = UNITS["in"][1]
FOOT: Final = UNITS["ft"][1]
METRE: Final = UNITS["m"][1]
ASTRONOMICAL_UNIT: Final = 149_597_870_700.0 * METRE

MILLIMETRES: Final[dict[int, tuple[str, float]]] = {
    1: UNITS["in"],
    2: UNITS["ft"],
    3: ("miles", FOOT * 5280),
    4: UNITS["mm"],
    5: UNITS["cm"],
    6: UNITS["m"],
    7: ("kilometres", METRE * 1e3),
    8: ("microinches", INCH * 1e-6),
    9: UNITS["mil"],
    10: UNITS["yd"],
    11: ("ångströms", 1e-7),
    12: ("nanometres", 1e-6),
    13: UNITS["um"],
    14: UNITS["dm"],
    15: ("decametres", METRE * 10),
    16: ("hectometres", METRE * 100),
    17: ("gigametres", METRE * 1e9),
    18: ("astronomical units", ASTRONOMICAL_UNIT),
    19: ("light years", 9_460_730_472_580_800.0 * METRE),
    20: ("parsecs", ASTRONOMICAL_UNIT * 648_000 / 3.141592653589793),
    21: ("US survey feet", SURVEY_FOOT),
    22: ("US survey inches", SURVEY_FOOT / 12),
    23: ("US survey yards", SURVEY_FOOT * 3),
    24: ("US survey miles", SURVEY_FOOT * 5280),
}
"""Code of $INSUNITS (DXF reference, header section) → name, millimetres."""


def unit_of(
    document: Drawing, path: str, given: str | None = None
) -> tuple[str, float, tuple[Diagnostic, ...]]:
    """Name of the drawing's unit, mm a unit, findings; raises Refused for unknown codes.

    given: short name of the unit that holds whatever the drawing says. The units of blocks do
    not matter: a CAD system puts them into the scale of the insert when it is made.
    """
    code = document.header.get("$INSUNITS", None)
    if given is not None:
        name, factor = UNITS[given]
        said, _ = MILLIMETRES.get(code or 0, (name, factor))
        told = (OTHER_UNIT(path=path, place="header", said=said, given=name),)
        return name, factor, told if said != name else ()
    if code is None or code == 0:
        state = "missing" if code is None else "0"
        english = document.header.get("$MEASUREMENT", 1) == 0
        hint = ", although its measurement is English" if english else ""
        return "millimetres", 1.0, (NO_UNITS(path=path, place="header", state=state, hint=hint),)
    if code not in MILLIMETRES:
        raise Refused(UNKNOWN_UNITS(path=path, place="header", code=code))
    return (*MILLIMETRES[code], ())
