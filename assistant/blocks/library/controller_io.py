"""Blocks of controller inputs and outputs, of grippers, and of poses exchanged with a program.

A model goes on while the controller answers. `ExchangedPose` sends poses one after the other to the
module of `robot-assistant exchange module`, by files.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from typing import Final, Protocol

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Refused
from assistant.blocks.connections import STOP_TIMEOUT, Asked, Connection
from assistant.blocks.diagrams import Port
from assistant.blocks.library.ports import (
    POSE_SIZE,
    Connected,
    check_not_negative,
    pose_parts,
    pose_port,
    pose_signal,
)
from assistant.blocks.rules import GRIP_NOT_CONFIRMED, OPEN_AND_CLOSED
from assistant.controllers import connect
from assistant.controllers.abb.exchange import PoseExchange
from assistant.controllers.abb.exchange.files import Answer
from assistant.controllers.controller import Controller
from assistant.program.geometry import Pose, Vector

OPEN, _CLOSED, BETWEEN = 0.0, 1.0, 0.5
"""States of a gripper: confirmed ones, and what nobody confirms."""
_GRIP_TIMEOUT: Final = 2.0
"""Seconds in which a gripper has to confirm."""


class Signals(Connected[Asked[Controller]]):
    """Inputs of a controller by their names (numbers as text where it numbers them) → values, age.

    values: NaN until the first answer. age: seconds since the request for these values. The block
    requests them again at each step without a pending answer.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[Asked[Controller]],
        names: Sequence[str],
        *,
        period: float | None = None,
    ) -> None:
        self.names = (names,) if isinstance(names, str) else tuple(names)
        ports = [Port("values", len(self.names)), Port("age", unit="s")]
        super().__init__(name, connection, (), ports, period)

    def begin(self) -> None:
        self._values, self._at = np.full(len(self.names), np.nan), np.nan
        self._coming: tuple[float, Future[dict[str, float]]] | None = None
        super().begin()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a signal that is not there, and for a connection that is lost."""
        del given
        if self._coming is not None and self._coming[1].done():
            self._at, answer = self._coming
            found = answer.result()
            self._values = np.array([found[name] for name in self.names])
            self._coming = None
        return [self._values, [now - self._at]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        del given
        if self._coming is None:
            self._coming = now, self.share.ask(lambda session: session.inputs(self.names))


class Output(Connected[Asked[Controller]]):
    """value → what the output was set to last, NaN before. It is set when the value changes.

    Values that come while one is on its way are not waited for: the newest is next. A value that is
    no number sets nothing.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[Asked[Controller]],
        output: str,
        *,
        period: float | None = None,
    ) -> None:
        super().__init__(name, connection, [Port("value")], [Port("set")], period)
        self.output, self.moves = output, connection.name

    def begin(self) -> None:
        self._set = np.nan
        self._coming: tuple[float, Future[None]] | None = None
        super().begin()

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for an output that is not there or does not take the value."""
        del now, given
        if self._coming is not None and self._coming[1].done():
            self._coming[1].result()
            self._set, self._coming = self._coming[0], None
        return [[self._set]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        del now
        value = float(given[0][0])
        if self._coming is None and np.isfinite(value) and value != self._set:
            name = self.output
            self._coming = value, self.share.ask(lambda session: session.set_output(name, value))


class Actuated(Protocol):
    """Actuator that opens and closes a gripper."""

    def move(self, session: Controller, *, close: bool) -> None: ...


@dataclass(frozen=True, slots=True)
class Hand:
    """A hand of a controller that numbers them."""

    number: int = 1

    def move(self, session: Controller, *, close: bool) -> None:
        session.hand(self.number, open=not close)


@dataclass(frozen=True, slots=True)
class Valve:
    """An output. closed, opened: its values for either."""

    output: str
    closed: float = 1.0
    opened: float = 0.0

    def move(self, session: Controller, *, close: bool) -> None:
        session.set_output(self.output, self.closed if close else self.opened)


class Gripper(Connected[Asked[Controller]]):
    """close → state (1 closed, 0 open, 0.5 for neither), whether that is confirmed, busy.

    Above 0.5 the gripper closes, below it opens, and a value that is not a number leaves it
    unchanged; the block sends a command when that changes. opened, closed: names of inputs that are
    1 in that state; a missing one is the opposite of the other. The block reads them all the time,
    so that it detects a lost part. Without any, the answer of the controller is the confirmation.
    within: seconds of the model in which it must confirm.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[Asked[Controller]],
        by: Actuated,
        *,
        opened: str | None = None,
        closed: str | None = None,
        within: float = _GRIP_TIMEOUT,
        period: float | None = None,
    ) -> None:
        ports = [Port("state"), Port("confirmed"), Port("busy")]
        super().__init__(name, connection, [Port("close")], ports, period)
        self.by, self.opened, self.closed = by, opened, closed
        self.within = check_not_negative("within", within)
        self.moves = connection.name

    def begin(self) -> None:
        self._told: bool | None = None
        self._since = 0.0
        self._state = BETWEEN
        self._moving: Future[None] | None = None
        self._looking: Future[dict[str, float]] | None = None
        super().begin()

    @property
    def _inputs(self) -> tuple[str, ...]:
        return tuple(name for name in (self.opened, self.closed) if name is not None)

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a gripper that does not confirm in time, or is refused."""
        del given
        if self._moving is not None and self.ended(self._moving):
            self._moving.result()
            self._moving = None
            if not self._inputs:
                self._state = _CLOSED if self._told else OPEN
        if self._looking is not None and self._looking.done():
            self._state = self._read(self._looking.result())
            self._looking = None
        done = self._moving is None and self._told is not None and self._state == self._told
        if done:
            self._since = np.inf  # a part that is lost later is no failure to grip
        elif self._told is not None and now - self._since > self.within:
            what = "close" if self._told else "open"
            raise Refused(GRIP_NOT_CONFIRMED(block=self.name, what=what, seconds=self.within))
        busy = self._told is not None and not done and self._since < np.inf
        return [[self._state], [float(done)], [float(busy)]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        wanted, by, inputs = float(given[0][0]), self.by, self._inputs
        if self._moving is None and np.isfinite(wanted) and (wanted > 0.5) != self._told:
            close = self._told = wanted > 0.5
            self._since, self._state = now, BETWEEN
            self._looking = None  # what was asked before tells of before
            self._moving = self.share.ask(lambda session: by.move(session, close=close))
        elif self._moving is None and self._looking is None and inputs:
            self._looking = self.share.ask(lambda session: session.inputs(inputs))

    def _read(self, found: dict[str, float]) -> float:
        """The state that the inputs tell."""
        is_open = found[self.opened] > 0.5 if self.opened else None
        is_closed = found[self.closed] > 0.5 if self.closed else None
        if is_open and is_closed:
            raise Refused(OPEN_AND_CLOSED(block=self.name))
        if is_closed or (is_closed is None and not is_open):
            return _CLOSED
        return OPEN if is_open or is_open is None else BETWEEN


def exchanged(
    name: str,
    address: str,
    *,
    box: tuple[Vector, Vector] | None = None,
    password: str | None = None,
    prefix: str = "exchange",
    timeout: float = 10.0,
    longest: float = 240.0,
) -> Connection[Asked[PoseExchange]]:
    """Connect to a controller that runs the module of `robot-assistant exchange module`.

    box: least and greatest x, y, z in mm of poses that may be sent, None for any. prefix, timeout,
    longest: see `PoseExchange`. Closing it stops a running motion over a separate connection; the
    module has ended then.
    """

    def check(positions: Floats, quaternions: Floats) -> Mapping[int, str]:
        del quaternions
        return {} if box is None else _outside_box(positions, box)

    @contextmanager
    def opening() -> Iterator[Asked[PoseExchange]]:
        programs = connect(address, password=password, timeout=timeout)
        with programs:
            made = PoseExchange(
                programs, prefix=prefix, timeout=timeout, longest=longest, check=check
            )
            with made as exchange:
                asking = Asked(exchange)
                try:
                    yield asking
                finally:
                    if asking.busy:
                        with connect(address, password=password, timeout=timeout) as other:
                            stopping = PoseExchange(other, prefix=prefix, timeout=timeout)
                            stopping.stop()
                        exchange.ended = stopping.ended
                    asking.close()

    return Connection(name, opening, moves=True)


def _outside_box(positions: Floats, box: tuple[Vector, Vector]) -> Mapping[int, str]:
    low, high = map(np.array, box)
    wrong = ((positions < low) | (positions > high)).any(axis=1)
    return {int(row): "it is outside of the box of its block" for row in np.flatnonzero(wrong)}


class ExchangedPose(Connected[Asked[PoseExchange]]):
    """pose, start → busy, poses reached, pose where it stood last, seconds of the last motion.

    While `start` is above 0.5 and nothing is under way, the tool of the module goes on a line to a
    pose that is another one than the last. Poses that come meanwhile are not waited for: the one
    that is there when it is free again is next. `pose` is that of its work object.
    """

    def __init__(
        self,
        name: str,
        connection: Connection[Asked[PoseExchange]],
        *,
        period: float | None = None,
    ) -> None:
        outputs = [Port("busy"), Port("done"), pose_port("stands"), Port("motion", unit="s")]
        super().__init__(name, connection, [pose_port(), Port("start")], outputs, period)
        self.moves = connection.name

    def begin(self) -> None:
        super().begin()
        self._done, self._motion = 0, 0.0
        self._last: Floats | None = None
        self._stands = np.full(POSE_SIZE, np.nan)
        self._under_way: Future[Answer] | None = self.share.ask(
            lambda exchange: exchange.current_pose()
        )
        self._goes = False

    def end(self) -> None:
        asking = self._share
        super().end()
        if asking is None:
            return
        under_way, self._under_way = self._under_way, None
        if under_way is not None and not asking.busy:
            with suppress(Refused):  # what ended it was the stop
                under_way.result(STOP_TIMEOUT)

    def give(self, now: float, given: Sequence[Floats]) -> Sequence[ArrayLike]:
        """Raises Refused for a pose that is not sent or not reached."""
        del now, given
        if self._under_way is not None and self.ended(self._under_way):
            answer, self._under_way = self._under_way.result(), None
            self._stands = pose_signal(answer.pose.position, answer.pose.quaternion)
            if self._goes:
                self._done += 1
                self._motion = answer.motion
            self._goes = False
        return [[float(self._goes)], [float(self._done)], self._stands, [self._motion]]

    def take(self, now: float, given: Sequence[Floats]) -> None:
        del now
        wanted = given[0]
        if self._under_way is not None or not given[1][0] > 0.5:
            return
        if self._last is not None and np.array_equal(wanted, self._last):
            return
        position, turn = pose_parts(wanted)
        pose = Pose.of(position[0], turn[0])
        self._last, self._goes = wanted, True
        self._under_way = self.share.ask(lambda exchange: exchange.move_to(pose))
