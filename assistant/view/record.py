"""What a page shows, as plain data: surfaces, arms, the motion over time, and what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from assistant.base.source_text import visible
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.scene import Body, PlacedRobot, part_surface
from assistant.program.geometry import Pose
from assistant.program.program import Program
from assistant.report.timing import statements
from assistant.report.track import track
from assistant.view.found import MOST_FINDINGS, finding_records
from assistant.view.motion import Motion, Record, column_text, tool_held, tool_tips
from assistant.view.moves import MOST_MOVES, Moves
from assistant.view.riding import Ride, rides_of
from assistant.view.shown import Shown
from assistant.view.still import StillMotion, StillMoves, path_record
from assistant.view.times import procedure_times
from assistant.view.zones import zones_of

MOST_NAMES: Final = 300
"""Targets that are shown, and that have their names beside them."""
MOST_ZONES: Final = 5_000
MOST_DRAWN: Final = 200_000
"""Points of the lines of a drawing."""
LINK_COLOUR: Final = (232, 140, 60)
IDLE_LINK_COLOUR: Final = (222, 200, 170)
"""Of a robot that stands at home."""
TOOL_COLOUR: Final = (90, 100, 112)
BODY_COLOUR: Final = (138, 150, 164)


def page_record(shown: Shown) -> Record:
    """The data of a page; columns of numbers as text, see `column`.

    Lengths are mm and angles radians there, poses seven numbers: position, then quaternion w, x, y,
    z. Raises Refused for a body whose parent the scene has not.
    """
    data = _moving_record(shown) if shown.simulation is not None else _still_record(shown)
    carriers = Carriers(shown.scene.robots)
    drawn, drawn_left = _drawn_record(shown)
    targets = data.pop("targets")
    riding = data.pop("riding")
    return data | {
        "title": visible(shown.title),
        "notes": list(map(visible, shown.notes)),
        "robot": "" if shown.placed is None else visible(shown.placed.robot.title),
        "live": None if shown.live is None else visible(shown.live),
        "plan": shown.plan,
        "robots": [_arm_record(one, one is shown.placed) for one in shown.scene.robots],
        "bodies": [
            _body_record(shown, body, carriers, riding)
            for body in shown.scene.all_bodies()
            if body.shown
        ],
        "targets": targets[:MOST_NAMES],
        "drawn": drawn,
        "beside": None if shown.beside is None else shown.beside.record(),
        "left": data["left"]
        | {
            "targets": max(0, len(targets) - MOST_NAMES),
            "findings": max(0, len(shown.findings) - MOST_FINDINGS),
            "drawn": drawn_left,
        },
    }


def _moving_record(shown: Shown) -> Record:
    """Of a program that an arm goes through."""
    solution, simulation, placed = shown.solution, shown.simulation, shown.placed
    assert solution is not None and simulation is not None and placed is not None
    motion = Motion(simulation, placed)
    moves = Moves(solution, simulation, shown.places, motion.until)
    around = zones_of(simulation, placed, motion.until) if tool_held(simulation) else None
    every = statements(simulation)
    timed = {(one.procedure, one.number): one for one in every}
    listed = moves.records()
    for key, one in zip(moves.keys, listed, strict=False):
        found = timed.get(key)
        one["length"], one["seconds"], one["bound"] = (
            (None, None, "") if found is None else (found.length, found.seconds, found.bound)
        )
    texts, lines_left = moves.lines()
    return {
        "motion": motion.record(),
        "still": None,
        "times": procedure_times(simulation, every),
        "tips": [_pose_record(tip) for tip in tool_tips(simulation)],
        "targets": _target_records(solution.program, placed.base),
        "riding": rides_of(simulation, shown.scene, motion.until),
        "zones": column_text(np.zeros((0, 4)) if around is None else around[:MOST_ZONES]),
        "moves": listed,
        "played": moves.played(),
        "texts": texts,
        "findings": finding_records(shown, motion, moves, solution.program),
        "left": {
            "moves": max(0, len(moves) - MOST_MOVES),
            "zones": 0 if around is None else max(0, len(around) - MOST_ZONES),
            "lines": lines_left,
        },
    }


def _still_record(shown: Shown) -> Record:
    """Of a program that is only drawn."""
    program = shown.program or Program("nothing")
    motion, moves = StillMotion(), StillMoves(program, shown.places)
    texts, lines_left = moves.lines()
    still = path_record(program, shown.base)
    return {
        "motion": motion.record(),
        "still": still,
        "times": None,
        "tips": [],
        "targets": _target_records(program, shown.base),
        "riding": {},
        "zones": column_text(np.zeros((0, 4))),
        "moves": moves.records(),
        "played": moves.played(),
        "texts": texts,
        "findings": finding_records(shown, motion, moves, program),
        "left": {"moves": max(0, len(moves) - MOST_MOVES), "zones": 0, "lines": lines_left},
    }


def _arm_record(placed: PlacedRobot, moves: bool) -> Record:
    """Its chain: the page poses its links by itself."""
    chain = placed.robot.arm.whole_chain
    home = placed.robot.chained(np.array([placed.robot.home]))[0]
    return {
        "name": visible(placed.name),
        "base": _pose_record(placed.base),
        "joints": [
            {"pose": _pose_record(joint.pose), "axis": list(joint.axis), "sliding": joint.sliding}
            for joint in chain.joints
        ],
        "flange": _pose_record(chain.flange),
        "home": home.tolist(),
        "moves": moves,
    }


def _body_record(
    shown: Shown,
    body: Body,
    carriers: Carriers,
    riding: Mapping[str, Sequence[tuple[float, Ride]]],
) -> Record:
    """A body in its own frame, and what it rides on; `rides` where that changes."""
    carrier, pose = carrier_of(shown.scene, body, carriers)
    own = shown.placed is not None and any(body is one for one in shown.placed.links)
    link = own or any(body is one for placed in shown.scene.robots for one in placed.links)
    usual = (
        LINK_COLOUR
        if own
        else IDLE_LINK_COLOUR
        if link
        else TOOL_COLOUR
        if carrier
        else BODY_COLOUR
    )
    colour = body.colour or usual
    parts = []
    for part in body.parts:
        seen = part_surface(part)
        parts.append(
            {
                "points": column_text(seen.points),
                "triangles": column_text(seen.triangles),
                "flat": seen.flat,
            }
        )
    rode = () if link else riding.get(body.name, ())
    return {
        "name": visible(body.name),
        "carrier": carrier,
        "pose": _pose_record(pose),
        "rides": [_ride_record(time, ride) for time, ride in rode],
        "colour": "#{:02x}{:02x}{:02x}".format(*colour),
        "link": link,
        "parts": parts,
        "locations": [
            {"name": visible(name), "pose": _pose_record(one)}
            for name, one in body.locations.items()
        ],
    }


def _ride_record(time: float, ride: Ride) -> Record:
    carrier, pose = (None, None) if ride is None else (ride[0], _pose_record(ride[1]))
    return {"time": time, "carrier": carrier, "pose": pose}


def _target_records(program: Program, base: Pose) -> list[Record]:
    """Named targets of the program, each place once."""
    way = track(program)
    found: dict[tuple[object, ...], Record] = {}
    for row, name in way.names.items():
        pose = base @ Pose.of(way.positions[row], way.quaternions[row])
        key = (name, *(round(value, 3) for value in pose.position))
        found.setdefault(key, {"name": visible(name), "pose": _pose_record(pose)})
    return list(found.values())


def _drawn_record(shown: Shown) -> tuple[list[Record], int]:
    """The lines of the drawing in the world, and how many are left out."""
    found: list[Record] = []
    base, room = shown.base, MOST_DRAWN
    for number, line in enumerate(shown.drawn):
        room -= len(line.points)
        if room < 0:
            return found, len(shown.drawn) - number
        found.append({"layer": visible(line.layer), "points": column_text(base.moved(line.points))})
    return found, 0


def _pose_record(pose: Pose) -> list[float]:
    return [*map(float, pose.position), *map(float, pose.quaternion)]
