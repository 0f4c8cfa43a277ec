"""Our blocks in bdsim, and runs of bdsim diagrams.

`add` puts one block of ours into a diagram of bdsim without a class for it; `OfKind`, `Direct` and
`Stepped` are the bases of the classes in `robot` and `robot_around`, which bdsim finds by reading
their files. Diagrams run by bdsim itself, or step by step in our time, by simulation or in real
time.
"""

from __future__ import annotations

import contextlib
import io
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextvars import ContextVar
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams import (
    LATE_SHARE,
    Block,
    RunClock,
    RunResult,
    Simulated,
    block_outputs,
    check_confirmed,
    closing_all,
    confirmed_names,
    errors_with_block,
    step_count,
)
from assistant.blocks.rules import BAD_STEP, NEEDS_CLOCK

if TYPE_CHECKING:
    from bdsim import BDSim
    from bdsim.blockdiagram import BlockDiagram
    from bdsim.components import Clock


CONFIRMED: Final[ContextVar[frozenset[str]]] = ContextVar("confirmed", default=frozenset())
"""Names of the controllers whose arms may be moved by the run that begins."""
_TICK_TOLERANCE: Final = 1e-6
"""Part of a period by which a moment may be beside a tick, as it is added up."""


class Adapted:
    """Adapter that wraps a block of this package as a bdsim block; mixed in before the bdsim
    class.
    """

    def __init__(self, inner: Block, **blockargs: Any) -> None:
        self._inner = inner
        super().__init__(  # type: ignore[call-arg]
            nin=len(inner.inputs),
            nout=len(inner.outputs),
            inames=[port.name for port in inner.inputs] or None,
            onames=[f"{port.name}_" for port in inner.outputs] or None,
            name=inner.name,
            **blockargs,
        )

    def _raise_runtime_error(self, operation: str, err: Exception, **more: Any) -> None:
        """Raise a Refused unchanged; for other errors bdsim prints much and raises its own
        error.
        """
        if isinstance(err, Refused):
            raise err
        super()._raise_runtime_error(operation, err, **more)  # type: ignore[misc]

    def _given(self, values: Sequence[Any]) -> list[Floats]:
        ports = self._inner.inputs
        arrays = [np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel() for value in values]
        for port, array in zip(ports, arrays, strict=True):
            if not port.takes(array.size):
                named = f"`{self._inner.name}.{port.name}`"
                raise ValueError(f"{named} takes {port.wanted}, not {array.size} numbers")
        return arrays

    def _shown(self, values: Sequence[Floats]) -> list[Any]:
        """Return single numbers as floats, as bdsim's own blocks do, and other values as arrays."""
        return [float(one[0]) if one.shape == (1,) else one for one in values]


class Direct(Adapted):
    """A function of the signals of the moment."""

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        del x
        with errors_with_block(self._inner, t):
            return self._shown(block_outputs(self._inner, t, self._given(u)))


class Stepped(Adapted):
    """A block that steps with a clock. Until a run begins it gives zeros."""

    def __init__(self, inner: Block, clock: Clock, **blockargs: Any) -> None:
        super().__init__(inner, clock=clock, ndstates=1, **blockargs)
        self._begun = self._open = False
        self._at: float | None = None
        self._taken: float | None = None
        self._shows = self._shown([np.zeros(port.size) for port in inner.outputs])

    def start(self, simstate: Any) -> None:
        """Raises Refused for an arm that nobody confirmed to move."""
        super().start(simstate)  # type: ignore[misc]
        check_confirmed([self._inner], CONFIRMED.get())
        self._open = True
        with errors_with_block(self._inner, 0.0):
            self._inner.begin()
        self._begun, self._at, self._taken = True, None, None

    def output(self, t: float, u: Sequence[Any], x: Any) -> list[Any]:
        """Return the outputs at a time; compute them once per time, however often bdsim asks."""
        del u, x
        if self._begun and t != self._at:
            self._at = t
            self._shows = self._shown(block_outputs(self._inner, t, ()))
        return self._shows

    def next(self, t: float, u: Sequence[Any], x: Floats) -> Floats:
        """Step once at a tick of its clock; bdsim calls all blocks at the ticks of any clock."""
        clock: Clock = self._clock  # type: ignore[attr-defined]
        ticks = (t - clock.offset) / clock.T
        if t != self._taken and abs(ticks - round(ticks)) < _TICK_TOLERANCE:
            self._taken = t
            with errors_with_block(self._inner, t):
                self._inner.take(t, self._given(u))
        return x

    def done(self, **arguments: Any) -> None:
        super().done(**arguments)  # type: ignore[misc]
        if self._open:  # also if its begin failed half way
            self._begun = self._open = False
            self._inner.end()


