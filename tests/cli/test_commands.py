"""The commands as people and pipelines use them: answers, exit statuses, nothing half done."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from assistant import __version__
from assistant.cli import main
from assistant.program import pseudo
from assistant.virtual.cr import VirtualCr
from assistant.virtual.irc5 import VirtualIrc5

SAMPLES = Path(__file__).parents[2] / "samples"
POSITIONING = str(SAMPLES / "positioning.csv")
IRB = ("--language", "rapid", "--robot", "irb1200-7-0.7")


def run(capsys, *arguments: object) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of a command."""
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    said = capsys.readouterr()
    assert "Traceback" not in said.err + said.out
    assert "CL900" not in said.err
    return int(ended.value.code or 0), said.out, said.err


@pytest.mark.parametrize(
    ("command", "words"),
    [("follow", "[exchange|data-link|mxt|egm]"), ("servo", "[jog|data-link|mxt|egm|exchange]")],
)
def test_the_help_lists_the_ways_to_lead_an_arm(capsys, command, words):
    status, out, _ = run(capsys, command, "--help")
    assert status == 0 and f"--by {words}" in out


def test_version_and_help(capsys):
    assert run(capsys, "--version")[1] == f"robot-assistant {__version__}\n"
    status, out, _ = run(capsys, "--help")
    assert status == 0
    for command in ("compile", "show", "check", "deploy", "virtual", "demo"):
        assert f"\n  {command} " in out


def test_wrong_usage_is_exit_status_2(capsys):
    for arguments in (["compile"], ["nonsense"], ["compile", "x", "--frob"], []):
        assert run(capsys, *arguments)[0] == 2, arguments


def test_wrong_usage_is_a_finding_with_a_cure(capsys):
    for arguments, cure in (
        (["compil", "x"], "did you mean `compile`?"),
        (["compile", "x", "--langage", "rapid"], "did you mean `--language`"),
        (["translate", "x.mod"], "add `--to` ("),
        (["robots", "irb120"], "write one of calibrate, poses, show"),
        (["simulate", "x", "--period", "abc"], "`robot-assistant simulate --help`"),
        (["run", "x", "--until"], "`robot-assistant run --help`"),
    ):
        status, out, err = run(capsys, *arguments)
        assert (status, out) == (2, "") and "CL902 error robot-assistant" in err, arguments
        assert cure in err, arguments
    status, out, _ = run(capsys, "check", "--format", "json", "--nope")
    assert status == 2 and json.loads(out)["findings"][0]["code"] == "CL902"
    # A group without a command shows its help, which is no finding.
    _, out, err = run(capsys, "camera")
    assert "Usage: " in out + err and "CL902" not in out + err


def test_a_file_that_is_missing_is_answered_by_the_one_that_is_meant(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plate.dxf").write_text("x", encoding="utf-8")
    assert "did you mean `plate.dxf`?" in run(capsys, "info", "plat.dxf")[2]
    assert "CONTROLLER FILES" in run(capsys, "put", "plate.dxf", "ftp://127.0.0.1:1")[2]
    assert "did you mean `in`?" in run(capsys, "info", "plate.dxf", "--unit", "inches")[2]


BASH = """eval "$(robot-assistant --show-completion bash)"
for typed in transl "check --form" "compile --frames pro" "compile a.dxf -l melfa-" "robots sh"; do
  COMP_WORDS=(robot-assistant $typed); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMPREPLY=()
  _robot_assistant_completion robot-assistant
  echo "$typed:" "${COMPREPLY[@]}"
done
"""


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_completes_commands_options_and_values():
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-c", BASH], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == [
        "transl: translate",
        "check --form: --format",
        "compile --frames pro: product",
        "compile a.dxf -l melfa-: melfa-basic-4 melfa-basic-5 melfa-basic-6",
        "robots sh: show",
    ]


def test_power_shell_is_answered_by_lines_of_a_word_and_its_help():
    words = {"COMP_WORDS": "robot-assistant comp", "COMP_WORD": "comp"}
    asked = {**os.environ, **words, "_ROBOT_ASSISTANT_COMPLETE": "powershell_complete"}
    command = [sys.executable, "-c", "from assistant.cli import main; main()"]
    done = subprocess.run(command, env=asked, capture_output=True, text=True, check=True)
    assert [line.split("\t")[0] for line in done.stdout.splitlines()] == ["compile", "compare"]
    assert all(line.split("\t")[1] for line in done.stdout.splitlines())


