"""Traversal of a drawing: every entity once for each placement by inserts.

A block on a frozen layer is not visible at all; on a layer that is off, only the entities on layer
0 of the block are hidden with it. In a block, layer 0 means the layer of the insert. Entities on a
frozen or switched-off layer, invisible ones, and those in paper space are left out and counted. The
geometry of a location block is its symbol, for people: it is counted, not read. Locations inside it
are read.

`_EntityCount` counts the entities of a drawing with all its inserts without inserting a block: each
block counts once for each layer that layer 0 means in it and each depth where it occurs. Forty
blocks in each other expand to 2⁴⁰ entities, which is known after examining forty blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import field
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.budgets import budget_factor
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.base.toml_edits import toml_value
from assistant.sources.drawing.attributes import Tags, texts_of
from assistant.sources.drawing.document import library_errors
from assistant.sources.drawing.entities import check_stated, is_followed
from assistant.sources.drawing.findings import (
    BAD_ENTITY,
    CLIPPED,
    EXTERNAL,
    LEFT_OUT,
    NO_BLOCK,
    NO_LOCATION,
    RECURSIVE,
    TOO_DEEP,
    TOO_MANY,
    UNUSED,
    Tally,
    shown,
)
from assistant.sources.drawing.transforms import cells, check_insert, copies, insert_matrix

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.entities.insert import Insert
    from ezdxf.layouts.blocklayout import BlockLayout


_LayerInBlock = Callable[["DXFGraphic", str], tuple[str, bool]]
"""The layer of an entity in a block, by that of the block's insert, and whether it is followed."""


class _EntityCount:
    """Entity counts of a document. most_nested: depth of nested blocks that are followed."""

    def __init__(self, document: Drawing, layered: _LayerInBlock, most_nested: int) -> None:
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
            # Nothing of a hidden insert is inserted.
            return 1
        try:
            times = copies(cast("Insert", entity))
            count = times[0] * times[1]
        except library_errors():
            return 1  # it is left out, with a finding
        block = self._blocks.get(entity.dxf.get("name", ""))
        if block is None or depth >= self._most:
            return 1 + count
        # Layer and depth change what the content counts for, so they belong to the key.
        key = (block.name.lower(), layer, depth)
        if key not in self._known:
            self._known[key] = self.of(block, layer, depth + 1)
        return 1 + count * self._known[key]


MOST_ENTITIES: Final = 1_000_000
"""Nested blocks double with each level: a small file can stand for more than a memory holds."""

MOST_NESTED: Final = 100

_DIMENSION_LAYER: Final = "defpoints"
"""Layer on which CAD systems put the construction points of dimensions; never plotted."""

_ANNOTATION: Final = frozenset(
    {
        "TEXT",
        "MTEXT",
        "ATTDEF",
        "ATTRIB",
        "LEADER",
        "MULTILEADER",
        "TOLERANCE",
        "ACAD_TABLE",
        "DIMENSION",
        "ARC_DIMENSION",
        "LARGE_RADIAL_DIMENSION",
        "VIEWPORT",
        "IMAGE",
        "WIPEOUT",
        "OLEFRAME",
        "OLE2FRAME",
        "PDFUNDERLAY",
    }
)
"""Types that are for people to read; no robot would be expected to follow them."""

_XREF_FLAGS: Final = 4 | 8

CONTINUOUS: Final = "Continuous"
_BY_LAYER: Final = "BYLAYER"
_BY_BLOCK: Final = "BYBLOCK"


def _never(_: str) -> bool:
    return False


def _never_block(_: str, __: str) -> bool:
    return False


@dataclass(frozen=True, slots=True, eq=False)
class PlacedEntity:
    """An entity at one of its placements.

    matrix: from the coordinates of its container to the drawing's world, in mm. layer: in effect.
    place: the inserts it is in and its handle, for people. cell: of a multiple insert. inserted:
    the outermost insert that contains it, None outside blocks. line_type: in effect. blocks: around
    it, from the outermost, in small letters.
    """

    entity: DXFGraphic
    matrix: Floats
    layer: str
    place: str
    cell: tuple[float, float] = (0.0, 0.0)
    inserted: InsertedBlock | None = None
    line_type: str = CONTINUOUS
    blocks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class InsertedBlock:
    """A block at one place in the model space, the same object for all that comes with it.

    matrix: (4, 4) from its coordinates to the drawing's world in mm. base: (3,) its base point.
    """

    block: str
    matrix: Floats
    base: Floats


