"""Programs along the contours of a drawing: one procedure for each layer, as its process states.

From curves to contours, the tool's paths beside them, their order, and the statements of each.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, error, info, warning
from assistant.base.near_names import near_name
from assistant.base.source_text import plain_letters
from assistant.program.geometry import Target, Vector
from assistant.program.motion import FINE
from assistant.program.program import Procedure, TakenNames, identifier, renamed
from assistant.program.settings_tables import shown
from assistant.program.statements import Call, Comment, OwnText, Statement
from assistant.sources.contours.chains import Contour, chain_curves, wide_gaps, without_overlaps
from assistant.sources.contours.contour_choice import ContourChoice, Row
from assistant.sources.contours.contour_order import (
    NO_HOLDER,
    GroupNesting,
    LayerText,
    group_nestings,
    order_contours,
    stated_order,
)
from assistant.sources.contours.contour_shapes import ContourShape, contour_shapes, number_text
from assistant.sources.contours.contour_statements import (
    FramedSurroundings,
    PlacedLayer,
    follow_contour,
    highest_point,
    signal_statements,
    travel_measure,
)
from assistant.sources.contours.curves import Arc, Curve, Line
from assistant.sources.contours.moves import WIDEST_ARC, contour_moves
from assistant.sources.contours.tool_paths import PathShaper, ShapedContour, ToolPath
from assistant.sources.contours.work_words import edge_kind, words_of_name
from assistant.sources.process import Layer, Process, ProgramStyle

_NOT_USED_ON_LAYER = warning(
    "CT201",
    "not used on layer {layer!r}, which the process file does not have: {what}",
    "add [layers.{key}] to the process file, or leave_out = [{key}] at its top",
)
_NO_CONTOURS = info(
    "CT202", "the process file's layer {layer!r} has no contours in the drawing", "{cure}"
)
_TOO_SMALL = warning(
    "CT203",
    "a contour on layer {layer!r} is smaller than the tolerance of {tolerance:g} mm and left out",
    "give a smaller `tolerance`",
)
_CURVE_NOT_FITTED = error(
    "CT204",
    "a curve on layer {layer!r} cannot be followed within {tolerance:g} mm",
    "redraw it without jumps, or give a larger `tolerance`",
)
_CURVES_FITTED = info(
    "CT205",
    "{count} ellipses and splines on layer {layer!r} are followed by arcs and lines, "
    "at most {deviation:.4f} mm off",
    "give a smaller `tolerance` for more and shorter pieces",
)
_TRAVEL_LENGTH_SAVED = info(
    "CT206",
    "travel between the {count} contours of layer {layer!r} is {after:.0f} mm{inside}; "
    "it was {before:.0f} mm in the order of drawing",
    "",
)
_TRAVEL_TIME_SAVED = info(
    "CT209",
    "travel between the {count} contours of layer {layer!r} takes {after:.2f} s of joint moves at"
    " full speed{inside}; it was {before:.2f} s in the order of drawing",
    "",
)
_SLOW_CORNERS = info(
    "CT222",
    "{count} corners of layer {layer!r} are gone round at {speed:g} mm/s: turns of {angle:g}"
    " degrees and more, arcs of up to {radius:g} mm",
    "",
)
_NO_SLOW_CORNER = warning(
    "CT223",
    "layer {layer!r} has no corner for `corner_speed`: no turn of {angle:g} degrees, no arc of up"
    " to {radius:g} mm",
    "give a smaller `corner_angle`, or a `corner_radius` as large as the rounded corners",
)
_TURNS_SWITCHED_ON = warning(
    "CT236",
    "at {count} corners of layer {layer!r} the tool stops and turns on the spot while the outputs"
    " of `on` are set; the first is at {at} in `{contour}`",
    "round the corners in the drawing, or leave out `tangential`, if the process must not stay",
)
_STOPS_SWITCHED_ON = info(
    "CT237",
    "the tool stops at {count} points within the contours of layer {layer!r} while the outputs of"
    " `on` are set: `blend` under [motion] is `fine`, and the layer states none",
    "leave it out of [motion] to round corners within the tolerance, or give the layer a `blend`",
)
_POINTS_LEFT_OUT = info(
    "CT108",
    "{count} points on layer {layer!r} are left out, as the way without them is at most"
    " {deviation:.4f} mm off",
    "give a smaller `tolerance` to keep them",
)
_WIDEST_TURN: Final = 120.0
"""Degrees of an arc over which the tool turns with the contour: a controller turns it the
shorter way from start to end, which has to stay the way of the arc."""

_LONGEST_NAME_STEM: Final = 20
"""Letters of a layer's name that go into the names of its paths."""
_LONGEST_LAYER_PART: Final = 12
"""Letters of it that stand before the word for a shape."""
_NUMBER_IN_NAME: Final = re.compile(r"(?:(?<![A-Za-z])[A-Za-z]{1,2})?[0-9]+(?:_[0-9]+)*")
"""A number with up to two letters before it: `D6_6`, `M8`."""
_WORD: Final = re.compile(r"[^\W\d_]{2}")
CONTOURS_SUFFIX: Final = "_contours"
"""End of the name of the procedure of a layer that something else is named like."""
_NAMELESS_PATH: Final = "path"
"""Name of open contours on a layer whose name has no letters, such as `0`."""


