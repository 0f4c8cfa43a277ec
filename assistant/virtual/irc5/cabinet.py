"""The cabinet of an IRC5: panel, event log, programs, signals, system parameters and backups.

Handlers of requests use it from their threads. All data of the programs is only touched in the
thread of the kernel, through `do`. System parameters are stored, read, saved and loaded; changes
after the start have no other effect here, as a real controller takes most of them over at its next
start. A backup has the layout that controllers write (reference, 4.3): `BACKINFO`, `HOME`,
`RAPID/TASK1/PROGMOD` and `SYSMOD`, `SYSPAR`; a restore brings the files of HOME:, the modules and
the system parameters back.
"""

from __future__ import annotations

import re
import shutil
import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from datetime import datetime, timedelta
from pathlib import Path as FilePath
from typing import Final, Literal, TypeVar, get_args

from assistant.base.data_classes import dataclass
from assistant.base.file_access import UNFINISHED, read_file, read_text, write_whole
from assistant.base.source_text import lines_of
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.walk import nodes
from assistant.robots import Robot
from assistant.virtual.irc5 import egm_instructions
from assistant.virtual.irc5.panel import EventLog, Panel
from assistant.virtual.irc5.programs import TASK, Programs, read_module
from assistant.virtual.kernel import Board, Instant, Kernel, Live
from assistant.virtual.kernel.kernel import Standing
from assistant.virtual.program_run import BUSY_TIME
from assistant.virtual.rapid.controller import used_signals
from assistant.virtual.rapid.disk import Disk

PARAMETER_DOMAINS: Final = ("EIO", "MMC", "MOC", "PROC", "SIO", "SYS")
CFG_HEAD: Final = "{domain}:CFG_1.0:6:1::\n"
_CFG_HEAD: Final = re.compile(r"\s*(\w+):CFG_[\d.]+:")
_CFG_TYPE: Final = re.compile(r"^(\w+):[ \t]*$", re.MULTILINE)
_CFG_ATTRIBUTE: Final = re.compile(r'-(\w+)(?:[ \t]+("[^"]*"|[^\s"-][^\s"]*|-[\d.][^\s"]*))?')
INSTANCE_NAME: Final = ("Name", "name")
LoadMethod = Literal["add", "replace", "add-with-reset"]

Instance = dict[str, str]


class _Parameters:
    """values: attributes by domain, type and instance."""

    def __init__(self, signals: Iterable[Signal], robot: str) -> None:
        rows = {
            one.name: {"Name": one.name, "SignalType": one.type, "Device": one.device}
            for one in signals
        }
        task = {"Name": TASK, "Type": "NORMAL", "Entry": "main", "MotionTask": "TRUE"}
        unit = {"name": "ROB_1", "use_robot_type": robot}
        self.values: dict[str, dict[str, dict[str, Instance]]] = {
            name: {} for name in PARAMETER_DOMAINS
        }
        self.values["EIO"]["EIO_SIGNAL"] = rows
        self.values["SYS"]["CAB_TASKS"] = {TASK: task}
        self.values["MOC"]["ROBOT"] = {"ROB_1": unit}

    def text(self, domain: str) -> str:
        """Return the parameters of a domain as its file."""
        said = [CFG_HEAD.format(domain=domain)]
        for type, instances in self.values[domain].items():
            said.append(f"#\n{type}:\n")
            for attributes in instances.values():
                row = " ".join(f'-{name} "{value}"' for name, value in attributes.items())
                said.append(f"\n      {row}\n")
        return "".join(said)

    def load(self, text: str, how: LoadMethod) -> None:
        """Load a file of parameters; raises ValueError for an invalid file or an instance that
        exists.

        how: `add` only new instances, `replace` existing ones too, `add-with-reset` all of a type.
        """
        domain, types = parse_cfg(text)
        kept = self.values[domain]
        if how == "add":
            for type, instances in types.items():
                both = set(instances) & set(kept.get(type, {}))
                if both:
                    raise ValueError(f"{type} {min(both)} is there already")
        for type, instances in types.items():
            before = {} if how == "add-with-reset" else kept.get(type, {})
            kept[type] = {**before, **instances}


def parse_cfg(text: str) -> tuple[str, dict[str, dict[str, Instance]]]:
    """The domain of a file, and what it holds; raises ValueError."""
    head = _CFG_HEAD.match(text)
    if head is None or head[1].upper() not in PARAMETER_DOMAINS:
        raise ValueError("it does not begin with the name of a domain")
    found: dict[str, dict[str, Instance]] = {}
    lines = "\n".join(line for line in lines_of(text)[1:] if not line.lstrip().startswith("#"))
    places = list(_CFG_TYPE.finditer(lines))
    ends = [*(place.start() for place in places[1:]), len(lines)]
    # A type lasts until the next one begins.
    for place, end in zip(places, ends, strict=False):
        # A backslash at the end of a line continues it.
        body = lines[place.end() : end].replace("\\\n", " ")
        instances = found.setdefault(place[1], {})
        for row in lines_of(body):
            attributes = {
                name: (value or "TRUE").strip('"') for name, value in _CFG_ATTRIBUTE.findall(row)
            }
            if attributes:
                own = next((attributes[key] for key in INSTANCE_NAME if key in attributes), None)
                # Types without names count their instances.
                instances[own or str(len(instances))] = attributes
    return head[1].upper(), found


