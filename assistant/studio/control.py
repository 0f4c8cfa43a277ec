"""An arm moved by a held key: in small steps, and only while its window proves to be there.

A window that has control is told a tick every `TICK` seconds and answers each with a beat, which
names the tick and whether the key is held. So a beat tells when the window was there, however late
it comes: after `WATCH` seconds without a fresh one the arm is stopped, and what was held has to be
let go before anything moves again. A step is a jog to a place near by, at which the arm stops by
itself: so it goes no further even if this process dies.

beat: {"kind": "beat", "tick": 17, "hold": 3, "axis": "J1", "by": -1, "frame": "base", "speed": 10}
hold: a number that grows with each press of the key, 0 while it is not held.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from assistant.compiler.jogging import ABOUT, ALONG, JOINTS, check_jog
from assistant.controllers import Controller, Programs
from assistant.controllers.abilities import JogsHeld
from assistant.controllers.states import Jog, record
from assistant.controllers.stopping import Rest, stop_at_once
from assistant.program.diagnostics import Diagnostic, Refused
from assistant.studio import rules
from assistant.studio.answering import findings
from assistant.studio.connections import Connection
from assistant.studio.windows import Tell

TICK: Final = 0.05
"""Seconds between two ticks."""
WATCH: Final = 0.2
"""Seconds without a fresh beat after which the arm is stopped."""
AWAY: Final = 3.0
"""Seconds without any beat after which control is given up."""
LOOKS: Final = 0.01
"""Seconds between two looks at the beats."""
KEPT: Final = 100
"""Ticks whose times are remembered."""
FASTEST: Final = 10.0
"""Percent of the full speed that a held key moves at most; `jog` of the command goes faster."""
DEGREES, LENGTH = 0.1, 0.5
"""Degrees, and mm along an axis, of a step at each percent of speed: a tenth of a second."""
ENDING: Final = 10.0
"""Seconds that a step has to come to its end when control is given up."""
AXES: Final = frozenset({*JOINTS, *ALONG, *ABOUT})


@dataclass(frozen=True, slots=True)
class Hold:
    """A key that is held. number: of its press. step: that is taken again and again."""

    number: int
    step: Jog


class Control:
    """An arm that one window moves until it gives that up; raises Refused.

    window: its name. say: tells that window something. over: is called when control has to be
    given up because the window is away. A session of its own waits for the stop, where the
    controller has a line for it.
    """

    def __init__(self, connection: Connection, window: str, say: Tell, over: Callable[[], None]):
        self.window = window
        self._connection, self._say, self._over = connection, say, over
        self._changed = threading.Condition()
        self._ticks: dict[int, float] = {}
        self._held: Hold | None = None
        self._cut = 0
        self._moving = self._switched = self._ended = False
        self._fresh = time.monotonic()
        connection.do(lambda controller: controller.state())  # one that keeps programs says so
        self._open = ExitStack()
        self._stopper: Programs | None = None
        with suppress(Refused):  # where there is no line for it, the session that jogs stops it
            self._stopper = self._open.enter_context(connection.client())
        self._stopping = threading.Lock()
        self._threads = [
            threading.Thread(target=does, name=f"control {does.__name__}", daemon=True)
            for does in (self._watch, self._move)
        ]
        for thread in self._threads:
            thread.start()

    # ---------------------------------------------------------------------------------- asked

    def beat(self, window: str, message: Mapping[str, Any]) -> None:
        """What a window answers to a tick; what is stale or makes no sense counts for nothing."""
        tick, number = message.get("tick"), message.get("hold")
        if window != self.window or type(tick) is not int or type(number) is not int:
            return
        step = _step(message) if number > 0 else None
        with self._changed:
            when = self._ticks.get(tick, float("-inf"))
            if self._ended or time.monotonic() - when > WATCH:
                return
            self._fresh = max(self._fresh, when)
            wanted = Hold(number, step) if step is not None and number > self._cut else None
            if number == 0 or wanted is not None:
                self._held = wanted
            self._changed.notify_all()

    def let_go(self, only: Hold | None = None) -> bool:
        """The key counts as held no more until it is pressed anew; whether it was held.

        only: if it is held so, None for however it is.
        """
        with self._changed:
            held, wanted = self._held, only or self._held
            if held is None or held != wanted:
                return False
            self._cut, self._held = max(self._cut, held.number), None
            return True

    def stop(self) -> Rest:
        """Stops the arm, and all programs, where they are; tells whether the arm stands."""
        self.let_go()
        self._stop_at_once()
        return self._connection.stop()

    def _stop_at_once(self) -> None:
        with self._stopping:
            if self._stopper is not None:
                stop_at_once(self._stopper)

    def motors(self, on: bool) -> None:
        """Switches the motors; those that were switched on here go off when control ends."""

        def switch(controller: Controller) -> None:
            before = controller.state().motors
            with self._changed:
                if self._ended and on:
                    raise Refused(rules.NO_CONTROL())
                self._switched |= on and not before
            controller.motors(on)
            self._switched &= on

        self.let_go()
        self._connection.do(switch)

    def end(self) -> None:
        """Gives control up: what moves is stopped, motors that were switched on here go off."""
        with self._changed:
            if self._ended:
                return
            self._ended = True
            self._held = None
            self._changed.notify_all()
        if self._moving or self._switched:
            self._stop_at_once()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(ENDING)
        found = self._motors_off() if self._switched else ()
        with suppress(Refused, OSError):  # the line for the stop has gone by itself
            self._open.close()
        self._say({"kind": "control", "ended": True, "findings": findings(found)})

    def _motors_off(self) -> tuple[Diagnostic, ...]:
        """Findings if they may still be on."""
        with suppress(Refused):
            self._connection.do(lambda controller: controller.motors(False))
            return ()
        try:
            with self._connection.client() as session:
                assert isinstance(session, Controller)
                session.motors(False)
        except Refused as refused:
            one = self._connection.one
            return (rules.MOTORS_ON(place=str(one.address), name=one.name), *refused.findings)
        return ()

    # -------------------------------------------------------------------------------- threads

    def _watch(self) -> None:
        """Tells ticks, stops what moves without fresh beats, and gives up what is left alone."""
        count, due = 0, time.monotonic()
        while not self._ended:
            now = time.monotonic()
            if now >= due:
                count, due = count + 1, now + TICK
                with self._changed:
                    self._ticks[count] = now
                    self._ticks.pop(count - KEPT, None)
                self._say({"kind": "tick", "tick": count})
            with self._changed:
                silent = now - self._fresh
                cut = self._held is not None and silent > WATCH
            if cut:
                self._cut_off()
            elif silent > AWAY:
                threading.Thread(target=self._over, name="control over", daemon=True).start()
                return
            time.sleep(LOOKS)

    def _cut_off(self) -> None:
        began = time.monotonic()
        try:
            rest = self.stop()
        except Refused as refused:  # it was left meanwhile
            rest = Rest(False, reason=refused.findings[0].message)
        with self._changed:
            self._fresh += time.monotonic() - began  # nobody was told a tick meanwhile
        self._say({"kind": "control", "cut": True, **rest_record(rest)})

    def _move(self) -> None:
        """Takes step after step while the key is held."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._ended or self._held is not None)
                hold = self._held
            if self._ended or hold is None:
                return
            try:
                self._connection.do(partial(self._take, hold))
            except Refused as refused:
                if self.let_go(hold):  # else it is what the stop has brought about
                    self._say({"kind": "control", "findings": findings(refused.findings)})
            finally:
                self._moving = False
            time.sleep(LOOKS)

    def _take(self, hold: Hold, controller: Controller) -> None:
        check_jog(hold.step, controller.position(), self._connection.robot)
        self._moving = True
        held = partial(self._is_held, hold)
        if isinstance(controller, JogsHeld):
            controller.jog_while(hold.step, held)
        elif held():
            controller.jog(hold.step)

    def _is_held(self, hold: Hold) -> bool:
        """Whether it still is, by a beat that is fresh."""
        with self._changed:
            return self._held == hold and time.monotonic() - self._fresh <= WATCH


def rest_record(rest: Rest) -> dict[str, object]:
    """Whether an arm stands, and where, as plain data."""
    return {"stands": rest.stands, "reason": rest.reason, "position": record(rest.position)}


def _step(message: Mapping[str, Any]) -> Jog | None:
    """The step that a beat asks for, None for what is none."""
    axis, by, speed = message.get("axis"), message.get("by"), message.get("speed")
    frame = message.get("frame", "base")
    if not isinstance(axis, str) or axis not in AXES or by not in (1, -1):
        return None
    if frame not in ("base", "tool"):
        return None
    if isinstance(speed, bool) or not isinstance(speed, int | float) or not 1 <= speed <= FASTEST:
        return None
    size = (LENGTH if axis in ALONG else DEGREES) * speed
    return Jog(axis, size * by, frame, float(speed))
