"""Paths: columns, tables, equality by effect."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from assistant.program.expressions import Name
from assistant.program.geometry import NO_EXTERNAL, Configuration, Target
from assistant.program.motion import (
    FINE,
    UNSTATED,
    Blend,
    Kind,
    Path,
    Speed,
    configuration_of,
    configuration_row,
)
from tests.strategies import configurations, paths
from tests.tables import every_row

TURN = [1.0, 0.0, 0.0, 0.0]


def seam(**changes: object) -> Path:
    given = {
        "speeds": [Speed(100.0), Speed(50.0)],
        "speed": [0, 1, 0],
        "kinds": [Kind.LINEAR, Kind.VIA, Kind.END],
    }
    return Path.of("seam", [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [TURN] * 3, **{**given, **changes})  # type: ignore[arg-type]


def test_missing_columns_hold_for_every_row() -> None:
    path = seam()
    assert len(path) == 3
    assert path.tools == ("tool0",) and path.frames == ("base",) and path.blends == (FINE,)
    assert path.tool.tolist() == [0, 0, 0] and path.tool.dtype == np.int32
    assert path.configurations.shape == (3, 6) and (path.configurations[:, 0] == UNSTATED).all()
    assert path.external.shape == (3, 6) and np.isnan(path.external).all()
    assert path.target(1) == Target(path.pose(1), None, NO_EXTERNAL)


@every_row(
    "changes",
    [
        {"speed": [0, 2, 0]},
        {"speed": [0, -1, 0]},
        {"speed": [0, 1]},
        {"tool": 1},
        {"speeds": []},
        {"kinds": [1, 1]},
        {"configurations": np.zeros((2, 6))},
        {"external": np.zeros((3, 5))},
    ],
)
def test_columns_that_do_not_fit_are_refused(changes: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"index has no row|broadcast|shape|remapped"):
        seam(**changes)


def test_positions_and_quaternions_are_of_one_length() -> None:
    with pytest.raises(ValueError, match="2 positions but 1 quaternions"):
        Path.of("a", [[0, 0, 0], [1, 0, 0]], [TURN], speeds=[Speed(1.0)])


def test_a_path_of_no_rows_needs_no_tables() -> None:
    empty = Path.of("a", [], [], speeds=[], blends=[], tools=[], frames=[])
    assert len(empty) == 0 and empty == Path.of("a", [], [], speeds=[Speed(1.0)])
    assert empty.differing_rows(seam(), "speed").size == 0


def test_equality_is_of_effect_not_of_tables() -> None:
    swapped = seam(speeds=[Name("unused"), Speed(50.0), Speed(100.0)], speed=[2, 1, 2])
    assert seam() == swapped and hash(seam()) == hash(swapped)
    assert seam() != seam(speed=[0, 0, 0])
    assert seam() != seam(blends=[Blend(1.0)])
    assert seam() != seam(tools=["gripper"])
    assert seam() != seam(frames=["table"])
    assert seam() != seam(kinds=Kind.LINEAR)
    assert seam() != seam(external=[0.0, *[np.nan] * 5])
    assert seam() != seam(configurations=configuration_row(Configuration()))
    assert seam() != seam().rows(0, 2)
    assert seam() != seam().rows(0, 3, "other")
    assert seam() != "seam"


def test_rows_that_differ_are_told() -> None:
    other = seam(speeds=[Speed(50.0), Speed(100.0)], speed=[1, 1, 1])
    assert seam().differing_rows(other, "speed").tolist() == [1]


@settings(deadline=None)
@given(paths())
def test_a_cut_path_has_the_rows_of_the_whole(path: Path) -> None:
    middle = len(path) // 2
    parts = path.rows(0, middle, "first"), path.rows(middle, len(path), "second")
    assert [len(part) for part in parts] == [middle, len(path) - middle]
    targets = [part.target(i) for part in parts for i in range(len(part))]
    assert targets == [path.target(i) for i in range(len(path))]
    assert path.rows(0, len(path)) == path


@given(configurations())
def test_a_configuration_is_a_row(configuration: Configuration) -> None:
    row = np.array(configuration_row(configuration), dtype=np.int8)
    assert configuration_of(row) == configuration
    assert configuration_of(np.array(configuration_row(None), dtype=np.int8)) is None


def test_quaternions_can_be_made_unit() -> None:
    path = Path.of("a", [[0, 0, 0]], [[-2.0, 0, 0, 0]], speeds=[Speed(1.0)])
    assert path.with_unit_quaternions().quaternions.tolist() == [TURN]