class OfKind:
    """Base of a bdsim class for one kind of block of this package, with that kind's parameters.

    bdsim finds the class by parsing the file, without running it: its docstring and ports are
    written there. kind: the block class. called: default name of a block, "" where a name is
    required. Positional parameters are the clock of a block that steps, the positional parameters
    of the kind, and the name; None means omitted, as in the forms of bdsim's editor. Other keyword
    arguments go to bdsim.
    """

    kind: ClassVar[type[Block]]
    called: ClassVar[str] = ""
    __signature__: ClassVar[Signature]

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        if hasattr(cls, "kind"):
            cls.__signature__ = _signature_of(cls.kind, cls.called, steps=issubclass(cls, Stepped))

    def __init__(self, *given: Any, **told: Any) -> None:
        bound = self.__signature__.bind(*given, **told)
        bound.apply_defaults()
        more = bound.arguments.pop("blockargs")
        own = {key: value for key, value in bound.arguments.items() if value is not None}
        clock = {"clock": own.pop("clock")} if "clock" in own else {}
        super().__init__(self.kind(**own), **clock, **more)  # type: ignore[call-arg]


def _signature_of(kind: type[Block], called: str, *, steps: bool) -> Signature:
    """Return the signature of a bdsim class for a kind of block; its clock replaces the period."""
    place = Parameter.POSITIONAL_OR_KEYWORD
    own = [p for p in signature(kind).parameters.values() if p.name not in ("name", "period")]
    clock = [Parameter("clock", place)] if steps else []
    name = Parameter("name", place, default=called or Parameter.empty)
    by_place = [*clock, *(one for one in own if one.kind is place), name]
    by_name = (one for one in own if one.kind is not place)
    return Signature([*by_place, *by_name, Parameter("blockargs", Parameter.VAR_KEYWORD)])


def add(diagram: BlockDiagram, block: Block, clock: Clock | None = None) -> Any:
    """Puts a block of ours into a diagram of bdsim; gives the block of bdsim, to be connected.

    clock: at whose ticks it steps; None for a block that is a function of the signals of the
    moment. Raises Refused for a block that remembers something (`direct` is False) without one.
    """
    from bdsim.block import FunctionBlock, SampledBlock

    if clock is None and not block.direct:
        raise Refused(NEEDS_CLOCK(block=block.name))
    name = type(block).__name__
    if clock is None:
        ports = {"nin": len(block.inputs)}
        made = type(name, (Direct, FunctionBlock), ports)(block)
    else:
        made = type(name, (Stepped, SampledBlock), {})(block, clock)
    made.type = name.lower()
    diagram.add_block(made)
    return made


def run_bdsim(
    sim: BDSim,
    diagram: BlockDiagram,
    seconds: float,
    *,
    clock: RunClock | None = None,
    moving: Iterable[str] = (),
    **options: Any,
) -> Any:
    """Return the result of `sim.run`; end blocks that hold connections in every case.

    clock: waited for before each time that bdsim evaluates: `LockStep` keeps controllers in step.
    moving: names of the controllers whose arms the user confirmed may move. options: of
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
    """Step a bdsim diagram at a fixed step, in real time if `clock` is `RealTime`.

    Continuous states are integrated by the classical Runge-Kutta method; clocks tick at the steps.
    Signals are recorded as columns, `block[port]`, of ports with numeric values. See `diagrams.run`
    for the rest.
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
