"""Findings while one types: milliseconds from a key to the findings of a module of 5,000 lines."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from typing import Final

from assistant.base.budgets import freeze_loaded_objects
from assistant.editing import service
from assistant.editing.service import Change, Place, Range, Workspace
from benchmarks.code import code

LINES: Final = 5000
LIMIT: Final = 100.0
"""Milliseconds in which the findings of a key have to be there."""
PLACES: Final = 12
TITLES: Final = {"rapid": "RAPID", "melfa-basic-5": "MELFA-BASIC V", "pseudo": "pseudo-program"}
SUFFIXES: Final = {"rapid": "mod", "melfa-basic-5": "mb5", "pseudo": "pseudo"}


def report() -> None:
    """A line a language: of each key the time to its findings, damaged states among them."""
    print(f"\nTyping in a program of {LINES:,} lines: milliseconds from a key to its findings\n")
    head = f"{'keys':>8}{'median':>10}{'95 %':>10}{'worst':>10}{'over limit':>12}{'whole (s)':>12}"
    print(f"{'language':<20}{head}")
    for language, title in TITLES.items():
        whole, times = measured(language, LINES, PLACES)
        worst, over = max(times), sum(one > LIMIT for one in times)
        share = statistics.quantiles(times, n=20)[-1]
        print(
            f"{title:<20}{len(times):>8,}{statistics.median(times):>10.1f}{share:>10.1f}"
            f"{worst:>10.1f}{over:>12,}{whole:>12.2f}",
            flush=True,
        )


def measured(language: str, lines: int, places: int) -> tuple[float, list[float]]:
    """Seconds of a look at the whole, and milliseconds of each key at some places of the text."""
    text, workspace = program(language, lines), Workspace()
    document = workspace.open(f"/nowhere/typed.{SUFFIXES[language]}", text)
    start = time.perf_counter()
    service.settled(document)
    whole = time.perf_counter() - start
    freeze_loaded_objects()  # as the language server does
    times = []
    for change in keys(text, places):
        document = workspace.change(document.path, [change], document.version + 1)
        start = time.perf_counter()
        service.findings(document)
        times.append(1000 * (time.perf_counter() - start))
    return whole, times


def keys(text: str, places: int) -> Iterator[Change]:
    """Lines are typed anew, a key at a time: the end of each is taken off, and written again."""
    lines = text.splitlines()
    chosen = [n for n, line in enumerate(lines) if len(line.strip()) > 12 and line.isascii()]
    for number in chosen[:: max(len(chosen) // places, 1)][:places]:
        line = lines[number]
        cut = max(len(line) - 8, 1)
        yield Change(Range(Place(number, cut), Place(number, len(line))), "")
        for column in range(cut, len(line)):
            yield Change(Range(Place(number, column), Place(number, column)), line[column])


def program(language: str, lines: int) -> str:
    """Ordinary code, no two lines alike."""
    if language != "pseudo":
        (data,) = code(language, lines).values()
        return data.decode("ascii")
    count = PSEUDO.count("\n")
    copies = (PSEUDO.replace("%", str(copy)) for copy in range(1, lines // count + 1))
    return "program typed\n\n" + "\n".join(copies)


PSEUDO: Final = """\
target p% [400, %, 300] [0, 0, 1, 0]
variable count% number = %
signal valve% digital output %
procedure part%
  count% = count% + %
  if count% > %
    move joint p% speed 200 mm/s blend fine
    move linear offset(p%, 0, 0, %) speed 50 mm/s blend fine
  else
    set valve% = 1
    wait 0.% s
  end
  for i from 1 to %
    message "part %"
    call part%
  end
end
"""
