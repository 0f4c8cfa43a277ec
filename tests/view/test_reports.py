"""`--report`: what commands did, on the page that `view` writes."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_commands import SAMPLES, run
from tests.view.cases import data_of, numbers, written

Capture = pytest.CaptureFixture[str]
GLUING = SAMPLES / "rapid" / "gluing.mod"
CELL = SAMPLES / "rapid" / "cell.process.toml"
IRB = ("--robot", "irb1200-7-0.7")
TO_CR = ("--to", "melfa-basic-5", "--from-robot", "irb1200-7-0.7", "--robot", "rv-4frl")


def programs_of(page: str) -> list[dict[str, Any]]:
    """The data of each program of a page."""
    found = re.findall(
        r'<script id="data(?:-\d+)?" type="application/json">(.*?)</script>', page, re.DOTALL
    )
    return [json.loads(text) for text in found]


def report(capsys: Capture, folder: Path, *command: object) -> tuple[int, str]:
    """Exit status and page of a command."""
    out = folder / "out" / "page.html"
    status, said, _ = run(capsys, *command, "--report", out)
    assert f"wrote {out}\n" in said
    return status, out.read_text(encoding="utf-8")


def ints(column: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(column), "<u4")


def test_a_compiled_drawing_is_shown_as_it_is_written(tmp_path: Path, capsys: Capture) -> None:
    plate = SAMPLES / "plate.dxf"
    status, page = report(capsys, tmp_path, "compile", plate, "-l", "rapid", *IRB, "-o", tmp_path)
    data = data_of(page)
    assert status == 0
    (text,) = data["texts"]
    lines = (tmp_path / "plate.mod").read_text().splitlines()
    assert text["lines"][: len(lines)] == lines
    assert [note.startswith("text read back: proven") for note in data["notes"]] == [True]
    assert data["plan"] and data["still"] is None
    for move in data["moves"]:
        assert "Move" in lines[move["line"] - 1]
    # every place of the drawing's path is one of the targets that stand in the text
    times = {one["name"]: one for one in data["times"]["procedures"]}
    assert times["GLUE"]["length"] == pytest.approx(
        sum(one["length"] for one in data["moves"] if one["procedure"] == "GLUE")
    )
    assert float(times["main"]["seconds"]) == pytest.approx(data["motion"]["whole"], abs=0.01)


def test_a_page_says_that_edits_are_kept_which_it_does_not_show(
    tmp_path: Path, capsys: Capture
) -> None:
    program, _ = written(tmp_path)
    given = ("compile", program, "-l", "rapid", "-o", tmp_path / "out")
    _, page = report(capsys, tmp_path, *given)
    assert "CL062" not in {one["code"] for one in data_of(page)["findings"]}
    module = tmp_path / "out" / "cell.mod"
    module.write_text(module.read_text().replace("WaitTime 0.5", "WaitTime 0.7"))
    status, page = report(capsys, tmp_path, *given)
    data = data_of(page)
    assert status == 0
    assert "WaitTime 0.7" in module.read_text()
    assert "CL062" in {one["code"] for one in data["findings"]}
    assert any("WaitTime 0.5" in line for line in data["texts"][0]["lines"])


def test_lengths_are_those_of_the_lines(tmp_path: Path, capsys: Capture) -> None:
    program, _ = written(tmp_path)
    _, page = report(capsys, tmp_path, "simulate", program)
    data = data_of(page)
    there, back = (one for one in data["moves"] if one["procedure"] == "forth")
    assert (there["length"], back["length"]) == pytest.approx((200.0, 200.0))
    assert there["seconds"] > 2.0 > back["seconds"] > 1.0  # at 100 and 200 mm/s
    forth = next(one for one in data["times"]["procedures"] if one["name"] == "forth")
    assert forth["length"] == pytest.approx(400.0)
    assert float(forth["seconds"]) == pytest.approx(forth["moving"] + 0.5, abs=0.02)  # it waits


def test_each_line_of_a_translation_stands_beside_what_it_became(
    tmp_path: Path, capsys: Capture
) -> None:
    given = ("translate", GLUING, *TO_CR, "-p", CELL, "-o", tmp_path)
    status, page = report(capsys, tmp_path, *given)
    data = data_of(page)
    assert status == 0
    before = GLUING.read_text().splitlines()
    after = (tmp_path / "GLUING.prg").read_bytes().decode("ascii").splitlines()
    rows = ints(data["beside"]["rows"]).reshape(-1, 3)
    assert set(rows[:, 0]) >= set(range(1, len(before) + 1))
    assert sorted(rows[rows[:, 0] > 0, 0]) == sorted(set(rows[rows[:, 0] > 0, 0]))
    assert set(rows[:, 1]) >= set(range(1, len(after) + 1))
    pairs = {
        before[a - 1].strip().rstrip(";"): after[b - 1].split(" ", 1)[-1]
        for a, b, _ in rows.tolist()
        if a and b
    }
    comment = "Cell: IRB 1200-7/0.7, cartridge dispenser on the flange, cover on a table."
    assert pairs[f"! {comment}"] == f"' {comment}"
    assert pairs["WaitTime 0.15"] == "Dly 0.15"
    assert pairs["SetDO doGlue,1"] == "M_Out(11)=1 ' doGlue"
    assert pairs["MoveL pCorner3,vBead,z5,tNozzle\\WObj:=wCover"] == "Mvs PCORNER3"
    assert pairs["MoveL pCorner4,vBead,z5,tNozzle\\WObj:=wCover"] == "Mvs PCORNER4"
    declared = next(text for one, text in pairs.items() if "robtarget pCorner4" in one)
    assert declared.startswith("PCORNER4=(+0.00,+280.00,")
    levels = {before[a - 1].strip(): level for a, _, level in rows.tolist() if a}
    assert levels["MoveJ pHome,v1000,fine,tNozzle;"] == 1
    assert levels["ENDMODULE"] == 3
    assert data["texts"][0]["lines"][: len(after)] == after


REWINDING = """MODULE files
  VAR iodev io;
  PROC main()
    SetDO doGlue,1;
    Open "HOME:/a.txt",io\\Read;
    Rewind io;
    WaitTime 1;
    Rewind io;
  ENDPROC