@dataclass(frozen=True, slots=True)
class ContourProgram:
    """procedures: of the layers, each with those of its contours after it. called: those of the
    layers, in the order of the work. targets: that they name. choice: of the contours that are
    followed. order: its contours as they are numbered in pictures; one of several passes repeats.
    at_rest: statements that switch off what the layers switch on, for the start of the program.
    """

    procedures: tuple[Procedure, ...]
    called: tuple[Procedure, ...]
    targets: Mapping[str, Target]
    findings: tuple[Diagnostic, ...]
    choice: ContourChoice
    order: tuple[Row, ...]
    at_rest: tuple[Statement, ...] = ()


@dataclass(slots=True)
class _ContourNames:
    """Names of contours by their shapes, unique in a program.

    several: more than one layer is followed, so that names begin with that of the layer.
    """

    several: bool
    taken: TakenNames
    stems: dict[tuple[str, str], str] = field(default_factory=dict)
    counts: Counter[str] = field(default_factory=Counter)

    def of(self, layer: str, shape: ContourShape) -> str:
        """The next name of a contour on a layer, which is taken then."""
        if (layer, shape.kind) not in self.stems:
            self.stems[layer, shape.kind] = _path_name_stem(self._text(layer, shape), self.taken)
        stem = self.stems[layer, shape.kind]
        while True:
            self.counts[stem] += 1
            name = f"{stem}_{self.counts[stem]}"
            if name.lower() not in self.taken.lower:
                self.taken.add(name)
                return name

    def _text(self, layer: str, shape: ContourShape) -> str:
        named = identifier(layer) if any(c.isalpha() for c in plain_letters(layer)) else ""
        if not shape.kind:
            return named or _NAMELESS_PATH
        if not (self.several and named):
            return shape.kind
        # Not `outline_outline_1`, nor `holes_hole_1`.
        words = words_of_name(named)
        if words in ([shape.kind], [f"{shape.kind}s"]) and named.replace("_", "").isalpha():
            return shape.kind
        if {shape.kind, f"{shape.kind}s"}.intersection(words):
            return named
        return f"{_shortened(named, _LONGEST_LAYER_PART)}_{shape.kind}"


