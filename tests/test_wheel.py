"""The wheel works where nothing but it is installed."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

PROJECT = Path(__file__).parent.parent


def run(*command: object, cwd: Path) -> str:
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=cwd, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    "dependencies", ["of these tests", pytest.param("of its own", marks=pytest.mark.slow)]
)
def test_a_sample_compiles_from_the_installed_wheel(tmp_path, dependencies):
    run(
        sys.executable,
        "-m",
        "build",
        "--wheel",
        "--no-isolation",
        "--outdir",
        tmp_path,
        PROJECT,
        cwd=tmp_path,
    )
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "empty")
    scripts = tmp_path / "empty" / ("Scripts" if sys.platform == "win32" else "bin")
    pip = (sys.executable, "-m", "pip", "--python", scripts / "python")
    if dependencies == "of its own":
        run(*pip, "install", "--quiet", wheel, cwd=tmp_path)
    else:
        run(*pip, "install", "--quiet", "--no-compile", "--no-deps", wheel, cwd=tmp_path)
        where = "import site; print(site.getsitepackages()[0])"
        site = Path(run(scripts / "python", "-c", where, cwd=tmp_path).strip())
        (site / "these.pth").write_text(sysconfig.get_path("purelib") + "\n")
    answer = run(
        scripts / "robot-assistant",
        "compile",
        PROJECT / "samples" / "plate.dxf",
        "--robot=irb1200-7-0.7",
        "--language=rapid",
        "--output=out",
        cwd=tmp_path,
    )
    assert "proven: " in answer
    assert (tmp_path / "out" / "plate.mod").read_bytes().startswith(b"MODULE plate")
    said = run(scripts / "robot-assistant", "explain", "RA204", cwd=tmp_path)
    assert "Better:" in said
    checked = run(scripts / "robot-assistant", "check", "out", cwd=tmp_path)
    assert checked.startswith("1 checked, ")
    where = run(
        scripts / "python", "-c", "import assistant; print(assistant.__file__)", cwd=tmp_path
    )
    assert str(tmp_path) in where
