"""Maps of explored space: runs, merging, comparing, files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant.base.arrays import Ints
from assistant.base.diagnostics import Refused, Unreadable
from assistant.cell.exploration.known_space import boxes_of
from assistant.cell.exploration.occupancy import (
    CellState,
    Comparison,
    Occupancy,
    cells_of_keys,
    keys_of,
    load_map,
    save_map,
)


def line(start: int, stop: int) -> Ints:
    """Keys of the cells (start, 0, 0) to before (stop, 0, 0)."""
    return keys_of(np.array([[x, 0, -7] for x in range(start, stop)]).reshape(-1, 3))


def a_map(*runs: tuple[Ints, Ints], size: float = 10.0, robot: str = "arm") -> Occupancy:
    out = Occupancy.unknown(size, robot)
    for filled, touched in runs:
        out = out.with_run(filled, touched)
    return out


def test_cells_and_their_numbers() -> None:
    cells = np.random.default_rng(1).integers(-(1 << 20), 1 << 20, (1000, 3))
    assert (cells_of_keys(keys_of(cells)) == cells).all()
    ordered = cells[np.lexsort(cells.T[::-1])]
    assert (np.diff(keys_of(ordered)) >= 0).all()


def test_runs_are_counted_and_the_last_one_holds() -> None:
    known = a_map((line(0, 4), line(4, 5)), (line(2, 6), line(0, 1)))
    assert known.states(cells_of_keys(line(-1, 7))).tolist() == [0, 2, 1, 1, 1, 1, 1, 0]
    assert known.filled.tolist() == [1, 1, 2, 2, 1, 1]
    assert known.touched.tolist() == [1, 0, 0, 0, 1, 0]
    assert known.runs == 2
    assert known.counts() == {CellState.FREE: 5, CellState.OCCUPIED: 1}
    assert known.litres == 5 * 1e3 / 1e6
    points = np.array([[15.0, 5.0, -65.0], [5.0, 5.0, -65.0], [15.0, 5.0, -75.0]])
    assert known.at(points).tolist() == [CellState.FREE, CellState.OCCUPIED, CellState.UNKNOWN]


def test_what_one_map_has_occupied_is_so_in_both() -> None:
    one, other = a_map((line(0, 4), line(9, 10))), a_map((line(3, 6), line(2, 3)))
    both = one.merged(other)
    assert both.states(cells_of_keys(line(0, 10))).tolist() == [1, 1, 2, 1, 1, 1, 0, 0, 0, 2]
    assert both.runs == 2 and both.filled.tolist() == [1, 1, 1, 2, 1, 1, 0]
    swapped = other.merged(one)
    assert (both.keys == swapped.keys).all() and (both.free == swapped.free).all()
    assert one.compared(other) == Comparison(same=1, gained=2, lost=3, freed=0, blocked=1)
    assert other.compared(one).freed == 1


def test_maps_of_other_grids_do_not_fit() -> None:
    for other in (a_map(size=5.0), a_map(robot="other")):
        for asked in (a_map().merged, a_map().compared):
            with pytest.raises(Refused) as refused:
                asked(other)
            assert refused.value.findings[0].code == "CK452"
    for size in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(Refused) as refused:
            a_map(size=size)
        assert refused.value.findings[0].code == "CK458"


def test_a_file_gives_the_map_back(tmp_path: Path) -> None:
    far = keys_of(np.array([[(1 << 20) - 1, 5, -(1 << 20)], [-(1 << 20), 0, 3]]))
    known = a_map((line(0, 4), line(4, 5)), (np.sort(far), line(0, 1)), size=7.3)
    save_map(known, tmp_path / "arm.npz")
    again = load_map(tmp_path / "arm.npz")
    assert (again.size, again.robot, again.runs) == (7.3, "arm", 2)
    for name in ("keys", "filled", "touched", "free"):
        one, other = getattr(known, name), getattr(again, name)
        assert one.dtype == other.dtype and one.tolist() == other.tolist()


def columns(**other: object) -> dict[str, np.ndarray]:
    """The arrays of a file with two cells, some of them others; None leaves one out."""
    plain: dict[str, object] = {
        "kind": "explored space",
        "robot": "arm",
        "about": [1.0, 10.0, 3.0],
        "keys": [[0, 0], [4, 5]],
        "filled": [1, 2],
        "touched": [0, 0],
        "free": [1, 1],
    }
    return {k: np.array(v) for k, v in (plain | other).items() if v is not None}


@pytest.mark.parametrize(
    ("other", "code"),
    [
        ({"kind": "points"}, "CK450"),
        ({"robot": None}, "CK450"),
        ({"about": [2.0, 10.0, 3.0]}, "CK451"),
        ({"about": [1.0, 0.0, 3.0]}, "CK450"),
        ({"about": [1.0, float("nan"), 3.0]}, "CK450"),
        ({"about": None}, "CK450"),
        ({"filled": None}, "CK450"),
        ({"filled": [1, 2, 3]}, "CK450"),
        ({"filled": [1.5, 2.0]}, "CK450"),
        ({"touched": [-1, 0]}, "CK450"),
        ({"keys": [[0, 0], [5, 4]]}, "CK450"),
        ({"keys": [[0, 0], [4, 4]]}, "CK450"),
        ({"keys": [4, 5]}, "CK450"),
        ({"keys": [[0, 0], [4, 2**40]]}, "CK450"),
        ({"keys": 3.0}, "CK450"),
    ],
)
def test_what_is_no_map_is_told(tmp_path: Path, other: dict[str, object], code: str) -> None:
    np.savez(tmp_path / "good.npz", **columns())  # type: ignore[arg-type]
    assert load_map(tmp_path / "good.npz").runs == 3
    np.savez(tmp_path / "bad.npz", **columns(**other))  # type: ignore[arg-type]
    with pytest.raises((Refused, Unreadable)) as refused:
        load_map(tmp_path / "bad.npz")
    assert refused.value.findings[0].code == code


def test_boxes_hold_the_cells_and_nothing_else() -> None:
    draw = np.random.default_rng(4)
    for share in (0.1, 0.5, 0.9, 0.0, 1.0):
        cells = draw.uniform(size=(7, 8, 9)) < share
        count = np.zeros(cells.shape, dtype=int)
        boxes = boxes_of(cells)
        for (x0, y0, z0), (x1, y1, z1) in boxes.tolist():
            count[x0:x1, y0:y1, z0:z1] += 1
        assert (count == cells).all()
    assert len(boxes) == 1
