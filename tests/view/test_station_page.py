"""The page of a drawing with bodies, in a real browser: arm, path and bodies are to be seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_commands import run
from tests.view.test_browser import browser, picture, until

__all__ = ["browser"]

CELL = Path(__file__).parents[2] / "samples" / "cell"


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["rv-2aj", "irb1200-7-0.7"])
def test_arm_and_path_around_the_bodies_are_in_the_picture(
    robot: str, browser: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("coal")
    pytest.importorskip("ompl")
    out, cell = tmp_path / "station.html", CELL / f"station-{robot}.toml"
    run(capsys, "view", CELL / "station.dxf", "--cell", cell, "--html", out)
    capsys.readouterr()
    page = browser.new_page(viewport={"width": 800, "height": 500})
    wrong: list[str] = []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda fault: wrong.append(str(fault)))
    page.goto(out.as_uri())
    until(page, "view.drawn() > 0")
    seen = picture(page)
    red, green, blue = np.moveaxis(seen, 2, 0)
    assert ((red > 1.3 * green) & (green > 1.3 * blue)).sum() > 5000  # orange links
    assert ((red > 3.0 * green) & (red > 3.0 * blue)).sum() > 300  # the red wall
    page.get_by_label("path of the tool").uncheck()
    changed = np.abs(seen - picture(page)).max(axis=2) > 0.05
    assert 50 < changed.sum() < 0.05 * changed.size  # a line, and nothing else
    assert np.ptp(np.flatnonzero(changed.any(axis=0))) > 50
    page.close()
    assert wrong == []
