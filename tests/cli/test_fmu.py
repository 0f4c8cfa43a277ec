"""`fmu`: an arm or a program as a file that other tools import."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest

from assistant.blocks.fmu.co_simulation import this_platform
from tests.blocks.code.compiled import compiler
from tests.cli.tables import each
from tests.cli.test_commands import run
from tests.robots.test_urdf import OFFSET, WRISTED

Capture = pytest.CaptureFixture[str]
SAMPLES = Path(__file__).parents[2] / "samples"
GLUING = str(SAMPLES / "rapid" / "gluing.mod")


def names(file: Path) -> list[str]:
    with zipfile.ZipFile(file) as archive:
        return archive.namelist()


def test_the_name_or_the_file_of_a_robot_gives_an_arm(capsys: Capture, tmp_path: Path) -> None:
    compiler()
    file = tmp_path / "arm.fmu"
    status, out, err = run(capsys, "fmu", "rv-2aj", "-o", str(file))
    assert (status, err) == (0, "")
    assert out.splitlines() == [
        "Mitsubishi RV-2AJ, simulated: 26 parameters, 14 inputs, 34 outputs",
        f"wrote {file}",
    ]
    assert f"binaries/{this_platform()}/rv_2aj_simulated.so" in names(file)
    own = tmp_path / "own.urdf"
    own.write_text(WRISTED, encoding="utf-8")
    status, out, _ = run(capsys, "fmu", own, "--lag", "0.05", "-o", file)
    assert status == 0 and out.startswith("own, simulated: 31 parameters")


def test_a_program_gives_its_motion(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "gluing.fmu"
    words = ("--robot", "irb1200-7-0.7", "--period", "0.05", "-o", str(file), "--format", "json")
    status, out, _ = run(capsys, "fmu", GLUING, *words)
    assert status == 0
    answer = json.loads(out)
    assert (answer["kind"], answer["identifier"]) == ("program", "gluing_played")
    assert answer["written"] == [str(file)]
    with zipfile.ZipFile(file) as archive:
        described = archive.read("modelDescription.xml").decode()
    assert answer["guid"] in described and 'stepSize="0.05"' in described


REFUSED = (
    ("own.urdf", (), "arm.fmu", 1, "BL301"),  # without a closed form
    ("rv-2aj", (), "arm.zip", 2, "CL560"),
    *(("rv-2aj", ("--lag", lag), "arm.fmu", 2, "--lag") for lag in ("inf", "nan", "-1", "1e300")),
    ("rv-2aj", ("--cycle", "0.01"), "arm.fmu", 2, "CL561"),
    ("rv-2aj", ("--period", "0.01"), "arm.fmu", 2, "CL561"),
    ("irb1200-7-0.7", ("--kind", "live"), "live.fmu", 1, "BL406"),
    (GLUING, ("--robot", "rv-2aj"), "gluing.fmu", 1, "is not written as an FMU"),  # out of reach
)


def test_what_cannot_be_a_block_is_refused(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.urdf").write_text(OFFSET, encoding="utf-8")

    def check(name: str, more: tuple[str, ...], file: str, status: int, code: str) -> None:
        ended, out, err = run(capsys, "fmu", name, *more, "-o", file)
        assert (ended, code in out + err) == (status, True)
        assert "error" in err.lower()
        assert [one.name for one in tmp_path.iterdir()] == ["own.urdf"]

    each(REFUSED, check)


def test_a_live_controller_has_its_own_cycle(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "live.fmu"
    words = ("--kind", "live", "-o", str(file), "--format", "json")
    status, out, _ = run(capsys, "fmu", "rv-4frl", *words)
    assert status == 0 and json.loads(out)["kind"] == "live"
    with zipfile.ZipFile(file) as archive:
        described = archive.read("modelDescription.xml").decode()
    assert 'stepSize="0.0035"' in described
    assert 'canHandleVariableCommunicationStepSize="false"' in described


def test_what_only_running_a_program_tells_is_said_not_to_be_played(
    capsys: Capture, tmp_path: Path
) -> None:
    words = ("-o", str(tmp_path / "pallet.fmu"), "--period", "0.05", "--format", "json")
    pallet = str(SAMPLES / "melfa" / "PALLET.prg")
    status, out, _ = run(capsys, "fmu", pallet, "--robot", "rv-4frl", *words)
    told = [one["message"] for one in json.loads(out)["findings"] if one["code"] == "BL408"]
    assert status == 0
    assert any("move 3 to `PTo`: only running the program tells" in one for one in told)
