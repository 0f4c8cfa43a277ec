"""Bodies of links from a URDF: where they are, against a chain of this file's own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from assistant.base import rotations
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.cell.cell_file import read_scene
from assistant.cell.collision.model import Carriers, Model
from assistant.cell.scene import Box, Capsule, Cylinder, Mesh, Scene, Sphere

LIMIT = '<limit lower="-2.5" upper="2.5" velocity="3.0" effort="1"/>'
CHAIN = (
    ("0 0 0.3991", "0 0 1", "0 0 0"),
    ("0 0 0", "0 1 0", "0 0 0"),
    ("0 0 0.35", "0 1 0", "0 0 0"),
    ("0 0 0.042", "1 0 0", "0 0 0"),
    ("0.351 0 0", "0 1 0", "0 0 0"),
    ("0.082 0 0", "1 0 0", "0 0 0"),
)
"""xyz, axis, rpy of each joint: an arm whose angles are solved in closed form."""
TURNED = (
    ("0 0 0.2", "0 0.6 0.8", "0.3 -0.2 0.1"),
    ("0.1 0.02 0.3", "1 0 0", "0 0.4 0"),
    ("0.2 0 0", "0 0 -1", "1.1 0 -0.7"),
)
"""One that is not."""


def urdf(
    chain: tuple[tuple[str, str, str], ...], drawn: dict[str, str], more: str = "", tool: str = ""
) -> str:
    """drawn: what stands in a link, by its name: base, l1 …, tool0, and what `more` holds."""
    names = ["base", *(f"l{i}" for i in range(1, len(chain) + 1)), "tool0"]
    links = "".join(f'<link name="{n}">{drawn.get(n, "")}</link>' for n in names)
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="{names[i - 1]}"/>'
        f'<child link="{names[i]}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>{LIMIT}'
        "</joint>"
        for i, (xyz, axis, rpy) in enumerate(chain, 1)
    )
    tip = (
        f'<joint name="tip" type="fixed"><parent link="{names[-2]}"/><child link="tool0"/>'
        f'<origin xyz="0 0 0" rpy="0 1.5707963267948966 0"/></joint>{tool}'
    )
    return f'<robot name="own">{links}{joints}{tip}{more}</robot>'


def shape(inner: str, xyz: str = "0 0 0", rpy: str = "0 0 0", kind: str = "collision") -> str:
    origin = f'<origin xyz="{xyz}" rpy="{rpy}"/>'
    return f"<{kind}>{origin}<geometry>{inner}</geometry></{kind}>"


def scene_of(
    folder: Path, text: str, robot: str = "", more: str = ""
) -> tuple[Scene, tuple[Diagnostic, ...]]:
    (folder / "arm.urdf").write_text(text, encoding="utf-8")
    (folder / "cell.toml").write_text(f'[robots.arm]\nrobot = "arm.urdf"\n{robot}\n{more}')
    scene, findings = read_scene(folder / "cell.toml")
    return scene, tuple(finding for finding in findings if finding.code != "CK419")


def test_links_that_nothing_is_drawn_of_are_told_of(tmp_path: Path) -> None:
    ball = shape('<sphere radius="0.05"/>')
    drawn = dict.fromkeys(("base", "l1", "l2", "l4", "l5", "tool0"), ball)
    scene_of(tmp_path, urdf(CHAIN, drawn))
    (finding,) = read_scene(tmp_path / "cell.toml")[1]
    assert finding.code == "CK419"
    assert " J3," in finding.message
    scene_of(tmp_path, urdf(CHAIN, drawn | {"l3": ball}))
    assert read_scene(tmp_path / "cell.toml")[1] == ()


def transform(xyz: str, rpy: str) -> np.ndarray:
    """(4, 4) of an origin, by the formulas of the URDF specification: about fixed x, y, z."""
    r, p, y = (float(word) for word in rpy.split())
    out = np.eye(4)
    rx = np.array([[1, 0, 0], [0, np.cos(r), -np.sin(r)], [0, np.sin(r), np.cos(r)]])
    ry = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
    rz = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
    out[:3, :3] = rz @ ry @ rx
    out[:3, 3] = [float(word) for word in xyz.split()]
    return out


def about(axis: str, angle: float) -> np.ndarray:
    """(4, 4) by Rodrigues' formula."""
    x, y, z = (float(word) for word in axis.split())
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    out = np.eye(4)
    out[:3, :3] = np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k
    return out


