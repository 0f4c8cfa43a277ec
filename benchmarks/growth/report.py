"""Measures every construct in every command, and prints those that grow the fastest."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from benchmarks.growth.construct import Construct
from benchmarks.growth.drawn import drawn
from benchmarks.growth.flows import flows
from benchmarks.growth.measuring import Growth, forked, grown, run
from benchmarks.growth.sources import sources

MOST: Final = 1.2
"""The exponent that no construct should exceed."""
WORST: Final = 10
"""Constructs that are printed."""
FIRST: Final = 1000
"""Of each construct at first."""
CHEAP: Final = 0.02
"""Seconds of CPU for FIRST below which more are not looked at: what is as quick as the noise."""
SIZES: Final = (1_000, 3_162, 10_000, 31_623, 100_000)
FEW: Final = (250, 1_000)
SHORT: Final = (
    "RAPID: semicolons on a line",
    "RAPID: routines of one name",
    "MELFA-BASIC: subroutines in a ring",
    "MELFA-BASIC: For in each other",
    "pseudo: labels and jumps",
)


@dataclass(frozen=True, slots=True)
class Plan:
    """only: part of a construct's name; seconds: of CPU that one run may take; runs: the best of
    how many counts. short: a handful of small ones.
    """

    only: str = ""
    seconds: float = 10.0
    runs: int = 5
    short: bool = False


def every() -> Iterator[Construct]:
    yield from flows()
    yield from sources()
    yield from drawn()


def report(plan: Plan) -> None:
    """Looks at all, measures what takes time, and prints the worst."""
    chosen = [
        one
        for one in (flows() if plan.short else every())
        if plan.only.lower() in one.name.lower() and (not plan.short or one.name in SHORT)
    ]
    pairs = [(one, command) for one in chosen for command in one.commands]
    print(f"{len(chosen):,} constructs, {len(pairs):,} times with a command\n", flush=True)
    print_worst([*_measured(pairs, plan)], len(pairs))


def _measured(pairs: Iterable[tuple[Construct, str]], plan: Plan) -> Iterator[Growth]:
    """Those that take time with FIRST of them; of the others nothing could be told."""
    bases: dict[tuple[str, str], float] = {}
    for at, (one, command) in enumerate(pairs):
        key = one.suffix, command
        if key not in bases:
            run(one, command, 1, _once)  # loads what the command needs, for all forks
            base = _forked(one, command, 1, plan.seconds)
            bases[key] = base if isinstance(base, float) else 0.0
        first = min(FIRST, one.largest or FIRST)
        took = _forked(one, command, first, plan.seconds)
        if isinstance(took, str):
            yield Growth(one.name, command, {}, f"{took} at {first:,}")
        elif took - bases[key] >= CHEAP:
            yield grown(one, command, FEW if plan.short else SIZES, plan.runs, plan.seconds)
        if sys.stderr.isatty():
            print(f"\r{at + 1:,}", end="", file=sys.stderr)


def _forked(one: Construct, command: str, n: int, seconds: float) -> float | str:
    return forked(lambda: run(one, command, n, _once), seconds)


def _once(work: Callable[[], object]) -> float:
    before = time.process_time()
    work()
    return time.process_time() - before


def print_worst(found: Sequence[Growth], count: int) -> None:
    """The worst first: what was ended, then by exponent."""
    ranked = sorted(found, key=lambda one: (not one.why, -_known(one.exponent)))
    print(f"{count:,} measured, {len(found):,} of them at several sizes; the worst {WORST}:\n")
    print(f"{'exponent':>9}{'largest':>10}{'seconds':>9}  command, construct")
    for one in ranked[:WORST]:
        largest = max(one.costs, default=0)
        seconds = one.costs.get(largest, math.nan)
        why = f" ({one.why})" if one.why else ""
        shown = f"{one.command}, {one.construct}{why}"
        print(f"{one.exponent:>9.2f}{largest:>10,}{seconds:>9.2f}  {shown}")
    over = [one for one in found if one.why or _known(one.exponent) > MOST]
    print(f"\n{len(over)} above {MOST}")


def _known(exponent: float) -> float:
    return 0.0 if math.isnan(exponent) else exponent