@dataclass(slots=True)
class Traversal:
    """Walks through a document; `tally` and `findings` fill while it goes.

    wanted: which entities are yielded, beside points and locations; what is not is counted.
    numbering: which texts of a layer are yielded.
    unwanted: tells layers of which what is not yielded is not counted either. unwanted_block: tells
    by layer and block which inserts need no content.
    """

    document: Drawing
    path: str
    tags: Tags
    tally: Tally
    wanted: Callable[[DXFGraphic], bool] = is_followed
    numbering: Callable[[DXFGraphic, str], bool] = lambda entity, layer: False  # noqa: ARG005
    unwanted: Callable[[str], bool] = _never
    unwanted_block: Callable[[str, str], bool] = _never_block
    findings: list[Diagnostic] = field(default_factory=list)
    annotations: list[Floats] = field(default_factory=list)
    """Where texts are, (3,) mm of the world; not a number for dimensions and leaders."""
    missing: dict[str, None] = field(default_factory=dict)
    """Names of blocks that are inserted, but not in the file."""
    states: dict[str, str] = field(default_factory=dict)
    """Layer in lower case → `frozen` or `off`."""
    line_types: dict[str, str] = field(default_factory=dict)
    """Layer in lower case → its line type."""

    def __post_init__(self) -> None:
        for layer in self.document.layers:
            state = "frozen" if layer.is_frozen() else "off" if layer.is_off() else ""
            self.states[layer.dxf.name.lower()] = state
            self.line_types[layer.dxf.name.lower()] = str(layer.dxf.get("linetype", CONTINUOUS))

    def model(self, root: Floats) -> Iterator[PlacedEntity]:
        """Curves, points and location inserts of the model space, in order of drawing.

        root: scale from drawing units to mm.
        """
        yield from self._walk(self.document.modelspace(), _BlockOwner(root))

    def count(self) -> int:
        """Entities of the model space with all inserts; raises Refused if there are too many."""
        entities = self.document.modelspace()
        count = _EntityCount(self.document, self._layered, MOST_NESTED).of(entities)
        if count > MOST_ENTITIES * budget_factor():
            raise Refused(TOO_MANY(path=self.path, most=int(MOST_ENTITIES * budget_factor())))
        return count

    def _layered(self, entity: DXFGraphic, around: str) -> tuple[str, bool]:
        """The layer of an entity in a block that is inserted on another, and if it is followed."""
        layer = _layer_of(entity)
        # Layer 0 in a block means the layer of the insert.
        if layer == "0" and around:
            layer = around
        return layer, self._hidden(entity, layer) in (None, _LAYER_OFF)

    def paper(self) -> None:
        """Count the entities in paper space; viewports there are windows, not part of a drawing."""
        for layout in self.document.layouts:
            if layout.is_modelspace:
                continue
            reason = f"it is in the paper space `{shown(layout.name)}`"
            for entity in layout:
                if entity.dxftype() != "VIEWPORT":
                    self._leave(LEFT_OUT, entity, _layer_of(entity), reason)

    def _walk(self, entities: Iterable[DXFGraphic], owner: _BlockOwner) -> Iterator[PlacedEntity]:
        for entity in entities:
            layer = _layer_of(entity)
            # Layer 0 in a block means the layer of the insert.
            if layer == "0" and owner.blocks:
                layer = owner.layer
            kind = entity.dxftype()
            hidden = self._hidden(entity, layer)
            # A layer that is off hides only what is on it, so the content of the block is still
            # visited.
            if kind == "INSERT" and hidden in (None, _LAYER_OFF):
                yield from self._insert(cast("Insert", entity), layer, hidden, owner)
            elif kind == "ATTDEF" and owner.blocks:
                continue  # says which attributes an insert may have; those are read there
            elif hidden:
                self._leave(LEFT_OUT, entity, layer, hidden)
            elif owner.symbol:
                self._leave(LEFT_OUT, entity, layer, _LOCATION_SYMBOL)
            elif layer.lower() == _DIMENSION_LAYER:
                self._leave(LEFT_OUT, entity, layer, "construction points of dimensions")
            elif kind in _ANNOTATION and not self.numbering(entity, layer):
                self._note(entity, owner.matrix)
                self._leave(LEFT_OUT, entity, layer, "it is for people to read")
            elif kind == "POINT" or kind in _ANNOTATION or self.wanted(entity):
                place = owner.place(entity)
                line_type = self._line_type(entity, layer, owner)
                yield PlacedEntity(
                    *(entity, owner.matrix, layer, place),
                    inserted=owner.inserted,
                    line_type=line_type,
                    blocks=owner.blocks,
                )
            else:
                self._leave(UNUSED, entity, layer, "")

    def _insert(
        self, insert: Insert, layer: str, hidden: str | None, owner: _BlockOwner
    ) -> Iterator[PlacedEntity]:
        place = owner.place(insert)
        try:
            check_stated(insert)
            tags = [tag for tag, _ in texts_of(insert, self.document)]
            check_insert(insert)
        except library_errors() as error:
            self._say(BAD_ENTITY, place, kind="INSERT", reason=shown(str(error)))
            return
        location = self.tags.make_location(tags)
        # A location on a hidden layer is hidden as its symbol is.
        if hidden and location:
            self._leave(LEFT_OUT, insert, layer, hidden)
            return
        if not location:
            self._no_location(insert, layer, tags, place, owner.matrix)
        wanted = not self.unwanted_block(layer, str(insert.dxf.get("name", "")))
        block = self._block(insert, place, owner, needed=not location and wanted)
        symbol = owner.symbol or location
        for cell in cells(insert):
            # The location is yielded once per copy, its symbol is walked for locations inside it.
            if location:
                yield PlacedEntity(insert, owner.matrix, layer, place, cell, owner.inserted)
            if block is None:
                continue
            with np.errstate(all="ignore"):  # what overflows is found not to be finite
                inner = owner.matrix @ insert_matrix(insert, block.base_point.xyz, cell)
            blocks = (*owner.blocks, block.name)
            # The outermost insert stands for all inside it; a location's symbol stands for nothing.
            inserted = owner.inserted
            if inserted is None and not location:
                inserted = InsertedBlock(block.name, inner, np.array(block.base_point.xyz))
            line_type = self._line_type(insert, layer, owner)
            own = _BlockOwner(inner, layer, f"{place} > ", blocks, symbol, inserted, line_type)
            yield from self._walk(block, own)

    def _block(
        self, insert: Insert, place: str, owner: _BlockOwner, *, needed: bool
    ) -> BlockLayout | None:
        """The block of an insert; None, with a finding, if its content cannot be had."""
        name = insert.dxf.get("name", "")
        block = self.document.blocks.get(name)
        given = shown(name)
        if block is None:
            if needed:  # a location needs no symbol
                self.missing.setdefault(str(name))
                self._say(NO_BLOCK, place, block=given, key=toml_value(given))
        elif needed and _is_clipped(insert):
            self._say(CLIPPED, place, block=given)
        elif block.name.lower() in (*map(str.lower, owner.blocks), "*model_space"):
            self._say(RECURSIVE, place, block=given)
        elif len(owner.blocks) >= MOST_NESTED:
            self._say(TOO_DEEP, place, most=MOST_NESTED)
        elif block.block is not None and block.block.dxf.flags & _XREF_FLAGS and not len(block):
            # An external reference has no content in this file.
            if needed:
                self._say(EXTERNAL, place, block=given)
        else:
            return block
        return None

    def _no_location(
        self, insert: Insert, layer: str, tags: list[str], place: str, matrix: Floats
    ) -> None:
        for attribute in insert.attribs:
            if not self._hidden(attribute, layer):
                self._note(attribute, matrix)
            self._leave(LEFT_OUT, attribute, layer, "it belongs to a block that is no location")
        if any(self.tags.meaning(tag) for tag in tags):
            names = " ".join(shown(tag) for tag in tags)
            self._say(NO_LOCATION, place, block=shown(insert.dxf.name), tags=names)

    def _line_type(self, entity: DXFGraphic, layer: str, owner: _BlockOwner) -> str:
        """The line type in effect: the entity's, its layer's, or that of the insert around it."""
        given = str(entity.dxf.get("linetype", _BY_LAYER))
        if given.upper() == _BY_BLOCK:
            return owner.line_type
        if given.upper() == _BY_LAYER:
            return self.line_types.get(layer.lower(), CONTINUOUS)
        return given

    def _hidden(self, entity: DXFGraphic, layer: str) -> str | None:
        if entity.dxf.is_supported("invisible") and entity.dxf.get("invisible", 0):
            return "it is invisible"
        state = self.states.get(layer.lower(), "")
        return {"frozen": "the layer is frozen", "off": _LAYER_OFF}.get(state)

    def _note(self, entity: DXFGraphic, matrix: Floats) -> None:
        at = entity.dxf.get("insert") if entity.dxf.is_supported("insert") else None
        here = np.full(3, np.nan) if at is None else (matrix @ (*at.xyz, 1.0))[:3]
        self.annotations.append(np.asarray(here))

    def _leave(self, rule: Rule, entity: DXFGraphic, layer: str, reason: str) -> None:
        if not self.unwanted(layer):
            self.tally.add(rule, shown(entity.dxftype()), layer, reason, entity.dxf.handle or "")

    def _say(self, rule: Rule, place: str, **fields: Any) -> None:
        self.findings.append(rule(path=self.path, place=place, **fields))


