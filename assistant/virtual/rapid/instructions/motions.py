"""Motions, what is set for them, and displacements of targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final, Literal

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.events import Called, OnWay, Switched
from assistant.virtual.rapid import motion
from assistant.virtual.rapid.ends import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.expressions import place, signal
from assistant.virtual.rapid.given import Given, table_row
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.statements import call_late
from assistant.virtual.rapid.values import Trigger


def _move_and_set(move: Callable[[Given], None], value: int) -> Callable[[Given], None]:
    """A motion that sets a signal in its corner; value: which argument the signal's value is."""

    def does(given: Given) -> None:
        move(given)
        given.machine.signals.set(given.signal(value - 1), given.number(value))

    return does


def _move_and_set_group(move: Callable[[Given], None], place: int) -> Callable[[Given], None]:
    r"""A motion that sets a group by `\Value` in its corner; place: of the signal."""

    def does(given: Given) -> None:
        move(given)
        value = given.optional_number("value")
        given.machine.signals.set(given.signal(place), 0.0 if value is None else value)

    return does


def _move_and_call(move: Callable[[Given], None], place: int) -> Callable[[Given], None]:
    """A motion that calls a procedure in its corner; place: of its name."""

    def does(given: Given) -> None:
        move(given)
        call_late(given.machine, given.text(place), ())

    return does


def _path_place(move: Callable[[Given], None], place: int) -> Callable[[Given], None]:
    """A motion that sets outputs on its way; place: the argument that is the first trigger."""

    def does(given: Given) -> None:
        machine = given.machine
        first = given.required.pop(place)
        taken = [first, *(given.options.pop(n) for n in MORE_OPTIONS.split() if n in given.options)]
        changes = [_trigger_change(machine, one) for one in taken]
        machine.on_way = changes
        try:
            move(given)
        finally:
            machine.on_way = ()

    return does


def _trigger_change(machine: Machine, node: s.Expression | None) -> Switched:
    trigger = None if node is None else place(machine, node).get()
    if not isinstance(trigger, Trigger):
        raise Fault("what is no triggdata is given to a motion")
    if trigger.change is None:
        raise Fault("a motion is given triggdata that nothing set up", UNSURE)
    return trigger.change


def _set_up_trigger(delay: bool) -> Callable[[Given], None]:
    """TriggIO, and with a delay of what the output switches TriggEquip."""

    def does(given: Given) -> None:
        trigger = given.place(0).get()
        if not isinstance(trigger, Trigger):
            raise Fault("what is no triggdata is set up as one")
        outputs = [name for name in TRIGGER_OUTPUTS if name in given.options]
        if len(outputs) != 1:
            raise NotSimulated("a trigger that sets no output")
        node = given.options[outputs[0]]
        assert node is not None
        signal_ = signal(given.machine, node)
        value = given.number(3 if delay else 2)
        at = OnWay(_trigger_measure(given), given.number(1), given.number(2) if delay else 0.0)
        digital = outputs[0] == "dop"
        trigger.change = Switched(signal_, float(value != 0.0) if digital else value, at)

    return does


def _trigger_interrupt(given: Given) -> None:
    """TriggInt: a trap routine runs where the motion is."""
    machine, trigger = given.machine, given.place(0).get()
    if not isinstance(trigger, Trigger):
        raise Fault("what is no triggdata is set up as one")
    interrupts = machine.interrupts
    interrupt = interrupts.known(whole(given.number(2), "the number of an interrupt"))
    at = OnWay(_trigger_measure(given), given.number(1))
    trigger.change = Called(at=at, act=lambda: interrupts.occur(interrupt))


def _trigger_measure(given: Given) -> Literal["start", "time", "end"]:
    return "start" if given.has("start") else "time" if given.has("time") else "end"


def _set_velocity(given: Given) -> None:
    given.machine.arm.override, given.machine.arm.most = given.number(0), given.number(1)


def _set_acceleration(given: Given) -> None:
    """The ramp, how fast an acceleration builds up, has no part in the timing."""
    given.machine.arm.acceleration = min(max(given.number(0), LEAST_ACCELERATION), 100.0)


def _watch_joints(given: Given) -> None:
    given.machine.arm.watches_joints = not given.has("off")


def _watch_lines(given: Given) -> None:
    given.machine.arm.watches_lines = not given.has("off")


def _stop_move(given: Given) -> None:
    """The robot goes on to the very target of the motion before, and stops there."""
    given.machine.settle()


