"""What a block of ours is to bdsim, and blocks of one's own in it without a class each."""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar
from inspect import Parameter, Signature, signature
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.diagrams.block import Block
from assistant.blocks.diagrams.running import block_outputs, check_confirmed, errors_with_block

if TYPE_CHECKING:
    from bdsim.blockdiagram import BlockDiagram
    from bdsim.components import Clock

CONFIRMED: Final[ContextVar[frozenset[str]]] = ContextVar("confirmed", default=frozenset())
"""Names of the controllers whose arms may be moved by the run that begins."""
TICK_TOLERANCE: Final = 1e-6
"""Part of a period by which a moment may be beside a tick, as it is added up."""


class Adapted:
    """What a block of ours is to bdsim; its class of bdsim stands behind this one."""

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
        """A Refused as it is; of others bdsim prints much, and ends with an error of its own."""
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
        """Single numbers as such, as bdsim's own blocks give them."""
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
        """What it gives at a moment is worked out once, however often bdsim asks."""
        del u, x
        if self._begun and t != self._at:
            self._at = t
            self._shows = self._shown(block_outputs(self._inner, t, ()))
        return self._shows

    def next(self, t: float, u: Sequence[Any], x: Floats) -> Floats:
        """At the tick of any clock bdsim asks all blocks: here that of its own counts, and once."""
        clock: Clock = self._clock  # type: ignore[attr-defined]
        ticks = (t - clock.offset) / clock.T
        if t != self._taken and abs(ticks - round(ticks)) < TICK_TOLERANCE:
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
    """For a class of bdsim that stands for one kind of block of ours, and takes what that takes.

    bdsim finds it by reading the file, without running it: its docstring and ports stand there.
    kind: the kind. called: the name of one that is given none, "" where one has to be given. By
    place come the clock of a block that steps, what the kind takes so, and the name; None stands
    for what is left out, as in the forms of bdsim's editor. What else is told is bdsim's.
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
    """What a class of bdsim takes for a kind of block; its clock tells the period."""
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
    moment. Raises ValueError for a block that remembers something (`direct` is False) without one.
    """
    from bdsim.block import FunctionBlock, SampledBlock

    if clock is None and not block.direct:
        raise ValueError(f"block `{block.name}` steps with a clock, and none is given")
    name = type(block).__name__
    if clock is None:
        ports = {"nin": len(block.inputs)}
        made = type(name, (Direct, FunctionBlock), ports)(block)
    else:
        made = type(name, (Stepped, SampledBlock), {})(block, clock)
    made.type = name.lower()
    diagram.add_block(made)
    return made
