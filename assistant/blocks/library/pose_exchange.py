"""Poses that are exchanged with a program on the controller by files, one after the other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress

import numpy as np
from numpy.typing import ArrayLike

from assistant.base.arrays import Floats
from assistant.base.diagnostics import Refused
from assistant.blocks.asking import Asked
from assistant.blocks.connections import STOP_TIMEOUT, Connection
from assistant.blocks.diagrams.block import Port
from assistant.blocks.library.arrays import POSE_SIZE, pose_parts, pose_port, pose_signal
from assistant.blocks.library.connected import Connected
from assistant.controllers import connect
from assistant.controllers.abb.exchange import PoseExchange
from assistant.controllers.abb.exchange.files import Answer
from assistant.program.geometry import Pose, Vector


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
    """A controller on which the module of `robot-assistant exchange module` runs.

    box: least and greatest x, y, z in mm of poses that may be sent, None for any. prefix, timeout,
    longest: see `PoseExchange`. What is under way is stopped when it is closed, over a connection
    of its own; the module has ended then.
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
