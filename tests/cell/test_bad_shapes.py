"""Files of shapes that are none: a finding each, and no traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.cell.reading.cell_file import read_scene
from assistant.program.diagnostics import Refused

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
