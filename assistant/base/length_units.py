"""Units of length by the short names that settings files and `--unit` take."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from assistant.base.diagnostics import Diagnostic, Refused, error, info
from assistant.base.near_names import near_name

UNITS: Final[Mapping[str, tuple[str, float]]] = {
    "mm": ("millimetres", 1.0),
    "cm": ("centimetres", 10.0),
    "dm": ("decimetres", 100.0),
    "m": ("metres", 1000.0),
    "um": ("micrometres", 1e-3),
    "mil": ("mils", 0.0254),
    "in": ("inches", 25.4),
    "ft": ("feet", 304.8),
    "yd": ("yards", 914.4),
}
"""Short name → name for people, millimetres."""

_UNKNOWN_UNIT = error("SR002", "there is no unit of length `{name}`", "{cure}")
_UNIT_STATED = info(
    "SR003",
    "the unit `{unit}` changes nothing here: the file states its own lengths",
    "leave --unit out, of a project's program `unit`, or correct the lengths in the file",
)


def length_text(mm: float) -> str:
    """A measured length in mm, as far as it means something: tenths, two digits below 1."""
    size = abs(mm)
    if 0.0 < size < 0.01:
        return "less than 0.01"
    return f"{round(mm, 1 if size >= 1.0 else 2) + 0.0:g}"


def unit_stated(path: object, unit: str) -> Diagnostic:
    """That a file states its own lengths; raises Refused as `known_unit` does."""
    return _UNIT_STATED(path=str(path), unit=known_unit(unit))


def known_unit(name: str) -> str:
    """The name itself; raises Refused, exit status 2, if there is no such unit."""
    if not isinstance(name, str) or name not in UNITS:
        given = str(name)[:40]
        words = {long: short for short, (long, _) in UNITS.items()} | {"foot": "ft"}
        words |= {long.replace("metre", "meter"): short for long, short in words.items()}
        near = near_name(given, words)
        cure = f"choose one of {', '.join(UNITS)}"
        cure = f"did you mean `{words[near]}`?" if near else cure
        raise Refused(_UNKNOWN_UNIT(name=given, cure=cure), exit_status=2)
    return name
