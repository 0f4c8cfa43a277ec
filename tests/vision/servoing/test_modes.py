"""Each way to lead an arm: it comes to its goal, keeps its limits, and stops when sight is lost.

What the arm did is looked at in the virtual controller's own record.
"""

from __future__ import annotations

import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from assistant.base import rotations
from assistant.vision.servoing.bounds import Bounds
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.servo_loop import ServoSettings, ServoStopped, lead_to, servo
from assistant.vision.servoing.simulation import Clock
from tests.vision.servoing.scenes import MODES_BY_NAME, TIP

SLOW = ("jog", "mxt", "exchange")
ALL = [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in MODES_BY_NAME]
AWAY = {
    "five": np.array([9.0, -6.0, 5.0, -8.0, 14.0]),
    "six": np.array([9.0, -6.0, 5, 6, -8, 14.0]),
}
SETTINGS = ServoSettings(timeout=60.0, stale=1.0)


@contextmanager
def led(name, folder):
    """A scene with a box that is hardly larger than the way, and an arm that is led in it."""
    make, over = MODES_BY_NAME[name]
    scene = make()
    tip = np.array((scene.flange @ TIP).position)
    box = (tuple((tip - 90.0).tolist()), tuple((tip + 90.0).tolist()))
    bounds = Bounds(*(250.0, 120.0) if name == "egm" else (600.0, 240.0), part=0.4, box=box)
    scene = replace(scene, bounds=bounds)
    more = (folder / "home",) if name == "exchange" else ()
    with over(scene, *more) as (carrier, joints, kept):
        yield scene, carrier, joints, kept


def begin(scene, carrier):
    """At a start that is some way from the goal, without looking at limits on the way there."""
    away = AWAY["five" if len(scene.goal_joints) == 5 else "six"]
    free = replace(scene, bounds=replace(scene.bounds, box=None))
    start = flange_of(scene.robot, scene.goal_joints + 0.7 * away) @ TIP
    lead_to(start, carrier, free.guard, ServoSettings(distance=1.0, turn=2.0, gain=4.0, share=0.7))


@pytest.mark.parametrize("name", ALL)
def test_it_stops_when_sight_is_lost_and_comes_to_its_goal_within_its_limits(name, tmp_path, tell):
    with led(name, tmp_path) as (scene, carrier, joints, kept):
        begin(scene, carrier)
        kept.rows.clear()
        lost = Lost(joints)
        eyes = scene.eyes("pose in hand", joints, hidden=lost)
        law = scene.law("pose in hand")
        with pytest.raises(ServoStopped) as broken:
            servo(eyes, law, carrier, scene.guard, SETTINGS, clock=Clock())
        check_lost(broken.value, lost.at)
        check_rest(scene, carrier, joints, broken.value)

        eyes = scene.eyes("pose in hand", joints, seed=5)
        law = scene.law("pose in hand")
        served = servo(eyes, law, carrier, scene.guard, SETTINGS, clock=Clock())
        away, turn = scene.off(joints())
        tell(f"{name}: {served.pictures} pictures, {away:.2f} mm and {turn:.2f} degrees left")
        assert away < 1.0 and turn < 1.0
        check_limits(scene, kept)


class Lost:
    """Hides the target from the seventh picture on, once the arm has moved, however long a busy
    computer takes for that. at: the first picture without it.
    """

    def __init__(self, joints):
        self.joints, self.start, self.at = joints, np.array(joints()), None

    def __call__(self, number):
        if self.at is None and number >= 7:
            moved = np.abs(np.array(self.joints()) - self.start).max()
            self.at = number if moved > 2.0 else None
        return self.at is not None


def check_lost(broken, lost_at):
    """By the log: the loop is over at the second picture without a sight, and asked for no more
    motion from the first one on.
    """
    assert [finding.code for finding in broken.findings] == ["VS202"]
    columns = broken.served.columns
    seen, pictures = columns["seen"], columns["picture"]
    assert (seen[pictures < lost_at] == 1.0).all() and pictures[-1] == lost_at + 1
    assert (seen == 0.0).sum() == 2 and (seen[-2:] == 0.0).all()
    speeds = np.stack([columns[name] for name in columns if name.startswith("velocity.")])
    assert (speeds[:, seen == 0.0] == 0.0).all()
    told = np.stack([columns[name] for name in columns if name.startswith("told.")])
    assert np.abs(told[:, -1] - told[:, 0]).max() > 1.0, "it moved until then"


def check_rest(scene, carrier, joints, broken):
    """By the virtual arm itself: it comes to rest by what a step and its brakes take, no farther,
    and what the sight did not tell is not gone to.
    """
    before = broken.served.columns
    told = np.array([before[f"told.{axis}"][-1] for axis in scene.robot.axes])
    last, now = told + 1.0, np.array(joints())
    while np.abs(now - last).max() > 1e-3:
        time.sleep(0.1)
        last, now = now, np.array(joints())
    speeds = np.minimum(scene.guard.speeds, carrier.speeds)
    room = speeds * carrier.period + speeds**2 / (2.0 * scene.guard.rises)
    assert (np.abs(now - told) <= room + 0.1).all()


def check_limits(scene, kept):
    """In the record of the virtual arm: ends of axes and the box, by the arm's own kinematics.

    A tip may go straight through the joints (`Mov`) or behind a servo: half a mm more.
    """
    rows = kept.joints()
    assert len(rows) > 5
    low, high = scene.robot.limits.T
    assert (rows >= low).all() and (rows <= high).all()
    places, turns = scene.robot.fk(rows)
    tips = places + rotations.rotate(turns, np.array(TIP.position))
    least, most = map(np.array, scene.bounds.box)
    assert (tips >= least - 0.5).all() and (tips <= most + 0.5).all()
