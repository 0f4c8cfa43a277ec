"""Statements and interrupts of a pseudo-program, and the start of one in a kernel.

`assistant.program.statements` states what interrupts mean.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from functools import partial
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.source_text import SourceText, lines_of
from assistant.program import statements as p
from assistant.program.expressions import Elapsed, Expression
from assistant.program.geometry import Pose
from assistant.program.program import Procedure, Program
from assistant.program.pseudo.expressions import expression_text
from assistant.program.rewriting import records
from assistant.robots import Robot
from assistant.virtual.events import Said, Stopped
from assistant.virtual.kernel import Ending, Kernel, Task
from assistant.virtual.kernel.kernel import Instant
from assistant.virtual.pseudo import motion
from assistant.virtual.pseudo.expressions import condition, evaluate, numeric, place, truth_or
from assistant.virtual.pseudo.machine import (
    MOST_CALLS,
    Call,
    Cell,
    Fault,
    Jump,
    Machine,
    NotRun,
    Over,
    Returned,
    Value,
    copied,
    first_value,
    value_text,
)

_LOOK_PERIOD: Final = 0.0071
"""Seconds between two looks at what time alone changes, as controllers of MELFA-BASIC have it."""


@dataclass(slots=True, eq=False)
class Interrupts:
    """Those of a program: as they were defined, by lower-case name, and which of them are on.

    run: makes the call of one, in the call that it was defined in.
    """

    machine: Machine
    run: Callable[[p.Call], None]
    known: dict[str, tuple[p.Interrupt, Call]] = field(default_factory=dict)
    on: set[str] = field(default_factory=set)
    open: bool = True
    busy: bool = False

    def look(self) -> None:
        """Runs what is due now."""
        # An interrupt's own call changes what others see: look again until none is due.
        while not self.busy and (due := self._due()) is not None:
            self._answer(*due)

    def _due(self) -> tuple[p.Interrupt, Call] | None:
        if not self.open:
            return None
        # The first one defined has the highest priority.
        for name, (node, frame) in self.known.items():
            if name in self.on and self._within(frame, partial(self._holds, node)):
                return node, frame
        return None

    def _holds(self, node: p.Interrupt) -> bool:
        kernel = self.machine.task.kernel
        kernel.looking = True
        try:
            return condition(self.machine, node.condition)
        finally:
            kernel.looking = False

    def _within(self, frame: Call, does: Callable[[], Any]) -> Any:
        """Evaluate a function in the call in which an interrupt was defined."""
        calls, self.busy = self.machine.calls, True
        # Names of the condition are those of the procedure that defined the interrupt.
        calls.append(frame)
        try:
            return does()
        finally:
            calls.pop()
            self.busy = False

    def _answer(self, node: p.Interrupt, frame: Call) -> None:
        kernel = self.machine.task.kernel
        stands = kernel.motion.stands()
        # The arm stops on its way for the call, and goes on afterwards.
        if not stands:
            kernel.motion.hold(kernel)
        before = self.machine.flange
        self._within(frame, lambda: self.run(node.call))
        ends = node.ends
        if ends is not None and self._within(frame, lambda: condition(self.machine, ends)):
            raise Over
        if stands:
            return
        # The interrupted move could only go on from where it was stopped.
        if self.machine.flange is not before:
            raise NotRun("a move in an interrupt that came on the way of another one")
        kernel.motion.resume(kernel)

    def attend(self) -> None:
        """Has statements, waits and moves look for interrupts."""
        task = self.machine.task
        nodes = [node.condition for node, _ in self.known.values()]
        # Only a condition with a timer needs to be sampled; the others change with events.
        timed = any(isinstance(part, Elapsed) for part in records(tuple(nodes)))
        task.looks, task.sampling = self.look, _LOOK_PERIOD if timed else None


def _interrupts_of(m: Machine) -> Interrupts:
    assert m.interrupts is not None
    return m.interrupts


def _define_interrupt(m: Machine, node: p.Interrupt) -> None:
    own = _interrupts_of(m)
    own.known[node.name.lower()] = node, m.call
    own.attend()


def _switch_interrupt(m: Machine, node: p.SwitchInterrupt) -> None:
    name = node.name.lower()
    if node.state == "on":
        _interrupts_of(m).on.add(name)
    else:
        _interrupts_of(m).on.discard(name)


def _switch_interrupts(m: Machine, node: p.SwitchInterrupts) -> None:
    _interrupts_of(m).open = node.state == "on"


_INTERRUPT_STATEMENTS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    p.Interrupt: _define_interrupt,
    p.SwitchInterrupt: _switch_interrupt,
    p.SwitchInterrupts: _switch_interrupts,
}


_Body = Sequence[p.Statement]


def _execute(m: Machine, body: _Body) -> None:
    """Runs a body; a jump to a label in it goes on behind that label."""
    start = 0
    while True:
        try:
            for statement in body[start:]:
                does = _STATEMENT_FORMS.get(type(statement))
                if does is None:
                    continue
                m.step(statement)
                does(m, statement)
        except Jump as jump:
            found = next(
                (
                    i
                    for i, one in enumerate(body)
                    if isinstance(one, p.Label) and one.name.lower() == jump.label
                ),
                None,
            )
            if found is None:
                raise
            start = found
        else:
            return


def call(m: Machine, procedure: Procedure, arguments: Sequence[Expression]) -> Value | None:
    """Runs a procedure; what it gives back, None for nothing."""
    if len(m.calls) >= MOST_CALLS:
        raise NotRun(f"more than {MOST_CALLS} procedures inside of one another")
    if len(arguments) != len(procedure.parameters):
        raise Fault(
            f"`{procedure.name}` is given {len(arguments)} arguments and takes "
            f"{len(procedure.parameters)}"
        )
    made = Call(procedure)
    for parameter, argument in zip(procedure.parameters, arguments, strict=True):
        key = parameter.name.lower()
        if parameter.mode == "inout":
            made.names[key] = place(m, argument)
        else:
            made.names[key] = Cell(copied(evaluate(m, argument)))
    m.calls.append(made)
    try:
        for name, variable in procedure.variables.items():
            first = None if variable.initial is None else evaluate(m, variable.initial)
            constant = variable.storage == "constant"
            made.names[name.lower()] = Cell(first_value(variable, first), constant)
        _execute(m, procedure.body)
    except Returned as returned:
        return returned.value
    except Jump as jump:
        raise Fault(f"there is no label `{jump.label}` that can be jumped to") from None
    else:
        return None
    finally:
        m.calls.pop()


def _call_statement(m: Machine, node: p.Call) -> None:
    procedure = m.program.procedure(node.procedure)
    if procedure is None:
        raise Fault(f"there is no procedure `{node.procedure}`")
    call(m, procedure, node.arguments)


def _follow_path(m: Machine, node: p.Follow) -> None:
    for number, _ in enumerate(motion.follow(m, node.path)):
        # The first point is part of the statement that runs; each further one is a step.
        if number:
            m.task.step()


def _wait(m: Machine, node: p.Wait) -> None:
    seconds = numeric(m, node.seconds, "a wait")
    if seconds < 0.0:
        raise Fault(f"a wait of {seconds:g} seconds")
    m.task.delay(seconds)


def _wait_signal(m: Machine, node: p.WaitSignal) -> None:
    value = truth_or(evaluate(m, node.value))
    name = node.signal
    what = f"`{name}` is {m.read(name):g}, {value:g} is waited for"
    _await(m, lambda: m.read(name) == value, node.timeout, what)


def _wait_until(m: Machine, node: p.WaitUntil) -> None:
    what = "the condition that is waited for is not met"
    _await(m, lambda: condition(m, node.condition), node.timeout, what)


def _await(m: Machine, is_met: Callable[[], bool], timeout: Expression | None, what: str) -> None:
    seconds = None if timeout is None else numeric(m, timeout, "the longest time")
    if not m.task.wait(is_met, seconds, what):
        raise Fault(f"{what}, and the longest time is over")


def _start_timer(m: Machine, node: p.StartTimer) -> None:
    m.timers[node.timer.lower()] = m.task.kernel.now


def _set_signal(m: Machine, node: p.SetSignal) -> None:
    value = truth_or(evaluate(m, node.value))
    _switch_output(m, node.signal.lower(), value)
    if node.pulse is None:
        return
    seconds = numeric(m, node.pulse, "a pulse")
    if seconds <= 0.0:
        raise Fault(f"a pulse of {seconds:g} seconds")
    back = float(value == 0.0)
    kernel, task, name = m.task.kernel, m.task, node.signal.lower()
    # Motions without time leave no later: the end of the pulse goes into the record of the run.
    if isinstance(kernel.motion, Instant):
        task.switch(name, back, after=seconds)
    else:
        kernel.at(kernel.now + seconds, lambda: task.switch(name, back))


def _switch_output(m: Machine, name: str, value: float) -> None:
    declared = next((s for n, s in m.program.signals.items() if n.lower() == name), None)
    if declared is not None and declared.direction == "input":
        raise Fault(f"the input `{name}` is set")
    m.task.switch(name, value)


def _gripper(m: Machine, node: p.Gripper) -> None:
    m.task.switch(f"hand{node.hand}", float(node.action == "open"))


def _acceleration(m: Machine, node: p.SetAcceleration) -> None:
    m.acceleration = numeric(m, node.acceleration) / 100.0
    m.deceleration = numeric(m, node.deceleration) / 100.0


def _override(m: Machine, node: p.SetOverride) -> None:
    percent = numeric(m, node.percent, "the override")
    if percent <= 0.0:
        raise Fault(f"an override of {percent:g} %")
    m.override = percent / 100.0


def _assign(m: Machine, node: p.Assign) -> None:
    target = place(m, node.target)
    target.change(evaluate(m, node.value))


def _if(m: Machine, node: p.If) -> None:
    for branch in node.branches:
        if condition(m, branch.condition):
            _execute(m, branch.body)
            return
    _execute(m, node.otherwise)


def _while(m: Machine, node: p.While) -> None:
    while condition(m, node.condition):
        _execute(m, node.body)
        # An empty loop has to count as steps, or it never ends.
        m.step(node)


def _for(m: Machine, node: p.For) -> None:
    """Bounds and step are worked out once; see `For`."""
    first, last = numeric(m, node.first), numeric(m, node.last)
    towards = 1.0 if first <= last else -1.0
    step = towards if node.step is None else numeric(m, node.step)
    if step == 0.0:
        raise Fault("a loop whose step is 0")
    key, names = node.variable.lower(), m.call.names
    declared = m.place(node.variable)
    own = Cell()
    if declared is None:
        names[key] = own
    value = first
    while (value <= last) if step > 0.0 else (value >= last):
        if declared is None:
            own.value = value
        else:
            declared.change(value)
        _execute(m, node.body)
        m.step(node)
        value += step
    if declared is None:
        del names[key]


def _select(m: Machine, node: p.Switch) -> None:
    subject = evaluate(m, node.subject)
    for case in node.cases:
        if any(subject == evaluate(m, value) for value in case.values):
            _execute(m, case.body)
            return
    _execute(m, node.otherwise)


def _stop(m: Machine, node: p.Stop) -> None:
    m.task.tell(Stopped(end=node.end))
    if node.end:
        raise Over


def _return(m: Machine, node: p.Return) -> None:
    raise Returned(None if node.value is None else copied(evaluate(m, node.value)))


def _goto(_: Machine, node: p.Goto) -> None:
    raise Jump(node.label.lower())


def _message(m: Machine, node: p.Message) -> None:
    parts = (evaluate(m, part) for part in node.parts)
    m.task.tell(Said("".join(one if isinstance(one, str) else value_text(one) for one in parts)))


def _channel(_: Machine, node: p.Attach | p.Detach | p.Send) -> None:
    raise NotRun(f"the channel `{node.channel}`")


def _travel(_: Machine, node: p.Travel) -> None:
    raise NotRun(
        f"the way to {expression_text(node.target)}, which is planned when it is compiled,"
    )


def _vendor_statement(_: Machine, node: p.Opaque) -> None:
    lines = lines_of(node.text.strip()) or [""]
    raise NotRun(f"`{lines[0]}`, which is {node.language}")


_STATEMENT_FORMS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    p.Move: motion.move,
    p.MoveCircular: motion.move,
    p.MoveJoints: motion.move_joints,
    p.Travel: _travel,
    p.Follow: _follow_path,
    p.Wait: _wait,
    p.WaitSignal: _wait_signal,
    p.WaitUntil: _wait_until,
    p.StartTimer: _start_timer,
    p.SetSignal: _set_signal,
    p.Gripper: _gripper,
    p.SetAcceleration: _acceleration,
    p.SetOverride: _override,
    p.Call: _call_statement,
    p.Assign: _assign,
    p.If: _if,
    p.While: _while,
    p.For: _for,
    p.Switch: _select,
    p.Stop: _stop,
    p.Return: _return,
    p.Goto: _goto,
    p.Message: _message,
    **dict.fromkeys((p.Attach, p.Detach, p.Send), _channel),
    **_INTERRUPT_STATEMENTS,
    p.Opaque: _vendor_statement,
}
"""Comments and labels do nothing."""


_TASK_NAME: Final = "program"
"""Name of the program's task."""


