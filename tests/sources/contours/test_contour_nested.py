"""Tools beside random nested contours: nothing is gouged, and each hole comes before its outline.

Looked at is the emitted text; the arithmetic is pyclipper's and that of the tests.
"""

import numpy as np
import pytest

import assistant
from tests.sources.contours.nested import area, distances, followed, forbidden, gouges, nested

PROCESS = """
[motion]
speed = 50

[layers.CUT]
offset = 3
way_round = "climb"
lead_in = {arc = 2}
lead_out = {line = 2, angle = 60}
overlap = 4
"""
RADIUS, GOUGE, OVERLAP = 3.0, 0.05, 4.0


def ways_of(tmp_path, document, process=PROCESS):
    drawing = tmp_path / "nested.dxf"
    document.saveas(drawing)
    drawing.with_suffix(".process.toml").write_text(process)
    compiled = assistant.compile(drawing, language="rapid")
    assert compiled.ok, [str(f) for f in compiled.findings]
    (text,) = compiled.files.values()
    return followed(text.decode())


def check(drawn, ways):
    assert len(ways) == len(drawn)
    zone = forbidden([d.outline for d in drawn], RADIUS - GOUGE)
    corners = [(d.outline.min(axis=0), d.outline.max(axis=0)) for d in drawn]
    order = {}
    for place, way in enumerate(ways):
        assert gouges(way, zone) == []
        # The contour that most of the way is a radius away from.
        middle = way[len(way) // 4 :: max(len(way) // 30, 1), :2]
        near = [
            row
            for row, (low, high) in enumerate(corners)
            if (low - 2 * RADIUS <= middle.min(axis=0)).all()
            and (high + 2 * RADIUS >= middle.max(axis=0)).all()
        ]
        closed = {row: np.vstack([drawn[row].outline, drawn[row].outline[:1]]) for row in near}
        beside = {row: abs(distances(middle, closed[row]) - RADIUS) <= GOUGE for row in near}
        row = max(beside, key=lambda r: beside[r].sum())
        assert beside[row].sum() >= 3
        assert row not in order
        order[row] = place
        one = drawn[row]
        # The contour is met, but for corners that the tool is too round for.
        along = 0.5 * (one.outline + np.roll(one.outline, -1, axis=0))
        assert (distances(along, way[:, :2]) <= RADIUS + GOUGE).mean() > 0.5
        inside = one.depth % 2 == 1
        # Climbing, what stays is on the right: clockwise outside, anticlockwise in holes.
        assert (area(way) > 0.0) == inside
        # It begins and ends in what is cut away, farther from the contour than it runs.
        for end in (way[:1, :2], way[-1:, :2]):
            assert distances(end, closed[row])[0] > RADIUS + GOUGE
    for row, one in enumerate(drawn):
        if one.holder >= 0:
            assert order[row] < order[one.holder]


@pytest.mark.slow
def test_no_gouge_and_each_hole_before_its_outline(tmp_path):
    drawn, document = nested(1, 30)
    assert {d.depth for d in drawn} >= {0, 1, 2}
    check(drawn, ways_of(tmp_path, document))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 7))
def test_two_hundred_nested_contours(seed, tmp_path):
    drawn, document = nested(seed, 200)
    check(drawn, ways_of(tmp_path, document))