@pytest.mark.parametrize("chain", [CHAIN, TURNED], ids=["closed form", "solved"])
def test_shapes_are_where_the_urdf_has_them(
    tmp_path: Path, chain: tuple[tuple[str, str, str], ...]
) -> None:
    own = ("0.01 -0.02 0.03", "0.5 -0.3 0.9")
    names = ["base", *(f"l{i}" for i in range(1, len(chain) + 1)), "tool0"]
    drawn = {name: shape('<box size="0.01 0.02 0.03"/>', *own) for name in names}
    scene, _ = scene_of(tmp_path, urdf(chain, drawn))
    (placed,) = scene.robots
    assert [body.name for body in placed.links] == [
        "arm.base", *(f"arm.J{i}" for i in range(1, len(chain) + 1)), "arm.flange"
    ]  # fmt: skip
    rows = np.random.default_rng(3).uniform(-140.0, 140.0, (30, len(chain)))
    carriers = Carriers(scene.robots)
    origins, turns = carriers.at(rows)
    for number, row in enumerate(np.radians(rows)):
        where = np.eye(4)
        expected = [where]
        for (xyz, axis, rpy), angle in zip(chain, row, strict=True):
            where = where @ transform(xyz, rpy) @ about(axis, angle)
            expected.append(where)
        expected.append(where @ transform("0 0 0", "0 1.5707963267948966 0"))
        for body, there in zip(placed.links, expected, strict=True):
            wanted = there @ transform(*own)
            carrier, pose = carriers.names[body.parent], body.parts[0].pose
            at, turn = origins[number, carrier], turns[number, carrier]
            assert at + turn @ np.array(pose.position) == pytest.approx(
                wanted[:3, 3] * 1000.0, abs=1e-6
            )
            found = turn @ rotations.to_matrix(np.array(pose.quaternion))
            assert np.abs(found - wanted[:3, :3]).max() < 1e-9


def test_every_shape_is_read_in_mm(tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.2, 0.3)).export(tmp_path / "link.stl")
    mesh = '<mesh filename="link.stl" scale="1 -2 1"/>'
    drawn = {
        "base": shape('<box size="0.1 0.2 0.3"/>') + shape('<sphere radius="0.05"/>'),
        "l1": shape('<cylinder radius="0.04" length="0.5"/>'),
        "l2": shape('<capsule radius="0.04" length="0.5"/>'),
        "l3": shape(mesh),
        "l4": shape(mesh, kind="visual"),  # where there are bodies of contact, no link is drawn
    }
    scene, findings = scene_of(tmp_path, urdf(CHAIN, drawn))
    assert findings == ()
    shapes = {body.name: [part.shape for part in body.parts] for body in scene.robots[0].links}
    assert shapes["arm.base"] == [Box((100.0, 200.0, 300.0)), Sphere(50.0)]
    assert shapes["arm.J1"] == [Cylinder(40.0, 500.0)]
    assert shapes["arm.J2"] == [Capsule(40.0, 500.0)]
    (mirrored,) = shapes["arm.J3"]
    assert isinstance(mirrored, Mesh)
    assert np.ptp(mirrored.points, axis=0) == pytest.approx((100.0, 400.0, 300.0), abs=1e-3)
    assert mirrored.solid
    assert "arm.J4" not in shapes


def test_what_is_only_drawn_counts_where_no_link_has_more(tmp_path: Path) -> None:
    scene, _ = scene_of(
        tmp_path, urdf(CHAIN, {"l3": shape('<sphere radius="0.05"/>', kind="visual")})
    )
    assert [body.name for body in scene.robots[0].links] == ["arm.J3"]


def test_without_shapes_or_if_it_is_said_links_are_capsules(tmp_path: Path) -> None:
    by_lengths, _ = scene_of(tmp_path, urdf(CHAIN, {}))
    drawn = {"base": shape('<mesh filename="package://nowhere/link.dae"/>')}
    said, _ = scene_of(tmp_path, urdf(CHAIN, drawn), 'links = "capsules"')
    assert said.robots[0].links == by_lengths.robots[0].links != ()


def test_tools_and_fingers_of_the_file_hang_on_the_flange(tmp_path: Path) -> None:
    finger = (
        '<link name="hand">{}</link><link name="finger">{}</link>'
        '<joint name="mount" type="fixed"><parent link="tool0"/><child link="hand"/>'
        '<origin xyz="0 0 0.05"/></joint>'
        '<joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/>'
        '<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>'
        '<limit lower="0.01" upper="0.04" velocity="1" effort="1"/></joint>'
    ).format(shape('<sphere radius="0.02"/>'), shape('<sphere radius="0.01"/>'))
    scene, findings = scene_of(tmp_path, urdf(CHAIN, {}, more=finger))
    (hand,) = scene.robots[0].links
    assert hand.name == hand.parent == "arm.flange"
    assert [part.pose.position for part in hand.parts] == [
        pytest.approx((0, 0, 50)),
        pytest.approx((0, 10, 150)),
    ]
    assert [finding.code for finding in findings] == ["CK439"]
    assert "`grip`" in findings[0].message


