"""What was taught on a controller comes home into the sources that its programs were made of."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from assistant.cli import main
from assistant.controllers import connect

SAMPLES = Path(__file__).parent.parent.parent / "samples"
MODULE = """\
MODULE seam
  ! approach, then the seam
  CONST robtarget p1 := [ [400, 0, 300], [0,0,1,0],
                          [0,0,0,0], [9E9,9E9,9E9,9E9,9E9,9E9] ];   ! above the clamp
  CONST robtarget p2 := [[400,50,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];

  PROC main()
    MoveJ p1, v100,  fine, tool0;   ! slow
    MoveL p2, v100, fine, tool0;
  ENDPROC
ENDMODULE
"""


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def git(folder, *arguments):
    who = ("-c", "user.name=n", "-c", "user.email=e@x")
    subprocess.run(["git", *who, *arguments], cwd=folder, check=True, capture_output=True)


@pytest.fixture
def repository(here):
    """The working folder, kept by git."""
    git(here, "init", "-q")
    return here


def commit(folder):
    git(folder, "add", "-A")
    git(folder, "commit", "-qm", "as it is")


def test_a_point_taught_in_memory_comes_home_in_the_layout_of_its_file(capsys, repository, rws):
    file = repository / "seam.mod"
    file.write_text(MODULE, newline="")
    commit(repository)
    deploy = ("deploy", "seam.mod", "--to", "cell1")
    assert run(capsys, *deploy, "--load")[0] == 0
    rws.teach("seam", "p1", "[[412.25,-3,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]")
    status, out, err = run(capsys, "plan", "seam.mod", "--to", "cell1")
    assert status == 1 and "conflict" in out and "412.25" in out
    assert run(capsys, *deploy)[0] == 1 and file.read_text() == MODULE
    status, out, err = run(capsys, *deploy, "--pull")
    assert status == 0 and "wrote seam.mod" in out, out + err
    assert file.read_text() == MODULE.replace("[400, 0, 300]", "[412.25, -3, 300]")
    status, out, err = run(capsys, *deploy)
    assert (status, "DP224" in err) == (0, True), out + err
    assert run(capsys, "verify", "--to", "cell1")[0] == 0


def test_what_is_there_already_is_recorded_and_not_what_is_taken_back(capsys, repository, irc5):
    file, there = repository / "seam.mod", irc5.folder / "seam.mod"
    file.write_text(MODULE, newline="")
    deploy = ("deploy", "seam.mod", "--to", "cell1")
    assert run(capsys, *deploy)[0] == 0
    there.write_text(MODULE.replace("400,50", "401,50"), newline="")
    commit(repository)
    assert run(capsys, *deploy, "--pull")[0] == 0 and "401,50" in file.read_text()
    assert run(capsys, "verify", "--to", "cell1")[0] == 1
    status, out, _ = run(capsys, *deploy)
    assert status == 0 and "0 installed and verified, 1 already there" in out
    assert run(capsys, "verify", "--to", "cell1")[0] == 0
    assert run(capsys, "rollback", "--to", "cell1")[0] != 0 and there.exists()
    assert run(capsys, "rollback", "--to", "cell1", "--replace", "seam.mod")[0] == 0
    assert not there.exists()


def test_a_change_here_and_one_there_are_both_kept(capsys, repository, irc5):
    file, there = repository / "seam.mod", irc5.folder / "seam.mod"
    file.write_text(MODULE, newline="")
    commit(repository)
    deploy = ("deploy", "seam.mod", "--to", "cell1")
    assert run(capsys, *deploy)[0] == 0
    there.write_text(MODULE.replace("400,50,300", "400,55.5,300"), newline="")
    file.write_text(MODULE.replace("slow", "slower"), newline="")
    status, _, err = run(capsys, *deploy, "--pull")
    assert status == 1 and "PR505" in err and "slower" in file.read_text()
    commit(repository)
    assert run(capsys, *deploy, "--pull")[0] == 0
    both = MODULE.replace("slow", "slower").replace("400,50,300", "400,55.5,300")
    assert file.read_text() == both
    status, _, err = run(capsys, *deploy, "--files-only")
    assert status == 0 and there.read_text() == both
    there.write_text(both.replace("55.5", "56"), newline="")
    file.write_text(both.replace("55.5", "57"), newline="")
    commit(repository)
    status, _, err = run(capsys, *deploy, "--pull")
    assert status == 1 and "PR501" in err and "57" in file.read_text()


def test_targets_go_into_the_file_that_they_were_taught_in(capsys, repository, rws):
    source = repository / "taught.toml"
    shutil.copy(SAMPLES / "taught.toml", source)
    (repository / "assistant.toml").write_text(
        f'[controllers.cell1]\naddress = "{rws.rws_address}"\nrobot = "irb1200-7-0.7"\n'
        '[programs.taught]\nsource = "taught.toml"\n'
        '[targets.cell1]\nprograms = ["taught"]\nload = true\n'
    )
    (repository / ".gitignore").write_text("build/\n.robot-assistant/\n")
    assert run(capsys, "build")[0] == 0
    commit(repository)
    assert run(capsys, "deploy")[0] == 0
    external = "[9E9,9E9,9E9,9E9,9E9,9E9]"
    rws.teach("taught", "down", f"[[420,-60,298.5],[0,1,0,0],[-1,0,1,0],{external}]")
    rws.teach("taught", "home", f"[[0,0,0,0,45,0],{external}]")
    assert run(capsys, "plan")[0] == 1
    before = source.read_text()
    status, out, _ = run(capsys, "deploy", "--pull", "--format", "json")
    answer = json.loads(out)
    assert status == 0 and answer["written"] == {"taught.toml": ["target `down`", "target `home`"]}
    expected = before.replace("position = [420, -60, 300]", "position = [420, -60, 298.5]")
    expected = expected.replace("[0, 0, 0, 0, 30, 0]", "[0, 0, 0, 0, 45, 0]")
    assert source.read_text() == expected
    assert run(capsys, "build")[0] == 0
    assert run(capsys, "deploy")[0] == 0 and run(capsys, "verify")[0] == 0


def test_a_cr_gives_its_positions_back_to_a_pseudo_program(capsys, here, cr):
    source = here / "t.pseudo"
    source.write_text(
        "program t for rv-2aj\n\n"
        "target  over [250, 0, 300] [0, 0, 1, 0]  # above the part\n"
        "target down [250, 0, 250] [0, 0, 1, 0]\n\n"
        "procedure main\n  move joint over speed 100 mm/s blend fine\n"
        "  move linear down speed 50 mm/s blend fine\nend\n"
    )
    assert run(capsys, "compile", source, "-l", "melfa-basic-4", "-r", "rv-2aj")[0] == 0
    assert run(capsys, "deploy", "T.prg", "--to", "cell1")[0] == 0
    with connect(cr.address) as client:
        text = client.read("T").decode()
        assert "+300.00" in text
        client.write("T", text.replace("+300.00", "+305.25").encode())
    pull = ("deploy", "T.prg", "--to", "cell1", "--pull", "--source", source)
    status, out, err = run(capsys, *pull)
    assert status == 0 and "PR510" in err, out + err
    assert "target over [250, 0, 305.25] [0, 0, 1, 0]  # above the part\n" in source.read_text()
    assert "300]" in (here / "t.pseudo.orig").read_text()
    assert run(capsys, "compile", source, "-l", "melfa-basic-4", "-r", "rv-2aj")[0] == 0
    assert run(capsys, "plan", "T.prg", "--to", "cell1")[0] == 0


def test_what_cannot_come_home_is_said_and_nothing_is_written(capsys, repository, irc5):
    source = repository / "plate.dxf"
    for name in ("plate.dxf", "plate.process.toml"):
        shutil.copy(SAMPLES / name, repository / name)
    taught = shutil.copy(SAMPLES / "taught.toml", repository / "taught.toml")
    for name in ("plate.dxf", "taught.toml"):
        assert run(capsys, "compile", name, "-l", "rapid", "-r", "irb1200-7-0.7")[0] == 0
    (repository / "gone.mod").write_text(MODULE.replace("seam", "gone"))
    commit(repository)
    to = ("--to", "cell1")
    assert run(capsys, "deploy", "plate.mod", "taught.mod", "gone.mod", *to)[0] == 0
    status, _, err = run(capsys, "deploy", "plate.mod", *to, "--pull")
    assert status == 0 and "PR509" in err
    declared = "CONST robtarget "
    for name, old, new, made_of, code in (
        ("taught.mod", "v50,", "v60,", taught, "PR502"),
        ("taught.mod", f"{declared}down", f"VAR num x;\r\n{declared}down", taught, "PR502"),
    ):
        there = irc5.folder / name
        text = there.read_bytes().decode()
        assert text.replace(old, new) != text
        there.write_bytes(text.replace(old, new).encode())
        status, _, err = run(capsys, "deploy", name, *to, "--pull", "--source", made_of)
        assert (status, code in err) == (1, True), err
        there.write_bytes(text.encode())
    Path(taught).write_text(Path(taught).read_text().replace("-60, 300", "-61, 300"))
    commit(repository)
    there = irc5.folder / "taught.mod"
    there.write_bytes(there.read_bytes().replace(b"down:=[[420", b"down:=[[421"))
    of_it = ("--source", taught)
    status, _, err = run(capsys, "deploy", "taught.mod", *to, "--pull", *of_it)
    assert status == 1 and "PR503" in err
    (irc5.folder / "gone.mod").write_text("MODULE gone\r\nPROC (\r\n")
    status, _, err = run(capsys, "deploy", "gone.mod", *to, "--pull")
    assert status == 1 and "PR508" in err
    assert subprocess.run(["git", "diff", "--exit-code"], cwd=repository).returncode == 0
    two = ("gone.mod", "plate.mod", "--source", source)
    status, _, err = run(capsys, "deploy", *two, *to, "--pull")
    assert status == 2 and "CL271" in err


@pytest.mark.slow
def test_a_touched_up_start_of_a_drawing_outlives_the_next_drawing(capsys, repository, rws):
    """From the pendant into what was built, and on as the source changes."""
    for name in ("plate.dxf", "plate.process.toml"):
        shutil.copy(SAMPLES / name, repository / name)
    (repository / "assistant.toml").write_text(
        f'[controllers.cell1]\naddress = "{rws.rws_address}"\nrobot = "irb1200-7-0.7"\n'
        '[programs.plate]\nsource = "plate.dxf"\n'
        '[targets.cell1]\nprograms = ["plate"]\nload = true\n'
    )
    (repository / ".gitignore").write_text("build/\n.robot-assistant/\n")
    assert run(capsys, "build")[0] == 0
    commit(repository)
    assert run(capsys, "deploy")[0] == 0
    external = "[9E9,9E9,9E9,9E9,9E9,9E9]"
    rws.teach("plate", "glue_1_start", f"[[250.4,-45.2,259.5],[0,1,0,0],[-1,0,1,0],{external}]")
    assert run(capsys, "deploy")[0] == 1
    status, out, err = run(capsys, "deploy", "--pull")
    assert status == 0 and "DP330" in err, out + err
    built = repository / "build" / "cell1" / "plate.mod"
    assert "glue_1_start:=[[250.4,-45.2,259.5]" in built.read_text()
    assert run(capsys, "deploy")[0] == 1  # it is not what was built
    process = repository / "plate.process.toml"
    process.write_text(process.read_text().replace("speed = 20", "speed = 30"))
    status, out, err = run(capsys, "build", "--format", "json")
    (program,) = json.loads(out)["programs"]
    assert status == 0 and program["state"] == "built"
    assert "250.4" in program["edits"]["build/cell1/plate.mod"]
    text = built.read_text()
    assert "glue_1_start:=[[250.4,-45.2,259.5]" in text and ",v30," in text
    assert run(capsys, "build")[1] == "cell1: plate unchanged\n"
    status, out, err = run(capsys, "deploy")
    assert status == 0, out + err
    assert run(capsys, "verify")[0] == 0
    process.write_text(process.read_text().replace("tip = [0, 0, 60]", "tip = [0, 0, 61]"))
    built.write_text(text.replace("[TRUE,[[0,0,60]", "[TRUE,[[0,0,62]"))
    status, out, err = run(capsys, "build")
    assert status == 1 and "CO332" in err and "[[0,0,62]" in built.read_text()
    assert run(capsys, "build", "--drop-edit", "none")[0] == 2
    assert run(capsys, "build", "--drop-edit", "gripper")[0] == 0
    assert "[TRUE,[[0,0,61]" in built.read_text() and "250.4" in built.read_text()
