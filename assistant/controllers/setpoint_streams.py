"""Streams of setpoints to an arm, one step at a time, by each mode that a controller offers.

A caller that computes each step while the arm moves, from camera pictures for instance, hands the
step to a `Carrier`, which takes it to the arm and reports where the arm is. `MODES` lists the
modes; each makes a `Carrier` of a session with the controller. A new mode is a class and a row.
`_JogCarrier`: each step is a jog and ends before the next one begins. `DataLinkCarrier`: a joint
position on a line, sent before the last one is reached. `_PoseCarrier`: a request by file, whose
answer tells where the arm is. `CyclicCarrier`: a correction of the loop that sends the packets
(EGM, Mxt).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from types import TracebackType
from typing import Final, Literal, Protocol, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused
from assistant.controllers import rules
from assistant.controllers.abb.exchange import PoseExchange
from assistant.controllers.controller import Controller, JogsJoints, Programs
from assistant.controllers.cyclic import Leading, Limits, Settings
from assistant.controllers.mitsubishi.control_mode import ControlMode
from assistant.controllers.rules import NOT_HERE
from assistant.controllers.trajectory_execution import MODES as FOLLOWING
from assistant.controllers.trajectory_execution import (
    MXT_PROGRAM,
    Check,
    LinkOptions,
    check_of,
    lines_of,
    mxt_installed,
)
from assistant.program.geometry import Pose

__all__ = ["MODES", "Arm", "Carrier", "Mode"]


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """An arm of a axes, and its limits during control by setpoints.

    controller: series of its controller, such as CR800.
    axes: J1, J2 … of the arm. sliding: (a,) which of them slide. limits: (a, 2). full: (a,) its
    greatest speeds a second. speeds, rises: (a,) a second (squared) that no step may exceed. share:
    part of `full` at which a motion of all axes keeps the limits of its tool; for carriers whose
    controller chooses the speed. pose_of: joints (a,) → the tool in the base. joints_of: a pose of
    the tool, and joints (a,) near the solution; None without a solution.
    """

    controller: str
    axes: tuple[str, ...]
    sliding: tuple[bool, ...]
    limits: Floats
    full: Floats
    speeds: Floats
    rises: Floats
    share: float
    pose_of: Callable[[Floats], Pose]
    joints_of: Callable[[Pose, Floats], Floats | None]

    @property
    def places(self) -> list[int]:
        """Columns of the axes where J1 is the first, whichever the arm lacks."""
        return [int(axis[1:]) - 1 for axis in self.axes]

    def numbered(self, values: Floats, missing: float) -> Floats:
        """Values of axes (…, a) with a column for each number; missing: of the others."""
        from assistant.controllers.cyclic.trajectory import numbered

        return numbered(self.axes, values, missing)

    @property
    def part(self) -> float:
        """Part of its full speed that keeps to `speeds` and `share`."""
        # The axis with the least share of its speed limits the percentage of all.
        return min(self.share, float((self.speeds / self.full).min()))

    @property
    def percent(self) -> int:
        """`part` in percent, 1 where it is less: controllers go no slower."""
        return int(np.clip(np.floor(100.0 * self.part), 1, 100))

    @property
    def slow(self) -> Floats:
        """(a,) the speeds of `percent`."""
        return np.minimum(self.speeds, self.full * self.percent / 100.0)


class Carrier(Protocol):
    """A context manager: entering makes the arm ready, leaving brings it to rest and ends the way.

    period: seconds that a step takes at least. speeds: (a,) that steps may have. waits: whether
    `move` comes back when the arm stands, so that what was seen before is of another place.
    """

    period: float
    speeds: Floats
    waits: bool

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...

    def joints(self) -> Floats:
        """(a,) where the arm is, as it tells; raises Refused if it is not known any more."""

    def told(self) -> Floats:
        """Return the last commanded joints (a,)."""

    def move(self, to: Floats, seconds: float) -> None:
        """Command the arm to joints (a,) in so many seconds, near the last commanded position.

        It comes to rest there unaided if no other step follows. Raises Refused.
        """

    def rest(self) -> None:
        """Has the arm come to rest now, at its accelerations."""


MakeCarrier = Callable[[Programs, Arm, LinkOptions, Floats], Carrier]
"""Makes a carrier from a session, the arm, the options, and joints (a,) near the present
position.
"""
SpeedKeeper = Literal["cycles", "percent", "program"]
_SLOWEST_OVERRIDE: Final = 0.01
"""Part of its full speed: the least that a controller can be set to."""


@dataclass(frozen=True, slots=True)
class Mode:
    """title: in words. make: a carrier that is not entered. operates: whether the session must be
    one that operates the controller. check: called before the user confirms. unbegun: codes of
    refusals after which nothing has been sent or started. waits: as of its carrier. keeps: limiter
    of the speed: each cycle, a percentage of the controller, or the controller's program.
    """

    title: str
    make: MakeCarrier
    operates: bool
    check: Check
    unbegun: frozenset[str] = frozenset()
    waits: bool = False
    keeps: SpeedKeeper = "cycles"

    def faster(self, arm: Arm, place: str) -> Iterator[Diagnostic]:
        """Report where the arm may be faster than what `arm` may do: the way cannot keep to it."""
        if self.keeps == "percent" and arm.part < _SLOWEST_OVERRIDE:
            times = f"{_SLOWEST_OVERRIDE / arm.part:.1f}"
            yield rules.NO_SLOWER(place=place, percent=100.0 * _SLOWEST_OVERRIDE, times=times)
        elif self.keeps == "program":
            yield rules.OWN_SPEED(place=place)


def _jog(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001

    assert isinstance(session, JogsJoints)
    return _JogCarrier(session, arm)


def _jogs_joints(session: Programs, wishes: LinkOptions) -> None:  # noqa: ARG001 - as of each way
    """Raises Refused for a controller that cannot."""
    if not isinstance(session, JogsJoints):
        place, what = str(session.address), "jog several joints at once"
        reason, cure = "its protocol has no such command", "choose another way by --by"
        finding = NOT_HERE(place=place, address=place, what=what, reason=reason, cure=cure)
        raise Refused(finding, exit_status=2)


def _data_link(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001

    assert isinstance(session, Controller)
    return DataLinkCarrier(session, *lines_of(session, wishes), arm, replace=wishes.replace)


def _mxt(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001

    assert isinstance(session, Controller)
    return by_mxt(session, arm, wishes)


def _egm(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001

    return by_egm(session.address.host, arm, wishes.port, wishes.cycle)


def _exchange(session: Programs, arm: Arm, wishes: LinkOptions, near: Floats) -> Carrier:  # noqa: ARG001

    return _PoseCarrier(session, arm, near)


def _mode(
    name: str,
    title: str,
    make: MakeCarrier,
    *,
    waits: bool = False,
    keeps: SpeedKeeper = "cycles",
) -> Mode:
    """Needs what following a trajectory by the same way does."""
    other = FOLLOWING[name]
    return Mode(title, make, other.operates, other.check, other.unbegun, waits, keeps)


MODES: Final[Mapping[str, Mode]] = {
    "jog": Mode(
        "jogs of its joints, step by step",
        _jog,
        True,
        check_of(then=_jogs_joints),
        waits=True,
        keeps="percent",
    ),
    "data-link": _mode(
        "data-link", "joint positions on a line of data", _data_link, keeps="percent"
    ),
    "mxt": _mode("mxt", "joints cycle by cycle", _mxt),
    "egm": _mode("egm", "joints cycle by cycle, as a program asks for them", _egm),
    "exchange": _mode(
        "exchange", "poses by files, one after the other", _exchange, waits=True, keeps="program"
    ),
}


_JOG_PERIOD: Final = 1.0
"""Greatest seconds of a step: nothing is checked meanwhile, but requests take much of each step."""
_LEAST_JOG: Final = 0.01
"""Degrees or mm of a step: places are written with two decimals."""


class _JogCarrier:
    """controller: is connected, has its motors on, and jogs several joints at once."""

    waits = True

    def __init__(self, controller: JogsJoints, arm: Arm, period: float = _JOG_PERIOD) -> None:
        self.period, self.speeds = period, arm.slow
        self._controller, self._arm = controller, arm

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Each step has ended before."""

    def joints(self) -> Floats:
        there = self._controller.position().joints
        return np.array([there[place] for place in self._arm.places], dtype=np.float64)

    def told(self) -> Floats:
        return self.joints()

    def move(self, to: Floats, seconds: float) -> None:  # noqa: ARG002 - the percentage tells
        # A step below the written digits would be a jog of nothing, which controllers refuse.
        if float(np.abs(to - self.joints()).max()) < _LEAST_JOG:
            return
        goal = dict(zip(self._arm.axes, to.tolist(), strict=True))
        self._controller.jog_joints(goal, float(self._arm.percent))

    def rest(self) -> None:
        """It stands."""


