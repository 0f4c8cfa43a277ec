"""`reach`: tables on the screen, columns and pictures in files."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np

from tests.cli.tables import each
from tests.cli.test_commands import run

SAMPLES = Path(__file__).parents[2] / "samples"
STAND = SAMPLES / "cell" / "stand.toml"
FEW = ("--x", "200:500:100", "--y", "0:200:200", "--z", "300")
PNG = b"\x89PNG\r\n\x1a\n"


def test_map_prints_a_table_and_writes_columns_and_a_picture(capsys, tmp_path):
    names = [tmp_path / name for name in ("map.csv", "map.npz", "map.png", "map.svg")]
    outputs = [word for name in names for word in ("-o", name)]
    status, out, err = run(
        *(capsys, "reach", "map", "--cell", STAND, "--tip", "0,0,60", *FEW),
        *("--direction", "down", "--direction", "1,0,-1", *outputs),
    )
    assert (status, err) == (0, "")
    assert "8 points" in out
    rows = list(csv.DictReader(io.StringIO(names[0].read_text())))
    assert len(rows) == 16
    assert {row["direction"] for row in rows} == {"down", "1,0,-1"}
    down = [row for row in rows if row["direction"] == "down"]
    reached = sum(row["reached"] == "1" for row in down)
    (line,) = [line for line in out.splitlines() if line.startswith("down")]
    assert line.split()[1] == str(reached)
    assert 0 < reached <= 8
    for row in rows:
        assert (row["room"] != "") == (row["reached"] == "1")
    with np.load(names[1]) as found:
        assert found["reached"].shape == (8, 2)
        assert int(found["reached"][:, 0].sum()) == reached
    assert names[2].read_bytes().startswith(PNG)
    assert b"<svg" in names[3].read_bytes()


def test_map_answers_in_json(capsys):
    status, out, _ = run(
        *(capsys, "reach", "map", "-r", "rh-6frh5520", "--direction", "up", "--format", "json"),
        *("--x", "200:600:100", "--y", "0", "--z", "200"),
    )
    answer = json.loads(out)
    assert (status, answer["points"], answer["all"]) == (0, 5, 4)  # not 600 mm
    assert answer["directions"][0]["reached"] == 4
    assert answer["findings"] == []


def test_nothing_reached_is_said_with_where_the_flange_points(capsys):
    status, out, err = run(capsys, "reach", "map", "-r", "rh-6frh5520", "--x", "300", "--y", "0")
    assert status == 0
    assert "CK463" in err
    assert "(0.0, 0.0, 1.0)" in err
    assert "0.0 %" in out


TWO = """[robots.left]
robot = "rv-2aj"
position = [0, 400, 0]
[robots.right]
robot = "rv-2aj"
"""


def test_of_two_robots_one_is_named_and_the_other_is_in_the_way(capsys, tmp_path):
    cell = tmp_path / "two.toml"
    cell.write_text(TWO)
    status, _, err = run(capsys, "reach", "map", "--cell", cell)
    assert (status, "CL036" in err) == (2, True)
    status, _, err = run(capsys, "reach", "map", "--cell", cell, "--robot", "rv-2aj")
    assert (status, "CK425" in err) == (2, True)
    there = ("--x", "0:300:100", "--y", "300:400:50", "--z", "300")
    status, out, _ = run(
        capsys, "reach", "map", "--cell", cell, "--robot", "right", *there, "--format", "json"
    )
    assert status == 0
    pairs = [(one["one"], one["other"]) for one in json.loads(out)["nearest"]]
    assert {"left", "right"} in [{name.split(".")[0] for name in pair} for pair in pairs]


def test_a_source_is_not_written_over(capsys, tmp_path):
    cell = tmp_path / "cell.csv"
    cell.write_bytes(STAND.read_bytes())
    status, _, err = run(capsys, "reach", "map", "--cell", cell, *FEW, "-o", cell)
    assert status == 2
    assert cell.read_bytes() == STAND.read_bytes()
    assert "error" in err


TRAY = SAMPLES / "cell" / "tray.toml"
TIP = ("--tip", "0,0,60")


def test_place_finds_where_all_is_reached_and_says_it_as_the_cell_file_does(capsys, tmp_path):
    names = [tmp_path / name for name in ("places.csv", "places.png", "places.svg")]
    outputs = [word for name in names for word in ("-o", name)]
    ranges = ("--x", "-150:0:150", "--y", "-200:0:100")
    status, out, err = run(
        capsys, "reach", "place", "tray", "--cell", TRAY, *TIP, *ranges, *outputs
    )
    assert status == 0
    assert "CK467" in err or not err
    best = out.splitlines()[3]
    assert " 4/4 " in best
    rows = list(csv.DictReader(io.StringIO(names[0].read_text())))
    assert rows[0]["reached"] == rows[0]["targets"] == "4"
    assert names[1].read_bytes().startswith(PNG)
    assert b"<svg" in names[2].read_bytes()
    # Put there, the tray is reached as was promised.
    lines = out.splitlines()
    start = lines.index("[bodies.tray]")
    text = TRAY.read_text().replace("position = [560, 250, 10]", "\n".join(lines[start + 1 :][:2]))
    moved = tmp_path / "moved.toml"
    moved.write_text(text)
    status, out, _ = run(capsys, "reach", "place", "tray", "--cell", moved, *TIP, "--x", "0")
    assert status == 0
    assert out.splitlines()[3].split()[3:] == best.split()[-len(out.splitlines()[3].split()) + 3 :]


def test_place_says_what_is_reached_nowhere(capsys):
    status, out, err = run(capsys, "reach", "place", "tray", "--cell", TRAY, *TIP, "--x", "0")
    assert status == 1
    assert "the best one, where it is, reaches 2 of 4, and not `tray.c`" in err
    assert "(not tray.c)" in out
    assert "[bodies.tray]" not in out


def test_base_answers_in_json_for_a_program_without_a_cell(capsys):
    status, out, _ = run(
        *(capsys, "reach", "base", SAMPLES / "plate.dxf", "--robot", "irb1200-7-0.7"),
        *("--x", "-100:0:100", "--format", "json"),
    )
    answer = json.loads(out)
    assert status == 0
    assert answer["moved"] == "robot"
    assert len(answer["places"]) == 2
    assert answer["places"][0]["reached"] == answer["targets"]
    assert answer["places"][0]["offset"] == [-100.0, 0.0, 0.0, 0.0]


MAPS = (
    ((), "CL036"),
    (("-r", "nobody"), "CO002"),
    (("-r", "rv-2aj", "--cell", STAND), "CK423"),
    (("--cell", STAND, "--x", "1:2"), "CK460"),
    (("--cell", STAND, "--x", "0:100000:0.001"), "CK461"),
    (("--cell", STAND, "--turns", "0"), "CK468"),
    (("--cell", STAND, "--direction", "left"), "CK462"),
    (("--cell", STAND, "--tip", "1,2"), "CL038"),
    (("--cell", STAND, "--tip", "1,2,3,0,0,0,0"), "CL038"),
    (("--cell", STAND, "--margin", "-1"), "CL039"),
    (("--cell", STAND, "--margin", "nan"), "CL039"),
    (("--cell", STAND, "-o", "map.txt"), "CL037"),
    (("--cell", "nowhere.toml"), ""),
)
PLACES = (
    (("place", "tray"), "CL040"),
    (("place", "nothing", "--cell", TRAY), "CK465"),
    (("place", "gripper", "--cell", TRAY), "CK465"),
    (("place", "table", "--cell", TRAY), "CK464"),
    (("place", "tray", "--cell", TRAY, "--turns", "9999"), "CK468"),
    (("place", "tray", "--cell", TRAY, "--turn", "a"), "CK460"),
    (("place", "tray", "--cell", TRAY, "-o", "a.npz"), "CL037"),
    (("base",), "CL036"),
    (("base", "--robot", "rv-2aj"), "CK464"),
    (("base", SAMPLES / "plate.dxf", "--cell", TRAY, *TIP), "CL041"),
    (("base", "nowhere.dxf", "--cell", TRAY), "IN"),
    (("base", SAMPLES / "plate.dxf", "--robot", "rv-2aj", "--cell", TRAY), "CK423"),
)


def test_what_is_not_there_is_refused_with_one_finding(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def check(arguments, code):
        status, out, err = run(capsys, "reach", *arguments)
        assert (status, out) == (2, "")
        assert code in err
        assert err.count(" error") == 1
        assert not list(tmp_path.iterdir())

    each([(("map", *arguments), code) for arguments, code in MAPS], check)
    each(PLACES, check)


WAY = """program way for irb1200-7-0.7

