"""Poses in the conventions of controllers, against spatialmath and scipy, which share no code."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spatialmath import SE3

from assistant import pose
from assistant.base.diagnostics import Refused

POSES = [SE3.Rand() for _ in range(20)]
MATRICES = np.stack([one.A for one in POSES])
TURNS = Rotation.from_matrix(MATRICES[:, :3, :3])
SCIPY = {
    "melfa": TURNS.as_euler("xyz", degrees=True),
    "fanuc": TURNS.as_euler("xyz", degrees=True),
    "kuka": TURNS.as_euler("ZYX", degrees=True),
    "rotation-vector": TURNS.as_rotvec(),
}


@pytest.mark.parametrize("name", SCIPY)
def test_angles_are_those_of_scipy(name):
    rows = pose.write(POSES, name, unit="m", to_unit="m")
    assert rows[:, :3] == pytest.approx(MATRICES[:, :3, 3])
    assert rows[:, 3:] == pytest.approx(SCIPY[name], abs=1e-9)


def test_quaternions_are_those_of_scipy():
    theirs = TURNS.as_quat()  # scalar last
    for name, order in (("xyzw", [0, 1, 2, 3]), ("rapid", [3, 0, 1, 2])):
        ours = pose.write(POSES, name, unit="m", to_unit="m")[:, 3:]
        assert np.abs(np.einsum("ij,ij->i", ours, theirs[:, order])) == pytest.approx(1.0)


TURNED = {
    "melfa": lambda a, b, c: SE3.Rz(c, "deg") * SE3.Ry(b, "deg") * SE3.Rx(a, "deg"),
    "kuka": lambda a, b, c: SE3.Rz(a, "deg") * SE3.Ry(b, "deg") * SE3.Rx(c, "deg"),
    "fanuc": lambda w, p, r: SE3.Rz(r, "deg") * SE3.Ry(p, "deg") * SE3.Rx(w, "deg"),
}


@pytest.mark.parametrize("name", TURNED)
@pytest.mark.parametrize("angles", [(10, 20, 30), (-170, 89.9, 5), (0, 90, 40), (180, 0, -90)])
def test_angles_turn_as_the_manuals_state(name, angles):
    wanted = SE3(0.1, -0.2, 0.3) * TURNED[name](*angles)
    positions, quaternions = pose.read([100, -200, 300, *angles], name)
    assert pytest.approx(wanted.A, abs=1e-9) == pose.se3(positions, quaternions, unit="m").A
    again = pose.convert([100, -200, 300, *angles], name, "matrix")
    back = pose.read(pose.convert(again, "matrix", name, unit="mm"), name)
    assert np.abs(back[1] @ quaternions.T) == pytest.approx(1.0)


@pytest.mark.parametrize("source", pose.conventions())
@pytest.mark.parametrize("target", pose.conventions())
def test_every_convention_leads_to_every_other(source, target):
    rows = pose.write(POSES, source, unit="m", to_unit="m")
    there = pose.convert(rows, source, target, unit="m", to_unit="mm")
    back = pose.convert(there, target, "matrix", unit="mm", to_unit="m")
    assert back.reshape(-1, 4, 4) == pytest.approx(MATRICES, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "text", "wanted"),
    [
        ("rapid", "[[6,0,4],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]", [6, 0, 4, 0, 0, 1, 0]),
        ("melfa", "(600.00,-1.50,400.00,180.00,0.00,90.00)(7,0)", [600, -1.5, 400, 180, 0, 90]),
        ("melfa", "(1,2,3,4,5,6,7,8)(7,1048576)", [1, 2, 3, 4, 5, 6]),
        ("kuka", "{E6POS: X 600,Y 0,Z 400,A 1,B 2,C 3,S 2,T 35,E1 9.0}", [600, 0, 400, 1, 2, 3]),
        ("kuka", "{A 1,B 2,C 3,X 600,Y 0,Z 400}", [600, 0, 400, 1, 2, 3]),
        ("fanuc", "X=1 Y=2 Z=3 W=-4 P=5 R=.6", [1, 2, 3, -4, 5, 0.6]),
        ("rotation-vector", "p[0.1, -0.2, 0.3, 0, 1.5e-1, 1]", [0.1, -0.2, 0.3, 0, 0.15, 1]),
        ("matrix", "1 0 0 5 0 1 0 6 0 0 1 7", [1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7]),
    ],
)  # fmt: skip
def test_poses_are_read_as_programs_write_them(name, text, wanted):
    assert pose.parse(text, name).tolist() == wanted


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("kuka", "1 2 3"),
        ("kuka", "1 2 3 4 5 6 7"),
        ("kuka", "{X 1,Y 2,Z 3,A 4,B 5}"),
        ("rapid", ""),
    ],
)
def test_other_texts_are_refused(name, text):
    with pytest.raises(Refused, match="TB453"):
        pose.parse(text, name)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: pose.read([1, 2, 3, 4, 5, 6], "kuba"), "TB451.*kuka"),
        (lambda: pose.read([1, 2, 3, 4, 5], "kuka"), r"TB441.*\(5,\), not \(n, 6\)"),
        (lambda: pose.read([1, 2, 3, 4, 5, np.nan], "kuka"), "TB442"),
        (lambda: pose.read([1, 2, 3, 0, 0, 0], "rotation-vector"), "TB445"),
        (lambda: pose.read([1, 2, 3, 4, 5, 6], "kuka", unit="cm"), "TB446"),
        (lambda: pose.read([1, 2, 3, 1, 1, 0, 0], "rapid"), "TB452.*row 1.*1.414"),
        (lambda: pose.read([1, 2, 3, 4], "matrix", unit="m"), "TB441"),
        (lambda: pose.read(np.ones(16), "matrix", unit="m"), "TB444"),
        (lambda: pose.write(SE3(), "kuka"), "TB445"),
        (lambda: pose.write(SE3(), "xyzw", unit="m"), 'TB449.*to_unit="m"'),
        (lambda: pose.write(SE3(), "kuka", unit="m", to_unit="cm"), 'TB446.*to_unit="m"'),
    ],
)
def test_what_is_no_pose_is_refused(call, said):
    with pytest.raises(Refused, match=said):
        call()


def test_no_turn_is_a_rotation_vector_of_zeros():
    assert (
        pose.convert([1, 2, 3, 1, 0, 0, 0], "rapid", "rotation-vector")[0, 3:].tolist() == [0] * 3
    )
    assert (
        pose.convert([1, 2, 3, 0, 0, 0], "rotation-vector", "kuka", unit="mm")[0, 3:].tolist()
        == [0] * 3
    )