_STEPS_AHEAD: Final = 1
"""Steps that wait on the line: what the arm still goes when no more follow."""
_STEP_TOLERANCE: Final = 0.1
"""Degrees that a step may be larger than it was worked out to be: positions are rounded."""
_LONGEST_STEP: Final = 1.0
"""Seconds that a step takes at most; it bounds how far one may lead."""


class DataLinkCarrier:
    """The override of the controller keeps the speed while its program moves, and comes back to
    what it was afterwards.

    controller: is connected. control, status: targets of the lines. replace: other programs of the
    names of ours there.
    """

    waits = False

    def __init__(
        self,
        controller: Controller,
        control: str,
        status: str,
        arm: Arm,
        *,
        period: float = 0.1,
        replace: bool = False,
    ) -> None:
        self.period, self.speeds = period, arm.slow
        self._controller, self._arm = controller, arm
        limits = arm.numbered(arm.limits.T, np.nan).T
        # An axis that the arm lacks gets any range: its value never changes.
        limits[np.isnan(limits[:, 0])] = (-1.0, 1.0)
        # Positions are rounded: a step at the limit may come out slightly larger.
        farthest = float((self.speeds * _LONGEST_STEP).max()) + _STEP_TOLERANCE
        self._mode = ControlMode(
            controller,
            control,
            status,
            limits=limits,
            most_step=farthest,
            ahead=_STEPS_AHEAD,
            replace=replace,
        )
        self._told: Floats | None = None
        self._override: int | None = None

    @property
    def mode(self) -> ControlMode:
        """Control mode that carries the steps; its `recording` holds every status received."""
        return self._mode

    def __enter__(self) -> Self:
        self._override = self._controller.state().override
        self._controller.set_override(self._arm.percent)
        try:
            self._mode.__enter__()
        except BaseException:
            self._set_back()
            raise
        self._told = None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            self._mode.__exit__(kind, error, trace)
        finally:
            self._set_back()

    def joints(self) -> Floats:
        return self._own(self._mode.status.feedback.values)

    def told(self) -> Floats:
        return self._own(self._mode.status.commanded.values) if self._told is None else self._told

    def move(self, to: Floats, seconds: float) -> None:  # noqa: ARG002 - the override tells how fast
        self._mode.lead(self._arm.numbered(to, np.nan))
        self._told = np.array(to)

    def rest(self) -> None:
        """Do nothing: the arm stops at its last command, which is near."""

    def _set_back(self) -> None:
        if self._override is not None:
            self._controller.set_override(self._override)

    def _own(self, values: tuple[float, ...]) -> Floats:
        return np.array(values, dtype=np.float64)[self._arm.places]


