"""`info`: what a drawing holds, told before anything is done with it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from assistant.cli import main

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Exit status, standard output and errors of a command."""

    def _run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            main(list(arguments))
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.out, said.err

    return _run


@pytest.fixture
def part(tmp_path: Path) -> Path:
    """As a CAD system exports it: inches, a layer `Default`, odd names, blocks, hidden layers."""
    document = ezdxf.new("R2013", units=1)
    space = document.modelspace()
    for name, colour in (("Default", 3), ("Außen kontur", 1), ("HIDDEN", 5), ("COLD", 6)):
        document.layers.add(name, color=colour)
    document.layers.get("HIDDEN").off()
    document.layers.get("COLD").freeze()
    space.add_lwpolyline([(0, 0), (4, 0), (4, 2), (0, 2)], close=True,
                         dxfattribs={"layer": "Default"})  # fmt: skip
    space.add_line((5, 0), (6, 0), dxfattribs={"layer": "Default"})
    space.add_line((6.0001, 0), (6, 1), dxfattribs={"layer": "Default"})
    space.add_text("part 7", dxfattribs={"layer": "Default"})
    space.add_circle((2, 1), 0.5, dxfattribs={"layer": "Außen kontur"})
    space.add_line((0, 0), (90, 90), dxfattribs={"layer": "HIDDEN"})
    space.add_line((0, 0), (90, 90), dxfattribs={"layer": "COLD"})
    hole = document.blocks.new("HOLE")
    hole.add_circle((0, 0), 0.1)
    for x in (1, 3):
        space.add_blockref("HOLE", (x, 1), dxfattribs={"layer": "Default"})
    pick = document.blocks.new("PICK")
    pick.add_line((0, 0), (1, 0))
    insert = space.add_blockref("PICK", (0.5, 0.5, 1), dxfattribs={"layer": "POSES"})
    insert.add_attrib("NAME", "pick_1")
    insert.add_attrib("TOOL", "a gripper that nobody declared")
    path = tmp_path / "Teil (ä) 7.dxf"
    document.saveas(path)
    return path


def told(run: Run, *arguments: str) -> dict[str, Any]:
    status, printed, errors = run("info", *arguments, "--format", "json")
    assert (status, errors) == (0, "")
    answer: dict[str, Any] = json.loads(printed)
    return answer


def test_unit_and_size_are_told_in_millimetres(run: Run, part: Path) -> None:
    answer = told(run, str(part))
    inches = {"name": "inches", "millimetres": 25.4, "stated": "as the drawing says"}
    assert answer["unit"] == inches
    assert answer["extents"]["from"] == pytest.approx([0, 0, 0])
    assert answer["extents"]["to"] == pytest.approx([6.0001 * 25.4, 2 * 25.4, 25.4])
    said = told(run, str(part), "--unit", "mm")
    assert (said["unit"]["name"], said["unit"]["stated"]) == ("millimetres", "as --unit says")
    assert said["extents"]["to"] == pytest.approx([6.0001, 2, 1])


def test_layers_are_told_with_what_is_on_them(run: Run, part: Path) -> None:
    layers = {layer["name"]: layer for layer in told(run, str(part))["layers"]}
    usual = layers["Default"]
    assert usual["entities"] == {"LWPOLYLINE": 1, "LINE": 2, "CIRCLE": 2, "TEXT": 1}
    assert usual["unused"] == {"TEXT": 1}
    assert usual["contours"] == {"closed": 3, "open": 1}
    whole = 12 + 2 + 2 * 2 * math.pi * 0.1
    assert usual["length"] == pytest.approx(25.4 * whole, rel=1e-4)
    assert (usual["state"], usual["colour"]) == ("on", 3)
    circle = layers["Außen kontur"]
    assert circle["extents"]["from"] == pytest.approx([1.5 * 25.4, 0.5 * 25.4, 0], abs=1e-3)
    assert [layers[name]["state"] for name in ("HIDDEN", "COLD")] == ["off", "frozen"]
    assert layers["HIDDEN"]["use"] == "nothing: the layer is off"
    assert layers["HIDDEN"]["extents"] is None
    assert layers["POSES"]["use"] == "locations are visited"


def test_blocks_and_locations_are_told_with_their_attributes(run: Run, part: Path) -> None:
    answer = told(run, str(part))
    blocks = {block["name"]: block for block in answer["blocks"]}
    assert (blocks["HOLE"]["inserts"], blocks["HOLE"]["location"]) == (2, False)
    assert blocks["PICK"]["location"]
    assert blocks["PICK"]["attributes"]["NAME"] == ["pick_1"]
    (location,) = answer["locations"]
    assert (location["name"], location["layer"]) == ("pick_1", "POSES")
    assert location["position"] == pytest.approx([12.7, 12.7, 25.4])


def test_what_would_be_used_is_what_the_process_file_says(run: Run, part: Path) -> None:
    part.with_suffix(".process.toml").write_text(
        'leave_out = ["*"]\n[layers."Außen kontur"]\n[placement]\nposition = [900, 0, 0]\n', "utf-8"
    )
    answer = told(run, str(part))
    uses = {layer["name"]: layer["use"] for layer in answer["layers"]}
    assert uses["Außen kontur"] == "contours are followed"
    assert uses["Default"] == uses["POSES"] == "left out"
    assert answer["extents"]["from"] == pytest.approx([0, 0, 0])  # as drawn, not as placed


def test_the_tables_are_for_people(run: Run, part: Path) -> None:
    status, printed, errors = run("info", str(part))
    assert (status, errors) == (0, "")
    lines = printed.splitlines()
    assert lines[0] == "unit: inches, as the drawing says (25.4 mm each)"
    assert lines[1].startswith("size: 152.4 x 50.8 x 25.4 mm, from [0.000, 0.000, 0.000] to [")
    (row,) = [line for line in lines if line.startswith("Default ")]
    assert "3 closed, 1 open" in row
    assert row.endswith("contours are followed as [motion] says; not used: 1 TEXT")


def test_a_drawing_without_a_unit_is_told_of(run: Run, tmp_path: Path) -> None:
    document = ezdxf.new(units=0)
    document.modelspace().add_line((0, 0), (1, 0))
    document.saveas(tmp_path / "a.dxf")
    status, printed, errors = run("info", str(tmp_path / "a.dxf"))
    assert status == 1
    assert "DX101 warning" in errors
    assert "unit: millimetres, assumed, as the drawing names none" in printed


def test_what_is_no_drawing_is_refused_and_an_empty_one_has_no_size(
    run: Run, tmp_path: Path
) -> None:
    for name, code in (("none.dxf", "IN001"), ("a.mod", "CL050")):
        status, _, errors = run("info", str(tmp_path / name))
        assert (status, code in errors) == (2, True), name
    ezdxf.new(units=4).saveas(tmp_path / "a.dxf")
    status, printed, _ = run("info", str(tmp_path / "a.dxf"))
    assert status == 0
    assert "size: nothing in it can be followed or visited" in printed


def test_a_process_file_that_is_not_finished_hides_nothing(run: Run, part: Path) -> None:
    part.with_suffix(".process.toml").write_text("[tools.tool]\ntip = []\n")
    status, printed, errors = run("info", str(part))
    assert status == 1
    assert "CT303" in errors
    assert printed.startswith("unit: inches, as the drawing says")
