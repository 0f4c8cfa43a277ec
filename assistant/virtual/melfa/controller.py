"""A CR controller: programs by name, slots that run them side by side, and what slots share.

A slot has a program that runs, waits or is reset. Statements about slots: XRun, XStp, XRst, XClr,
XLoad, GetM, RelM, Priority. Facts: COSIROP help on each of them and on SLT*; lists of errors for
their numbers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final, Literal

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import has_errors
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.program.geometry import Pose
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.melfa import arm_state, expressions
from assistant.virtual.melfa.arm_state import Arm
from assistant.virtual.melfa.code import Code, code_of
from assistant.virtual.melfa.communication_lines import Line
from assistant.virtual.melfa.machine import Machine, call_levels, statement_place
from assistant.virtual.melfa.options import Options
from assistant.virtual.melfa.values import (
    OWN_ARRAY,
    OWN_ELEMENTS,
    Failed,
    Memory,
    Scope,
    Storage,
    Unknown,
    out_of_range,
    text,
)
from assistant.virtual.melfa.world import World, commands_by_name

if TYPE_CHECKING:
    from assistant.robots import Robot
    from assistant.virtual.melfa.world import Commands


State = Literal["reset", "runs", "waits"]


class Slot:
    """program: upper-case name, empty for none. mode, condition, lines: see Entry.

    world: of the program that runs, or of the one that ran last. first_line: the number of the line
    that the program begins with when it is run next, None for its top.
    """

    def __init__(self, controller: Controller, number: int, entry: Entry) -> None:
        self.controller: Controller = controller
        self.number = number
        self.program, self.mode = entry.program.upper(), entry.mode
        self.condition, self.lines = entry.condition, entry.lines
        self.world: World | None = None
        self.first_line: int | None = None
        self._task: Task | None = None
        self._stops = self._held = False

    @property
    def state(self) -> State:
        """`reset` also where no program is loaded; `waits` where one was stopped on its way."""
        if self._task is None:
            return "reset"
        return "waits" if self._held else "runs"

    # ---------------------------------------------------------------------- what others say

    def load(self, program: str) -> None:
        """`XLoad`: selects a program; raises Failed."""
        name = program.upper()
        if self.state != "reset":
            raise Failed(3360, f"slot {self.number} is not reset")
        if not self.controller.exists(name):
            raise Failed(4140, f"there is no program {program}")
        other = self.controller.selected(name)
        if other not in (None, self):
            raise Failed(4190, f"the program {program} is selected for another slot")
        self.program = name

    def run(self) -> None:
        """`XRun`: from the top, or on from where the program was stopped."""
        if self.state == "runs":
            raise Failed(3310, f"slot {self.number} runs")
        if not self.program:
            raise Failed(3320, f"slot {self.number} has no program")
        if self.state == "waits":
            self._held = False
            return
        kernel = self.controller.kernel
        essential = self.condition == "START"
        self._task = kernel.task(str(self.number), self._body, self.lines, essential)
        self._task.prompt()

    def stop(self) -> None:
        """`XStp`: before the next statement of the program, or in its wait."""
        if self.state == "runs" and not self._stops and self._task is not None:
            self._stops = True
            self._task.post(self.hold)

    def reset(self) -> None:
        """`XRst`: a program that was stopped will begin at its top."""
        if self.state == "runs":
            raise Failed(3350, f"slot {self.number} runs")
        if self._task is not None:
            task, self._task = self._task, None
            self.controller.kernel.drop(task)

    def end(self) -> None:
        """The power goes off: the program is where it is no more."""
        task, self._task = self._task, None
        if task is not None:
            self.controller.kernel.drop(task)

    def clear(self) -> None:
        """`XClr`: no program is selected."""
        if not self.program:
            raise Failed(3370, f"slot {self.number} has no program")
        if self.state != "reset":
            raise Failed(3380, f"slot {self.number} is not reset")
        self.program = ""

    def rank(self, lines: int) -> None:
        """`Priority`: statements until the next slot has its turn."""
        self.lines = lines
        if self._task is not None:
            self._task.lines = lines

    # ------------------------------------------------------------------------- in its task

    def hold(self) -> None:
        """Waits until the program is started again; a stopped one gives the arm up meanwhile."""
        task = self._task
        assert task is not None
        controller, world = self.controller, self.world
        assert world is not None
        paused = arm_state.pause_arm(world, late=False)
        # Remember whose motion is paused: the arm is free for other slots meanwhile.
        controller.paused = self if paused else controller.paused
        had = controller.release(self)
        # A slot that waits for its start does not keep the run from ending.
        self._held, self._stops, task.essential = True, False, False
        task.wait(lambda: not self._held, what=f"slot {self.number} waits for its start")
        task.essential = self.condition == "START"
        if had:
            # Going on needs the arm, which another slot may have taken.
            controller.get(self, 1)
        if paused:
            if controller.paused is not self:
                raise Unknown("how a stopped motion goes on that another slot has ended")
            controller.paused = None
            arm_state.resume_arm(world)

    def _body(self, task: Task) -> Ending:
        controller = self.controller
        world = World(task, controller.arm, timers=controller.timers, shared=controller.shared)
        world.options, world.commands = controller.options, controller.commands
        world.slot, self.world = self, world
        task.where, task.levels = (lambda: statement_place(world)), (lambda: call_levels(world))
        try:
            self._cycles(world)
        except Failed as failed:
            return self._failed(task, failed)
        except Unknown as unknown:
            return Ending("unknown", f"slot {self.number}: {unknown}", task.where())
        finally:
            self._leave(world)
        return Ending()

    def _cycles(self, world: World) -> None:
        controller = self.controller
        machine = controller.machine(self.program, world)
        if machine is None:
            raise Failed(4140, f"there is no program {self.program}")
        # Slot 1 has the arm from the beginning (COSIROP: GETM).
        if self.number == 1 and controller.owner is None:
            controller.get(self, 1)
        if self.first_line is not None:
            machine.first, self.first_line = machine.code.numbers.get(self.first_line, 0), None
        while True:
            before = controller.kernel.steps
            machine.run()
            if self.mode == "CYC":
                return
            # It would begin again for ever without giving other slots a turn.
            if controller.kernel.steps == before:
                raise Failed(3286, f"the program {self.program} is empty")

    def _failed(self, task: Task, failed: Failed) -> Ending:
        """The others stop; programs for errors run to their end before the run is over."""
        place = task.where()
        if self.condition != "ERROR":
            self.controller.fail(self, failed)
            task.wait(lambda: not self.controller.handles, what="a program that begins with errors")
        return Ending("error", f"slot {self.number}: {failed}", place)

    def _leave(self, world: World) -> None:
        """The program is reset; slot 1 keeps the arm, as it has it from the beginning.

        When the whole run is over, the slot stays as it is, to be looked at.
        """
        world.close_files()
        if self.controller.kernel.ending is not None:
            return
        self._task, self._held, self._stops = None, False, False
        self.controller.end_motion(self)
        if self.number != 1:
            self.controller.release(self)
        for machine in world.running:
            machine.depth = 0
        world.running.clear()


DEFAULT_SLOTS: Final = 8
"""Value of the parameter TASKMAX as delivered; 32 at most."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A row of the slot table, the parameters SLT1 to SLT32, with the maker's settings.

    mode: `REP` begins again after the end of the program, `CYC` stops there. condition: `START`
    programs begin with the start signal, `ALWAYS` programs with the power, `ERROR` programs when an
    error stops the others. lines: number of lines that run until the next slot has its turn.
    """

    program: str = ""
    mode: Literal["REP", "CYC"] = "REP"
    condition: Literal["START", "ALWAYS", "ERROR"] = "START"
    lines: int = 1


class Controller:
    """A controller with its slots. programs: by their names. table: slots that differ from the
    maker's settings.

    start: the flange in the robot base before the first move. joints: those of the arm then,
    degrees. base: the user base program (PRGUSR), which declares further external variables.
    always_may: whether programs that always run may start and stop others (ALWENA is 7). lines:
    communication lines by the names that `Open` uses, as `COM1:` and `ENET:`. options, commands:
    see `run`. library: further programs by their names, which may change until they are first run.
    made: is called with each program that is made ready to run.
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
        self.shared = _Shared(None if base is None else code_of(base))
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
        """True if a program that begins with an error still runs."""
        return any(slot.condition == "ERROR" and slot.state == "runs" for slot in self.slots)

    # ----------------------------------------------------------------------------- lines

    def line(self, name: str) -> Line:
        """Return a communication line by its name in `Open`; the part after its colon is
        optional.
        """
        found = self.lines.get(name) or self.lines.get(name.partition(":")[0] + ":")
        if found is None:
            raise Failed(3140, f"nothing is connected to the line {name}")
        return found

    def uses(self, line: Line) -> bool:
        """True if a program has opened a line."""
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
        # A program keeps its variables, but runs in the world of the slot that runs it now.
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
        # The new owner may move the arm, so a motion that is paused will not go on.
        if self.paused is not slot:
            self.end_motion(self.paused)
        self.owner = slot

    def end_motion(self, slot: Slot | None) -> None:
        """A slot that was stopped on the way of a motion will not make it to its end."""
        if slot is not None and self.paused is slot and slot.world is not None:
            self.paused = None
            arm_state.cut_motion(slot.world)

    def release(self, slot: Slot) -> bool:
        """Release the mechanism; True if the slot had it."""
        had = self.owner is slot
        if had:
            self.owner = None
        return had


