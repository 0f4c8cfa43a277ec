"""`Wth` and `WthIf`: what is set while a motion runs, and where on its way."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal

from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.walk import nodes
from assistant.virtual.events import OnWay, Switched
from assistant.virtual.melfa import expressions, interrupts, pausing
from assistant.virtual.melfa.stops import Unknown
from assistant.virtual.melfa.values import holds

if TYPE_CHECKING:
    from assistant.virtual.melfa.machine import Machine

PATH_MEASURES: Final[Mapping[str, tuple[Literal["end", "share"], str]]] = {
    "M_RDST": ("end", "<"),
    "M_RATIO": ("share", ">"),
}
"""What tells how far a motion is, and how it is compared with a place that is reached later."""
PATH_START: Final = OnWay("start", 0.0)
_MIRRORED: Final = {"<": ">", ">": "<"}


def begin_wth(m: Machine, append: s.Append) -> list[Switched]:
    """What is set on the way of the motion that begins; inputs are the same until it ends."""
    from assistant.virtual.melfa.statements import execute

    condition = append.condition
    place = PATH_START
    if condition is not None and _reads_position(condition):
        place = _trigger_place(m, condition)
    elif condition is not None and not holds(expressions.value(m, condition)):
        return []
    m.world.held = []
    try:
        execute(m, append.statement)
        return [replace(change, at=place) for change in m.world.held]
    finally:
        m.world.held = None


class _Skipped(Exception):
    """A motion is broken off."""


def is_watched_condition(m: Machine, append: s.Append) -> bool:
    """Whether what is appended waits for its condition while the motion runs."""
    condition = append.condition
    if not isinstance(append.statement, s.Assign):
        return True
    if condition is None or _reads_position(condition):
        return False
    on_way = _reads_any(condition, interrupts.ON_WAY)
    if m.world.task.kernel.motion.where() is None:
        if on_way:
            raise Unknown("where on its way a motion meets a condition")
        return False
    return on_way or not holds(expressions.value(m, condition))


def watch_condition(m: Machine, append: s.Append, run: Callable[[], None]) -> None:
    """Runs a motion that `Skip` ends where the arm is, or `Hlt` holds, or on whose way an output is
    set, as soon as a condition is met (COSIROP: SKIP, HLT, WTHIF).
    """
    world, condition = m.world, append.condition
    motion = world.task.kernel.motion
    word = append.statement.keyword.upper() if isinstance(append.statement, s.Command) else ""
    if word not in ("SKIP", "HLT") and not isinstance(append.statement, s.Assign):
        raise Unknown(f"{word or 'such a statement'} on the way of a motion")
    timed = motion.where() is not None
    on_way = condition is not None and _reads_any(condition, interrupts.ON_WAY)
    if on_way and not timed:
        raise Unknown("where a motion is when it is broken off")
    if condition is None or (not on_way and holds(expressions.value(m, condition))):
        if word == "SKIP":
            motion.settle(world.task)
            world.skipped = True
        else:
            world.halt()
            run()
        return

    def monitor() -> None:
        if holds(expressions.value(m, condition)):
            world.monitor = None
            _act_on_condition(m, append.statement, word)

    world.skipped = world.skipped and word != "SKIP"
    world.monitor = monitor if timed else None
    interrupts.attend(m, condition)
    try:
        run()
        if word == "SKIP" and not timed:  # a motion without time is whole as it is broken off
            world.skipped = holds(expressions.value(m, condition))
    except _Skipped:
        pausing.cut_motion(world)
        world.skipped = True
    finally:
        world.monitor = None
        interrupts.attend(m)


def _act_on_condition(m: Machine, statement: s.Statement, word: str) -> None:
    """The condition of what is appended is met while the motion runs."""
    from assistant.virtual.melfa.statements import execute

    if word == "SKIP":
        raise _Skipped
    if word == "HLT":
        paused = pausing.pause_arm(m.world, late=False)
        m.world.halt()
        if paused:
            pausing.resume_arm(m.world)
    else:
        execute(m, statement)


def _reads_any(condition: s.Expression, names: Container[str]) -> bool:
    return any(isinstance(x, s.Variable) and x.key in names for x in nodes(condition))


def _reads_position(condition: s.Expression) -> bool:
    return _reads_any(condition, PATH_MEASURES)


def _trigger_place(m: Machine, condition: s.Expression) -> OnWay:
    """Where on the way a condition comes to hold; raises Unknown for all but plain comparisons."""
    if isinstance(condition, s.Binary) and "<>" not in condition.operator:
        compared = condition.operator[:1]
        sides = (
            (condition.left, compared, condition.right),
            (condition.right, _MIRRORED.get(compared, ""), condition.left),
        )
        for place, way, bound in sides:
            if isinstance(place, s.Variable) and place.key in PATH_MEASURES and not place.arguments:
                measure, reached = PATH_MEASURES[place.key]
                if way == reached and not _reads_position(bound):
                    return OnWay(measure, expressions.plain(m, bound, "a place on the way"))
    raise Unknown("where on its way a motion meets a condition")