SignalType = Literal["DI", "DO", "GI", "GO", "AI", "AO"]
SIGNAL_TYPES: Final[Mapping[str, SignalType]] = {name: name for name in get_args(SignalType)}
OUTPUT_TYPES: Final = ("DO", "GO", "AO")
MOST_STEPS: Final = 10**15
MASTERSHIP_DOMAINS: Final = ("cfg", "motion", "rapid")
_NETWORK, DEVICE = "Local", "DRV_1"
"""Network and device of a signal without stated ones, as public clients expect it
(rpiRobotics/abb_robot_client, rws.py).
"""
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
    network: str = _NETWORK
    device: str = DEVICE

    @property
    def title(self) -> str:
        return f"{self.network}/{self.device}/{self.name}" if self.network else self.name


@dataclass(eq=False)
class _Mastership:
    """Who may change what. holders: by domain, the key of a session or the name of who is there."""

    holders: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._lock = threading.Lock()

    def take(self, domains: tuple[str, ...], who: str) -> bool:
        """Take mastership of all the domains or of none; True if it was taken."""
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
        self.mastership = _Mastership()
        self.behind: dict[str, BackgroundTask] = {}
        """Tasks in the background, by name: they are there, and nothing in them is simulated."""
        self.serial = ""
        """Number of the controller; virtual ones tell none, unless they have to."""
        self.grants = False
        """True if the pendant grants every request to modify in manual mode."""
        self.live = Live(self._kernel, rate=rate, ended=self._ended, name="virtual-irc5-kernel")
        self.board = Board()
        self.parameters = _Parameters(self.given.values(), "" if robot is None else robot.title)
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
            from assistant.virtual.kernel.timed_arm import Timed

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


_BACKUP_FOLDERS: Final = {False: "PROGMOD", True: "SYSMOD"}
"""By whether a module is a SYSMODULE."""
_MODULE_FOLDER_SUFFIXES: Final = {False: ".mod", True: ".sys"}


def back_up(programs: Programs, target: FilePath, cabinet: Cabinet) -> None:
    """Makes a folder, which appears whole or not at all; raises OSError."""
    # Hidden beside its place until it is complete: readers see no half backup.
    beside = target.with_name(f"{UNFINISHED}{target.name}")
    shutil.rmtree(beside, ignore_errors=True)
    try:
        _write_backup(programs, beside, cabinet)
        beside.replace(target)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def _write_backup(programs: Programs, folder: FilePath, cabinet: Cabinet) -> None:
    home = cabinet.disk.folder("HOME")
    arriving = shutil.ignore_patterns(f"{UNFINISHED}*")
    (folder / "BACKINFO").mkdir(parents=True)
    told = f">>SYSTEM_ID:\n{cabinet.name}\n\n>>PRODUCTS_ID:\nRobotWare\n\n>>TASK1: ({TASK},,)\n"
    (folder / "BACKINFO" / "backinfo.txt").write_text(told, "latin-1")
    shutil.copytree(home, folder / "HOME", ignore=arriving)
    for system in (False, True):
        (folder / "RAPID" / "TASK1" / _BACKUP_FOLDERS[system]).mkdir(parents=True)
    for one in programs.modules.values():
        file = (
            folder
            / "RAPID"
            / "TASK1"
            / _BACKUP_FOLDERS[one.system]
            / f"{one.name}{_MODULE_FOLDER_SUFFIXES[one.system]}"
        )
        file.write_bytes(programs.text(one).encode("latin-1", "replace"))
    (folder / "SYSPAR").mkdir()
    for domain in PARAMETER_DOMAINS:
        text = cabinet.parameters.text(domain)
        (folder / "SYSPAR" / f"{domain}.cfg").write_text(text, "latin-1", "replace")


def is_backup(folder: FilePath) -> bool:
    return (folder / "BACKINFO").is_dir() and (folder / "RAPID").is_dir()


def restore(programs: Programs, source: FilePath, cabinet: Cabinet) -> None:
    """Raises NotPossible or ValueError for what cannot be loaded, and changes nothing; OSError."""
    files = sorted((source / "RAPID").glob("TASK1/*/*"))
    # All files are read and parsed before anything is changed.
    read = [one for file in files for one in read_module(file.name, read_file(file))]
    settings = [read_text(file, "latin-1") for file in sorted((source / "SYSPAR").glob("*.cfg"))]
    for text in settings:
        parse_cfg(text)
    home, kept = cabinet.disk.folder("HOME"), source / "HOME"
    programs.restore(read)
    for text in settings:
        cabinet.parameters.load(text, "add-with-reset")
    _restore_files(kept, home)


def _restore_files(kept: FilePath, home: FilePath) -> None:
    """Has a folder hold what another one does; each file of it is whole at any time."""
    wanted = {one.relative_to(kept): one for one in sorted(kept.rglob("*"))}
    for name, one in wanted.items():
        target = home / name
        # A file where a folder was, or the other way round.
        if target.exists() and target.is_dir() != one.is_dir():
            _remove_folder(target)
        if one.is_dir():
            target.mkdir(exist_ok=True)
        else:
            write_whole(target, one.read_bytes())
    # From the inside out: a folder is empty when its turn comes.
    for old in sorted(home.rglob("*"), reverse=True):
        if old.relative_to(home) not in wanted:
            _remove_folder(old)


def _remove_folder(old: FilePath) -> None:
    if old.is_dir() and not old.is_symlink():
        shutil.rmtree(old)
    else:
        old.unlink()