def contour_program(
    curves: Sequence[Curve],
    process: Process,
    *,
    taken: set[str],
    path: str | None = None,
    marks: Sequence[tuple[str, Vector]] = (),
    texts: Sequence[LayerText] = (),
) -> ContourProgram:
    """Procedures of each layer that has a process, in the style of the process.

    curves: where the process places them in its default frame; the layers come in order of
    first appearance, those inside others first. A layer whose motion names another frame is
    followed at the same place, its targets and its tool direction given in that frame. Without any
    layer in the process, every layer moves as the defaults say. Curves of other layers are counted
    in a finding. taken: names that must not be used; those that the program got are added.
    path: the drawing, for findings. marks: points on layers, where contours start. texts: of the
    drawing, where they number contours.
    """
    names = TakenNames(taken)
    procedures: list[Procedure] = []
    called: list[Procedure] = []
    targets: dict[str, Target] = {}
    followed, findings, choice = _chosen(curves, process, names, marks, texts)
    findings += choice.findings
    kept = [choice.kept(i) for i in range(len(followed))]
    left = [rows for rows in kept if rows]
    followed = [
        (name, layer, [contours[k] for _, k in rows])
        for (name, layer, contours), rows in zip(followed, kept, strict=True)
        if rows
    ]
    nestings = group_nestings(
        [
            (layer.direction, edge_kind(contours[0].layer, layer), contours)
            for _, layer, contours in followed
        ],
        process.tolerance,
    )
    contour_names = _ContourNames(len(followed) > 1, names)
    shaper = PathShaper(
        [(layer, contours) for _, layer, contours in followed], nestings, process.tolerance
    )
    # All procedures have their names before any path gets one.
    before: Layer | None = None
    order: list[Row] = []
    worked: list[Layer] = []
    for row in shaper.order():
        name, layer, drawn = followed[row]
        key = drawn[0].layer.casefold()
        points = [point for marked, point in marks if marked.casefold() == key]
        beside = [one for one in texts if one.layer.casefold() == key]
        shaped = shaper.shaped(row, np.reshape(points, (-1, 3)))
        findings += shaper.findings
        shaper.findings.clear()
        made, named, found, numbers = _layer_procedure(
            name, drawn, shaped, layer, process, names, beside,
            nesting=nestings[row], contour_names=contour_names, before=before,
        )  # fmt: skip
        order += [left[row][k] for k in numbers]
        if made:
            before = layer
            worked.append(layer)
        procedures += made
        called += made[:1]
        targets |= named
        findings += found
    taken.update(names)
    findings += _without_contours(process.layers, [*dict.fromkeys(one.layer for one in curves)])
    found_within = tuple(f.within(path) for f in findings)
    return ContourProgram(
        tuple(procedures),
        tuple(called),
        targets,
        found_within,
        choice,
        tuple(order),
        tuple(signal_statements(_values_at_rest(worked))),
    )


def contour_choice(
    curves: Sequence[Curve],
    process: Process,
    marks: Sequence[tuple[str, Vector]] = (),
    texts: Sequence[LayerText] = (),
) -> ContourChoice:
    """The choice of contours alone, for drawings of which the program takes long; see
    `contour_program`.
    """
    return _chosen(curves, process, TakenNames(()), marks, texts)[2]


def _values_at_rest(layers: Sequence[Layer]) -> Iterator[tuple[str, float]]:
    """Outputs that layers switch on and off again, with the value that is off for all of them.

    A program that was stopped on a contour has left them on.
    """
    off: dict[str, set[float]] = {}
    for layer in layers:
        switched = {signal for signal, _ in layer.on}
        for signal, value in layer.off:
            if signal in switched:
                off.setdefault(signal, set()).add(value)
    return ((signal, values.pop()) for signal, values in off.items() if len(values) == 1)


_Followed = tuple[str, Layer, Sequence[Contour]]
"""The procedure of a layer, its process, and its contours."""


def _chosen(
    curves: Sequence[Curve],
    process: Process,
    names: TakenNames,
    marks: Sequence[tuple[str, Vector]],
    texts: Sequence[LayerText],
) -> tuple[list[_Followed], list[Diagnostic], ContourChoice]:
    """The layers that are followed with all contours, findings, and which of them are left out.

    names: those of the procedures are added.
    """
    taken = set(names)
    layers: dict[str, list[Curve]] = {}
    for curve in curves:
        layers.setdefault(curve.layer.casefold(), []).append(curve)
    known = {name.casefold(): layer for name, layer in process.layers.items()}
    defaults = process.defaults
    rounded = defaults.blend is None
    usual = Layer("contours", defaults.motion, rounded=rounded, travel=defaults.travel)
    usual_layer = None if known else usual
    findings: list[Diagnostic] = []
    followed: list[_Followed] = []
    for key, group in layers.items():
        unwanted = process.leaves_out(key)
        layer = known.get(key, None if unwanted else usual_layer)
        if layer is None:
            if not unwanted:
                given = group[0].layer
                key_shown = json.dumps(shown(given), ensure_ascii=False)
                findings.append(
                    _NOT_USED_ON_LAYER(
                        what=_curves_in_words(group), layer=shown(given), key=key_shown
                    )
                )
            continue
        name = _procedure_name(group[0].layer, names)
        names.add(name)
        single, overlapping = without_overlaps(group, process.tolerance)
        contours, chained = chain_curves(single, process.tolerance)
        findings += (*overlapping, *chained, *wide_gaps(contours, process.tolerance))
        if contours:
            direction = process.placed(layer.direction)
            followed.append((name, replace(layer, direction=direction), contours))

    def numbered() -> Sequence[Row]:
        """Rows of the program as it is without the entries that have a number."""
        others = tuple(one for one in process.left_out if one.number is None)
        without = replace(process, left_out=others)
        made = contour_program(curves, without, taken=set(taken), marks=marks, texts=texts)
        return made.order

    choice = ContourChoice.of([contours for *_, contours in followed], process, numbered)
    return followed, findings, choice


