"""What the packets of a maker are to the loop that sends and receives them.

A maker's module gives a frozen dataclass that answers `Link`. The loop runs in a process of its
own, which makes the link anew from its class and fields: numbers, texts, truths and tuples of them.

    @dataclass(frozen=True)
    class Egm:
        cycle: float = 0.004
        ...
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Measured:
    """What a packet of the controller tells.

    values: where the arm is, in the columns of the trajectory. counter: of the packet, to know one
    that comes twice or late; None if it has none. missed: cycles in a row that the controller says
    it was left without a command. stopped: why it does not follow (any more), "" while it does.
    ready: False while a controller that speaks first does not take commands yet.
    extra: what else is recorded, as `Link.recorded` names it.
    """

    values: tuple[float, ...]
    counter: int | None = None
    missed: int = 0
    stopped: str = ""
    ready: bool = True
    extra: tuple[float, ...] = ()


class Link(Protocol):
    """The packets of one conversation; each call is made in the loop, so it must be quick.

    cycle: seconds from packet to packet of the controller. speaks_first: whether the controller
    sends of its own accord in each cycle; else it answers a packet with one.
    recorded: names of `Measured.extra`.
    """

    @property
    def cycle(self) -> float: ...

    @property
    def speaks_first(self) -> bool: ...

    @property
    def recorded(self) -> tuple[str, ...]: ...

    def hello(self, count: int) -> bytes:
        """A packet that moves nothing and asks where the arm is; unused if it speaks first."""

    def read(self, packet: bytes) -> Measured | None:
        """What a packet says; None if it is none of this conversation or makes no sense."""

    def command(self, values: Sequence[float], count: int) -> bytes:
        """The packet that leads the arm to a row. count: of packets that were sent before."""

    def end(self, values: Sequence[float], count: int) -> bytes | None:
        """The packet that ends the control; None if there is none and silence ends it."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Where the packets go. host: of the controller; None to take the first one that speaks.

    port: of the controller, 0 to take it from its first packet. local_host, local_port: on this
    machine, "" and 0 for any.
    """

    host: str | None
    port: int
    local_host: str = ""
    local_port: int = 0

    def __str__(self) -> str:
        if self.host is None:
            return f"port {self.local_port} of this machine"
        return f"{self.host}:{self.port}" if self.port else self.host
