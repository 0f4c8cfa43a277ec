"""What a project states of a source need not stand on the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import ezdxf
import pytest

from assistant.cli import main

Run = Callable[..., tuple[int, str, str]]
ARM = 'address = "virtual:irc5"\nrobot = "irb1200-7-0.7"\n'
OTHER = 'address = "virtual:cr"\nrobot = "rv-4frl"\n'
ONE = f"""\
[controllers.left]
{ARM}
[programs.part]
source = "drawings/part.dxf"
process = "glue.toml"
unit = "mm"

[targets.left]
programs = ["part"]
"""
TWO = f"""\
{ONE}
[controllers.right]
{OTHER}
[targets.right]
programs = ["part"]
"""
GLUE = """\
[motion]
frame = "table"
[frames.table]
position = [380, 0, 300]
[layers.GLUE]
speed = 37
"""


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    (tmp_path / "drawings").mkdir()
    document = ezdxf.new(units=0)
    document.modelspace().add_line((0, 0), (40, 0), dxfattribs={"layer": "GLUE"})
    document.saveas(tmp_path / "drawings/part.dxf")
    (tmp_path / "glue.toml").write_text(GLUE)
    monkeypatch.chdir(tmp_path)

    def _run(*words: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            main(list(words))
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.out, said.err

    return _run


def put(text: str) -> None:
    Path("assistant.toml").write_text(text)


def test_compile_takes_language_robot_process_and_unit_of_the_project(run: Run) -> None:
    """It is the same program as with everything on the command line."""
    put(ONE)
    status, _, errors = run("compile", "drawings/part.dxf", "-o", "out")
    assert status == 0, errors
    text = Path("out/part.mod").read_text()
    assert "v37" in text or "37" in text
    assert "IRB 1200" in text or "irb1200-7-0.7" in text
    assert "DX101" not in errors  # the unit is stated
    Path("assistant.toml").unlink()
    words = ("-l", "rapid", "-r", "irb1200-7-0.7", "-p", "glue.toml", "--unit", "mm")
    assert run("compile", "drawings/part.dxf", "-o", "plain", *words)[0] == 0
    assert Path("out/part.mod").read_bytes() == Path("plain/part.mod").read_bytes()


def test_what_targets_differ_in_has_to_be_named(run: Run) -> None:
    put(TWO)
    status, _, errors = run("compile", "drawings/part.dxf", "-o", "out")
    assert status == 2
    assert "PR304" in errors
    assert "`part` for `left` (rapid, irb1200-7-0.7)" in errors
    assert "--language and --robot" in errors
    assert not Path("out").exists()
    assert run("compile", "drawings/part.dxf", "-o", "out", "-l", "RAPID")[0] == 0
    assert "37" in Path("out/part.mod").read_text()


def test_the_command_line_counts_where_it_says_something(run: Run) -> None:
    put(ONE)
    Path("fast.toml").write_text(GLUE.replace("37", "91"))
    words = ("-p", "fast.toml", "-l", "melfa-basic-6", "-r", "rv-4frl", "-o", "out")
    status, _, errors = run("compile", "drawings/part.dxf", *words)
    assert status == 0, errors
    (made,) = Path("out").glob("*.prg")
    assert "91" in made.read_text()


def test_other_commands_take_it_as_well(run: Run) -> None:
    """So `check` looks at what a robot reaches without naming it."""
    put(ONE)
    for command in ("check", "simulate", "show"):
        status, said, errors = run(command, "drawings/part.dxf")
        assert status == 0, (command, errors)
        assert "DX101" not in errors, command
        if command == "show":
            assert "table" in said and "37" in said
    Path("glue.toml").write_text(GLUE.replace("380", "3800"))
    status, said, _ = run("check", "drawings/part.dxf", "--format", "json")
    assert status == 1
    assert any(finding["code"].startswith("RB") for finding in json.loads(said)["findings"])


def test_nothing_says_the_language_or_the_project_is_wrong(run: Run) -> None:
    status, _, errors = run("compile", "drawings/part.dxf")
    assert (status, "CL053" in errors) == (2, True)
    put(ONE.replace("drawings/part.dxf", "glue.toml"))
    assert "CL053" in run("compile", "drawings/part.dxf")[2]
    put(ONE.replace('"irb1200-7-0.7"', '"nobody"'))
    status, _, errors = run("compile", "drawings/part.dxf")
    assert (status, "PR107" in errors) == (2, True)


def test_sources_of_one_command_are_for_one_robot(run: Run) -> None:
    Path("drawings/other.dxf").write_bytes(Path("drawings/part.dxf").read_bytes())
    more = '\n[programs.other]\nsource = "drawings/other.dxf"\n'
    one = ONE.replace("\n[targets.left]", f"{more}[targets.left]")
    put(f'{one}\n[controllers.right]\n{OTHER}[targets.right]\nprograms = ["other"]\n')
    status, _, errors = run("compile", "drawings/part.dxf", "drawings/other.dxf", "-o", "out")
    assert (status, "CL054" in errors) == (2, True)
    assert not Path("out").exists()
