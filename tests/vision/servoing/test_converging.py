"""Servoing as a closed loop: with ideal arms, and with virtual controllers over real sockets.

The arm tells where it ends; pictures are exact projections of it with noise.
"""

from __future__ import annotations

import numpy as np
import pytest

from assistant.base import rotations
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.servo_loop import ServoSettings, lead_to, servo
from assistant.vision.servoing.simulation import Clock, IdealArm, SteppedClock
from tests.vision.servoing.scenes import TIP, by_controller, five_axes, over_egm, six_axes

LAWS = ("image in hand", "pose in hand", "image to hand", "pose to hand")


def led(scene, carrier, joints, kept, name, number, rng):
    """mm and degrees that are left behind a random start, by the virtual arm itself."""
    begin = scene.start(name, rng)
    lead_to(flange_of(scene.robot, begin) @ TIP, carrier, scene.guard)
    first = scene.off(joints())
    served = servo(
        scene.eyes(name, joints, seed=number), scene.law(name), carrier, scene.guard, clock=Clock()
    )
    return (*first, *scene.off(joints()), served.seconds)


def told(title, rows):
    found = np.array(rows)
    mean, worst = found[:, 2:4].mean(axis=0), found[:, 2:4].max(axis=0)
    return (
        f"{title}: {len(found)} of {len(found)} random starts came to {mean[0]:.2f} mm and "
        f"{mean[1]:.2f} degrees in the mean, {worst[0]:.2f} mm and {worst[1]:.2f} at worst, from "
        f"{found[:, 0].mean():.0f} mm and {found[:, 1].mean():.0f} degrees away in "
        f"{found[:, 4].mean():.1f} s"
    )


def held(scene, kept):
    """That the virtual arm kept ends and box, by its own record and its own kinematics."""
    rows = kept.joints()
    low, high = scene.robot.limits.T
    assert (rows >= low).all() and (rows <= high).all()
    if scene.bounds.box is not None:
        least, most = map(np.array, scene.bounds.box)
        places, turns = scene.robot.fk(rows)
        tips = places + rotations.rotate(turns, np.array(TIP.position))
        assert (tips >= least - 0.5).all() and (tips <= most + 0.5).all()


def runs(scene, carrier, joints, kept, count, seed):
    rng, rows = np.random.default_rng(seed), []
    for number in range(count):
        name = LAWS[number % len(LAWS)]
        rows.append(led(scene, carrier, joints, kept, name, number, rng))
        assert rows[-1][2] < 2.0 and rows[-1][3] < 1.5, (name, number, rows[-1])
    held(scene, kept)
    return rows


def imagined(scene, name, number, rng, late=0.0):
    """The same with an arm that takes the time of its steps, in a time that nobody waits for.

    late: seconds by which each picture comes, while the arm goes on.
    """
    begin, clock = scene.start(name, rng), SteppedClock()
    arm = IdealArm(begin, scene.guard.speeds, clock=clock)
    eyes = scene.eyes(name, arm.joints, seed=number, clock=clock, delay=lambda _: late)
    settings = ServoSettings(stale=1.0, timeout=20.0)
    served = servo(eyes, scene.law(name), arm, scene.guard, settings, clock=clock)
    return (*scene.off(begin), *scene.off(arm.joints()), served.seconds)


@pytest.mark.parametrize("make", [five_axes, six_axes])
def test_pictures_that_come_late_are_of_where_the_arm_was_then(make, tell):
    scene, rng = make(), np.random.default_rng(5)
    for name in LAWS:
        row = imagined(scene, name, 0, rng, late=0.4)
        assert row[2] < 1.5 and row[3] < 1.0, (name, row)
        tell(told(f"{scene.robot.name}, {name}, pictures 0.4 s late", [row]))


class Stepping(IdealArm):
    """It is where it was told to be when a step ends, and stands there until the next one."""

    waits = True

    def move(self, to, seconds):
        super().move(to, seconds)
        self._clock.wait(seconds)


def test_an_arm_that_waits_stood_still_when_a_picture_was_taken():
    """Pictures take their time, in which it does not move: few steps bring it to its goal."""
    scene, rng = five_axes(), np.random.default_rng(7)
    begin, clock = scene.start("image in hand", rng), SteppedClock()
    arm = Stepping(begin, scene.guard.speeds, period=0.2, clock=clock)
    eyes = scene.eyes("image in hand", arm.joints, clock=clock, delay=lambda _: 1.0)
    settings = ServoSettings(gain=10.0, share=0.95, stale=1.5, timeout=100.0)
    servo(eyes, scene.law("image in hand"), arm, scene.guard, settings, clock=clock)
    assert scene.off(arm.joints())[0] < 1.5
    assert len(arm.rows) < 12


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("make", [five_axes, six_axes])
def test_each_law_comes_to_its_goal_from_a_hundred_random_starts(make, name, tell):
    scene, rng = make(), np.random.default_rng(6)
    rows = [imagined(scene, name, number, rng) for number in range(100)]
    tell(told(f"{scene.robot.name}, {name}", rows))
    assert max(row[2] for row in rows) < 2.0 and max(row[3] for row in rows) < 1.5


@pytest.mark.slow
def test_a_hundred_random_starts_over_data_link(tell):
    scene = five_axes()
    with by_controller(scene, "data-link") as (carrier, joints, kept):
        tell(told("RV-2AJ, data link control", runs(scene, carrier, joints, kept, 100, 3)))


@pytest.mark.slow
def test_a_hundred_random_starts_by_egm(tell):
    scene = six_axes()
    with over_egm(scene, scene.goal_joints) as (carrier, joints, kept):
        tell(told("IRB 1200, EGM", runs(scene, carrier, joints, kept, 100, 4)))
