"""Programs in a cell: what `check`, `compile`, `translate` and `simulate` say of its bodies."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from assistant.base.diagnostics import Diagnostic, Refused, Severity
from assistant.cli import main
from assistant.compiler import check_files, compile, translate
from assistant.compiler.arms import open_cell

SAMPLES = Path(__file__).parents[2] / "samples"
DRAWING = SAMPLES / "plate.dxf"
CLEAR, TOUCHING = SAMPLES / "cell" / "stand.toml", SAMPLES / "cell" / "clamped.toml"

ACROSS = """
program across
target a [400, -100, 400] [0, 0, 1, 0]
target b [400, 100, 400] [0, 0, 1, 0]
procedure main
  move joint a speed 200 mm/s blend fine
  move linear b speed 100 mm/s blend fine
end
"""
MODULE = """MODULE across
CONST robtarget a:=[[400,-100,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
CONST robtarget b:=[[400,100,400],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
MoveJ a,v200,fine,tool0;
MoveL b,v100,fine,tool0;
ENDPROC
ENDMODULE
"""
POST = """
[robots.arm]
robot = "irb1200-7-0.7"
tool = "needle"
[bodies.needle]
cylinder = [1, 80]
position = [0, 0, 40]
[bodies.plate]
box = [30, 0.2, 30]
position = [400, 20.1, 330]
"""
"""A plate 0.2 mm thick, which a needle of 1 mm goes through."""


def codes(findings: tuple[Diagnostic, ...] | list[Diagnostic], family: str = "CK42") -> list[str]:
    return [finding.code for finding in findings if finding.code.startswith(family)]


def status(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert isinstance(ended.value.code, int)
    return ended.value.code


@pytest.fixture
def across(tmp_path: Path) -> Path:
    return written(tmp_path / "across.pseudo", ACROSS)


def written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_a_drawing_is_clear_in_its_cell_and_not_with_a_clamp() -> None:
    assert codes(check_files([DRAWING], cell=CLEAR).findings) == []
    found = check_files([DRAWING], cell=TOUCHING).findings
    assert "CK421" in codes(found)
    assert all("`clamp`" in finding.message for finding in found if finding.code == "CK421")


def test_nothing_is_written_that_touches(across: Path, tmp_path: Path) -> None:
    clear = written(tmp_path / "clear.toml", POST.replace("330", "230"))
    assert compile(across, language="rapid", cell=clear).ok
    made = compile(across, language="rapid", cell=written(tmp_path / "post.toml", POST))
    assert not made.files
    (finding,) = [f for f in made.findings if f.code == "CK421"]
    assert finding.severity is Severity.ERROR
    assert (finding.line, "needle" in finding.message) == (7, True)


def test_the_time_of_contact_is_where_the_needle_gets_to_the_plate(
    across: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = written(tmp_path / "post.toml", POST)
    arguments = ["simulate", str(across), "--cell", str(cell), "--format", "json"]
    assert status(arguments) == 1
    answer = json.loads(capsys.readouterr().out)
    (finding,) = [f for f in answer["findings"] if f["code"] == "CK421"]
    told = re.search(r"after ([\d.]+) s of `main`, at \(400\.\d, (-?[\d.]+), ", finding["message"])
    assert told is not None
    # the edge of the needle is 119 mm along the line at 100 mm/s; told are hundredths
    (before,) = (move["seconds"] for move in answer["moves"] if move["kind"] == "joint")
    assert abs(float(told[1]) - (before + 1.19)) < 0.007
    assert finding["line"] == 7


def test_what_is_simulated_says_what_it_touches_beside_its_times(
    across: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = written(tmp_path / "post.toml", POST)
    assert status(["simulate", str(across), "--cell", str(cell)]) == 1
    said = capsys.readouterr()
    assert "CK421" in said.err
    assert "slowest moves" in said.out


def test_a_translation_is_in_the_cell_of_its_values(tmp_path: Path) -> None:
    program = written(tmp_path / "across.mod", MODULE)
    given = {"to": "melfa-basic-5", "robot": "irb1200-7-0.7"}
    alone = translate(program, cell=tmp_path / "none.toml", **given)  # type: ignore[arg-type]
    cell = written(tmp_path / "post.toml", POST.replace("plate]\nbox", "wall]\nbox"))
    wall = written(tmp_path / "wall.toml", cell.read_text().replace("[30, 0.2, 30]", "[9, 9, 900]"))
    stands = translate(program, cell=wall, **given)  # type: ignore[arg-type]
    assert codes(alone.findings) == []
    assert set(codes(stands.findings)) >= {"CK421"}
    assert not stands.files


TWO = """
[robots.left]
robot = "irb1200-7-0.7"
[robots.right]
robot = "irb1200-7-0.7"
position = [0, 1500, 0]
[bodies.post]
box = [60, 60, 500]
position = [400, 1500, 250]
"""


def test_of_two_robots_one_is_named(across: Path, tmp_path: Path) -> None:
    cell = written(tmp_path / "two.toml", TWO)
    assert codes(check_files([across], cell=cell).findings, "CO07") == ["CO075"]
    assert codes(check_files([across], cell=cell, robot="irb1200-7-0.7").findings) == ["CK425"]
    large = written(tmp_path / "large.toml", POST.replace("irb1200-7-0.7", "irb1600-10-1.45"))
    assert codes(check_files([across], cell=large, robot="irb1200-7-0.7").findings) == ["CK423"]
    assert codes(check_files([across], cell=cell, robot="left").findings) == []
    assert "CK421" in codes(check_files([across], cell=cell, robot="right").findings)


def test_the_only_robot_of_a_cell_runs_what_names_none(across: Path, tmp_path: Path) -> None:
    made = compile(
        across, language="rapid", cell=written(tmp_path / "c.toml", POST.split("tool")[0])
    )
    assert made.program.robot == "irb1200-7-0.7"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("[tools.drill]\ntip = [0, 0, 1]\n", "CO076"),
        ('[bodies.a]\nsphere = 1\nparent = "nowhere"\n', "CK401"),
        ("[bodies.a]\nsphere = 0\n", "CT303"),
        ("[bodies.a\n", "CT301"),
    ],
)
def test_a_cell_file_that_is_wrong_is_told_at_its_place(
    across: Path, tmp_path: Path, text: str, code: str, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = written(tmp_path / "wrong.toml", text)
    try:
        found: tuple[Diagnostic, ...] = open_cell(cell).findings
    except Refused as refused:
        found = refused.findings
    assert [(finding.code, finding.path) for finding in found] == [(code, str(cell))]
    assert status(["check", str(across), "--cell", str(cell)]) in (1, 2)
    assert code in capsys.readouterr().err


def test_a_cell_that_is_not_there_is_refused(across: Path, tmp_path: Path) -> None:
    with pytest.raises(Refused) as refused:
        compile(across, language="rapid", cell=tmp_path / "none.toml")
    assert refused.value.exit_status == 2


def test_without_the_library_the_extra_is_named(
    across: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "coal", None)
    with pytest.raises(Refused) as refused:
        check_files([across], cell=written(tmp_path / "post.toml", POST))
    (finding,) = refused.value.findings
    assert (finding.code, "[cell]" in (finding.cure or "")) == ("CK400", True)


@pytest.mark.parametrize(("length", "told"), [(80, []), (129, []), (200, ["CK427"])])
def test_a_tool_without_a_body_is_told_of(tmp_path: Path, length: float, told: list[str]) -> None:
    """The needle ends at 80 mm; what a program's tool has beyond it is not looked at."""
    tool = f"tool gun tip [0, 0, {length}] [1, 0, 0, 0]\ntarget a"
    program = ACROSS.replace("target a", tool, 1).replace("fine", "fine tool gun")
    file = written(tmp_path / "gun.pseudo", program)
    cell = written(tmp_path / "post.toml", POST.replace("20.1, 330", "900, 330"))
    assert codes(check_files([file], cell=cell).findings) == told
