"""`explore`: charts on the command line, and checks that keep a robot to what its chart knows."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from assistant.cell.exploration.occupancy import CellState, Occupancy, keys_of, load_map, save_map
from tests.cli.test_commands import run

Capture = pytest.CaptureFixture[str]
CELL = '[robots.arm]\nrobot = "rv-2aj"\n'
HIDDEN = CELL + "[bodies.post]\ncylinder = [40, 600]\nposition = [0, 330, 300]\n"
PROGRAM = """program demo
target a [250, -100, 300] [0, 0, 1, 0]
target b [250, 100, 300] [0, 0, 1, 0]
target c [250, 100, 400] [0, 0, 1, 0]
procedure main
move joint a speed 200 mm/s blend fine
move linear b speed 200 mm/s blend fine
end
"""
FARTHER = PROGRAM.replace("\nend", "\nmove linear c speed 200 mm/s blend fine\nend")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a cell, what is hidden in it, and programs."""
    monkeypatch.chdir(tmp_path)
    files = {"cell.toml": CELL, "hidden.toml": HIDDEN, "demo.pseudo": PROGRAM}
    files |= {"farther.pseudo": FARTHER, "known.toml": CELL + 'explored = "arm.npz"\n'}
    for name, text in files.items():
        Path(name).write_text(text, encoding="utf-8")
    return tmp_path


def answer(capsys: Capture, *words: str, exits: int = 0) -> Any:
    status, out, err = run(capsys, *words, "--format", "json")
    assert status == exits, err
    return json.loads(out)


def codes(capsys: Capture, *words: str, exits: int = 2) -> list[str]:
    status, out, err = run(capsys, *words)
    assert status == exits, err
    lines = (err + out).splitlines()
    return [line.split()[0] for line in lines if line[:2].isupper() and line[2:5].isdigit()]


def test_where_a_program_was_it_may_go_again_and_nowhere_else(here: Path, capsys: Capture) -> None:
    words = ("explore", "program", "demo.pseudo", "--cell", "cell.toml", "--chart", "arm.npz")
    for name, text in (("demo", PROGRAM), ("farther", FARTHER)):  # a short way
        (here / f"{name}.pseudo").write_text(text.replace("[250, 100,", "[250, -60,"))
    told = answer(capsys, *words)
    assert told["chart"]["runs"] == 1 and told["contacts"] == 0
    assert told["chart"]["free"] == load_map("arm.npz").counts()[CellState.FREE] > 2000
    assert run(capsys, "check", "demo.pseudo", "--cell", "known.toml")[0] == 0
    found = set(codes(capsys, "check", "farther.pseudo", "--cell", "known.toml", exits=1))
    assert found == {"CK459", "CK497"}
    said = "unknown = 'free'\n"
    (here / "beside.toml").write_text(CELL + "explored = 'arm.npz'\n" + said, encoding="utf-8")
    assert run(capsys, "check", "farther.pseudo", "--cell", "beside.toml")[0] == 0
    assert (
        run(capsys, "compile", "farther.pseudo", "-l", "melfa-basic-4", "--cell", "known.toml")[0]
        == 1
    )
    assert not list(here.glob("*.prg"))


def test_contacts_that_were_found_are_in_the_way_of_a_program(here: Path, capsys: Capture) -> None:
    """At a place of the way, where a contact made a free cell an occupied one."""
    words = ("explore", "program", "demo.pseudo", "--cell", "cell.toml", "--chart", "arm.npz")
    answer(capsys, *words, "--size", "20")
    known = load_map("arm.npz")
    none = np.zeros(0, dtype=np.int64)
    save_map(known.with_run(none, keys_of(np.array([[12, 0, 16]]))), "arm.npz")
    for unknown in ("free", "blocked"):
        text = f"{CELL}explored = 'arm.npz'\nunknown = '{unknown}'\n"
        (here / "beside.toml").write_text(text, encoding="utf-8")
        assert "CK421" in codes(capsys, "check", "demo.pseudo", "--cell", "beside.toml", exits=1)


def test_wandering_goes_on_with_a_map_and_the_same_seed_gives_the_same(
    here: Path, capsys: Capture
) -> None:
    words = ("explore", "wander", "cell.toml", "--hidden", "hidden.toml", "--size", "20")
    first = answer(capsys, *words, "--runs", "4", "--seed", "1", "--chart", "one.npz")
    answer(capsys, *words, "--runs", "4", "--seed", "1", "--chart", "two.npz")
    assert Path("one.npz").read_bytes() == Path("two.npz").read_bytes()
    assert [row["runs"] for row in first["explored"]] == [1, 2, 4]
    assert first["contacts"] > 0
    more = answer(capsys, *words, "--runs", "2", "--chart", "two.npz")
    assert more["chart"]["runs"] == 6 and more["chart"]["litres"] > first["chart"]["litres"]
    told = answer(capsys, "explore", "compare", "one.npz", "two.npz")
    assert told["gained"] > 0 and told["lost"] == told["blocked"] == 0
    told = answer(capsys, "explore", "merge", "one.npz", "two.npz", "-o", "both.npz")
    assert told["chart"]["free"] == more["chart"]["free"] and told["chart"]["runs"] == 10
    shown = answer(capsys, "explore", "show", "two.npz")
    assert {key: shown[key] for key in more["chart"]} == more["chart"]
    assert "cells    20 mm" in run(capsys, "explore", "show", "two.npz", "-o", "two.png")[1]
    assert Path("two.png").read_bytes().startswith(b"\x89PNG")
    assert codes(capsys, "explore", "show", "two.npz", "-o", "two.txt") == ["CL009"]


