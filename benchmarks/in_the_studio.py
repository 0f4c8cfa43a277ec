"""Typing in the studio: milliseconds from a key on the page to the answer of its server."""

from __future__ import annotations

import json
import statistics
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from benchmarks.editing import LIMIT, SUFFIXES, TITLES, keys, program
from tests.studio.serving import Page, served

LINES: Final = 5000
PLACES: Final = 6
SEEN: Final = 60
"""Lines of the text that the page shows."""


def report() -> None:
    """A line a language: findings and colours of each key, by the server that people start."""
    print("\nThe same in the studio, with the colours of the lines that are seen\n")
    print(f"{'language':<20}{'keys':>8}{'median':>10}{'95 %':>10}{'worst':>10}{'over limit':>12}")
    for language, title in TITLES.items():
        times = measured(language)
        over = sum(one > LIMIT for one in times)
        print(
            f"{title:<20}{len(times):>8,}{statistics.median(times):>10.1f}"
            f"{statistics.quantiles(times, n=20)[-1]:>10.1f}{max(times):>10.1f}{over:>12,}",
            flush=True,
        )


def measured(language: str, lines: int = LINES, places: int = PLACES) -> list[float]:
    """Milliseconds of each key."""
    name, text = f"typed.{SUFFIXES[language]}", program(language, lines)
    times = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, name).write_text(text, encoding="ascii")
        with _asking(folder) as ask:
            ask("open_text", {"path": name})
            ask("settled", {"path": name, "version": 0})
            for version, change in enumerate(keys(text, places), 1):
                start, end = change.range.start, change.range.end
                made = {
                    "from": [start.line, start.column],
                    "to": [end.line, end.column],
                    "text": change.text,
                }
                seen = {"first": start.line, "last": start.line + SEEN}
                begin = time.perf_counter()
                ask("change", {"path": name, "version": version, "changes": [made], **seen})
                times.append(1000 * (time.perf_counter() - begin))
    return times


@contextmanager
def _asking(folder: str) -> Iterator[Any]:
    """A window of a studio, by what it asks of its texts."""
    with served(Path(folder)) as address:
        page = Page(address)
        with page.line():
            parts = urlsplit(address)
            kept = HTTPConnection(parts.netloc, timeout=120)
            told = {"Origin": page.origin, "X-Window": page.window}
            told["Content-Type"] = "application/json"

            def ask(what: str, values: Mapping[str, Any]) -> Any:
                kept.request("POST", f"{parts.path}text/{what}", json.dumps(values), told)
                answer = kept.getresponse()
                value = json.loads(answer.read())
                assert answer.status == 200, value
                return value

            yield ask
            kept.close()
