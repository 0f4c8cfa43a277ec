"""What `init` writes for a customer's drawing: it says what is blank, and works without blanks."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import ezdxf
import pytest

from assistant.base.diagnostics import Refused
from assistant.base.source_text import SourceText
from assistant.cli import main
from assistant.project import build, project_of
from assistant.project.builds import check
from assistant.project.new_project import (
    CHOICE_KEYS,
    LAYER_ROWS,
    REPOSITORY_FILES,
    TOP_ROWS,
    start_project,
)
from assistant.sources.process import file as process_layers
from assistant.sources.process.file import parse_process, read_process

PROCESS = "drawings/Teil (ä) 7.process.toml"


def draw(path: Path, units: int = 1, layer: str = "Default") -> Path:
    """In the manner of an export: inches, a layer `Default`, names with blanks and umlauts."""
    document = ezdxf.new("R2013", units=units)
    space = document.modelspace()
    for name in (layer, "Außen kontur", "OFF"):
        document.layers.add(name)
    document.layers.get("OFF").off()
    space.add_lwpolyline([(0, 0), (4, 0), (4, 2), (0, 2)], close=True, dxfattribs={"layer": layer})
    space.add_circle((2, 1), 0.5, dxfattribs={"layer": "Außen kontur"})
    space.add_line((0, 0), (9, 9), dxfattribs={"layer": "OFF"})
    space.add_text("part", dxfattribs={"layer": "NOTES"})
    path.parent.mkdir(parents=True, exist_ok=True)
    document.saveas(path)
    return path


@pytest.fixture
def drawing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return draw(tmp_path_factory.mktemp("mail") / "Teil (ä) 7.dxf")


def codes(text: str) -> set[str]:
    """What is found in a process file; a key may need another one beside it."""
    try:
        return {finding.code for finding in parse_process(SourceText(text, "x.toml")).findings}
    except Refused as refused:
        return {finding.code for finding in refused.findings}


def fill_in(file: Path) -> None:
    text = file.read_text("utf-8")
    text = text.replace("tip = []", "tip = [0, 0, 100]").replace(
        "position = []", "position = [350, -20, 200]"
    )
    file.write_text(text.replace("# mass =", "mass =").replace("# centre =", "centre ="), "utf-8")


def test_a_project_of_a_drawing_builds_once_its_blanks_are_filled_in(home, drawing: Path) -> None:
    started = start_project(home.folder, [drawing])
    written = {file.relative_to(home.folder).as_posix() for file in started.written}
    copied = "drawings/Teil (ä) 7.dxf"
    assert written == {
        copied,
        PROCESS,
        "assistant.toml",
        "assistant.schema.json",
        *REPOSITORY_FILES,
    }
    assert (home.folder / copied).read_bytes() == drawing.read_bytes()
    assert started.blank == (home.folder / PROCESS,)
    blank = check(project_of())
    assert [(f.code, f.message) for f in blank.findings] == [
        ("CT303", "`tip` has 0 entries"),
        ("CT303", "`position` has 0 entries"),
    ]
    assert not build(project_of(), jobs=1).ok
    fill_in(home.folder / PROCESS)
    assert not [f for f in check(project_of()).findings if f.severity == "error"]
    done = build(project_of(), jobs=1)
    assert done.ok
    assert list(project_of().programs) == ["Teil_ae_7"]
    (made,) = done.programs
    assert [file.name for file in made.files] == ["Teil_ae_7.mod"]


def test_the_process_file_says_what_the_drawing_has(home, drawing: Path) -> None:
    start_project(home.folder, [drawing])
    fill_in(home.folder / PROCESS)
    process = read_process(home.folder / PROCESS)
    assert (process.unit, process.leave_out) == ("in", ("OFF", "NOTES"))
    assert list(process.layers) == ["Default", "Außen kontur"]
    assert process.frames["work"].user.position == (350.0, -20.0, 200.0)
    text = (home.folder / PROCESS).read_text("utf-8")
    assert "from [0.0, 0.0, 0.0] to [101.6, 50.8, 0.0]" in text
    assert "contours: 1 closed, 304.8 mm in all; size 101.6 x 50.8 x 0.0 mm" in text


def test_every_key_of_a_layer_is_there_and_can_be_had_by_taking_the_mark_away(
    home, drawing: Path
) -> None:
    start_project(home.folder, [drawing])
    fill_in(home.folder / PROCESS)
    text = (home.folder / PROCESS).read_text("utf-8")
    text = re.sub(r"^# (?=\[signals|direction = \"|number|offset|depth)", "", text, flags=re.M)
    for choice, _ in CHOICE_KEYS:
        assert choice in text or choice.removeprefix("# ") in text
        taken = text.replace(choice, choice.removeprefix("# "))
        assert not codes(taken) & {"CT301", "CT302", "CT303", "CT304", "CT309"}, choice
    told = {row[0].removeprefix("# ").split(" = ")[0] for row in (*LAYER_ROWS, *CHOICE_KEYS)}
    assert told | {"tool", "frame"} == set(process_layers.LAYER_KEYS)


def test_what_stands_at_the_top_can_be_had_by_taking_the_mark_away(home, drawing: Path) -> None:
    start_project(home.folder, [drawing])
    fill_in(home.folder / PROCESS)
    text = (home.folder / PROCESS).read_text("utf-8")
    for choice, _ in TOP_ROWS:
        assert f"\n{choice} " in text.partition("[motion]")[0]
        text = text.replace(choice, choice.removeprefix("# "))
    process = tomllib.loads(text)
    assert {"home", "robot", "joint_percent"} <= set(process)
    assert not [code for code in codes(text) if code.startswith(("CT3", "CO5"))]


def test_a_unit_that_nobody_names_can_be_stated(home, tmp_path_factory) -> None:
    drawing = draw(tmp_path_factory.mktemp("mail") / "a.dxf", units=0)
    started = start_project(home.folder, [drawing], "in")
    assert started.findings == ()
    assert 'unit = "in"' in (home.folder / "drawings/a.process.toml").read_text("utf-8")


def test_a_unit_that_is_assumed_is_said(home, tmp_path_factory) -> None:
    drawing = draw(tmp_path_factory.mktemp("mail") / "a.dxf", units=0)
    started = start_project(home.folder, [drawing])
    assert [finding.code for finding in started.findings] == ["DX101"]
    text = (home.folder / "drawings/a.process.toml").read_text("utf-8")
    assert re.search(r'^unit = "mm" +# assumed, as the drawing names none', text, re.M)


def test_a_drawing_of_the_project_stays_where_it_is(home) -> None:
    draw(home.folder / "parts/a.dxf")
    start_project(home.folder, [home.folder / "parts/a.dxf"])
    assert (home.folder / "parts/a.process.toml").is_file()
    assert not (home.folder / "drawings").exists()
    project = tomllib.loads((home.folder / "assistant.toml").read_text("utf-8"))
    assert project["programs"] == {"a": {"source": "parts/a.dxf"}}
    assert project["targets"]["cell1"]["programs"] == ["a"]


def test_two_drawings_are_two_programs(home, tmp_path_factory) -> None:
    one, two = (draw(tmp_path_factory.mktemp("mail") / name) for name in ("a-b.dxf", "A b.dxf"))
    start_project(home.folder, [one, two])
    assert list(project_of().programs) == ["a_b", "A_b_2"]


def test_a_project_that_is_there_is_told_what_to_add(home, drawing: Path) -> None:
    start_project(home.folder)
    before = (home.folder / "assistant.toml").read_bytes()
    started = start_project(home.folder, [drawing])
    assert (home.folder / "assistant.toml").read_bytes() == before
    (finding,) = [f for f in started.findings if f.code == "PR302"]
    assert '[programs.Teil_ae_7] with source = "drawings/Teil (ä) 7.dxf"' in finding.cure
    home.put(
        "assistant.toml",
        before.decode() + '\n[programs.Teil_ae_7]\nsource = "drawings/Teil (ä) 7.dxf"\n',
    )
    assert "PR302" not in [f.code for f in start_project(home.folder, [drawing]).findings]


def test_what_somebody_filled_in_is_never_written_over(home, drawing: Path) -> None:
    start_project(home.folder, [drawing])
    fill_in(home.folder / PROCESS)
    filled = (home.folder / PROCESS).read_bytes()
    started = start_project(home.folder, [drawing])
    assert (started.written, started.blank) == ((), ())
    assert [finding.code for finding in started.findings] == ["PR301"]
    assert (home.folder / PROCESS).read_bytes() == filled


def test_another_drawing_of_that_name_is_refused_before_anything_is_written(
    home, drawing: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    start_project(home.folder, [drawing])
    other = draw(tmp_path_factory.mktemp("other") / drawing.name, layer="OTHER")
    before = sorted(file for file in home.folder.rglob("*"))
    with pytest.raises(Refused) as caught:
        start_project(home.folder, [other])
    assert [finding.code for finding in caught.value.findings] == ["PR303"]
    assert sorted(file for file in home.folder.rglob("*")) == before


def test_what_is_no_drawing_writes_nothing(home) -> None:
    home.put("a.dxf", "no drawing")
    with pytest.raises(Refused):
        start_project(home.folder / "cell", [home.folder / "a.dxf"])
    assert not (home.folder / "cell").exists()


@pytest.mark.parametrize(("words", "code"), [(("a", "b"), "CL051"), (("--unit", "in"), "CL052")])
def test_what_init_cannot_be_told(
    home, words: tuple[str, ...], code: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["init", *words])
    assert ended.value.code == 2
    assert code in capsys.readouterr().err
    assert list(home.folder.iterdir()) == []


def test_the_command_says_what_to_fill_in(
    home, drawing: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["init", str(drawing)])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert "fill in `tip` of [tools.tool] and `position` of [frames.work] in drawings/" in said
    assert 'the arm is assumed: if it is another, change robot = "' in said
    assert said.endswith("next, robot-assistant check, then build and deploy\n")
    # Another drawing comes to the robot that the project has by now.
    other = drawing.rename(drawing.with_name("other.dxf"))
    with pytest.raises(SystemExit):
        main(["init", str(other)])
    said = capsys.readouterr().out
    assert "fill in `tip`" in said and "assumed" not in said
