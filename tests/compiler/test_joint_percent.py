"""The percentage of joint moves that a process file states, where a controller takes no mm/s."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.compiler import Compiled, compile, translate

TABLE = """\
x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z,motion,speed_mm_s
300,0,400,0,0,1,0,joint,100
310,0,400,0,0,1,0,linear,60
300,10,400,0,0,1,0,joint,1000
"""
MODULE = """\
MODULE part
  CONST speeddata slow:=[80,500,5000,1000];
  CONST robtarget p:=[[300,0,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ p,slow,fine,tool0;
    MoveL Offs(p,9,0,0),slow,fine,tool0;
    MoveJ p,vmax,fine,tool0;
  ENDPROC
ENDMODULE
"""


def lines(done: Compiled) -> list[str]:
    """The statements of the program that is written, without their numbers."""
    (data,) = done.files.values()
    text = data.decode("latin-1").splitlines()
    return [line.partition(" ")[2] for line in text if line[:1].isdigit() and "'" not in line]


def codes(done: Compiled) -> set[str]:
    return {finding.code for finding in done.findings}


@pytest.mark.parametrize("robot", [None, "rv-4frl"])
def test_joint_moves_of_a_table_get_it_and_lines_their_speed(
    tmp_path: Path, robot: str | None
) -> None:
    source = tmp_path / "way.csv"
    source.write_text(TABLE)
    (tmp_path / "way.process.toml").write_text("joint_percent = 17\n")
    done = compile(source, language="melfa-basic-5", robot=robot)
    said = lines(done)
    assert [line for line in said if line.startswith("JOvrd")] == ["JOvrd 17"]
    assert [line for line in said if line.startswith("Spd")] == ["Spd 60"]
    assert "CO511" in codes(done) and not {"MB204", "CO508"} & codes(done)
    rapid = compile(source, language="rapid", robot="irb1200-7-0.7")
    assert "CO511" not in codes(rapid)
    assert b"v100,fine" in next(iter(rapid.files.values()))


def test_joint_moves_of_a_program_get_it_also_where_its_speeds_have_names(tmp_path: Path) -> None:
    source, process = tmp_path / "part.mod", tmp_path / "cell.toml"
    source.write_text(MODULE)
    process.write_text("joint_percent = 12\n")
    done = translate(source, to="melfa-basic-5", process=process).compiled
    assert [line for line in lines(done) if line.startswith("JOvrd")] == ["JOvrd 12"]
    assert [line for line in lines(done) if line.startswith("Spd")] == ["Spd 80"]
    assert not {"MB204", "CO009"} & codes(done)


@pytest.mark.parametrize("value", ["0", "101", '"fast"'])
def test_what_is_no_percentage_is_told_of(tmp_path: Path, value: str) -> None:
    from assistant.compiler import check_files

    source = tmp_path / "way.csv"
    source.write_text(TABLE)
    (tmp_path / "way.process.toml").write_text(f"joint_percent = {value}\n")
    assert [finding.code for finding in check_files([source]).findings] == ["CT303"]


@pytest.mark.parametrize("beside", [None, 33])
def test_joint_moves_of_taught_targets_get_that_of_their_own_file(
    tmp_path: Path, beside: int | None
) -> None:
    source = tmp_path / "taught.toml"
    source.write_text(
        'joint_percent = 14\n[[targets]]\nname = "home"\nposition = [300, 0, 400]\n'
        "quaternion = [0, 0, 1, 0]\n"
    )
    if beside is not None:
        (tmp_path / "taught.process.toml").write_text(f"joint_percent = {beside}\n")
    done = compile(source, language="melfa-basic-5")
    assert [line for line in lines(done) if line.startswith("JOvrd")] == ["JOvrd 14"]
    assert "MB204" not in codes(done)
