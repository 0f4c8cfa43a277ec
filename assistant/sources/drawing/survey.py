"""Survey of a drawing before a process is stated: sizes, layers, blocks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.budgets import CONTOURS, INSERTING, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic
from assistant.program.geometry import Vector
from assistant.sources.contours.chains import chain_curves
from assistant.sources.contours.curves import Curve, chorded
from assistant.sources.drawing.attributes import Tags, texts_of
from assistant.sources.drawing.contents import curves_of, root_of, ucs_of
from assistant.sources.drawing.document import library_errors, open_drawing, unit_of
from assistant.sources.drawing.drafting import BORDER, Drafting
from assistant.sources.drawing.findings import NO_UNITS, Tally, shown
from assistant.sources.drawing.locations import Location, LocationReader
from assistant.sources.drawing.traversal import Traversal
from assistant.sources.process import Process

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.insert import Insert

_CHORDS: Final = 0.001
"""Largest deviation in mm of chords of a curve when its extents are computed."""


@dataclass(frozen=True, slots=True)
class Extents:
    """The box around curves and locations in the drawing's world, mm."""

    low: Vector
    high: Vector

    @property
    def size(self) -> Vector:
        x, y, z = (b - a for a, b in zip(self.low, self.high, strict=True))
        return (x, y, z)

    @staticmethod
    def around(points: Sequence[Floats]) -> Extents | None:
        """Return the extents of arrays (n, 3), None without a point."""
        every = np.vstack(points) if points else np.empty((0, 3))
        every = every[np.isfinite(every).all(axis=1)]
        if not len(every):
            return None
        low, high = (every.min(axis=0) + 0.0).tolist(), (every.max(axis=0) + 0.0).tolist()
        return Extents((low[0], low[1], low[2]), (high[0], high[1], high[2]))


@dataclass(frozen=True, slots=True)
class LayerPart:
    """Drafting on a layer that is work. what: `line type`, `block` or `border`. count: of entities
    or, of a border, of its lines.
    """

    what: str
    name: str
    kind: str
    count: int


@dataclass(frozen=True, slots=True)
class SurveyedLayer:
    """A layer of a drawing. name: as drawn. colour: number of AutoCAD's colours, None for a layer
    that no table has. state: "on", "off" or "frozen". kinds: entities by type, with all inserts;
    unused: those that no robot follows or visits, as they are hidden, for people to read, or of a
    kind that is not a line. closed, open: contours, with curves joined end to end. length: of them,
    mm. locations: points and blocks with attributes. use: its use by the process file. drafting:
    what its name or its line type means if that is not work, empty if it may be work. parts: what
    is drafting on a layer that is work; its curves are not in the other numbers.
    """

    name: str
    colour: int | None
    state: str
    kinds: dict[str, int]
    unused: dict[str, int]
    closed: int
    open: int
    length: float
    extents: Extents | None
    locations: int
    use: str
    drafting: str = ""
    parts: tuple[LayerPart, ...] = ()

    @property
    def works(self) -> bool:
        return self.closed + self.open > 0