target a [400, -100, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]

procedure main
  move joint a speed 500 mm/s blend fine
  move linear b speed 500 mm/s blend fine
end
"""


def test_swept_prints_volumes_and_writes_cells_a_surface_and_a_picture(capsys, tmp_path):
    source = tmp_path / "way.pseudo"
    source.write_text(WAY)
    names = [tmp_path / f"space{end}" for end in (".csv", ".npz", ".glb", ".png", ".svg")]
    outputs = [word for name in names for word in ("-o", name)]
    status, out, err = run(capsys, "reach", "swept", source, "--size", "80", *outputs)
    assert (status, err) == (0, "")
    rows = list(csv.DictReader(io.StringIO(names[0].read_text())))
    (line,) = [line for line in out.splitlines() if line.startswith("all ")]
    assert line.split()[1:] == [f"{len(rows):,}", f"{len(rows) * 0.512:.1f}"]
    assert rows[0].keys() == {"x_mm", "y_mm", "z_mm", *(f"robot.J{i}" for i in (1, 2, 3, 4, 6))}
    with np.load(names[1]) as found:
        assert found["swept"].shape == (5, len(rows))
        assert found["swept"].any(axis=0).all()
    assert names[2].read_bytes().startswith(b"glTF")
    assert names[3].read_bytes().startswith(PNG)
    assert b"<svg" in names[4].read_bytes()
    status, out, _ = run(capsys, "reach", "swept", source, "--size", "80", "--format", "json")
    assert (status, json.loads(out)["cells"]) == (0, len(rows))


UNSWEPT = (
    (WAY, ("--size", "0"), 2, "CK458"),
    (WAY, ("--size", "0.5"), 2, "CK461"),
    (WAY, ("-o", "a.stl"), 2, "CL037"),
    (WAY, ("--cell", SAMPLES / "cell" / "nothing.toml"), 2, ""),
    (WAY.replace(" for irb1200-7-0.7", ""), (), 2, "CL010"),
    (WAY.replace("[400, 100", "[4000, 100"), (), 1, "RB"),
)


def test_what_cannot_be_swept_is_refused(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "way.pseudo"

    def check(text, arguments, status, code):
        source.write_text(text)
        found, _, err = run(capsys, "reach", "swept", source, *arguments)
        assert found == status
        assert code in err
        assert " error" in err
        assert [path.name for path in tmp_path.iterdir()] == ["way.pseudo"]

    each(UNSWEPT, check)
