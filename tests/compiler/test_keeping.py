"""What was edited in a written program stays when its source is compiled again, or that ends."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import ezdxf
import pytest

from assistant.cli import main

SAMPLES = Path(__file__).parent.parent.parent / "samples"
PROCESS = """\
[layers.SEAM]
speed = 50
approach = 40
retract = 40
"""
BEADS = {
    "a": ((400, -100), (450, -100)),
    "b": ((460, -60), (400, -60)),
    "c": ((400, -20), (450, -20)),
}
"""Beads that are worked in this order, each from its first point."""
RAPID = ("-l", "rapid", "-r", "irb1200-7-0.7")
MELFA = ("-l", "melfa-basic-5", "-r", "rv-4frl")


def draw(folder, beads, **others):
    """A drawing of straight beads, of circles and of named points."""
    drawing = ezdxf.new("R2010", units=4)
    space = drawing.modelspace()
    for first, last in beads.values():
        space.add_line((*first, 300), (*last, 300), dxfattribs={"layer": "SEAM"})
    for name, at in others.items():
        block = drawing.blocks.new(name=f"B{name}") if f"B{name}" not in drawing.blocks else None
        insert = space.add_blockref(f"B{name}", (*at, 330))
        insert.add_attrib("NAME", name)
        del block
    drawing.saveas(folder / "part.dxf")
    (folder / "part.process.toml").write_text(PROCESS)


def run(capsys, *arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def compiled(capsys, here, *more, language=RAPID):
    given = (here / "part.dxf", *language, "--place", "0,0,0", "-o", here / "out", *more)
    return run(capsys, "compile", *given)


def module(here):
    return here / "out" / "part.mod"


def positions(text):
    """The positions that the text of a module declares, by their names."""
    found = re.findall(r"robtarget (\w+):=\[\[([^\]]*)\]", text)
    return {name: tuple(map(float, numbers.split(","))) for name, numbers in found}


def edit(path, old, new, count=1):
    text = path.read_bytes().decode()
    assert text.count(old) == count, (old, text)
    path.write_bytes(text.replace(old, new).encode())
    return text


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The drawing of the beads with what was written of it, which each test has a copy of."""
    folder = tmp_path_factory.mktemp("first")
    draw(folder, BEADS)
    given = ("compile", folder / "part.dxf", *RAPID, "--place", "0,0,0", "-o", folder / "out")
    with pytest.raises(SystemExit) as ended:
        main([str(argument) for argument in given])
    assert ended.value.code == 0
    return folder


@pytest.fixture
def here(tmp_path, first):
    shutil.copytree(first, tmp_path, dirs_exist_ok=True)
    return tmp_path


def test_an_untouched_program_is_written_anew_without_a_word(here, capsys):
    draw(here, {**BEADS, "c": ((400, -20), (470, -20))})
    status, out, err = compiled(capsys, here)
    assert status == 0 and "CO33" not in err and "---" not in out
    assert positions(module(here).read_text())["seam_3_end"] == (470, -20, 300)


def test_a_touched_up_start_stays_as_its_bead_gets_another_end(here, capsys):
    edit(module(here), "seam_1_start:=[[400,-100,300]", "seam_1_start:=[[400.5,-101,299]")
    draw(here, {**BEADS, "a": ((400, -100), (455, -100))})
    status, out, err = compiled(capsys, here)
    assert status == 0, err
    found = positions(module(here).read_text())
    assert found["seam_1_start"] == (400.5, -101, 299) and found["seam_1_end"] == (455, -100, 300)
    assert "CO330" in err and "target `seam_1_start`" in err
    assert "+    CONST robtarget seam_1_start:=[[400.5,-101,299]" in out
    again = module(here).read_bytes()
    assert compiled(capsys, here)[0] == 0 and module(here).read_bytes() == again


def test_a_touch_up_follows_its_bead_when_that_gets_another_number(here, capsys):
    edit(module(here), "seam_2_start:=[[460,-60,300]", "seam_2_start:=[[460.5,-60,300]")
    draw(here, {"new": ((440, -140), (400, -120)), **BEADS})
    status, _, err = compiled(capsys, here)
    assert status == 0 and "`seam_2_start`, which is `seam_3_start` now" in err, err
    found = positions(module(here).read_text())
    assert found["seam_3_start"] == (460.5, -60, 300)
    assert found["seam_2_start"] == (400, -100, 300)


