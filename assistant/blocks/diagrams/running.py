"""Runs of a diagram: all blocks step by step, their signals in columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.blocks.diagrams import rules
from assistant.blocks.diagrams.block import Block, Port, signal
from assistant.blocks.diagrams.clocks import RunClock, Simulated
from assistant.blocks.diagrams.diagram import Diagram, StepOrder

MOST_STEPS: Final = 10_000_000
LATE_SHARE: Final = 0.5
"""Part of a step by which one is late that counts as late."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RunResult:
    """What a run gave.

    seconds: (n,) of its steps. columns: (n, k) by `block.port`. lateness: (n,) seconds that each
    step began late. late: how many by more than half a step.
    """

    seconds: Floats
    columns: Mapping[str, Floats]
    lateness: Floats
    late: int
    findings: tuple[Diagnostic, ...] = ()

    def __repr__(self) -> str:
        end = float(self.seconds[-1]) if len(self.seconds) else 0.0
        told = f"{len(self.columns)} signals, {len(self.seconds)} steps to {end:g} s"
        return f"<Ran {told}, {self.late} late>"

    def _repr_html_(self) -> str:
        from assistant.blocks.showing.columns import signals_html

        return signals_html(self)

    def _repr_png_(self) -> bytes | None:
        """Signals over time; None without matplotlib."""
        from assistant.blocks.showing.pictures import run_png

        return run_png(self)

    def __getitem__(self, name: str) -> Floats:
        """The signal of a port, `block.port`, (n,) where it is a single number."""
        found = self.columns[name]
        return found[:, 0] if found.shape[1] == 1 else found

    def flat(self) -> dict[str, Floats]:
        """(n,) columns, `block.port` or `block.port.1` …, as recordings are saved."""
        columns = {"seconds": self.seconds}
        for name, values in self.columns.items():
            width = values.shape[1]
            names = [name] if width == 1 else [f"{name}.{i}" for i in range(1, width + 1)]
            columns.update(zip(names, values.T, strict=True))
        return columns


def run(
    diagram: Diagram,
    seconds: float,
    step: float,
    *,
    clock: RunClock | None = None,
    watch: Callable[[float], bool] | None = None,
    moving: Iterable[str] = (),
) -> RunResult:
    """Steps a diagram from 0 to so many seconds.

    moving: names of the controllers whose arms somebody confirmed that it moves.
    clock: `Simulated` if left out, or `RealTime`. watch: is asked before each step, with its time;
    False ends the run. Whatever happens, every block that was begun is ended.
    Raises Refused for a diagram that cannot run, and for a block that fails.
    """
    count = step_count(seconds, step)
    plan = diagram.plan()
    check_confirmed(plan.order, confirmed_names(moving))
    clock = clock or Simulated()
    stepper, recorder = _Stepper(plan, step), _Recorder(plan.order, count)
    with closing_all() as open_blocks:
        for block in plan.order:
            open_blocks.callback(block.end)
            with errors_with_block(block, 0.0):
                block.begin()
        clock.begin()
        for number in range(count):
            now = number * step
            late = clock.reach(now)
            if watch is not None and not watch(now):
                break
            stepper.step(number, now)
            recorder.add(now, late, stepper.signals)
    return recorder.ran(step, plan.findings)


def step_count(seconds: float, step: float) -> int:
    """Steps of a run, the one at 0 s among them; raises Refused."""
    if not 0.0 < step < np.inf:
        raise Refused(rules.BAD_STEP(what="a step", value=step, cure="give seconds above 0"))
    if not 0.0 <= seconds / step < MOST_STEPS:
        cure = f"give 0 s or more, and at most {MOST_STEPS:,} steps"
        raise Refused(rules.BAD_STEP(what="the run", value=seconds, cure=cure))
    return int(np.floor(seconds / step + 1e-9)) + 1


def confirmed_names(moving: Iterable[str]) -> frozenset[str]:
    """Names of controllers whose arms may move; a text by itself is one name."""
    return frozenset([moving] if isinstance(moving, str) else moving)


def check_confirmed(blocks: Iterable[Block], names: frozenset[str]) -> None:
    """Raises Refused for blocks that move an arm which is not among the names."""
    wanting = [block for block in blocks if block.moves and block.moves not in names]
    if wanting:
        told = (rules.MOTION_NOT_CONFIRMED(block=one.name, name=one.moves) for one in wanting)
        raise Refused(*told, exit_status=2)


