"""Work that several processes share: the same answers and files as from one."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.forks import PROJECT

SAMPLES = PROJECT / "samples"
slow = pytest.mark.slow
COMMANDS = (
    "check .",
    "translate one two --to rapid -o out",
    "fmt .",
    *(
        pytest.param(words, marks=slow)
        for words in (
            "check . --format sarif",
            "compile a.dxf no.dxf b.dxf -l rapid -r irb1200-7-0.7 -o out",
            "fmt --diff . no.mod",
        )
    ),
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Drawings, programs and a broken one."""
    for name in "ab":
        shutil.copy(SAMPLES / "plate.dxf", tmp_path / f"{name}.dxf")
        shutil.copy(SAMPLES / "plate.process.toml", tmp_path / f"{name}.process.toml")
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        shutil.copy(SAMPLES / "melfa/PALLET.prg", tmp_path / name)
    (tmp_path / "broken.mod").write_text("MODULE broken\nPROC main()\n  MoveL;\nENDPROC\n")
    (tmp_path / "long.mod").write_text(
        "MODULE long\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n"
    )
    return tmp_path


def answer(forks, folder: Path, words: str) -> tuple[object, ...]:
    """Status, output and files of a command, which works in a copy of the folder."""
    copy = folder.parent / "copy"
    shutil.copytree(folder, copy)
    done = forks.python("-m", "assistant", *words.split(), cwd=copy)
    files = {
        path.relative_to(copy): path.read_bytes() for path in copy.rglob("*.*") if path.is_file()
    }
    shutil.rmtree(copy)
    return done.returncode, done.stdout, done.stderr, files


@pytest.mark.parametrize("words", COMMANDS)
def test_two_processes_answer_as_one_does(forks, folder, words):
    alone = answer(forks, folder, f"{words} --jobs 1")
    assert answer(forks, folder, f"{words} --jobs 2") == tuple(
        part.replace("--jobs 1", "--jobs 2") if isinstance(part, str) else part for part in alone
    )


@slow
@pytest.mark.skipif(sys.platform != "linux", reason="it looks for processes as Linux lists them")
def test_a_worker_that_is_killed_costs_nothing(tmp_path):
    for number in range(6):
        shutil.copy(SAMPLES / "plate.dxf", tmp_path / f"d{number}.dxf")
    command = [sys.executable, "-m", "assistant", "check", ".", "--jobs"]
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    whole = subprocess.run([*command, "1"], cwd=tmp_path, env=environment, capture_output=True)
    process = subprocess.Popen(
        [*command, "2"],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    until = time.monotonic() + 60
    while not (workers := children(process.pid)):
        assert time.monotonic() < until and process.poll() is None
        time.sleep(0.01)
    os.kill(workers[0], signal.SIGKILL)
    said, errors = process.communicate()
    assert (process.returncode, said, errors) == (whole.returncode, whole.stdout, whole.stderr)


def children(parent: int) -> list[int]:
    """Processes that a process started and that still run."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended
        if int(fields[1]) == parent and fields[0] != "Z":
            found.append(int(path.parent.name))
    return found
