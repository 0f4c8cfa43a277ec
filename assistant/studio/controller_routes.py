"""Routes of the controller: connect, look, deploy, set, back up, and control of the arm.

Control is taken by typing the controller's name. `stop` is answered for any window at any time, in
threads that other requests cannot use up.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Diagnostic, Refused
from assistant.studio import rules
from assistant.studio.controller_session import Connection
from assistant.studio.route_answers import Question, asks, changes, finding_records, looks
from assistant.studio.studio import Studio

if TYPE_CHECKING:
    from assistant.controllers import Controller, Named, Programs
    from assistant.deploy import Plan
    from assistant.project import Target
    from assistant.studio.controller_session import Control


_MOST_EVENTS: Final = 50
_BACKUP_FOLDER: Final = "backups"
"""Folder of the project in which backups are kept."""


def _connection_of(studio: Studio) -> Connection:
    """Return the connected controller; raise Refused if not connected."""
    found = studio.live.get("connection")
    if not isinstance(found, Connection):
        raise Refused(rules.NOT_CONNECTED())
    return found


def _refuse_unconfirmed(one: Named, asked: Question, what: str) -> None:
    """Raises Refused unless the name of the controller was typed, as commands ask for it."""
    word = asked.text("word", "").strip()
    place = str(one.address)
    if not word:
        raise Refused(rules.NOT_CONFIRMED(place=place, what=what, word=one.word))
    if word != one.word:
        raise Refused(rules.OTHER_WORD(place=place, word=one.word))


# -------------------------------------------------------------------------------- connection


def controller(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Return the connected controller, and whether it is under a user's control."""
    from assistant.controllers.states import record
    from assistant.studio.controller_session import Control

    found = studio.live.get("connection")
    if not isinstance(found, Connection):
        return {"connected": False}
    control = studio.live.get("control")
    return {
        "connected": True,
        "name": found.one.name,
        "word": found.one.word,
        "address": str(found.one.address),
        "virtual": found.one.virtual is not None,
        "robot": found.one.robot,
        "identity": record(found.identity),
        "operates": found.operates,
        "signals": list(found.signals),
        "axes": _axis_records(found),
        "controlled": isinstance(control, Control),
    }


def _axis_records(found: Connection) -> list[dict[str, Any]]:
    robot = found.robot
    if robot is None:
        return []
    return [
        {"axis": axis, "least": float(low), "most": float(high), "unit": unit}
        for axis, (low, high), unit in zip(robot.axes, robot.limits, robot.units, strict=True)
    ]


def connect(studio: Studio, asked: Question) -> dict[str, Any]:
    """Connects to a controller that the project names; a password is used and not kept."""
    from assistant.controllers.named import of_project

    def lost() -> None:
        with studio.beginning:
            if studio.live.get("connection") is made:
                leave(studio, asked)

    one, password = (
        of_project(asked.text("name"), studio.folder),
        asked.text("password", "") or None,
    )
    with studio.beginning:
        leave(studio, asked)
        made = Connection(one, _kept_name(studio), studio.windows.tell, lost, password)
        studio.live["connection"] = made
        if not studio.windows.writes(asked.window):  # it has gone meanwhile
            leave(studio, asked)
    studio.windows.tell({"kind": "controller"})
    return controller(studio, asked) | {
        "findings": finding_records(tuple(_is_clear_text(studio, one)))
    }


