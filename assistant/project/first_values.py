"""First values of a new project: the robot, its language, where the work stands, the tool's tip.

Where the user states none, a robot that reaches the work is chosen, and the work is put in front of
it, turned by 90 degrees if no robot reaches it as drawn: as far from its limits and from the
singularity of its wrist as the positions that are tried allow, where the arm touches neither itself
nor its base. The tip of the tool is assumed, and the tool turned about its own axis so that the
last axis of the arm works about its middle, not half a turn away from it. All of that is enough to
compile and to simulate; what is assumed is to be measured before an arm moves, and the process file
says so.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Final

import numpy as np

from assistant import languages, robots
from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.base.near_names import near_name
from assistant.compiler.arms import robot_of
from assistant.controllers.address import VIRTUAL
from assistant.controllers.controller import LANGUAGES
from assistant.controllers.named import ROBOT_FILES, controllers_of
from assistant.program.geometry import Pose, Vector
from assistant.program.settings_tables import listed
from assistant.project import rules
from assistant.robots import Robot
from assistant.sources.drawing.survey import Extents

USUAL_ROBOT: Final = "irb1200-7-0.7"
"""Of a project that names none; the same as in the template."""
ASSUMED_TIP: Final[Vector] = (0.0, 0.0, 100.0)
_CLEARANCE: Final = 60.0
"""mm above the work that the tip comes to: the approach of a new process file, and a little."""
_NEAREST_PART: Final = 0.25
"""Part of the reach around axis 1 in which no work stands."""
_DISTANCES: Final = (0.65, 0.6, 0.7, 0.55, 0.75, 0.5, 0.8, 0.45, 0.9)
"""Parts of the reach at which the middle of the work is tried."""
_HEIGHTS: Final = (0.2, 0.3, 0.1, 0.4, 0.0, 0.5, -0.1)
"""Parts of the reach as heights of the work above the floor of the base."""
_TURNS: Final = (0.0, 90.0)
"""Degrees about z that the work is turned."""
_TOOL_TURNS: Final = (0.0, 180.0, 90.0, -90.0)
"""Degrees about z that the tool is turned in the flange."""
_GRID: Final = 5
"""Points along each side of the work that are looked at."""
_ROOMY_WRIST: Final = 20.0
"""Degrees of axis 5 from the singularity of the wrist that are enough."""
_WIDE_WRIST: Final = 10.0
"""Degrees for which another turn or robot is tried before one with fewer is taken."""
_WRIST_AXIS: Final = 4
_AXES_WITH_WRIST: Final = 6


@dataclass(frozen=True, slots=True)
class FirstValues:
    """What a new project states. robot_name: the robot as it is named. place: of the drawing's
    origin in its base. tool_turn: degrees of the tool about the z axis of the flange. assumed: keys
    that the user did not state. findings: about them.
    """

    robot_name: str
    robot: Robot
    language: str
    place: Pose
    tip: Vector
    tool_turn: float = 0.0
    assumed: tuple[str, ...] = ()
    findings: tuple[Diagnostic, ...] = ()

    @property
    def reached(self) -> bool:
        """False if no place was found at which the robot reaches all of the work."""
        return not any(finding.code == rules.NO_ROOM.code for finding in self.findings)

    def keys(self, key: str) -> dict[str, list[float]]:
        """Values of a process file that go with `tip` or with `position`."""
        if key == "tip":
            return {"tip": _rounded(self.tip), "euler_zyx": [self.tool_turn, 0.0, 0.0]}
        turn = rotations.to_euler(np.array(self.place.quaternion), "ZYX")
        return {"position": _rounded(self.place.position), "euler_zyx": _rounded(turn)}

    @property
    def place_text(self) -> str:
        """Return the pose of the work as `--place` takes it."""
        stated = self.keys("position")
        turn = stated["euler_zyx"] if any(stated["euler_zyx"]) else []
        return ",".join(f"{part:g}" for part in (*stated["position"], *turn))

    def assumes(self, key: str) -> bool:
        """True if the user did not state a key."""
        return key in self.assumed

    @property
    def assumed_words(self) -> list[str]:
        """What the user did not state, in words for people."""
        words = {"tip": ["tip of tool"], "position": ["position of work"]}
        turn = ["turn of tool"] if self.tool_turn else []
        return [*(word for key in self.assumed for word in words[key]), *turn]

    @property
    def address(self) -> str:
        """Of a virtual controller that takes the language."""
        taken = (name for name, one in VIRTUAL.items() if self.language in LANGUAGES[one.scheme])
        return f"virtual:{next(taken)}"


def known_robot(name: str) -> Robot:
    """A robot of the catalogue, or of a file. Raises Refused or Unreadable."""
    robot = robot_of(name)
    assert robot is not None
    return robot


def controller_robots(folder: FilePath) -> list[str]:
    """Return the robots that the controllers of a folder's project name, in its order.

    Raises Unreadable and Refused.
    """
    return [one.robot for one in controllers_of(folder).values() if one.robot is not None]


def chosen_language(robot: Robot, given: str | None) -> str:
    """The language of a robot's programs. Raises Refused (exit status 2) for another one."""
    if given is None:
        return robot.languages[0]
    if given not in robot.languages:
        near = near_name(given, list(robot.languages))
        cure = f"write {near}" if near else f"use {listed(list(robot.languages))}"
        if given in languages.names():
            cure += ", or name a robot that takes it"
        raise Refused(
            rules.OTHER_LANGUAGE(robot=robot.title, given=given, cure=cure), exit_status=2
        )
    return given