ENDMODULE
"""


def test_what_is_not_said_is_told_beside_its_line(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "files.mod"
    source.write_text(REWINDING)
    given = ("translate", source, "--to", "melfa-basic-5", "-o", tmp_path / "out")
    status, page = report(capsys, tmp_path, *given)
    data = data_of(page)
    assert status == 1
    rows = ints(data["beside"]["rows"]).reshape(-1, 3)
    assert rows[:, 1].any()  # a draft was written
    assert [a for a, _, level in rows.tolist() if level == 2] == [6, 8]
    assert "Rewind io" in data["beside"]["reasons"]["6"]
    found = {one["beside"] for one in data["findings"] if one["severity"] == "error"}
    assert found == {6, 8}
    assert data["still"] is not None  # no robot is told
    status, page = report(capsys, tmp_path, *given, "--no-draft")
    assert not ints(data_of(page)["beside"]["rows"]).reshape(-1, 3)[:, 1].any()


def test_a_check_finds_places_without_an_arm_that_reaches_them(
    tmp_path: Path, capsys: Capture
) -> None:
    program = tmp_path / "far.pseudo"
    program.write_text(
        "program far for irb1200-7-0.7\n\ntarget a [400, 0, 400] [0, 0, 1, 0]\n"
        "target b [1400, 100, 400] [0, 0, 1, 0]\n\nprocedure main\n"
        "  move joint a speed 500 mm/s blend fine\n  move linear b speed 100 mm/s blend fine\nend\n"
    )
    status, page = report(capsys, tmp_path, "check", program)
    data = data_of(page)
    assert status == 1
    assert data["times"] is None
    far = [one for one in data["findings"] if one["severity"] == "error"]
    assert far
    assert [one["at"] for one in far] == [[1400.0, 100.0, 400.0]] * len(far)
    places = numbers(data["still"]["places"]).reshape(-1, 3)
    assert places.tolist() == [[400.0, 0.0, 400.0], [1400.0, 100.0, 400.0]]
    assert ints(data["still"]["joint"]).tolist() == [1, 0]
    assert next(one["name"] for one in data["bodies"]) == "robot.base"


def test_no_finding_of_a_folder_is_lost_on_its_page(tmp_path: Path, capsys: Capture) -> None:
    here = tmp_path / "programs"
    here.mkdir()
    (here / "a.dxf").write_bytes((SAMPLES / "plate.dxf").read_bytes())
    (here / "b.prg").write_text("10 MOV P1\n20 GOTO 99\n")
    (here / "c.pseudo").write_text("program c\n\nprocedure main\n  nonsense\nend\n")
    (here / "d.dxf").write_bytes(b"\x00\x01 no drawing")
    out = tmp_path / "page.html"
    status, said, _ = run(capsys, "check", here, "--report", out, "--format", "json")
    told = {(one["code"], one["message"]) for one in json.loads(said)["findings"]}
    programs = programs_of(out.read_text(encoding="utf-8"))
    shown = {(one["code"], one["message"]) for data in programs for one in data["findings"]}
    assert status == 2
    assert {code for code, _ in told} == {code for code, _ in shown}
    assert {"a.dxf", "b.prg", "c.pseudo", "d.dxf"} == {data["title"] for data in programs}
    assert programs[0]["chosen"] == [data["title"] for data in programs]


def test_hostile_names_stay_texts(tmp_path: Path, capsys: Capture) -> None:
    name = "</script><script>alert(1)<!--"
    source = tmp_path / "m.mod"
    source.write_text(f'MODULE m\nPROC main()\nTPWrite "{name}";\nENDPROC\nENDMODULE\n')
    for command in (
        ("check", source),
        ("translate", source, "--to", "melfa-basic-6", "-o", tmp_path / "cr"),
    ):
        _, page = report(capsys, tmp_path, *command)
        assert page.count("</script>") == 3
        assert "alert(1)<" not in page
        assert any(name in line for one in data_of(page)["texts"] for line in one["lines"]) or any(
            name in line for one in data_of(page)["beside"]["texts"] for line in one["lines"]
        )


@pytest.mark.parametrize("command", ["compile", "check", "simulate"])
def test_a_report_that_is_no_page_is_refused(command: str, tmp_path: Path, capsys: Capture) -> None:
    program, _ = written(tmp_path)
    to = ("-l", "rapid", "-o", tmp_path / "out") if command == "compile" else ()
    status, _, err = run(capsys, command, program, *to, "--report", tmp_path / "page.pdf")
    assert (status, "CL034" in err) == (2, True)
    assert sorted(one.name for one in tmp_path.iterdir()) == ["cell.toml", "seam.pseudo"]


def test_a_page_is_not_written_over_a_source(tmp_path: Path, capsys: Capture) -> None:
    program, _ = written(tmp_path)
    source = program.rename(tmp_path / "seam.html")
    before = source.read_bytes()
    status, _, err = run(capsys, "simulate", source, "--report", source)
    assert (status, source.read_bytes()) == (2, before)
    assert err


@pytest.mark.parametrize("browser", [True, False])
def test_the_page_is_opened(
    browser: bool, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or browser)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    program, _ = written(tmp_path)
    status, said, err = run(capsys, "simulate", program, "--open")
    (address,) = opened
    page = Path(address.removeprefix("file://"))
    assert status == 0
    assert f"wrote {page}" in said
    assert data_of(page.read_text(encoding="utf-8"))["title"] == "seam.pseudo"
    assert ("CL060" in err) is not browser
