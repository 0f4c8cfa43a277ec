"""Tools whose turn is free, from their sources to what is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant.base.diagnostics import Refused
from assistant.checks import clearances
from assistant.compiler import Compiled, check_files
from assistant.compiler import compile as compiled
from assistant.program import pseudo
from assistant.program.statements import Follow
from assistant.sources.process.file import read_process

SAMPLES = Path(__file__).parent.parent.parent / "samples"

CELL = """\
[world]
margin = 2

[robots.arm]
robot = "irb1200-7-0.7"
tool = "holder"

[bodies.holder]
box = [80, 16, 12]
position = [20, 0, 30]

[bodies.nozzle]
cylinder = [8, 70]
position = [60, 0, 60]
parent = "arm.flange"

[bodies.{name}]
{shape}
"""


def written(folder: Path, text: str, **given: object) -> Compiled:
    file = folder / "seam.pseudo"
    file.write_text(text)
    return compiled(file, language="rapid", **given)  # type: ignore[arg-type]


def seam(x: str, free: bool = True) -> str:
    """A line along y at x, of 9 targets."""
    rows = "\n".join(
        f"    {'joint' if i == 0 else 'linear'} [{x}, {-120 + 30 * i}, 150] [0, 1, 0, 0]"
        + (" speed 50 mm/s blend 1 mm tool nozzle" if i == 0 else "")
        for i in range(9)
    )
    free_turn = " free turn" if free else ""
    return f"""\
program seam for irb1200-7-0.7

tool nozzle tip [60, 0, 100] mass 1 kg centre [0, 0, 50]{free_turn}

procedure main
  follow seam
{rows}
  end
end
"""


def codes(done: Compiled) -> list[str]:
    return [finding.code for finding in done.findings]


@pytest.fixture(scope="module")
def ring() -> Compiled:
    return compiled(SAMPLES / "ring.dxf", language="rapid")


def test_the_sample_is_only_reached_with_the_turns_that_are_chosen(
    ring: Compiled, tmp_path: Path
) -> None:
    assert ring.ok
    assert "RB119" in codes(ring)
    rigid = tmp_path / "rigid.process.toml"
    text = (SAMPLES / "ring.process.toml").read_text()
    rigid.write_text("\n".join(line for line in text.splitlines() if "free_turn" not in line))
    done = compiled(SAMPLES / "ring.dxf", language="rapid", process=rigid)
    assert "RB103" in codes(done)
    assert not done.files


def test_check_says_what_compile_does(ring: Compiled) -> None:
    found = check_files([str(SAMPLES / "ring.dxf")]).findings
    told = [f.message for f in found if f.code == "RB119"]
    assert told == [f.message for f in ring.findings if f.code == "RB119"]
    assert told


@pytest.mark.parametrize("language", ["rapid", "melfa-basic-6"])
def test_without_a_robot_the_turns_stay(language: str, tmp_path: Path) -> None:
    text = seam("420").replace(" for irb1200-7-0.7", "")
    file = tmp_path / "seam.pseudo"
    file.write_text(text)
    done = compiled(file, language=language)
    assert "RB124" in codes(done)
    (drawn,) = (s.path for s in pseudo.parse(text).statements() if isinstance(s, Follow))
    (path,) = (s.path for s in done.program.statements() if isinstance(s, Follow))
    assert (abs(path.quaternions - drawn.quaternions) < 1e-12).all()


def test_a_wall_beside_the_path_is_not_touched(tmp_path: Path) -> None:
    cell = tmp_path / "cell.toml"
    # As it was drawn, the flange stands behind the nozzle, where the wall is.
    wall = "box = [20, 400, 300]\nposition = [375, 0, 150]"
    cell.write_text(CELL.format(name="wall", shape=wall))
    rigid = written(tmp_path, seam("420", free=False), cell=cell)
    assert clearances.TOUCHES.code in codes(rigid)
    assert not rigid.files
    done = written(tmp_path, seam("420"), cell=cell)
    assert "RB119" in codes(done)
    assert not {clearances.TOUCHES.code, clearances.NEAR.code} & set(codes(done))
    assert done.ok


def test_where_no_turn_keeps_the_margin_nothing_is_touched(tmp_path: Path) -> None:
    cell = tmp_path / "cell.toml"
    wall = "box = [20, 400, 300]\nposition = [375, 0, 150]"
    cell.write_text(CELL.format(name="wall", shape=wall).replace("margin = 2", "margin = 60"))
    done = written(tmp_path, seam("420"), cell=cell)
    assert {"RB119", clearances.NEAR.code} <= set(codes(done))
    assert done.ok


def test_what_no_turn_keeps_clear_of_is_told(tmp_path: Path) -> None:
    cell = tmp_path / "cell.toml"
    cell.write_text(CELL.format(name="bar", shape="box = [600, 10, 10]\nposition = [420, 0, 155]"))
    done = written(tmp_path, seam("420"), cell=cell)
    assert "RB121" in codes(done)
    assert clearances.TOUCHES.code in codes(done)
    assert not done.files


def test_a_tool_that_follows_its_contours_is_not_free(tmp_path: Path) -> None:
    file = tmp_path / "seam.process.toml"
    file.write_text(
        "[tools.nozzle]\ntip = [0, 0, 100]\nfree_turn = true\n"
        '[layers.GLUE]\ntool = "Nozzle"\ntangential = true\n'
    )
    with pytest.raises(Refused) as refused:
        read_process(file)
    (finding,) = refused.value.findings
    assert (finding.code, finding.line) == ("CT322", 6)