def _procedure_name(layer: str, taken: TakenNames) -> str:
    """Return the name of the procedure; a signal often has the name of its layer, and takes
    precedence.
    """
    name = _layer_identifier(layer)
    free = identifier(name, taken) == name
    return name if free else identifier(f"{name}{CONTOURS_SUFFIX}", taken)


def _layer_identifier(layer: str) -> str:
    """Return the name of a layer in letters; one that begins with a digit is `layer_0`."""
    first = next((c for c in plain_letters(layer) if c.isalnum()), "")
    return identifier(f"layer {layer}" if first.isdigit() else layer)


def _curves_in_words(curves: Sequence[Curve]) -> str:
    """`3 lines, 1 arc`."""
    kinds = Counter(
        "line" if isinstance(c, Line) else "arc" if isinstance(c, Arc) else "free curve"
        for c in curves
    )
    return ", ".join(f"{n} {kind}{'s' if n > 1 else ''}" for kind, n in kinds.items())


def _without_contours(layers: Mapping[str, Layer], drawn: list[str]) -> list[Diagnostic]:
    there = {name.casefold() for name in drawn}
    findings = []
    for name in layers:
        if name.casefold() not in there:
            near = near_name(name, drawn)
            cure = f"did you mean {shown(near)}?" if near else "draw some, or delete its table"
            findings.append(_NO_CONTOURS(layer=shown(name), cure=cure))
    return findings


