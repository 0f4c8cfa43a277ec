"""Plans, deployments and what is looked at of them, as people and pipelines see it."""

import json

import pytest

from assistant.cli import main

MODULE = (
    "MODULE {0}\r\n"
    "  CONST robtarget p1:=[[400,0,{1}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\r\n"
    "  PROC {0}_go()   ! kept\r\n    MoveJ p1, v100, fine, tool0;\r\n  ENDPROC\r\nENDMODULE\r\n"
)


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def module(folder, name, z=300):
    file = folder / f"{name}.mod"
    file.write_text(MODULE.format(name, z), newline="")
    return file


def test_a_plan_tells_of_every_program(capsys, here, irc5):
    cell = irc5.folder
    for name in ("a", "old"):
        module(here, name)
    status, out, _ = run(capsys, "deploy", "a.mod", "old.mod", "--to", "cell1")
    assert (status, "2 installed and verified" in out) == (0, True)
    (here / "old.mod").unlink()
    module(here, "a", 310)
    module(here, "b")
    module(cell, "theirs")
    status, out, err = run(capsys, "plan", here, "--to", "cell1")
    assert status == 0 and "DP229" in err
    assert "a.mod: replace" in out and "b.mod: create" in out
    assert "+  CONST robtarget p1:=[[400,0,310]" in out
    assert "foreign: theirs.mod" in out and "left: old.mod" in out
    assert "nothing has been changed" in out
    module(cell, "a", 277)
    status, out, err = run(capsys, "plan", here, "--to", "cell1", "--format", "json")
    answer = json.loads(out)
    assert (status, answer["ok"], answer["foreign"], answer["left"]) == (
        *(1, False),
        *(["theirs.mod"], ["old.mod"]),
    )
    a, b = answer["files"]
    assert (a["change"], b["change"]) == ("conflict", "create")
    assert "-  CONST robtarget p1:=[[400,0,300]" in a["since"]
    assert "+  CONST robtarget p1:=[[400,0,277]" in a["since"]
    assert "-  CONST robtarget p1:=[[400,0,277]" in a["diff"]
    assert answer["last deployment"]["who"]
    status, out, err = run(capsys, "deploy", here, "--to", "cell1")
    assert status == 1 and "DP204" in err and "277" in (cell / "a.mod").read_text()
    assert not (cell / "b.mod").exists()
    status, _, err = run(
        capsys, "deploy", here, "--to", "cell1", "--replace", "a.mod", "--files-only"
    )
    assert status == 0 and "DP223" in err and "310" in (cell / "a.mod").read_text()


def test_a_comment_holds_whatever_a_program_says(capsys, here, irc5):
    nasty = "! `````` </details> ```diff\r\nENDMODULE"
    module(irc5.folder, "a").write_text(MODULE.format("a", 1).replace("ENDMODULE", nasty))
    module(here, "a")
    (irc5.folder / "x``y.mod").write_text("MODULE x\r\nENDMODULE\r\n")
    status, out, _ = run(
        capsys, "deploy", "a.mod", "--dry-run", "--to", "cell1", "--format", "markdown"
    )
    assert status == 1
    assert "| `a.mod` | **conflict** |" in out
    fence = next(line for line in out.splitlines() if line.endswith("`diff"))[:-4]
    assert len(fence) == 7 and out.splitlines().count(fence) == 1
    assert "``` x``y.mod ```" in out
    assert "<summary>a.mod: what would be sent</summary>" in out
    (here / "a.mod").write_text("MODULE a\r\nPROC (\r\nENDMODULE\r\n")
    status, out, err = run(capsys, "plan", "a.mod", "--to", "cell1", "--format", "markdown")
    assert status == 1 and out.startswith("### Refused") and "- error `" in out and err


