"""Labels of a picture cover neither lines nor each other."""

from __future__ import annotations

import numpy as np
import pytest

from assistant.report.label_positions import label_positions

LOW, HIGH = np.zeros(2), np.array([300.0, 200.0])


def boxes(centres: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return centres - 0.5 * sizes, centres + 0.5 * sizes


@pytest.mark.parametrize("seed", range(5))
def test_labels_cover_no_line_no_other_label_and_stay_in_the_picture(seed: int) -> None:
    draw = np.random.default_rng(seed)
    anchors = draw.uniform((20, 20), (280, 180), (25, 2))
    sizes = np.column_stack([draw.choice([6.0, 12.0, 18.0], 25), np.full(25, 8.0)])
    lines = [np.array([a, a + draw.uniform(-60, 60, 2)]) for a in anchors]
    centres = label_positions(anchors, sizes, lines, lines, LOW, HIGH)
    low, high = boxes(centres, sizes)
    assert (low >= LOW).all()
    assert (high <= HIGH).all()
    along = np.linspace(0.0, 1.0, 2000)[:, None]
    points = np.vstack([a + along * (b - a) for a, b in lines])
    covered = [
        int(((points > a) & (points < b)).all(axis=1).sum()) for a, b in zip(low, high, strict=True)
    ]
    assert sum(covered) == 0
    for one in range(25):
        for other in range(one):
            apart = (low[one] >= high[other]) | (high[one] <= low[other])
            assert apart.any()


def test_a_label_is_next_to_its_anchor_where_there_is_room() -> None:
    anchors, sizes = np.array([[100.0, 100.0]]), np.array([[10.0, 8.0]])
    centre = label_positions(anchors, sizes, [anchors], [], LOW, HIGH)
    assert np.linalg.norm(centre - anchors) < 12.0


def test_each_of_many_small_squares_has_its_own_label() -> None:
    square = np.array([[0, 0], [16, 0], [16, 16], [0, 16], [0, 0.0]])
    homes = [square + np.array([20.0 + 18.0 * k, 50.0]) for k in range(12)]
    anchors, sizes = np.array([home[0] for home in homes]), np.tile([10.0, 6.0], (12, 1))
    centres = label_positions(anchors, sizes, homes, homes, LOW, HIGH)
    assert (centres > anchors).all()
    assert (centres < anchors + 16.0).all()


def test_without_room_a_label_is_still_in_the_picture() -> None:
    lines = [np.array([[0.0, y], [40.0, y]]) for y in np.arange(0.0, 40.0, 1.0)]
    anchors, sizes = np.array([[20.0, 20.0]]), np.array([[10.0, 8.0]])
    centre = label_positions(anchors, sizes, [anchors], lines, LOW, np.array([40.0, 40.0]))
    assert ((centre > 4.0) & (centre < 36.0)).all()
