"""How many entities a drawing has with all its inserts, told by its blocks without inserting one.

A block counts once for each layer that layer 0 stands for in it, and each depth that it is met in:
what 40 blocks in each other stand for, 2⁴⁰ entities, is known after looking at 40 blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, cast

from assistant.sources.drawing.document import library_errors
from assistant.sources.drawing.transforms import copies

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.entities.insert import Insert

LayerInBlock = Callable[["DXFGraphic", str], tuple[str, bool]]
"""The layer of an entity in a block, by that of the block's insert, and whether it is followed."""


class EntityCount:
    """Of a document. most_nested: blocks in each other that are followed."""

    def __init__(self, document: Drawing, layered: LayerInBlock, most_nested: int) -> None:
        self._blocks, self._layered, self._most = document.blocks, layered, most_nested
        self._known: dict[tuple[str, str, int], int] = {}

    def of(self, entities: Iterable[DXFGraphic], layer: str = "", depth: int = 0) -> int:
        """Entities and what their inserts stand for. layer: in effect around them."""
        return sum(self._one(entity, layer, depth) for entity in entities)

    def _one(self, entity: DXFGraphic, around: str, depth: int) -> int:
        if entity.dxftype() != "INSERT":
            return 1
        layer, followed = self._layered(entity, around)
        if not followed:
            return 1
        try:
            times = copies(cast("Insert", entity))
            count = times[0] * times[1]
        except library_errors():
            return 1  # it is left out, with a finding
        block = self._blocks.get(entity.dxf.get("name", ""))
        if block is None or depth >= self._most:
            return 1 + count
        key = (block.name.lower(), layer, depth)
        if key not in self._known:
            self._known[key] = self.of(block, layer, depth + 1)
        return 1 + count * self._known[key]