@dataclass(frozen=True, slots=True)
class SurveyedBlock:
    """inserts: in the model space and in blocks there. attributes: texts by tag, each once."""

    name: str
    inserts: int
    location: bool
    attributes: dict[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class SurveyedLocation:
    name: str
    layer: str
    position: Vector


@dataclass(frozen=True, slots=True)
class Survey:
    """unit: for people. millimetres: of one unit. stated: who says so. extents: of all that is not
    drafting. missing: names of blocks that are inserted, but not in the file; none if a `*` in one
    of them would stand for any letters in `leave_out`.
    """

    unit: str
    millimetres: float
    stated: str
    extents: Extents | None
    layers: tuple[SurveyedLayer, ...]
    blocks: tuple[SurveyedBlock, ...]
    locations: tuple[SurveyedLocation, ...]
    findings: tuple[Diagnostic, ...]
    missing: tuple[str, ...] = ()

    @property
    def has_work(self) -> bool:
        """True if something is drawn that a robot could follow or visit, and is no drafting."""
        return any(layer.works and not layer.drafting for layer in self.layers) or bool(
            self.locations
        )


_MOST_REASONS: Final = 3
"""Meanings of a layer that are named."""


@dataclass(slots=True)
class _Layer:
    name: str
    kinds: Counter[str] = field(default_factory=Counter)
    unused: Counter[str] = field(default_factory=Counter)
    curves: list[Curve] = field(default_factory=list)
    places: list[Vector] = field(default_factory=list)
    aside: list[Curve] = field(default_factory=list)
    reasons: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    """What, name and meaning of drafting, and its entities."""

    def settle(self) -> None:
        """A layer that holds nothing but drafting is drafting, and its curves are counted."""
        if not self.curves:
            self.curves, self.aside = self.aside, []

    @property
    def drafting(self) -> str:
        """What the layer is for, if nothing on it is work."""
        if self.aside or not self.reasons:
            return ""
        # What is known by its shape alone comes first: it may be work that nobody expects there.
        said = sorted(self.reasons.most_common(), key=lambda one: one[0][0] != BORDER)
        words = [
            kind if what == "layer" else f"{what} {shown(name)}: {kind}"
            for (what, name, kind), _ in said[:_MOST_REASONS]
        ]
        return ", ".join([*words, *(["..."] if len(said) > _MOST_REASONS else [])])


def survey(path: FilePath, process: Process, stated: str = "as stated") -> Survey:
    """Survey a drawing in mm of its world, and the parts that its process would use.

    stated: source of the unit, if the process gives it. Raises Unreadable or Refused.
    """
    name, tally = str(path), Tally()
    process = replace(process, placement=None)
    tags = Tags.of(process.tags, name)
    document, opened = open_drawing(path)
    unit, factor, units = unit_of(document, name, process.unit)
    said = stated if process.unit is not None else "as the drawing says"
    if NO_UNITS.code in {finding.code for finding in units}:
        said = "assumed, as the drawing names none"
    traversal = Traversal(
        *(document, name, tags, tally),
        unwanted_block=lambda layer, block: process.leaves_out_part(layer, "", (block,)),
    )
    drafting = Drafting.of(document, process)
    reader = LocationReader(document, name, tags, process, Tally(), attached=True)
    layers: dict[str, _Layer] = {}
    found: list[SurveyedLocation] = []

    def at(layer: str) -> _Layer:
        return layers.setdefault(layer.lower(), _Layer(layer))

    for one in document.layers:
        at(one.dxf.name)
    empty = Tally()
    with within(INSERTING, name, traversal.count()):
        for placed in traversal.model(root_of(process, factor)):
            here = at(placed.layer)
            kind = placed.entity.dxftype()
            here.kinds[kind] += 1
            given = kind == "INSERT" or process.leaves_out(placed.layer)
            reason = None if given else drafting.reason(placed)
            if reason is not None:
                here.reasons[reason.what, reason.name, reason.kind] += 1
            if kind not in ("POINT", "INSERT"):
                off = reason is not None or process.leaves_out_part(
                    placed.layer, placed.line_type, placed.blocks
                )
                (here.aside if off else here.curves).extend(curves_of(placed, empty, traversal))
            elif reason is None and (location := reader.read(placed)) is not None:
                here.places.append(location.pose.position)
                found.append(_located(location, placed.layer))
    _put_borders_aside(layers.values(), drafting, traversal.annotations)
    for (_, kind, layer, _), count in tally.counts.items():
        at(layer).kinds[kind] += count
        at(layer).unused[kind] += count
    for each in layers.values():
        each.settle()
    with (
        np.errstate(all="ignore"),
        within(CONTOURS, name, sum(len(one.curves) for one in layers.values())),
    ):
        told = [_layer(one, document, process, traversal) for one in layers.values()]
        # Drafting counts only where nothing else is drawn: the size is that of the work.
        work = [one for one in layers.values() if not one.drafting and (one.curves or one.places)]
        boxes = [_box(one) for one in work or layers.values()]
    findings = (*opened, *units, *ucs_of(document, name), *traversal.findings, *reader.findings)
    findings += tuple(drafting.findings())
    return Survey(
        unit,
        factor,
        said,
        Extents.around([points for points in boxes if len(points)]),
        tuple(told),
        tuple(_blocks(document, tags)),
        tuple(found),
        findings,
        () if any("*" in one for one in traversal.missing) else tuple(traversal.missing),
    )


def _put_borders_aside(
    layers: Collection[_Layer], drafting: Drafting, annotations: Sequence[Floats]
) -> None:
    """Move curves of borders, which are known by their shape, from the work to the drafting."""
    drawn = [(layer, curve) for layer in layers for curve in layer.curves]
    aside = [curve for layer in layers for curve in layer.aside]
    borders = drafting.borders([curve for _, curve in drawn], aside, annotations)
    if not borders:
        return
    for layer in layers:
        layer.curves = []
    for row, (layer, curve) in enumerate(drawn):
        if row in borders:
            reason = borders[row]
            layer.aside.append(curve)
            layer.reasons[reason.what, reason.name, reason.kind] += 1
        else:
            layer.curves.append(curve)


def _located(location: Location, layer: str) -> SurveyedLocation:
    return SurveyedLocation(location.given or location.stem, layer, location.pose.position)


def _box(layer: _Layer) -> Floats:
    """Points (n, 3) that reach as far as all of a layer."""
    points = [np.array(layer.places).reshape(-1, 3)]
    for curve in layer.curves:
        along = chorded(curve, _CHORDS)
        points.append(np.stack([along.min(axis=0), along.max(axis=0)]))
    return np.vstack(points)


def _layer(
    layer: _Layer, document: Drawing, process: Process, traversal: Traversal
) -> SurveyedLayer:
    state = traversal.states.get(layer.name.lower(), "") or "on"
    contours = chain_curves(layer.curves, process.tolerance)[0] if layer.curves else ()
    closed = sum(contour.closed for contour in contours)
    length = sum(curve.length for contour in contours for curve in contour.curves)
    colour = None
    if layer.name in document.layers:
        colour = abs(int(document.layers.get(layer.name).color))
    points = _box(layer)
    return SurveyedLayer(
        layer.name,
        colour,
        state,
        dict(layer.kinds),
        dict(layer.unused),
        closed,
        len(contours) - closed,
        float(length),
        Extents.around([points] if len(points) else []),
        len(layer.places),
        _use(layer, state, process),
        layer.drafting,
        tuple(
            LayerPart(what, name, kind, count)
            for (what, name, kind), count in layer.reasons.items()
            if layer.aside
        ),
    )


def _use(layer: _Layer, state: str, process: Process) -> str:
    """Describe the use of a layer, in words."""
    known = {name.casefold(): name for name in process.layers}
    if layer.drafting and not layer.places:
        return f"switched off: {layer.drafting}"
    if not layer.curves and not layer.places:
        hidden = f"nothing: the layer is {state}" if state != "on" else "nothing"
        return hidden if layer.kinds else "nothing is on it"
    if process.leaves_out(layer.name):
        return "left out"
    visited = ["locations are visited"] if layer.places else []
    if not layer.curves:
        return visited[0]
    if layer.drafting:
        return ", ".join([f"switched off: {layer.drafting}", *visited])
    if known.get(layer.name.casefold()) is not None:
        return ", ".join(["contours are followed", *visited])
    if known:
        return ", ".join(["contours are not used: it has no table", *visited])
    return ", ".join(["contours are followed as [motion] says", *visited])


def _blocks(document: Drawing, tags: Tags) -> Iterator[SurveyedBlock]:
    """Blocks that stand somewhere, in order of first appearance."""
    counts: Counter[str] = Counter()
    texts: dict[str, dict[str, dict[str, None]]] = {}
    names: dict[str, str] = {}
    pending = [*document.modelspace().query("INSERT")]
    while pending:
        insert = cast("Insert", pending.pop(0))
        name = str(insert.dxf.get("name", ""))
        key = name.lower()
        counts[key] += 1
        seen = texts.setdefault(key, {})
        try:
            for tag, text in texts_of(insert, document):
                seen.setdefault(tag, {})[text] = None
        except library_errors():
            continue  # it is a finding of who reads it
        block = document.blocks.get(name)
        if key not in names and block is not None:
            pending += block.query("INSERT")
        names.setdefault(key, name)
    for key, name in names.items():
        if not name.startswith("*"):
            attributes = {t: tuple(shown(v) for v in values) for t, values in texts[key].items()}
            yield SurveyedBlock(name, counts[key], tags.make_location(texts[key]), attributes)
