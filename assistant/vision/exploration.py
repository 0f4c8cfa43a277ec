"""Exploration of the space around an arm by random moves, each up to the first contact.

Contacts come from an input of the controller, a key of the operator or a camera. After a contact
the arm goes back along the path it came. `RandomExplorer` keeps the arm in the bounds of a `Guard`
and logs joints, flange poses and contacts in the form that `explore recorded` reads.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field
from pathlib import Path as FilePath
from typing import Final, Protocol

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.cell.cell_file import read_scene
from assistant.cell.collision.model import Model
from assistant.cell.exploration.explorer import Explorer, best_of, drawn_in, ranges_of, way_to
from assistant.cell.exploration.filled_cells import STEP_IN_CELLS
from assistant.cell.exploration.recordings import clear_runs
from assistant.cell.findings import NOT_CLEAR
from assistant.controllers.recording import Recording
from assistant.controllers.setpoint_streams import Carrier
from assistant.robots import Robot
from assistant.vision import rules
from assistant.vision.cameras.camera import Camera
from assistant.vision.cameras.synthetic_pictures import (
    Picture,
    bodies_of_scene,
    camera_in_world,
    draw,
)
from assistant.vision.servoing.bounds import Guard
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.live_cameras import CameraReader
from assistant.vision.servoing.simulation import Clock

_NOISE_LEVELS: Final = 30
"""Grey levels by which a pixel may differ by noise."""
_MOST_CHANGED: Final = 0.01
"""Largest part of the pixels of a region that differ without contact."""
_PICTURE_TIMEOUT: Final = 2.0
"""Most seconds to wait for a picture."""
PictureRegion = tuple[int, int, int, int]
"""Left, top, right, bottom in pixels; right and bottom are outside."""


class Contacts(Protocol):
    """A source of contacts, or several."""

    def touching(self) -> bool:
        """True if the arm is in contact now; raises Refused if that cannot be found out."""


class InputReader(Protocol):
    """A controller whose inputs can be read."""

    def inputs(self, names: Sequence[str]) -> dict[str, float]: ...


@dataclass(frozen=True, slots=True)
class InputContacts:
    """An input of the controller that is not 0 in contact."""

    controller: InputReader
    name: str

    def touching(self) -> bool:
        return self.controller.inputs([self.name])[self.name] != 0.0


@dataclass(slots=True)
class KeyContacts:
    """A key of the operator: each press is a contact.

    pressed: returns a key that was pressed within so many seconds, b"" if none was. ends: keys that
    end the exploration. ended: one of them was pressed, or no more keys can come.
    """

    pressed: Callable[[float | None], bytes]
    ends: bytes
    ended: bool = False

    def touching(self) -> bool:
        touched = False
        while not self.ended and (key := self.pressed(0.0)):
            self.ended = key in self.ends
            touched = touched or not self.ended
        return touched


@dataclass(slots=True)
class PictureContacts:
    """A camera: in contact a region of its picture differs from the first picture.

    picture: returns the newest picture. region: of the picture.
    """

    picture: Callable[[], Picture]
    region: PictureRegion
    first: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.first = self._grey()

    def touching(self) -> bool:
        return self.difference() > _MOST_CHANGED

    def difference(self) -> float:
        """Part of the pixels of the region that differ from the first picture."""
        return float((np.abs(self._grey() - self.first) > _NOISE_LEVELS).mean())

    def _grey(self) -> Floats:
        left, top, right, bottom = self.region
        return np.asarray(self.picture()[top:bottom, left:right].mean(axis=2, dtype=np.float64))


@dataclass(slots=True)
class AnyContacts:
    """Several sources, of which one is enough. Each is asked: keys are gone once they are read."""

    each: Sequence[Contacts]

    def touching(self) -> bool:
        asked = [one.touching() for one in self.each]
        return any(asked)


@contextmanager
def open_contact_camera(
    camera: Camera,
    source: str,
    folder: FilePath,
    region: PictureRegion | None,
    joints: Callable[[], Mapping[str, Floats]],
) -> Iterator[PictureContacts]:
    """Open a camera as a source of contacts.

    region: None for the complete picture. joints: returns the joints of robots by name, at which a
    cell is drawn where the source is a cell file. Raises Refused for a region outside of the
    picture, and for a camera that gives no picture.
    """
    width, height = camera.lens.size
    wanted = (0, 0, width, height) if region is None else region
    left, top, right, bottom = wanted
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        size = f"{width} × {height}"
        finding = rules.BAD_REGION(region=wanted, camera=camera.name, size=size)
        raise Refused(finding, exit_status=2)
    if source.lower().endswith(".toml"):
        yield PictureContacts(_cell_drawer(camera, folder / source, joints), wanted)
        return
    reader = CameraReader(camera, source, folder)

    def newest() -> Picture:
        now = time.monotonic()
        frame = reader.newest(now, now + _PICTURE_TIMEOUT)
        if frame is None:
            raise Refused(
                rules.NO_CONTACT_PICTURE(camera=camera.name, seconds=_PICTURE_TIMEOUT),
                exit_status=1,
            )
        return frame.picture

    with reader.running():
        yield PictureContacts(newest, wanted)


def _cell_drawer(
    camera: Camera, cell: FilePath, joints: Callable[[], Mapping[str, Floats]]
) -> Callable[[], Picture]:
    """Return a function that draws a cell with its robots at their present joints, and noise."""
    scene, _ = read_scene(cell, explored=False)
    numbers = itertools.count()

    def picture() -> Picture:
        now = joints()
        stands = camera_in_world(camera, scene, now)
        return draw(stands, bodies_of_scene(scene, now), seed=next(numbers))

    return picture


_POSTURES_TRIED: Final = 6
"""Postures that are drawn for each move; the target is the one that fills most new space."""
_POSTURES_DRAWN: Final = 2000
"""Postures that are drawn to find some with the flange in the box."""
_LEAST_STEPS_BACK: Final = 3.0
"""Least steps back from a contact."""
_SECONDS_AHEAD: Final = 0.3
"""Seconds to the target at the present speed, near the end of a motion led cycle by cycle."""
_LONGEST_STEP: Final = 0.2
"""Most seconds of a step, however long the sources of contacts take."""
_AT_TARGET: Final = 0.1
"""Steps from the target within which a move has ended."""
_REST_TIMEOUT: Final = 2.0
"""Seconds in which a motion that is led cycle by cycle must come to rest."""
_STANDSTILL: Final = 0.02
"""Most degrees or mm between two looks at an arm that stands still."""
_STANDSTILL_PERIOD: Final = 0.1
"""Seconds between these looks."""


@dataclass(slots=True, eq=False)
class ExplorationLog:
    """Joints, poses and contacts over time, as `explore recorded` reads them.

    rows: seconds, joints (a,) and contact of each row of the recording.
    """

    recording: Recording
    rows: list[tuple[float, Floats, bool]] = field(default_factory=list)

    def note(self, seconds: float, joints: Floats, touching: bool, robot: Robot) -> None:
        """Add a row: the joints (a,), and the flange in the frame of the base."""
        flange = flange_of(robot, joints)
        self.rows.append((seconds, np.array(joints), touching))
        pose = (*flange.position, *flange.quaternion)
        self.recording.add(seconds, *joints.tolist(), *pose, float(touching))

    @property
    def contacts(self) -> int:
        """Number of contacts that began."""
        touching = np.array([False, *(row[2] for row in self.rows)])
        return int((np.diff(touching.astype(np.int8)) == 1).sum())

    def clear(self, since: int = 0) -> tuple[Floats, ...]:
        """Runs of joints (n, a) without contact, from a row on; see `clear_runs`."""
        rows = self.rows[since:]
        if not rows:
            return ()
        times, joints, touching = zip(*rows, strict=True)
        return clear_runs(np.array(times), np.array(joints), np.array(touching))


def empty_log(guard: Guard) -> ExplorationLog:
    """Return an empty log for the arm of a guard."""
    axes = zip(guard.robot.axes, guard.robot.units, strict=True)
    names = [f"{axis.lower()}_{'mm' if unit == 'mm' else 'deg'}" for axis, unit in axes]
    pose = ("x_mm", "y_mm", "z_mm", "q_w", "q_x", "q_y", "q_z")
    fields: dict[str, tuple[str, ...]] = dict.fromkeys(("seconds", *names, *pose, "contact"), ())
    return ExplorationLog(Recording(fields))


@dataclass(slots=True, eq=False)
class RandomExplorer:
    """An arm that moves at random.

    explorer: with the chart so far; while the arm moves it learns from the log. carrier: leads the
    arm, and is entered. guard: keeps speeds, limits and box. ranges: (a, 2) of the joints, degrees
    or mm, None for their limits. seconds: after which no further move begins. ended: True once the
    operator ends the exploration. told: called after each move with its number, the number of
    contacts, and the free space in litres. moves: that are done.
    """

    explorer: Explorer
    carrier: Carrier
    guard: Guard
    contacts: Contacts
    log: ExplorationLog
    ranges: Floats | None = None
    seconds: float = np.inf
    seed: int = 0
    ended: Callable[[], bool] = lambda: False
    told: Callable[[int, int, float], None] = lambda *_: None
    clock: Clock = field(default_factory=Clock)
    moves: int = 0
    _began: float = 0.0
    _lever: Floats = field(init=False)
    """Most mm (a, i) that each body moves for a degree (mm) of each joint."""

    def __post_init__(self) -> None:
        self.guard = self.guard.slowed(self.carrier.speeds)
        filler = self.explorer.filler
        self._lever = filler.lever()[filler.columns]

    def check(self) -> None:
        """Raise Refused if the arm is outside its bounds or in contact; nothing moves."""
        joints = self.carrier.joints()
        what = self.guard.outside(joints) or self._outside(joints)
        if what:
            raise Refused(rules.START_OUTSIDE_BOUNDS(what=what), exit_status=2)
        if self.contacts.touching():
            raise Refused(NOT_CLEAR(), exit_status=2)

    def wander(self, moves: int) -> None:
        """Make so many random moves, each up to the first contact.

        Raises Refused, when the arm stands still.
        """
        self._began = self.clock()
        draw = np.random.default_rng(self.seed)
        known = Model(self.explorer.scene)
        self._note(self.contacts.touching())
        try:
            while self.moves < moves and not self.ended() and not self.is_over:
                since = len(self.log.rows) - 1
                self._move(known, draw)
                for row in self.log.clear(since):
                    self.explorer.gone(self._all(row))
                self.moves += 1
                self.told(self.moves, self.log.contacts, self.explorer.occupancy.litres)
        except BaseException:
            self.carrier.rest()
            raise

    # ---------------------------------------------------------------------------- a move

    def _move(self, known: Model, draw: np.random.Generator) -> None:
        here = self.carrier.joints()
        target = best_of(self.explorer, self._all(self._targets(draw)))
        rows = way_to(self.explorer, known, self._all(here[None])[0], target)
        way = rows[:, self.explorer.filler.columns]
        inside = [not self._outside(row) and not self.guard.outside(row) for row in way[1:]]
        end = way[inside.index(False) if False in inside else len(inside)]
        if self._go(end, stops=True):
            self._go_back()

    def _targets(self, draw: np.random.Generator) -> Floats:
        """Return random joints (n, a) in the ranges and with the flange in the box."""
        robot = self.guard.robot
        ranges = ranges_of(robot, self.ranges)
        if self.guard.bounds.box is None:
            return drawn_in(ranges, _POSTURES_TRIED, draw)
        drawn = drawn_in(ranges, _POSTURES_DRAWN, draw)
        low, high = np.array(self.guard.bounds.box)
        places = robot.flange_poses(drawn)[0]
        found = drawn[((places >= low) & (places <= high)).all(axis=1)][:_POSTURES_TRIED]
        if not len(found):
            raise Refused(rules.EMPTY_BOX(count=_POSTURES_DRAWN), exit_status=1)
        return np.asarray(found)

    def _go(self, end: Floats, *, stops: bool) -> bool:
        """Move straight in the joints to an end; True if a contact ended the move.

        stops: whether a contact ends it; else it goes on in contact, and ends with the contact.
        """
        velocity, before = np.zeros(len(end)), self.clock()
        while True:
            now = self.clock()
            seconds = float(np.clip(now - before, self.carrier.period, _LONGEST_STEP))
            before = now
            at = self.carrier.told()
            left = end - at
            steps = self._steps(left)
            if steps < _AT_TARGET:
                self._rest()
                return self._note(self.contacts.touching()) and stops
            if self.carrier.waits:
                self.carrier.move(at + left / max(steps, 1.0), seconds)
            else:
                wanted = left / max(_SECONDS_AHEAD, 2.0 * seconds)
                velocity = self.guard.limited(wanted, velocity, at, seconds)
                self.carrier.move(at + velocity * seconds, seconds)
                self.clock.wait(max(self.carrier.period - (self.clock() - now), 0.0))
            touching = self._note(self.contacts.touching())
            if stops and (touching or self.ended()):
                self._rest()
                return touching
            if not stops and not touching:
                self._rest()
                return False
            if not self.carrier.waits and np.abs(velocity).max() <= 0.0 and self.guard.barred:
                self._rest()
                return False

    def _go_back(self) -> None:
        """Go back the way the arm came until the contact is over, and at least BACK steps.

        Raises Refused if the arm is still in contact at the beginning of the log.
        """
        gone = 0.0
        rows = [row[1] for row in self.log.rows]
        way = [self.carrier.joints()]
        for row in reversed(rows):
            if self._steps(row - way[-1]) >= 1.0:
                way.append(row)
        way.append(rows[0])
        for here, there in itertools.pairwise(way):
            gone += self._steps(there - here)
            self._go(there, stops=False)
            if gone >= _LEAST_STEPS_BACK and not self.log.rows[-1][2]:
                return
        if self.log.rows[-1][2]:
            back = gone * STEP_IN_CELLS * self.explorer.filler.size
            raise Refused(rules.STILL_TOUCHING(back=back), exit_status=1)

    def _rest(self) -> None:
        """Bring the arm to rest."""
        self.carrier.rest()
        if self.carrier.waits:
            return
        end, before = self.clock() + _REST_TIMEOUT, self.carrier.joints()
        while self.clock() < end:
            self.clock.wait(_STANDSTILL_PERIOD)
            now = self.carrier.joints()
            self._note(self.contacts.touching())
            if np.abs(now - before).max() <= _STANDSTILL:
                return
            before = now

    # ------------------------------------------------------------------------------- parts

    def _note(self, touching: bool) -> bool:
        joints = self.carrier.joints()
        self.log.note(self.clock() - self._began, joints, touching, self.guard.robot)
        return touching

    def _steps(self, left: Floats) -> float:
        """Number of steps for joints (a,) that are left; in each no body moves over half a cell."""
        moved = np.abs(left) @ self._lever
        return float(moved.max(initial=0.0)) / (STEP_IN_CELLS * self.explorer.filler.size)

    def _all(self, rows: Floats) -> Floats:
        """Joints (n, j) of all robots of the cell, with the others at home."""
        out = np.tile(self.explorer.home, (len(rows), 1))
        out[:, self.explorer.filler.columns] = rows
        return out

    def _outside(self, joints: Floats) -> str:
        """Which joint is outside its range, in words; empty for none."""
        if self.ranges is None:
            return ""
        off = np.maximum(self.ranges[:, 0] - joints, joints - self.ranges[:, 1])
        worst = int(np.argmax(off))
        if off[worst] <= _STANDSTILL:
            return ""
        low, high = self.ranges[worst]
        axis = self.guard.robot.axes[worst]
        return f"{axis} is at {joints[worst]:.2f}, not between {low:g} and {high:g}"

    @property
    def is_over(self) -> bool:
        """True once the time is over."""
        return self.clock() - self._began > self.seconds