def _is_clipped(insert: Insert) -> bool:
    """True if only a part of the block is shown; a robot must not follow the rest."""
    from ezdxf.xclip import XClip

    clip = XClip(insert)
    return clip.has_clipping_path and clip.is_clipping_enabled


def _layer_of(entity: DXFGraphic) -> str:
    """The entity's own layer, also of a type that ezdxf only stores."""
    if entity.dxf.is_supported("layer"):
        return str(entity.dxf.layer)
    tags = getattr(entity, "xtags", None)
    stored = (tag for part in (tags.subclasses if tags else ()) for tag in part)
    return next((str(tag.value) for tag in stored if tag.code == _LAYER_CODE), "0")


_LAYER_CODE: Final = 8
_LOCATION_SYMBOL: Final = "it is the symbol of a location"
_LAYER_OFF: Final = "the layer is off"


@dataclass(frozen=True, slots=True, eq=False)
class _BlockOwner:
    """Properties that the content of a block gets from the inserts around it."""

    matrix: Floats
    layer: str = "0"
    prefix: str = ""
    blocks: tuple[str, ...] = ()
    symbol: bool = False
    inserted: InsertedBlock | None = None
    line_type: str = CONTINUOUS

    def place(self, entity: DXFGraphic) -> str:
        return f"{self.prefix}{shown(entity.dxftype())} #{entity.dxf.handle}"
