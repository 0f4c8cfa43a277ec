"""What the cabinet of an IRC5 holds: panel, event log, programs, signals, files, and who commands.

Handlers of requests act upon it from threads of their own. What belongs to the programs is only
touched in the thread of the kernel, through `do`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path as FilePath
from typing import Final, Literal, TypeVar, get_args

from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.robots import Robot
from assistant.virtual.irc5 import egm_instructions
from assistant.virtual.irc5.panel import EventLog, Panel
from assistant.virtual.irc5.parameters import Parameters
from assistant.virtual.irc5.programs import Programs
from assistant.virtual.kernel import Board, Instant, Kernel, Live
from assistant.virtual.kernel.motion import Standing
from assistant.virtual.rapid.disk import Disk
from assistant.virtual.rapid.loading import used_signals
from assistant.virtual.running import BUSY_TIME

SignalType = Literal["DI", "DO", "GI", "GO", "AI", "AO"]
SIGNAL_TYPES: Final[Mapping[str, SignalType]] = {name: name for name in get_args(SignalType)}
OUTPUT_TYPES: Final = ("DO", "GO", "AO")
MOST_STEPS: Final = 10**15
MASTERSHIP_DOMAINS: Final = ("cfg", "motion", "rapid")
NETWORK, DEVICE = "Local", "DRV_1"
"""Where a signal is that nothing else is said of, as public clients expect it (rpiRobotics/
abb_robot_client, rws.py)."""
SYSTEM_ID: Final = "{0D0C1A55-0000-4000-8000-000000000001}"
VERSIONS: Final[Mapping[int, str]] = {1: "6.16.2027", 2: "7.21.0+229"}
"""RobotWare, of the controllers that the answers were captured from."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class BackgroundTask:
    """A task in the background. modules: the text of each, by name. kind: as it is configured."""

    kind: Literal["static", "semistatic"] = "semistatic"
    running: bool = True
    modules: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Signal:
    """A signal as the I/O configuration has it."""

    name: str
    type: SignalType
    network: str = NETWORK
    device: str = DEVICE

    @property
    def title(self) -> str:
        return f"{self.network}/{self.device}/{self.name}" if self.network else self.name


@dataclass(eq=False)
class Mastership:
    """Who may change what. holders: by domain, the key of a session or the name of who is there."""

    holders: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._lock = threading.Lock()

    def take(self, domains: tuple[str, ...], who: str) -> bool:
        """Of all domains or of none."""
        with self._lock:
            if any(self.holders.get(domain, who) != who for domain in domains):
                return False
            self.holders.update(dict.fromkeys(domains, who))
            return True

    def give_back(self, domains: tuple[str, ...], who: str) -> None:
        with self._lock:
            for domain in domains:
                if self.holders.get(domain) == who:
                    del self.holders[domain]


class Cabinet:
    """home: the folder that is HOME:. given: signals of the configuration, by name.

    devices: UdpUc devices that programs send EGM packets to, host and port by name. rate: simulated
    seconds for each real one.
    """

    def __init__(
        self,
        home: FilePath,
        *,
        name: str = "virtual-irc5",
        robot: Robot | None = None,
        given: Mapping[str, Signal] | None = None,
        devices: Mapping[str, tuple[str, int]] | None = None,
        rate: float = 1.0,
    ) -> None:
        self.name, self.robot = name, robot
        self.disk = Disk(home, outside=True)
        self.given = {name.lower(): one for name, one in (given or {}).items()}
        self.devices = dict(devices or {})
        self.offset = timedelta(0)
        self.began = datetime.now()
        self.log = EventLog(self.now)
        self.panel = Panel(self.log)
        self.mastership = Mastership()
        self.behind: dict[str, BackgroundTask] = {}
        """Tasks in the background, by name: they are there, and nothing in them is simulated."""
        self.serial = ""
        """Number of the controller; virtual ones tell none, unless they have to."""
        self.grants = False
        """Whether the pendant lets whoever asks modify in manual mode."""
        self.live = Live(self._kernel, rate=rate, ended=self._ended, name="virtual-irc5-kernel")
        self.board = Board()
        self.parameters = Parameters(self.given.values(), "" if robot is None else robot.title)
        self._used: tuple[int, dict[str, Signal]] = -1, {}
        self.programs: Programs

    def start(self) -> None:
        self.live.start()

    def stop(self) -> None:
        self.live.stop()

    def now(self) -> datetime:
        return datetime.now() + self.offset

    def do(self, command: Callable[[Programs], T]) -> T:
        """Carries out what belongs to the programs, between two of their statements."""
        return self.live.do(lambda _: command(self.programs))

    def _kernel(self) -> Kernel:
        if self.robot is None:
            motion = None
        else:
            from assistant.virtual.motion import Timed

            motion = Timed(self.robot)
        kernel = Kernel(self.board, motion or Instant(), most_steps=MOST_STEPS, busy_time=BUSY_TIME)
        abilities = egm_instructions.abilities(self.devices)
        self.programs = Programs(kernel, self.disk, self.log, self.robot, abilities)
        return kernel

    def _ended(self, task: object, ending: object) -> None:
        from assistant.virtual.kernel import Ending, Task

        assert isinstance(task, Task)
        assert isinstance(ending, Ending)
        self.programs.ended(task, ending)

    # ---------------------------------------------------------------------------- safety

    def press_emergency_stop(self) -> None:
        """The arm stops on its way, and the motors go off."""
        self.panel.press()
        self.do(lambda programs: programs.fail("the emergency stop was pressed"))

    def release_emergency_stop(self) -> None:
        self.panel.release()

    # --------------------------------------------------------------------------- signals

    def signals(self) -> dict[str, Signal]:
        """By name in lower case: those of the configuration and those that programs use."""
        return self.do(self._signals)

    def _signals(self, programs: Programs) -> dict[str, Signal]:
        if self._used[0] != programs.changes:
            trees = [one.tree for one in programs.modules.values()]
            outputs, known = used_signals(trees)
            used = nodes(tuple(tree.parts for tree in trees))
            names = {one.name.lower(): one.name for one in used if isinstance(one, s.NameRef)}
            found = {
                name: Signal(names.get(name, name), "DO" if name in outputs else "DI")
                for name in known
            }
            self._used = programs.changes, found | self.given
        return self._used[1]

    def read(self, signal: Signal) -> float:
        side = self.board.outputs if signal.type in OUTPUT_TYPES else self.board.inputs
        return self.live.do(lambda _: side.read(signal.name.lower()))

    def write(self, signal: Signal, value: float) -> None:
        """An output as a program would, an input as what is connected does."""
        side = self.board.outputs if signal.type in OUTPUT_TYPES else self.board.inputs
        self.live.do(lambda _: side.set(signal.name.lower(), value))

    # ------------------------------------------------------------------------------- arm

    def standing(self) -> Standing | None:
        return self.live.do(lambda kernel: kernel.motion.where())
