"""How a loop is run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from assistant.base.diagnostics import Refused
from assistant.controllers.cyclic.rules import BAD_SETTING

PRIORITY: Final = 80
"""Of SCHED_FIFO (1 to 99): above other programs, below the kernel's own threads that matter."""


@dataclass(frozen=True, slots=True)
class Settings:
    """timeout: seconds without a packet after which it gives up. opening: the same for the first
    one, None for as many: a controller that speaks first may begin later.
    lapse: cycles without one after which the arm is taken to stand, so that it starts softly
    again, and a controller that only answers is asked again.
    garbled: packets without sense in a row that end it.
    approach: what the soft start may go at most, degrees of a joint or mm (degrees) of a pose.
    softness: part of the limits that it uses. lag: seconds that the arm may be behind its command,
    at the speeds of the limits; inf to follow whatever it says. slack: degrees or mm beside that.
    settle: seconds for which the last point is held. wait: `block` in the kernel for a packet;
    `spin`, which takes a whole core at ordinary priority, as the kernel takes it from a real-time
    loop for 50 ms of each second; or `mixed`, which blocks until a third of a cycle before the
    packet is due and then spins: a processor that sleeps, that of a virtual machine above all, may
    wake up late. real_time: whether to ask for real-time priority, and processors that stay awake.
    alive: seconds without a sign of life of the program that asked for the motion, which Ctrl-Z
    stops, after which the arm is brought to rest.
    end: whether to end the control behind the last point; else the controller waits for more.
    """

    timeout: float = 0.5
    opening: float | None = None
    lapse: int = 4
    garbled: int = 20
    approach: float = 10.0
    softness: float = 0.1
    lag: float = 0.25
    slack: float = 1.0
    settle: float = 0.05
    wait: Literal["mixed", "block", "spin"] = "mixed"
    real_time: bool = True
    alive: float = 2.0
    end: bool = True

    @property
    def first(self) -> float:
        """Seconds to wait for the first packet."""
        return self.timeout if self.opening is None else self.opening

    def __post_init__(self) -> None:
        ranges = {
            "timeout": (0.005, 60.0),
            "opening": (0.005, 3600.0),
            "lapse": (1, 1000),
            "garbled": (1, 1_000_000),
            "approach": (0.0, float("inf")),
            "softness": (0.001, 1.0),
            "lag": (0.0, float("inf")),
            "slack": (0.0, float("inf")),
            "settle": (0.0, 60.0),
            "alive": (0.5, 60.0),
        }
        for name, (least, most) in ranges.items():
            value = getattr(self, name)
            if value is None:
                continue
            if not least <= value <= most:
                reason = f"it is a number from {least:g} to {most:g}"
                raise Refused(BAD_SETTING(name=name, value=value, reason=reason), exit_status=2)
        if self.wait not in ("mixed", "block", "spin"):
            reason = "it is mixed, block or spin"
            raise Refused(BAD_SETTING(name="wait", value=self.wait, reason=reason), exit_status=2)
