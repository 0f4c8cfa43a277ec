"""A drawing as tables of its layers, blocks and locations, and as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from assistant.program.geometry import Vector
from assistant.sources.drawing.findings import shown
from assistant.sources.drawing.survey import Extents, Survey, SurveyedBlock, SurveyedLayer

_LAYERS: Final = ("layer", "state", "colour", "entities", "contours", "length mm", "size mm", "use")
BLOCKS: Final = ("block", "inserts", "is", "attributes")
_LOCATIONS: Final = ("location", "layer", "at mm")
_MOST: Final = 20
"""Most locations listed one by one."""
_MOST_VALUES: Final = 3
"""Most values of an attribute that are listed."""


def record(survey: Survey) -> dict[str, Any]:
    """Return the contents of the tables as plain data: mm."""
    return {
        "unit": {
            "name": survey.unit,
            "millimetres": survey.millimetres,
            "stated": survey.stated,
        },
        "extents": _box(survey.extents),
        "layers": [
            {
                "name": one.name,
                "state": one.state,
                "colour": one.colour,
                "entities": one.kinds,
                "unused": one.unused,
                "contours": {"closed": one.closed, "open": one.open},
                "length": round(one.length, 6),
                "extents": _box(one.extents),
                "locations": one.locations,
                "use": one.use,
                "drafting": one.drafting,
                "parts": [
                    {"what": part.what, "name": part.name, "kind": part.kind, "count": part.count}
                    for part in one.parts
                ],
            }
            for one in survey.layers
        ],
        "blocks": [
            {
                "name": one.name,
                "inserts": one.inserts,
                "location": one.location,
                "attributes": {tag: list(texts) for tag, texts in one.attributes.items()},
            }
            for one in survey.blocks
        ],
        "locations": [
            {"name": one.name, "layer": one.layer, "position": list(one.position)}
            for one in survey.locations
        ],
    }


def lines(survey: Survey) -> Iterator[str]:
    """Unit and size, then tables."""
    yield f"unit: {survey.unit}, {survey.stated} ({survey.millimetres:g} mm each)"
    if survey.extents is None:
        yield "size: nothing in it can be followed or visited"
    else:
        low, high = (_at(corner) for corner in (survey.extents.low, survey.extents.high))
        yield f"size: {_size(survey.extents)} mm, from {low} to {high}"
    yield ""
    yield from _table([_LAYERS, *map(_layer, survey.layers)])
    if survey.blocks:
        yield ""
        yield from _table([BLOCKS, *map(_block, survey.blocks)])
    if survey.locations:
        yield ""
        told = survey.locations[:_MOST]
        rows = [(shown(one.name), shown(one.layer), _at(one.position)) for one in told]
        yield from _table([_LOCATIONS, *rows])
        if len(survey.locations) > _MOST:
            yield f"and {len(survey.locations) - _MOST} more, see --format json"


def _layer(layer: SurveyedLayer) -> tuple[str, ...]:
    unused = "" if not layer.unused else f"; not used: {_counted(layer.unused)}"
    if layer.parts:
        parts = (f"{one.count} of {one.what} {shown(one.name)}" for one in layer.parts)
        unused = f"; switched off: {', '.join(parts)}{unused}"
    contours = [f"{n} {what}" for n, what in ((layer.closed, "closed"), (layer.open, "open")) if n]
    return (
        shown(layer.name),
        layer.state,
        "" if layer.colour is None else str(layer.colour),
        _counted(layer.kinds),
        ", ".join(contours),
        f"{layer.length:.1f}" if contours else "",
        "" if layer.extents is None else _size(layer.extents),
        layer.use + unused,
    )


def _counted(kinds: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {shown(kind)}" for kind, count in kinds.items())


def _block(block: SurveyedBlock) -> tuple[str, ...]:
    attributes = []
    for tag, texts in block.attributes.items():
        more = " …" if len(texts) > _MOST_VALUES else ""
        attributes.append(f"{shown(tag)}={'|'.join(texts[:_MOST_VALUES])}{more}")
    kind = "a location" if block.location else "drawn"
    return shown(block.name), str(block.inserts), kind, ", ".join(attributes)


def _table(rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        yield "  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()


def _box(extents: Extents | None) -> dict[str, list[float]] | None:
    return None if extents is None else {"from": list(extents.low), "to": list(extents.high)}


def _size(extents: Extents) -> str:
    return " x ".join(f"{length:.1f}" for length in extents.size)


def _at(position: Vector) -> str:
    return "[" + ", ".join(f"{part:.3f}" for part in position) + "]"