class _Programs(Mapping[str, Machine]):
    """Programs that `CallP` of one slot finds."""

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


_OWN_VARIABLES: Final = re.compile(r"[PJMC]_[01]\d")
"""External variables that every controller has, beside its arrays."""


class _Shared(Memory):
    """Variables of all programs: the controller's own, and those that a base program declares."""

    def __init__(self, base: Code | None) -> None:
        super().__init__(Scope() if base is None else base.main)
        for name, index, value in base.data if base is not None else ():
            self.place(name).set(value, index)

    def place(self, name: str) -> Storage:
        if name not in self.places:
            if OWN_ARRAY.fullmatch(name):
                self.scope.sizes[name] = (OWN_ELEMENTS,)
            elif not _OWN_VARIABLES.fullmatch(name) and name not in self.scope.declared | set(
                self.scope.kinds
            ):
                raise Failed(4341, f"no base program declares the external variable {name}")
        return super().place(name)


_RUN_MODES: Final[Mapping[int, Literal["REP", "CYC"]]] = {0: "REP", 1: "CYC"}
_MOST_LINES: Final = 31


def _own_slot(m: Machine) -> Slot:
    if m.world.slot is None:
        raise Unknown("slots of a program that runs without a controller")
    return m.world.slot


def _slot_of(m: Machine, node: s.Expression) -> Slot:
    """The slot that a statement about another program names."""
    own = _own_slot(m)
    if own.condition == "ALWAYS" and not own.controller.always_may:
        raise Unknown("what a program that always runs does to others where ALWENA is not 7")
    return own.controller.slot(expressions.integer(m, node, "the slot"))