def test_another_bead_of_the_number_never_gets_a_touch_up(here, capsys):
    before = edit(module(here), "seam_2_start:=[[460,-60,300]", "seam_2_start:=[[461,-60,300]")
    edited = module(here).read_bytes()
    draw(here, {"a": BEADS["a"], "c": BEADS["c"]})
    status, _, err = compiled(capsys, here)
    assert status == 1 and "CO333" in err and "--keep-edit" not in err
    assert module(here).read_bytes() == edited
    assert compiled(capsys, here, "--keep-edit", "seam_2_start")[0] == 1
    assert module(here).read_bytes() == edited
    status, _, err = compiled(capsys, here, "--drop-edit", "seam_2_start")
    assert status == 0 and "CO338" in err
    assert "461" not in module(here).read_text() and module(here).read_text() != before


def test_a_point_that_both_have_moved_is_refused_until_somebody_decides(here, capsys):
    edit(module(here), "seam_1_start:=[[400,-100,300]", "seam_1_start:=[[400,-102,300]")
    edited = module(here).read_bytes()
    draw(here, {**BEADS, "a": ((395, -100), (450, -100))})
    status, _, err = compiled(capsys, here)
    assert (
        status == 1 and "CO332" in err and "[400, -102, 300]" in err and "[395, -100, 300]" in err
    )
    assert module(here).read_bytes() == edited
    shutil.copytree(here, here / "other")
    assert compiled(capsys, here, "--keep-edit", "seam_1_start")[0] == 0
    assert positions(module(here).read_text())["seam_1_start"] == (400, -102, 300)
    assert compiled(capsys, here)[0] == 0
    assert positions(module(here).read_text())["seam_1_start"] == (400, -102, 300)
    other = here / "other"
    assert compiled(capsys, other, "--drop-edit", "seam_1_start")[0] == 0
    assert positions(module(other).read_text())["seam_1_start"] == (395, -100, 300)


def test_named_points_are_known_by_their_names(here, capsys):
    draw(here, BEADS, pick=(420, 60), place=(420, 100))
    assert compiled(capsys, here)[0] == 0
    edit(module(here), "pick:=[[420,60,330]", "pick:=[[420,60,329]")
    draw(here, BEADS, place=(425, 100), pick=(420, 60))
    assert compiled(capsys, here)[0] == 0
    found = positions(module(here).read_text())
    assert (found["pick"], found["place"]) == ((420, 60, 329), (425, 100, 330))


def test_speeds_and_waits_stay_with_their_bead(here, capsys):
    text = module(here).read_bytes().decode()
    slow = text.replace("MoveL seam_2_end,v50", "WaitTime 0.3;\r\n        MoveL seam_2_end,v30")
    assert slow != text
    module(here).write_bytes(slow.encode())
    draw(here, {"new": ((440, -140), (400, -120)), **BEADS})
    status, _, err = compiled(capsys, here)
    assert status == 0, err
    words = re.sub(r"\s+", " ", module(here).read_text())
    assert "WaitTime 0.3; MoveL seam_3_end,v30," in words
    assert words.count("v30,") == 1 and words.count("WaitTime") == 1


def test_edits_of_a_bead_that_was_drawn_anew_are_refused(here, capsys):
    edit(module(here), "MoveL seam_2_end,v50", "MoveL seam_2_end,v30")
    edited = module(here).read_bytes()
    draw(here, {**BEADS, "b": ((460, -60), (390, -60))})
    status, _, err = compiled(capsys, here)
    assert status == 1 and "CO334" in err and module(here).read_bytes() == edited
    assert compiled(capsys, here, "--drop-edit", "seam_2")[0] == 0
    assert "v30" not in module(here).read_text()


def test_tools_stay_as_they_were_measured(here, capsys):
    process = here / "part.process.toml"
    tool = '[motion]\ntool = "gun"\n[tools.gun]\ntip = [0, 0, 120]\nmass = 1\n'
    process.write_text(PROCESS + tool)
    status, _, err = compiled(capsys, here)
    assert status == 0, err
    edit(module(here), "[[0,0,120],", "[[0.4,-0.2,121],")
    draw(here, {**BEADS, "c": ((400, -20), (470, -20))})
    process.write_text(PROCESS + tool)
    status, _, err = compiled(capsys, here)
    assert status == 0 and "tool `gun`" in err, err
    assert "[[0.4,-0.2,121]," in module(here).read_text()
    process.write_text((PROCESS + tool).replace("120", "125"))
    status, _, err = compiled(capsys, here)
    assert status == 1 and "CO332" in err and "--keep-edit gun" in err