def _layer_procedure(
    named: str,
    drawn: Sequence[Contour],
    shaped: Sequence[ShapedContour | None],
    layer: Layer,
    process: Process,
    taken: TakenNames,
    texts: Sequence[LayerText],
    *,
    nesting: GroupNesting,
    contour_names: _ContourNames,
    before: Layer | None,
) -> tuple[list[Procedure], dict[str, Target], list[Diagnostic], list[int]]:
    """The procedure of that name along the contours of one layer and those of the contours, none
    if nothing is left.

    shaped: what the contours have become. nesting: of `drawn`. before: the layer that comes before
    it. With the procedures come the targets that they name, the findings, and the places in `drawn`
    of what they follow, in their order.
    """
    name, findings = drawn[0].layer, list[Diagnostic]()
    placed = PlacedLayer.of(name, layer, process)
    if isinstance(placed, Diagnostic):
        return [], {}, [placed], []
    kept = [one for one in shaped if one is not None]
    contours = [one.main for one in kept]
    if not contours:
        return [], {}, findings, []
    around = _remaining_holders(nesting.holders if layer.inside_first else [], shaped)
    if layer.order == "travel":
        standing = FramedSurroundings.of(process, layer.motion)
        measure = travel_measure(layer, placed, standing) if process.defaults.travels else None
        order = order_contours(contours, around, measure)
    else:
        left = [one for one, became in zip(drawn, shaped, strict=True) if became is not None]
        order, said = stated_order(contours, left, around, layer.order, texts)
        findings += said
    # An open contour is described as it is run: that may be against the way it is drawn.
    back = {one.number for one in order.contours if one.backwards}
    run = [one.reversed() if k in back else one for k, one in enumerate(drawn)]
    shapes = contour_shapes(run, nesting, layer.direction, process.placement, process.tolerance)
    if len(contours) > 1 and layer.order == "travel":
        inside = ", with those inside others first" if any(i >= 0 for i in around) else ""
        findings.append(
            (_TRAVEL_TIME_SAVED if order.measured else _TRAVEL_LENGTH_SAVED)(
                layer=shown(name),
                count=len(contours),
                before=order.before,
                after=order.after,
                inside=inside,
            )
        )
    if named != name:
        plain = _layer_identifier(name)
        findings.append(renamed(name, named, plain, place=f"layer {shown(name)}"))
    targets: dict[str, Target] = {}
    parts: dict[str, list[Statement]] = {}
    widest = _WIDEST_TURN if layer.tangential else WIDEST_ARC
    deviation, fitted, count = 0.0, sum(one.fitted for one in kept), 0
    thinned, dropped = 0.0, sum(one.dropped for one in kept)
    wound = 0.0 if before is not None and _is_reached_by_lines(before, layer) else None
    top = highest_point(drawn, placed) if layer.above.height is not None else 0.0
    corners = stops = 0
    turns: list[tuple[str, Floats]] = []
    numbers: list[int] = []
    of_number = {
        one.main.number: (one, shape)
        for one, shape in zip(shaped, shapes, strict=True)
        if one is not None
    }
    last = order.contours[-1]
    for main in order.contours:
        one, shape = of_number[main.number]
        ways = [*one.ways(main, layer.shaping)]
        called, body = "", list[Statement]()
        for at, way in enumerate(ways):
            rows = contour_moves(way.contour, process.tolerance, widest=widest, spent=one.deviation)
            handle = next((c.handle for c in way.contour.curves if c.handle), "")
            place = f"entity {handle}" if handle else None
            if not rows.within:
                findings.append(
                    _CURVE_NOT_FITTED(place=place, layer=shown(name), tolerance=process.tolerance)
                )
            elif not len(rows):
                findings.append(
                    _TOO_SMALL(place=place, layer=shown(name), tolerance=process.tolerance)
                )
            else:
                count += 1
                stops += len(rows) - 1
                numbers.append(main.number)
                deviation, fitted = max(deviation, rows.deviation), fitted + rows.fitted
                if one.dropped or rows.dropped:
                    thinned, dropped = max(thinned, rows.deviation), dropped + rows.dropped
                if not called:
                    called = contour_names.of(name, shape)
                    parts[called] = body = [*_described(shape, name)]
                path_name = called
                if len(ways) > 1:
                    path_name = f"{called}_pass_{at + 1}"
                    taken.add(path_name)
                    body.append(Comment(_pass_text(at, ways)))
                # Without a home the program ends above the last contour.
                stays = process.home is None and main is last and at == len(ways) - 1
                made = follow_contour(
                    path_name, rows, way.lower(layer), placed, wound, process, taken, top,
                    drawn_on=name, stays=stays,
                )  # fmt: skip
                body += made.statements
                corners += made.corners
                turns += ((path_name, at_corner) for at_corner in made.turns)
                findings += made.findings
                targets |= made.targets
                taken.update(made.targets)
                wound = made.wound
    if fitted:
        findings.append(_CURVES_FITTED(layer=shown(name), count=fitted, deviation=deviation))
    if dropped:
        findings.append(_POINTS_LEFT_OUT(layer=shown(name), count=dropped, deviation=thinned))
    if turns and layer.tangential and layer.on:
        path_name, first = turns[0]
        where = ", ".join(f"{x + 0.0:g}" for x in first.round(3).tolist())
        findings.append(
            _TURNS_SWITCHED_ON(layer=shown(name), count=len(turns), at=where, contour=path_name)
        )
    if stops and layer.on and layer.motion.blend == FINE and not (layer.rounded or layer.own_blend):
        findings.append(_STOPS_SWITCHED_ON(layer=shown(name), count=stops))
    if count and (slow := layer.pace.corner) is not None:
        about: dict[str, Any] = {
            "layer": shown(name),
            "angle": layer.pace.angle,
            "radius": layer.pace.radius,
        }
        findings.append(
            _SLOW_CORNERS(count=corners, speed=slow.tcp, **about)
            if corners
            else _NO_SLOW_CORNER(**about)
        )
    title = f"layer {name}" if layer.process == shown(name) else f"{layer.process}: layer {name}"
    procedures = _procedures(named, _printable_line(title), parts, process.style)
    return (procedures if count else []), targets, findings, numbers


