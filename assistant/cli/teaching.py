"""Teach: store where the arm is as a target in a file, at a key press or when a signal rises."""

from __future__ import annotations

import os
import select
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

from assistant.base.diagnostics import Refused, error
from assistant.cli.command import argument, command, option
from assistant.cli.controller_session import (
    ReplaceOption,
    complete_controller,
    connected,
    joints_line,
    pose_line,
    record,
    robot_of_cell,
)
from assistant.cli.pointing_input import PointingOptions, free_names, store_shown
from assistant.cli.presentation import Format, print_findings, print_json, say

if TYPE_CHECKING:
    from assistant.compiler.taught_targets import TargetOptions
    from assistant.controllers import Controller


_SEVERAL_TRIGGERS: Final = error(
    "CL230", "a key, a signal or at once: targets are stored at one of them", "keep --on or --now"
)
_NO_NAME: Final = error("CL231", "--now stores one target", "name it")
_NO_SIGNAL: Final = error(
    "CL232", "there is no input `{name}` on {address}", "write its name or number as there"
)
_NO_CONTROLLER: Final = error(
    "CL518", "no controller is named", "name one, or the cameras that see places by --point"
)
_ONLY_POINTING: Final = error(
    "CL516", "{option} is for places that are shown", "add --point CAMERAS.toml"
)
_SIGNAL_PERIOD: Final = 0.1
"""Seconds between two looks at the signal."""
_STORE_KEYS: Final = b"\r\n "
END_KEYS: Final = b"q\x1b\x04"
"""Keys: q, Escape, and the end of the input."""


@command
class Teach:
    """Store where the arm is, or places that are shown to cameras, under names.

    At a key press, when an input comes, or when a device is held still. Nothing moves but with
    --go, which asks before.
    """

    cell: str | None = argument(
        "Its name in [controllers] of assistant.toml, or its address; --point needs none.",
        default=None,
        metavar="CONTROLLER",
        completions=complete_controller,
    )
    names: tuple[str, ...] = argument("Targets, in this order; default p1, p2 …", default=())
    into: Path = option(
        "File of taught targets, which keeps all else.", default=Path("taught.toml"), metavar="FILE"
    )
    on: str | None = option("Store when this input comes, not at a key.", metavar="INPUT")
    now: bool = option("Store one target at once.")
    joints: bool = option("As joint angles.")
    tool: str | None = option("Tool of the file that the controller shows the pose of.")
    frame: str | None = option("Frame that it shows it in.")
    replace: ReplaceOption
    pointing: PointingOptions

    def run(self) -> int:
        from assistant.compiler.taught_targets import TargetOptions

        wanted = TargetOptions(self.joints, self.tool, self.frame, self.replace)
        if self.pointing.point is None:
            return self._store_here(wanted)
        words = [] if self.cell is None else [self.cell, *self.names]
        trigger = "--on" if self.on is not None else "--now" if self.now else None
        return store_shown(words, trigger, self.pointing, self.into, wanted)

    def _store_here(self, wanted: TargetOptions) -> int:
        """Names in their order; without any, p1, p2 … until somebody ends it."""
        from assistant.compiler.taught_targets import teach_target

        pointing = {"--go": self.pointing.go, "--stroke": self.pointing.stroke}
        wrong = next((option for option, given in pointing.items() if given), None)
        if wrong is not None:
            raise Refused(_ONLY_POINTING(option=wrong), exit_status=2)
        if self.cell is None:
            raise Refused(_NO_CONTROLLER(), exit_status=2)
        if self.now and self.on is not None:
            raise Refused(_SEVERAL_TRIGGERS(), exit_status=2)
        if self.now and len(self.names) != 1:
            raise Refused(_NO_NAME(), exit_status=2)
        stored: list[dict[str, object]] = []
        with connected(self.cell, "teach") as there:
            controller, robot = there.controller, robot_of_cell(there.one)
            with _store_triggers(controller, str(there.one.address), self) as comes:
                for name in self.names or free_names(self.into):
                    if self.pointing.format is Format.TEXT and not self.now:
                        keys = f"`{self.on}`" if self.on is not None else "Enter"
                        say(f"{name}: {keys} stores it, q ends")
                        sys.stdout.flush()
                    if not comes():
                        break
                    position = controller.position()
                    reading = teach_target(self.into, name, position, robot, wanted)
                    stored.append({"name": name, "position": record(position)})
                    if self.pointing.format is Format.TEXT:
                        print_findings(reading.findings)
                        shown = joints_line if self.joints else pose_line
                        say(f"{name}: {shown(position)}, stored in {self.into}")
                        sys.stdout.flush()
        if self.pointing.format is Format.JSON:
            answer = {"address": str(there.one.address), "file": str(self.into), "stored": stored}
            print_json(answer)
        return 0


@contextmanager
def _store_triggers(
    controller: Controller, address: str, options: Teach
) -> Iterator[Callable[[], bool]]:
    """Yield a function that waits for the moment to store: False when there are no more."""
    if options.now:
        yield lambda: True
        return
    with terminal_keys() as pressed:
        if options.on is None:
            yield lambda: _store_key(pressed, None) is True
            return
        yield _wait_for_rise(controller, address, options.on, pressed)


def _wait_for_rise(
    controller: Controller, address: str, signal: str, pressed: Callable[[float | None], bytes]
) -> Callable[[], bool]:
    """Return a function that waits until an input that was off is on; q ends it, if there are keys.

    The input is read once before the user is prompted, so that an immediate change counts.
    """

    def is_on() -> bool:
        found = controller.inputs([signal])
        if signal not in found:
            raise Refused(_NO_SIGNAL(name=signal, address=address), exit_status=2)
        return found[signal] != 0.0

    was = is_on()

    def comes() -> bool:
        nonlocal was
        while True:
            if sys.stdin.isatty():
                if _store_key(pressed, _SIGNAL_PERIOD) is False:
                    return False
            else:
                time.sleep(_SIGNAL_PERIOD)
            before, was = was, is_on()
            if was and not before:
                return True

    return comes


def _store_key(pressed: Callable[[float | None], bytes], seconds: float | None) -> bool | None:
    """True for a key that stores, False for one that ends, None if the time is over."""
    end = None if seconds is None else time.monotonic() + seconds
    while True:
        rest = None if end is None else max(0.0, end - time.monotonic())
        key = pressed(rest)
        if key == b"":
            return None
        if key in END_KEYS:
            return False
        if key in _STORE_KEYS:
            return True


@contextmanager
def terminal_keys() -> Iterator[Callable[[float | None], bytes]]:
    """Yield a reader of single keys of the terminal, or of characters of another input; Ctrl-C
    stays Ctrl-C.

    It waits for the given seconds, and returns b"" if none came. The end of the input is a key,
    too.
    """
    try:
        import termios
        import tty
    except ImportError:  # another system: a line is what it gives
        yield lambda _: b"\n" if sys.stdin.readline() else END_KEYS[-1:]
        return
    source = sys.stdin.fileno()

    def pressed(seconds: float | None) -> bytes:
        ready, _, _ = select.select([source], [], [], seconds)
        return (os.read(source, 1) or END_KEYS[-1:]) if ready else b""

    if not os.isatty(source):
        yield pressed
        return
    before = termios.tcgetattr(source)
    tty.setcbreak(source)
    try:
        yield pressed
    finally:
        termios.tcsetattr(source, termios.TCSADRAIN, before)
