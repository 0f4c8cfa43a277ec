"""Contours as CAD systems export them: stops where they truly turn, and nowhere else.

Looked at is the emitted text; the arithmetic is that of the tests.
"""

import numpy as np
import pytest

import assistant
from tests.sources.contours import exports
from tests.sources.contours.exports import apart, dense, sheet, shortest_move, ways

TIGHT, USUAL = 0.01, 0.05
RESOLUTION = 1e-3
WIDEST = 6.0
"""Offsets from a corner to the centre of a tool that comes no nearer, in the sharpest of them."""


def compiled(tmp_path, contours, keys, tolerance):
    path = tmp_path / "part.dxf"
    path.write_text(exports.drawing(contours))
    process = f'unit = "mm"\ntolerance = {tolerance}\n[layers.CUT]\nspeed = 30\n{keys}\n'
    path.with_suffix(".process.toml").write_text(process)
    made = assistant.compile(path, language="rapid")
    assert made.ok, [str(f) for f in made.findings]
    assert not {f.code for f in made.findings} & {"CT107", "CT213"}
    # Of a long path the targets are in modules of their own.
    return ways("".join(text.decode() for text in made.files.values()))


def of_contour(contour, found):
    """The way that belongs to a contour."""
    centre = contour.curve.mean(axis=0)
    return min(found, key=lambda way: float(np.hypot(*(way.points.mean(axis=0) - centre))))


def check(contours, found, offset, tolerance):
    """offset: over 0 outside, below 0 inside."""
    assert len(found) == len(contours)
    for contour in contours:
        way = of_contour(contour, found)
        assert shortest_move(way) >= RESOLUTION
        left_turning = _area(contour.curve) > 0.0
        # Beside a corner that turns away from the tool the way is round.
        sharp = [
            point
            for point, left in contour.corners
            if not offset or (left == left_turning) == (offset < 0.0)
        ]
        assert np.hypot(*(way.points[0] - way.points[-1])) < 1e-3
        inside = len(sharp) - (_turn_at_start(way.points) > 60.0)
        if tolerance == TIGHT:  # too tight for any rounding of those corners
            assert len(way.stops) == inside, (contour.corners, way.stops)
            near = [min(np.hypot(*(stop - p)) for p in sharp) for stop in way.stops]
            assert max(near, default=0.0) <= abs(offset) * WIDEST + tolerance
        else:
            assert not len(way.stops)
        off = np.abs(apart(dense(way.points), contour.curve) - abs(offset))
        assert off.max() <= tolerance
        reach = abs(offset) * WIDEST + tolerance
        assert apart(dense(contour.curve), way.points).max() <= reach


def _turn_at_start(points):
    """Degrees."""
    (ax, ay), (bx, by) = points[-1] - points[-2], points[1] - points[0]
    return abs(np.degrees(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)))


def _area(points):
    x, y = points.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


CASES = [
    (keys, offset, tolerance)
    for tolerance in (TIGHT, USUAL)
    for keys, offset in (
        ("", 0.0),
        ('offset = 1.5\nside = "outside"', 1.5),
        ('offset = 1.5\nside = "inside"', -1.5),
    )
]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("keys", "offset", "tolerance"), CASES)
def test_exports_stop_where_they_turn(keys, offset, tolerance, tmp_path):
    contours = sheet(1, 2, tolerance)
    check(contours, compiled(tmp_path, contours, keys, tolerance), offset, tolerance)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 117))
@pytest.mark.parametrize(("keys", "offset", "tolerance"), CASES)
def test_hundreds_of_exports(seed, keys, offset, tolerance, tmp_path):
    contours = sheet(seed, 5, tolerance)
    check(contours, compiled(tmp_path, contours, keys, tolerance), offset, tolerance)
