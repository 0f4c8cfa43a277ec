"""The page of a program: data, scripts and the library that draws, in one HTML file.

`record` gives what the page shows as plain data: surfaces, arms, the motion over time, carried
bodies, zones and findings. Columns are base64 of little-endian numbers. Poses are in the world, mm
and scalar-first quaternions; times are seconds.
"""

from __future__ import annotations

import html
import json
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.source_text import visible
from assistant.cell.clearances import CarriedBodies, carried_stretches, takeable
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.scene import Body, PlacedRobot, Scene, part_surface
from assistant.program.geometry import Pose
from assistant.program.motion import Kind
from assistant.program.program import Program
from assistant.report.timing import Statement, seconds_of, statements
from assistant.report.track import track
from assistant.robots.timing import Simulation
from assistant.robots.timing.course import join_moves, sums_by_move
from assistant.robots.timing.uninterrupted_moves import MovesWithoutStop
from assistant.view.motion import (
    MOST_MOVES,
    Motion,
    Moves,
    Record,
    StillMotion,
    StillMoves,
    column_text,
    motion_stages,
    path_record,
    tool_held,
    tool_tips,
)
from assistant.view.page_contents import MOST_FINDINGS, Shown, finding_records

_MOST_RIDE_STAGES: Final = 40_000
"""Most stretches of moves that are examined; the page does not show positions of bodies after
them.
"""

_Ride = tuple[int, Pose] | None
"""The carrier of a body and its pose on it; None where only running the program tells."""


def _rides_of(
    simulation: Simulation, scene: Scene, until: float
) -> Mapping[str, list[tuple[float, _Ride]]]:
    """Return the carrier of each body over time, for those that do not keep their first position.

    simulation: of a program that carries, with the `Holding` of the scene. until: seconds that are
    played.
    """
    if not takeable(scene):
        return {}
    carriers = Carriers(scene.robots)
    at: dict[str, list[tuple[float, _Ride]]] = {
        name: [(0.0, ride)] for name, ride in _all_bodies(scene, scene, carriers).items()
    }
    known: dict[CarriedBodies, Mapping[str, _Ride]] = {}
    for time, holding in _carried_bodies(simulation, until):
        riding: Mapping[str, _Ride]
        if holding is None:
            riding = {name: None for name, rode in at.items() if len(rode) > 1}
        else:
            if holding not in known:
                known[holding] = _all_bodies(scene, holding.scene_now(), carriers)
            riding = known[holding]
        for name, ride in riding.items():
            if ride != at[name][-1][1]:
                at[name].append((time, ride))
    return {name: rode for name, rode in at.items() if len(rode) > 1}


def _carried_bodies(
    simulation: Simulation, until: float
) -> Iterator[tuple[float, CarriedBodies | None]]:
    """Yield the carried bodies by start time; None once the examination stops."""
    known: dict[int, list[tuple[float, CarriedBodies]]] = {}
    for number, (start, passed) in enumerate(motion_stages(simulation, until)):
        if number >= _MOST_RIDE_STAGES:
            yield start, None
            return
        if id(passed) not in known:
            known[id(passed)] = [
                (float(stretches.times[0]), held)
                for held, stretches in carried_stretches(passed)
                if isinstance(held, CarriedBodies)
            ]
        for time, held in known[id(passed)]:
            yield start + time, held


def _all_bodies(scene: Scene, now: Scene, carriers: Carriers) -> Mapping[str, _Ride]:
    """The bodies of a scene as they are in that of a moment, which lacks those that are lost."""
    return {body.name: _ride_of(now, now.body(body.name), carriers) for body in scene.bodies}


def _ride_of(now: Scene, body: Body | None, carriers: Carriers) -> _Ride:
    """Return the carrier of a body; None also for one whose parent body is lost."""
    upper = body
    while upper is not None and upper.parent not in carriers.names | now.frames.keys():
        upper = now.body(upper.parent)
    return None if body is None or upper is None else carrier_of(now, body, carriers)


_MOST_ZONE_STAGES: Final = 1_000
"""Most stretches of moves that are examined."""
_SMALLEST_ZONE: Final = 0.05
"""Radius in mm below which a zone is not visible."""


