"""Interrupts: Def Act, Act, On Com, Com and Return n (COSIROP: ACT, DEF ACT, ON COM, RETURN).

They are checked before each statement, and while one waits or moves. A subroutine runs inside the
statement that it interrupts, so that `Return 0` continues with that statement as if nothing had
happened; `Return 1` and interrupts that jump leave it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final

from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.virtual.melfa import arm_state, expressions
from assistant.virtual.melfa.code import nodes
from assistant.virtual.melfa.values import Failed, Redirected, Unknown, holds, out_of_range

if TYPE_CHECKING:
    from assistant.virtual.melfa.communication import Channel
    from assistant.virtual.melfa.machine import Frame, Machine
    from assistant.virtual.melfa.world import World

_NUMBERS: Final = range(1, 9)
_COM_FILES: Final = range(1, 4)
COM: Final = 0
"""The rank of interrupts of lines, which come before those of `Def Act` 1 to 8."""
ON_WAY: Final = frozenset(("P_CURR", "P_FBC", "J_CURR", "J_FBC", "M_RDST", "M_RATIO", "M_RSPD"))
"""Status variables that change while the arm is moving."""
_CYCLE: Final = 0.0071
"""Seconds from look to look at what changes while nothing happens: the cycle in which CRn-500
controllers move (BFP-A3379, MXT).
"""
_LASTING: Final = ("WAIT", "DLY", "HLT")


@dataclass(frozen=True, slots=True)
class Act:
    """An interrupt and its condition. frame, nest, at: position of the program at its definition.
    condition: None for that of a line.
    """

    rank: int
    condition: s.Expression | None
    node: s.DefAct | s.OnCom
    frame: Frame
    nest: int
    at: int


class Interrupts:
    """Those of one program, which a program that it calls does not have."""

    def __init__(self, m: Machine) -> None:
        self._m = m
        self.acts: dict[int, Act] = {}
        self.allowed: set[int] = set()
        self.order: list[int] = []
        """Numbers of those that may come."""
        self.all = True
        self.coms: dict[int, Act] = {}
        self.states: dict[int, str] = {}
        self._seen: dict[int, tuple[Channel, int]] = {}
        self._ranks: list[int] = []
        self._looks = False

    # ----------------------------------------------------------------------------- looking

    def look(self) -> None:
        """Runs what is due now."""
        # Evaluating a condition may run statements, which check interrupts in turn.
        if self._looks:
            return
        while (due := self._due()) is not None:
            self._run(due)

    def _due(self) -> Act | None:
        """The first of those that may interrupt what runs."""
        # A lower number may interrupt the subroutine of a higher one.
        rank = self._ranks[-1] if self._ranks else _NUMBERS.stop
        if rank > COM:
            for file in sorted(self.coms):
                if self.states.get(file) == "On" and self._has_come(file):
                    return self.coms[file]
        if self.all:
            for number in self.order:
                if number < rank and self._holds(self.acts[number]):
                    return self.acts[number]
        return None

    def _holds(self, act: Act) -> bool:
        m, node = self._m, act.node
        # Stop type `L` lets the motion come to its end first.
        if isinstance(node, s.DefAct) and node.stop == "L" and m.began and _moves(m):
            return False
        kernel = m.world.task.kernel
        self._looks = kernel.looking = True
        # The condition names variables of the function that defines it.
        m.frames.append(act.frame)
        try:
            met = holds(expressions.value(m, act.condition))
        finally:
            m.frames.pop()
            self._looks = kernel.looking = False
        if kernel.branch is not None:
            kernel.branch(m.code.path, act.at, 0 if met else 1)
        return met

    def conditions(self) -> list[s.Expression | None]:
        """Conditions of the interrupts that may come."""
        return [self.acts[number].condition for number in self.order] if self.all else []

    # ------------------------------------------------------------------------------- lines

    def set_state(self, file: int, state: str) -> None:
        """`Com On`, `Com Off`, `Com Stop`: what came while it was off does not interrupt."""
        before = self.states.get(file, "Off")
        channel = self._m.world.files.get(file)
        if before == "Off" and state != "Off" and channel is not None:
            channel.pull()
            early = channel.unread if self._m.world.options.early else 0
            self._seen[file] = channel, channel.arrived - early
        self.states[file] = state

    def _has_come(self, file: int) -> bool:
        channel = self._m.world.files.get(file)
        if channel is None:
            return False
        channel.pull()
        before, seen = self._seen.get(file, (channel, 0))
        seen = seen if before is channel else 0
        # One interrupt for each line that comes.
        self._seen[file] = channel, min(seen + 1, channel.arrived)
        return channel.arrived > seen

    # ----------------------------------------------------------------------------- running

    def _run(self, act: Act) -> None:
        m, node = self._m, act.node
        late = isinstance(node, s.DefAct) and node.stop.upper() == "L"
        paused = arm_state.pause_arm(m.world, late)
        function = act.frame.function
        if isinstance(node, s.DefAct) and node.keyword == "GoTo":
            above = m.frames[m.frames.index(act.frame) + 1 :] if act.frame in m.frames else None
            if above is None or not all(frame.interrupts for frame in above):
                raise Unknown("an interrupt that jumps out of a Function")
            arm_state.cut_motion(m.world)
            del m.frames[len(m.frames) - len(above) :]
            self._ranks.append(act.rank)
            raise Redirected(act.nest, m.code.target(node.target, function))
        back = m.here, m.at, m.began
        frame = m.interrupting(act.frame)
        self._ranks.append(act.rank)
        m.at = m.code.target(node.target, function)
        m.go_on(frame)
        self._ranks.pop()
        m.frames.pop()
        m.here, m.at, m.began = back
        if frame.choice is None:
            raise Unknown("an interrupt that ends without Return")
        self._return(frame.choice, paused)

    def _return(self, choice: int, paused: bool) -> None:
        """0: with the statement that was interrupted. 1: with the next one.

        paused: whether the arm was stopped for it on its way.
        """
        m = self._m
        if choice == 0:
            if not paused or arm_state.resume_arm(m.world):
                return
            if not (m.began and _moves(m)):
                return
            statement = m.code.rows[m.here].statement
            if isinstance(statement, s.Motion) and statement.keyword.upper() in ("MOV", "MVS"):
                raise Redirected(m.nest, m.here)
            raise Unknown("how an arc goes on that an interrupt has moved the arm from")
        if not m.began and not _lasts(m):
            raise Unknown("which line an interrupt comes in, between two that take no time")
        arm_state.cut_motion(m.world)
        raise Redirected(m.nest, m.here + 1)


def _moves(m: Machine) -> bool:
    return isinstance(m.code.rows[m.here].statement, s.Motion)


def _lasts(m: Machine) -> bool:
    """True if the current statement takes time, so that an interrupt can come during it."""
    statement = m.code.rows[m.here].statement
    if isinstance(statement, s.Command):
        return statement.keyword.upper() in _LASTING
    return isinstance(statement, s.Motion | s.Input)


def look(world: World) -> None:
    """Runs the interrupts of the program that runs which are due."""
    held = world.slot is not None and world.slot.state != "runs"
    machine = world.running[-1] if world.running else None
    if machine is None or held:
        return
    if machine.interrupts is not None:
        machine.interrupts.look()
    if world.monitor is not None:
        world.monitor()


# ------------------------------------------------------------------------------- statements


def _own(m: Machine) -> Interrupts:
    """Those of the program, made when it first speaks of any."""
    if m.interrupts is None:
        m.interrupts = Interrupts(m)
    return m.interrupts


def attend(m: Machine, *more: s.Expression | None) -> None:
    """Has waits and motions look for interrupts, again and again where only time may bring one.

    more: conditions beside those of interrupts.
    """
    task, known = m.world.task, m.interrupts
    if known is not None:
        known.order = sorted(known.allowed & set(known.acts))
    conditions = [*more, *(() if known is None else known.conditions())]
    parts = [part for condition in conditions for part in nodes(condition)]
    asked = {part.key for part in parts if isinstance(part, s.Variable)}
    flies = bool(asked & ON_WAY) and task.kernel.motion.where() is not None
    # Time changes the arm and the timers without any event, so look again in each cycle.
    task.sampling = _CYCLE if flies or "M_TIMER" in asked else None
    if known is not None or m.world.monitor is not None:
        task.looks = lambda: look(m.world)


def _define(m: Machine, node: s.DefAct) -> None:
    number = expressions.integer(m, node.number, "the number of an interrupt")
    if number not in _NUMBERS:
        raise out_of_range(f"the interrupt {number}")
    stop = node.stop.upper()
    if stop not in ("", "S", "L"):
        raise Unknown(f"an interrupt of the stop type {stop}")
    _own(m).acts[number] = Act(number, node.condition, node, m.frame, m.nest, m.here)
    attend(m)


def _act(m: Machine, node: s.Expression) -> None:
    if not isinstance(node, s.Binary) or node.operator != "=":
        raise Failed(4220, "Act without a number and a state")
    number = expressions.integer(m, node.left, "the number of an interrupt")
    state = expressions.integer(m, node.right, "the state of an interrupt")
    if not 0 <= number < _NUMBERS.stop or state not in (0, 1):
        raise out_of_range(f"Act {number}={state}")
    own = _own(m)
    if number == 0:
        own.all = state == 1
    elif state == 1:
        own.allowed.add(number)
    else:
        own.allowed.discard(number)
    attend(m)


def _file(m: Machine, node: s.Expression | None) -> int:
    number = 1 if node is None else expressions.integer(m, node, "the line of an interrupt")
    if number not in _COM_FILES:
        raise out_of_range(f"an interrupt of line {number}")
    return number


def _on_com(m: Machine, node: s.OnCom) -> None:
    _own(m).coms[_file(m, node.line)] = Act(COM, None, node, m.frame, m.nest, m.here)
    attend(m)


def _com(m: Machine, node: s.Com) -> None:
    state = node.state.capitalize()
    if state not in ("On", "Off", "Stop"):
        raise Failed(4220, f"Com {state}")
    _own(m).set_state(_file(m, node.line), state)


def back(m: Machine, *node: s.Expression) -> None:
    """`Return` of a subroutine, `Return 0` and `Return 1` of an interrupt."""
    frame = m.frame
    if not node:
        if not frame.back and frame.interrupts:
            raise Failed(None, "Return without a number from an interrupt")
        if not frame.back:
            raise Failed(3840, "Return without GoSub")
        m.at = frame.back.pop()
        return
    choice = expressions.integer(m, node[0], "where an interrupt returns to")
    if choice not in (0, 1):
        raise out_of_range(f"Return {choice}")
    if frame.back or not frame.interrupts:
        raise Failed(None, "Return with a number outside of an interrupt")
    frame.choice, frame.left = choice, True


FORMS: Final[Mapping[type, Callable[[Machine, Any], None]]] = {
    s.DefAct: _define,
    s.OnCom: _on_com,
    s.Com: _com,
}
WORDS: Final[Mapping[str, Callable[..., None]]] = {"ACT": _act, "RETURN": back}
