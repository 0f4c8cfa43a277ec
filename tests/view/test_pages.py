"""Pages of programs in their cells: what they hold, and that they need nothing else."""

from __future__ import annotations

import base64
import io
import json
import re
from contextlib import redirect_stdout
from pathlib import Path

import numpy as np
import pytest

from assistant import robots
from assistant.cli import main
from assistant.view.page import filled_page
from tests.cli.tables import each
from tests.cli.test_commands import SAMPLES, run
from tests.view.cases import data_of, numbers, written

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    pytest.importorskip("coal")
    folder = tmp_path_factory.mktemp("seam")
    program, cell = written(folder)
    out = folder / "out" / "seam.html"
    with redirect_stdout(io.StringIO()) as said, pytest.raises(SystemExit) as ended:
        main(["view", str(program), "--cell", str(cell), "--html", str(out)])
    assert ended.value.code == 1  # it touches the post
    assert said.getvalue().endswith(f"wrote {out}\n")
    return out.read_text(encoding="utf-8")


def test_a_page_needs_no_other_file(page: str) -> None:
    assert "default-src 'none'" in page
    assert not re.search(r"""<(script|link|img)[^>]+(src|href)=["'](?!data:)""", page)
    assert page.count("</script>") == 3


def test_no_text_of_a_program_ends_a_script() -> None:
    data = {"title": "<!--</script><b>\u2028&amp;", "moves": ["<script>{{ data }}"]}
    page = filled_page(data)
    assert page.count("</script>") == 3
    assert "<b>" not in page
    assert data_of(page) == data


def test_the_motion_of_a_page_is_that_of_the_program(page: str) -> None:
    data = data_of(page)
    motion, robot = data["motion"], robots.get("irb1200-7-0.7")
    times = numbers(motion["times"])
    chained = numbers(motion["joints"]).reshape(len(times), 6)
    joints = np.degrees(chained) - np.asarray(robot.zero)
    positions, _ = robot.fk(joints)
    places = numbers(motion["places"]).reshape(-1, 3)
    assert np.abs(places - positions - [50.0, 0.0, 20.0]).max() < 0.1  # between knots
    # There and back at 100 and 200 mm/s with waits between, three times.
    assert times[-1] > 3 * (2.0 + 0.5 + 1.0)
    speeds = numbers(motion["speeds"])
    on_lines = np.abs(positions[:, 2] - 400.0) < 0.01
    assert np.isclose(speeds[on_lines].max(), 200.0, atol=0.5)


def test_moves_have_their_lines_and_every_round_of_a_loop(page: str) -> None:
    data = data_of(page)
    moves = data["moves"]
    assert [(move["procedure"], move["number"], move["line"]) for move in moves] == [
        ("main", 1, 7),
        ("forth", 1, 14),
        ("forth", 2, 16),
    ]
    assert moves[0]["time"] == 0.0
    begins = numbers(data["played"]["times"])
    lines = np.frombuffer(base64.b64decode(data["played"]["lines"]), "<u4")
    assert lines.tolist() == [7, *[14, 16] * 3]
    (text,) = data["texts"]
    assert text["lines"][13].strip().startswith("move linear b")
    assert len(begins) == 1 + 3 * 2
    rounds = np.diff(begins[1::2])
    assert np.allclose(rounds, rounds[0])
    assert begins[1] == pytest.approx(moves[1]["time"], abs=1e-4)


def test_a_contact_is_found_on_the_time_line(page: str) -> None:
    data = data_of(page)
    touching = [f for f in data["findings"] if f["code"] == "CK421" and f["mark"]["time"]]
    assert touching
    times, motion = numbers(data["motion"]["times"]), data["motion"]
    joints = numbers(motion["joints"]).reshape(len(times), 6)
    for finding in touching:
        mark = finding["mark"]
        assert "post" in (mark["one"], mark["other"])
        at = [np.interp(mark["time"], times, column) for column in joints.T]
        assert np.abs(np.degrees(np.array(at) - mark["joints"])).max() < 0.5
        assert data["moves"][finding["move"]]["line"] in (7, 14, 16)


def test_targets_and_locations_have_names(page: str) -> None:
    data = data_of(page)
    places = {one["name"]: one["pose"][:3] for one in data["targets"]}
    assert places == {"a": [450.0, -100.0, 420.0], "b": [450.0, 100.0, 420.0]}
    post = next(body for body in data["bodies"] if body["name"] == "post")
    assert post["locations"][0]["pose"][:3] == [0.0, 0.0, 150.0]
    assert post["pose"][:3] == [450.0, 0.0, 420.0]


def test_without_a_cell_the_robot_stands_alone(tmp_path: Path, capsys: Capture) -> None:
    program, _ = written(tmp_path)
    out = tmp_path / "alone.html"
    status, said, err = run(capsys, "view", program, "--html", out, "--format", "json")
    assert (status, err) == (0, "")
    assert json.loads(said)["written"] == [str(out)]
    names = [body["name"] for body in data_of(out.read_text(encoding="utf-8"))["bodies"]]
    assert names[:2] == ["robot.base", "robot.J1"]


def test_it_opens_in_the_browser(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: not opened.append(address))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    program, _ = written(tmp_path)
    assert run(capsys, "view", program)[0] == 0
    (page,) = tmp_path.glob("robot-assistant-view-*/seam.html")
    assert opened == [page.as_uri()]
    monkeypatch.setattr("webbrowser.open", lambda _: False)
    status, _, err = run(capsys, "view", program)
    assert status == 2
    assert "CL035" in err
    assert list(tmp_path.glob("robot-assistant-view-*")) == [page.parent]


BAD = (
    (("--html", "out.txt"), "CL034", 2),
    (("--html", "seam.html", "--robot", "nothing"), "CO002", 2),
    (("--html", "seam.html", "--cell", "other.toml"), "CK423", 2),
    (("--html", "seam.html", "--cell", "none.toml"), "IN001", 2),
    (("--html", "seam.html", "--robot", "rv-2aj"), "RB", 1),
)


def test_bad_input_leaves_no_page(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coal")
    monkeypatch.chdir(tmp_path)
    program, _ = written(tmp_path)
    Path("other.toml").write_text('[robots.arm]\nrobot = "rv-2aj"\n', encoding="utf-8")

    def check(words: tuple[str, ...], code: str, status: int) -> None:
        ended, _, err = run(capsys, "view", program.name, *words)
        assert ended == status
        assert code in err
        assert not list(tmp_path.glob("*.html"))
        assert not Path("out.txt").exists()

    each(BAD, check)


def test_what_is_worst_stands_first(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("coal")
    out = tmp_path / "plate.html"
    cell = SAMPLES / "cell" / "clamped.toml"
    status, _, _ = run(capsys, "view", SAMPLES / "plate.dxf", "--cell", cell, "--html", out)
    severities = [one["severity"] for one in data_of(out.read_text(encoding="utf-8"))["findings"]]
    assert status == 1
    assert severities == sorted(severities, key=("error", "warning", "info").index)
    assert {"error", "info"} <= set(severities)
