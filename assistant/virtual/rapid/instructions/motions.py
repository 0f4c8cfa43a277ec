"""Motions, what is set for them, and displacements of targets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final, Literal

from assistant.languages.rapid.tree import syntax as s
from assistant.virtual.events import Called, OnWay, Switched
from assistant.virtual.rapid import motion
from assistant.virtual.rapid.ends import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.expressions import place, signal
from assistant.virtual.rapid.given import Given, takes
from assistant.virtual.rapid.machine import Function, Machine
from assistant.virtual.rapid.operators import whole
from assistant.virtual.rapid.statements import call_late
from assistant.virtual.rapid.values import Trigger


def _and_set(move: Callable[[Given], None], value: int) -> Callable[[Given], None]:
    """A motion that sets a signal in its corner; value: which argument the signal's value is."""

    def does(given: Given) -> None:
        move(given)
        given.machine.signals.set(given.signal(value - 1), given.number(value))

    return does


def _and_set_group(move: Callable[[Given], None], place: int) -> Callable[[Given], None]:
    r"""A motion that sets a group by `\Value` in its corner; place: of the signal."""

    def does(given: Given) -> None:
        move(given)
        value = given.optional_number("value")
        given.machine.signals.set(given.signal(place), 0.0 if value is None else value)

    return does


def _and_call(move: Callable[[Given], None], place: int) -> Callable[[Given], None]:
    """A motion that calls a procedure in its corner; place: of its name."""

    def does(given: Given) -> None:
        move(given)
        call_late(given.machine, given.text(place), ())

    return does


def _on_way(move: Callable[[Given], None], place: int) -> Callable[[Given], None]:
    """A motion that sets outputs on its way; place: the argument that is the first trigger."""

    def does(given: Given) -> None:
        machine = given.machine
        first = given.required.pop(place)
        taken = [first, *(given.options.pop(n) for n in MORE.split() if n in given.options)]
        changes = [_change(machine, one) for one in taken]
        machine.on_way = changes
        try:
            move(given)
        finally:
            machine.on_way = ()

    return does


def _change(machine: Machine, node: s.Expression | None) -> Switched:
    trigger = None if node is None else place(machine, node).get()
    if not isinstance(trigger, Trigger):
        raise Fault("what is no triggdata is given to a motion")
    if trigger.change is None:
        raise Fault("a motion is given triggdata that nothing set up", UNSURE)
    return trigger.change


def _set_up(delay: bool) -> Callable[[Given], None]:
    """TriggIO, and with a delay of what the output switches TriggEquip."""

    def does(given: Given) -> None:
        trigger = given.place(0).get()
        if not isinstance(trigger, Trigger):
            raise Fault("what is no triggdata is set up as one")
        outputs = [name for name in OUTPUTS if name in given.options]
        if len(outputs) != 1:
            raise NotSimulated("a trigger that sets no output")
        node = given.options[outputs[0]]
        assert node is not None
        signal_ = signal(given.machine, node)
        value = given.number(3 if delay else 2)
        at = OnWay(_measure(given), given.number(1), given.number(2) if delay else 0.0)
        digital = outputs[0] == "dop"
        trigger.change = Switched(signal_, float(value != 0.0) if digital else value, at)

    return does


def _interrupt(given: Given) -> None:
    """TriggInt: a trap routine runs where the motion is."""
    machine, trigger = given.machine, given.place(0).get()
    if not isinstance(trigger, Trigger):
        raise Fault("what is no triggdata is set up as one")
    interrupts = machine.interrupts
    interrupt = interrupts.known(whole(given.number(2), "the number of an interrupt"))
    at = OnWay(_measure(given), given.number(1))
    trigger.change = Called(at=at, act=lambda: interrupts.occur(interrupt))


def _measure(given: Given) -> Literal["start", "time", "end"]:
    return "start" if given.has("start") else "time" if given.has("time") else "end"


def _velocity(given: Given) -> None:
    given.machine.arm.override, given.machine.arm.most = given.number(0), given.number(1)


