"""What an arm may do: speeds, accelerations, ends of axes, the box of the tool."""

from __future__ import annotations

import numpy as np
import pytest

from assistant import robots
from assistant.base.diagnostics import Refused
from assistant.controllers.cyclic.setpoint_source import (
    Corrections,
    CorrectionSource,
    Job,
    correction_line,
)
from assistant.controllers.cyclic.setpoint_source import Settings as CyclicSettings
from assistant.program.geometry import Pose
from assistant.vision.servoing.bounds import Bounds, Guard
from assistant.vision.servoing.interaction import flange_of
from assistant.vision.servoing.servo_loop import ServoSettings

ARM = robots.get("rv-2aj")
TIP = Pose((0.0, 0.0, 100.0))


def test_whatever_is_wanted_the_limits_hold():
    """Velocities by chance, larger than can be, for most of a minute of the arm."""
    box = ((150.0, -120.0, 200.0), (400.0, 160.0, 420.0))
    bounds = Bounds(speed=150.0, turning=60.0, part=0.2, to_speed=0.25, box=box)
    guard, rng, each = Guard(ARM, bounds, TIP), np.random.default_rng(2), 0.05
    joints = np.array([10.0, 25.0, 85.0, 70.0, 15.0])
    speed, track, speeds = np.zeros(5), [joints], [np.zeros(5)]
    for k in range(900):
        if k % 12 == 0:
            wanted = rng.uniform(-2.0, 2.0, 5) * ARM.speeds
        speed = guard.limited(wanted, speed, joints, each)
        joints = joints + speed * each
        track.append(joints)
        speeds.append(speed)
    found, turning = np.array(track), np.array(speeds)
    low, high = ARM.limits.T
    assert (found >= low).all() and (found <= high).all()
    assert (np.abs(turning) <= 0.2 * ARM.speeds + 1e-9).all()
    tips = np.array([(flange_of(ARM, row) @ TIP).position for row in found])
    assert (tips >= np.array(box[0]) - 1e-6).all() and (tips <= np.array(box[1]) + 1e-6).all()
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1) / each
    assert 140.0 < steps.max() <= 150.0 * 1.001
    assert np.ptp(found, axis=0).min() > 10.0, "it moved"


def test_an_axis_brakes_before_its_end():
    guard, each = Guard(ARM, Bounds(part=0.2, margin=1.0), TIP), 0.03
    joints, speed, rises = np.array([140.0, 0.0, 90.0, 60.0, 0.0]), np.zeros(5), []
    for _ in range(400):
        before = speed
        speed = guard.limited(np.array([90.0, 0.0, 0.0, 0.0, 0.0]), speed, joints, each)
        rises.append(np.abs(speed - before).max() / each)
        joints = joints + speed * each
    assert joints[0] == pytest.approx(149.0, abs=0.02)
    assert max(rises) <= guard.rises[0] * 1.35
    assert guard.barred == "the end of J1"


@pytest.mark.parametrize("given", [{"speed": 0.0}, {"part": 2.0}, {"to_speed": 0.0}])
def test_bounds_that_cannot_be(given):
    with pytest.raises(Refused) as refused:
        Bounds(**given)
    assert [finding.code for finding in refused.value.findings] == ["VS209"]
    with pytest.raises(Refused):
        Bounds(box=((0.0, 0.0, 0.0), (10.0, -1.0, 10.0)))
    with pytest.raises(Refused):
        ServoSettings(gain=-1.0)


# ----------------------------------------------------------------- corrections in each cycle


SPEEDS, RISES, CYCLE = (40.0, 60.0), (160.0, 300.0), 0.004


def led(corrections, cycles, *, until=10**9, give=lambda k: None):
    """(n, 2) what is commanded in each cycle. give: cycle → seconds and a row, or None."""
    empty = np.zeros((0, 2))
    job = Job(
        "joints", empty, SPEEDS, RISES, CyclicSettings(), corrections, (-30.0, -50.0), (30.0, 50.0)
    )
    way, rows = CorrectionSource(job), []
    way.begin((0.0, 0.0), CYCLE)
    for k in range(cycles):
        if (given := give(k)) is not None:
            corrections.take(correction_line(given[1], given[0]))
        rows.append(way.next(k < until))
    return np.array(rows), way


def test_corrections_by_chance_keep_speed_acceleration_and_range():
    rng = np.random.default_rng(4)

    def give(k):
        return (rng.uniform(0.0, 0.1), rng.uniform(-90.0, 90.0, 2)) if k % 9 == 0 else None

    rows, _ = led(Corrections(), 20_000, give=give)
    speeds = np.diff(rows, axis=0) / CYCLE
    rises = np.diff(speeds, axis=0) / CYCLE
    assert (np.abs(rows) <= np.array([30.0, 50.0]) + 1e-9).all()
    assert (np.abs(speeds) <= np.array(SPEEDS) + 1e-9).all()
    assert (np.abs(rises) <= np.array(RISES) * 1.01 + 1e-6).all()
    assert np.ptp(rows, axis=0).min() > 40.0, "it moved"


def test_it_comes_to_rest_at_the_last_correction_and_at_once_when_told():
    rows, way = led(Corrections(), 800, give=lambda k: (0.5, (6.0, -9.0)) if k == 0 else None)
    assert (
        np.allclose(rows[-1], (6.0, -9.0), atol=0.01) and np.abs(rows[-1] - rows[-2]).max() < 1e-4
    )
    on_the_way = [(0.5, (20.0, 0.0)), (0.0, (0.0, 0.0))]
    rows, way = led(
        Corrections(),
        300,
        give=lambda k: on_the_way[0] if k == 0 else on_the_way[1] if k == 60 else None,
    )
    assert way.stands and rows[60, 0] < rows[-1, 0] < rows[60, 0] + 40.0**2 / (2.0 * 160.0) + 0.5
    rows, way = led(Corrections(), 300, until=60, give=lambda k: on_the_way[0] if k == 0 else None)
    assert way.stands and 0.0 < rows[-1, 0] < 20.0


def test_lines_that_come_in_pieces_are_put_together():
    corrections = Corrections()
    text = b"\n" + correction_line((1.0, -2.5), 0.03) + b"\n"
    for k in range(len(text)):
        corrections.take(text[k : k + 1])
    assert corrections.count == 1 and corrections.newest == (0.03, (1.0, -2.5))
    corrections.take(b"0.1 nan 2\n")
    assert corrections.count == 1