def test_comments_stay_where_their_lines_are(here, capsys):
    declared = positions(module(here).read_text())["seam_2_start"]
    assert declared == (460, -60, 300)
    text = module(here).read_bytes().decode()
    line = next(one for one in text.split("\r\n") if "robtarget seam_2_start:=" in one)
    edit(module(here), line, f"{line} ! measured")
    edit(module(here), "PROC main()", "! asked for by Eva\r\n    PROC main()")
    edit(module(here), "MoveL seam_2_end,v50,fine,tool0;", "MoveL seam_2_end,v50,fine,tool0; ! ok")
    draw(here, {**BEADS, "c": ((400, -20), (470, -20))})
    status, _, err = compiled(capsys, here)
    assert status == 0, err
    text = module(here).read_text()
    assert "! asked for by Eva" in text and "[[470,-20,300]" in text
    assert re.search(r"MoveL seam_2_end,[^\n]*\s*! ok", text)
    assert re.search(r"robtarget seam_2_start:=[^\n]*! measured", text)
    draw(here, {"a": BEADS["a"]})
    status, _, err = compiled(capsys, here, "--drop-edit", "seam_2")
    assert (status, "measured" in module(here).read_text()) == (0, False), err


def test_a_comment_on_what_is_gone_is_told_of(here, capsys):
    text = module(here).read_bytes().decode()
    line = next(one for one in text.split("\r\n") if "robtarget seam_3_end:=" in one)
    edit(module(here), line, f"{line} ! measured")
    edited = module(here).read_bytes()
    draw(here, {"a": BEADS["a"], "b": BEADS["b"]})
    status, _, err = compiled(capsys, here)
    assert status == 1 and "CO337" in err and "`measured`" in err
    assert module(here).read_bytes() == edited


def test_a_file_that_nobody_knows_is_not_written_over(here, capsys):
    shutil.rmtree(here / "out" / ".robot-assistant")
    assert compiled(capsys, here)[0] == 0  # it says the same
    shutil.rmtree(here / "out" / ".robot-assistant")
    edit(module(here), "seam_1_start:=[[400,-100,300]", "seam_1_start:=[[400,-102,300]")
    edited = module(here).read_bytes()
    status, out, err = compiled(capsys, here)
    assert status == 1 and "CO331" in err and "wrote" not in out
    assert module(here).read_bytes() == edited
    status, _, err = compiled(capsys, here, "--overwrite")
    assert status == 0 and "CO338" in err and b"-102" not in module(here).read_bytes()


def test_a_file_that_is_no_program_any_more_is_not_written_over(here, capsys):
    module(here).write_text("MODULE part\nPROC main(\n")
    draw(here, {**BEADS, "c": ((400, -20), (470, -20))})
    status, _, err = compiled(capsys, here)
    assert status == 1 and "CO336" in err and module(here).read_text().endswith("main(\n")


def test_a_touch_up_out_of_reach_is_refused(here, capsys):
    edit(module(here), "seam_1_start:=[[400,-100,300]", "seam_1_start:=[[4000,-100,300]")
    status, _, err = compiled(capsys, here)
    assert status == 1 and "RB1" in err and "4000" in module(here).read_text()


def test_names_of_no_edit_are_told(here, capsys):
    edit(module(here), "seam_1_start:=[[400,-100,300]", "seam_1_start:=[[400,-102,300]")
    edited = module(here).read_bytes()
    draw(here, {**BEADS, "c": ((400, -20), (470, -20))})
    status, _, err = compiled(capsys, here, "--drop-edit", "seam_9_start")
    assert status == 1 and "CO339" in err and "`seam_1_start`" in err
    assert module(here).read_bytes() == edited


def test_programs_told_of_edits(here, capsys):
    edit(module(here), "seam_1_start:=[[400,-100,300]", "seam_1_start:=[[400,-102,300]")
    status, out, _ = compiled(capsys, here, "--format", "json")
    answer = json.loads(out)
    assert status == 0 and answer["written"] == [str(module(here))]
    assert "-102" in answer["edits"][str(module(here))]


