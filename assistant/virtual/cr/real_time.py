"""Real-time control and monitor of a virtual CR controller over UDP (BFP-A3379-A).

`mxt_commands` adds the command `Mxt` to those of every controller; packets are served by a thread
in real time while the program waits, and a program that is stopped halts it until it runs again:

    run(tree, robot=robot, lines={"ENET:": Enet()}, commands=mxt_commands(port=10000))

`MxtMonitor` sends packets in each cycle to the client that asked last (section 5):

    with MxtMonitor(lambda: arm, bits) as monitor:
        Monitor("127.0.0.1", port=monitor.port)
"""

from __future__ import annotations

import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final, Self

import numpy as np

from assistant.program.geometry import IDENTITY
from assistant.virtual.cr.mxt import CYCLE, PULSES, Bits, MxtArm, MxtControl, Signals
from assistant.virtual.cr.state import CrState
from assistant.virtual.events import Moved
from assistant.virtual.kernel.kernel import Board
from assistant.virtual.melfa.communication_lines import Line, Wire
from assistant.virtual.melfa.values import Failed, Unknown, Value
from assistant.virtual.melfa.world import Command, Given

_MXT_PORT: Final = 10000
"""First element of NETPORT as delivered."""
_LOOK_PERIOD: Final = 0.02
"""Seconds from look to look of the program at what its packets did."""
_HALT_SIGNAL: Final = 0.2
"""Seconds without a look after which the program counts as stopped."""
_ERROR_NUMBERS: Final = {
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
    port: int = _MXT_PORT,
    cycle: float = CYCLE,
    timeout: Callable[[], int] = lambda: -1,
    opened: Callable[[int], None] = lambda _: None,
) -> dict[str, Command]:
    """Return the statement by its name, for `commands` of a run.

    host, port: address that receives packets. timeout: returns MXTTOUT. opened: is called with the
    port as soon as it receives packets.
    """

    def mxt(given: Given) -> Value | None:
        kind, filter_ms, partner = _requested_kind(given)
        robot = given.arm.robot
        if robot is None:
            raise Unknown("Mxt without a robot")
        # Poses of packets are those of the flange here; a tool or base would shift them.
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
                # A stopped program stops looking: the arm then holds, and packets are not answered.
                halted=lambda: time.monotonic() - looked[0] > _HALT_SIGNAL,
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
                    lambda: not thread.is_alive(), _LOOK_PERIOD, "packets of Mxt", outside=True
                )
                # Outputs change between two statements, in the program's own task.
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
            # The last digit is the number of an axis.
            said = _ERROR_NUMBERS.get(number) or _ERROR_NUMBERS.get(
                number // 10 * 10, "an error of Mxt"
            )
            raise Failed(number, said)
        return None

    return {"Mxt": mxt}


def _requested_kind(given: Given) -> tuple[int, float, str]:
    """Return the arguments of the statement: type of data, ms of the filter, and the partner's
    address.
    """
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


_MONITOR_BLOCK: Final = "V40"
MONITOR_PACKET: Final = np.dtype(
    [
        ("Command", "<u2"),
        ("reserve0", "<u2"),
        ("Type1", "<u2"),
        ("reserve1", "<u2"),
        ("Data1", _MONITOR_BLOCK),
        ("InputTop", "<u2"),
        ("OutputTop", "<u2"),
        ("Input", "<u4"),
        ("Output", "<u4"),
        ("Counter", "<u4"),
        ("Type2", "<u2"),
        ("reserve2", "<u2"),
        ("Data2", _MONITOR_BLOCK),
        ("Type3", "<u2"),
        ("reserve3", "<u2"),
        ("Data3", _MONITOR_BLOCK),
        ("Type4", "<u2"),
        ("reserve4", "<u2"),
        ("Data4", _MONITOR_BLOCK),
    ]
)
assert MONITOR_PACKET.itemsize == 196
_MONITOR_START: Final = 1
_MONITOR_END: Final = 255
_ROBMON: Final = np.dtype(
    [
        ("moving", "<f4", 5),
        ("states", "<i2", 3),
        ("program", "S6"),
        ("temperature", "<i2"),
        ("unused", "<u2"),
        ("counter", "<u4"),
    ]
)
_TEMPERATURE: Final = 352
"""Tenths of a degree in the controller, which is not simulated."""
_FEEDBACK: Final = frozenset((7, 8, 9, 1007, 1008))
_DEGREES: Final = 1000
"""From here on angles are degrees."""


