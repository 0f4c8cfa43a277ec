"""`compare`: what it says of two programs, for people and for programs, and its exit status."""

from __future__ import annotations

import base64
import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.cli.test_commands import SAMPLES, run
from tests.compiler.test_comparing import (
    CELL,
    CHOOSING,
    CHOSEN,
    HEAD,
    PICKED,
    PICKING,
    POSITIONS,
    written,
)
from tests.view.cases import data_of
from tests.view.test_reports import programs_of

Capture = pytest.CaptureFixture[str]
PAGE = Path(__file__).parents[2] / "docs" / "comparing.md"


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    written(tmp_path, "pick.mod", HEAD + PICKING)
    written(tmp_path, "PICK.mb5", PICKED + POSITIONS)
    written(tmp_path, "cell.process.toml", CELL)
    return tmp_path


def test_equal_programs(capsys: Capture, cell: Path) -> None:
    given = cell / "pick.mod", cell / "PICK.mb5", "-p", cell / "cell.process.toml"
    status, out, err = run(capsys, "compare", *given)
    assert (status, err) == (0, "")
    assert out.rstrip().endswith("largest distance 0.0000 mm, 0.0000 degrees: equal")
    assert out.count("\n") == 1


def test_both_lines_of_a_difference(capsys: Capture, cell: Path) -> None:
    wrong = PICKED.replace("Dly 0.3", "Dly 3")
    written(cell, "PICK.mb5", wrong + POSITIONS)
    given = cell / "pick.mod", cell / "PICK.mb5", "-p", cell / "cell.process.toml"
    status, out, err = run(capsys, "compare", *given)
    assert (status, err) == (1, "")
    first, second, third, what, line = out.splitlines()
    assert first == f"{cell / 'pick.mod'}:13: WaitTime 0.3;"
    assert second == f"{cell / 'PICK.mb5'}:28: Dly 3"
    assert third == "  behind line 18: If M_In(4)=0 Then GoTo *WAITING"
    assert what == "  event 6: another delay: 0.3 s, and 3 s; with diPart=1"
    assert line.endswith(": different")


def test_the_answer_for_programs(capsys: Capture, cell: Path) -> None:
    written(cell, "pick.mod", HEAD + CHOOSING)
    written(cell, "PICK.mb5", CHOSEN.replace("M_Out(11)=1", "M_Out(12)=1") + POSITIONS)
    given = cell / "pick.mod", cell / "PICK.mb5", "-p", cell / "cell.process.toml"
    status, out, _ = run(capsys, "compare", *given, "--format", "json")
    answer = json.loads(out)
    assert status == 1 and answer["ok"] is False
    (one,) = answer["comparisons"]
    assert one["answer"] == "different"
    assert one["compared"]["runs"] > 1
    (difference,) = one["differences"]
    assert [place["text"] for place in difference["places"]] == ["SetDO doDone,1;", "M_Out(12)=1"]
    assert difference["behind"][0]["text"] == "TEST n"


def test_what_cannot_be_read(capsys: Capture, cell: Path) -> None:
    written(cell, "broken.mb5", "10 Mvs (\n20 End\n")
    written(cell, "empty.mod", "")
    for second, code in (("none.mb5", "IN001"), ("broken.mb5", "MB002"), ("empty.mod", "IN005")):
        status, out, err = run(capsys, "compare", cell / "pick.mod", cell / second)
        assert (status, out) == (2, "")
        assert code in err and "Traceback" not in err


@pytest.mark.slow
def test_folders(capsys: Capture, cell: Path) -> None:
    for folder in ("old", "new"):
        (cell / folder).mkdir()
        written(cell / folder, "PICK.mb5", PICKED + POSITIONS)
        written(cell / folder, "CHOOSE.mb5", CHOSEN + POSITIONS)
    status, out, _ = run(capsys, "compare", cell / "old", cell / "new")
    assert status == 0
    assert out.rstrip().endswith("2 pairs of programs, 2 of them equal")
    written(cell / "old", "MORE.mb5", "M_Out(3)=1\nEnd\n")
    status, out, err = run(capsys, "compare", cell / "old", cell / "new")
    assert status == 1 and "CL015" in err and "MORE" in err


def test_statements_are_paired_without_running(capsys: Capture, cell: Path) -> None:
    plain = PICKED.replace("Mvs PPICK\n", "Mvs PHOME\n")
    for name, text in (("a.mb5", PICKED), ("b.mb5", plain.replace("Dly 0.3\n", ""))):
        written(cell, name, text + POSITIONS)
    given = cell / "a.mb5", cell / "b.mb5", "--text"
    status, out, err = run(capsys, "compare", *given)
    assert (status, err) == (1, "")
    first, second, third, line = out.splitlines()
    assert first == f"- {cell / 'a.mb5'}:26: Mvs PPICK"
    assert second == f"+ {cell / 'b.mb5'}:26: Mvs PHOME"
    assert third == f"- {cell / 'a.mb5'}:28: Dly 0.3"
    assert line.endswith("statements say the same: different")
    status, out, _ = run(capsys, "compare", cell / "a.mb5", cell / "a.mb5", "--text")
    assert status == 0 and out.rstrip().endswith(": equal")