def leave(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    with studio.beginning:
        studio.drop("control", "connection")
    studio.windows.tell({"kind": "controller"})
    return {"connected": False}


def _kept_name(studio: Studio) -> FilePath:
    from assistant.project import project_of
    from assistant.project.project_file import STATE_FOLDER

    with suppress(Refused):  # of another table than that of its controllers
        return project_of(studio.folder).kept
    return studio.folder / STATE_FOLDER


def _is_clear_text(studio: Studio, one: Named) -> Iterator[Diagnostic]:
    """Yield a finding if the connection is not encrypted, unless the project has accepted that."""
    from assistant.controllers.address import clear_text_finding
    from assistant.findings.severities import severities_for

    told = clear_text_finding(one.address)
    wanted = severities_for(studio.folder).of(told) if told else None
    if wanted:
        yield wanted


# ------------------------------------------------------------------------------------ looking


def watch(studio: Studio, asked: Question) -> dict[str, Any]:
    """Signals whose values come with what is seen."""
    found = _connection_of(studio)
    found.look_at(asked.texts("signals"))
    return {"signals": list(found.signals)}


def log(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    from assistant.controllers.states import record

    return {"log": record(_connection_of(studio).do(lambda one: one.log(_MOST_EVENTS)))}


def reset(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Acknowledges errors."""
    _connection_of(studio).do(lambda one: one.reset())
    return {}


def parameters(studio: Studio, asked: Question) -> dict[str, Any]:
    """Those that are named, or those that were changed."""
    names = asked.texts("names")
    return {"parameters": _connection_of(studio).do(lambda one: one.parameters(names))}


def _set_parameter(studio: Studio, asked: Question) -> dict[str, Any]:
    found = _connection_of(studio)
    name, value = asked.text("name"), asked.text("value")

    def put(one: Controller) -> dict[str, str]:
        does = "under a program that runs" if one.state().running else "on the controller"
        _refuse_unconfirmed(found.one, asked, f"changes `{name}` to `{value}` {does}")
        one.set_parameter(name, value)
        return one.parameters([name])

    return {"parameters": found.do(put)}


# ---------------------------------------------------------------------------------- deploying


def _controller_targets(studio: Studio, one: Named) -> list[Target]:
    """Return the project's targets for a controller; raise Refused if it has no targets."""
    from assistant.project import targets_of

    found = [target for target in targets_of(studio.folder) if target.controller.name == one.name]
    if not found:
        raise Refused(rules.NO_TARGET(name=one.name))
    return found


def plan(studio: Studio, asked: Question) -> dict[str, Any]:
    """Return the changes that a deployment would make, with the differences; `plan` names it for
    `deploy`.
    """
    from assistant.project.deployment import plan_record

    found = _connection_of(studio)

    def records(session: Programs) -> dict[str, Any]:
        plans = _plan_each(studio, found.one, session, asked)
        return {"plan": _plan_name(plans)} | _joined_records(
            [
                {
                    "target": target.name,
                    **plan_record(made, None, (*made.findings, *made.unseen)),
                }
                for target, made in plans
            ]
        )

    return found.apart(records)


def deploy(studio: Studio, asked: Question) -> dict[str, Any]:
    """Sends what the plan of that name showed; raises Refused where that is another one by now."""
    from assistant import deploy as deploying
    from assistant.project.deployment import plan_record

    found, shown = _connection_of(studio), asked.text("plan", "")

    def records(session: Programs) -> list[dict[str, Any]]:
        plans = _plan_each(studio, found.one, session, asked)
        if _plan_name(plans) != shown:
            raise Refused(rules.OTHER_PLAN(name=found.one.name))
        answers = []
        for target, made in plans:
            done = deploying.deploy(made, history=target.history)
            told = (*made.findings, *done.findings)
            answers.append({"target": target.name, **plan_record(made, done, told)})
        return answers

    return _joined_records(found.apart(records))


def _plan_each(
    studio: Studio, one: Named, session: Programs, asked: Question
) -> list[tuple[Target, Plan]]:
    """Return the plan of each target. replace: programs to overwrite although no deployment left
    them so.
    """
    from assistant.project.deployment import checked_plan

    replace = asked.texts("replace")
    return [
        (
            target,
            checked_plan(
                [studio.named(file) for file in target.files()],
                one,
                session,
                task=target.task,
                load=target.load,
                replace=replace,
                history=target.history,
            ),
        )
        for target in _controller_targets(studio, one)
    ]


def _plan_name(plans: Sequence[tuple[Target, Plan]]) -> str:
    """Return a digest of the present and the new programs; permission to replace is not part of
    it.
    """
    told = hashlib.sha256()
    for target, made in plans:
        told.update(repr((target.name, target.task, target.load, str(made.address))).encode())
        for one in made.files:
            held = (one.before.file, one.before.loaded, one.data)
            told.update(repr((one.name, held)).encode())
    return told.hexdigest()


def verify(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Return the comparison with the last deployment, and later changes on the controller."""
    from assistant import deploy as deploying
    from assistant.project.deployment import verified_record

    found = _connection_of(studio)

    def records(session: Programs) -> list[dict[str, Any]]:
        answers = []
        for target in _controller_targets(studio, found.one):
            files = [studio.named(file) for file in target.files()]
            seen = deploying.verify(session, files, history=target.history)
            answers.append({"target": target.name, **verified_record(seen)})
        return answers

    return _joined_records(found.apart(records))


def _roll_back(studio: Studio, asked: Question) -> dict[str, Any]:
    """Restore the programs from before the last deployment."""
    from assistant import deploy as deploying
    from assistant.project.deployment import deployment_record

    found, replace = _connection_of(studio), asked.texts("replace")
    history = _controller_targets(studio, found.one)[0].history
    done = found.apart(
        lambda session: deploying.rollback(session, history=history, replace=replace)
    )
    return deployment_record(done, back=True)


def _joined_records(answers: list[dict[str, Any]]) -> dict[str, Any]:
    """Join the records of all targets of a controller; their findings are listed together, as in
    other answers.
    """
    told = [finding for answer in answers for finding in answer.pop("findings")]
    return {
        "ok": all(answer["ok"] for answer in answers),
        "targets": answers,
        "findings": told,
    }


# ------------------------------------------------------------------------------------ backups


def backup(studio: Studio, asked: Question) -> dict[str, Any]:
    """Into a folder of the project that is not there yet."""
    found = _connection_of(studio)
    moment = f"{datetime.now():%Y-%m-%d-%H%M%S}"
    name = asked.text("folder", "") or f"{_BACKUP_FOLDER}/{found.one.name}-{moment}"
    folder = studio.place(name)
    if folder.exists():
        raise Refused(rules.FOLDER_THERE(path=name, name=name))
    folder.parent.mkdir(parents=True, exist_ok=True)
    files = found.do(lambda one: one.backup(folder))
    return {"folder": studio.named(folder), "files": len(files)}


def backups(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    folder = studio.folder / _BACKUP_FOLDER
    there = sorted(one for one in folder.iterdir() if one.is_dir()) if folder.is_dir() else []
    return {"folders": [studio.named(one) for one in there]}


def restore(studio: Studio, asked: Question) -> dict[str, Any]:
    """Return the differences from a backup; with `apply`, and confirmed, restore it."""
    found, only = _connection_of(studio), asked.texts("only")
    name, wanted = asked.text("folder"), asked.truth("apply")
    folder = studio.place(name)
    if not folder.is_dir():
        raise Refused(rules.NO_BACKUP(path=name, name=name))

    def bring(one: Controller) -> dict[str, Any]:
        restoring = one.restore(folder, only=only)
        does = wanted and bool(restoring.changes)
        if does:
            parts = len(restoring.changes)
            _refuse_unconfirmed(found.one, asked, f"changes {parts} parts of the controller")
            restoring.apply()
        return {
            "restored": does,
            "changes": dict(restoring.changes),
            "left_out": dict(restoring.left_out),
            "needs_restart": restoring.needs_restart,
        }

    return found.do(bring)


CONTROLLER_ROUTES: Final = (
    looks("/controller", controller),
    changes("/controller/connect", connect),
    changes("/controller/leave", leave),
    changes("/controller/watch", watch),
    looks("/controller/log", log),
    changes("/controller/acknowledge", reset),
    asks("/controller/parameters", parameters),
    changes("/controller/parameter", _set_parameter),
    asks("/controller/plan", plan),
    changes("/controller/deploy", deploy),
    asks("/controller/verify", verify),
    changes("/controller/rollback", _roll_back),
    looks("/controller/backups", backups),
    changes("/controller/backup", backup),
    changes("/controller/restore", restore),
)


def _control_of(studio: Studio, asked: Question) -> Control:
    """The control that the window has; raises Refused if it has none."""
    from assistant.studio.controller_session import Control

    found = studio.live.get("control")
    if not isinstance(found, Control) or found.window != asked.window:
        raise Refused(rules.NO_CONTROL())
    return found


def _take_control(studio: Studio, asked: Question) -> dict[str, Any]:
    """From now on the window may move the arm; its name has to be typed."""
    with studio.beginning:
        return _control_record(studio, asked)


def _control_record(studio: Studio, asked: Question) -> dict[str, Any]:
    from assistant.compiler.commanded_motion import check_position
    from assistant.studio.controller_session import FASTEST_STEP, WATCH, Control

    found = _connection_of(studio)
    _refuse_unconfirmed(found.one, asked, "lets this window move the arm")
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


def _give_up_control(studio: Studio, asked: Question) -> dict[str, Any]:
    _control_of(studio, asked)
    studio.drop("control")
    studio.windows.tell({"kind": "controller"})
    return {}


def stop(studio: Studio, asked: Question) -> dict[str, Any]:  # noqa: ARG001
    """Stops the arm and all programs; any window may, at any time, also while control ends."""
    from assistant.studio.controller_session import Control, rest_record

    there = (*studio.live.values(), *studio.leaving)
    for kind in (Control, Connection):
        for one in there:
            if isinstance(one, kind):
                return rest_record(one.stop())
    raise Refused(rules.NOT_CONNECTED())


def motors(studio: Studio, asked: Question) -> dict[str, Any]:
    _control_of(studio, asked).motors(asked.truth("on"))
    return {}


def hand(studio: Studio, asked: Question) -> dict[str, Any]:
    control, found = _control_of(studio, asked), _connection_of(studio)
    number, opens = int(asked.number("number")), asked.truth("open")
    does = "opens" if opens else "closes"
    _refuse_unconfirmed(found.one, asked, f"{does} hand {number}: what it holds may fall")
    control.do(lambda one: one.hand(number, open=opens))
    return {}


def teach(studio: Studio, asked: Question) -> dict[str, Any]:
    """Stores where the arm is under a name, as the command of that name does."""
    from assistant.base.source_text import is_file
    from assistant.compiler.taught_targets import TargetOptions
    from assistant.compiler.taught_targets import teach_target as stored
    from assistant.studio.project_routes import check_file_name

    _control_of(studio, asked)
    found, file = _connection_of(studio), studio.place(asked.text("file"))
    if not is_file(file):
        check_file_name(file.name)
    wanted = TargetOptions(joints=asked.truth("joints"), again=asked.truth("replace"))
    position = found.do(lambda one: one.position())
    reading = stored(file, asked.text("name"), position, found.robot, wanted)
    return {"file": studio.named(file), "findings": finding_records(reading.findings)}


CONTROL_ROUTES: Final = (
    changes("/control/take", _take_control),
    changes("/control/give-up", _give_up_control),
    asks("/control/stop", stop, urgent=True),
    changes("/control/motors", motors, urgent=True),
    changes("/control/hand", hand),
    changes("/control/teach", teach),
)