def _no_effect(given: Given) -> None:
    """What changes how the arm moves, and not where, or only what a person sees."""


LEAST_ACCELERATION: Final = 20.0
"""Percent: AccSet takes 20 to 100."""
MORE_OPTIONS: Final = "t2 t3 t4 t5 t6 t7 t8"
TRIGGER_OUTPUTS: Final = ("dop", "gop", "aop")
TRIGGER_MOVES: Final = f"{motion.MOVE_OPTIONS} {MORE_OPTIONS}"
ANY_OPTIONS: Final = "on off wrist lockaxis4 finepointramp tunevalue"


def _tuning_row(name: str) -> Callable[[Given], None]:
    """What changes how well an arm follows, not where it is told to go."""
    return lambda given: given.machine.task.kernel.note(f"{name} has no effect on this run")


_MOVE_KINDS: Final = (
    ("J", motion.move_joint, 0),
    ("L", motion.move_linear, 0),
    ("C", motion.move_circular, 1),
)
_GROUP_OPTIONS: Final = f"{motion.MOVE_OPTIONS} value"

MOTION_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("MoveJ", 4, motion.move_joint, motion.MOVE_OPTIONS),
        table_row("MoveL", 4, motion.move_linear, motion.MOVE_OPTIONS),
        table_row("MoveC", 5, motion.move_circular, motion.MOVE_OPTIONS),
        table_row("MoveAbsJ", 4, motion.move_absolute, motion.MOVE_OPTIONS),
        table_row("MoveJDO", 6, _move_and_set(motion.move_joint, 5), motion.MOVE_OPTIONS),
        table_row("MoveLDO", 6, _move_and_set(motion.move_linear, 5), motion.MOVE_OPTIONS),
        table_row("MoveCDO", 7, _move_and_set(motion.move_circular, 6), motion.MOVE_OPTIONS),
        *(
            row
            for letter, move, more in _MOVE_KINDS
            for row in (
                table_row(
                    f"Move{letter}AO", 6 + more, _move_and_set(move, 5 + more), motion.MOVE_OPTIONS
                ),
                table_row(
                    f"Move{letter}GO", 5 + more, _move_and_set_group(move, 4 + more), _GROUP_OPTIONS
                ),
                table_row(
                    f"Move{letter}Sync",
                    5 + more,
                    _move_and_call(move, 4 + more),
                    motion.MOVE_OPTIONS,
                ),
            )
        ),
        table_row("TriggJ", 5, _path_place(motion.move_joint, 2), TRIGGER_MOVES),
        table_row("TriggL", 5, _path_place(motion.move_linear, 2), TRIGGER_MOVES),
        table_row("TriggC", 6, _path_place(motion.move_circular, 3), TRIGGER_MOVES),
        table_row("TriggIO", 3, _set_up_trigger(delay=False), "start time dop gop aop"),
        table_row("TriggInt", 3, _trigger_interrupt, "start time"),
        table_row("TriggEquip", 4, _set_up_trigger(delay=True), "start dop gop aop"),
        table_row("VelSet", 2, _set_velocity),
        table_row("AccSet", 2, _set_acceleration, ANY_OPTIONS),
        table_row("ConfJ", 0, _watch_joints, ANY_OPTIONS),
        table_row("ConfL", 0, _watch_lines, ANY_OPTIONS),
        table_row("SingArea", 0, _no_effect, ANY_OPTIONS),
        table_row("MotionSup", 0, _no_effect, ANY_OPTIONS),
        table_row("CornerPathWarning", 1, _no_effect),
        table_row("GripLoad", 1, _no_effect),
        table_row("ActUnit", 1, _no_effect),
        table_row("DeactUnit", 1, _no_effect),
        table_row("PathAccLim", 2, _no_effect, "accmax decelmax"),
        table_row("WorldAccLim", 0, _no_effect, ANY_OPTIONS),
        table_row("SoftAct", 2, _tuning_row("SoftAct"), "mechunit ramp"),
        table_row("SoftDeact", 0, _tuning_row("SoftDeact"), "ramp"),
        table_row("TuneServo", 3, _tuning_row("TuneServo"), "type"),
        table_row("TuneReset", 0, _no_effect),
        table_row("PathResol", 1, _tuning_row("PathResol")),
        table_row("WaitRob", 0, _stop_move, "inpos zerospeed"),
    )
)
