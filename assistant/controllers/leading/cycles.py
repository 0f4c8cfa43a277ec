"""Small steps cycle by cycle: each is a correction of the loop that sends the packets."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import Final, Self

import numpy as np

from assistant.base.arrays import Floats
from assistant.controllers.controller import Controller
from assistant.controllers.cyclic import Leading, Limits, Settings
from assistant.controllers.following import MXT_PROGRAM, LinkOptions, mxt_installed
from assistant.controllers.leading.carrier import Arm

FIRST_PACKET_TIMEOUT: Final = 10.0
"""Seconds in which a program that was started must answer the first packet."""
CYCLIC_PERIOD: Final = 0.02
CATCH_UP_SPEED: Final = 1.1
"""Part of the speeds of steps that a cycle may have: a step that comes late is caught up with."""


class CyclicCarrier:
    """made: the loop for limits; what else is needed is entered on the stack before.

    The arm comes to rest behind its last step by what it takes to brake.
    """

    waits = False

    def __init__(
        self, arm: Arm, made: Callable[[Limits, ExitStack], Leading], period: float = CYCLIC_PERIOD
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
        full = np.minimum(CATCH_UP_SPEED * arm.speeds, arm.full)
        limits = Limits(
            tuple(arm.numbered(full, 1.0).tolist()),
            tuple(arm.numbered(arm.rises, 1.0).tolist()),
            tuple(arm.numbered(arm.limits[:, 0], -1.0).tolist()),
            tuple(arm.numbered(arm.limits[:, 1], 1.0).tolist()),
        )
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
    from assistant.controllers.abb.egm import guidance

    def made(limits: Limits, opening: ExitStack) -> Leading:  # noqa: ARG001
        return guidance.guide_by_corrections(
            host,
            len(limits.speeds),
            limits,
            port=port or guidance.PORT,
            cycle=cycle or guidance.CYCLE,
            settings=settings,
        )

    return CyclicCarrier(arm, made)


def by_mxt(controller: Controller, arm: Arm, wishes: LinkOptions) -> CyclicCarrier:
    """Lead an arm by mxt; while it is entered, the program that takes the packets runs there."""
    from assistant.controllers.mitsubishi.mxt import client

    def made(limits: Limits, opening: ExitStack) -> Leading:
        sliding = tuple(
            place + 1 for place, slides in zip(arm.places, arm.sliding, strict=True) if slides
        )
        mxt = client.Mxt(
            controller.address.host,
            port=wishes.port or client.PORT,
            limits=limits,
            cycle=wishes.cycle or client.CYCLES["CR750"],
            axes=len(limits.speeds),
            sliding=sliding,
            settings=Settings(opening=FIRST_PACKET_TIMEOUT),
        )
        opening.enter_context(mxt_installed(controller, wishes))
        controller.load(MXT_PROGRAM)
        controller.start()
        opening.push(lambda kind, *_: controller.stop() if kind is not None else None)
        opening.enter_context(mxt)
        return mxt.leading()

    return CyclicCarrier(arm, made)
