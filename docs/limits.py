"""Prints `limits.md`, a page about what may be how large and take how long, from the table itself.

python -m docs.limits > docs/limits.md
"""

from __future__ import annotations

import sys
from collections.abc import Iterable

from assistant.base.budgets import (
    FACTOR_VARIABLE,
    FACTORS,
    FILE,
    MEGABYTE,
    PART_OF_MACHINE,
    SETTINGS_FILE,
    STAGES,
    UNPACKED,
)
from assistant.sources.drawing.traversal import MOST_ENTITIES, MOST_NESTED

HEAD = """\
# Limits

Whatever a file holds, reading and working on it comes to an end. What is larger than it may be, or
takes longer than its budget, is a finding (`IN009`, `IN010` and [those of
limits](findings.md#limits)); nothing is written of it, and other files are worked on.

## Files

Only regular files are read: no command waits at a named pipe, or reads a device. A robot program
may come on standard input, as `-`. Sizes are looked at before a file is read and while it is, as
it may grow, and those of an archive before it is unpacked.
"""
BUDGETS = """\
## Budgets

Each stage may take so much processor time and memory: a fixed part, and more for each million
units of its input. Reading, checking, lifting and laying out have 5 to 10 times what they need for
samples of 1,000 to 1,000,000 units; what follows in the table has more, as its need differs more.
Time counts in the thread that works, so that a busy machine changes nothing. Memory is what the
process has more than before the stage; on macOS what it ever had more.
No stage may take more than {part:.0%} of the memory of the machine. A `travel to` that is planned
counts as 5,000 points of compiling.
Calculating in one step of a library, such as numpy, ends before either is looked at; one that would
take all memory at once is refused on Linux, by the limit of a process's data.
"""
RAISING = """\
## Raising them

`--budget` before the command multiplies all of them: sizes, time and memory. So does the variable
`{variable}` of the environment, for servers and pipelines; if both are there, the
option counts.

```console
$ robot-assistant --budget 10 check samples/positioning.csv
```

From {least:g} to {most:,.0f}. Processes that a command starts, such as those of `build`, have the
same factor, and so have virtual controllers: there a file that a client stores is read within a
budget of its own, so that none keeps the others waiting.
"""


def page() -> str:
    """Sizes, then the budgets of all stages, then how to raise them."""
    sizes = (
        ("a program, drawing, table, archive, or standard input", _megabytes(FILE)),
        ("settings: processes, robots, projects, scripts", _megabytes(SETTINGS_FILE)),
        ("what an NPZ archive unpacks to", _megabytes(UNPACKED)),
        ("entities of a drawing with all its inserts, counted beforehand", f"{MOST_ENTITIES:,}"),
        ("blocks in each other", f"{MOST_NESTED}"),
    )
    rows = (
        f"| {stage.name} | {stage.unit} | {stage.seconds:g} s + {stage.more_seconds:,g} s "
        f"| {stage.megabytes:,g} MB + {stage.more_megabytes:,g} MB |"
        for stage in STAGES
    )
    least, most = FACTORS
    parts = (
        HEAD,
        _table(("what", "most"), (f"| {what} | {size} |" for what, size in sizes)),
        BUDGETS.format(part=PART_OF_MACHINE),
        _table(("stage", "a million of", "processor time", "memory"), rows),
        RAISING.format(variable=FACTOR_VARIABLE, least=least, most=most),
    )
    return "\n".join(parts)


def _table(heads: tuple[str, ...], rows: Iterable[str]) -> str:
    line = "| " + " | ".join(heads) + " |"
    return "\n".join([line, "|---" * len(heads) + "|", *rows, ""])


def _megabytes(size: int) -> str:
    return f"{size // MEGABYTE:,} MB"


if __name__ == "__main__":
    sys.stdout.write(page())
