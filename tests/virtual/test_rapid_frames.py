"""Functions of positions against matrices that the tests work out for themselves (numpy)."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import numpy as np
import pytest

from assistant import robots
from tests.virtual.rapid_cell import ran, said

Matrix = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def about(axis: int, degrees: float) -> Matrix:
    """A turn about x, y or z, as a 4 x 4 matrix."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    found = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found[i, i] = found[j, j] = c
    found[i, j], found[j, i] = -s, s
    return found


def shifted(x: float, y: float, z: float) -> Matrix:
    found = np.eye(4)
    found[:3, 3] = x, y, z
    return found


def matrix(position: Sequence[float], q: Sequence[float]) -> Matrix:
    w, x, y, z = q
    found = np.eye(4)
    found[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    found[:3, 3] = position
    return found


class Drawn:
    """A random pose: as a text of RAPID, and as a matrix."""

    def __init__(self, source: random.Random) -> None:
        q = np.array([source.gauss(0, 1) for _ in range(4)])
        q = np.round(q / np.linalg.norm(q), 7)
        self.p = [round(source.uniform(-500, 500), 2) for _ in range(3)]
        self.q = [float(v) for v in q]
        self.matrix = matrix(self.p, q / np.linalg.norm(q))
        self.pos = "[" + ",".join(map(repr, self.p)) + "]"
        self.pose = f"[{self.pos},[{','.join(map(repr, self.q))}]]"
        self.target = f"[{self.pose[1:-1]},[0,0,0,0],{AXES}]"
        self.frame = f'[FALSE,TRUE,"",{self.pose},[[0,0,0],[1,0,0,0]]]'


PRINT = """
PROC show(pose p)
TPWrite NumToStr(p.trans.x,4)+" "+NumToStr(p.trans.y,4)+" "+NumToStr(p.trans.z,4);
TPWrite NumToStr(p.rot.q1,7)+" "+NumToStr(p.rot.q2,7)+" "
  +NumToStr(p.rot.q3,7)+" "+NumToStr(p.rot.q4,7);
ENDPROC
PROC show_target(robtarget t)
VAR pose p;
p.trans:=t.trans;
p.rot:=t.rot;
show p;
ENDPROC
"""


def shown(main: str, data: str, **given: object) -> list[Matrix]:
    """The poses that a program shows."""
    lines = said(main, PRINT, data, **given)
    rows = [[float(word) for word in line.split()] for line in lines]
    return [matrix(p, q) for p, q in zip(rows[::2], rows[1::2], strict=True)]


def near(found: Matrix, expected: Matrix) -> None:
    assert found[:3, 3] == pytest.approx(expected[:3, 3], abs=2e-3)
    assert found[:3, :3] == pytest.approx(expected[:3, :3], abs=2e-6)


SEEDS = pytest.mark.parametrize("seed", range(4))


@SEEDS
def test_poses_are_multiplied_and_turned_round(seed: int) -> None:
    source = random.Random(seed)
    a, b = Drawn(source), Drawn(source)
    data = f"VAR pose a:={a.pose};\nVAR pose b:={b.pose};\nVAR pos v:={b.pos};\nVAR pos w;"
    found = shown("show PoseMult(a,b);\nshow PoseInv(a);", data)
    near(found[0], a.matrix @ b.matrix)
    near(found[1], np.linalg.inv(a.matrix))
    moved = said(
        'w:=PoseVect(a,v);\nTPWrite NumToStr(w.x,4)+" "+NumToStr(w.y,4)+" "+NumToStr(w.z,4);',
        data=data,
    )
    expected = (a.matrix @ [*b.p, 1.0])[:3]
    assert [float(word) for word in moved[0].split()] == pytest.approx(list(expected), abs=2e-3)


@SEEDS
def test_euler_angles_turn_about_z_then_y_then_x(seed: int) -> None:
    source = random.Random(seed)
    z, y, x = (round(source.uniform(-80, 80), 3) for _ in range(3))
    found = shown(f"p.rot:=OrientZYX({z},{y},{x});\nshow p;", "VAR pose p;")
    near(found[0], about(2, z) @ about(1, y) @ about(0, x))
    angles = said(
        f"o:=OrientZYX({z},{y},{x});\n"
        'TPWrite NumToStr(EulerZYX(\\Z,o),3)+" "+NumToStr(EulerZYX(\\Y,o),3)+" "'
        "+NumToStr(EulerZYX(\\X,o),3);",
        data="VAR orient o;",
    )
    assert [float(word) for word in angles[0].split()] == pytest.approx([z, y, x], abs=2e-3)


@SEEDS
def test_offs_goes_along_the_frame_and_reltool_along_the_tool(seed: int) -> None:
    source = random.Random(seed)
    a = Drawn(source)
    data = f"VAR robtarget t:={a.target};"
    found = shown(
        "show_target Offs(t,1,-2,3.5);\nshow_target RelTool(t,1,-2,3.5);\n"
        "show_target RelTool(t,0,0,10\\Rx:=20\\Ry:=-30\\Rz:=40);",
        data,
    )
    near(found[0], shifted(1, -2, 3.5) @ a.matrix)
    near(found[1], a.matrix @ shifted(1, -2, 3.5))
    turned = about(0, 20) @ about(1, -30) @ about(2, 40)
    near(found[2], a.matrix @ shifted(0, 0, 10) @ turned)


@SEEDS
@pytest.mark.parametrize("with_frame", [False, True])
def test_a_position_is_mirrored(seed: int, with_frame: bool) -> None:
    source = random.Random(seed)
    a, plane, frame = (Drawn(source) for _ in range(3))
    data = f"VAR robtarget t:={a.target};\nPERS wobjdata m:={plane.frame};\n"
    data += f"PERS wobjdata w:={frame.frame};"
    option = "\\WObj:=w" if with_frame else ""
    found = shown(f"show_target MirPos(t,m{option});\nshow_target MirPos(t,m{option}\\MirY);", data)
    own = frame.matrix if with_frame else np.eye(4)
    mirror = plane.matrix @ np.diag([1.0, 1.0, -1.0, 1.0]) @ np.linalg.inv(plane.matrix)
    seen = np.linalg.inv(own) @ mirror @ own @ a.matrix  # a left-handed system
    for pose, axis in zip(found, (1, 0), strict=True):
        expected = seen.copy()
        expected[:3, axis] *= -1.0
        near(pose, expected)


def points(source: random.Random) -> list[Drawn]:
    return [Drawn(source) for _ in range(3)]


@SEEDS
def test_a_frame_through_three_positions(seed: int) -> None:
    drawn = points(random.Random(seed))
    data = "\n".join(f"CONST robtarget t{i}:={d.target};" for i, d in enumerate(drawn))
    found = shown(
        "show DefFrame(t0,t1,t2);\nshow DefFrame(t0,t1,t2\\Origin:=2);\n"
        "show DefFrame(t0,t1,t2\\Origin:=3);",
        data,
    )
    one, two, three = (np.array(d.p) for d in drawn)
    for pose in found:
        into = np.linalg.inv(pose)
        on_x = [(into @ [*p, 1.0])[:3] for p in (one, two)]
        assert [*on_x[0][1:], *on_x[1][1:]] == pytest.approx([0, 0, 0, 0], abs=5e-3)
        assert on_x[1][0] > on_x[0][0]
        third = (into @ [*three, 1.0])[:3]
        assert third[2] == pytest.approx(0, abs=5e-3)
        assert third[1] > 0
    assert found[0][:3, 3] == pytest.approx(one, abs=2e-3)
    assert found[1][:3, 3] == pytest.approx(two, abs=2e-3)
    assert (np.linalg.inv(found[2]) @ [*three, 1.0])[0] == pytest.approx(0, abs=5e-3)


@SEEDS
def test_a_frame_between_positions_before_and_after(seed: int) -> None:
    source = random.Random(seed)
    old, shift = points(source), Drawn(source)
    new = [(shift.matrix @ [*d.p, 1.0])[:3] for d in old]
    data = "\n".join(f"CONST robtarget a{i}:={d.target};" for i, d in enumerate(old))
    for i, p in enumerate(new):
        at = ",".join(f"{v:.4f}" for v in p)
        data += f"\nCONST robtarget b{i}:=[[{at}],[1,0,0,0],[0,0,0,0],{AXES}];"
    data += f"\nVAR robtarget a{{4}}:=[{','.join(f'a{i}' for i in range(3))},a0];"
    data += f"\nVAR robtarget b{{4}}:=[{','.join(f'b{i}' for i in range(3))},b0];"
    data += "\nVAR num most;\nVAR num mean;"
    found = shown("show DefDFrame(a0,a1,a2,b0,b1,b2);\nshow DefAccFrame(a,b,3,most,mean);", data)
    for pose in found:
        assert pose[:3, 3] == pytest.approx(shift.matrix[:3, 3], abs=2e-2)
        assert pose[:3, :3] == pytest.approx(shift.matrix[:3, :3], abs=5e-5)
    assert said(
        "p:=DefAccFrame(a,b,3,most,mean);\nTPWrite ValToStr(most<0.01);",
        data=data + "\nVAR pose p;",
    ) == ["TRUE"]


@SEEDS
def test_a_displacement_moves_targets_and_is_taken_out_again(seed: int) -> None:
    source = random.Random(seed)
    a, b, c = (Drawn(source) for _ in range(3))
    data = "\n".join(
        f"VAR robtarget {n}:={d.target};" for n, d in zip("abc", (a, b, c), strict=True)
    )
    shift = c.matrix @ np.linalg.inv(b.matrix)
    plain = shifted(*(np.array(c.p) - b.p))
    found = shown(
        "PDispOn\\Rot\\ExeP:=c,b,tool0;\nshow_target ORobT(a);\nshow_target ORobT(a\\InPDisp);\n"
        "MoveL a,v100,fine,tool0;\nshow_target CRobT(\\Tool:=tool0\\WObj:=wobj0);\nPDispOff;\n"
        "show_target CRobT(\\Tool:=tool0\\WObj:=wobj0);\n"
        "PDispOn\\ExeP:=c,b,tool0;\nshow_target ORobT(a);\nPDispOff;\nshow_target ORobT(a);\n"
        "MoveL c,v100,fine,tool0;\nPDispOn\\Rot,b,tool0;\nshow_target ORobT(a);",
        data,
    )
    expected = [shift @ a.matrix, a.matrix, a.matrix, shift @ a.matrix]
    expected += [plain @ a.matrix, a.matrix, shift @ a.matrix]
    for pose, wanted in zip(found, expected, strict=True):
        near(pose, wanted)


def test_offsets_of_additional_axes() -> None:
    target = "[[0,0,0],[1,0,0,0],[0,0,0,0],[{},9E9,9E9,9E9,9E9,9E9]]"
    data = f"VAR robtarget a:={target.format(100)};\nVAR robtarget b:={target.format(30)};\n"
    data += "VAR robtarget t;"
    show = 't:=ORobT(a);\nTPWrite ValToStr(t.extax.eax_a)+" "+ValToStr(t.extax.eax_b);\n'
    assert said(
        f"EOffsSet [5,9E9,9E9,9E9,9E9,9E9];\n{show}EOffsOff;\n{show}"
        f"EOffsOn\\ExeP:=a,b;\n{show}t:=ORobT(a\\InEOffs);\nTPWrite ValToStr(t.extax.eax_a);\n"
        f"EOffsOff;\nMoveL a,v100,fine,tool0;\nEOffsOn b;\n{show}",
        data=data,
    ) == ["105 9E+09", "100 9E+09", "170 9E+09", "100", "170 9E+09"]


JOINTS = [(10, -20, 15, 30, 40, -50), (-100, 20, -30, 100, -60, 200), (0, 0, 0, 0, 30, 0)]


@pytest.mark.parametrize("joints", JOINTS)
def test_joints_and_positions_of_a_robot_belong_together(joints: tuple[float, ...]) -> None:
    arm = robots.get("irb1200-7-0.7")
    stated = ",".join(map(str, joints))
    data = f"VAR jointtarget j:=[[{stated}],{AXES}];\nVAR robtarget t;\nVAR jointtarget k;\n"
    data += "PERS tooldata tl:=[TRUE,[[10,20,130],[0.5,0.5,0.5,0.5]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
    tell = 'TPWrite NumToStr(k.robax.rax_1,3)+" "+NumToStr(k.robax.rax_2,3)+" "'
    tell += '+NumToStr(k.robax.rax_3,3)+" "+NumToStr(k.robax.rax_4,3)+" "'
    tell += '+NumToStr(k.robax.rax_5,3)+" "+NumToStr(k.robax.rax_6,3);\n'
    lines = said(
        f"t:=CalcRobT(j,tl);\nk:=CalcJointT(t,tl);\n{tell}"
        f"MoveJ t,v100,fine,tl;\nk:=CJointT();\n{tell}",
        data=data,
        robot=arm,
    )
    for line in lines:
        assert [float(word) for word in line.split()] == pytest.approx(list(joints), abs=2e-2)
    found = shown("show_target CalcRobT(j,tl);", data, robot=arm)[0]
    p, q = arm.fk([joints])
    near(found, matrix(p[0], q[0]) @ matrix((10, 20, 130), (0.5, 0.5, 0.5, 0.5)))


@pytest.mark.parametrize(
    ("target", "error"),
    [("[5000,0,0]", "ERR_OUTSIDE_REACH"), ("[0,0,-100]", "ERR_ROBLIMIT")],
)
def test_positions_that_the_robot_does_not_reach(target: str, error: str) -> None:
    data = f"VAR robtarget t:=[{target},[0,0,1,0],[0,0,0,0],{AXES}];\nVAR jointtarget j;"
    main = f'j:=CalcJointT(t,tool0);\nERROR\nIF ERRNO={error} TPWrite "far";\nTRYNEXT;'
    assert said(main, data=data, robot=robots.get("irb1200-7-0.7")) == ["far"]
    assert ran(main, data=data).ended == "unknown"


def test_orientations_are_normalised() -> None:
    lines = said(
        'o:=NOrient([0.95,0.3,0,0]);\nTPWrite NumToStr(o.q1,6)+" "+NumToStr(o.q2,6);',
        data="VAR orient o;",
    )
    length = math.hypot(0.95, 0.3)
    assert [float(w) for w in lines[0].split()] == pytest.approx(
        [0.95 / length, 0.3 / length], abs=2e-6
    )
    assert ran("o:=NOrient([0.9,0,0,0]);", data="VAR orient o;").ended == "error"
