"""The studio with a long program: frames a second while its text scrolls and its scene scrubs."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from docs.browsing import WITHOUT_CARD, chromium, installed

MOVES: Final = 10_000
SECONDS: Final = 5.0
"""That each of them is counted."""
LEAST: Final = 30.0
"""Frames a second that are promised."""
PATIENCE: Final = 600_000.0
"""ms until a page shows the program on a slow machine."""
SIZE: Final[Any] = {"width": 1280, "height": 800}
HOSTED: Final = "document.querySelector('#scene iframe')?.contentWindow"

COUNTED: Final = """
([seconds, step]) => new Promise((resolve) => {
  const does = new Function("part", step), times = [];
  const frame = (at) => {
    times.push(at);
    const gone = (at - times[0]) / 1000;
    if (gone >= seconds) { resolve(times); return; }
    does(gone / seconds);
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
})
"""
SCRUBS: Final = "view.setTime(view.seconds * part);"
SCROLLS: Final = """
const one = document.querySelector("#editor .cm-scroller");
one.scrollTop = (one.scrollHeight - one.clientHeight) * part;
"""

PROJECT: Final = """\
[programs.long]
source = "long.mod"
robot = "irb1200-7-0.7"
cell = "cell.toml"
"""
CELL: Final = """\
[robots.arm]
robot = "irb1200-7-0.7"

[bodies.table]
box = [400, 400, 20]
position = [420, 0, 100]
"""


def report(moves: int = MOVES) -> None:
    print(f"\nStudio: a program of {moves:,} moves in a browser that draws without a card\n")
    if installed() is None:
        print("there is no Chromium here")
        return
    with tempfile.TemporaryDirectory() as name, _window(_project(Path(name), moves)) as window:
        begun = time.perf_counter()
        window.get_by_role("treeitem", name="long.mod").click()
        window.wait_for_function(f"{HOSTED}?.view?.drawn() > 0", timeout=PATIENCE)
        window.wait_for_function("!document.querySelector('#drag-state').textContent")
        print(f"{'scene shown after':<40}{time.perf_counter() - begun:>10.1f} s")
        window.wait_for_timeout(3_000)
        inner = window.locator("#scene iframe").element_handle().content_frame()
        for what, frame, step in (
            ("frames a second, scene scrubs", inner, SCRUBS),
            ("frames a second, text scrolls", window.main_frame, SCROLLS),
        ):
            before = _used(window)
            times = frame.evaluate(COUNTED, [SECONDS, step])
            count, used = len(times) - 1, _used(window) - before
            rate = 1000.0 * count / (times[-1] - times[0])
            longest = max(b - a for a, b in pairwise(times))
            said = (
                f"the longest {longest:.0f} ms, {1000.0 * used / count:.0f} ms of processors each"
            )
            short = "" if rate >= LEAST else f"; below {LEAST:g}"
            print(f"{what:<40}{rate:>10.1f}, {said}{short}", flush=True)


def _used(window: Any) -> float:
    """Seconds that processors have spent on the page: where others are at work, frames wait."""
    line = window.context.browser.new_browser_cdp_session()
    told = line.send("SystemInfo.getProcessInfo")["processInfo"]
    line.detach()
    return float(sum(one["cpuTime"] for one in told if one["type"].lower() in ("gpu", "renderer")))


def _project(folder: Path, moves: int) -> Path:
    (folder / "assistant.toml").write_text(PROJECT)
    (folder / "cell.toml").write_text(CELL)
    (folder / "long.mod").write_text(program(moves))
    return folder


def program(moves: int) -> str:
    """Targets on a spiral above a table, no two alike, and a line to each."""
    data, lines = [], []
    for i in range(moves):
        angle, wide = 2.0 * math.pi * i / 400.0, 1.0 - i / (2.0 * moves)
        x, y = 420.0 + 80.0 * wide * math.cos(angle), 150.0 * wide * math.sin(angle)
        arm = "-1,0,-1" if y < 0.0 else "0,0,0"
        place = f"[{x:.3f},{y:.3f},{250.0 + 100.0 * i / moves:.3f}]"
        data.append(
            f"  CONST robtarget p{i}:=[{place},[0,0,1,0],[{arm},0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
        )
        lines.append(f"    Move{'L' if i else 'J'} p{i},v200,z1,tool0;\n")
    return f"MODULE long\n{''.join(data)}  PROC main()\n{''.join(lines)}  ENDPROC\nENDMODULE\n"


@contextmanager
def _window(folder: Path) -> Iterator[Any]:
    from tests.studio.serving import served

    with served(folder) as address, chromium(WITHOUT_CARD) as browser:
        page = browser.new_page(viewport=SIZE, bypass_csp=True)
        page.set_default_timeout(PATIENCE)
        page.goto(address)
        page.wait_for_selector("body.ready")
        yield page
