"""Runs of bdsim diagrams: by bdsim itself, or step by step at a pace of ours."""

from __future__ import annotations

import contextlib
import io
import math
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams.clocks import RunClock, Simulated
from assistant.blocks.diagrams.rules import BAD_STEP
from assistant.blocks.diagrams.running import (
    LATE_SHARE,
    RunResult,
    check_confirmed,
    closing_all,
    confirmed_names,
    step_count,
)
from assistant.blocks.library.adapted import CONFIRMED

if TYPE_CHECKING:
    from bdsim import BDSim
    from bdsim.blockdiagram import BlockDiagram


def run_bdsim(
    sim: BDSim,
    diagram: BlockDiagram,
    seconds: float,
    *,
    clock: RunClock | None = None,
    moving: Iterable[str] = (),
    **options: Any,
) -> Any:
    """What `sim.run` gives; blocks that hold connections are ended whatever happens.

    clock: is waited for before each moment that bdsim evaluates: `LockStep` has controllers keep
    step. moving: names of the controllers whose arms somebody confirmed that it moves. options: of
    `BDSim.run`. Raises Refused for an arm that is not among them.
    """
    if not diagram.compiled:
        _compile_quietly(diagram)
    with closing_all() as ends, _confirmed(diagram, moving), _paced_by(diagram, clock):
        _end_blocks_after(diagram, ends)
        return sim.run(diagram, T=seconds, **options)


def run_paced(
    sim: BDSim,
    diagram: BlockDiagram,
    seconds: float,
    step: float,
    *,
    clock: RunClock | None = None,
    watch: Callable[[float], bool] | None = None,
    moving: Iterable[str] = (),
) -> RunResult:
    """Steps a bdsim diagram at a fixed step, in real time if `clock` is `RealTime`.

    What is continuous in it is integrated by the classical method of Runge and Kutta; clocks tick
    at the steps. Signals are recorded as columns, `block[port]`, of ports that give numbers.
    See `diagrams.running.run` for the rest.
    """
    count = step_count(seconds, step)
    clock = clock or Simulated()
    if not diagram.compiled:
        _compile_quietly(diagram)
    stepping = _SteppedDiagram(sim, diagram, step)
    with closing_all() as ends, _confirmed(diagram, moving):
        _end_blocks_after(diagram, ends)
        stepping.begin(seconds)
        clock.begin()
        for number in range(count):
            now = number * step
            late = clock.reach(now)
            if watch is not None and not watch(now):
                break
            if not stepping.step(number, now, late):
                break
    return stepping.ran()