def test_compile_prints_the_proof_and_what_it_wrote(capsys, tmp_path):
    status, out, _ = run(capsys, "compile", POSITIONING, *IRB, "-o", tmp_path)
    assert status == 0
    assert "proven: 38 statements and 36 targets read back, largest deviation 0.0000" in out
    assert f"wrote {tmp_path / 'positioning.mod'}" in out
    assert sorted(os.listdir(tmp_path)) == [".robot-assistant", "positioning.mod"]


def test_compile_answers_in_json(capsys, tmp_path):
    status, out, _ = run(capsys, "compile", POSITIONING, *IRB, "-o", tmp_path, "--format", "json")
    answer = json.loads(out)
    assert (status, answer["ok"]) == (0, True)
    assert answer["sources"][0]["proof"]["holds"] is True
    assert answer["sources"][0]["proof"]["targets"] == 36
    assert answer["written"] == [str(tmp_path / "positioning.mod")]


def test_findings_in_json_name_code_and_place(capsys, tmp_path):
    arguments = ("--language", "melfa-basic-4", "--robot", "rv-2aj", "-o", tmp_path)
    source = SAMPLES / "taught.toml"
    status, out, _ = run(capsys, "compile", source, *arguments, "--format", "json")
    answer = json.loads(out)
    assert (status, answer["ok"], answer["written"]) == (1, False, [])
    errors = [f for f in answer["findings"] if f["severity"] == "error"]
    assert {f["code"] for f in errors} == {"CO502", "RB102"}
    assert all(f["cure"] and f["path"] == str(source) for f in errors)
    assert os.listdir(tmp_path) == []


def test_a_single_file_goes_to_standard_output(tmp_path):
    command = [sys.executable, "-m", "assistant", "compile", POSITIONING, *IRB, "-o", "-"]
    done = subprocess.run(command, capture_output=True, check=True, cwd=tmp_path)
    assert done.stdout.startswith(b"MODULE positioning\r\n")
    assert os.listdir(tmp_path) == []


def test_show_can_be_piped_into_compile(capsys, monkeypatch, tmp_path):
    plain = tmp_path / "plain.process.toml"
    style = '[style]\nprocedures = "none"\nconstants = false\n'
    tools = (SAMPLES / "positioning.process.toml").read_text("utf-8")
    plain.write_text(style + tools, encoding="utf-8")
    status, text, _ = run(capsys, "show", POSITIONING)
    assert status == 0
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    status, out, _ = run(capsys, "compile", "-", *IRB, "-o", "-")
    assert (status, out) == run(capsys, "compile", POSITIONING, "-p", plain, *IRB, "-o", "-")[:2]
    assert (status, out[:18]) == (0, "MODULE positioning")


def test_show_writes_long_paths_into_tables_beside(capsys, tmp_path):
    rows = "\n".join(f"{300 + i / 10:.1f},0,300,0,1,0,0" for i in range(1500))
    source = tmp_path / "scan.csv"
    source.write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n" + rows, encoding="utf-8")
    status, _, _ = run(capsys, "show", source, "-o", tmp_path / "out" / "scan.pseudo")
    assert status == 0
    assert len((tmp_path / "out" / "scan.pseudo").read_text("utf-8")) < 1000
    back = pseudo.read(tmp_path / "out" / "scan.pseudo")
    assert len(next(back.statements()).path) == 1500


def test_two_sources_of_one_name_have_a_folder_each(capsys, tmp_path):
    (tmp_path / "a").mkdir()
    other = tmp_path / "a" / "Positioning.csv"
    other.write_bytes(Path(POSITIONING).read_bytes())
    (tmp_path / "a" / "Positioning.process.toml").write_bytes(
        (SAMPLES / "positioning.process.toml").read_bytes()
    )
    status, _, err = run(capsys, "compile", POSITIONING, other, *IRB, "-o", tmp_path / "out")
    assert status == 0
    assert "CL001" in err
    written = sorted(path.name for path in (tmp_path / "out").rglob("*.mod"))
    assert written == ["Positioning.mod", "positioning.mod"]
    assert len({path.parent for path in (tmp_path / "out").rglob("*.mod")}) == 2