def test_the_statements_of_two_languages_are_paired(capsys: Capture, cell: Path) -> None:
    moving = "PROC main()\n  MoveL pPick,v100,fine,tGrip;\n  SetDO doGrip,1;\nENDPROC\nENDMODULE\n"
    written(cell, "pick.mod", HEAD + moving)
    code = "Tool PTOOL\nSpd 100\nCnt 0\nMvs PPICK\nM_Out(10)=1\nEnd\n"
    written(cell, "PICK.mb5", code + POSITIONS)
    given = cell / "pick.mod", cell / "PICK.mb5", "-p", cell / "cell.process.toml", "--text"
    status, out, _ = run(capsys, "compare", *given)
    assert (status, out.split(": ")[-2]) == (0, "2 of 2 statements say the same"), out
    written(cell, "PICK.mb5", code.replace("PPICK", "PPLACE") + POSITIONS)
    status, out, _ = run(capsys, "compare", *given)
    assert status == 1 and "1 of 2 statements say the same" in out


def test_the_page_shows_both_programs_side_by_side(capsys: Capture, cell: Path) -> None:
    wrong = PICKED.replace("Dly 0.3", "Dly 3")
    written(cell, "PICK.mb5", wrong + POSITIONS)
    page = cell / "page.html"
    given = cell / "pick.mod", cell / "PICK.mb5", "-p", cell / "cell.process.toml"
    status, out, err = run(capsys, "compare", *given, "--report", page)
    assert (status, err) == (1, "") and out.endswith(f"wrote {page}\n")
    data = data_of(page.read_text(encoding="utf-8"))
    assert data["title"] == "pick.mod and PICK.mb5: different"
    assert [one["lines"] for one in data["texts"]] == [(cell / "PICK.mb5").read_text().split("\n")]
    (first,) = data["beside"]["texts"]
    rows = np.frombuffer(base64.b64decode(data["beside"]["rows"]), "<u4").reshape(-1, 3).tolist()
    beside = {one: other for one, other, _ in rows if one and other}
    assert first["lines"][12].strip() == "WaitTime 0.3;" and beside[13] == 28
    assert data["beside"]["reasons"] == {
        "13": "event 6: another delay: 0.3 s, and 3 s; with diPart=1"
    }
    (finding,) = [one for one in data["findings"] if one["code"] == "CO118"]
    assert finding["line"] == 28


def test_the_page_lists_programs_without_a_counterpart(capsys: Capture, cell: Path) -> None:
    for folder in ("old", "new"):
        (cell / folder).mkdir()
        written(cell / folder, "PICK.mb5", "Mvs PPICK\nM_Out(2)=1\nEnd\n" + POSITIONS)
    written(cell / "old", "MORE.mb5", "M_Out(3)=1\nEnd\n")
    page = cell / "page.html"
    status, _, _ = run(capsys, "compare", cell / "old", cell / "new", "--report", page)
    first, other = programs_of(page.read_text(encoding="utf-8"))
    assert (status, first["title"]) == (1, "PICK.mb5 and PICK.mb5: equal")
    assert [one["code"] for one in other["findings"]] == ["CL015"]


def test_a_page_is_not_written_over_what_is_compared(capsys: Capture, cell: Path) -> None:
    given = cell / "pick.mod", cell / "PICK.mb5", "-p", cell / "cell.process.toml"
    for name in ("pick.mod", "PICK.mb5", "cell.process.toml"):
        page = cell / f"{name}.html"
        page.symlink_to(cell / name)
        before = (cell / name).read_bytes()
        status, _, err = run(capsys, "compare", *given, "--report", page)
        assert status == 2 and name in err and (cell / name).read_bytes() == before
    status, _, err = run(capsys, "compare", *given, "--report", cell / "page.txt")
    assert status == 2 and "page.txt" in err


def test_what_the_page_of_the_documentation_prints(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands, printed = re.findall(r"^```(?:console)?\n(.*?)^```", PAGE.read_text(), re.M | re.S)[
        :2
    ]
    shutil.copytree(SAMPLES, tmp_path / "samples")
    monkeypatch.chdir(tmp_path)
    out = ""
    for line in commands.splitlines():
        name, *given = shlex.split(line.removeprefix("$ "), comments=True)
        if name == "robot-assistant":
            _, out, _ = run(capsys, *given)
        else:
            made = Path(given[-1])
            old, new = given[1].split("/")[1:3]
            made.write_text(made.read_text().replace(old, new))
    assert out == printed