def start_program(
    kernel: Kernel,
    program: Program,
    *,
    robot: Robot | None = None,
    start: Pose | None = None,
    text: SourceText | None = None,
    cycles: int = 1,
) -> Task:
    """Return a task that runs one cycle of a program, from the call of its first procedure to its
    end.

    robot: the arm; without it the end of a motion to joints is unknown. start: the flange in the
    base before the first motion. text: source that the program was read from, for source locations.
    cycles: number of calls of that procedure; if more than one, the run is over after them.
    """

    def body(task: Task) -> Ending:
        machine = Machine(task, program, robot, text, flange=start)
        machine.interrupts = Interrupts(machine, lambda node: _call_statement(machine, node))
        task.where, task.levels = machine.where, machine.levels
        try:
            _declare_variables(machine)
            entry = program.procedure(program.entry) if program.entry else None
            if entry is None:
                raise Fault("the program has no procedure to begin with")
            call(machine, entry, ())
            for _ in range(cycles - 1):
                # A cycle without statements must let the others have their turn.
                task.step()
                call(machine, entry, ())
        except Fault as fault:
            return Ending("error", str(fault))
        except NotRun as unknown:
            return Ending("unknown", str(unknown))
        except RecursionError:
            return Ending("unknown", "statements nested so deep")
        except Over:
            return Ending()
        return Ending() if cycles == 1 else Ending("steps", f"more than {cycles} cycles")

    return kernel.task(_TASK_NAME, body)


def _declare_variables(machine: Machine) -> None:
    """The program's targets and variables with their first values."""
    program, shared = machine.program, machine.shared
    for name, target in program.targets.items():
        shared[name.lower()] = Cell(target)
    for name, joints in program.joint_targets.items():
        shared[name.lower()] = Cell(joints)
    for name, variable in program.variables.items():
        first = None if variable.initial is None else evaluate(machine, variable.initial)
        constant = variable.storage == "constant"
        shared[name.lower()] = Cell(first_value(variable, first), constant)
    for name, tool in program.tools.items():
        # A variable of the program hides a tool or frame of the same name.
        shared.setdefault(name.lower(), Cell(tool.tip))
    for name, frame in program.frames.items():
        shared.setdefault(name.lower(), Cell(frame.pose))