_POSE_PERIOD: Final = 0.5
"""Greatest seconds of a step: nothing is checked meanwhile, but the files take much of each
step.
"""


class _PoseCarrier:
    """Carrier over the running pose exchange, with the tool of `Arm.pose_of`, in the base.

    Its speed is that of its module. begin: (a,) joints near the first pose: the answers contain no
    joints.
    """

    waits = True

    def __init__(
        self, programs: Programs, arm: Arm, begin: Floats, period: float = _POSE_PERIOD
    ) -> None:
        self.period, self.speeds = period, arm.speeds
        self._arm, self._exchange, self._near = arm, PoseExchange(programs), begin
        self.begun = False

    @property
    def exchange(self) -> PoseExchange:
        """Pose exchange that carries the steps; its `recording` holds every answer."""
        return self._exchange

    def __enter__(self) -> Self:
        self._exchange.__enter__()
        self.begun = True
        self._take(self._exchange.current_pose().pose)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._exchange.__exit__(kind, error, trace)

    def joints(self) -> Floats:
        return self._near

    def told(self) -> Floats:
        return self._near

    def move(self, to: Floats, seconds: float) -> None:  # noqa: ARG002 - the module tells how fast
        # The answer has no joints: the search for them begins at the target, in its branch.
        self._near = np.array(to)
        self._take(self._exchange.move_to(self._arm.pose_of(to)).pose)

    def rest(self) -> None:
        """It stands."""

    def _take(self, pose: Pose) -> None:
        found = self._arm.joints_of(pose, self._near)
        if found is None:
            x, y, z = pose.position
            raise Refused(rules.NO_JOINTS(point=f"({x:.1f}, {y:.1f}, {z:.1f}) mm"))
        self._near = found


