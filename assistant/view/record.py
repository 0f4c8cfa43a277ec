"""What a page shows, as plain data: surfaces, arms, the motion over time, and what was found."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from assistant.cell.clearances import Closeness
from assistant.cell.collision.carriers import Carriers, carried
from assistant.cell.scene import Body, Placed, Scene
from assistant.compiler.source_map import Places
from assistant.program import rotations
from assistant.program.arrays import Floats
from assistant.program.diagnostics import Diagnostic
from assistant.program.geometry import Pose
from assistant.report.track import track
from assistant.robots.solved_program import SolvedProgram
from assistant.robots.timing import Simulation
from assistant.robots.timing.passed import Passed, stretches_of
from assistant.robots.timing.plan import Plan
from assistant.robots.timing.state import History
from assistant.view.surfaces import surface_of

MOST_SAMPLES: Final = 20_000
"""Places of the arm that a page holds."""
MOST_NAMES: Final = 300
"""Targets that are shown, and that have their names beside them."""
MOST_MOVES: Final = 2_000
"""Motion statements in the list."""
MOST_PLAYED: Final = 20_000
"""Passings of motion statements that the time line knows; loops have many."""
MOST_TEXT: Final = 200
"""Characters of a statement that are shown."""
MOST_FINDINGS: Final = 500
NEAR: Final = 0.5
"""Degrees (mm) that a place on the time line is away from joints that it stands for, at most."""
LINK: Final = (232, 140, 60)
TOOL: Final = (90, 100, 112)
BODY: Final = (138, 150, 164)

Marked = tuple[Diagnostic, Closeness | None]
"""A finding, and where in the scene it is."""
Record = dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """What is to be seen.

    solution: of the program, simulated on `placed`, one of the robots of the scene; the others
    stand at home. places: of the program's texts. findings: in the order of the list.
    """

    title: str
    solution: SolvedProgram
    simulation: Simulation
    scene: Scene
    placed: Placed
    places: Places
    findings: Sequence[Marked] = ()


def record(shown: Shown) -> Record:
    """The data of a page; columns of numbers as text, see `column`.

    Lengths are mm and angles radians there, poses seven numbers: position, then quaternion w, x, y,
    z. Raises Refused for a body whose parent the scene has not.
    """
    carriers = Carriers(shown.scene.robots)
    simulation = _sparse(shown.simulation)
    motion = Motion(shown, simulation)
    names = list(_targets(shown))
    moves = Moves(shown)
    found = [_finding(shown, motion, moves, marked) for marked in shown.findings[:MOST_FINDINGS]]
    return {
        "title": shown.title,
        "robot": shown.placed.robot.title,
        "robots": [_arm(one, one is shown.placed) for one in shown.scene.robots],
        "bodies": [_body(shown, body, carriers) for body in shown.scene.all_bodies() if body.shown],
        "motion": motion.record(),
        "tips": [_pose(tip) for tip in _tips(shown.simulation)],
        "targets": names[:MOST_NAMES],
        "moves": moves.records(),
        "played": moves.played(),
        "findings": found,
        "left": {
            "targets": max(0, len(names) - MOST_NAMES),
            "findings": max(0, len(shown.findings) - MOST_FINDINGS),
            "moves": max(0, len(moves) - MOST_MOVES),
        },
    }


def column(values: NDArray[Any]) -> str:
    """An array as base64 of its little-endian numbers: float32, or uint32 if it holds integers."""
    kind = "<u4" if np.issubdtype(values.dtype, np.integer) else "<f4"
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


class Motion:
    """The way that the page plays: k samples of time, joints and the tool.

    held: whether the tool is at the arm for all of it; else its path is that of the flange.
    """

    def __init__(self, shown: Shown, simulation: Simulation) -> None:
        samples = simulation.samples
        base = shown.placed.base
        self.robot = shown.placed.robot
        self.times, self.joints, self.speeds = samples.t, samples.joints, samples.tcp_speed
        self.held = all(
            mount.tool.held and not mount.frame.held for mount in _mounts(shown.simulation)
        )
        places = samples.position
        if not self.held:
            places = self.robot.link_frames(self.joints)[0][:, -1]
        turned = rotations.rotate(np.array(base.quaternion), places)
        self.places: Floats = turned + np.array(base.position)

    def record(self) -> Record:
        return {
            "times": column(self.times),
            "joints": column(self.robot.chained(self.joints)),
            "places": column(self.places),
            "speeds": column(self.speeds),
            "axes": len(self.robot.axes),
            "held": self.held,
        }

    def when(self, joints: Floats) -> float | None:
        """Seconds at which joints (a,) are first passed, None if they are not on this way."""
        start = self.joints[:-1]
        if not len(start):
            return None
        step = np.diff(self.joints, axis=0)
        square = np.einsum("ij,ij->i", step, step)
        along = np.einsum("ij,ij->i", joints - start, step)
        part = np.clip(along / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        off = np.abs(start + part[:, None] * step - joints).max(axis=1)
        if off.min() > NEAR:
            return None
        at = int(np.flatnonzero(off <= off.min() + NEAR / 10.0)[0])
        return float(self.times[at] + part[at] * (self.times[at + 1] - self.times[at]))


def _sparse(simulation: Simulation) -> Simulation:
    """With no more samples than a page holds."""
    least = simulation.seconds / (MOST_SAMPLES - 1)
    return replace(simulation, wanted_period=least) if simulation.period < least else simulation


def _mounts(simulation: Simulation) -> Iterator[Any]:
    for passed in simulation.passed:
        for piece in passed.pieces:
            yield from piece.moves.mounts


def _tips(simulation: Simulation) -> list[Pose]:
    """Tips of the tools that the arm carries, without the bare flange."""
    tips = {mount.tool.tip: None for mount in _mounts(simulation) if mount.tool.held}
    return [tip for tip in tips if tip != Pose()]


def _arm(placed: Placed, moves: bool) -> Record:
    """Its chain: the page poses its links by itself."""
    chain = placed.robot.arm.whole_chain
    home = placed.robot.chained(np.array([placed.robot.home]))[0]
    return {
        "name": placed.name,
        "base": _pose(placed.base),
        "joints": [
            {"pose": _pose(joint.pose), "axis": list(joint.axis), "sliding": joint.sliding}
            for joint in chain.joints
        ],
        "flange": _pose(chain.flange),
        "home": home.tolist(),
        "moves": moves,
    }


def _body(shown: Shown, body: Body, carriers: Carriers) -> Record:
    carrier, pose = carried(shown.scene, body, carriers)
    link = any(body is own for placed in shown.scene.robots for own in placed.links)
    colour = body.colour or (LINK if link else TOOL if carrier else BODY)
    parts = []
    for part in body.parts:
        seen = surface_of(part).at(pose)
        parts.append(
            {
                "points": column(seen.points),
                "triangles": column(seen.triangles),
                "flat": seen.flat,
            }
        )
    return {
        "name": body.name,
        "carrier": carrier,
        "colour": "#{:02x}{:02x}{:02x}".format(*colour),
        "link": link,
        "parts": parts,
        "locations": [
            {"name": name, "pose": _pose(pose @ one)} for name, one in body.locations.items()
        ],
    }


def _targets(shown: Shown) -> Iterator[Record]:
    """Named targets of the program, each place once."""
    way = track(shown.solution.program)
    seen = set[tuple[object, ...]]()
    for row, name in way.names.items():
        pose = shown.placed.base @ Pose.of(way.positions[row], way.quaternions[row])
        key = (name, *(round(value, 3) for value in pose.position))
        if key not in seen:
            seen.add(key)
            yield {"name": name, "pose": _pose(pose)}


class Moves:
    """The motion statements in order of text, and when they are come to in the way that is played.

    keys: procedure and number of each. begins: seconds and place in the list, in order of time, of
    at most `MOST_PLAYED`. until: seconds up to which these are all.
    """

    def __init__(self, shown: Shown) -> None:
        self.shown = shown
        self.keys = list(shown.simulation.labels)
        self.places = {key: i for i, key in enumerate(self.keys)}
        self.begins: list[tuple[float, int]] = []
        self.until = shown.simulation.seconds
        for start, steps in _stages(shown.simulation):
            if len(self.begins) >= MOST_PLAYED:
                self.until = start
                break
            self.begins += [(start + time, self.places[key]) for key, time in steps]
        self.spans = {
            span.start: self.places[name, number]
            for name, legs in shown.solution.legs.items()
            for number, leg in enumerate(legs, start=1)
            if (span := leg.statement.span) is not None and (name, number) in self.places
        }

    def __len__(self) -> int:
        return len(self.keys)

    def records(self) -> list[Record]:
        """Those of the list; `time` is when each begins first, None if it is not played."""
        first: dict[int, float] = {}
        for time, place in self.begins:
            first.setdefault(place, time)
        return [self._record(key, first.get(i)) for i, key in enumerate(self.keys[:MOST_MOVES])]

    def played(self) -> Record:
        inside = [(time, place) for time, place in self.begins if place < MOST_MOVES]
        return {
            "times": column(np.array([time for time, _ in inside])),
            "moves": column(np.array([place for _, place in inside], dtype=np.int64)),
            "until": self.until,
        }

    def of(self, marked: Marked) -> int | None:
        """The place in the list of what a finding is about."""
        finding, close = marked
        if close is not None:
            place = self.places.get((close.procedure, close.number))
        else:
            place = None if finding.span is None else self.spans.get(finding.span.start)
        return place if place is not None and place < MOST_MOVES else None

    def _record(self, key: tuple[str, int], time: float | None) -> Record:
        procedure, number = key
        legs = self.shown.solution.legs.get(procedure, ())
        span = legs[number - 1].statement.span if number <= len(legs) else None
        place = None if span is None else self.shown.places.of(span)
        return {
            "procedure": procedure,
            "number": number,
            "label": self.shown.simulation.labels[key].strip("`"),
            "time": time,
            "line": None if place is None else place.line,
            "path": None if place is None else place.path,
            "text": "" if place is None else place.text[:MOST_TEXT],
        }


def _stages(
    simulation: Simulation,
) -> Iterator[tuple[float, Sequence[tuple[tuple[str, int], float]]]]:
    """What is done one after the other: when it begins, and each statement with the seconds in it
    after which it does.
    """
    by_plan = {id(passed.plan): passed for passed in reversed(simulation.passed)}
    known: dict[int, Sequence[tuple[tuple[str, int], float]]] = {}
    for start, plan in _plans(simulation.history, 0.0):
        passed = by_plan.get(id(plan))
        if passed is None:
            continue
        if id(plan) not in known:
            known[id(plan)] = list(_statements(passed))
        yield start, known[id(plan)]


def _statements(passed: Passed) -> Iterator[tuple[tuple[str, int], float]]:
    stretches = stretches_of(passed.plan)
    before = None
    rows, first = np.unique(stretches.row, return_index=True)
    for row, at in zip(rows.tolist(), first.tolist(), strict=True):
        piece, _ = passed.piece_of(row)
        if piece is not before:
            yield (piece.procedure, piece.number), float(stretches.times[at])
        before = piece


def _plans(history: History | None, start: float) -> Iterator[tuple[float, Plan]]:
    """The plans of a history with when they begin, those of a loop in each of its rounds."""
    for node in () if history is None else history.chain():
        if isinstance(node.done, Plan):
            yield start + node.start, node.done
        elif isinstance(node.done, tuple):
            inner, count = node.done
            for i in range(count if inner.last is not None else 0):
                yield from _plans(inner, start + node.start + i * inner.seconds)


def _finding(shown: Shown, motion: Motion, moves: Moves, marked: Marked) -> Record:
    finding, close = marked
    finding = shown.places.finding(finding)
    mark: Record | None = None
    if close is not None:
        contact = close.contact
        at = _own(shown, close.joints)
        mark = {
            "one": contact.one,
            "other": contact.other,
            "points": [list(point) for point in contact.points],
            "normal": list(contact.normal),
            "joints": motion.robot.chained(at[None])[0].tolist(),
            "time": motion.when(at),
        }
    return {
        "code": finding.code,
        "severity": finding.severity.value,
        "message": finding.message,
        "cure": finding.cure,
        "where": finding.where(),
        "move": moves.of(marked),
        "mark": mark,
    }


def _own(shown: Shown, joints: Floats) -> Floats:
    """Of a row of the joints of all robots those of the one that moves."""
    carriers = Carriers(shown.scene.robots)
    at = next(i for i, one in enumerate(shown.scene.robots) if one is shown.placed)
    return joints[carriers.columns[at]]


def _pose(pose: Pose) -> list[float]:
    return [*map(float, pose.position), *map(float, pose.quaternion)]