def first_values(
    extents: Extents | None,
    robot: str | None = None,
    language: str | None = None,
    place: Pose | None = None,
    tip: Vector | None = None,
    millimetres: float = 1.0,
) -> FirstValues:
    """All values of a project, those that are not given chosen to fit work of that size.

    millimetres: of the unit that the drawing names. Raises Refused.
    """
    tool = ASSUMED_TIP if tip is None else tip
    assumed = {} if tip is not None else {"tip": f"`tip` {_rounded(tool)}"}
    findings: list[Diagnostic] = []
    candidates = _usual_robots(language) if robot is None else [(robot, known_robot(robot))]
    name, arm = candidates[0]
    if place is None:
        fitting = _fitting_place(candidates, extents, tool)
        if fitting is not None:
            (name, arm), place = fitting
            smaller = _in_millimetres(candidates[:1], extents, tool, millimetres)
            if extents is not None and name != candidates[0][0] and smaller:
                size = _size_text(extents)
                findings.append(rules.LARGE_UNIT(robot=arm.title, size=size, cure=smaller))
        else:
            name, arm = candidates[-1]
            place = _in_front(arm, extents, _DISTANCES[0], _HEIGHTS[0], _TURNS[0])
            size = "" if extents is None else f", {_size_text(extents)}"
            cure = _in_millimetres(candidates, extents, tool, millimetres)
            cure = cure or _more_reach(candidates)
            findings.append(rules.NO_ROOM(robot=arm.title, size=size, cure=cure))
        turn = rotations.to_euler(np.array(place.quaternion), "ZYX")
        turned = f" turned by {_rounded(turn[:1])[0]} degrees" if turn.any() else ""
        assumed["position"] = f"`position` {_rounded(place.position)}{turned}"
    spoken = chosen_language(arm, language)
    if assumed:
        findings.append(rules.ASSUMED(what=" and ".join(assumed.values())))
    tool_turn = _tool_turn(arm, extents, place, tool)
    return FirstValues(name, arm, spoken, place, tool, tool_turn, tuple(assumed), tuple(findings))


def _size_text(extents: Extents) -> str:
    return " x ".join(f"{length:.0f}" for length in extents.size) + " mm"


