"""Block diagrams: blocks with ports and units, wires, the order of steps, and runs.

A run steps all blocks at a fixed step and records their signals in columns, as fast as the blocks
allow or in real time with late steps counted.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import field
from graphlib import CycleError, TopologicalSorter
from typing import ClassVar, Final, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats, number_within
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, UnknownName
from assistant.blocks import rules


@dataclass(frozen=True, slots=True)
class Port:
    """name: of the signal. size: numbers that it has. unit: `deg`, `mm`, `mm/s`, "" for none.

    also: other sizes that an input takes. means: the numbers of each size, for messages.
    """

    name: str
    size: int = 1
    unit: str = ""
    also: tuple[int, ...] = ()
    means: str = ""

    @property
    def wanted(self) -> str:
        """The sizes that an input takes, and the numbers of each, in words."""
        sizes = " or ".join(map(str, (self.size, *self.also)))
        return f"{sizes}: {self.means}" if self.means else sizes

    def takes(self, size: int) -> bool:
        """True if signals of that size fit the input."""
        return size == self.size or size in self.also


class Block:
    """Block of a diagram; a subclass defines its ports and its behaviour.

    direct: whether its outputs depend on its inputs of the same step; blocks without that
    dependency, such as delays and arms, may be in a loop. period: seconds between its steps, None
    for each step of the diagram; between them it repeats its outputs. moves: name of the controller
    whose arm it moves, "" for none; a run must receive that name as confirmed.
    """

    direct: ClassVar[bool] = True
    moves: str = ""

    def __init__(
        self,
        name: str,
        inputs: Sequence[Port] = (),
        outputs: Sequence[Port] = (),
        *,
        period: float | None = None,
    ) -> None:
        self.name = name
        self.inputs = tuple(inputs)
        self.outputs = tuple(outputs)
        self.period = period

    def begin(self) -> None:
        """Before the first step; what it opens here, `end` closes."""

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Its outputs at a moment. given: signals of its inputs; () for one that is not direct."""
        raise NotImplementedError

    def take(self, now: float, given: Sequence[Floats]) -> None:
        """All signals of a moment are there; what the block remembers changes here."""

    def end(self) -> None:
        """After the last step, whatever it was; also if `begin` of another block failed."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"


def _signal(value: ArrayLike, port: Port) -> Floats:
    """A value as the signal of a port; raises ValueError for one of another size."""
    found = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if found.shape != (port.size,):
        raise ValueError(f"`{port.name}` has {port.size} numbers, not {found.shape}")
    return found


AnyBlock = TypeVar("AnyBlock", bound=Block)
PortRef = tuple[Block, int]
"""A port of a block, by its number."""


@dataclass(frozen=True, slots=True)
class StepOrder:
    """order: blocks as they give their outputs. sources: of each block where its inputs come from.
    findings: what may be wrong and does not keep it from running.
    """

    order: tuple[Block, ...]
    sources: Mapping[Block, tuple[PortRef, ...]]
    findings: tuple[Diagnostic, ...]


class Diagram:
    """Blocks and wires.

    diagram = Diagram()
    way = diagram.add(Ramp("way", ...))
    arm = diagram.add(SimulatedArm("arm", robot))
    diagram.wire((way, "joints"), arm)
    """

    def __init__(self, name: str = "main") -> None:
        self.name = name
        self.blocks: list[Block] = []
        self._wires: dict[tuple[Block, int], PortRef] = {}

    def __repr__(self) -> str:
        return f"<Diagram {self.name}: {len(self.blocks)} blocks, {len(self._wires)} wires>"

    def _repr_png_(self) -> bytes | None:
        """Its blocks and wires, for notebooks; None without matplotlib."""
        from assistant.blocks.display import diagram_png

        return diagram_png(self)

    def add(self, block: AnyBlock) -> AnyBlock:
        """Puts a block in and gives it back; raises Refused for a name that is taken."""
        if any(one.name == block.name for one in self.blocks):
            raise Refused(rules.SAME_BLOCK_NAME(name=block.name))
        self.blocks.append(block)
        return block

    def wire(
        self,
        start: Block | tuple[Block, str],
        end: Block | tuple[Block, str],
        *more: Block | tuple[Block, str],
    ) -> None:
        """From an output to one or more inputs; a port is named where a block has several.

        Raises Refused for ports that are not there, and for an input that has a wire.
        """
        source = self._port(start, "output")
        for one in (end, *more):
            block, number = self._port(one, "input")
            if (block, number) in self._wires:
                port = block.inputs[number].name
                raise Refused(rules.TWO_WIRES(port=port, block=block.name))
            self._wires[block, number] = source

    @property
    def wires(self) -> Sequence[tuple[PortRef, PortRef]]:
        """From where to where, in the order in which they were laid."""
        return [(start, end) for end, start in self._wires.items()]

    def plan(self) -> StepOrder:
        """The order of its steps; raises Refused for inputs without a wire and for loops."""
        missing = [
            rules.NO_WIRE(port=port.name, block=block.name)
            for block in self.blocks
            for number, port in enumerate(block.inputs)
            if (block, number) not in self._wires
        ]
        unlike = [found for wire in self.wires if (found := _port_mismatch(*wire)) is not None]
        wrong = [*missing, *(one for one in unlike if one.severity == "error")]
        if wrong:
            raise Refused(*wrong)
        sources = {
            block: tuple(self._wires[block, number] for number in range(len(block.inputs)))
            for block in self.blocks
        }
        waits = {
            block: [start for start, _ in sources[block]] if block.direct else []
            for block in self.blocks
        }
        try:
            order = tuple(TopologicalSorter(waits).static_order())
        except CycleError as error:
            names = " → ".join(f"`{block.name}`" for block in error.args[1])
            raise Refused(rules.ALGEBRAIC_LOOP(names=names)) from None
        return StepOrder(order, sources, tuple(unlike))

    def _port(self, given: Block | tuple[Block, str], kind: str) -> PortRef:
        block, name = given if isinstance(given, tuple) else (given, None)
        if block not in self.blocks:
            raise Refused(rules.BLOCK_OF_NO_DIAGRAM(name=block.name))
        ports = block.outputs if kind == "output" else block.inputs
        found = [i for i, port in enumerate(ports) if name in (None, port.name)]
        if len(found) != 1:
            if name is None and ports:
                known = " or ".join(f'(block, "{port.name}")' for port in ports)
                wrong = rules.WHICH_PORT(block=block.name, kind=kind, count=len(ports), known=known)
                raise Refused(wrong)
            known = ", ".join(f"`{port.name}`" for port in ports) or "none"
            said = name or "it has none"
            raise Refused(rules.NO_PORT(block=block.name, kind=kind, name=said, known=known))
        return block, found[0]


def _port_mismatch(start: PortRef, end: PortRef) -> Diagnostic | None:
    """Return the mismatch between two ports as a finding, None if they fit."""
    one, other = start[0].outputs[start[1]], end[0].inputs[end[1]]
    given, wanted = f"{start[0].name}.{one.name}", f"{end[0].name}.{other.name}"
    if not other.takes(one.size):
        return rules.OTHER_SIGNAL_SIZE(start=given, end=wanted, given=one.size, wanted=other.wanted)
    if one.unit != other.unit and one.unit and other.unit:
        return rules.OTHER_SIGNAL_UNIT(start=given, end=wanted, given=one.unit, wanted=other.unit)
    return None


_SPIN_SECONDS: Final = 2e-4
"""Seconds before a moment from which on it is waited for without sleeping."""


class RunClock(Protocol):
    """Clock that paces the steps of a run."""

    def begin(self) -> None:
        """The first step is next, at 0 s."""

    def reach(self, moment: float) -> float:
        """Comes back at a moment of the run; how many seconds after it."""


class Simulated:
    """Time passes as fast as the blocks allow."""

    def begin(self) -> None: ...

    def reach(self, moment: float) -> float:
        del moment
        return 0.0


class RealTime:
    """Clock in real time. A late step runs at once, and none is skipped.

    pace: seconds of the run in each real second: the speed of a virtual controller that the run
    drives. Raises Refused for a pace that is not a positive finite number.
    """

    def __init__(self, pace: float = 1.0) -> None:
        self.pace, self._began = number_within(pace, "pace", above=0.0), 0.0

    def begin(self) -> None:
        self._began = time.monotonic()

    def reach(self, moment: float) -> float:
        due = self._began + moment / self.pace
        while (rest := due - time.monotonic()) > 0.0:
            if rest > _SPIN_SECONDS:
                time.sleep(rest - _SPIN_SECONDS)
        return -rest * self.pace


MOST_STEPS: Final = 10_000_000
LATE_SHARE: Final = 0.5
"""Part of a step by which one is late that counts as late."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RunResult:
    """Result of a run.

    seconds: (n,) of its steps. columns: (n, k) by `block.port`. lateness: (n,) seconds that each
    step began late. late: number of steps that were late by more than half a step.
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
        from assistant.blocks.display import signals_html

        return signals_html(self)

    def _repr_png_(self) -> bytes | None:
        """Signals over time; None without matplotlib."""
        from assistant.blocks.display import run_png

        return run_png(self)

    def __getitem__(self, name: str) -> Floats:
        """The signal of a port, `block.port`, (n,) where it is a single number."""
        if name not in self.columns:
            known = ", ".join(f"`{one}`" for one in self.columns)
            raise UnknownName(rules.NO_SIGNAL(name=str(name)[:60], known=known))
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
    """Return the names of controllers whose arms may move; a plain text is one name."""
    return frozenset([moving] if isinstance(moving, str) else moving)


def check_confirmed(blocks: Iterable[Block], names: frozenset[str]) -> None:
    """Raises Refused for blocks that move an arm which is not among the names."""
    wanting = [block for block in blocks if block.moves and block.moves not in names]
    if wanting:
        told = (rules.MOTION_NOT_CONFIRMED(block=one.name, name=one.moves) for one in wanting)
        raise Refused(*told, exit_status=2)


@contextmanager
def closing_all() -> Iterator[ExitStack]:
    """Close everything after a run, each item even if others raise.

    The finding that ended the run comes first, followed by those of the closing.
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
    """Report an error of a block with its name and the time; a Refused contains them already."""
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
    """Return the outputs of a block, one signal per port; raises Refused with its name."""
    with errors_with_block(block, now):
        values = tuple(block.give(now, given))
        if len(values) != len(block.outputs):
            raise ValueError(f"{len(values)} signals for {len(block.outputs)} outputs")
        return tuple(_signal(v, port) for v, port in zip(values, block.outputs, strict=True))


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
