"""What a page shows, as plain data: surfaces, arms, the motion over time, and what was found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from assistant.cell.clearances import Closeness
from assistant.cell.collision.carriers import Carriers, carried
from assistant.cell.scene import CORE, Body, Placed, Scene
from assistant.cell.surfaces import surface_of
from assistant.compiler.source_map import Places
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.program.visible import visible
from assistant.report.drawn import Line
from assistant.report.track import track
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing import Simulation
from assistant.view.motion import Motion, Record, column, tips, tool_held
from assistant.view.moves import MOST_MOVES, Moves
from assistant.view.riding import Ride, rides
from assistant.view.zones import zones

MOST_NAMES: Final = 300
"""Targets that are shown, and that have their names beside them."""
MOST_ZONES: Final = 5_000
MOST_FINDINGS: Final = 500
MOST_DRAWN: Final = 200_000
"""Points of the lines of a drawing."""
LINK: Final = (232, 140, 60)
OTHER_LINK: Final = (222, 200, 170)
"""Of a robot that stands at home."""
TOOL: Final = (90, 100, 112)
BODY: Final = (138, 150, 164)

Marked = tuple[Diagnostic, Closeness | None]
"""A finding, and where in the scene it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What is to be seen.

    solution: of the program, simulated on `placed`, one of the robots of the scene; the others
    stand at home. places: of the program's texts. findings: in the order of the list. drawn: lines
    of its drawing. live: the name of the controller that the page follows, None for none.
    """

    title: str
    solution: SolvedProgram
    simulation: Simulation
    scene: Scene
    placed: Placed
    places: Places
    findings: Sequence[Marked] = ()
    drawn: Sequence[Line] = ()
    live: str | None = None


def record(shown: Shown) -> Record:
    """The data of a page; columns of numbers as text, see `column`.

    Lengths are mm and angles radians there, poses seven numbers: position, then quaternion w, x, y,
    z. Raises Refused for a body whose parent the scene has not.
    """
    carriers = Carriers(shown.scene.robots)
    motion = Motion(shown.simulation, shown.placed)
    names = list(_targets(shown))
    moves = Moves(shown.solution, shown.simulation, shown.places, motion.until)
    found = [_finding(shown, motion, moves, marked) for marked in shown.findings[:MOST_FINDINGS]]
    around = (
        zones(shown.simulation, shown.placed, motion.until) if tool_held(shown.simulation) else None
    )
    texts, lines_left = moves.lines()
    drawn, drawn_left = _drawn(shown)
    riding = rides(shown.simulation, shown.scene, motion.until)
    return {
        "title": visible(shown.title),
        "robot": visible(shown.placed.robot.title),
        "live": None if shown.live is None else visible(shown.live),
        "robots": [_arm(one, one is shown.placed) for one in shown.scene.robots],
        "bodies": [
            _body(shown, body, carriers, riding) for body in shown.scene.all_bodies() if body.shown
        ],
        "motion": motion.record(),
        "tips": [_pose(tip) for tip in tips(shown.simulation)],
        "targets": names[:MOST_NAMES],
        "zones": column(np.zeros((0, 4)) if around is None else around[:MOST_ZONES]),
        "drawn": drawn,
        "moves": moves.records(),
        "played": moves.played(),
        "texts": texts,
        "findings": found,
        "left": {
            "targets": max(0, len(names) - MOST_NAMES),
            "findings": max(0, len(shown.findings) - MOST_FINDINGS),
            "moves": max(0, len(moves) - MOST_MOVES),
            "zones": 0 if around is None else max(0, len(around) - MOST_ZONES),
            "lines": lines_left,
            "drawn": drawn_left,
        },
    }


def _arm(placed: Placed, moves: bool) -> Record:
    """Its chain: the page poses its links by itself."""
    chain = placed.robot.arm.whole_chain
    home = placed.robot.chained(np.array([placed.robot.home]))[0]
    return {
        "name": visible(placed.name),
        "base": _pose(placed.base),
        "joints": [
            {"pose": _pose(joint.pose), "axis": list(joint.axis), "sliding": joint.sliding}
            for joint in chain.joints
        ],
        "flange": _pose(chain.flange),
        "home": home.tolist(),
        "moves": moves,
    }


def _body(
    shown: Shown,
    body: Body,
    carriers: Carriers,
    riding: Mapping[str, Sequence[tuple[float, Ride]]],
) -> Record:
    """A body in its own frame, and what it rides on; `rides` where that changes."""
    carrier, pose = carried(shown.scene, body, carriers)
    own = any(body is one for one in shown.placed.links)
    link = own or any(body is one for placed in shown.scene.robots for one in placed.links)
    usual = LINK if own else OTHER_LINK if link else TOOL if carrier else BODY
    colour = body.colour or usual
    parts = []
    for part in body.parts:
        seen = surface_of(part)
        parts.append(
            {
                "points": column(seen.points),
                "triangles": column(seen.triangles),
                "flat": seen.flat,
            }
        )
    rode = () if link else riding.get(body.name, ())
    return {
        "name": visible(body.name),
        "carrier": carrier,
        "pose": _pose(pose),
        "rides": [_ride(time, ride) for time, ride in rode],
        "colour": "#{:02x}{:02x}{:02x}".format(*colour),
        "link": link,
        "parts": parts,
        "locations": [
            {"name": visible(name), "pose": _pose(one)} for name, one in body.locations.items()
        ],
    }


def _ride(time: float, ride: Ride) -> Record:
    carrier, pose = (None, None) if ride is None else (ride[0], _pose(ride[1]))
    return {"time": time, "carrier": carrier, "pose": pose}


def _targets(shown: Shown) -> Iterator[Record]:
    """Named targets of the program, each place once."""
    way = track(shown.solution.program)
    seen = set[tuple[object, ...]]()
    for row, name in way.names.items():
        pose = shown.placed.base @ Pose.of(way.positions[row], way.quaternions[row])
        key = (name, *(round(value, 3) for value in pose.position))
        if key not in seen:
            seen.add(key)
            yield {"name": visible(name), "pose": _pose(pose)}


def _drawn(shown: Shown) -> tuple[list[Record], int]:
    """The lines of the drawing in the world, and how many are left out."""
    found: list[Record] = []
    base, room = shown.placed.base, MOST_DRAWN
    for number, line in enumerate(shown.drawn):
        room -= len(line.points)
        if room < 0:
            return found, len(shown.drawn) - number
        found.append({"layer": visible(line.layer), "points": column(base.moved(line.points))})
    return found, 0


def _finding(shown: Shown, motion: Motion, moves: Moves, marked: Marked) -> Record:
    finding, close = marked
    finding = shown.places.finding(finding)
    mark: Record | None = None
    move = moves.of_finding(finding if close is None else marked[0])
    if close is not None:
        contact = close.contact
        at = _own(shown, close.joints)
        mark = {
            "one": visible(contact.one.removesuffix(CORE)),
            "other": visible(contact.other.removesuffix(CORE)),
            "points": [list(point) for point in contact.points],
            "normal": list(contact.normal),
            "deep": max(0.0, -min(close.least, contact.distance)),
            "joints": motion.robot.chained(at[None])[0].tolist(),
            "time": motion.when(at),
        }
        move = moves.places.get((close.procedure, close.number))
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": visible(finding.message),
        "cure": None if finding.cure is None else visible(finding.cure),
        "where": visible(finding.where()),
        "move": move if move is not None and move < MOST_MOVES else None,
        "mark": mark,
    }


def _own(shown: Shown, joints: Floats) -> Floats:
    """Of a row of the joints of all robots those of the one that moves."""
    carriers = Carriers(shown.scene.robots)
    at = next(i for i, one in enumerate(shown.scene.robots) if one is shown.placed)
    return joints[carriers.columns[at]]


def _pose(pose: Pose) -> list[float]:
    return [*map(float, pose.position), *map(float, pose.quaternion)]