def test_one_source_that_fails_keeps_no_other_from_being_compiled(capsys, tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text("x_mm,y_mm\n1,2\n", encoding="utf-8")
    status, _, err = run(capsys, "compile", bad, POSITIONING, *IRB, "-o", tmp_path / "out")
    assert status == 1
    assert str(bad) in err
    assert [path.name for path in (tmp_path / "out").glob("*.mod")] == ["positioning.mod"]


def test_check_is_clean_or_says_what_is_wrong(capsys, tmp_path):
    status, out, _ = run(capsys, "check", POSITIONING, "--robot", "irb1200-7-0.7")
    assert (status, out) == (0, "1 checked, 0 findings\n")
    broken = tmp_path / "broken.mod"
    broken.write_text(
        "MODULE broken\n  PROC main()\n    MoveL p1, v25, fine tool0;\n  ENDPROC\nENDMODULE\n",
        encoding="ascii",
    )
    status, _, err = run(capsys, "check", broken)
    assert status == 1
    assert f"{broken}:3:" in err
    assert "^" in err
    status, out, _ = run(capsys, "check", broken, "--format", "json")
    assert (status, json.loads(out)["findings"][0]["line"]) == (1, 3)


BAD = {
    "missing.csv": (None, 2, "IN001"),
    "empty.csv": (b"", 2, "IN005"),
    "empty.dxf": (b"", 2, "IN005"),
    "picture.dxf": (b"\x89PNG\r\n\x1a\n", 2, "DX"),
    "comma.csv": (b"x_mm;y_mm;z_mm;q_w;q_x;q_y;q_z\n1,5;2;3;1;0;0;0\n", 1, "TB"),
    "nan.csv": (b"x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\nnan,2,3,1,0,0,0\n", 1, "TB"),
    "columns.csv": (b"x_mm,y_mm,q_w,q_x,q_y,q_z\n1,2,1,0,0,0\n", 1, "TB104"),
    "long.csv": (b"x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n1,2,3,1,0.5,0,0\n", 1, "TB"),
    "unknown.xyz": (b"anything", 2, "SR001"),
    "odd.pseudo": (b"program p\nprocedure main\n  move sideways p1\nend\n", 1, "PS"),
    "odd.mod": (b"MODULE m\nPROC main()\n", 1, "RA"),
    "tokens.mb5": (b"ROBPRG\x00\x01\x02", 2, "MB"),
    "bad.toml": (b"[[targets]\n", 2, "CT301"),
    "bad.json": (b"{", 2, "TB421"),
    "bad.npy": (b"\x93NUMPY\x01\x00", 2, "TB"),
}


def test_bad_input_is_one_finding_and_an_exit_status(capsys, tmp_path):
    wrong = []
    for name, (content, expected, code) in BAD.items():
        source = tmp_path / name
        if content is not None:
            source.write_bytes(content)
        for command in ("compile", "show", "check"):
            options = [*IRB, "-o", tmp_path / "out"] if command == "compile" else []
            status, _, err = run(capsys, command, source, *options)
            right = status in ({expected} if command != "check" else {1, 2})
            if not right or code not in err or name not in err or (tmp_path / "out").exists():
                wrong.append((command, name, status, err))
    assert not wrong


def test_a_folder_is_no_source(capsys, tmp_path):
    folder = tmp_path / "folder.csv"
    folder.mkdir()
    status, _, err = run(capsys, "show", folder)
    assert (status, "IN002" in err) == (2, True)


def test_findings_do_not_steer_the_terminal(capsys, tmp_path):
    source = tmp_path / "x.csv"
    source.write_bytes(b"x_mm,\x1b[31mred\n1,2\n")
    _, _, err = run(capsys, "show", source)
    assert "\x1b" not in err


def test_deploy_shows_installs_and_finds_it_there(capsys, tmp_path, monkeypatch):
    run(capsys, "compile", POSITIONING, *IRB, "-o", tmp_path)
    program = tmp_path / "positioning.mod"
    with VirtualIrc5(tmp_path / "home") as controller:
        monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", controller.password)
        to = ("--to", controller.address, "--history", tmp_path / "kept")
        status, out, _ = run(capsys, "deploy", program, *to, "--dry-run")
        assert (status, "nothing has been changed" in out) == (0, True)
        assert not list((tmp_path / "home").iterdir())
        status, out, err = run(capsys, "deploy", program, *to)
        assert (status, "1 installed and verified" in out) == (0, True)
        assert controller.password not in out + err
        assert (tmp_path / "home" / "positioning.mod").read_bytes() == program.read_bytes()
        status, out, _ = run(capsys, "deploy", program, *to, "--format", "json")
        assert json.loads(out)["files"][0]["state"] == "same"


def test_deploy_to_a_cr_controller(capsys, tmp_path):
    arguments = ("--language", "melfa-basic-4", "--robot", "rv-2aj", "-o", tmp_path)
    run(capsys, "compile", POSITIONING, *arguments)
    with VirtualCr("rv-2aj") as controller:
        to = ("--to", controller.address, "--history", tmp_path / "kept")
        status, out, _ = run(capsys, "deploy", tmp_path / "POSITIONING.prg", *to)
        assert (status, "1 installed and verified" in out) == (0, True)
        assert controller.names()


def test_deploying_to_nobody_is_no_success(capsys, tmp_path, monkeypatch):
    run(capsys, "compile", POSITIONING, *IRB, "-o", tmp_path)
    with VirtualIrc5(tmp_path / "home") as controller:
        address = controller.address
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROBOT_ASSISTANT_PASSWORD", "x")
    status, out, err = run(capsys, "deploy", "positioning.mod", "--to", address)
    assert status in (1, 2) and "CN" in err
    assert "installed" not in out


PLAYED = re.compile(r"  played: 35 points passed within \S+ mm and \S+ degrees, by \d+ looks")


def demo(capsys, folder, *more):
    """Return what the demo prints, once its programs, plots and report are found right."""
    status, out, _ = run(capsys, "demo", "-o", folder, *more)
    assert status == 0
    assert len(PLAYED.findall(out)) == 2
    assert out.count("proven: ") == 4
    assert out.count("1 installed and verified") == 4
    for name in ("positioning.mod", "POSITIONING.prg", "plate.mod", "PLATE.prg"):
        assert (folder / name).stat().st_size > 1000
    for name in ("positioning.png", "plate.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")
    page = (folder / "report.html").read_text("utf-8")
    assert page.count("</script>") == 3 + 3
    assert re.search("Move[JL] positioning_2,v150,z100,GRIPPER", page) is not None
    assert 'src="http' not in page
    assert page.count('"1 installed and verified') == 4
    assert page.count('"played: 35 points passed') == 2
    assert '"name":"arm.J6"' in page.replace("robot.J6", "arm.J6")
    return out


@pytest.mark.slow
def test_the_demo_without_the_toolbox_tells_what_installs_it(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("assistant.cli.demo.TIME_FACTOR", 20.0)
    monkeypatch.setitem(sys.modules, "roboticstoolbox", None)
    out = demo(capsys, tmp_path)
    (line,) = [line for line in out.splitlines() if "roboticstoolbox" in line]
    assert "pip install" in line and "[toolbox]'" in line and "positioning.csv" in line


@pytest.mark.slow
def test_the_demo_computes_its_trajectory_with_the_toolbox(capsys, tmp_path):
    out = demo(capsys, tmp_path, "--unit", "m")
    assert re.search(r"^ctraj of roboticstoolbox .*: 35 poses between two SE3$", out, re.M)


REFUSED = (
    ["compile", "BROKEN", "-l", "rapid", "-o", "FOLDER"],
    ["translate", "BROKEN", "--to", "rapid", "-o", "FOLDER"],
    ["simulate", "FOLDER/nowhere.mod", "-r", "rv-4frl"],
    ["robots", "show", "nobody"],
)


def test_what_is_refused_is_told_in_the_form_that_was_asked_for(tmp_path: Path, capsys) -> None:
    broken = tmp_path / "broken.mod"
    broken.write_text("MODULE m\nPROC main(\nENDPROC\nENDMODULE\n")
    for command in REFUSED:
        said = [w.replace("BROKEN", str(broken)).replace("FOLDER", str(tmp_path)) for w in command]
        status, out, errors = run(capsys, *said, "--format", "json")
        answer = json.loads(out)
        assert status in (1, 2), command
        assert not answer["ok"], command
        assert [finding["severity"] for finding in answer["findings"]] == ["error"], command
        assert not errors, command
        if command[0] in ("compile", "translate"):
            _, out, errors = run(capsys, *said, "--format", "sarif")
            (found,) = json.loads(out)["runs"][0]["results"]
            assert found["ruleId"] == "RA103", command
            assert not errors, command
        status, out, errors = run(capsys, *said)
        assert status in (1, 2), command
        assert not out, command
        assert answer["findings"][0]["code"] in errors, command
