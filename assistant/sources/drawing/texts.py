"""Texts of a drawing that number its contours."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

from assistant.base.arrays import Floats
from assistant.sources.contours.curves import vector
from assistant.sources.contours.numbering import LayerText
from assistant.sources.drawing.transforms import ocs_matrix

if TYPE_CHECKING:
    from ezdxf.entities.dxfgfx import DXFGraphic

TEXT_TYPES: Final = frozenset(("TEXT", "MTEXT"))


def is_number_text(entity: DXFGraphic) -> bool:
    """Whether an entity is a text that is a number."""
    return (
        entity.dxftype() in TEXT_TYPES
        and _layer_text_at(entity, (0.0, 0.0, 0.0)).number is not None
    )


def layer_text(entity: DXFGraphic, matrix: Floats, layer: str) -> LayerText:
    """A text at its insertion point. matrix: (4, 4), to the drawing's world in mm."""
    text = cast("Any", entity)
    if entity.dxftype() == "MTEXT":
        point = text.dxf.insert.xyz
    else:
        aligned = text.dxf.get("halign", 0) or text.dxf.get("valign", 0)
        chosen = text.dxf.align_point if aligned and text.dxf.hasattr("align_point") else None
        point = (chosen or text.dxf.insert).xyz
        point = (ocs_matrix(text.dxf.extrusion.xyz) @ (*point, 1.0))[:3]
    return _layer_text_at(entity, vector((matrix @ (*point, 1.0))[:3]), layer)


def _layer_text_at(
    entity: DXFGraphic, at: tuple[float, float, float], layer: str = ""
) -> LayerText:
    text = cast("Any", entity)
    return LayerText(text.plain_text(), at, layer, entity.dxf.handle or "")