_FIRST_PACKET_TIMEOUT: Final = 10.0
"""Seconds in which a program that was started must answer the first packet."""
_CYCLIC_PERIOD: Final = 0.02
_CATCH_UP_SPEED: Final = 1.1
"""Part of the speeds of steps that a cycle may have: a step that comes late is caught up with."""


class CyclicCarrier:
    """made: the loop for limits; what else is needed is entered on the stack before.

    The arm comes to rest behind its last step by what it takes to brake.
    """

    waits = False

    def __init__(
        self, arm: Arm, made: Callable[[Limits, ExitStack], Leading], period: float = _CYCLIC_PERIOD
    ) -> None:
        self.period, self.speeds = period, arm.speeds
        self._arm, self._made = arm, made
        self._open = ExitStack()
        self._leading: Leading | None = None
        self._told: Floats | None = None

    @property
    def leading(self) -> Leading:
        assert self._leading is not None, "it is entered"
        return self._leading

    def __enter__(self) -> Self:
        arm = self._arm
        # A step that comes late is caught up with at a little more than its speed.
        full = np.minimum(_CATCH_UP_SPEED * arm.speeds, arm.full)
        limits = Limits(
            tuple(arm.numbered(full, 1.0).tolist()),
            tuple(arm.numbered(arm.rises, 1.0).tolist()),
            tuple(arm.numbered(arm.limits[:, 0], -1.0).tolist()),
            tuple(arm.numbered(arm.limits[:, 1], 1.0).tolist()),
        )
        # Close everything that was opened if the loop does not begin.
        with ExitStack() as opening:
            self._leading = opening.enter_context(self._made(limits, opening))
            self._open = opening.pop_all()
        self._told = None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def joints(self) -> Floats:
        return np.array(self.leading.joints())[self._arm.places]

    def told(self) -> Floats:
        return self.joints() if self._told is None else self._told

    def move(self, to: Floats, seconds: float) -> None:
        self.leading.to(self._arm.numbered(to, 0.0).tolist(), seconds)
        self._told = np.array(to)

    def rest(self) -> None:
        """No speed is wanted from now on."""
        if self._leading is not None:
            self._leading.to(self._arm.numbered(self.joints(), 0.0).tolist(), 0.0)
        self._told = None


def by_egm(
    host: str,
    arm: Arm,
    port: int | None = None,
    cycle: float | None = None,
    settings: Settings | None = None,
) -> CyclicCarrier:
    """A program on the controller is to come and ask for joints. settings: None for the usual."""
    from assistant.controllers.abb import egm

    def made(limits: Limits, opening: ExitStack) -> Leading:  # noqa: ARG001
        return egm.guide_by_corrections(
            host,
            len(limits.speeds),
            limits,
            port=port or egm.PORT,
            cycle=cycle or egm.CYCLE,
            settings=settings,
        )

    return CyclicCarrier(arm, made)


def by_mxt(controller: Controller, arm: Arm, wishes: LinkOptions) -> CyclicCarrier:
    """Lead an arm by mxt; while it is entered, the program that takes the packets runs there."""
    from assistant.controllers.mitsubishi import external_control

    def made(limits: Limits, opening: ExitStack) -> Leading:
        sliding = tuple(
            place + 1 for place, slides in zip(arm.places, arm.sliding, strict=True) if slides
        )
        mxt = external_control.Mxt(
            controller.address.host,
            port=wishes.port or external_control.PORT,
            limits=limits,
            cycle=wishes.cycle or external_control.usual_cycle(arm.controller),
            axes=len(limits.speeds),
            sliding=sliding,
            settings=Settings(opening=_FIRST_PACKET_TIMEOUT),
        )
        opening.enter_context(mxt_installed(controller, wishes))
        controller.load(MXT_PROGRAM)
        controller.start()
        # A program that was started must not wait for packets after a failure.
        opening.push(lambda kind, *_: controller.stop() if kind is not None else None)
        opening.enter_context(mxt)
        return mxt.leading()

    return CyclicCarrier(arm, made)
