"""`make test` draws the same cases whatever was imported before."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).parent.parent
DRAWING = """
import os
from hypothesis import given, strategies as st
import {module}

@given(st.lists(st.integers() | st.floats() | st.text(), min_size=3))
def test_drawing(values):
    with open(os.environ["DRAWN"], "a", encoding="utf-8") as file:
        print(ascii(values), file=file)
"""


def draws(folder: Path, module: str) -> str:
    """What a property test draws that imports a module before."""
    folder.mkdir()
    drawn = folder / "drawn.txt"
    (folder / "test_drawing.py").write_text(DRAWING.format(module=module))
    (folder / "odd.py").write_text("values = [31415, 2.71828, 'a word that is nowhere else']\n")
    settings = ["-p", "tests.conftest", "-p", "no:cacheprovider", "-q", f"--rootdir={folder}"]
    subprocess.run(
        [sys.executable, "-m", "pytest", *settings, str(folder / "test_drawing.py")],
        cwd=PROJECT,
        env={
            **os.environ,
            "PYTEST_ADDOPTS": "",
            "PYTHONPATH": f"{PROJECT}{os.pathsep}{folder}",
            "DRAWN": str(drawn),
        },
        check=True,
    )
    return drawn.read_text("utf-8")


def test_draws_do_not_depend_on_the_modules_that_are_loaded(tmp_path):
    plain = draws(tmp_path / "plain", "json")
    assert plain == draws(tmp_path / "again", "odd") and len(plain.splitlines()) >= 20
