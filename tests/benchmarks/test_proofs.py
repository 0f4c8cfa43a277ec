"""The count of proofs over a folder of programs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_programs_of_a_folder_are_counted(tmp_path: Path) -> None:
    place = "(+400.00,{},+400.00,+180.00,+0.00,+180.00)(7,0)\n"
    data = "P1=" + place.format("+0.00") + "P2=" + place.format("+50.00")
    (tmp_path / "A.prg").write_text("1 Spd 100\n2 Mvs P1\n3 Mvs P2\n4 End\n" + data)
    (tmp_path / "B.prg").write_text("1 Spd 100\n2 XRun 2\n3 End\n" + data)
    (tmp_path / "C.prg").write_text("1 Spd 100\n2 Dly M_Fbd\n3 Mvs P1\n4 End\n" + data)
    command = [sys.executable, "-m", "benchmarks.proofs", str(tmp_path), "--to", "melfa-basic-6"]
    command += ["--from", "melfa-basic-5", "--runs", "2"]
    said = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=True).stdout
    assert "3 programs to melfa-basic-6" in said
    assert "3 cross whole, 1 of them (33 %) are proven by motion" in said
    assert "not run: there is no proof by motion: a program cannot be run here" in said