def test_what_is_there_is_verified_listed_and_taken_back(capsys, here, irc5):
    status, out, err = run(capsys, "verify", "--to", "cell1")
    assert status == 1 and "DP214" in err
    for name in ("a", "b", "c"):
        module(here, name)
    run(capsys, "deploy", "a.mod", "b.mod", "c.mod", "--to", "cell1")
    assert run(capsys, "verify", "--to", "cell1")[0] == 0
    module(irc5.folder, "a", 299.5)
    (irc5.folder / "b.mod").unlink()
    module(irc5.folder, "theirs")
    status, out, _ = run(capsys, "verify", "--to", "cell1")
    assert status == 1
    assert "a.mod: changed" in out and "b.mod: gone" in out and "c.mod: as deployed" in out
    assert "+  CONST robtarget p1:=[[400,0,299.5]" in out and "theirs.mod: not ours" in out
    module(here, "c", 5)
    status, out, _ = run(capsys, "verify", "c.mod", "--to", "cell1", "--format", "json")
    seen = {one["name"]: one for one in json.loads(out)["programs"]}
    assert (seen["c.mod"]["seen"], seen["c.mod"]["as built"]) == ("as deployed", False)
    assert seen["a.mod"]["as built"] is None
    status, out, _ = run(capsys, "rollback", "--to", "cell1")
    assert status != 0 and (irc5.folder / "c.mod").exists()
    status, out, _ = run(capsys, "rollback", "1", "--to", "cell1", "--replace", "*")
    assert status == 0 and "a.mod: put back" in out and "installed" not in out
    assert [file.name for file in irc5.folder.glob("*.mod")] == ["theirs.mod"]
    status, out, _ = run(capsys, "deployments", "--format", "json")
    first, second = json.loads(out)["deployments"]
    assert (first["number"], first["result"], first["programs"]) == (
        *(1, "done"),
        ["a.mod", "b.mod", "c.mod"],
    )
    assert second["number"] == 2 and second["who"] and second["time"]
    status, out, _ = run(capsys, "deployments", "--to", "cell1")
    assert status == 0 and len(out.splitlines()) == 3 and "done" in out


def test_a_list_takes_its_modules_along(capsys, here, irc5):
    module(here, "a")
    (here / "job.pgf").write_text("<Program><Module>a.mod</Module></Program>")
    assert run(capsys, "deploy", "job.pgf", "--to", "cell1")[0] == 0
    assert {"a.mod", "job.pgf"} <= {file.name for file in irc5.folder.iterdir()}
    for named, code in (("../a.mod", "DP108"), ("b.mod", "DP109")):
        (here / "job.pgf").write_text(f"<Program><Module>{named}</Module></Program>")
        status, _, err = run(capsys, "plan", "job.pgf", "--to", "cell1")
        assert status == 1 and code in err


def test_wrong_usage(capsys, here, irc5):
    module(here, "a")
    (here / "empty").mkdir()
    for arguments, code in (
        (["plan", "a.mod"], "CL270"),
        (["plan", "a.mod", "--to", "cell1", "--target", "x"], "CL271"),
        (["deploy", "a.mod", "--resume", "--to", "cell1"], "CL271"),
        (["plan", "--to", "cell1"], "PR101"),
        (["plan", "empty", "--to", "cell1"], "DP107"),
    ):
        status, _, err = run(capsys, *arguments)
        assert (status, code in err) == (2, True), err


def test_the_robot_of_the_controller_has_to_reach_it(capsys, here, tmp_path, irc5):
    table = f'[controllers.cell1]\naddress = "{irc5.address}"\nrobot = "irb1200-7-0.7"\n'
    (tmp_path / "assistant.toml").write_text(table)
    module(here, "a", 3000)
    status, _, err = run(capsys, "deploy", "a.mod", "--to", "cell1")
    assert status == 1 and "a.mod" in err and not (irc5.folder / "a.mod").exists()


def test_a_target_of_a_project_is_deployed_as_it_was_built(capsys, here, tmp_path, cr):
    (tmp_path / "go.prg").write_text("10 OVRD 50\r\n20 DLY 2\r\n30 END\r\n", newline="")
    text = (tmp_path / "assistant.toml").read_text()
    text += '[targets.cell1]\nprograms = ["go.prg"]\n'
    (tmp_path / "assistant.toml").write_text(text)
    status, _, err = run(capsys, "plan")
    assert status == 1 and "PR202" in err
    assert run(capsys, "build")[0] == 0
    status, out, _ = run(capsys, "deploy")
    assert (status, "1 installed" in out, cr.names()) == (0, True, ("GO",))
    assert (tmp_path / ".robot-assistant" / "deployments").is_dir()
    assert run(capsys, "verify")[0] == 0
    status, _, err = run(capsys, "plan", "--target", "other")
    assert status == 2 and "CL272" in err and "`cell1`" in err
    assert run(capsys, "rollback", "--target", "cell1")[0] == 0 and cr.names() == ()
    text += '[controllers.cell2]\naddress = "virtual:irc5"\n'
    text += '[targets.cell2]\nprograms = ["a.mod"]\n'
    (tmp_path / "assistant.toml").write_text(text)
    module(tmp_path, "a")
    status, _, err = run(capsys, "rollback")
    assert status == 2 and "CL273" in err and "`cell2`" in err
    assert run(capsys, "plan", "--to", "cell2")[0] == 1, "not built"