def _accelerate(given: Given) -> None:
    """The ramp, how fast an acceleration builds up, has no part in the timing."""
    given.machine.arm.acceleration = min(max(given.number(0), LEAST_ACCELERATION), 100.0)


def _watch_joints(given: Given) -> None:
    given.machine.arm.watches_joints = not given.has("off")


def _watch_lines(given: Given) -> None:
    given.machine.arm.watches_lines = not given.has("off")


def _stop(given: Given) -> None:
    """The robot goes on to the very target of the motion before, and stops there."""
    given.machine.settle()


def _nothing(given: Given) -> None:
    """What changes how the arm moves, and not where, or only what a person sees."""


LEAST_ACCELERATION: Final = 20.0
"""Percent: AccSet takes 20 to 100."""
MORE: Final = "t2 t3 t4 t5 t6 t7 t8"
OUTPUTS: Final = ("dop", "gop", "aop")
ON_WAY: Final = f"{motion.OPTIONS} {MORE}"
ANY: Final = "on off wrist lockaxis4 finepointramp tunevalue"


def _tunes(name: str) -> Callable[[Given], None]:
    """What changes how well an arm follows, not where it is told to go."""
    return lambda given: given.machine.task.kernel.note(f"{name} has no effect on this run")


_KINDS: Final = (("J", motion.joint, 0), ("L", motion.linear, 0), ("C", motion.circular, 1))
_GROUP: Final = f"{motion.OPTIONS} value"

TABLE: Final[Mapping[str, Function]] = dict(
    (
        takes("MoveJ", 4, motion.joint, motion.OPTIONS),
        takes("MoveL", 4, motion.linear, motion.OPTIONS),
        takes("MoveC", 5, motion.circular, motion.OPTIONS),
        takes("MoveAbsJ", 4, motion.absolute, motion.OPTIONS),
        takes("MoveJDO", 6, _and_set(motion.joint, 5), motion.OPTIONS),
        takes("MoveLDO", 6, _and_set(motion.linear, 5), motion.OPTIONS),
        takes("MoveCDO", 7, _and_set(motion.circular, 6), motion.OPTIONS),
        *(
            row
            for letter, move, more in _KINDS
            for row in (
                takes(f"Move{letter}AO", 6 + more, _and_set(move, 5 + more), motion.OPTIONS),
                takes(f"Move{letter}GO", 5 + more, _and_set_group(move, 4 + more), _GROUP),
                takes(f"Move{letter}Sync", 5 + more, _and_call(move, 4 + more), motion.OPTIONS),
            )
        ),
        takes("TriggJ", 5, _on_way(motion.joint, 2), ON_WAY),
        takes("TriggL", 5, _on_way(motion.linear, 2), ON_WAY),
        takes("TriggC", 6, _on_way(motion.circular, 3), ON_WAY),
        takes("TriggIO", 3, _set_up(delay=False), "start time dop gop aop"),
        takes("TriggInt", 3, _interrupt, "start time"),
        takes("TriggEquip", 4, _set_up(delay=True), "start dop gop aop"),
        takes("VelSet", 2, _velocity),
        takes("AccSet", 2, _accelerate, ANY),
        takes("ConfJ", 0, _watch_joints, ANY),
        takes("ConfL", 0, _watch_lines, ANY),
        takes("SingArea", 0, _nothing, ANY),
        takes("MotionSup", 0, _nothing, ANY),
        takes("CornerPathWarning", 1, _nothing),
        takes("GripLoad", 1, _nothing),
        takes("ActUnit", 1, _nothing),
        takes("DeactUnit", 1, _nothing),
        takes("PathAccLim", 2, _nothing, "accmax decelmax"),
        takes("WorldAccLim", 0, _nothing, ANY),
        takes("SoftAct", 2, _tunes("SoftAct"), "mechunit ramp"),
        takes("SoftDeact", 0, _tunes("SoftDeact"), "ramp"),
        takes("TuneServo", 3, _tunes("TuneServo"), "type"),
        takes("TuneReset", 0, _nothing),
        takes("PathResol", 1, _tunes("PathResol")),
        takes("WaitRob", 0, _stop, "inpos zerospeed"),
    )
)
