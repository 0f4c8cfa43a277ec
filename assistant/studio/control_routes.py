"""Control of an arm: taken by typing its name, given up, and what may be done with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.studio import rules
from assistant.studio.answering import Question, asks, changes, finding_records
from assistant.studio.connections import Connection
from assistant.studio.controller_routes import connection_of, refuse_unconfirmed
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.studio.control import Control


def control_of(studio: Studio, asked: Question) -> Control:
    """The control that the window has; raises Refused if it has none."""
    from assistant.studio.control import Control

    found = studio.live.get("control")
    if not isinstance(found, Control) or found.window != asked.window:
        raise Refused(rules.NO_CONTROL())
    return found


def take_control(studio: Studio, asked: Question) -> dict[str, Any]:
    """From now on the window may move the arm; its name has to be typed."""
    with studio.beginning:
        return _control_record(studio, asked)


def _control_record(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.compiler.commanded_motion import check_position
    from assistant.studio.control import FASTEST_STEP, WATCH, Control

    found = connection_of(studio)
    refuse_unconfirmed(found.one, asked, "lets this window move the arm")
    told = check_position(found.do(lambda one: one.position()), found.robot)
    studio.drop("control")

    def say(message: Mapping[str, object]) -> None:
        studio.windows.tell_one(asked.window, message)

    def over() -> None:
        if studio.live.get("control") is made:
            studio.drop("control")
            studio.windows.tell({"kind": "controller"})

    def left_on(told: Sequence[Diagnostic]) -> None:
        studio.left_on = tuple(told)
        if told:
            studio.windows.tell(
                {"kind": "control", "left_on": True, "findings": finding_records(told)}
            )

    made = Control(found, asked.window, say, over, left_on)
    studio.live["control"] = made
    made.begin()
    if not studio.windows.writes(asked.window) or studio.live.get("connection") is not found:
        studio.drop("control")  # it has gone meanwhile
        raise Refused(rules.NO_CONTROL())
    studio.windows.tell({"kind": "controller"})
    return {
        "name": found.one.name,
        "watch": WATCH,
        "fastest": FASTEST_STEP,
        "findings": finding_records(told),
    }


def give_up_control(studio: Studio, asked: Question) -> dict[str, Any]:
    control_of(studio, asked)
    studio.drop("control")
    studio.windows.tell({"kind": "controller"})
    return {}


def stop(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Stops the arm and all programs; any window may, at any time, also while control ends."""
    from assistant.studio.control import Control, rest_record

    there = (*studio.live.values(), *studio.leaving)
    for kind in (Control, Connection):
        for one in there:
            if isinstance(one, kind):
                return rest_record(one.stop())
    raise Refused(rules.NOT_CONNECTED())


def motors(studio: Studio, asked: Question) -> dict[str, Any]:
    control_of(studio, asked).motors(asked.truth("on"))
    return {}


def hand(studio: Studio, asked: Question) -> dict[str, Any]:
    control, found = control_of(studio, asked), connection_of(studio)
    number, opens = int(asked.number("number")), asked.truth("open")
    does = "opens" if opens else "closes"
    refuse_unconfirmed(found.one, asked, f"{does} hand {number}: what it holds may fall")
    control.do(lambda one: one.hand(number, open=opens))
    return {}


def teach(studio: Studio, asked: Question) -> dict[str, Any]:
    """Stores where the arm is under a name, as the command of that name does."""
    from assistant.base.source_text import is_file
    from assistant.compiler.taught_targets import TargetOptions
    from assistant.compiler.taught_targets import teach_target as stored
    from assistant.studio.dropping import check_file_name

    control_of(studio, asked)
    found, file = connection_of(studio), studio.place(asked.text("file"))
    if not is_file(file):
        check_file_name(file.name)
    wanted = TargetOptions(joints=asked.truth("joints"), again=asked.truth("replace"))
    position = found.do(lambda one: one.position())
    reading = stored(file, asked.text("name"), position, found.robot, wanted)
    return {"file": studio.named(file), "findings": finding_records(reading.findings)}


CONTROL_ROUTES: Final = (
    changes("/control/take", take_control),
    changes("/control/give-up", give_up_control),
    asks("/control/stop", stop, urgent=True),
    changes("/control/motors", motors, urgent=True),
    changes("/control/hand", hand),
    changes("/control/teach", teach),
)
