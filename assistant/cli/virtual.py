"""`virtual irc5` and `virtual cr`: a controller that runs until Ctrl-C."""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from assistant.cli.presentation import say
from assistant.controllers.credentials import PASSWORD
from assistant.program.diagnostics import Refused, error

if TYPE_CHECKING:
    from assistant.virtual.cr import VirtualCr
    from assistant.virtual.irc5 import VirtualIrc5

NOT_STARTED = error(
    "CL101",
    "the virtual controller cannot start: {reason}",
    "name another port or folder; ports below 1024 need more rights",
)


def run_irc5(folder: Path, port: int, user: str) -> None:
    from assistant.virtual.irc5 import VirtualIrc5

    given = os.environ.get(PASSWORD)
    controller = VirtualIrc5(folder, port=port, user=user, password=given, report=_report)
    _run(controller, f"HOME: is {controller.folder}", None if given else controller.password)


def run_cr(robot: str, port: int, log: bool) -> None:
    from assistant.compiler.arms import robot_of
    from assistant.languages import get
    from assistant.virtual.cr import VirtualCr

    arm = robot_of(robot)
    assert arm is not None
    try:
        controller = VirtualCr(arm.name, port=port, report=_report if log else None)
    except ValueError as error:
        raise Refused(NOT_STARTED(place=robot, reason=error), exit_status=2) from None
    _run(controller, f"{arm.title}, {get(controller.state.language).title}", None)


def _run(controller: VirtualIrc5 | VirtualCr, about: str, password: str | None) -> None:
    """Runs until Ctrl-C. A password that was made up is told, as nobody else knows it."""
    try:
        controller.start()
    except OSError as error:
        reason = error.strerror or str(error)
        raise Refused(NOT_STARTED(reason=reason), exit_status=2) from None
    try:
        say(f"listening at {controller.address} ({about}); Ctrl-C ends it")
        if password is not None:
            say(f"password: {password} (set {PASSWORD} to choose one)")
        sys.stdout.flush()
        threading.Event().wait()
    except KeyboardInterrupt:
        say("ended")
    finally:
        controller.stop()


def _report(line: str) -> None:
    say(line)
    sys.stdout.flush()
