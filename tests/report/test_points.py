"""Points beside where an arm passed them; where that is is known, as the motion is made here."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.report import figures
from assistant.report.figures import Poses, passed_poses, point_plot


def turned(degrees):
    """Turns about z."""
    half = np.radians(np.asarray(degrees, dtype=float)) / 2.0
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)


def line(x, degrees=None, y=0.0):
    x = np.asarray(x, dtype=float)
    places = np.stack([x, np.full_like(x, y), np.zeros_like(x)], axis=-1)
    return Poses(places, turned(np.zeros_like(x) if degrees is None else degrees))


def test_poses_are_those_between_two_looks():
    points = line([0, 10, 25, 40], [0, 20, 50, 80])
    seen = line([-5, 17, 40], [-10, 34, 80])
    there = passed_poses(points, seen)
    assert there.positions == pytest.approx(points.positions, abs=1e-9)
    assert points.deviation(there) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_the_largest_deviation_is_that_of_the_worst_point():
    points, seen = line([0, 10, 20], [0, 0, 3]), line([0, 10, 20], y=1.5)
    assert points.deviation(passed_poses(points, seen)) == pytest.approx((1.5, 3.0), abs=1e-6)


def test_a_place_that_is_passed_twice_is_that_of_its_turn():
    """There and back: the second point at 10 mm is passed on the way back."""
    points = line([0, 10, 20, 10, 0], [0, 10, 20, 30, 40])
    seen = line([0, 20, 0], [0, 20, 40])
    there = passed_poses(points, seen)
    assert points.deviation(there) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_motion_that_ends_early_is_at_its_end():
    points = line([0, 10, 20])
    assert passed_poses(points, line([0, 12])).positions[:, 0] == pytest.approx([0, 10, 12])
    assert passed_poses(points, line([4])).positions[:, 0] == pytest.approx([4, 4, 4])


def test_an_arm_that_waits_is_no_other_point():
    points = line([0, 10])
    assert passed_poses(points, line([0, 0, 0, 10, 10])).positions[:, 0] == pytest.approx([0, 10])


def test_the_sign_of_a_quaternion_is_not_drawn():
    points = line([0.0, 500.0], [0, 90])
    other = Poses(points.positions, -points.quaternions)
    one, two = (point_plot(points, {"arm": arm}, "title", format="svg") for arm in (points, other))
    assert b"<svg" in one and one == two


@pytest.mark.parametrize(("unit", "most"), [("mm", 500.0), ("m", 0.5)])
def test_positions_are_drawn_in_the_unit_that_is_asked_for(unit, most, monkeypatch):
    kept = []
    monkeypatch.setattr(figures, "picture", lambda figure, _: kept.append(figure) or b"")
    point_plot(line([0.0, 500.0]), {"arm": line([0.0, 500.0])}, "title", unit=unit)
    upper = kept[0].axes[0]
    assert upper.get_ylabel() == f"position of the TCP in {unit}"
    assert upper.get_lines()[0].get_xdata().tolist() == [1.0, 2.0]
    assert upper.get_lines()[0].get_ydata().tolist() == [0.0, most]
