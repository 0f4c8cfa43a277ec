"""The panel of the controller: motors, operating mode, speed; and its event log."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import field
from datetime import datetime
from typing import Final, Literal

from assistant.base.data_classes import dataclass

Mode = Literal["AUTO", "MANR", "MANF"]
State = Literal["motoroff", "motoron", "guardstop", "emergencystop", "emergencystopreset"]
Kind = Literal[1, 2, 3]
"""Kind of an event: information, a warning, an error."""
_MOST_EVENTS: Final = 1000
_DOMAIN: Final = 10_000
"""The number of an event is its domain times this, and its own number in the domain."""

_TITLES: Final[dict[int, tuple[Kind, str]]] = {
    10002: (1, "Program pointer has been reset"),
    10010: (1, "Motors OFF state"),
    10011: (1, "Motors ON state"),
    10013: (3, "Emergency stop state"),
    10015: (1, "Manual mode selected"),
    10017: (1, "Automatic mode confirmed"),
    10125: (1, "Program stopped"),
    10126: (3, "Program stopped by an error"),
    10151: (1, "Program started"),
    40160: (3, "Errors in RAPID program"),
    40228: (3, "Execution error"),
    41822: (3, "No data from the UdpUc device"),
    50027: (3, "Joint out of range"),
    50050: (3, "Position outside reach"),
    80001: (3, "User message: error"),
    80002: (2, "User message: warning"),
    80003: (1, "User message: information"),
}
"""Events that this controller logs; the numbers are those of the reference, 4.2, except 10013,
10015, 10017 and those of ErrWrite (80001 …), which are from memory.
"""


@dataclass(frozen=True, slots=True)
class Event:
    """number: counted from 1. code: domain and number in one. text: beside its title."""

    number: int
    code: int
    kind: Kind
    time: datetime
    title: str
    text: str = ""
    arguments: tuple[str, ...] = ()

    @property
    def domain(self) -> int:
        return self.code // _DOMAIN


@dataclass(eq=False)
class EventLog:
    """The events, the oldest first. now: what the clock of the controller says."""

    now: Callable[[], datetime]
    events: list[Event] = field(default_factory=list)
    count: int = 0

    def __post_init__(self) -> None:
        self._lock = threading.Lock()

    def add(
        self, code: int, text: str = "", title: str = "", arguments: tuple[str, ...] = ()
    ) -> None:
        kind, usual = _TITLES.get(code, (3, f"Event {code}"))
        with self._lock:
            self.count += 1
            made = Event(self.count, code, kind, self.now(), title or usual, text, arguments)
            self.events.append(made)
            del self.events[:-_MOST_EVENTS]

    def of(self, domain: int) -> list[Event]:
        """Return the events of a domain, 0 for all."""
        with self._lock:
            return [one for one in self.events if domain in (0, one.domain)]

    def clear(self, domain: int = 0) -> None:
        with self._lock:
            self.events = [one for one in self.events if domain not in (0, one.domain)]


@dataclass(slots=True, eq=False)
class Panel:
    """speed: percent of the programmed one; it is kept and told, and changes no motion here.

    locked: whether the emergency stop is pressed.
    """

    log: EventLog
    mode: Mode = "AUTO"
    state: State = "motoroff"
    speed: int = 100

    def set_motors(self, on: bool) -> None:
        """Raises ValueError where an emergency stop forbids it."""
        if on and self.state in ("emergencystop", "guardstop"):
            raise ValueError(f"the controller is in {self.state}")
        wanted: State = "motoron" if on else "motoroff"
        if self.state != wanted:
            self.state = wanted
            self.log.add(10011 if on else 10010)

    def set_mode(self, mode: Mode) -> None:
        if self.mode != mode:
            self.mode = mode
            self.log.add(10017 if mode == "AUTO" else 10015)

    def press(self) -> None:
        """The emergency stop."""
        if self.state != "emergencystop":
            self.state = "emergencystop"
            self.log.add(10013)

    def release(self) -> None:
        """The emergency stop is pulled out; the motors stay off until they are set on."""
        if self.state == "emergencystop":
            self.state = "emergencystopreset"
