"""A key that is let go, beats that stay away, a link that is cut: when the arm stood.

python -m benchmarks.letting_go 6 prints milliseconds, by the record of the virtual controller.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from assistant.virtual.cr import VirtualCr
from tests.studio.cells import BENCHES, Bench
from tests.studio.serving import Page, served
from tests.studio.test_control import STEP, recorded, slowly, taken

WAYS = ("let go", "beats stay away", "link cut")


def main() -> None:
    times = int(sys.argv[1]) if len(sys.argv) > 1 else 6
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, "cell")
        folder.mkdir()
        with BENCHES["cr"](folder, Path(place, "home")) as bench, served(folder) as address:
            for way in WAYS:
                took = [1000 * measured(bench, address, way) for _ in range(times)]
                print(f"{way}: stood after {min(took):.0f} to {max(took):.0f} ms, {times} times")


def measured(bench: Bench, address: str, way: str) -> float:
    """Seconds from what ends the motion to the last change of a joint; a step would last 1.2 s."""
    cell, page = bench.cell, Page(address)
    assert isinstance(cell, VirtualCr)
    with recorded(cell) as record, page.line() as line:
        while not page.writes:
            page.hear(line)
        window = taken(page, line)
        slowly(bench)
        cell.state.joints = (0.0, *cell.state.joints[1:])
        window.press_until(lambda: record.now > STEP / 10)
        if way == "let go":
            window.answer(1, hold=0)
        ended = time.monotonic()
        if way == "let go":
            window.answer(10, hold=0)
        elif way == "link cut":
            line.socket.close()
        record.until_it_stands()
        took = record.last_motion() - ended
    while cell.state.servo:
        time.sleep(0.02)
    return took


if __name__ == "__main__":
    main()
