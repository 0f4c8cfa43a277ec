"""Names that people taught stay, in translations and in findings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from assistant.compiler import translate
from assistant.report.translation import renamed_items
from tests.cli.test_commands import run

HEAD = "1 Tool P_NTool\n2 Base P_NBase\n3 Spd 150\n4 Cnt 0\n"


def written(folder: Path, numbers: list[int], *, stem: str = "P", far: int = 0) -> Path:
    """A program that goes to positions once each, of which one is out of reach."""
    moves = [f"{at} Mvs {stem}{n}" for at, n in enumerate(numbers, 5)]
    x = {n: 980 if n == far else 360 + k for k, n in enumerate(numbers)}
    places = [f"{stem}{n}=(+{x[n]}.00,+10.00,+310.00,+180.00,+0.00,+180.00)(7,0)" for n in numbers]
    file = folder / "JOB.prg"
    file.write_text(HEAD + "\n".join([*moves, f"{len(moves) + 5} End", *places, ""]), "ascii")
    return file


@pytest.mark.parametrize("count", [2, 3, 7, 8, 9, 30])
@pytest.mark.parametrize("first", [1, 10, 98])
def test_positions_keep_their_names(tmp_path: Path, first: int, count: int) -> None:
    numbers = list(range(first, first + count))
    made = translate(written(tmp_path, numbers), to="rapid")
    (text,) = made.files.values()
    assert made.ok
    found = re.findall(r"MoveL (\w+),", text.decode())
    assert found == [f"P{number}" for number in numbers]
    assert re.findall(r"CONST robtarget (\w+):=", text.decode()) == found


def test_positions_with_other_stems_keep_their_names(tmp_path: Path) -> None:
    made = translate(written(tmp_path, [3, 4, 5, 6], stem="PGLUE"), to="rapid")
    (text,) = made.files.values()
    assert re.findall(r"MoveL (\w+),", text.decode()) == ["PGLUE3", "PGLUE4", "PGLUE5", "PGLUE6"]


@pytest.mark.parametrize("far", [2, 4])
def test_a_target_out_of_reach_is_named_with_its_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, far: int
) -> None:
    file = written(tmp_path, [1, 2, 3, 4, 5], far=far)
    file.write_text(file.read_text("ascii").replace(f"Mvs P{far}", f"Mvs P{far} 'look"), "ascii")
    status, out, err = run(capsys, "check", file, "-r", "rv-4frl")
    assert status == 1
    assert f"(P{far})" in out + err
    assert f"{file}:{far + 4}:" in out + err
    assert "P_" not in re.sub("P_N(Tool|Base)", "", out + err)


@pytest.mark.parametrize("stem", ["P", "PSEAM"])
def test_so_many_positions_that_they_become_a_path_are_reported(tmp_path: Path, stem: str) -> None:
    file = written(tmp_path, [*range(7, 2108)], stem=stem)
    made = translate(file, to="rapid")
    found = [(row.place.line, r) for row in made.rows for r in row.reasons if r.code == "MB297"]
    assert made.ok
    assert [(f.message.split(" lose ")[0], line) for line, f in found] == [
        (f"the 2101 positions `{stem}7` to `{stem}2107`", 5)
    ]
    news = [
        (old.name, new) for old, new, _ in renamed_items(made) if old.name.startswith(f"{stem}2")
    ]
    assert (f"{stem}2107", f"{stem}_2101") in news
    (text,) = (data.decode() for data in made.files.values())
    assert f"{stem}_2101:=" in text


def test_a_row_of_a_path_is_named_as_in_its_text(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = written(tmp_path, [*range(7, 2108)])
    text = file.read_text("ascii")
    text = re.sub(r"=\(\+\d+", "=(+400", text).replace("P2100=(+400", "P2100=(+9400")
    file.write_text(text, "ascii")
    said = "".join(run(capsys, "check", file, "-r", "rv-4frl")[1:])
    assert "(P2100)" in said and f"{file}:{5 + 2100 - 7}:" in said
    assert "P_" not in re.sub("P_N(Tool|Base)", "", said)