@contextmanager
def closing_all() -> Iterator[ExitStack]:
    """For what is ended behind a run, each of it whatever the others raise.

    What ended the run is told first, and behind it what its end met.
    """
    first: Refused | None = None
    try:
        with ExitStack() as ends:
            try:
                yield ends
            except Refused as refused:
                first = refused
                raise
    except Exception as last:
        if first is None or last is first:
            raise
        met = last.findings if isinstance(last, Refused) else ()
        more = (one for one in met if one not in first.findings)
        raise Refused(*first.findings, *more, exit_status=first.exit_status) from last


@contextmanager
def errors_with_block(block: Block, now: float) -> Iterator[None]:
    """What a block raises is told with its name and the moment; a Refused says it already."""
    try:
        yield
    except Refused:
        raise
    except Exception as error:
        reason = str(error) or type(error).__name__
        if not isinstance(error, ValueError | ArithmeticError):
            reason = f"{type(error).__name__}: {error}"
        raise Refused(rules.BLOCK_FAILED(name=block.name, now=now, reason=reason)) from error


class _Stepper:
    """signals: of each block by now, one array an output."""

    def __init__(self, plan: StepOrder, step: float) -> None:
        self._plan = plan
        self.signals: dict[Block, tuple[Floats, ...]] = {
            block: tuple(np.zeros(port.size) for port in block.outputs) for block in plan.order
        }
        self._every = {block: _steps_per_block_step(block, step) for block in plan.order}

    def step(self, number: int, now: float) -> None:
        due = [block for block in self._plan.order if number % self._every[block] == 0]
        for block in due:
            given = self._given(block) if block.direct else ()
            self.signals[block] = block_outputs(block, now, given)
        for block in due:
            with errors_with_block(block, now):
                block.take(now, self._given(block))

    def _given(self, block: Block) -> tuple[Floats, ...]:
        return tuple(self.signals[start][number] for start, number in self._plan.sources[block])


def _steps_per_block_step(block: Block, step: float) -> int:
    """Steps of the diagram from one step of a block to its next."""
    if block.period is None:
        return 1
    count = round(block.period / step) if math.isfinite(block.period) else 0
    if count < 1 or abs(count * step - block.period) > 1e-6 * block.period:
        cure = f"let it be a multiple of the step of {step:g} s"
        what = f"the period of `{block.name}`"
        raise Refused(rules.BAD_STEP(what=what, value=block.period, cure=cure))
    return count


def block_outputs(block: Block, now: float, given: Sequence[Floats]) -> tuple[Floats, ...]:
    """What a block gives, one signal a port; raises Refused with its name."""
    with errors_with_block(block, now):
        values = tuple(block.give(now, given))
        if len(values) != len(block.outputs):
            raise ValueError(f"{len(values)} signals for {len(block.outputs)} outputs")
        return tuple(signal(v, port) for v, port in zip(values, block.outputs, strict=True))


@dataclass(slots=True, eq=False)
class _Recorder:
    order: Sequence[Block]
    count: int
    rows: int = 0
    table: Floats = field(init=False)

    def __post_init__(self) -> None:
        width = 2 + sum(port.size for _, port in self._ports())
        self.table = np.empty((self.count, width))

    def _ports(self) -> Sequence[tuple[Block, Port]]:
        return [(block, port) for block in self.order for port in block.outputs]

    def add(self, now: float, late: float, signals: Mapping[Block, Sequence[Floats]]) -> None:
        row = [np.array([now, late])]
        row += [one for block in self.order for one in signals[block]]
        self.table[self.rows] = np.concatenate(row)
        self.rows += 1

    def ran(self, step: float, findings: tuple[Diagnostic, ...]) -> RunResult:
        table = self.table[: self.rows]
        columns, place = {}, 2
        for block, port in self._ports():
            columns[f"{block.name}.{port.name}"] = table[:, place : place + port.size]
            place += port.size
        late = int((table[:, 1] > LATE_SHARE * step).sum())
        return RunResult(table[:, 0], columns, table[:, 1], late, findings)