def test_a_recording_of_a_motion_knows_what_the_program_does(here: Path, capsys: Capture) -> None:
    assert run(capsys, "simulate", "demo.pseudo", "-r", "rv-2aj", "-o", "motion.csv")[0] == 0
    given = ("--cell", "cell.toml", "--size", "20", "--chart")
    told = answer(capsys, "explore", "recorded", "motion.csv", *given, "one.npz")
    answer(capsys, "explore", "program", "demo.pseudo", *given, "two.npz")
    free = [set(load_map(name).keys.tolist()) for name in ("one.npz", "two.npz")]
    assert len(free[0] ^ free[1]) < 0.02 * len(free[0])
    assert told["explored"][0]["runs"] == 1
    half = answer(
        capsys, "explore", "recorded", "motion.csv", *given, "thin.npz", "--thinner", "10"
    )
    assert 0 < half["chart"]["free"] < told["chart"]["free"]


MOVE = "move linear b speed 200 mm/s blend fine"


BODIES = (
    f"if s = 1\n{MOVE}\nend",
    f"while s = 1\n{MOVE}\nend",
    f"for i from 1 to n\n{MOVE}\nend",
    f"{MOVE} until s = 1",
    f"goto behind\n{MOVE}\nlabel behind",
)


def test_a_program_that_may_go_several_ways_tells_nothing(here: Path, capsys: Capture) -> None:
    """What it has not done would be called free."""
    said = "target a [2"
    text = PROGRAM.replace(said, f"signal s digital input\nvariable n number = 0\n{said}")
    words = ("explore", "program", "demo.pseudo", "--cell", "cell.toml", "--chart", "arm.npz")
    for body in BODIES:
        (here / "demo.pseudo").write_text(text.replace(MOVE, body), encoding="utf-8")
        assert codes(capsys, *words, exits=1) == ["CK492"], body
        assert not Path("arm.npz").exists()


def test_what_was_free_and_is_occupied_is_told_by_the_exit_status(
    here: Path, capsys: Capture
) -> None:
    none, cell = np.zeros(0, dtype=np.int64), keys_of(np.array([[1, 2, 3]]))
    save_map(Occupancy.unknown(10.0, "rv-2aj").with_run(cell, none), "old.npz")
    save_map(Occupancy.unknown(10.0, "rv-2aj").with_run(none, cell), "new.npz")
    assert answer(capsys, "explore", "compare", "old.npz", "new.npz", exits=1)["blocked"] == 1
    assert answer(capsys, "explore", "compare", "new.npz", "old.npz")["freed"] == 1


def test_wrong_usage_changes_no_map(here: Path, capsys: Capture) -> None:
    save_map(Occupancy.unknown(15.0, "rv-2aj"), "arm.npz")
    save_map(Occupancy.unknown(15.0, "rv-1a"), "other.npz")
    shutil.copy("arm.npz", "before.npz")
    moved = HIDDEN.replace("[bodies", "position = [10, 0, 0]\n[bodies", 1)
    (here / "moved.toml").write_text(moved, encoding="utf-8")
    larger = HIDDEN.replace("rv-2aj", "rv-1a")
    (here / "larger.toml").write_text(larger, encoding="utf-8")
    wander = ("explore", "wander", "cell.toml", "--runs", "1", "--chart")
    cases = {
        (*wander, "arm.txt"): ["CL280"],
        (*wander, "other.npz"): ["CK452"],
        (*wander, "arm.npz", "--size", "10"): ["CK452"],
        (*wander, "new.npz", "--size", "-1"): ["CK458"],
        (*wander, "new.npz", "--thinner", "-1"): ["CK458"],
        (*wander, "new.npz", "--robot", "leg"): ["CK457"],
        (*wander, "new.npz", "--hidden", "moved.toml"): ["CK488"],
        (*wander, "new.npz", "--hidden", "larger.toml"): ["CK487"],
        ("explore", "merge", "arm.npz", "other.npz", "-o", "new.npz"): ["CK452"],
        ("explore", "merge", "arm.npz", "before.npz", "-o", "arm.npz"): ["CL007"],
        ("explore", "compare", "arm.npz", "other.npz"): ["CK452"],
        (*("explore", "program", "demo.pseudo", "--cell", "cell.toml", "--chart", "new.npz"),
         "--until", "0"): ["CL281"],
    }  # fmt: skip
    for words, expected in cases.items():
        assert codes(capsys, *words) == expected, words
    assert not Path("new.npz").exists()
    assert Path("arm.npz").read_bytes() == Path("before.npz").read_bytes()