def _load_slot(m: Machine, slot: s.Expression, program: s.Expression) -> None:
    _slot_of(m, slot).load(text(expressions.value(m, program), "the name of a program"))


def _run_slot(
    m: Machine, node: s.Expression, program: s.Expression | None = None, *more: s.Expression | None
) -> None:
    slot = _slot_of(m, node)
    if slot.state == "runs":
        raise Failed(3310, f"slot {slot.number} runs")
    if program is not None:
        name = text(expressions.value(m, program), "the name of a program")
        if slot.state == "reset":
            slot.load(name)
        elif name.upper() != slot.program:
            raise Unknown("XRun of another program than the one that was stopped")
    if more and more[0] is not None:
        mode = expressions.integer(m, more[0], "the operation mode")
        if mode not in _RUN_MODES:
            raise out_of_range(f"the operation mode {mode}")
        slot.mode = _RUN_MODES[mode]
    slot.run()


def _stop_slot(m: Machine, node: s.Expression) -> None:
    slot = _slot_of(m, node)
    if not slot.program:
        raise Failed(3330, f"slot {slot.number} has no program")
    slot.stop()


def _reset_slot(m: Machine, node: s.Expression) -> None:
    slot = _slot_of(m, node)
    if not slot.program:
        raise Failed(3340, f"slot {slot.number} has no program")
    slot.reset()


def _get_mechanism(m: Machine, node: s.Expression) -> None:
    slot = _own_slot(m)
    slot.controller.get(slot, expressions.integer(m, node, "the mechanism"))


def _release_mechanism(m: Machine) -> None:
    slot = _own_slot(m)
    if slot.condition == "ALWAYS" or not slot.controller.release(slot):
        raise Unknown("RelM without a mechanism")


def _set_priority(m: Machine, lines: s.Expression, *node: s.Expression) -> None:
    count = expressions.integer(m, lines, "the lines of a turn")
    if not 1 <= count <= _MOST_LINES:
        raise out_of_range(f"a turn of {count} lines")
    slot = _own_slot(m)
    if node:
        slot = slot.controller.slot(expressions.integer(m, node[0], "the slot"))
        if not slot.program:
            raise Failed(None, f"slot {slot.number} has no program")
    slot.rank(count)


SLOT_WORDS: Final[Mapping[str, Callable[..., None]]] = {
    "XLOAD": _load_slot,
    "XRUN": _run_slot,
    "XSTP": _stop_slot,
    "XRST": _reset_slot,
    "XCLR": lambda m, node: _slot_of(m, node).clear(),
    "GETM": _get_mechanism,
    "RELM": _release_mechanism,
    "PRIORITY": _set_priority,
}
