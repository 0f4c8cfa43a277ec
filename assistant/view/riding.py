"""Bodies that the arm takes and lets go on the way that a page plays: what each rides on, when."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from assistant.cell.clearances import CarriedBodies, carried_stretches, takeable
from assistant.cell.collision.model import Carriers, carrier_of
from assistant.cell.scene import Body, Scene
from assistant.program.geometry import Pose
from assistant.robots.timing import Simulation
from assistant.view.stages import motion_stages

MOST_RIDE_STAGES: Final = 40_000
"""Stretches of moves that are looked at; where bodies are behind them the page does not tell."""

Ride = tuple[int, Pose] | None
"""The carrier of a body and its pose on it; None where only running the program tells."""


def rides_of(
    simulation: Simulation, scene: Scene, until: float
) -> Mapping[str, list[tuple[float, Ride]]]:
    """What each body rides on, by seconds, of those that do not stay where they are at first.

    simulation: of a program that carries, with the `Holding` of the scene. until: seconds that are
    played.
    """
    if not takeable(scene):
        return {}
    carriers = Carriers(scene.robots)
    at: dict[str, list[tuple[float, Ride]]] = {
        name: [(0.0, ride)] for name, ride in _all_bodies(scene, scene, carriers).items()
    }
    known: dict[CarriedBodies, Mapping[str, Ride]] = {}
    for time, holding in _carried_bodies(simulation, until):
        riding: Mapping[str, Ride]
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
    """What is carried from when on; None from where nobody looks any more."""
    known: dict[int, list[tuple[float, CarriedBodies]]] = {}
    for number, (start, passed) in enumerate(motion_stages(simulation, until)):
        if number >= MOST_RIDE_STAGES:
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


def _all_bodies(scene: Scene, now: Scene, carriers: Carriers) -> Mapping[str, Ride]:
    """The bodies of a scene as they are in that of a moment, which lacks those that are lost."""
    return {body.name: _ride_of(now, now.body(body.name), carriers) for body in scene.bodies}


def _ride_of(now: Scene, body: Body | None, carriers: Carriers) -> Ride:
    """None also for what stands in a body that is lost."""
    upper = body
    while upper is not None and upper.parent not in carriers.names | now.frames.keys():
        upper = now.body(upper.parent)
    return None if body is None or upper is None else carrier_of(now, body, carriers)
