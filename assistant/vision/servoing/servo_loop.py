"""The servo loop: look, ask the control law, keep the limits, take a step, repeat.

It ends when the goal is reached, and stops for everything else: a target that is lost for two
pictures, late pictures, a growing error, a singular interaction matrix, a limit in the way, the
timeout. A picture is used with the joints of the moment in which it was taken. `lead_to` leads the
tool to a known pose by its joints, with cameras that watch it or without.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from pathlib import Path as FilePath
from typing import Any, Final, Protocol

import numpy as np

from assistant.base.arrays import Floats, Truths
from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule
from assistant.controllers.recording import Recording, save_columns
from assistant.controllers.setpoint_streams import Carrier
from assistant.program.geometry import Pose
from assistant.vision import rules
from assistant.vision.cameras.camera import WORLD, Camera
from assistant.vision.servoing.bounds import Guard
from assistant.vision.servoing.control_laws import (
    ControlLaw,
    JointsToGoal,
    PoseToHand,
    ServoMoment,
    ServoTask,
    TargetSighting,
)
from assistant.vision.servoing.interaction import flange_of, jacobian
from assistant.vision.servoing.simulation import Clock
from assistant.vision.servoing.visual_targets import VisualTarget

_MOMENTS_KEPT: Final = 200
"""Moments that are remembered, of which each picture takes two."""


@dataclass(slots=True)
class _JointHistory:
    """Moments (seconds of any clock, joints (a,)), one after the other."""

    _moments: deque[tuple[float, Floats]] = field(
        default_factory=lambda: deque(maxlen=_MOMENTS_KEPT)
    )

    def add(self, seconds: float, joints: Floats) -> None:
        """seconds: none before those of the last moment."""
        self._moments.append((seconds, joints))

    def at(self, seconds: float) -> Floats:
        """(a,) joints at a time, in a line between the moments around it; those of the nearest
        moment for what was before all of them, or behind.
        """
        times = np.array([moment[0] for moment in self._moments])
        after = int(np.searchsorted(times, seconds))
        if after in (0, len(times)):
            return self._moments[min(after, len(times) - 1)][1]
        (early, before), (late, behind) = self._moments[after - 1], self._moments[after]
        share = (seconds - early) / (late - early)
        return np.asarray(before + share * (behind - before))


_PICTURES_TO_LOSE: Final = 2
"""Pictures in a row without a sighting: the first one stops the arm, this number ends servoing."""
_DAMPING: Final = 1e-3
"""Part of the best direction by which others are damped, so that none asks for endless speed."""
_GROWN_ERROR: Final = 2.0
"""Largest ratio of an error to its first value."""
_GROWING_PICTURES: Final = 5
"""Pictures in a row with such an error."""
_BARRED_PICTURES: Final = 15
"""Pictures in a row in which a limit lets nothing be done."""
_BARRED_SHARE: Final = 0.02
"""Part of what is wanted that is as good as nothing."""
_SHORTEST_STEP: Final = 0.004
"""Seconds of a step at least."""
_LONGEST_STEP: Final = 1.0
"""Seconds of a step at most, however long a picture was waited for."""


class Eyes(Protocol):
    """Who looks. cameras: as their file has them, in the world or on the flange."""

    @property
    def cameras(self) -> Sequence[Camera]: ...

    def look(self, after: float, patience: float) -> TargetSighting | None:
        """The latest sight that was taken after a time of the loop's clock; None if none comes
        within so many seconds. Raises Refused where there will be no more.
        """


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """gain: part of the error that is taken away in a second. share: part of it at most with one
    step. pixels, distance, turn: px, mm and degrees at which the goal is reached; turn inf where it
    does not matter. hold: pictures in a row for which that must be so; before the first step as
    many must be sure. stale: seconds from a picture to its use from which on it counts as lost.
    timeout: seconds for all of it. condition: of the interaction matrix at most. opening: seconds
    in which it must be seen first. Raises Refused for what cannot be.
    """

    gain: float = 2.0
    share: float = 0.4
    pixels: float = 0.5
    distance: float = 0.5
    turn: float = 0.5
    hold: int = 3
    stale: float = 0.3
    timeout: float = 60.0
    condition: float = 5000.0
    opening: float = 3.0

    def __post_init__(self) -> None:
        ranges = {
            "gain": (0.01, 20.0),
            "share": (0.01, 1.0),
            "pixels": (0.01, 100.0),
            "distance": (0.01, 100.0),
            "turn": (0.01, float("inf")),
            "hold": (1, 100),
            "stale": (0.01, 10.0),
            "timeout": (0.1, 3600.0),
            "condition": (1.0, 1e9),
            "opening": (0.05, 600.0),
        }
        for name, (least, most) in ranges.items():
            value = getattr(self, name)
            if not least <= value <= most:
                reason = f"it is a number from {least:g} to {most:g}"
                finding = rules.BAD_SETTING(name=name, value=value, reason=reason)
                raise Refused(finding, exit_status=2)


@dataclass(frozen=True, slots=True, eq=False)
class ServoResult:
    """joints: (a,) and pose: of the tip in the base, where the arm stands. pictures: that were
    looked at. pixels, distance, turn: that are left as it is seen, NaN where that is not told.
    """

    joints: Floats
    pose: Pose
    pictures: int
    seconds: float
    pixels: float
    distance: float
    turn: float
    recording: Recording

    @property
    def columns(self) -> Mapping[str, Floats]:
        return dict(zip(self.recording.labels, self.recording.rows().T, strict=True))

    def save(self, path: FilePath) -> None:
        """Writes the log as .csv or .npz; raises Refused."""
        save_columns(path, self.columns)

    @property
    def left(self) -> str:
        return _error_text(self.pixels, self.distance, self.turn)

    def __str__(self) -> str:
        return f"{self.left} left after {self.pictures} pictures, {self.seconds:.1f} s"


class ServoStopped(Refused):
    """A servoing that did not come to its goal; `served` is what came of it, None if nothing."""

    def __init__(self, finding: Diagnostic, served: ServoResult | None) -> None:
        super().__init__(finding)
        self.served = served


def servo(
    eyes: Eyes,
    law: ControlLaw,
    carrier: Carrier,
    guard: Guard,
    settings: ServoSettings | None = None,
    *,
    clock: Callable[[], float] = time.monotonic,
    progress: Callable[[float], None] | None = None,
) -> ServoResult:
    """Servo the arm of a carrier, which is entered, until the law has reached its goal.

    clock: also used by the eyes. progress: called with the part of the first error that is removed.
    Raises Broken, and Refused of the eyes and the carrier; the arm stops before that.
    """
    slowed = guard.slowed(carrier.speeds)
    loop = _Loop(eyes, law, carrier, slowed, settings or ServoSettings(), clock)
    try:
        return loop.run(progress or (lambda _: None))
    except BaseException:
        carrier.rest()
        raise


@dataclass(slots=True, eq=False)
class _Loop:
    eyes: Eyes
    law: ControlLaw
    carrier: Carrier
    guard: Guard
    settings: ServoSettings
    clock: Callable[[], float]
    recording: Recording = field(init=False)
    began: float = 0.0
    after: float = -np.inf
    before: float = 0.0
    """When the picture before was taken."""
    velocity: Floats = field(init=False)
    past: _JointHistory = field(default_factory=_JointHistory)
    seen_at: Floats = field(init=False)
    """(a,) where the arm was when the last picture was taken."""
    task: ServoTask | None = None
    number: int = 0

    def __post_init__(self) -> None:
        axes = self.guard.robot.axes
        self.velocity = self.seen_at = np.zeros(len(axes))
        self.recording = Recording(
            {
                **dict.fromkeys(("seconds", "picture", "age", "seen"), ()),
                **dict.fromkeys(("pixels", "distance", "turn", "condition"), ()),
                **dict.fromkeys(("joints", "told", "velocity"), axes),
                "tip": ("x", "y", "z"),
            }
        )

    def run(self, progress: Callable[[float], None]) -> ServoResult:
        self.began = self.before = self.clock()
        self.law.forget()
        if what := self.guard.outside(self.carrier.joints()):
            raise ServoStopped(rules.ARM_OUTSIDE_BOUNDS(what=what), None)
        first = self._first_sight()
        lost = good = growing = barred = 0
        while True:
            sight, joints, task = self._look()
            if isinstance(task, str):
                lost, good = lost + 1, 0
                self._rest()
                self._record(sight, joints, None)
                if lost >= _PICTURES_TO_LOSE:
                    raise self._lost(sight, task)
                continue
            assert sight is not None
            lost, self.task = 0, task
            size = task.size
            if not task.condition <= self.settings.condition:
                self._record(sight, joints, task)
                raise self._broken(rules.SINGULAR_INTERACTION, condition=task.condition)
            good = good + 1 if self._is_there(task) else 0
            growing = growing + 1 if size > _GROWN_ERROR * first else 0
            if growing >= _GROWING_PICTURES:
                self._record(sight, joints, task)
                raise self._broken(rules.ERROR_GROWS, first=first, now=size)
            if good >= self.settings.hold:
                self._rest()
                self._record(sight, joints, task)
                return self._served()
            held_back = self._step(task, sight)
            barred = barred + 1 if held_back else 0
            self._record(sight, joints, task)
            if barred >= _BARRED_PICTURES:
                raise self._broken(rules.BARRED_BY_LIMIT, what=self.guard.barred)
            if self.clock() - self.began > self.settings.timeout:
                raise self._broken(rules.SERVO_TIMEOUT, seconds=self.settings.timeout)
            progress(float(np.clip(1.0 - size / first, 0.0, 1.0)))

    # ------------------------------------------------------------------------------- looking

    def _first_sight(self) -> float:
        """Size of the first error, once so many pictures in a row are sure; nothing moves."""
        seen, why = 0, ""
        while seen < self.settings.hold:
            sight, joints, task = self._look()
            self._record(sight, joints, None if isinstance(task, str) else task)
            if not isinstance(task, str):
                seen, self.task = seen + 1, task
                continue
            seen, why = 0, task
            if self.clock() - self.began > self.settings.opening:
                raise ServoStopped(rules.TARGET_NOT_SEEN(reason=why), self._served())
        assert self.task is not None
        return max(self.task.size, 1e-6)

    def _look(self) -> tuple[TargetSighting | None, Floats, ServoTask | str]:
        """Return the sighting, the joints, and the task, or the reason in words why it is
        unknown.
        """
        if not self.carrier.waits:  # or it stands where it stood behind the last step
            self.past.add(self.clock(), self.carrier.joints())
        sight = self.eyes.look(self.after, self.settings.stale)
        joints = self.carrier.joints()
        self.past.add(self.clock(), joints)
        if sight is None:
            return None, joints, f"no picture came within {self.settings.stale:g} s"
        self.after, self.number = sight.seconds, sight.number
        if (age := self.clock() - sight.seconds) > self.settings.stale:
            return sight, joints, f"its picture was {age:.2f} s old"
        self.seen_at = self.past.at(sight.seconds)
        flange = flange_of(self.guard.robot, self.seen_at)
        cameras = [c if c.parent == WORLD else c.carried(flange) for c in self.eyes.cameras]
        return sight, joints, self.law.task(ServoMoment(cameras, sight, flange))

    def _is_there(self, task: ServoTask) -> bool:
        wanted = self.settings
        if np.isfinite(task.pixels):
            return task.pixels <= wanted.pixels
        turn = 0.0 if np.isnan(task.turn) else task.turn
        return task.distance <= wanted.distance and turn <= wanted.turn

    # ------------------------------------------------------------------------------- stepping

    def _step(self, task: ServoTask, sight: TargetSighting) -> bool:
        """Takes one; whether a limit lets nothing be done."""
        since = sight.seconds - self.before
        seconds = float(np.clip(since, max(self.carrier.period, _SHORTEST_STEP), _LONGEST_STEP))
        self.before = sight.seconds
        told = self.carrier.told()
        wanted = self._wanted(task, told, seconds)
        self.velocity = self.guard.limited(wanted, self.velocity, told, seconds)
        self.carrier.move(told + self.velocity * seconds, seconds)
        if self.carrier.waits:  # the arm stood before, and stands now
            self.velocity = np.zeros_like(self.velocity)
            self.before = self.after = self.clock()
            self.past.add(self.after, self.carrier.joints())
        if not self.guard.barred:
            return False
        speed = float(np.abs(self.velocity).max())
        return speed <= _BARRED_SHARE * float(np.abs(wanted).max())

    def _wanted(self, task: ServoTask, joints: Floats, seconds: float) -> Floats:
        """Return (a,) velocities that remove the error; axes at their ends are left out.

        Motion commanded since the picture was taken is already subtracted from the error.
        """
        slopes = task.slopes @ jacobian(self.guard.robot, joints)
        error = task.error + slopes @ (joints - self.seen_at)
        gain = min(self.settings.gain, self.settings.share / seconds)
        free: Truths = np.ones(len(joints), dtype=bool)
        velocity = np.zeros(len(joints))
        for _ in range(len(joints)):
            velocity = np.zeros(len(joints))
            velocity[free] = -gain * _damped_least_squares(slopes[:, free], error)
            ends = self.guard.at_end(joints, velocity)
            if not ends.any():
                break
            free = free & ~ends
        return velocity

    def _rest(self) -> None:
        self.carrier.rest()
        self.velocity = np.zeros_like(self.velocity)

    # ------------------------------------------------------------------------------- telling

    def _record(self, sight: TargetSighting | None, joints: Floats, task: ServoTask | None) -> None:
        """task: None for a picture in which it was not seen."""
        now = self.clock()
        seen = (np.nan,) * 4
        if task is not None:
            seen = (task.pixels, task.distance, task.turn, task.condition)
        self.recording.add(
            now - self.began,
            np.nan if sight is None else float(sight.number),
            np.nan if sight is None else now - sight.seconds,
            float(task is not None),
            *seen,
            joints.tolist(),
            self.carrier.told().tolist(),
            self.velocity.tolist(),
            (flange_of(self.guard.robot, joints) @ self.guard.tip).position,
        )

    def _served(self) -> ServoResult:
        joints, task = self.carrier.joints(), self.task
        left = (np.nan,) * 3 if task is None else (task.pixels, task.distance, task.turn)
        pose = flange_of(self.guard.robot, joints) @ self.guard.tip
        seconds = self.clock() - self.began
        return ServoResult(joints, pose, len(self.recording), seconds, *left, self.recording)

    def _lost(self, sight: TargetSighting | None, why: str) -> ServoStopped:
        if sight is not None and (age := self.clock() - sight.seconds) > self.settings.stale:
            return self._broken(rules.STALE_PICTURES, age=age)
        return self._broken(rules.TARGET_LOST, reason=why)

    def _broken(self, rule: Rule, **fields: Any) -> ServoStopped:
        self._rest()
        served = self._served()
        return ServoStopped(rule(number=self.number, left=served.left, **fields), served)


def _damped_least_squares(slopes: Floats, error: Floats) -> Floats:
    """Least squares, damped (Wampler 1986): short where a direction is hardly told."""
    left, values, right = np.linalg.svd(slopes, full_matrices=False)
    if not values.size or not values[0] > 0.0:
        return np.zeros(slopes.shape[1])
    damped = values / (values**2 + (_DAMPING * values[0]) ** 2)
    return np.asarray(right.T @ (damped * (left.T @ error)))


def _error_text(pixels: float, distance: float, turn: float) -> str:
    parts = [f"{pixels:.2f} px"] if np.isfinite(pixels) else []
    parts += [f"{distance:.2f} mm"] if np.isfinite(distance) else []
    parts += [f"{turn:.2f} degrees"] if np.isfinite(turn) else []
    return ", ".join(parts) or "an unknown way"


_JOINT_PERIOD: Final = 1.0 / 30.0
"""Seconds from look to look at the joints."""
_JOINT_SETTINGS: Final = ServoSettings(distance=0.1, turn=0.1, gain=4.0, share=0.6)
"""For joints, which have no noise to speak of."""


def lead_to(
    goal: Pose,
    carrier: Carrier,
    guard: Guard,
    settings: ServoSettings | None = None,
    *,
    eyes: Eyes | None = None,
    mark: tuple[VisualTarget, Pose] | None = None,
    clock: Clock | None = None,
    progress: Callable[[float], None] | None = None,
) -> ServoResult:
    """Servo the tip of the guard to a pose in the base; return the joints and the pose that it
    reached.

    The path is a straight line unless a limit bars it; obstacles are not checked. carrier: is
    entered. eyes, mark: stationary cameras that see the mark on the tool, with its frame on the
    flange: the tool's pose is then the seen one. None to use the arm's position. An arm of five
    axes gets as close as it can turn: allow it the turn by `Settings(turn=inf)`. Raises Broken and
    Refused; the arm stops before that.
    """
    clock = clock or Clock()
    flange = goal @ guard.tip.inverse()
    if eyes is None or mark is None:
        eyes, law = _NoCameras(clock), JointsToGoal(flange, guard.tip)
        return servo(
            eyes, law, carrier, guard, settings or _JOINT_SETTINGS, clock=clock, progress=progress
        )
    seen = PoseToHand(mark[0], mark[1], flange, tip=guard.tip)
    return servo(eyes, seen, carrier, guard, settings, clock=clock, progress=progress)


@dataclass(slots=True)
class _NoCameras:
    """Eyes without cameras; they return moments at which the joints are read."""

    clock: Clock = field(default_factory=Clock)
    cameras: Sequence[Camera] = ()
    _number: int = -1

    def look(self, after: float, patience: float) -> TargetSighting:  # noqa: ARG002 - one always comes
        self.clock.wait(max(after + _JOINT_PERIOD - self.clock(), 0.0))
        self._number += 1
        return TargetSighting(self.clock(), self._number)