def test_positions_of_the_other_maker_stay(tmp_path, capsys):
    draw(tmp_path, BEADS)
    assert compiled(capsys, tmp_path, language=MELFA)[0] == 0
    file = tmp_path / "out" / "PART.prg"
    edit(file, "PSEAM2START=(+460.00,-60.00,+300.00", "PSEAM2START=(+460.50,-60.00,+299.00")
    draw(tmp_path, {"new": ((440, -140), (400, -120)), **BEADS})
    status, _, err = compiled(capsys, tmp_path, language=MELFA)
    assert status == 0 and "which is `seam_3_start` now" in err, err
    text = file.read_text()
    assert "PSEAM3START=(+460.50,-60.00,+299.00" in text
    assert "PSEAM2START=(+400.00,-100.00,+300.00" in text


def test_a_program_of_several_files_is_not_merged(tmp_path, capsys):
    rows = [f"{400 + i},0,300,0,1,0,0" for i in range(25)]
    source = tmp_path / "part.csv"
    source.write_text("x_mm,y_mm,z_mm,q_w,q_x,q_y,q_z\n" + "\n".join(rows) + "\n")
    words = ("compile", source, "-l", "rapid", "--most-targets", "10", "-o", tmp_path / "out")
    assert run(capsys, *words)[0] == 0
    files = sorted((tmp_path / "out").glob("*.mod"))
    assert len(files) > 2
    edit(files[-1], "[424,0,300]", "[424,0,299]")
    edited = {file: file.read_bytes() for file in files}
    assert run(capsys, *words)[0] == 0  # nothing else has changed
    assert {file: file.read_bytes() for file in files} == edited
    source.write_text(source.read_text().replace("424,", "425,"))
    status, _, err = run(capsys, *words)
    assert status == 1 and "CO335" in err
    assert {file: file.read_bytes() for file in files} == edited
    assert run(capsys, *words, "--overwrite")[0] == 0
    assert "[425,0,300]" in files[-1].read_text()


def test_a_bead_that_is_not_called_any_more_is_left_out_whatever_its_number(here, capsys):
    edit(module(here), "        seam_2;", "        ! seam_2;")
    draw(here, {"new": ((440, -140), (400, -120)), **BEADS})
    status, _, err = compiled(capsys, here)
    assert status == 0, err
    called = re.findall(r"^        (seam_\d);", module(here).read_text(), re.MULTILINE)
    assert called == ["seam_1", "seam_2", "seam_4"]


def test_statements_of_a_bead_follow_its_procedure_to_another_number(here, capsys):
    edit(module(here), "MoveL seam_2_end,v50,fine", "MoveL seam_2_end,v30,fine")
    draw(here, {"new": ((440, -140), (400, -120)), **BEADS})
    status, _, err = compiled(capsys, here)
    assert status == 0, err
    text = module(here).read_text()
    assert "MoveL seam_3_end,v30,fine" in text and "MoveL seam_2_end,v50,fine" in text


def test_touch_ups_stay_where_contours_got_other_names(here, capsys):
    edit(module(here), "seam_2_start:=[[460,-60,300]", "seam_2_start:=[[460.5,-60,300]")
    drawing = ezdxf.readfile(here / "part.dxf")
    for line in drawing.modelspace():
        line.dxf.layer = "BEAD"
    drawing.saveas(here / "part.dxf")
    (here / "part.process.toml").write_text(PROCESS.replace("SEAM", "BEAD"))
    status, _, err = compiled(capsys, here)
    assert status == 0, err
    assert positions(module(here).read_text())["bead_2_start"] == (460.5, -60, 300)


def test_edits_stay_where_names_are_shortened_in_another_way_now(tmp_path, capsys):
    draw(tmp_path, BEADS)
    assert compiled(capsys, tmp_path, language=MELFA)[0] == 0
    file = tmp_path / "out" / "PART.prg"
    for written in (file, tmp_path / "out" / ".robot-assistant" / "written" / "PART.prg.written"):
        edit(written, "PSEAM2START", "PSEAM2S", count=4)  # as by an earlier version
        edit(written, "PSEAM3START", "PSEAM2START", count=4)
    edit(file, "PSEAM2S=(+460.00,-60.00,+300.00", "PSEAM2S=(+460.50,-60.00,+299.00")
    edit(file, "Mvs PSEAM2S\r\n", "Mvs PSEAM2S ' slowly\r\n")
    draw(tmp_path, {**BEADS, "new": ((400, 20), (440, 20))})
    status, _, err = compiled(capsys, tmp_path, language=MELFA)
    assert status == 0, err
    text = file.read_text()
    assert "PSEAM2START=(+460.50,-60.00,+299.00" in text
    assert "PSEAM3START=(+400.00,-20.00,+300.00" in text
    assert "' slowly" in text and "PSEAM4START" in text
