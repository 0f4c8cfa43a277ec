"""Pseudo-program of a drawing: names of its locations, their order, and its procedures.

`main` switches off what contours switch on, visits the locations, then follows the contours; the
motion starts and ends at `home` if the process file states one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant.base.budgets import AROUND, CONTOURS, within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, has_errors
from assistant.program.expressions import Name
from assistant.program.geometry import JointTarget, Pose, Target
from assistant.program.motion import FINE
from assistant.program.program import MANGLED, Procedure, Program, TakenNames, identifier, renamed
from assistant.program.statements import Call, MoveJoints, OwnText, Statement, Travel
from assistant.sources.contours.contour_order import TravelMeasure, order_points
from assistant.sources.contours.contour_statements import (
    FramedSurroundings,
    approach_of,
    backed_off_target,
    move_to,
)
from assistant.sources.contours.layer_program import contour_program
from assistant.sources.drawing.contents import Contents
from assistant.sources.drawing.findings import (
    DRAFTING,
    DUPLICATE,
    EMPTY,
    NO_PROCEDURE_LEFT,
    NOT_MEASURED,
    ONLY_DRAFTING,
    QUICKEST,
    SAME_ORDER,
    SOME_ORDERED,
    shown,
)
from assistant.sources.drawing.locations import Location
from assistant.sources.process import NO_PROCESS, Process, travel_seconds
from assistant.sources.reading import Reading

_MAIN_PROCEDURE: Final = "main"
_HOME_TARGET: Final = "home"
_LOCATIONS_PROCEDURE: Final = "locations"
"""Name of the procedure that visits the locations."""
_OFF_PROCEDURE: Final = "outputs_off"
"""Name of the procedure that switches off what contours switch on, before the first motion."""


def drawing_program(contents: Contents, path: FilePath, process: Process) -> Reading:
    """The program of a drawing: `main` visits the locations, then follows the contours.

    Raises Refused if there is nothing to do, or something in it is wrong.
    """
    name = str(path)
    title = identifier(path.stem)
    taken = TakenNames((title, _MAIN_PROCEDURE, _LOCATIONS_PROCEDURE, _OFF_PROCEDURE))
    taken.update(process.tools, process.frames, process.signals)
    named = name_locations(contents.locations, taken, name)
    taken.update(named.names)
    home = identifier(_HOME_TARGET, taken) if process.home is not None else None
    taken.update([home] if home else [])
    places = len(contents.curves) + len(contents.locations)
    with within(CONTOURS if process.around is None else AROUND, name, places):
        curves = contents.curves
        made = contour_program(
            curves, process, taken=taken, path=name, marks=contents.marks, texts=contents.texts
        )
        order = _visiting_order(contents.locations, name, process)
        visits, visited = _visit_procedure(contents.locations, named.names, order.rows, process)
    arriving = (finding.within(name) for finding in visited)
    findings = [*contents.findings, *named.findings, *order.findings, *made.findings, *arriving]
    alone = process.style.procedures == "none"
    if alone and process.interface is not None and not process.interface.main:
        findings.append(NO_PROCEDURE_LEFT(path=name))
    if process.assumed:
        findings.append(NOT_MEASURED(path=name, what=", ".join(process.assumed)))
    if title != path.stem:
        findings.append(MANGLED(path=name, place="file name", given=shown(path.stem), name=title))
    if not made.procedures and not contents.locations and not has_errors(findings):
        drafting = contents.drafting
        if drafting is not None and drafting.aside:
            findings = [one for one in findings if one.code != DRAFTING.code]
            what, cure = drafting.listed(), drafting.cure()
            findings.append(ONLY_DRAFTING(path=name, what=what, cure=cure))
        else:
            findings.append(EMPTY(path=name))
    if has_errors(findings):
        raise Refused(*findings)
    called, procedures = [*visits, *made.called], [*visits, *made.procedures]
    off = made.at_rest
    if alone:
        work = tuple(one for procedure in called for one in procedure.body)
        procedures = []
    else:
        work = tuple(Call(procedure.name) for procedure in called)
        if off:
            # `main` stays a list of calls, which others can make in its place.
            procedures.append(Procedure(_OFF_PROCEDURE, off))
            off = (Call(_OFF_PROCEDURE),)
    program = Program(
        title,
        (Procedure(_MAIN_PROCEDURE, (*off, *_between_homes(home, work, process))), *procedures),
        entry=_MAIN_PROCEDURE,
        robot=process.robot,
        comments=tuple(map(OwnText, _facts(contents, path, process))),
        frames=dict(process.frames),
        tools=dict(process.tools),
        signals=dict(process.signals),
        targets={
            n: Target(location.pose)
            for n, location in zip(named.names, contents.locations, strict=True)
        }
        | dict(made.targets),
        joint_targets={home: JointTarget(process.home)} if home and process.home else {},
        placed=process.placement is not None,
    )
    return Reading(program, tuple(findings))


def _facts(contents: Contents, path: FilePath, process: Process) -> Iterator[str]:
    """Lines above the program, about what it was made from."""
    saved = f", saved {contents.saved.isoformat()}" if contents.saved else ""
    yield f"drawing {shown(path.name)}, in {contents.unit}{saved}"
    motions = dict.fromkeys(one.motion for one in contents.locations)
    motions |= dict.fromkeys(one.motion for one in process.layers.values())
    used = list(motions) or [process.defaults.motion]
    tools, frames = (
        list(dict.fromkeys(names))
        for names in ([one.tool for one in used], [one.frame for one in used])
    )
    yield f"tool {', '.join(tools)}, frame {', '.join(frames)}"
    if process.assumed:
        yield f"ASSUMED, to be measured before the arm moves: {', '.join(process.assumed)}"
    if contents.curves:
        yield f"contours within {process.tolerance:g} mm; their sizes and positions as drawn, in mm"


def _between_homes(
    home: str | None, work: tuple[Statement, ...], process: Process
) -> tuple[Statement, ...]:
    """The work between two moves to home, if there is a home."""
    if home is None:
        return work
    motion = replace(process.defaults.motion, blend=FINE)
    way = Travel if process.defaults.travels else MoveJoints
    return (way(Name(home), motion), *work, way(Name(home), motion))


def _visit_procedure(
    locations: Sequence[Location], names: Sequence[str], rows: Sequence[int], process: Process
) -> tuple[list[Procedure], list[Diagnostic]]:
    """Return the procedure through the locations, empty if the drawing has no locations, and
    findings.

    The first location is not approached in a line from an unknown position, unless it states a
    line.
    """
    statements: list[Statement] = []
    findings: list[Diagnostic] = []
    usual = process.defaults
    for place, i in enumerate(rows):
        location, name = locations[i], names[i]
        first = usual.kind if usual.travels else "joint"
        kind = location.kind or (usual.kind if place else first)
        standing = FramedSurroundings.of(process, location.motion)
        into = approach_of(standing, location.pose, usual.approach, name)
        out = into
        if usual.retract != usual.approach:
            out = approach_of(standing, location.pose, usual.retract, name)
        findings += dict.fromkeys((*into.findings, *out.findings))
        stopping = replace(location.motion, blend=FINE)
        if usual.approach:
            statements.append(
                move_to(kind, backed_off_target(name, usual.approach, into), stopping)
            )
        at = stopping if usual.retract else location.motion  # no corner where the way turns back
        statements.append(move_to("linear" if usual.approach else kind, Name(name), at))
        if usual.retract:
            statements.append(
                move_to("linear", backed_off_target(name, usual.retract, out), stopping)
            )
    return ([Procedure(_LOCATIONS_PROCEDURE, tuple(statements))] if statements else []), findings


@dataclass(frozen=True, slots=True)
class LocationNames:
    """A name for each location, in order of drawing."""

    names: tuple[str, ...]
    findings: tuple[Diagnostic, ...]


def name_locations(
    locations: Sequence[Location], taken: Collection[str], path: str
) -> LocationNames:
    """Unique names of the locations, near to those that were drawn.

    Names that were given come first, so that a counted one never takes one of them.
    """
    used = TakenNames(t.lower() for t in taken)
    names: dict[int, str] = {}
    findings: list[Diagnostic] = []
    drawn: set[str] = set()
    for i, location in enumerate(locations):
        if not location.given:
            continue
        name = names[i] = identifier(location.given, used)
        given = shown(location.given)
        if location.given.lower() in drawn:
            findings.append(DUPLICATE(path=path, place=location.place, given=given, name=name))
        elif name != location.given:
            findings.append(renamed(location.given, name, path=path, place=location.place))
        drawn.add(location.given.lower())
        used.add(name.lower())
    counts: Counter[str] = Counter()
    stems: dict[str, str] = {}
    for i, location in enumerate(locations):
        if location.given:
            continue
        if location.stem not in stems:
            stems[location.stem] = stem = identifier(location.stem)
            if stem != location.stem:
                given = shown(location.stem)
                findings.append(MANGLED(path=path, place=location.place, given=given, name=stem))
        stem = stems[location.stem]
        while True:
            counts[stem.lower()] += 1
            name = f"{stem}_{counts[stem.lower()]}"
            if name.lower() not in used:
                break
        names[i] = name
        used.add(name.lower())
    return LocationNames(tuple(names[i] for i in range(len(locations))), tuple(findings))


@dataclass(frozen=True, slots=True)
class _LocationOrder:
    """Rows of locations in the order of visiting."""

    rows: tuple[int, ...]
    findings: tuple[Diagnostic, ...]


def _visiting_order(
    locations: Sequence[Location], path: str, process: Process = NO_PROCESS
) -> _LocationOrder:
    """Order locations by the order that they state, as drawn if it is equal; the others follow.

    If motions are planned and no location states an order or another motion, the order with the
    shortest travel is used.
    """
    free = all(entry.order is None and entry.kind in (None, "travel") for entry in locations)
    if process.defaults.travels and free:
        return _quickest_order(locations, path, process)
    stated = [(order, i) for i, entry in enumerate(locations) if (order := entry.order) is not None]
    rest = [i for i, entry in enumerate(locations) if entry.order is None]
    findings = []
    if stated and rest:
        findings.append(SOME_ORDERED(path=path, ordered=len(stated), rest=len(rest)))
    seen: set[float] = set()
    for order, i in sorted(stated):
        if order in seen:
            place = locations[i].place
            findings.append(SAME_ORDER(path=path, place=place, order=f"{order:g}"))
        seen.add(order)
    return _LocationOrder((*(i for _, i in sorted(stated)), *rest), tuple(findings))


def _quickest_order(locations: Sequence[Location], path: str, process: Process) -> _LocationOrder:
    """By joint moves between places above them; as drawn where those are not known."""
    drawn = _LocationOrder(tuple(range(len(locations))), ())
    motions = {(one.motion.frame, one.motion.tool) for one in locations}
    standing = FramedSurroundings.of(process, locations[0].motion) if len(motions) == 1 else None
    if standing is None or len(locations) < 2:
        return drawn
    up = Pose((0.0, 0.0, -process.defaults.approach))
    above = [one.pose @ up for one in locations]
    positions = np.array([pose.position for pose in above])
    turns = np.array([pose.quaternion for pose in above])
    found = order_points(
        positions, TravelMeasure(lambda points: standing.places(points, turns), travel_seconds)
    )
    if not found.measured:
        return drawn
    said = QUICKEST(path=path, count=len(above), before=found.before, after=found.after)
    return _LocationOrder(found.rows, (said,))
