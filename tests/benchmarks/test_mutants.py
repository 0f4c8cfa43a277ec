"""The exam of proofs: faults are made in translations, and most of them are found."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]


@pytest.mark.slow
def test_faults_of_translations_are_made_and_found() -> None:
    command = [sys.executable, "-m", "benchmarks", "--only", "proofs"]
    command += ["--programs", "2", "--mutants", "1"]
    said = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=True).stdout
    rows = {line[:34].strip(): line[34:].split() for line in said.splitlines() if line[34:].strip()}
    assert rows["a move dropped"] == ["2", "2", "100"]
    made, found, _ = map(int, rows["all"])
    left = said.partition("not found: ")[2].splitlines()
    assert 0.9 * made <= found and int(left[0]) == len(left[1:]) == made - found
