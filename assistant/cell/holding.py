"""Bodies that a program takes and lets go: where each is as its outputs change."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias

import numpy as np

from assistant.base import rotations
from assistant.base.arrays import Floats
from assistant.cell.collision.carriers import Carriers, carrier_of
from assistant.cell.collision.model import Model
from assistant.cell.scene import FLANGE, WORLD, Body, PlacedRobot, Scene
from assistant.program.geometry import Pose

POSE_DIGITS: Final = 6
"""Digits of a place that is kept, so that rounds of a loop are alike."""

CarriedPlace: TypeAlias = tuple[str, Pose] | None
"""What a body stands in, and its pose there; None if only running the program tells."""


@dataclass(slots=True)
class CarryingDoubts:
    """What was met that makes an answer less than whole. empty: outputs that should have taken
    something, and nothing was there; lost: bodies of which it is not known where they are.
    """

    empty: set[tuple[str, float]] = field(default_factory=set)
    lost: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class CarriedBodies:
    """Where the bodies of a scene are that can be taken, as `Carried` of a simulation.

    robot: the one that takes. places: of `takeable(scene)`, in order.
    """

    scene: Scene = field(compare=False)
    robot: PlacedRobot = field(compare=False)
    places: tuple[CarriedPlace, ...]
    doubts: CarryingDoubts = field(default_factory=CarryingDoubts, compare=False)

    @staticmethod
    def at_first(scene: Scene, robot: PlacedRobot) -> CarriedBodies:
        places = tuple((body.parent, body.pose) for body in takeable(scene))
        return CarriedBodies(scene, robot, places)

    def switched(
        self, name: str, value: float | None, joints: tuple[float, ...] | None
    ) -> CarriedBodies:
        """After an output is set: what it takes and is at the tool goes along with the flange,
        what it lets go stays where it is then.
        """
        places, taken, wanted = list(self.places), False, False
        for number, body in enumerate(takeable(self.scene)):
            place = self.places[number]
            names, lets, low = _named(body.taken), _named(body.released), name.lower()
            if place is None or low not in names | lets:
                continue
            held = place[0] in (self.flange, FLANGE)
            if value is None:
                places[number] = self._lost(body)
            elif held and lets.get(low) == value:
                places[number] = self._moved(place, joints, WORLD) or self._lost(body)
            elif not held and names.get(low) == value:
                wanted = True
                near = None if joints is None else self._near(number, np.array(joints))
                if near is not False:
                    taken = True
                    places[number] = self._moved(place, joints, self.flange) or self._lost(body)
            elif held and names.get(low) == value:
                taken = True
        if wanted and not taken:
            self.doubts.empty.add((name, float(value or 0.0)))
        return replace(self, places=tuple(places))

    def met(self, other: object) -> CarriedBodies:
        """What is elsewhere on one way than on another is lost."""
        assert isinstance(other, CarriedBodies)
        both = zip(takeable(self.scene), self.places, other.places, strict=True)
        places = tuple(a if a == b else self._lost(body) for body, a, b in both)
        return replace(self, places=places)

    @property
    def flange(self) -> str:
        return f"{self.robot.name}.{FLANGE}"

    def scene_now(self) -> Scene:
        """The scene with each body where it is, without those that are lost and what they bear."""
        places = dict(zip((body.name for body in takeable(self.scene)), self.places, strict=True))
        lost = {name for name, place in places.items() if place is None}
        while more := {b.name for b in self.scene.bodies if b.parent in lost} - lost - {*places}:
            lost |= more
        bodies = []
        for body in self.scene.bodies:
            place = places.get(body.name)
            if place is not None:
                bodies.append(replace(body, parent=place[0], pose=place[1]))
            elif body.name not in lost:
                bodies.append(body)
        return replace(self.scene, bodies=tuple(bodies))

    def _lost(self, body: Body) -> CarriedPlace:
        self.doubts.lost.add(body.name)
        return None

    def _rows(self, joints: Floats) -> Floats:
        """(1, j) of all robots, of which the others stand at home."""
        own = [joints if one is self.robot else one.robot.home for one in self.scene.robots]
        return np.concatenate(own)[None]

    def _moved(
        self, place: CarriedPlace, joints: tuple[float, ...] | None, parent: str
    ) -> CarriedPlace:
        """The same place in the world in another frame."""
        if place is None or joints is None:
            return None
        carriers = Carriers(self.scene.robots)
        one = Body("", (), place[1], place[0])
        number, pose = carrier_of(self.scene_now(), one, carriers)
        origins, turns = carriers.at(self._rows(np.array(joints)))
        frames = [
            Pose.of(origins[0, i], rotations.from_matrix(turns[:1, i])[0])
            for i in (number, carriers.names[parent])
        ]
        there = frames[1].inverse() @ frames[0] @ pose
        turn = rotations.canonical(np.array(there.quaternion))
        return parent, Pose.of(np.round(there.position, POSE_DIGITS), np.round(turn, 12))

    def _near(self, number: int, joints: Floats) -> bool:
        """Whether a body is within its margin of what the flange carries."""
        now = self.scene_now()
        name = takeable(self.scene)[number].name
        carriers = Carriers(self.scene.robots)
        moved = carriers.moved_by(carriers.names[self.flange])
        model = Model(replace(now, allowed=frozenset()))
        tools = {
            item.body.name
            for item in model.items
            if carriers.moved_by(item.carrier) == moved and item.body.name != name
        }
        pairs = np.array(
            [
                pair
                for pair in range(len(model))
                for one, other in [(model.items[model.one[pair]], model.items[model.other[pair]])]
                if {one.body.name, other.body.name} - {name} <= tools
                and name in (one.body.name, other.body.name)
            ],
            dtype=np.intp,
        )
        if not len(pairs):
            return False
        found = model.exact(self._rows(joints), np.zeros(len(pairs), dtype=np.intp), pairs)
        return bool((found <= model.margins[pairs]).any())


def _named(said: tuple[str, float] | None) -> dict[str, float]:
    return {} if said is None else {said[0].lower(): said[1]}


def takeable(scene: Scene) -> tuple[Body, ...]:
    """Bodies that an output takes."""
    return tuple(body for body in scene.bodies if body.taken is not None)