def _zones_of(simulation: Simulation, placed: PlacedRobot, until: float) -> Floats:
    """Return centres (z, 4) in the world and radii, mm, of the motion played until so many seconds,
    each place once.

    A zone reaches to the middle of the moves before and after it at most, and is absent if a
    program waits there. A tool that the arm does not carry has no zones.
    """
    found: dict[int, MovesWithoutStop] = {}
    for number, (_, passed) in enumerate(motion_stages(simulation, until)):
        if number >= _MOST_ZONE_STAGES:
            break
        found[id(passed)] = passed
    parts = [_move_zones(passed) for passed in found.values()]
    every = np.concatenate([np.zeros((0, 4)), *parts])
    _, first = np.unique(every.round(2), axis=0, return_index=True)
    every = every[np.sort(first)]
    every[:, :3] = placed.base.moved(every[:, :3])
    return every


def _move_zones(passed: MovesWithoutStop) -> Floats:
    moves = join_moves([piece.moves for piece in passed.pieces]).rest(passed.skipped)
    knots = passed.plan.course.knots
    half = sums_by_move(knots.row, knots.length, len(moves)) / 2.0
    entry = np.minimum(moves.entry[:-1], half[:-1])
    radius = np.minimum(entry, np.minimum(moves.leaving[:-1], half[1:]))
    mounts = moves.mounts
    held = np.array([one.tool.held and not one.frame.held for one in mounts])[moves.mount]
    tool = np.array([[m.tool for m in mounts].index(one.tool) for one in mounts])[moves.mount]
    through = moves.kinds[:-1] == Kind.VIA
    seen = (radius > _SMALLEST_ZONE) & ~through & (tool[:-1] == tool[1:]) & held[:-1]
    return np.asarray(np.column_stack([moves.positions[:-1], radius])[seen])


def _procedure_times(simulation: Simulation, every: Sequence[Statement]) -> Record:
    """seconds: of the program, in words. procedures: of each how long a call of it takes, with what
    it calls; its own motion statements, and how many mm and seconds these lead, each gone through
    once. unknown: what the times do not hold. every: the motion statements.
    """
    own: dict[str, list[Statement]] = {}
    for one in every:
        own.setdefault(one.procedure, []).append(one)
    return {
        "seconds": seconds_of(simulation.duration),
        "procedures": [
            {
                "name": visible(name),
                "seconds": seconds_of(duration),
                "moves": len(own.get(name, ())),
                "length": sum(one.length for one in own.get(name, ())),
                "moving": sum(one.seconds for one in own.get(name, ())),
            }
            for name, duration in simulation.procedures.items()
        ],
        "unknown": [visible(str(one)) for one in simulation.unknown],
    }


_MOST_NAMES: Final = 300
"""Targets that are shown, and that have their names beside them."""
_MOST_ZONES: Final = 5_000
_MOST_DRAWN: Final = 200_000
"""Points of the lines of a drawing."""
_LINK_COLOUR: Final = (232, 140, 60)
_IDLE_LINK_COLOUR: Final = (222, 200, 170)
"""Colour of a robot at home."""
_TOOL_COLOUR: Final = (90, 100, 112)
_BODY_COLOUR: Final = (138, 150, 164)


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
        "bare": shown.is_bare,
        "robots": [_arm_record(one, one is shown.placed) for one in shown.scene.robots],
        "bodies": [
            _body_record(shown, body, carriers, riding)
            for body in shown.scene.all_bodies()
            if body.shown
        ],
        "targets": targets[:_MOST_NAMES],
        "drawn": drawn,
        "beside": None if shown.beside is None else shown.beside.record(),
        "left": data["left"]
        | {
            "targets": max(0, len(targets) - _MOST_NAMES),
            "findings": max(0, len(shown.findings) - MOST_FINDINGS),
            "drawn": drawn_left,
        },
    }


