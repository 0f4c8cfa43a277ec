"""`fmu`: an arm or a program as a file that other tools import."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest

from assistant.blocks.fmu.co_simulation import this_platform
from tests.blocks.code.compiled import compiler
from tests.cli.test_commands import run
from tests.robots.test_urdf import OFFSET, WRISTED

Capture = pytest.CaptureFixture[str]
SAMPLES = Path(__file__).parents[2] / "samples"
GLUING = str(SAMPLES / "rapid" / "gluing.mod")


def names(file: Path) -> list[str]:
    with zipfile.ZipFile(file) as archive:
        return archive.namelist()


def test_the_name_of_a_robot_gives_an_arm(capsys: Capture, tmp_path: Path) -> None:
    compiler()
    file = tmp_path / "arm.fmu"
    status, out, err = run(capsys, "fmu", "rv-2aj", "-o", str(file))
    assert (status, err) == (0, "")
    assert out.splitlines() == [
        "Mitsubishi RV-2AJ, simulated: 26 parameters, 14 inputs, 34 outputs",
        f"wrote {file}",
    ]
    assert f"binaries/{this_platform()}/rv_2aj_simulated.so" in names(file)


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


def test_the_file_of_a_robot_is_an_arm(capsys: Capture, tmp_path: Path) -> None:
    own = tmp_path / "own.urdf"
    own.write_text(WRISTED, encoding="utf-8")
    status, out, _ = run(capsys, "fmu", str(own), "--lag", "0.05", "-o", str(tmp_path / "a.fmu"))
    assert status == 0 and out.startswith("own, simulated: 31 parameters")


def test_an_arm_without_a_closed_form_is_refused(capsys: Capture, tmp_path: Path) -> None:
    own = tmp_path / "own.urdf"
    own.write_text(OFFSET, encoding="utf-8")
    status, _, err = run(capsys, "fmu", str(own), "-o", str(tmp_path / "a.fmu"))
    assert status == 1 and "BL301" in err
    assert not (tmp_path / "a.fmu").exists()


def test_a_program_out_of_reach_is_not_written(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "gluing.fmu"
    status, out, err = run(capsys, "fmu", GLUING, "--robot", "rv-2aj", "-o", str(file))
    assert status == 1 and "error" in err and "is not written as an FMU" in out
    assert not file.exists()


def test_a_file_of_another_kind_is_refused(capsys: Capture, tmp_path: Path) -> None:
    status, _, err = run(capsys, "fmu", "rv-2aj", "-o", str(tmp_path / "arm.zip"))
    assert status == 2 and "CL560" in err


@pytest.mark.parametrize("lag", ["inf", "nan", "-1", "1e300"])
def test_a_lag_that_is_none_is_refused(capsys: Capture, tmp_path: Path, lag: str) -> None:
    status, _, err = run(capsys, "fmu", "rv-2aj", "--lag", lag, "-o", str(tmp_path / "a.fmu"))
    assert status == 2 and "--lag" in err
    assert list(tmp_path.iterdir()) == []


def test_a_live_controller_has_its_own_cycle(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "live.fmu"
    words = ("--kind", "live", "-o", str(file), "--format", "json")
    status, out, _ = run(capsys, "fmu", "rv-4frl", *words)
    assert status == 0 and json.loads(out)["kind"] == "live"
    with zipfile.ZipFile(file) as archive:
        described = archive.read("modelDescription.xml").decode()
    assert 'stepSize="0.0035"' in described
    assert 'canHandleVariableCommunicationStepSize="false"' in described


def test_a_live_arm_of_another_maker_is_refused(capsys: Capture, tmp_path: Path) -> None:
    words = ("--kind", "live", "-o", str(tmp_path / "live.fmu"))
    status, _, err = run(capsys, "fmu", "irb1200-7-0.7", *words)
    assert status == 1 and "BL406" in err


@pytest.mark.parametrize("option", [("--cycle", "0.01"), ("--period", "0.01")])
def test_an_option_of_another_kind_is_refused(capsys: Capture, tmp_path: Path, option) -> None:
    output = tmp_path / "arm.fmu"
    status, _, said = run(capsys, "fmu", "rv-2aj", "-o", output, *option)
    assert (status, "CL561" in said, output.exists()) == (2, True, False)


def test_what_only_running_a_program_tells_is_said_not_to_be_played(
    capsys: Capture, tmp_path: Path
) -> None:
    words = ("-o", str(tmp_path / "pallet.fmu"), "--period", "0.05", "--format", "json")
    pallet = str(SAMPLES / "melfa" / "PALLET.prg")
    status, out, _ = run(capsys, "fmu", pallet, "--robot", "rv-4frl", *words)
    told = [one["message"] for one in json.loads(out)["findings"] if one["code"] == "BL408"]
    assert status == 0
    assert any("move 3 to `PTo`: only running the program tells" in one for one in told)
