"""Small steps over a line of data: a joint position each, sent before the last one is reached."""

from __future__ import annotations

from types import TracebackType
from typing import Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.controllers.controller import Controller
from assistant.controllers.leading.carrier import Arm
from assistant.controllers.mitsubishi.control_mode import ControlMode

STEPS_AHEAD: Final = 1
"""Steps that wait on the line: what the arm still goes when no more follow."""
STEP_TOLERANCE: Final = 0.1
"""Degrees that a step may be larger than it was worked out to be: positions are rounded."""
LONGEST_STEP: Final = 1.0
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
        limits[np.isnan(limits[:, 0])] = (-1.0, 1.0)
        farthest = float((self.speeds * LONGEST_STEP).max()) + STEP_TOLERANCE
        self._mode = ControlMode(
            controller,
            control,
            status,
            limits=limits,
            most_step=farthest,
            ahead=STEPS_AHEAD,
            replace=replace,
        )
        self._told: Floats | None = None
        self._override: int | None = None

    @property
    def mode(self) -> ControlMode:
        """What the steps go by; its `recording` holds every status that came."""
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
        """Nothing: the arm stands at what it was told last, which is near."""

    def _set_back(self) -> None:
        if self._override is not None:
            self._controller.set_override(self._override)

    def _own(self, values: tuple[float, ...]) -> Floats:
        return np.array(values, dtype=np.float64)[self._arm.places]
