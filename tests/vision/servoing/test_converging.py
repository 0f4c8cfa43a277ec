"""Servoing as a closed loop with virtual controllers, over real sockets.

The virtual arm tells where it ends; pictures are exact projections of it with noise.
"""

from __future__ import annotations

import numpy as np
import pytest

from assistant.program import rotations
from assistant.vision.servoing.going import lead_to
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.loop import servo
from assistant.vision.servoing.synthetic import Clock
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


def test_an_arm_of_five_axes_comes_to_its_goal_over_data_link(tell):
    scene = five_axes()
    with by_controller(scene, "data-link") as (carrier, joints, kept):
        tell(told("RV-2AJ, data link control", runs(scene, carrier, joints, kept, 2, 1)))


def test_an_arm_of_six_axes_comes_to_its_goal_by_egm(tell):
    scene = six_axes()
    with over_egm(scene, scene.goal_joints) as (carrier, joints, kept):
        tell(told("IRB 1200, EGM", runs(scene, carrier, joints, kept, 2, 2)))


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
