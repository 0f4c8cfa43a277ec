"""The tutorial notebook runs, cell by cell, and shows what it has stored."""

from __future__ import annotations

import shutil
from pathlib import Path

from docs import tutorial
from tests.forks import Forks

PROJECT = Path(__file__).parent.parent
SHOWS = """\
from docs import tutorial
for shown in tutorial.run(tutorial.read()):
    print([sorted(one.get("data", {"stream": 0})) for one in shown])
"""


def test_the_cells_of_the_tutorial_run_in_a_new_process(tmp_path: Path, forks: Forks) -> None:
    """Without IPython, which is not among what the tests need."""
    shutil.copytree(PROJECT / "samples", tmp_path / "samples")
    script = tmp_path / "shows.py"
    script.write_text(f"import sys; sys.path.append({str(PROJECT)!r})\n{SHOWS}", "utf-8")
    done = forks.python(str(script), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    stored = [
        [sorted(one.get("data", {"stream": 0})) for one in cell["outputs"]]
        for cell in tutorial.code(tutorial.read())
    ]
    assert done.stdout.splitlines() == [str(one) for one in stored]
    assert sum("image/png" in kinds for cell in stored for kinds in cell) == 3
    assert sum("text/html" in kinds for cell in stored for kinds in cell) >= 6


def test_the_tutorial_is_a_notebook_without_scripts() -> None:
    notebook = tutorial.read()
    assert notebook["nbformat"] == 4 and len({cell["id"] for cell in notebook["cells"]}) == len(
        notebook["cells"]
    )
    text = tutorial.NOTEBOOK.read_text("utf-8")
    assert "<script" not in text and str(PROJECT) not in text
    assert tutorial.NOTEBOOK.stat().st_size < 200 * 1024
