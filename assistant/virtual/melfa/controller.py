"""A CR controller: programs by name, slots that run them side by side, and what slots share.

Facts about slots: COSIROP help on XRUN, XSTP, XRST, XCLR, XLOAD, GETM, RELM, PRIORITY and SLT*.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.diagnostics import has_errors
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.virtual.kernel import Kernel
from assistant.virtual.melfa import pausing
from assistant.virtual.melfa.arm import Arm
from assistant.virtual.melfa.code import Code, code_of
from assistant.virtual.melfa.lines import Line
from assistant.virtual.melfa.machine import Machine
from assistant.virtual.melfa.memory import OWN_ARRAY, OWN_ELEMENTS, Memory, Scope, Storage
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.plugins import commands_by_name
from assistant.virtual.melfa.slots import Slot
from assistant.virtual.melfa.stops import Failed
from assistant.virtual.melfa.world import World

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.melfa.plugins import Commands

DEFAULT_SLOTS: Final = 8
"""As the parameter TASKMAX is set by the maker; 32 at most."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A row of the slot table, the parameters SLT1 to SLT32, with the maker's settings.

    mode: `REP` begins again behind the end of the program, `CYC` stops there. condition: `START`
    programs begin with the start signal, `ALWAYS` programs with the power, `ERROR` programs when
    an error stops the others. lines: that run until the next slot has its turn.
    """

    program: str = ""
    mode: Literal["REP", "CYC"] = "REP"
    condition: Literal["START", "ALWAYS", "ERROR"] = "START"
    lines: int = 1


class Controller:
    """programs: by their names. table: slots that are not set as the maker sets them.

    start: the flange in the robot's base before the first move. joints: of the arm then, degrees.
    base: the user base program (PRGUSR), which declares further external variables. always_may:
    whether programs that always run may start and stop others (ALWENA is 7). lines: by what `Open`
    calls them, as `COM1:` and `ENET:`, with what they lead to. options, commands: see `run`.
    library: further programs by their names, which may change until they are first run. made: is
    told of each program that is made ready to run.
    """

    def __init__(
        self,
        kernel: Kernel,
        programs: Mapping[str, s.File],
        table: Mapping[int, Entry] | None = None,
        *,
        robot: Robot | None = None,
        start: Pose | None = None,
        joints: Sequence[float] | None = None,
        base: s.File | None = None,
        slots: int = DEFAULT_SLOTS,
        always_may: bool = False,
        lines: Mapping[str, Line] | None = None,
        options: Options | None = None,
        commands: Commands | None = None,
        library: Callable[[str], s.File | None] | None = None,
        made: Callable[[str, Machine], None] | None = None,
    ) -> None:
        self.kernel = kernel
        self.arm = Arm(robot, start)
        standing = kernel.motion.where()
        if joints is not None:
            self.arm.at_joints(tuple(joints))
        elif standing is not None:
            self.arm.at_joints(standing[1])
        self.always_may = always_may
        self.options, self.commands = options or Options(), commands_by_name(commands)
        self.lines = {name.upper(): line for name, line in (lines or {}).items()}
        self.stored: dict[str, bytearray] = {}
        self.timers: dict[int, float] = {}
        self.error: Failed | None = None
        self.owner: Slot | None = None
        self.paused: Slot | None = None
        self.shared = Shared(None if base is None else code_of(base))
        self._files = {name.upper(): file for name, file in programs.items()}
        self._machines: dict[str, Machine] = {}
        self._library, self._made = library, made
        rows = table or {}
        self.slots = [Slot(self, n, rows.get(n, Entry())) for n in range(1, slots + 1)]

    # ----------------------------------------------------------------------------- slots

    def slot(self, number: int) -> Slot:
        if not 1 <= number <= len(self.slots):
            raise Failed(3880, f"there is no slot {number}")
        return self.slots[number - 1]

    def start(self) -> None:
        """The power is on, and the start signal comes: all slots begin but those for errors."""
        for slot in self.slots:
            if slot.program and slot.condition != "ERROR":
                slot.run()

    def fail(self, where: Slot, failed: Failed) -> None:
        """An error of one slot stops all others but those that always run; some begin with it."""
        self.error = failed
        for slot in self.slots:
            if slot.condition == "START" and slot is not where:
                slot.stop()
            elif slot.condition == "ERROR" and slot.program and slot.state == "reset":
                slot.run()

    @property
    def handles(self) -> bool:
        """Whether a program that begins with an error still runs."""
        return any(slot.condition == "ERROR" and slot.state == "runs" for slot in self.slots)

    # ----------------------------------------------------------------------------- lines

    def line(self, name: str) -> Line:
        """A communication line by what `Open` calls it; what stands behind its colon may miss."""
        found = self.lines.get(name) or self.lines.get(name.partition(":")[0] + ":")
        if found is None:
            raise Failed(3140, f"nothing is connected to the line {name}")
        return found

    def uses(self, line: Line) -> bool:
        """Whether a program has opened a line."""
        worlds = [slot.world for slot in self.slots if slot.world is not None]
        return any(file.line is line for world in worlds for file in world.files.values())

    # -------------------------------------------------------------------------- programs

    def exists(self, name: str) -> bool:
        return self._file(name.upper()) is not None

    def _file(self, name: str) -> s.File | None:
        found = self._files.get(name)
        return self._library(name) if found is None and self._library is not None else found

    def variables(self, name: str) -> Memory | None:
        """The variables of a program, None of one that was not run since it was changed."""
        machine = self._machines.get(name.upper())
        return None if machine is None else machine.main

    def forget(self, name: str) -> None:
        """A program was changed: it is made ready anew when it runs next."""
        self._machines.pop(name.upper(), None)

    def selected(self, name: str) -> Slot | None:
        """The slot that a program is loaded in."""
        return next((slot for slot in self.slots if slot.program == name.upper()), None)

    def machine(self, name: str, world: World) -> Machine | None:
        """A program that a slot runs now; its variables keep their values from run to run."""
        name = name.upper()
        if name not in self._machines:
            file = self._file(name)
            if file is None:
                return None
            if has_errors(file.findings):
                raise Failed(4220, "; ".join(f.message for f in file.findings))
            self._machines[name] = Machine(code_of(file), world, {})
            if self._made is not None:
                self._made(name, self._machines[name])
        machine = self._machines[name]
        if machine.world is not world:
            if machine in machine.world.running:
                raise Failed(4180, f"the program {name} runs in another slot")
            machine.world, machine.programs = world, _Programs(self, world)
        elif not isinstance(machine.programs, _Programs):
            machine.programs = _Programs(self, world)
        return machine

    # ------------------------------------------------------------------------- mechanism

    def get(self, slot: Slot, mechanism: int) -> None:
        """`GetM`: only one slot moves the arm."""
        if mechanism != 1:
            raise Failed(3870, f"there is no mechanism {mechanism}")
        if self.owner is not None:
            raise Failed(3830, f"slot {self.owner.number} has mechanism {mechanism}")
        if self.paused is not slot:
            self.end_motion(self.paused)
        self.owner = slot

    def end_motion(self, slot: Slot | None) -> None:
        """A slot that was stopped on the way of a motion will not make it to its end."""
        if slot is not None and self.paused is slot and slot.world is not None:
            self.paused = None
            pausing.cut_motion(slot.world)

    def release(self, slot: Slot) -> bool:
        """Whether the slot had the mechanism."""
        had = self.owner is slot
        if had:
            self.owner = None
        return had


class _Programs(Mapping[str, Machine]):
    """What `CallP` of one slot finds."""

    def __init__(self, controller: Controller, world: World) -> None:
        self._controller, self._world = controller, world

    def __getitem__(self, name: str) -> Machine:
        machine = self._controller.machine(name, self._world)
        if machine is None:
            raise Failed(4140, f"there is no program {name}")
        return machine

    def __iter__(self) -> Iterator[str]:
        return iter(self._controller._files)

    def __len__(self) -> int:
        return len(self._controller._files)


OWN_VARIABLES: Final = re.compile(r"[PJMC]_[01]\d")
"""External variables that every controller has, beside its arrays."""


class Shared(Memory):
    """Variables of all programs: the controller's own, and those that a base program declares."""

    def __init__(self, base: Code | None) -> None:
        super().__init__(Scope() if base is None else base.main)
        for name, index, value in base.data if base is not None else ():
            self.place(name).set(value, index)

    def place(self, name: str) -> Storage:
        if name not in self.places:
            if OWN_ARRAY.fullmatch(name):
                self.scope.sizes[name] = (OWN_ELEMENTS,)
            elif not OWN_VARIABLES.fullmatch(name) and name not in self.scope.declared | set(
                self.scope.kinds
            ):
                raise Failed(4341, f"no base program declares the external variable {name}")
        return super().place(name)