def test_packages_are_found_above_the_urdf_or_where_the_cell_says(tmp_path: Path) -> None:
    mesh = trimesh.creation.icosphere(radius=0.05)
    for folder in ("ws/other/meshes", "ws/own/urdf", "else"):
        (tmp_path / folder).mkdir(parents=True)
    mesh.export(tmp_path / "ws/other/meshes/link.stl")
    mesh.apply_scale(2.0)
    mesh.export(tmp_path / "else/link.stl")
    drawn = {"l2": shape('<mesh filename="package://other/meshes/link.stl"/>')}
    scene, _ = scene_of(tmp_path / "ws/own/urdf", urdf(CHAIN, drawn))
    ball = scene.robots[0].links[0].parts[0].shape
    assert isinstance(ball, Mesh)
    assert np.abs(ball.points).max() == pytest.approx(50.0, abs=0.1)
    drawn = {"l2": shape('<mesh filename="package://far/link.stl"/>')}
    scene, findings = scene_of(
        tmp_path / "ws/own/urdf", urdf(CHAIN, drawn), 'packages = {far = "../../../else", b = "c"}'
    )
    ball = scene.robots[0].links[0].parts[0].shape
    assert isinstance(ball, Mesh)
    assert np.abs(ball.points).max() == pytest.approx(100.0, abs=0.1)
    assert [finding.code for finding in findings] == ["CK438"]


@pytest.mark.parametrize(
    ("inner", "code", "word"),
    [
        ('<mesh filename="package://nowhere/a.stl"/>', "CK436", "nowhere"),
        ('<mesh filename="package:///a.stl"/>', "CK436", "``"),
        ('<mesh filename="package://../a.stl"/>', "CK436", "`..`"),
        ('<mesh filename="http://maker/a.stl"/>', "CK437", "http://maker/a.stl"),
        ('<mesh filename="link.dae"/>', "CK407", ".dae"),
        ('<mesh filename=""/>', "RB007", "filename"),
        ('<mesh filename="a.stl" scale="1 0 1"/>', "RB007", "scale"),
        ('<mesh filename="a.stl" scale="1 nan 1"/>', "RB007", "scale"),
        ('<box size="1 1"/>', "RB007", "size"),
        ('<box size="1 -1 1"/>', "RB007", "above 0"),
        ('<sphere radius="nan"/>', "RB007", "radius"),
        ('<sphere/>', "RB007", "above 0"),
        ('<cylinder radius="1"/>', "RB007", "above 0"),
        ("<cone/>", "RB007", "is not one of"),
    ],
)  # fmt: skip
def test_what_is_no_shape_is_one_finding(tmp_path: Path, inner: str, code: str, word: str) -> None:
    with pytest.raises(Refused) as refused:
        scene_of(tmp_path, urdf(CHAIN, {"l2": shape(inner)}))
    (finding,) = refused.value.findings
    assert finding.code == code
    assert word in finding.message
    assert finding.cure


def test_a_mesh_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"gone\.stl"):
        scene_of(tmp_path, urdf(CHAIN, {"l2": shape('<mesh filename="gone.stl"/>')}))


def test_links_of_meshes_are_kept_from_each_other_as_others_are(tmp_path: Path) -> None:
    """A forearm that cannot be kept apart from its neighbour may touch it, the table may not."""
    trimesh.creation.box((0.1, 0.1, 0.35)).export(tmp_path / "link.stl")
    mesh = '<mesh filename="link.stl"/>'
    drawn = {
        "base": shape(mesh, "0 0 0.17"),
        "l1": shape('<sphere radius="0.06"/>'),
        "l2": shape(mesh, "0 0 0.17"),
        "l3": shape(mesh, "0.17 0 0", "0 1.5707963267948966 0"),
    }
    more = "[bodies.table]\nbox = [100, 100, 700]\nposition = [420, 0, 350]\n"
    scene, _ = scene_of(tmp_path, urdf(CHAIN, drawn), more=more)
    assert {("arm.J1", "arm.base"), ("arm.J1", "arm.J2")} <= scene.allowed
    assert ("arm.J3", "arm.base") not in scene.allowed
    model = Model(scene)
    reaching = np.array([[0.0, 40.0, 0.0, 0.0, 0.0, 0.0]])
    assert model.nearest(np.zeros((1, 6)))[0][0] > 0.0
    assert model.nearest(reaching)[0][0] < 0.0