def _moving_record(shown: Shown) -> Record:
    """Return the record of a program that an arm runs."""
    solution, simulation, placed = shown.solution, shown.simulation, shown.placed
    assert solution is not None and simulation is not None and placed is not None
    motion = Motion(simulation, placed)
    moves = Moves(solution, simulation, shown.places, motion.until)
    around = _zones_of(simulation, placed, motion.until) if tool_held(simulation) else None
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
        "times": _procedure_times(simulation, every),
        "tips": [_pose_record(tip) for tip in tool_tips(simulation)],
        "targets": _target_records(solution.program, placed.base),
        "riding": _rides_of(simulation, shown.scene, motion.until),
        "zones": column_text(np.zeros((0, 4)) if around is None else around[:_MOST_ZONES]),
        "moves": listed,
        "played": moves.played(),
        "texts": texts,
        "findings": finding_records(shown, motion, moves, solution.program),
        "left": {
            "moves": max(0, len(moves) - MOST_MOVES),
            "zones": 0 if around is None else max(0, len(around) - _MOST_ZONES),
            "lines": lines_left,
        },
    }


def _still_record(shown: Shown) -> Record:
    """Return the record of a program that is only drawn."""
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
    """Return the chain of an arm, with which the page poses its links."""
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
    riding: Mapping[str, Sequence[tuple[float, _Ride]]],
) -> Record:
    """A body in its own frame, and what it rides on; `rides` where that changes."""
    carrier, pose = carrier_of(shown.scene, body, carriers)
    own = shown.placed is not None and any(body is one for one in shown.placed.links)
    link = own or any(body is one for placed in shown.scene.robots for one in placed.links)
    usual = (
        _LINK_COLOUR
        if own
        else _IDLE_LINK_COLOUR
        if link
        else _TOOL_COLOUR
        if carrier
        else _BODY_COLOUR
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


def _ride_record(time: float, ride: _Ride) -> Record:
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
    base, room = shown.base, _MOST_DRAWN
    for number, line in enumerate(shown.drawn):
        room -= len(line.points)
        if room < 0:
            return found, len(shown.drawn) - number
        one = {"layer": visible(line.layer), "points": column_text(base.moved(line.points))}
        found.append(one | ({"left": True} if line.left else {}))
    return found, 0


def _pose_record(pose: Pose) -> list[float]:
    return [*map(float, pose.position), *map(float, pose.quaternion)]


_DRAWING_LIBRARY: Final = "three/three.js"
"""three.js, see `three/README.md` for its version, its licence and how it is made."""
_SCRIPTS: Final = (
    *("data", "scene", "lines", "plan", "camera", "time", "lists", "table", "source", "live"),
    "picking",
    "start",
)
"""Scripts that draw, in order; together they are one function of the page."""


def page(*shown: Shown) -> str:
    """One HTML file without anything from outside, for one program or for several of which one is
    chosen on it. Raises Refused as `record` does.
    """
    return filled_page(*map(page_record, shown))


def filled_page(*programs: Record, nonce: str = "") -> str:
    """The page of the data that `record` gives for each of them.

    nonce: of whoever serves it: nothing is run then that does not bear it. What a page that is
    shown inside of another one is given beside the data, see `scripts/picking.js`.
    """
    first, *others = programs
    chosen = [str(one["title"]) for one in programs] if others else []
    title = str(first["title"]) if not others else f"{first['title']} and {len(others)} more"
    more = (
        f'<script id="data-{number}" type="application/json">{_script_json(one)}</script>\n'
        for number, one in enumerate(others, start=1)
    )
    parts = {
        "title": html.escape(title),
        "style": _own_file("viewer.css"),
        "data": _script_json(first | {"chosen": chosen} if others else first),
        "more": "".join(more),
        "library": _own_file(_DRAWING_LIBRARY).replace("</script", "<\\/script"),
        "viewer": "".join(_own_file(f"scripts/{name}.js") for name in _SCRIPTS),
        "nonce": f' nonce="{html.escape(nonce)}"' if nonce else "",
        "own": f"'nonce-{html.escape(nonce)}'" if nonce else "'unsafe-inline'",
        # A page that follows a controller asks where it comes from for that; any other asks nobody.
        "asked": "'none'" if first.get("live") is None else "'self'",
    }
    out = _own_file("viewer.html")
    head, *rest = out.split("{{")
    found = [head]
    for piece in rest:
        name, tail = piece.split("}}", 1)
        found += [parts[name.strip()], tail]
    return "".join(found)


def _script_json(data: Record) -> str:
    """Return data as JSON that cannot end a script: `<` before `/script` would, even in a
    string.
    """
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028")


def _own_file(name: str) -> str:
    return files("assistant").joinpath("view", *name.split("/")).read_text(encoding="utf-8")
