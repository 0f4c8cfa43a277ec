"""The studio for a first visitor: seconds from the command's start until its page is there."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Any, Final

from docs.browsing import PLAIN, chromium, installed

RUNS: Final = 7
LIMIT: Final = 1.0
"""Seconds in which the page has to appear."""
PAINTED: Final = """() => performance.timeOrigin
  + (performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? NaN)"""
"""When the first text was seen, in ms since 1970."""
PARTS: Final = ("address", "page", "ready")


def report() -> None:
    """A line a part: when its address is told, its page seen, and its window ready to write."""
    print("\nThe studio of a new project: seconds from the start of the command\n")
    if installed() is None:
        print("there is no Chromium here")
        return
    with chromium(PLAIN) as opened:  # nothing is drawn yet that needs a graphics card
        _measured(opened)  # files of the system are in its memory then
        times = [_measured(opened) for _ in range(RUNS)]
    print(f"{'until':<12}{'best':>8}{'median':>8}{'worst':>8}{'over limit':>12}")
    for part, of_part in zip(PARTS, zip(*times, strict=True), strict=True):
        over = sum(seconds > LIMIT for seconds in of_part)
        middle = statistics.median(of_part)
        told = f"{min(of_part):>8.2f}{middle:>8.2f}{max(of_part):>8.2f}{over:>12}"
        print(f"{part:<12}{told}", flush=True)


def _measured(browser: Any) -> tuple[float, ...]:
    with tempfile.TemporaryDirectory() as folder:
        page = browser.new_page()
        start = time.time()
        command = [sys.executable, "-m", "assistant", "studio", folder, "--no-open"]
        process = subprocess.Popen(
            [*command, "--format", "json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        try:
            address = _address(process)
            told = time.time()
            page.goto(address)
            page.wait_for_selector("body.ready")
            ready = time.time()
            painted = page.evaluate(PAINTED) / 1000.0
        finally:
            process.terminate()
            process.communicate()
        page.close()
    return told - start, painted - start, ready - start


def _address(process: subprocess.Popen[bytes]) -> str:
    assert process.stdout is not None
    said = b""
    while not said.endswith(b"}\n"):
        said += process.stdout.readline()
    address: str = json.loads(said)["address"]
    return address
