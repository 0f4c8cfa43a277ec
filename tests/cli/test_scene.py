"""`scene`: what stands in a cell, told and written."""

from __future__ import annotations

import io
import json
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import trimesh

from tests.cli.tables import each
from tests.cli.test_commands import run

Capture = pytest.CaptureFixture[str]
SAMPLES = Path(__file__).parents[2] / "samples" / "cell"


def test_every_body_has_a_line(capsys: Capture) -> None:
    status, said, err = run(capsys, "scene", SAMPLES / "clamped.toml")
    assert (status, err) == (0, "")
    lines = said.splitlines()
    assert lines[0].startswith("robot arm: ABB IRB 1200-7/0.7")
    assert lines[1].split() == ["body", "stands", "in", "shape", "from", "to", "margin"]
    (table,) = [line for line in lines if line.startswith("table")]
    assert table.split("  ")[0] == "table"
    assert "-300, -500, -41" in table
    assert "900, 500, -1" in table


def test_boxes_around_turned_bodies(tmp_path: Path, capsys: Capture) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text(
        "[bodies.a]\nbox = [100, 10, 20]\neuler_zyx = [90, 0, 0]\nposition = [0, 0, 5]\n"
        '[bodies.b]\nsphere = 5\nparent = "a"\nposition = [50, 0, 0]\n'
    )
    status, said, _ = run(capsys, "scene", cell, "--format", "json")
    assert status == 0
    a, b = json.loads(said)["bodies"]
    assert np.concatenate([a["from"], a["to"]]) == pytest.approx([-5, -50, -5, 5, 50, 15])
    assert np.concatenate([b["from"], b["to"]]) == pytest.approx([-5, 45, 0, 5, 55, 10], abs=0.05)


def test_a_drawing_becomes_a_cell_file_and_that_gltf(tmp_path: Path, capsys: Capture) -> None:
    """A plate of 4 x 2 x 1 inches, whose bodies the text then holds in mm."""
    document = ezdxf.new()  # type: ignore[attr-defined]
    document.units = ezdxf.units.IN
    square = [(0, 0), (4, 0), (4, 2), (0, 2)]
    document.modelspace().add_lwpolyline(
        square, close=True, dxfattribs={"thickness": 1, "layer": "PLATE"}
    )
    document.saveas(tmp_path / "plate.dxf")
    cell, out = tmp_path / "cell.toml", tmp_path / "cell.glb"
    assert run(capsys, "scene", tmp_path / "plate.dxf", "-o", cell)[0] == 0
    assert {file.name for file in tmp_path.iterdir()} == {
        "plate.dxf", "cell.toml", "cell.PLATE.obj"
    }  # fmt: skip
    status, said, _ = run(capsys, "scene", cell, "-o", out)
    assert (status, said.strip()) == (0, f"wrote {out}")
    mesh = trimesh.load_scene(io.BytesIO(out.read_bytes()), file_type="glb").to_mesh()
    assert mesh.extents * 1000 == pytest.approx((101.6, 25.4, 50.8), abs=1e-3)
    assert mesh.volume * 1e9 == pytest.approx(101.6 * 25.4 * 50.8, rel=1e-5)


def test_tables_that_are_not_of_the_world_are_told_of(tmp_path: Path, capsys: Capture) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text("[tools.gun]\ntip = [0, 0, 100]\n[bodies.a]\nsphere = 5\n")
    status, _, err = run(capsys, "scene", cell, "-o", tmp_path / "new.toml")
    assert status == 0
    assert "CK417" in err
    assert "[tools]" in err
    assert "tools" not in (tmp_path / "new.toml").read_text()


UNTOLD = (
    ("[bodies.a]\nsphere = 1\n", ("-o", "cell.step"), 2, "CL045"),
    ("[bodies.a]\nsphere = 1\n", ("-o", "cell.toml"), 2, "CL0"),
    ("[bodies.a]\nsphere = 1\n", ("--unit", "ell"), 2, "ell"),
    ('[bodies.a]\nsphere = 1\nparent = "sky"\n', ("-o", "new.toml"), 1, "CK401"),
    ("[bodies.a]\nsphere = 0\n", ("-o", "new.toml"), 1, "CT303"),
    ("[bodies", (), 2, "CT3"),
)


def test_what_cannot_be_told_is_one_finding(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    def check(text: str, words: tuple[str, ...], status: int, code: str) -> None:
        (tmp_path / "cell.toml").write_text(text)
        ended, said, err = run(capsys, "scene", "cell.toml", *words)
        assert ended == status
        assert code in err
        assert "cell." in err or "unit" in err
        assert said == ""
        assert [file.name for file in tmp_path.iterdir()] == ["cell.toml"]
        assert (tmp_path / "cell.toml").read_text() == text

    each(UNTOLD, check)