def _compile_quietly(diagram: BlockDiagram) -> None:
    """Without what bdsim prints of outputs that nobody asks for."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            diagram.compile(verbose=False)
    finally:
        lines = said.getvalue().splitlines(keepends=True)
        told = (line for line in lines if not line.lstrip().startswith("INFORMATION"))
        sys.stdout.write("".join(told))


@contextlib.contextmanager
def _confirmed(diagram: BlockDiagram, names: Iterable[str]) -> Iterator[None]:
    """Raises Refused before anything begins; what a block refuses later comes as it is."""
    known = confirmed_names(names)
    check_confirmed((one._inner for one in diagram.blocklist if hasattr(one, "_inner")), known)
    token = CONFIRMED.set(known)
    try:
        yield
    except RuntimeError as error:  # bdsim's, around what a block raised
        found: BaseException | None = error
        while found is not None and not isinstance(found, Refused):
            found = found.__cause__ or found.__context__
        if found is not None:
            raise found from None
        raise
    finally:
        CONFIRMED.reset(token)


@contextlib.contextmanager
def _paced_by(diagram: BlockDiagram, clock: RunClock | None) -> Iterator[None]:
    """Has bdsim wait for each moment that it comes to; what it goes back to is over."""
    if clock is None:
        yield
        return
    evaluate, reached = diagram.evaluate, -1.0

    def in_time(states: Any, t: float, *rest: Any, **more: Any) -> Any:
        nonlocal reached
        if t > reached:
            if reached < 0.0:
                clock.begin()
            clock.reach(t)
            reached = t
        return evaluate(states, t, *rest, **more)

    diagram.evaluate = in_time
    try:
        yield
    finally:
        diagram.evaluate = evaluate


def _end_blocks_after(diagram: BlockDiagram, ends: contextlib.ExitStack) -> None:
    """Has the blocks ended that hold something; figures of bdsim are its own affair."""
    for block in diagram.blocklist:
        if hasattr(block, "_inner"):
            ends.callback(block.done)


class _SteppedDiagram:
    """A compiled diagram that is stepped from outside."""

    def __init__(self, sim: BDSim, diagram: BlockDiagram, step: float) -> None:
        from bdsim.run_sim import BDSimState

        self._diagram, self._step = diagram, step
        self._state = BDSimState()
        self._state.options = sim.options
        self._x = np.asarray(diagram.getstate0(), dtype=np.float64)
        self._every = {clock: _steps_per_tick(clock, step) for clock in diagram.clocklist}
        self._ports = [
            (block, number, f"{block.name}[{number}]")
            for block in diagram.blocklist
            for number in range(block.nout)
        ]
        self._rows: list[list[Any]] = []
        self._times: list[float] = []
        self._late: list[float] = []

    def begin(self, seconds: float) -> None:
        self._state.tf = seconds
        self._diagram.start(self._state)

    def step(self, number: int, now: float, late: float) -> bool:
        """All of a moment; False if a block asks to stop."""
        diagram, state = self._diagram, self._state
        state.t = now
        diagram.evaluate(diagram.state_map(self._x, state), now)
        self._times.append(now)
        self._late.append(late)
        self._rows.append([block.outport_value(port) for block, port, _ in self._ports])
        # bdsim's clocks tick for the first time after a period.
        due = [
            clock
            for clock, (every, first) in self._every.items()
            if number and number % every == first
        ]
        following = diagram.next(now, diagram.state_map(self._x, state)) if due else {}
        if len(self._x):
            self._x = self._integrated(now)
        for clock in due:
            clock._set_runtime_state(following[clock], state)
        return state.stop is None

    def ran(self) -> RunResult:
        """Ports that give numbers of one size, as columns."""
        columns = {}
        for place, (_, _, name) in enumerate(self._ports):
            values = [row[place] for row in self._rows]
            arrays = [np.atleast_1d(v) for v in values if isinstance(v, (int, float, np.ndarray))]
            if len(arrays) == len(values) and len({one.shape for one in arrays}) == 1:
                columns[name] = np.array(arrays, dtype=np.float64).reshape(len(arrays), -1)
        lateness = np.array(self._late)
        late = int((lateness > LATE_SHARE * self._step).sum())
        return RunResult(np.array(self._times), columns, lateness, late)

    def _integrated(self, now: float) -> Floats:
        """The classical method of fourth order, with what is sampled held over the step."""
        h, x = self._step, self._x
        first = self._change(now, x)
        second = self._change(now + h / 2.0, x + h / 2.0 * first)
        third = self._change(now + h / 2.0, x + h / 2.0 * second)
        fourth = self._change(now + h, x + h * third)
        return np.asarray(x + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth))

    def _change(self, now: float, x: Floats) -> Floats:
        states = self._diagram.state_map(x, self._state)
        self._diagram.evaluate(states, now, sinks=False)
        return np.asarray(self._diagram.deriv(now, states), dtype=np.float64)


def _steps_per_tick(clock: Any, step: float) -> tuple[int, int]:
    """Steps from tick to tick of a clock, and the first one."""
    told = clock.T, clock.offset
    every, first = (round(one / step) if math.isfinite(one) else 0 for one in told)
    off = max(abs(every * step - clock.T), abs(first * step - clock.offset))
    if every < 1 or off > 1e-6 * clock.T:
        cure = f"let it be a multiple of the step of {step:g} s"
        raise Refused(BAD_STEP(what=f"clock `{clock.name}`", value=clock.T, cure=cure))
    return every, first % every
