"""Cell files: robots and bodies, and what is wrong in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Diagnostic, Refused, Unreadable
from assistant.cell.cell_file import read_scene
from assistant.cell.collision.model import Model
from assistant.cell.exploration.occupancy import Occupancy, keys_of, save_map
from assistant.cell.mesh_files import read_mesh
from assistant.cell.scene import Box, Cylinder, Mesh, Scene
from assistant.sources.cell_values import read_cell

CELL = """
[tools.nozzle]
tip = [0, 0, 100]

[world]
margin = 8
allowed = [["table", "arm.base"]]

[robots.arm]
robot = "irb1200-7-0.7"

[frames.bench]
position = [400, 0, 100]

[bodies.table]
box = [600, 600, 20]
parent = "bench"
position = [0, 0, -10]
colour = "#102030"
margin = 12

[bodies.table.locations.corner]
position = [-300, -300, 10]

[bodies.nozzle]
cylinder = [8, 100]
position = [0, 0, 50]
parent = "arm.flange"
"""


def cell(folder: Path, text: str) -> tuple[Scene, tuple[Diagnostic, ...]]:
    file = folder / "cell.toml"
    file.write_text(text, encoding="utf-8")
    return read_scene(file)


def test_a_cell_file_says_what_stands_where(tmp_path: Path) -> None:
    scene, findings = cell(tmp_path, CELL)
    assert findings == ()
    table, nozzle = scene.bodies
    assert table.parts[0].shape == Box((600.0, 600.0, 20.0))
    assert (table.colour, table.margin, scene.margin) == ((16, 32, 48), 12.0, 8.0)
    assert table.locations["corner"].position == (-300.0, -300.0, 10.0)
    assert nozzle.parts[0].shape == Cylinder(8.0, 100.0)
    assert scene.may_touch("arm.base", "table")
    tip = Model(scene).contact(np.array([0.0, 60.0, 20.0, 0.0, 10.0, 0.0]), 0)
    assert {tip.one, tip.other} <= {body.name for body in scene.all_bodies()}


def test_the_same_file_says_tools_and_frames(tmp_path: Path) -> None:
    cell(tmp_path, CELL)
    assert read_cell(tmp_path / "cell.toml").process.tools["nozzle"].tip.position == (0, 0, 100)


@pytest.mark.parametrize(
    ("text", "code", "word"),
    [
        ('[bodies.a]\nbox = [1, 2, 3]\nparent = "sky"\n', "CK401", "sky"),
        (f'[robots.a]\nrobot = "{"x" * 300}.toml"\n', "CK413", "xxx"),
        (
            '[frames.f]\nheld = true\n[bodies.a]\nbox = [1, 2, 3]\nparent = "f"\n',
            "CK401",
            "f",
        ),
        (
            '[bodies.a]\nsphere = 1\nparent = "b"\n[bodies.b]\nsphere = 1\nparent = "a"\n',
            "CK402",
            "itself",
        ),
        ('[world]\nallowed = [["a", "a"]]\n', "CK403", "`a`"),
        ("[bodies.a]\nposition = [0, 0, 0]\n", "CK404", "no shape"),
        ("[bodies.a]\nsphere = 1\nbox = [1, 1, 1]\n", "CK404", "2 shapes"),
        ("[bodies.a]\nsphere = -1\n", "CT303", "sphere"),
        ("[bodies.a]\nsphere = 1\ncolor = 3\n", "CT302", "color"),
        ('[robots.r]\nrobot = "irb1200-7-0.7"\ntool = "drill"\n', "CK406", "drill"),
        ('[bodies.a]\nmesh = "part.step"\n', "CK407", "STEP|step"),
        ('[robots.r]\nrobot = "irb9"\n', "CO002|CK4|RB", "irb9"),
    ],
)
def test_what_is_wrong_is_one_finding(tmp_path: Path, text: str, code: str, word: str) -> None:
    with pytest.raises(Refused) as refused:
        Model(cell(tmp_path, text)[0])
    (finding,) = refused.value.findings
    assert any(finding.code.startswith(one) for one in code.split("|"))
    assert any(one in finding.message for one in word.split("|"))
    assert finding.cure


def stl(path: Path, mesh: Mesh) -> None:
    """As text, each triangle with its corners."""
    rows = ["solid part"]
    for triangle in mesh.points[mesh.triangles]:
        rows += ["facet normal 0 0 0", "outer loop"]
        rows += [f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
        rows += ["endloop", "endfacet"]
    path.write_text("\n".join([*rows, "endsolid part"]), encoding="ascii")


def cube(size: float) -> Mesh:
    from assistant.cell.scene import Convex

    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    return Convex(np.array(corners, dtype=np.float64) * size).hull


@pytest.mark.parametrize(
    ("change", "code", "solid"),
    [
        (lambda t: t, "", True),
        (lambda t: t[:, ::-1], "CK409", True),
        (lambda t: t[1:], "CK408", False),
        (lambda t: np.concatenate([t, [[0, 1, 1]]]), "", True),
    ],
    ids=["closed", "inside out", "open", "a triangle without area"],
)
def test_meshes_are_looked_at(tmp_path: Path, change: object, code: str, solid: bool) -> None:
    given = cube(100.0)
    assert callable(change)
    stl(tmp_path / "cube.stl", Mesh(given.points, change(given.triangles)))
    scene, findings = cell(tmp_path, '[bodies.a]\nmesh = "cube.stl"\nunit = "mm"\n')
    assert [finding.code for finding in findings] == ([code] if code else [])
    shape = scene.bodies[0].parts[0].shape
    assert isinstance(shape, Mesh)
    assert shape.solid == solid
    assert len(shape.points) == 8


def test_a_mesh_without_a_unit_is_told_of(tmp_path: Path) -> None:
    stl(tmp_path / "cube.stl", cube(4.0))
    scene, findings = cell(tmp_path, '[bodies.a]\nmesh = "cube.stl"\n')
    assert [finding.code for finding in findings] == ["CK412"]
    scene, findings = cell(tmp_path, '[bodies.a]\nmesh = "cube.stl"\nunit = "in"\n')
    shape = scene.bodies[0].parts[0].shape
    assert isinstance(shape, Mesh)
    assert findings == ()
    assert abs(shape.points.max() - 101.6) < 1e-4


def test_a_mesh_of_many_triangles_is_simplified_and_stays_closed(tmp_path: Path) -> None:
    """A plate of 1 mm, thinner than the grid: both of its sides are there, within what is said."""
    n, m = 40, 24
    around = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    rings = [(r, z) for z in (0.0, 1.0) for r in np.linspace(0.0, 200.0, m)]
    rings = rings[:m] + rings[: m - 1 : -1]
    points = np.array([[r * np.cos(t), r * np.sin(t), z] for r, z in rings for t in around])
    i, j = (x.reshape(-1) for x in np.meshgrid(np.arange(2 * m - 1), np.arange(n), indexing="ij"))
    a, b = i * n + j, i * n + (j + 1) % n
    faces = np.concatenate([np.stack([a, a + n, b], 1), np.stack([b, a + n, b + n], 1)])
    stl(tmp_path / "plate.stl", Mesh(points, faces))
    whole, _ = read_mesh(tmp_path / "plate.stl", "mm")
    mesh, findings = read_mesh(tmp_path / "plate.stl", "mm", most=1000)
    assert [finding.code for finding in findings] == ["CK411"]
    assert whole.solid
    assert mesh.solid
    assert 200 < len(mesh.triangles) <= 1000
    middles = whole.points[whole.triangles].mean(axis=1)
    found = mesh.points[mesh.triangles].mean(axis=1)
    size = np.linalg.norm(np.ptp(mesh.points[mesh.triangles], axis=1), axis=1).max()
    far = np.sqrt(((middles[:, None] - found[None]) ** 2).sum(axis=2)).min(axis=1)
    assert far.max() <= mesh.off + size
    assert 0.0 < mesh.off < 60.0


@pytest.mark.parametrize(
    ("said", "code"),
    [
        ('explored = "none.npz"', "IN"),
        ('explored = "other.npz"', "CK452"),
        ('unknown = "free"', "CK490"),
        ('explored = "arm.npz"\nunknown = "perhaps"', "CT"),
    ],
)
def test_what_is_wrong_with_a_map_of_explored_space(tmp_path: Path, said: str, code: str) -> None:
    cell_of = np.array([[60, 0, 0]])
    touched = keys_of(cell_of)
    for name, robot in (("arm.npz", "irb1200-7-0.7"), ("other.npz", "rv-2aj")):
        save_map(Occupancy.unknown(10.0, robot).with_run(touched[:0], touched), tmp_path / name)
    text = f'[robots.arm]\nrobot = "irb1200-7-0.7"\n{said}\n'
    with pytest.raises((Refused, Unreadable)) as refused:
        cell(tmp_path, text)
    assert [f.code[: len(code)] for f in refused.value.findings] == [code]


def test_a_thin_body_is_told_the_cells_that_suit_it(tmp_path: Path) -> None:
    save_map(Occupancy.unknown(10.0, "irb1200-7-0.7"), tmp_path / "arm.npz")
    text = CELL.replace('"irb1200-7-0.7"', '"irb1200-7-0.7"\nexplored = "arm.npz"')
    scene, findings = cell(tmp_path, text)
    assert [f.code for f in findings] == ["CK489", "CK497"]
    assert "`nozzle`" in findings[0].message
    names = {body.name: body for body in scene.bodies}
    assert {"arm.unknown", "nozzle.core", "arm.J2.core"} <= set(names)
    assert not names["arm.unknown"].shown
    plain, _ = read_scene(tmp_path / "cell.toml", explored=False)
    assert {body.name for body in plain.bodies} == {"table", "nozzle"}
