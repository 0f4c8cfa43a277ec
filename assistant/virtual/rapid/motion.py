"""Moves: where each ends, how fast, how wide its corner is cut, its triggers, and displacements.

Displacements shift all targets; offsets shift additional axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Final, Literal

import numpy as np

from assistant.languages.rapid.tree import syntax as s
from assistant.program.geometry import IDENTITY, Pose
from assistant.robots.configurations import from_confdata
from assistant.virtual.events import Called, How, Moved, OnWay, Switched
from assistant.virtual.rapid.call_arguments import Given, table_row
from assistant.virtual.rapid.control_flow import UNSURE, Fault, NotSimulated
from assistant.virtual.rapid.expressions import evaluate, place, signal, whole
from assistant.virtual.rapid.machine import Arm, Function, Machine, is_carried, work_object
from assistant.virtual.rapid.records import (
    axes_of,
    extjoint,
    extjoint_of,
    joints_of,
    number,
    pose_of,
    record,
    truth,
    wobj0,
)
from assistant.virtual.rapid.scopes import Place
from assistant.virtual.rapid.statements import call_late
from assistant.virtual.rapid.values import Record, Shape, Trigger, copied

MOVE_OPTIONS = "conc id v t z inpos wobj tload noeoffs"
"""Options of a move, beside its target, speed, zone and tool, that are simulated here."""


def move_joint(given: Given) -> None:
    _to_target(given, "joint", 0)


def move_linear(given: Given) -> None:
    _to_target(given, "linear", 0)


def move_circular(given: Given) -> None:
    via = given.record(0, "robtarget")
    _to_target(given, "circular", 1, via)


def _move_absolute(given: Given) -> None:
    """MoveAbsJ: no displacement and no work object changes where the joints go."""
    arm, target = given.machine.arm, given.record(0, "jointtarget")
    tool, frame, before = _tool_argument(given, 3), _frame_argument(given), arm.flange
    arm.joints = joints_of(target)
    arm.flange = flange_of(given.machine, arm.joints)
    arm.tool, arm.frame = tool, frame
    arm.configuration, arm.external = None, record(copied(target.parts["extax"]), "extjoint")
    speed, blend, how = _speed(given, 1), _blend(given, 2), _motion_style(given, 1)
    moved = Moved(
        "joint", arm.flange, is_carried(tool), joints=arm.joints, speed=speed, blend=blend, how=how
    )
    given.machine.go(replace(moved, external=tuple(axes_of(arm.external))), before)


def flange_of(machine: Machine, joints: tuple[float, ...]) -> Pose | None:
    """Return the flange pose at joints in degrees, None without a robot."""
    if machine.robot is None:
        return None
    p, q = machine.robot.flange_poses(np.array([machine.robot.own_joints(joints)]))
    return Pose.of(p[0], q[0])


def _to_target(
    given: Given,
    kind: Literal["joint", "linear", "circular"],
    first: int,
    via: Record | None = None,
) -> None:
    arm, target = given.machine.arm, given.record(first, "robtarget")
    before = arm.flange
    tool, frame = _tool_argument(given, first + 3), _frame_argument(given)
    flange = arm.flange_at(pose_of(target), tool, frame)
    between = None if via is None else arm.flange_at(pose_of(via), tool, frame)
    arm.flange, arm.joints, arm.tool, arm.frame = flange, None, tool, frame
    arm.configuration = record(copied(target.parts["robconf"]), "confdata")
    arm.external = record(copied(target.parts["extax"]), "extjoint")
    speed, blend = _speed(given, first + 1), _blend(given, first + 2)
    place = work_object(frame, tool) @ arm.displacement
    how = replace(_motion_style(given, first + 1), configuration=_configuration(arm, kind))
    moved = Moved(kind, flange, is_carried(tool), between, speed=speed, blend=blend, how=how)
    external = tuple(axes_of(arm.external))
    given.machine.go(replace(moved, frame=place, external=external), before)


def _motion_style(given: Given, index: int) -> How:
    """index: of the speed among the arguments."""
    arm, rotation = given.machine.arm, number(given.record(index, "speeddata").parts["v_ori"])
    share = arm.acceleration / 100.0
    assert arm.tool is not None
    mass = number(record(arm.tool.parts["tload"], "loaddata").parts["mass"])
    return How(
        rotation=rotation * arm.override / 100.0,
        acceleration=share,
        deceleration=share,
        seconds=given.optional_number("t"),
        mass=mass if mass >= 0.0 else None,
    )


def _configuration(arm: Arm, kind: str) -> tuple[int, ...] | None:
    """Return the configuration of the target if ConfJ or ConfL monitors it, else None."""
    watched = arm.watches_joints if kind == "joint" else arm.watches_lines
    if arm.configuration is None or not watched:
        return None
    stated = [number(part) for part in arm.configuration.parts.values()]
    return _neutral_configuration(*stated)


@lru_cache(256)
def _neutral_configuration(*stated: float) -> tuple[int, ...] | None:
    """The columns of a configuration in whole numbers."""
    if not all(part.is_integer() and abs(part) < 128 for part in stated):
        return None
    return tuple(from_confdata([[int(part) for part in stated]])[0].tolist())


def _tool_argument(given: Given, index: int) -> Record:
    return _persistent_argument(given.place(index), "tooldata")


def _frame_argument(given: Given) -> Record:
    node = given.options.get("wobj")
    if node is None:
        return wobj0()
    return record(copied(evaluate(given.machine, node, Shape("wobjdata"))), "wobjdata")


def _persistent_argument(place: Place, type: str) -> Record:
    if place.storage == "VAR":
        raise Fault(f"a VAR as {type}, which has to be persistent")
    return record(copied(place.get()), type)


def _speed(given: Given, index: int) -> float | None:
    r"""Return the speed of the tool in mm/s; None if the motion states its time, or the fastest
    there is.
    """
    stated = number(given.record(index, "speeddata").parts["v_tcp"])
    if given.has("t"):
        return None
    own = given.optional_number("v")
    arm = given.machine.arm
    speed = min((stated if own is None else own) * arm.override / 100.0, arm.most)
    return None if math.isinf(speed) else speed


def _blend(given: Given, index: int) -> float:
    zone = given.record(index, "zonedata")
    own = given.optional_number("z")
    if truth(zone.parts["finep"]) or given.has("inpos"):
        return 0.0
    return number(zone.parts["pzone_tcp"]) if own is None else own


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
        # The trigger stands between the speed and the zone;
        # the move itself expects neither it nor more.
        first = given.required.pop(place)
        taken = [
            first,
            *(given.options.pop(n) for n in _MORE_OPTIONS.split() if n in given.options),
        ]
        changes = [_trigger_change(machine, one) for one in taken]
        # `Machine.go` reads these when the move inside commands its motion.
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
        outputs = [name for name in _TRIGGER_OUTPUTS if name in given.options]
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
    given.machine.arm.acceleration = min(max(given.number(0), _LEAST_ACCELERATION), 100.0)


def _watch_joints(given: Given) -> None:
    given.machine.arm.watches_joints = not given.has("off")


def _watch_lines(given: Given) -> None:
    given.machine.arm.watches_lines = not given.has("off")


def _stop_move(given: Given) -> None:
    """The robot goes on to the very target of the motion before, and stops there."""
    given.machine.settle()


def _no_effect(given: Given) -> None:
    """Ignore an instruction that changes the arm's motion, but not its targets, or only the
    display.
    """


_LEAST_ACCELERATION: Final = 20.0
"""Percent: AccSet takes 20 to 100."""
_MORE_OPTIONS: Final = "t2 t3 t4 t5 t6 t7 t8"
_TRIGGER_OUTPUTS: Final = ("dop", "gop", "aop")
_TRIGGER_MOVES: Final = f"{MOVE_OPTIONS} {_MORE_OPTIONS}"
_ANY_OPTIONS: Final = "on off wrist lockaxis4 finepointramp tunevalue"


def _tuning_row(name: str) -> Callable[[Given], None]:
    """Return an instruction that tunes how well an arm follows, without effect on its targets."""
    return lambda given: given.machine.task.kernel.note(f"{name} has no effect on this run")


_MOVE_KINDS: Final = (
    ("J", move_joint, 0),
    ("L", move_linear, 0),
    ("C", move_circular, 1),
)
_GROUP_OPTIONS: Final = f"{MOVE_OPTIONS} value"

MOTION_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("MoveJ", 4, move_joint, MOVE_OPTIONS),
        table_row("MoveL", 4, move_linear, MOVE_OPTIONS),
        table_row("MoveC", 5, move_circular, MOVE_OPTIONS),
        table_row("MoveAbsJ", 4, _move_absolute, MOVE_OPTIONS),
        table_row("MoveJDO", 6, _move_and_set(move_joint, 5), MOVE_OPTIONS),
        table_row("MoveLDO", 6, _move_and_set(move_linear, 5), MOVE_OPTIONS),
        table_row("MoveCDO", 7, _move_and_set(move_circular, 6), MOVE_OPTIONS),
        *(
            row
            for letter, move, more in _MOVE_KINDS
            for row in (
                table_row(f"Move{letter}AO", 6 + more, _move_and_set(move, 5 + more), MOVE_OPTIONS),
                table_row(
                    f"Move{letter}GO", 5 + more, _move_and_set_group(move, 4 + more), _GROUP_OPTIONS
                ),
                table_row(
                    f"Move{letter}Sync",
                    5 + more,
                    _move_and_call(move, 4 + more),
                    MOVE_OPTIONS,
                ),
            )
        ),
        table_row("TriggJ", 5, _path_place(move_joint, 2), _TRIGGER_MOVES),
        table_row("TriggL", 5, _path_place(move_linear, 2), _TRIGGER_MOVES),
        table_row("TriggC", 6, _path_place(move_circular, 3), _TRIGGER_MOVES),
        table_row("TriggIO", 3, _set_up_trigger(delay=False), "start time dop gop aop"),
        table_row("TriggInt", 3, _trigger_interrupt, "start time"),
        table_row("TriggEquip", 4, _set_up_trigger(delay=True), "start dop gop aop"),
        table_row("VelSet", 2, _set_velocity),
        table_row("AccSet", 2, _set_acceleration, _ANY_OPTIONS),
        table_row("ConfJ", 0, _watch_joints, _ANY_OPTIONS),
        table_row("ConfL", 0, _watch_lines, _ANY_OPTIONS),
        table_row("SingArea", 0, _no_effect, _ANY_OPTIONS),
        table_row("MotionSup", 0, _no_effect, _ANY_OPTIONS),
        table_row("CornerPathWarning", 1, _no_effect),
        table_row("GripLoad", 1, _no_effect),
        table_row("ActUnit", 1, _no_effect),
        table_row("DeactUnit", 1, _no_effect),
        table_row("PathAccLim", 2, _no_effect, "accmax decelmax"),
        table_row("WorldAccLim", 0, _no_effect, _ANY_OPTIONS),
        table_row("SoftAct", 2, _tuning_row("SoftAct"), "mechunit ramp"),
        table_row("SoftDeact", 0, _tuning_row("SoftDeact"), "ramp"),
        table_row("TuneServo", 3, _tuning_row("TuneServo"), "type"),
        table_row("TuneReset", 0, _no_effect),
        table_row("PathResol", 1, _tuning_row("PathResol")),
        table_row("WaitRob", 0, _stop_move, "inpos zerospeed"),
    )
)


def _displace_on(given: Given) -> None:
    r"""PDispOn: displace from a programmed position to the one of \ExeP, or to the arm's position.

    Both positions are in the work object. Without \Rot the axes keep their directions.
    """
    arm = given.machine.arm
    programmed = pose_of(given.record(0, "robtarget"))
    executed = given.optional_record("exep", "robtarget")
    if executed is not None:
        there = pose_of(executed)
    else:
        tool = given.record(1, "tooldata")
        frame = given.optional_record("wobj", "wobjdata") or wobj0()
        # The position is read without a displacement, also without the one that is active.
        arm.displacement = IDENTITY
        there = arm.reading(tool, frame)
    if given.has("rot"):
        arm.displacement = there @ programmed.inverse()
    else:
        x, y, z = (a - b for a, b in zip(there.position, programmed.position, strict=True))
        arm.displacement = Pose((x, y, z))


def _displace_set(given: Given) -> None:
    given.machine.arm.displacement = pose_of(given.record(0, "pose"))


def _displace_add(given: Given) -> None:
    """PDispAdd: a displacement of the displaced frame."""
    arm = given.machine.arm
    arm.displacement = arm.displacement @ pose_of(given.record(0, "pose"))


def _displace_off(given: Given) -> None:
    given.machine.arm.displacement = IDENTITY


def _offsets_on(given: Given) -> None:
    arm = given.machine.arm
    programmed = axes_of(given.record(0, "robtarget").parts["extax"])
    executed = given.optional_record("exep", "robtarget")
    if executed is not None:
        there = axes_of(executed.parts["extax"])
    else:
        if arm.external is None:
            raise NotSimulated("additional axes that are read before the first motion")
        there = axes_of(extjoint_of(arm.external, arm.offsets))
    # An axis that is not in use (9E9) has no offset.
    arm.offsets = tuple(
        0.0 if a is None or b is None else a - b for a, b in zip(there, programmed, strict=True)
    )


def _offsets_set(given: Given) -> None:
    axes = axes_of(given.record(0, "extjoint"))
    given.machine.arm.offsets = tuple(axis or 0.0 for axis in axes)


def _offsets_off(given: Given) -> None:
    given.machine.arm.offsets = tuple(0.0 for _ in extjoint().parts)


DISPLACEMENT_INSTRUCTIONS: Final[Mapping[str, Function]] = dict(
    (
        table_row("PDispOn", 2, _displace_on, "rot exep wobj"),
        table_row("PDispSet", 1, _displace_set),
        table_row("PDispAdd", 1, _displace_add),
        table_row("PDispOff", 0, _displace_off),
        table_row("EOffsOn", 1, _offsets_on, "exep"),
        table_row("EOffsSet", 1, _offsets_set),
        table_row("EOffsOff", 0, _offsets_off),
    )
)
