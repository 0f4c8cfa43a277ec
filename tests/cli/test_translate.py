"""`translate`: reports for people and programs, exit statuses, nothing half done."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from tests.cli.test_commands import run

SAMPLES = Path(__file__).parents[2] / "samples"
PALLET = SAMPLES / "melfa" / "PALLET.prg"
EXCHANGE = SAMPLES / "rapid" / "pose_exchange.mod"
TO_RAPID = ("--to", "rapid", "-r", "irb1200-7-0.7", "--from-robot", "rv-4frl")

Capture = pytest.CaptureFixture[str]


def test_a_program_that_can_be_said_is_written(tmp_path: Path, capsys: Capture) -> None:
    status, out, _ = run(capsys, "translate", PALLET, *TO_RAPID, "-o", tmp_path)
    assert status == 0
    lines = out.splitlines()
    assert f"{PALLET}:13: partial: 13 Mov PHome -> PALLET.mod:23" in lines
    assert f"{PALLET}:12: supported: 12 Cnt 0" in lines
    assert any(line.startswith("    RA306 a joint speed in percent") for line in lines)
    assert lines[-1] == f"wrote {tmp_path / 'PALLET.mod'}"
    assert "MoveJ PHome" in (tmp_path / "PALLET.mod").read_text().splitlines()[22]


def test_nothing_is_written_if_something_cannot_be_said(tmp_path: Path, capsys: Capture) -> None:
    status, out, _ = run(capsys, "translate", EXCHANGE, "--to", "melfa-basic-5", "-o", tmp_path)
    assert status == 1
    assert f"{EXCHANGE}:33: not: Rewind ioFile\n" in out
    assert list(tmp_path.iterdir()) == []


def test_a_draft_is_written_and_still_no_success(tmp_path: Path, capsys: Capture) -> None:
    status, out, _ = run(
        capsys, "translate", EXCHANGE, "--to", "melfa-basic-5", "-o", tmp_path, "--draft"
    )
    assert status == 1
    assert "the files are a draft" in out
    (file,) = tmp_path.iterdir()
    assert file.read_text().startswith("1 ' DRAFT")


def test_the_answer_in_json(tmp_path: Path, capsys: Capture) -> None:
    status, out, _ = run(
        capsys, "translate", EXCHANGE, "--to", "melfa-basic-6", "-o", tmp_path, "--format", "json"
    )
    answer = json.loads(out)
    assert (status, answer["ok"], answer["written"]) == (1, False, [])
    (program,) = answer["programs"]
    rewind = next(s for s in program["statements"] if s["line"] == 33)
    assert (rewind["level"], rewind["text"]) == ("not", "Rewind ioFile")
    assert rewind["reasons"][0]["code"] == "MB209"
    counts = [s["level"] for s in program["statements"]]
    assert {k: v for k, v in program["totals"].items() if v} == {
        level: counts.count(level) for level in set(counts)
    }


@pytest.mark.parametrize("format", ["sarif", "github"])
def test_findings_stand_at_their_lines(tmp_path: Path, capsys: Capture, format: str) -> None:
    status, out, _ = run(
        capsys, "translate", EXCHANGE, "--to", "melfa-basic-6", "-o", tmp_path, "--format", format
    )
    assert status == 1
    assert ('"startLine": 33' if format == "sarif" else "line=33") in out


def test_reports_are_written_as_their_suffix_says(tmp_path: Path, capsys: Capture) -> None:
    for name in ("r.html", "r.json", "r.txt"):
        given = ("translate", EXCHANGE, "--to", "melfa-basic-6", "--report", tmp_path / name)
        assert run(capsys, *given)[0] == 1
    html = (tmp_path / "r.html").read_text()
    assert '<td class="not">not</td><td><code>Rewind ioFile</code>' in html
    assert "IsFile(stTarget) AND IsFile(stTurn)" in html
    (data,) = json.loads((tmp_path / "r.json").read_text())
    assert data["statements"][0]["line"] == 5
    assert ":33: not: Rewind ioFile" in (tmp_path / "r.txt").read_text()


def test_a_page_holds_texts_as_texts(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "m.mod"
    source.write_text('MODULE m\nPROC main()\nOpen "<script>",f;\nENDPROC\nENDMODULE\n')
    report = tmp_path / "r.html"
    run(capsys, "translate", source, "--to", "melfa-basic-6", "--report", report)
    assert "<script>" not in report.read_text()
    assert "&lt;script&gt;" in report.read_text()


def test_standard_input(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(PALLET.read_bytes())))
    status, out, _ = run(capsys, "translate", "-", *TO_RAPID, "-o", tmp_path)
    assert status == 0
    assert "standard input:12: supported: 12 Cnt 0" in out


def test_folders_are_searched_and_names_may_not_clash(tmp_path: Path, capsys: Capture) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "PALLET.prg").write_bytes(PALLET.read_bytes())
    out = tmp_path / "out"
    status, _, err = run(capsys, "translate", tmp_path, *TO_RAPID, "-o", out)
    assert status == 1
    assert "CL001" in err
    assert not out.exists()


@pytest.mark.parametrize(
    "given",
    [
        ["nowhere.mod", "--to", "rapid"],
        [str(PALLET), "--to", "karel"],
        [str(PALLET), "--to", "rapid", "-r", "r2d2"],
        [str(SAMPLES / "plate.dxf"), "--to", "rapid"],
        [str(PALLET)],
        [str(PALLET), "--to", "rapid", "-p", "nowhere.toml"],
    ],
)
def test_wrong_usage_is_2(tmp_path: Path, capsys: Capture, given: list[str]) -> None:
    output = tmp_path / "out"
    status, _, err = run(capsys, "translate", *given, "-o", output)
    assert status == 2
    assert err
    assert not output.exists()


def test_a_program_is_not_written_over(tmp_path: Path, capsys: Capture) -> None:
    source = tmp_path / "PALLET.prg"
    source.write_bytes(PALLET.read_bytes())
    for command in (("translate", source, "--to"), ("compile", source, "-l")):
        status, _, err = run(capsys, *command, "melfa-basic-6", "-o", tmp_path)
        assert status == 2 and "CL007" in err
    status, _, err = run(capsys, "translate", source, *TO_RAPID, "-o", tmp_path, "--report", source)
    assert status == 2 and "CL007" in err
    assert source.read_bytes() == PALLET.read_bytes()
    assert list(tmp_path.iterdir()) == [source]


def test_nothing_on_standard_input_is_no_program(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"")))
    status, _, err = run(
        capsys, "translate", "-", "--from", "rapid", "--to", "melfa-basic-5", "-o", tmp_path
    )
    assert status == 2 and "IN005" in err
    assert list(tmp_path.iterdir()) == []