class MxtMonitor:
    """arm: gives where it is now. program: name and step of slot 1. port: UDP, 0 for any."""

    def __init__(
        self,
        arm: Callable[[], MxtArm],
        signals: Signals | None = None,
        *,
        program: Callable[[], tuple[str, int]] = lambda: ("", 0),
        host: str = "127.0.0.1",
        port: int = 0,
        cycle: float = CYCLE,
    ) -> None:
        self._arm, self._program = arm, program
        self._signals = signals or Bits()
        self._place, self._cycle = (host, port), cycle
        self._over = threading.Event()
        self._counter = 0
        self._sent = 0

    def __enter__(self) -> Self:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(self._place)
        self._socket.setblocking(False)
        self._thread = threading.Thread(target=self._run, name="mxt-monitor", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()

    @property
    def port(self) -> int:
        return int(self._socket.getsockname()[1])

    def _run(self) -> None:
        asked: tuple[np.void, tuple[str, int]] | None = None
        while not self._over.wait(self._cycle):
            self._counter += 1
            asked = self._heard(asked)
            if asked is not None:
                packet, receiver = asked
                try:
                    self._socket.sendto(self._told(packet), receiver)
                except OSError:
                    asked = None

    def _heard(
        self, asked: tuple[np.void, tuple[str, int]] | None
    ) -> tuple[np.void, tuple[str, int]] | None:
        while True:
            try:
                data, sender = self._socket.recvfrom(2048)
            except BlockingIOError:
                return asked
            except ConnectionError:
                continue
            if len(data) != MONITOR_PACKET.itemsize:
                continue
            packet = np.frombuffer(data, MONITOR_PACKET)[0]
            if int(packet["Command"]) == _MONITOR_START:
                # The client that asked last gets the packets.
                asked = (packet, sender)
            elif int(packet["Command"]) == _MONITOR_END:
                asked = None

    def _told(self, packet: np.void) -> bytes:
        self._sent += 1
        told = np.zeros((), MONITOR_PACKET)
        for name in ("Command", "InputTop", "OutputTop"):
            told[name] = packet[name]
        told["Input"] = self._word(2, int(packet["InputTop"]))
        told["Output"] = self._word(1, int(packet["OutputTop"]))
        told["Counter"] = self._sent & 0xFFFFFFFF
        for i in range(1, 5):
            told[f"Type{i}"] = packet[f"Type{i}"]
            told[f"Data{i}"] = self._data(int(packet[f"Type{i}"]))
        return told.tobytes()

    def _word(self, kind: int, first: int) -> int:
        low, high = self._signals.read(kind, first), self._signals.read(kind, first + 16)
        return low | high << 16

    def _data(self, kind: int) -> bytes:
        """Return 40 bytes of a data type; zeros for types that a simulated arm has no values
        for.
        """
        arm = self._arm()
        joints = arm.fed_back if kind in _FEEDBACK else arm.commanded
        numbers = np.zeros(10, dtype="<f4")
        # Types from 1001 on are the same data in degrees.
        match kind % _DEGREES:
            case 1 | 7:
                pose = arm.pose(joints)
                pose[3:] = np.degrees(pose[3:]) if kind > _DEGREES else pose[3:]
                numbers[:6] = pose
            case 2 | 8:
                numbers[arm.places] = joints if kind > _DEGREES else arm.radians(joints)
            case 3 | 9:
                pulses = np.zeros(10, dtype="<i4")
                pulses[arm.places] = np.round(joints * PULSES)
                return pulses.tobytes()
            case 12:
                return self._robot()
        return numbers.tobytes()

    def _robot(self) -> bytes:
        robot = np.zeros((), _ROBMON)
        name, step = self._program()
        robot["states"] = (0, 0, step)
        robot["program"] = name.encode("ascii", "replace")[:6]
        robot["temperature"] = _TEMPERATURE
        robot["counter"] = self._counter & 0xFFFFFFFF
        return robot.tobytes()


_CYCLE_TIMES: Final = {"melfa-basic-6": 0.0035}
"""Language → seconds of a cycle: CR800; 7.11 ms of all others (BFP-A3379-A, 2.2.2)."""


class RealTime:
    """lines, commands: for programs. port: UDP, of `Mxt`, 0 for any that is free.

    monitor_port: of the monitor, which is there where MONMODE is 1 as the controller starts.
    """

    def __init__(self, state: CrState, host: str, port: int, monitor_port: int) -> None:
        self._state, self._host, self._monitor_port = state, host, monitor_port
        self.port = port or _free_port(host)
        self.cycle = _CYCLE_TIMES.get(state.language, CYCLE)
        self._monitor: MxtMonitor | None = None
        self.lines: dict[str, Line] = {"ENET:": Enet()}
        self.commands = mxt_commands(
            host=host,
            port=self.port,
            cycle=self.cycle,
            timeout=lambda: int(state.parameters["MXTTOUT"][0]),
        )

    @property
    def monitor_port(self) -> int | None:
        """None while there is no monitor."""
        return None if self._monitor is None else self._monitor.port

    def start(self) -> None:
        """Begin to report the arm's state; raises OSError if the port is taken."""
        if self._state.parameters["MONMODE"] == ("1",):
            self._monitor = MxtMonitor(
                self._arm, host=self._host, port=self._monitor_port, cycle=self.cycle
            )
            self._monitor.__enter__()

    def shut(self) -> None:
        monitor, self._monitor = self._monitor, None
        if monitor is not None:
            monitor.__exit__()

    def _arm(self) -> MxtArm:
        """The arm as it stands now."""
        return MxtArm(self._state.robot, np.array(self._state.joints), self.cycle)


def _free_port(host: str) -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])