def _in_millimetres(
    candidates: Sequence[tuple[str, Robot]],
    extents: Extents | None,
    tip: Vector,
    millimetres: float,
) -> str:
    """Return how to state that the numbers of a drawing are millimetres; empty if they are, or if
    no robot reaches all of the work even then.

    Many programs name a unit that they do not draw in: inches above numbers that are millimetres.
    """
    if extents is None or millimetres <= 1.0:
        return ""
    low, high = ([x / millimetres for x in corner] for corner in (extents.low, extents.high))
    smaller = Extents((low[0], low[1], low[2]), (high[0], high[1], high[2]))
    if _fitting_place(candidates, smaller, tip) is None:
        return ""
    size = _size_text(smaller)
    return f"state --unit mm if the drawing is in mm, whatever it names: it is {size} then"


def _more_reach(candidates: Sequence[tuple[str, Robot]]) -> str:
    """Return what to do with work that none of the robots reaches as it is drawn."""
    largest = max((robots.get(name) for name in robots.names()), key=lambda one: one.reach)
    if max(arm.reach for _, arm in candidates) < largest.reach:
        return "name a robot with more reach by --robot, or make the work smaller"
    return (
        f"no arm of the catalogue reaches farther, {largest.reach:.0f} mm: leave out what is not"
        " work, work it in parts, or name the file of a larger arm by --robot"
    )


def robot_text(robot: str, folder: FilePath) -> str:
    """A robot as a project in a folder names it: its file from there, or as the catalogue has it.

    Raises Refused (exit status 2) for a file elsewhere, and for a robot that is not known.
    """
    file = FilePath(robot)
    if file.suffix.lower() not in ROBOT_FILES:
        return known_robot(robot).name
    if not file.resolve().is_relative_to(folder.resolve()):
        raise Refused(rules.ROBOT_OUTSIDE(file=robot), exit_status=2)
    return file.resolve().relative_to(folder.resolve()).as_posix()


def _usual_robots(language: str | None) -> list[tuple[str, Robot]]:
    """The usual robot, then larger ones that take the same language. Raises Refused."""
    usual = known_robot(USUAL_ROBOT)
    if language is not None and language not in languages.names():
        chosen_language(usual, language)
    wanted = language or usual.languages[0]
    every = sorted(((name, robots.get(name)) for name in robots.names()), key=_reach)
    fitting = [one for one in every if wanted in one[1].languages]
    if wanted in usual.languages:
        larger = [one for one in fitting if one[1].reach > usual.reach]
        return [(USUAL_ROBOT, usual), *larger]
    return fitting


def _reach(one: tuple[str, Robot]) -> float:
    return one[1].reach


def _fitting_place(
    candidates: Sequence[tuple[str, Robot]], extents: Extents | None, tip: Vector
) -> tuple[tuple[str, Robot], Pose] | None:
    """Return a robot and a pose of the work's origin at which the tool, pointing down, reaches all
    of the work; None if no pose that is tried is one.
    """
    narrow: tuple[tuple[str, Robot], Pose] | None = None
    for turn, one in itertools.product(_TURNS, candidates):
        found = _best_place(one[1], extents, tip, turn)
        if found is None:
            continue
        margin, place = found
        if margin >= _WIDE_WRIST:
            return one, place
        narrow = narrow or (one, place)
    return narrow


def _best_place(
    robot: Robot, extents: Extents | None, tip: Vector, turn: float
) -> tuple[float, Pose] | None:
    """Return the pose of the work with the largest margin, and that margin; see `_margin`.

    turn: of the work about z, degrees.
    """
    best: tuple[float, Pose] | None = None
    for distance, height in itertools.product(_DISTANCES, _HEIGHTS):
        place = _in_front(robot, extents, distance, height, turn)
        margin = _margin(robot, extents, place, tip)
        if margin is not None and (best is None or margin > best[0]):
            best = margin, place
            if margin >= _ROOMY_WRIST:
                break
    return best


