"""`pose`: poses of other controllers, one by one and as columns of a table."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from assistant.cli import main

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    def _run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            main(["pose", *arguments])
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.out, said.err

    return _run


def test_a_pose_is_shown_in_every_convention(run: Run) -> None:
    status, out, _ = run("[[600,0,400],[0,0,1,0]]", "--from", "rapid")
    assert status == 0
    rows = {line.split()[0]: line.split("(")[0].split()[1:] for line in out.splitlines()[:6]}
    assert rows["kuka"] == ["600", "0", "400", "180", "0", "180"]
    assert rows["xyzw"] == ["600", "0", "400", "0", "1", "0", "0"]
    assert out.splitlines()[-1].split() == ["0", "0", "0", "1"]


def test_negative_numbers_are_no_options(run: Run) -> None:
    assert run(*["-100", "20", "300.5", "180", "0", "-90", "--from", "melfa", "--to", "kuka"])[
        :2
    ] == (
        0,
        "-100 20 300.5 -90 0 180\n",
    )
    assert run("--unti", "m", "1", "--from", "melfa")[0] == 1


def test_units_are_converted_and_asked_for(run: Run) -> None:
    given = ("1", "2", "3", "0", "0", "0", "--from", "rotation-vector", "--to", "fanuc")
    status, _, err = run(*given)
    assert status == 2 and "CL076" in err and "--unit" in err
    assert run(*given, "--unit", "m")[1] == "1000 2000 3000 0 0 0\n"
    _, out, _ = run(*given, "--unit", "mm", "--to-unit", "m", "--format", "json")
    assert json.loads(out)["poses"]["fanuc"]["x_m"] == 0.001


@pytest.mark.parametrize("option", ("--columns", "--output"))
def test_options_of_tables_are_refused_with_a_pose(run: Run, tmp_path: Path, option: str) -> None:
    file = tmp_path / "x"
    status, out, err = run("600", "0", "400", "0", "90", "0", "--from", "kuka", option, str(file))
    assert (status, out, file.exists()) == (2, "", False)
    assert "CL077" in err and f"leave {option} out" in err


def test_no_column_is_not_all_of_them(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "way.csv"
    table.write_text("X,Y,Z,A,B,C\n600,0,400,0,90,0\n", encoding="utf-8")
    assert "TB456" in run(str(table), "--from", "kuka", "--columns", "")[2]


def test_the_columns_of_a_table_are_replaced(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "way.csv"
    table.write_text("name,X,Y,Z,A,B,C\np1,600,0,400,0,90,0\n", encoding="utf-8")
    _, out, _ = run(str(table), "--from", "kuka", "--to", "rapid")
    assert out == (
        "x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,name\n600,0,400,0.707106781,0,0.707106781,0,p1\n"
    )
    file = tmp_path / "there.csv"
    assert (
        run(str(table), "--from", "kuka", "--to", "fanuc", "--to-unit", "m", "-o", str(file))[0]
        == 0
    )
    assert file.read_text("utf-8").splitlines()[1] == "0.6,0,0.4,0,90,0,p1"
    assert (
        run(str(file), "--from", "fanuc", "--to", "kuka")[1].splitlines()[1]
        == "600,0,400,0,90,0,p1"
    )
    status, _, err = run(str(file), "--from", "fanuc", "--unit", "mm")
    assert status == 1 and "TB455" in err
    named = ("--columns", "X,Y,Z,C,B,A")
    assert (
        run(str(table), "--from", "melfa", "--to", "kuka", *named)[1]
        .splitlines()[1]
        .endswith("0,90,0,p1")
    )
    for wrong, code in (("X,Y,Z", "TB456"), ("X,Y,Z,C,B,U", "TB454"), ("X,Y,Z,C,B,B", "TB454")):
        assert code in run(str(table), "--from", "melfa", "--columns", wrong)[2]
    assert "TB454" in run(str(table), "--from", "fanuc")[2]
