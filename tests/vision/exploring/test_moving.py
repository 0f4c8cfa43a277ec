"""An arm that explores by moving: where it was is free, and where it touched it goes back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.cell.cell_file import parse_scene
from assistant.cell.collision.model import Model
from assistant.cell.exploration.explorer import Explorer
from assistant.cell.exploration.occupancy import CellState
from assistant.cell.scene import Scene
from assistant.vision.exploration import (
    AnyContacts,
    InputContacts,
    KeyContacts,
    PictureContacts,
    RandomExplorer,
    empty_log,
)
from assistant.vision.servoing.bounds import Bounds, Guard
from assistant.vision.servoing.simulation import IdealArm, SteppedClock

CELL = '[robots.arm]\nrobot = "rv-2aj"\ntool = "gripper"\n'
CELL += "[bodies.gripper]\ncylinder = [25, 58]\nposition = [0, 0, 29]\n"
POST = np.array([260.0, 160.0]), 40.0
"""Position and radius of a cylinder within reach of the arm."""
STANDS = "[bodies.post]\ncylinder = [40, 900]\nposition = [260, 160, 450]\n"
RANGES = np.array([[-60.0, 60.0], [0.0, 60.0], [30.0, 110.0], [-90.0, 90.0], [-90.0, 90.0]])


def scene(text: str) -> Scene:
    return parse_scene(SourceText(text, "cell.toml", "utf-8", "\n"), Path())[0]


class Waiting(IdealArm):
    """Comes back when it stands."""

    waits = True

    def __init__(self, at, speeds, period: float, clock: SteppedClock) -> None:
        super().__init__(at, speeds, period)
        self.ticks = clock

    def move(self, to, seconds: float) -> None:
        super().move(to, seconds)
        self.ticks.wait(0.2)


class Felt:
    """Contacts as a scene has them that the arm knows nothing of; asked: how often."""

    def __init__(self, text: str, carrier: IdealArm) -> None:
        self.model, self.carrier, self.asked = Model(scene(text)), carrier, 0

    def touching(self) -> bool:
        self.asked += 1
        return bool(self.model.nearest(self.carrier.joints()[None])[0][0] <= 0.0)


def wanderer(waits: bool, box=None, ranges=RANGES, speed: float = 100.0) -> RandomExplorer:
    explorer = Explorer(scene(CELL), size=20.0)
    clock = SteppedClock()
    guard = Guard(explorer.placed.robot, Bounds(speed, 30.0, 0.1, box=box))
    made = Waiting if waits else IdealArm
    start = np.array([0.0, 10.0, 80.0, 40.0, 0.0])
    carrier = made(start, guard.speeds, 0.5 if waits else 0.1, clock)
    felt = Felt(CELL + STANDS, carrier)
    log = empty_log(guard)
    return RandomExplorer(explorer, carrier, guard, felt, log, ranges, seed=4, clock=clock)


@pytest.mark.parametrize("waits", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_free_space_is_found_about_an_obstacle_and_none_inside(waits: bool) -> None:
    one = wanderer(waits, speed=250.0)
    one.check()
    one.wander(4)
    assert one.moves == 4 and one.log.contacts >= 1
    assert one.explorer.occupancy.litres > 5.0
    cells = one.explorer.occupancy.cells(CellState.FREE)
    corners = 20.0 * (cells[:, None, :2] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]]))
    place, radius = POST
    deep = np.linalg.norm(corners - place, axis=2).max(axis=1) < radius
    assert not deep.any()
    assert not one.contacts.touching(), "it stands clear in the end"
    joints = np.array([row[1] for row in one.log.rows])
    assert (joints >= RANGES[:, 0] - 0.1).all() and (joints <= RANGES[:, 1] + 0.1).all()
    assert one.contacts.asked >= len(joints)


def test_the_flange_stays_in_the_box_and_is_slow() -> None:
    box = ((100.0, -250.0, 250.0), (400.0, 250.0, 600.0))
    one = wanderer(False, box, None, speed=60.0)
    one.wander(3)
    rows = one.log.recording
    places = np.stack([rows.column(name) for name in ("x_mm", "y_mm", "z_mm")], axis=1)
    assert (places >= np.array(box[0]) - 0.5).all() and (places <= np.array(box[1]) + 0.5).all()
    times = rows.column("seconds")
    far = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert (far <= 63.0 * np.maximum(np.diff(times), 0.1) + 0.1).all()
    assert np.ptp(places, axis=0).max() > 50.0


def refused(call, *arguments: object) -> str:
    with pytest.raises(Refused) as caught:
        call(*arguments)
    return caught.value.findings[0].code


def test_what_moves_nothing() -> None:
    one = wanderer(True)
    one.carrier.at = np.array([70.0, 0.0, 90.0, 0.0, 0.0])
    assert refused(one.check) == "VS221"
    one = wanderer(True, ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    assert refused(one.check) == "VS221"
    one = wanderer(True)
    one.contacts = InputContacts(Inputs([1.0]), "10")
    assert refused(one.check) == "CK456"
    assert len(one.carrier.rows) == 1


def test_a_contact_that_stays_ends_it_at_rest() -> None:
    one = wanderer(True)
    one.contacts = InputContacts(Inputs([0.0] * 6 + [1.0] * 1000), "10")
    assert refused(one.wander, 3) == "VS220"
    assert one.carrier.rested and not np.allclose(one.carrier.rows[-1], one.carrier.rows[-2])
    assert np.allclose(one.carrier.at, one.carrier.rows[0]), "it is back where it began"


def test_the_time_ends_it() -> None:
    one = wanderer(False)
    one.seconds = 3.0
    one.wander(50)
    assert one.is_over and one.moves < 50


class Inputs:
    def __init__(self, values: list[float]) -> None:
        self.values = values

    def inputs(self, names):
        value = self.values.pop(0) if len(self.values) > 1 else self.values[0]
        return dict.fromkeys(names, value)


def test_each_key_is_a_contact_and_q_ends_it() -> None:
    pressed = [b"", b" ", b"x", b"", b"q"]
    key = KeyContacts(lambda _: pressed.pop(0) if pressed else b"", b"q\x1b\x04")
    assert [key.touching() for _ in range(3)] == [False, True, False]
    assert key.ended
    assert not AnyContacts([key, InputContacts(Inputs([0.0]), "1")]).touching()


def test_a_region_that_changes_is_a_contact() -> None:
    still = np.full((40, 60, 3), 100, np.uint8)
    now = [still]
    seen = PictureContacts(lambda: now[0], (10, 10, 30, 30))
    now[0] = still + np.random.default_rng(0).integers(0, 10, still.shape, np.uint8)
    assert not seen.touching()
    aside = still.copy()
    aside[:, 40:] = 0
    now[0] = aside
    assert not seen.touching()
    now[0] = still.copy()
    now[0][12:16, 12:16] = 0
    assert seen.touching() and seen.difference() == pytest.approx(16 / 400)


@pytest.mark.parametrize("waits", [True, False])
def test_a_camera_that_sees_something_move_stops_the_arm(waits: bool) -> None:
    """What the camera looks at changes as soon as the first joint is beyond an angle."""
    one = wanderer(waits)

    def picture():
        shown = np.full((40, 60, 3), 100, np.uint8)
        shown[:10, :10] = 0 if one.carrier.joints()[0] > 8.0 else 100
        return shown

    one.contacts = PictureContacts(picture, (0, 0, 30, 30))
    one.wander(4)
    turned = np.array([row[1][0] for row in one.log.rows])
    assert one.log.contacts >= 1 and 8.0 < turned.max() < 12.0
    assert turned[-1] < 8.0, "it has gone back"


def test_the_arm_keeps_to_the_speeds_of_the_way_it_is_led_by() -> None:
    one = wanderer(False)
    slow = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    carrier = IdealArm(one.carrier.at, slow, 0.1)
    RandomExplorer(
        one.explorer, carrier, one.guard, one.contacts, one.log, RANGES, clock=one.clock
    ).wander(1)
    rows = np.array(carrier.rows)
    assert len(rows) > 10 and (np.abs(np.diff(rows, axis=0)) <= 0.2 * slow + 1e-9).all()
