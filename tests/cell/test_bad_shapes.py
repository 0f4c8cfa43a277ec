"""Files of shapes that are none: a finding each, and no traceback."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from assistant.base.diagnostics import Refused
from assistant.cell.cell_file import read_scene
from assistant.cell.scene import Box, Capsule, Convex, Cylinder, Mesh, Shape, Sphere
from assistant.compiler import check_files

FLAT = "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nf 1 2 3\nf 1 3 4\n"
LINE = "v 0 0 0\nv 100 0 0\nv 200 0 0\nf 1 2 3\n"
FAR = "v 0 0 0\nv 1e9 0 0\nv 0 1e9 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
NOWHERE = "v 0 0 0\nv nan 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"


@pytest.mark.parametrize(
    ("obj", "key", "word"),
    [
        (FLAT, "convex", "lie in one plane"),
        (LINE, "convex", ""),
        (LINE, "mesh", ""),
        (FAR, "mesh", "away from its origin"),
        (FAR, "convex", "away from its origin"),
        (NOWHERE, "convex", ""),
    ],
)
def test_a_file_that_is_no_shape_is_refused(tmp_path: Path, obj: str, key: str, word: str) -> None:
    (tmp_path / "shape.obj").write_text(obj)
    cell = tmp_path / "cell.toml"
    cell.write_text(f'[bodies.part]\n{key} = "shape.obj"\nunit = "mm"\n')
    with pytest.raises(Refused) as caught:
        read_scene(cell)
    (finding,) = [f for f in caught.value.findings if f.code == "CK407"]
    assert word in finding.message


@pytest.mark.parametrize(
    "shape",
    ["box = [0, 1, 1]", "sphere = nan", "sphere = inf", "cylinder = [1, 0]", "capsule = [-1, 5]"],
)
def test_a_size_that_is_none_is_refused(tmp_path: Path, shape: str) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text(f"[bodies.part]\n{shape}\n")
    with pytest.raises(Refused) as caught:
        read_scene(cell)
    assert len(caught.value.findings) == 1


NAN, INF = float("nan"), float("inf")
FOUR = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 9.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.mark.parametrize(
    "made",
    [
        lambda: Box((1.0, NAN, 1.0)),
        lambda: Box((1.0, 0.0, 1.0)),
        lambda: Sphere(-1.0),
        lambda: Sphere(INF),
        lambda: Cylinder(1.0, NAN),
        lambda: Cylinder(0.0, 1.0),
        lambda: Capsule(-1.0, 1.0),
        lambda: Convex(FOUR[:, :2]),
        lambda: Convex(FOUR + NAN),
        lambda: Convex(FOUR[:3]).hull,
        lambda: Convex(np.concatenate([FOUR[:3], [[9.0, 9.0, 0.0]]])).hull,
        lambda: Mesh(FOUR, FACES[:0]),
        lambda: Mesh(FOUR, FACES + 1),
        lambda: Mesh(FOUR, FACES - 1),
        lambda: Mesh(FOUR + INF, FACES),
        lambda: Mesh(FOUR[:0], FACES),
        lambda: Mesh(FOUR, FACES, off=-1.0),
    ],
)
def test_a_shape_made_in_python_is_refused_too(made: Callable[[], Shape]) -> None:
    with pytest.raises(Refused) as caught:
        made()
    (finding,) = caught.value.findings
    assert finding.code == "CK414"
    assert finding.cure


def tetrahedron(*more: str, faces: tuple[str, ...] = ("1 3 2", "1 2 4", "1 4 3", "2 3 4")) -> str:
    """In Wavefront OBJ, with more corners and faces behind it."""
    corners = ["v 0 0 0", "v 90 0 0", "v 0 90 0", "v 0 0 90"]
    return "\n".join([*corners, *(f"f {face}" for face in faces), *more]) + "\n"


@pytest.mark.parametrize(
    ("obj", "code", "word"),
    [
        (tetrahedron(faces=("1 3 2", "1 2 4", "1 4 3")), "CK408", "3 edges"),
        (tetrahedron(faces=("1 2 3", "1 4 2", "1 3 4", "2 4 3")), "CK409", "inwards"),
        (tetrahedron("v 45 0 0", "f 1 2 5", "f 2 1 5"), "CK410", "2 of 6"),
    ],
    ids=["open", "inside out", "no area"],
)
def test_what_is_wrong_with_a_mesh_is_one_finding(
    tmp_path: Path, obj: str, code: str, word: str
) -> None:
    (tmp_path / "shape.obj").write_text(obj)
    cell = tmp_path / "cell.toml"
    cell.write_text('[bodies.part]\nmesh = "shape.obj"\nunit = "mm"\n')
    scene, findings = read_scene(cell)
    assert len(scene.bodies) == 1
    (finding,) = findings
    assert finding.code == code
    assert word in finding.message
    assert finding.cure


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("[bodies.a]\nsphere = 1\n[bodies.A]\nsphere = 2\n", "CT313"),
        ("[bodies.a]\nsphere = 1\n[bodies.a]\nsphere = 2\n", "CT301"),
        ("[bodies.a]\nparts = {}\n", "CK404"),
        ("[bodies.a]\nparts = 3\n", "CT304"),
        ("[bodies.a.parts.b]\nposition = [0, 0, 0]\n", "CK404"),
        ("[bodies.a]\nbox = [1, 1, 1]\n[bodies.a.parts.b]\nsphere = 1\n", "CK404"),
        ("[bodies.a.parts.b]\ndrawing = 'a.dxf'\n", "CK404"),
        ("[bodies.a]\nsphere = 1\noff = 1\n", "CK404"),
        ("[bodies.a.parts.b]\nsphere = nan\n", "CT303"),
    ],
)
def test_names_and_parts_that_are_none(tmp_path: Path, text: str, code: str) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text(text)
    with pytest.raises(Refused) as caught:
        read_scene(cell)
    assert [finding.code for finding in caught.value.findings] == [code]


def test_a_robot_that_stands_in_something_is_told_of_once(tmp_path: Path) -> None:
    cell, program = tmp_path / "cell.toml", tmp_path / "goes.pseudo"
    cell.write_text(
        '[robots.arm]\nrobot = "irb1200-7-0.7"\n[bodies.post]\nbox = [50, 50, 900]\n'
        "position = [300, 0, 450]\n"
    )
    program.write_text(
        "program goes\ntarget a [450, 0, 450] [0, 0, 1, 0]\nprocedure main\n"
        "move joint a speed 100 mm/s blend fine\nend\n"
    )
    findings = check_files([program], cell=cell).findings
    touched = [(f.code, f.message.split(" after ")[0]) for f in findings if f.code == "CK421"]
    assert touched
    assert len(touched) == len(set(touched))
