"""Arcs that an export wrote as short sides become arcs again, as close as CT108 reports."""

from __future__ import annotations

import re
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely

from assistant.base.arrays import Floats
from assistant.base.source_text import SourceText
from assistant.program.motion import Kind
from assistant.sources.contours.chains import chain_curves
from assistant.sources.contours.curves import Arc, Line
from assistant.sources.contours.moves import Moves, contour_moves
from assistant.sources.drawing import read
from assistant.sources.process.file import parse_process

TOLERANCE = 0.05


def round_corners(radius: float, sides: int, start: float = 0.0, sweep: float = 360.0) -> Floats:
    angles = np.radians(start + sweep * np.arange(sides + 1) / sides)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def moves_along(corners: Floats, *, closed: bool = True, height: float = 0.0) -> Moves:
    points = [(float(x), float(y), height) for x, y in corners]
    ends = [*points[1:], points[0]] if closed else points[1:]
    lines = [Line(a, b, "0", str(k)) for k, (a, b) in enumerate(zip(points, ends, strict=False))]
    (contour,) = chain_curves(lines, TOLERANCE)[0]
    return contour_moves(contour, TOLERANCE)


def path_of(moves: Moves) -> Floats:
    """Points (n, 2) along moves, near enough for a thousandth of the tolerance."""
    points, here = [moves.start], moves.start
    via = None
    for place, kind in zip(moves.positions, moves.kinds.tolist(), strict=True):
        if kind == Kind.VIA:
            via = place
            continue
        if kind == Kind.END and via is not None:
            arc = Arc.through(here, via, place)
            assert arc is not None
            points += list(arc.at(np.linspace(0.0, 1.0, 400)))
        points.append(place)
        here = place
    return np.array(points)[:, :2]


def off(corners: Floats, moves: Moves, *, closed: bool = True) -> float:
    """Mm between what was drawn and what is followed."""
    drawn = shapely.LineString(np.vstack([corners, corners[:1]]) if closed else corners)
    return float(
        shapely.hausdorff_distance(drawn, shapely.LineString(path_of(moves)), densify=0.02)
    )


SLOT = np.vstack(
    [round_corners(5, 24, -90, 180) + np.array([30, 0]), round_corners(5, 24, 90, 180)]
)
"""Two half circles, each of 24 sides, and two lines."""


@pytest.mark.parametrize(
    ("corners", "arcs", "lines"),
    (
        (round_corners(2, 50)[:-1].round(4), 2, 0),  # the holes of an export
        (SLOT.round(4), 2, 2),
        (round_corners(40, 100)[:-1], 2, 0),  # sides longer than any that thinning takes
    ),
)
def test_chains_of_chords_become_arcs(corners: Floats, arcs: int, lines: int) -> None:
    moves = moves_along(corners)
    assert np.count_nonzero(moves.kinds == Kind.END) == arcs
    assert np.count_nonzero(moves.kinds == Kind.LINEAR) == lines
    assert 0.0 < off(corners, moves) <= moves.deviation + 1e-4 <= 0.5 * TOLERANCE + 1e-4
    assert off(corners, moves) == pytest.approx(moves.deviation, abs=2e-4)


def test_an_open_chain_keeps_its_ends(tmp_path: Path) -> None:
    corners = np.vstack([[(-20.0, 10.0)], round_corners(10, 30, 90, -90), [(10.0, -20.0)]])
    moves = moves_along(corners, closed=False, height=3.0)
    assert moves.kinds.tolist() == [Kind.LINEAR, Kind.VIA, Kind.END, Kind.LINEAR]
    assert moves.start.tolist() == [-20.0, 10.0, 3.0]
    assert moves.positions[-1] == pytest.approx([10.0, -20.0, 3.0])
    assert off(corners, moves, closed=False) <= moves.deviation + 1e-4


@pytest.mark.parametrize(
    "corners",
    (
        round_corners(10, 6)[:-1],  # a hexagon has corners
        round_corners(50, 60)[:-1],  # 0.07 mm between its sides and the circle
        np.array([(0, 0), (10, 0), (10, 10), (0, 10)], dtype=float),
        # Corners off the circle by more than a fifth of the tolerance.
        round_corners(5, 40)[:-1] * np.where(np.arange(40) % 2, 1.0, 1.005)[:, None],
        # A zigzag turns to both sides.
        np.vstack([[(k, 0.02 * (k % 2)) for k in range(30)], [(15, 20)]]),
    ),
)
def test_what_is_no_circle_within_the_tolerance_stays_as_drawn(corners: Floats) -> None:
    moves = moves_along(corners)
    assert not np.count_nonzero(moves.kinds == Kind.END)
    assert off(corners, moves) <= moves.deviation + 1e-6 <= 0.2 * TOLERANCE + 1e-6


@pytest.mark.parametrize("seed", range(6))
def test_random_smooth_chains_stay_within_what_is_told(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = int(random.integers(40, 400))
    angles = 2.0 * np.pi * np.arange(count) / count
    ripples = 1.0 + random.uniform(0.0, 0.1) * np.cos(random.integers(2, 6) * angles)
    stretch = random.uniform(2.0, 30.0, 2)
    corners = np.stack([np.cos(angles), np.sin(angles)], axis=1) * ripples[:, None] * stretch
    moves = moves_along(corners.round(3))
    assert off(corners.round(3), moves) <= moves.deviation + 1e-3 <= 0.5 * TOLERANCE + 1e-3


def test_a_finding_tells_how_far_the_arcs_of_a_drawing_are_off(tmp_path: Path) -> None:
    document = ezdxf.new(units=4)
    for x in (0, 30):
        corners = round_corners(2, 50)[:-1] + np.array([x, 0])
        document.modelspace().add_lwpolyline(corners.round(5).tolist(), close=True)
    path = tmp_path / "a.dxf"
    document.saveas(path)
    made = read(path, parse_process(SourceText("", "x.toml")))
    (told,) = [one for one in made.findings if one.code == "CT108"]
    count, deviation = re.findall(r"[\d.]+", told.message.replace("'0'", ""))[:2]
    # The middle of a side of 50 around a diameter of 4.
    sagitta = 2.0 * (1.0 - np.cos(np.pi / 50))
    assert int(count) == 98
    assert float(deviation) == pytest.approx(sagitta, abs=1e-3)
