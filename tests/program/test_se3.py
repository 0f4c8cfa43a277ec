"""Poses of spatialmath into columns and back; spatialmath itself says what they are."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.program.geometry import Pose
from assistant.program.motion import Path, Speed
from assistant.program.se3 import columns_of, pose_of, se3_of

spatialmath = pytest.importorskip("spatialmath")
SE3, UnitQuaternion = spatialmath.SE3, spatialmath.UnitQuaternion


def some(count=20):
    return [SE3.Rand() for _ in range(count)]


@pytest.mark.parametrize(("unit", "scale"), [("m", 1000.0), ("mm", 1.0)])
def test_positions_and_turns_are_those_of_spatialmath(unit, scale):
    poses = some()
    positions, turns = columns_of(poses, unit=unit)
    assert positions == pytest.approx(scale * np.array([one.t for one in poses]), abs=1e-12)
    theirs = np.array([UnitQuaternion(one.R).A for one in poses])
    assert np.abs(np.einsum("ij,ij->i", turns, theirs)) == pytest.approx(1.0, abs=1e-12)
    back = se3_of(positions, turns, unit=unit)
    assert np.array(back.A) == pytest.approx(np.array([one.A for one in poses]), abs=1e-12)


def test_one_pose_many_and_matrices_are_the_same():
    poses = some(3)
    many = SE3([one.A for one in poses], check=False)
    stack = np.stack([one.A for one in poses])
    wanted = columns_of(poses, unit="m")
    for given in (many, [many], stack, list(stack)):
        for one, other in zip(columns_of(given, unit="m"), wanted, strict=True):
            assert np.array_equal(one, other)
    single = pose_of(poses[0], unit="m")
    assert single.position == pytest.approx(tuple(wanted[0][0]))
    assert pose_of(poses[0].A, unit="m") == single
    again = se3_of(single.position, single.quaternion, unit="m")
    assert np.abs(again.A - poses[0].A).max() < 1e-12
    with pytest.raises(ValueError, match="one pose"):
        pose_of(poses, unit="m")


@pytest.mark.parametrize("given", [[1.0, 2.0, 3.0], np.eye(3), np.full((4, 4), np.nan), "pose"])
def test_what_is_no_pose_is_refused(given):
    with pytest.raises(ValueError):
        columns_of(given, unit="mm")


def test_the_unit_is_never_guessed():
    for unit, said in (("cm", "TB446"), (None, "TB445")):
        with pytest.raises(Refused, match=said):
            columns_of(SE3(), unit=unit)


def test_every_form_of_a_pose_is_the_same():
    poses = some(3)
    p, q = columns_of(poses, unit="m")
    given = [Pose.of(*row) for row in zip(p, q, strict=True)]
    forms = [
        given,
        (p, q),
        [p.tolist(), q.tolist()],
        np.hstack([p, q]),
        Path.of("p", p, q, speeds=[Speed(9.0)]),
    ]
    forms += [[one.matrix for one in given], list(np.hstack([p, q]))]
    for form in forms:
        for one, wanted in zip(columns_of(form, unit="mm"), (p, q), strict=True):
            assert one == pytest.approx(wanted, abs=1e-12)
    assert columns_of(given)[0] == pytest.approx(p)  # a `Pose` and columns are mm
    assert columns_of((p, q))[0] == pytest.approx(p)
    assert columns_of(given, unit="m")[0] == pytest.approx(p)
    assert columns_of((p, q), unit="m")[0] == pytest.approx(1000.0 * p)
    assert pose_of(given[0]) is given[0]
    assert np.abs(se3_of(given[0], unit="m").A - poses[0].A).max() < 1e-12


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (np.diag([2.0, 2.0, 2.0, 1.0]), "the pose has no rotation"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "no rotation"),
        (np.ones((4, 4)), "last row"),
        ([0, 0, 0, 1, 1, 0, 0], "no unit quaternion"),
        ([[0, 0, 0, 1, 0, 0, 0], [0, np.inf, 0, 1, 0, 0, 0]], "pose 2 has no finite position"),
        (np.zeros((2, 6)), r"the shape is \(2, 6\)"),
        (3, "int is no pose"),
        ([[1.0, 2.0], [3.0]], "list is no pose"),
        (([[0, 0, 0]], [[1, 0, 0, 0]] * 2), "1 positions but 2 quaternions"),
        (Pose((np.nan, 0.0, 0.0)), "no number|no finite"),
    ],
)
def test_what_is_no_pose_says_what_is_wanted(given, said):
    with pytest.raises(Refused, match=said):
        columns_of(given, unit="mm")
    with pytest.raises(Refused, match=said):
        pose_of(given, unit="mm")


def test_a_pose_has_the_matrices_of_spatialmath():
    for one in some():
        pose = Pose.of_matrix(one.A)
        assert abs(np.dot(pose.quaternion, UnitQuaternion(one.R).A)) == pytest.approx(1.0)
        assert pose.rotation == pytest.approx(UnitQuaternion(pose.quaternion).R, abs=1e-12)
        assert pose.matrix == pytest.approx(one.A, abs=1e-12)
        assert Pose.of_matrix(one.R, one.t) == pose


def test_a_pose_on_the_way_is_that_of_spatialmath():
    for start, end in itertools.pairwise(some()):
        first, last = Pose.of_matrix(start.A), Pose.of_matrix(end.A)
        for part in (0.0, 0.3, 0.5, 1.0):
            theirs = start.interp(end, part, shortest=True).A
            assert first.interpolate(last, part).matrix == pytest.approx(theirs, abs=1e-9)
