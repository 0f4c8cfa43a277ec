"""Texts of a drawing that number its contours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

from assistant.base.arrays import Floats
from assistant.sources.contours.curves import vector
from assistant.sources.contours.numbering import Written
from assistant.sources.drawing.transforms import ocs_matrix

if TYPE_CHECKING:
    from ezdxf.entities.dxfgfx import DXFGraphic

TEXTS: Final = frozenset(("TEXT", "MTEXT"))


def numbers(entity: DXFGraphic) -> bool:
    """Whether an entity is a text that is a number."""
    return entity.dxftype() in TEXTS and _written(entity, (0.0, 0.0, 0.0)).number is not None


def written(entity: DXFGraphic, matrix: Floats, layer: str) -> Written:
    """A text at its insertion point. matrix: (4, 4), to the drawing's world in mm."""
    text = cast("Any", entity)
    if entity.dxftype() == "MTEXT":
        point = text.dxf.insert.xyz
    else:
        aligned = text.dxf.get("halign", 0) or text.dxf.get("valign", 0)
        chosen = text.dxf.align_point if aligned and text.dxf.hasattr("align_point") else None
        point = (chosen or text.dxf.insert).xyz
        point = (ocs_matrix(text.dxf.extrusion.xyz) @ (*point, 1.0))[:3]
    return _written(entity, vector((matrix @ (*point, 1.0))[:3]), layer)


def _written(entity: DXFGraphic, at: tuple[float, float, float], layer: str = "") -> Written:
    text = cast("Any", entity)
    return Written(text.plain_text(), at, layer, entity.dxf.handle or "")
