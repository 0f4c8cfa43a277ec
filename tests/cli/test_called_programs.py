"""Programs that call programs in other files, whatever the suffixes of these files are."""

from __future__ import annotations

from pathlib import Path

import pytest

from assistant import languages
from assistant.compiler import translate
from assistant.compiler.loader import whole_programs
from tests.cli.tables import each
from tests.cli.test_commands import run

Capture = pytest.CaptureFixture[str]
SETTINGS = ("Tool P_NTool", "Base P_NBase", "Spd 100", "Cnt 0")
PLACE = "P1=(+320.00,+40.00,+310.00,+180.00,+0.00,+180.00)(7,0)"


def program(*lines: str) -> str:
    return "\n".join([*(f"{at} {line}" for at, line in enumerate(lines, 1)), PLACE, ""])


FILES = {
    "CELL": program(*SETTINGS, "Mvs P1", 'CallP "Grip"', 'CallP "lift",40', "End"),
    "GRIP": program(*SETTINGS, "Mvs P1,-30", "M_Out(9)=1", "End"),
    "LIFT": program("FPrm M7", *SETTINGS, "Mvs P1,-M7", "End"),
}
SUFFIXES = [
    ("prg", "prg"), ("mb4", "mb4"), ("mb5", "mb5"), ("mb6", "mb6"), ("MB5", "mb5"), ("mb5", "PRG"),
    ("prg", "Mb5"),
]  # fmt: skip


def written(folder: Path, main: str, others: str) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in FILES.items():
        suffix = main if name == "CELL" else others
        (folder / f"{name}.{suffix}").write_text(text, encoding="ascii")
    return folder / f"CELL.{main}"


def test_called_programs_are_part_of_the_translation(tmp_path: Path) -> None:
    def check(main: str, others: str) -> None:
        folder = tmp_path / f"{main} and {others}"
        start = written(folder, main, others)
        files = [str(file) for file in sorted(folder.iterdir())]
        assert whole_programs(files, "melfa-basic-5") == [str(start)]
        made = translate(start, to="rapid", language="melfa-basic-5")
        text = b"\n".join(made.files.values()).decode()
        assert made.ok
        assert "PROC GRIP()" in text
        assert "PROC LIFT(num M7)" in text
        assert "Load" not in text
        assert "MB123" not in {finding.code for finding in made.findings}

    each(SUFFIXES, check)


def test_called_programs_run(capsys: Capture, tmp_path: Path) -> None:
    def check(main: str, others: str) -> None:
        start = written(tmp_path / f"{main} and {others}", main, others)
        status, out, _ = run(capsys, "run", str(start))
        assert status == 0
        assert "(320.00, 40.00, 350.00)" in out

    each(SUFFIXES, check)


def test_the_file_with_the_suffix_of_its_caller_is_called(tmp_path: Path) -> None:
    written(tmp_path, "mb5", "mb5")
    (tmp_path / "GRIP.prg").write_text(program("M_Out(14)=1", "End"), encoding="ascii")
    made = translate(tmp_path / "CELL.mb5", to="rapid")
    text = b"\n".join(made.files.values()).decode()
    assert "do_9" in text
    assert "do_14" not in text


def test_a_called_program_that_is_missing_is_a_finding(capsys: Capture, tmp_path: Path) -> None:
    """In `run` also where the call is never reached."""
    start = tmp_path / "CELL.mb5"
    text = FILES["CELL"].replace('6 CallP "Grip"', '6 If M_In(3)=1 Then CallP "Grip"')
    start.write_text(text.replace('7 CallP "lift",40\n8', "7"), encoding="ascii")
    for command in ("check", "run", "translate"):
        given = ["--to", "rapid", "-o", str(tmp_path / "out")] if command == "translate" else []
        _, out, err = run(capsys, command, start, *given)
        assert "MB123" in out + err, command
        assert f"{start}:6" in out + err, command


def test_a_main_of_rapid_takes_no_parameters(tmp_path: Path) -> None:
    written(tmp_path, "mb5", "mb5")
    made = translate(tmp_path / "LIFT.mb5", to="rapid")
    (text,) = made.files.values()
    assert made.ok
    assert b"PROC LIFT(num M7)" in text
    rapid = languages.get("rapid")
    tree = rapid.parse("MODULE m\nPROC main(num a)\nTPWrite ValToStr(a);\nENDPROC\nENDMODULE\n")
    assert [finding.code for finding in rapid.check([tree])].count("RA235") == 1
