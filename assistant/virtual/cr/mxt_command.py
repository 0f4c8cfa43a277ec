"""`Mxt` in programs: a command that a virtual controller adds to those of all.

    run(tree, robot=robot, lines={"ENET:": Enet()}, commands=mxt_commands(port=10000))

Packets are served by a thread of its own, in real time; the program waits meanwhile, and a program
that is stopped has it halt until it goes on, as on a controller.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final

import numpy as np

from assistant.program.geometry import IDENTITY
from assistant.virtual.cr.mxt import CYCLE, MxtControl
from assistant.virtual.cr.mxt_arm import MxtArm
from assistant.virtual.events import Moved
from assistant.virtual.kernel.signals import Board
from assistant.virtual.melfa.lines import Wire
from assistant.virtual.melfa.plugins import Command, Given
from assistant.virtual.melfa.stops import Failed, Unknown
from assistant.virtual.melfa.values import Value

MXT_PORT: Final = 10000
"""First element of NETPORT as delivered."""
LOOK_PERIOD: Final = 0.02
"""Seconds from look to look of the program at what its packets did."""
HALT_SIGNAL: Final = 0.2
"""Seconds without a look after which the program is taken to be stopped."""
ERROR_NUMBERS: Final = {
    7820: "no packet came in time (MXTTOUT)",
    7840: "the argument and the type of data do not match",
    2130: "a speed is too high",
    2160: "a joint is beyond its range",
    2170: "a joint is below its range",
    2802: "a position cannot be reached",
}
"""Errors without the number of their axis."""


class Enet(Wire):
    """The line that `Open "ENET:…"` opens: packets, of which `Mxt` alone knows."""

    def __init__(self) -> None:
        super().__init__(outside=True)


class _Words:
    """Signals of the controller: read at once, set when the program looks."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self.set: deque[tuple[str, float]] = deque()

    def read(self, kind: int, first: int) -> int:
        signals = self._board.outputs if kind == 1 else self._board.inputs
        return sum(bool(signals.read(str(first + i))) << i for i in range(16))

    def write(self, first: int, mask: int, word: int) -> None:
        for i in range(16):
            if mask >> i & 1:
                self.set.append((str(first + i), float(word >> i & 1)))


def mxt_commands(
    *,
    host: str = "127.0.0.1",
    port: int = MXT_PORT,
    cycle: float = CYCLE,
    timeout: Callable[[], int] = lambda: -1,
    opened: Callable[[int], None] = lambda _: None,
) -> dict[str, Command]:
    """The statement by its name, for `commands` of a run.

    host, port: where packets are taken. timeout: gives MXTTOUT. opened: is told the port as soon as
    packets are taken there.
    """

    def mxt(given: Given) -> Value | None:
        kind, filter_ms, partner = _requested_kind(given)
        robot = given.arm.robot
        if robot is None:
            raise Unknown("Mxt without a robot")
        if kind == 0 and (given.arm.tip != IDENTITY or given.arm.foot != IDENTITY):
            raise Unknown("Mxt with positions, where a tool or a base is set")
        kernel = given.task.kernel
        kernel.motion.settle(given.task)
        standing = kernel.motion.where()
        shown = given.arm.shown_joints().values[:6] if standing is None else standing[1]
        own = np.array(robot.own_joints([value or 0.0 for value in shown]), dtype=np.float64)
        words = _Words(kernel.board)
        arm = MxtArm(robot, own, cycle, filter_ms)
        looked = [time.monotonic()]
        try:
            control = MxtControl(
                arm,
                kind,
                partner=partner,
                host=host,
                port=port,
                timeout=timeout(),
                signals=words,
                record=False,
                halted=lambda: time.monotonic() - looked[0] > HALT_SIGNAL,
            )
        except OSError as error:
            raise Failed(7830, f"port {port} of Mxt cannot be used: {error}") from None
        opened(control.port)
        stop = threading.Event()
        thread = threading.Thread(target=control.run, args=(stop,), name="mxt", daemon=True)
        thread.start()
        try:
            while thread.is_alive():
                looked[0] = time.monotonic()
                given.task.wait(
                    lambda: not thread.is_alive(), LOOK_PERIOD, "packets of Mxt", outside=True
                )
                while words.set:
                    given.task.switch(*words.set.popleft())
                kernel.motion.lead(kernel, _whole_argument(arm))
        finally:
            stop.set()
            thread.join()
            given.arm.at_joints(_whole_argument(arm))
        kernel.motion.lead(kernel, _whole_argument(arm))
        led = Moved("joint", given.arm.flange, given.arm.tip, joints=_whole_argument(arm))
        given.task.tell(led)
        number = control.result.number
        if number:
            said = ERROR_NUMBERS.get(number) or ERROR_NUMBERS.get(
                number // 10 * 10, "an error of Mxt"
            )
            raise Failed(number, said)
        return None

    return {"Mxt": mxt}


def _requested_kind(given: Given) -> tuple[int, float, str]:
    """What the statement names: type of data, ms of the filter, and the address it hears."""
    file, kind, filter_ms = (*given.arguments, None, None)[:3]
    if not isinstance(file, int | float) or not isinstance(kind, int | float):
        raise Failed(3120, "Mxt takes a file and a type of data")
    name = given.files.get(int(file), "")
    if not name.startswith("ENET:"):
        raise Failed(3110, f"the file {int(file)} of Mxt is not open as ENET")
    if int(kind) not in (0, 1, 2):
        raise Failed(3110, f"Mxt knows no type of data {int(kind)}")
    smoothed = float(filter_ms) if isinstance(filter_ms, int | float) else 0.0
    if smoothed < 0.0:
        raise Failed(3110, "a filter of Mxt below 0")
    return int(kind), smoothed, name.removeprefix("ENET:").strip()


def _whole_argument(arm: MxtArm) -> tuple[float, ...]:
    """Joints J1, J2, … of which an arm may lack some, 0 for those."""
    numbered = np.zeros(max(6, int(arm.places.max()) + 1))
    numbered[arm.places] = arm.fed_back
    return tuple(numbered.tolist())