def _procedures(
    named: str, title: str, parts: Mapping[str, Sequence[Statement]], style: ProgramStyle
) -> list[Procedure]:
    """Return the procedure of a layer and those of its contours in a style.

    title: of the layer. parts: statements of each contour by its name, with comments.
    """
    if not style.commented:
        parts = {
            name: [one for one in body if not isinstance(one, Comment)]
            for name, body in parts.items()
        }
    above = [Comment(title)] if style.commented else []
    # A single contour needs no procedure below that of its layer.
    if style.procedures in (None, "contour") and len(parts) > 1:
        calls = [Call(name) for name in parts]
        return [
            Procedure(named, (*above, *calls)),
            *(Procedure(name, tuple(body)) for name, body in parts.items()),
        ]
    return [Procedure(named, (*above, *(one for body in parts.values() for one in body)))]


def _described(shape: ContourShape, layer: str) -> Iterator[Statement]:
    """The comment that says what a contour is."""
    # Without a word the name would read as one of the sizes: `0, 44.4 mm`, `Ø6.6, 44.4 mm`.
    named = layer if _WORD.search(layer) else f"layer {layer}"
    yield Comment(_printable_line(shape.text if shape.kind else f"{named}, {shape.text}"))


def _pass_text(at: int, ways: Sequence[ToolPath]) -> str:
    depth = f", {number_text(ways[at].below)} mm deep" if ways[at].below else ""
    return f"pass {at + 1} of {len(ways)}{depth}"


def _remaining_holders(around: Sequence[int], shaped: Sequence[ShapedContour | None]) -> list[int]:
    """Return the holder of each remaining contour, by rows of the remaining contours."""
    rows = [i for i, one in enumerate(shaped) if one is not None]
    number = {row: i for i, row in enumerate(rows)}

    def holder(row: int) -> int:
        # A holder that is left out is replaced by the next one around it.
        while (row := around[row]) != NO_HOLDER:
            if row in number:
                return number[row]
        return NO_HOLDER

    return [holder(row) for row in rows] if around else []


def _is_reached_by_lines(before: Layer, layer: Layer) -> bool:
    """True if the tool moves from one layer to the next as it does within them.

    A joint move needs room above the work.
    """
    raised = before.retract > 0.0 or before.above.height is not None
    return layer.above.kind == "linear" or not (raised and layer.approach > 0.0)


def _shortened(name: str, longest: int) -> str:
    """The start of a name, with the last number in it: that may be all that tells layers apart.

    A number that takes more than half the room is left out.
    """
    start = name[:longest].rstrip("_")
    *_, number = [None, *_NUMBER_IN_NAME.finditer(name)]
    if number is None or number.end() <= longest or len(number[0]) > longest // 2:
        return start
    return f"{name[: longest - len(number[0]) - 1].rstrip('_')}_{number[0]}"


def _path_name_stem(layer: str, taken: TakenNames) -> str:
    """Start of the layer's path names, so that no path or row has the name of another thing.

    Row k of path n is called stem_n_k, so `glue` and `glue_1` must not both be stems.
    """
    base = _shortened(identifier(layer).lower(), _LONGEST_NAME_STEM)
    candidate, counted = base, ("stem", base)
    if candidate in taken.stems:
        # From the last number on, as many layers may share a stem.
        count = taken.counts.get(counted, 2)
        # Without underscores: `glue_2` could be a row of `glue`. Digits of the name stay apart.
        compact = base.replace("_", "")
        compact += "n" if compact[-1].isdigit() else ""
        while (candidate := f"{compact}{count}") in taken.stems:
            count += 1
        taken.counts[counted] = count
    return candidate


def _printable_line(text: str) -> OwnText:
    """One printable line of a comment."""
    return OwnText(" ".join("".join(c if c.isprintable() else " " for c in text).split()))