def _in_front(
    robot: Robot, extents: Extents | None, distance: float, height: float, turn: float
) -> Pose:
    """Return the origin of work whose middle is that far in front of the robot, in whole cm."""
    box = extents or Extents((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    middle = [(a + b) / 2.0 for a, b in zip(box.low, box.high, strict=True)]
    turned = rotations.from_euler(np.array([turn, 0.0, 0.0]), "ZYX")
    x, y, _ = rotations.rotate(turned, np.array(middle)).tolist()
    at = (distance * robot.reach - x, -y, height * robot.reach - box.low[2])
    cm = [round(part / 10.0) * 10.0 + 0.0 for part in at]
    q = turned.tolist()
    return Pose((cm[0], cm[1], cm[2]), (q[0], q[1], q[2], q[3]))


def _margin(robot: Robot, extents: Extents | None, place: Pose, tip: Vector) -> float | None:
    """Degrees of the wrist from its singularity; None if something is out of reach or too near."""
    points = place.moved(_points(extents))
    away = np.hypot(points[:, 0], points[:, 1])
    # With the tool pointing down the wrist is above the flange, and no farther than the reach.
    off = float(np.hypot(*tip[:2]))
    if away.min() < _NEAREST_PART * robot.reach or away.max() - off > robot.reach:
        return None
    joints = _ways_down(robot, points, _DOWN, tip)
    if not joints.shape[1]:
        return None
    if len(robot.axes) < _AXES_WITH_WRIST:
        return _ROOMY_WRIST
    return float(np.abs(joints[:, :, _WRIST_AXIS]).min(axis=0).max())


def _tool_turn(robot: Robot, extents: Extents | None, place: Pose, tip: Vector) -> float:
    """Degrees about the flange's z axis with which the last axis keeps nearest to its middle.

    Only of arms with six axes: others cannot turn the tool about itself in all places.
    """
    if len(robot.axes) != _AXES_WITH_WRIST:
        return 0.0
    points = place.moved(_points(extents))
    down = rotations.multiply(np.array(place.quaternion), _DOWN)
    best, least = 0.0, np.inf
    for turn in _TOOL_TURNS:
        flange = rotations.multiply(down, rotations.from_euler(np.array([-turn, 0.0, 0.0]), "ZYX"))
        joints = _ways_down(robot, points, flange, tip)
        # A wrist that is turned over and back holds the tool as well, but no better.
        rolls = joints[:, :, [3, 5]]
        away = np.abs(rolls).max(axis=(0, 2)).min(initial=np.inf)
        if away < least - 1.0:
            best, least = turn, float(away)
    return best


_DOWN: Final = np.array((0.0, 1.0, 0.0, 0.0))
"""Orientation of a tool that points down."""


def _ways_down(robot: Robot, points: Floats, flange: Floats, tip: Vector) -> Floats:
    """Joints (n, b, a) with the tip at points (n, 3), in the branches that reach all of them and
    touch nothing; flange: its orientation.
    """
    places = points - rotations.rotate(flange, np.array(tip))
    joints, valid = robot.ik(places, np.tile(flange, (len(places), 1)))
    branches = np.flatnonzero(valid.all(axis=0))
    return joints[:, branches[[_is_clear(robot, joints[:, one], tip) for one in branches]]]


def _is_clear(robot: Robot, joints: Floats, tip: Vector) -> bool:
    """True if the arm touches neither itself nor its base at joints (n, a)."""
    from assistant.cell.collision.model import Model
    from assistant.cell.link_bodies import arm_alone

    model = Model(arm_alone(robot, ("tool", Pose(tip))))
    apart = model.least(joints)
    row, pair = np.nonzero(apart <= 0.0)
    return not bool((model.exact(joints, row, pair) <= 0.0).any())


def _points(extents: Extents | None) -> Floats:
    """Points (n, 3) over the work, and above them."""
    box = extents or Extents((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    x, y = (np.linspace(a, b, _GRID) for a, b in zip(box.low[:2], box.high[:2], strict=True))
    z = [box.low[2], box.high[2] + _CLEARANCE]
    return np.stack(np.meshgrid(x, y, z), axis=-1).reshape(-1, 3)


def _rounded(values: Sequence[float] | Floats) -> list[float]:
    """Numbers as they are written: whole ones without a point."""
    found = [round(float(value), 3) + 0.0 for value in values]
    return [int(value) if value == int(value) else value for value in found]
