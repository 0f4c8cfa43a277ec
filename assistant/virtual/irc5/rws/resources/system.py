"""`/rw/system` and `/ctrl`: what the controller is, its clock, backup and restore."""

from __future__ import annotations

import shutil
from datetime import datetime
from typing import Final

from assistant.virtual.irc5.backup import back_up, is_backup, restore
from assistant.virtual.irc5.cabinet import SYSTEM_ID, VERSIONS, Cabinet
from assistant.virtual.irc5.programs import NotPossible
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request
from assistant.virtual.irc5.rws.resources.files import path_of, unit_path

SYSTEM_OPTIONS: Final = (
    "RobotWare Base",
    "English",
    "616-1 PC Interface",
    "689-1 Externally Guided Motion",
)
CONTROLLER_TIME: Final = "%Y-%m-%d T %H:%M:%S"
CLOCK: Final = ("year", "month", "day", "hour", "min", "sec")


def system_info(cabinet: Cabinet, request: Request) -> Answer:
    version = VERSIONS[request.dialect]
    major, minor, *_ = version.split(".")
    fields = {
        "major": major,
        "minor": minor,
        "name": cabinet.name,
        "rwversion": version,
        "sysid": SYSTEM_ID,
        "starttm": cabinet.began.strftime(CONTROLLER_TIME),
        "rwversionname": f"{major}.{minor}.00.00",
    }
    own = Item(request.either("sys-system-li", "sys-system"), "system", fields)
    kind = request.either("sys-option-li", "sys-options")
    inside = tuple(Item(kind, str(i), {"option": one}) for i, one in enumerate(SYSTEM_OPTIONS))
    listed = Item("sys-options-li", "options", {}, "options", inside, "options")
    return Answer(items=[own], listed=[listed])


def system_options(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(
        items=[Item("sys-option-li", str(i), {"option": o}) for i, o in enumerate(SYSTEM_OPTIONS)]
    )


def robot_type(cabinet: Cabinet, request: Request) -> Answer:
    title = "none" if cabinet.robot is None else cabinet.robot.title
    return Answer(items=[Item("sys-robottype", "robottype", {"robot-type": title})])


def controller_identity(cabinet: Cabinet, request: Request) -> Answer:
    fields = {
        "ctrl-name": cabinet.name,
        "ctrl-type": "Virtual Controller",
        "ctrl-level": "System Level",
    }
    if cabinet.serial:
        fields["ctrl-id"] = cabinet.serial
    return Answer(items=[Item("ctrl-identity-info", "identity", fields)])


def read_clock(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"datetime": cabinet.now().strftime(CONTROLLER_TIME)}
    return Answer(items=[Item("ctrl-clock-info", "clock", fields)])


def set_clock(cabinet: Cabinet, request: Request) -> Answer:
    try:
        wanted = datetime.strptime(
            " ".join(request.given(f"sys-clock-{part}") for part in CLOCK), "%Y %m %d %H %M %S"
        )
    except (ValueError, OverflowError):
        raise Rejected(reasons.BAD_ARGUMENT, "no time") from None
    cabinet.offset += wanted - cabinet.now()
    return DONE


def volume_path(cabinet: Cabinet, request: Request) -> Answer:
    """`/ctrl/$RAMDISK`: where a volume is."""
    volume = request.captures["volume"].upper()
    if volume not in ("HOME", "TEMP", "RAMDISK", "BACKUP"):
        raise Rejected(reasons.NO_RESOURCE)
    value = f"/hd0a/{cabinet.name}/{volume}"
    return Answer(items=[Item("ctrl-env", f"${volume}", {"_value": value, "value": value})])


# ------------------------------------------------------------------------------- backup


def backup_state(cabinet: Cabinet, request: Request) -> Answer:
    """It is made while the request that asks for it is answered, so none is ever under way."""
    fields = {"progress-state": "idle", "backup-state": "idle"}
    return Answer(items=[Item("ctrl-backup-info-li", "backup", fields)])


def backup_ready(cabinet: Cabinet, request: Request) -> Answer:
    """The last of: None, Init State, Backup in Progress, Backup Ready, Error during backup."""
    return Answer(items=[Item("ctrl-backup-state", "backup", {"backup-state": "Backup Ready"})])


def read_progress(cabinet: Cabinet, request: Request) -> Answer:
    """Of what a 202 was answered to."""
    number = request.captures["number"]
    return Answer(items=[Item("progress", number, {"state": "ready", "code": "294912"})])


def create_backup(cabinet: Cabinet, request: Request) -> Answer:
    target = path_of(cabinet, unit_path(request.given("backup")))
    if target.exists():
        raise Rejected(reasons.BAD_ARGUMENT, "there is a file or folder of that name")
    try:
        cabinet.do(lambda programs: back_up(programs, target, cabinet))
    except OSError as wrong:
        shutil.rmtree(target, ignore_errors=True)
        raise Rejected(reasons.UNSPECIFIED, wrong.strerror or "") from None
    return Answer(202, headers={"Location": "/progress/1"})


def restore_backup(cabinet: Cabinet, request: Request) -> Answer:
    source = path_of(cabinet, unit_path(request.given("backup")))
    if not is_backup(source):
        raise Rejected(reasons.BAD_ARGUMENT, "no backup")
    try:
        cabinet.do(lambda programs: restore(programs, source, cabinet))
    except ValueError as wrong:
        raise Rejected(reasons.BAD_ARGUMENT, str(wrong)) from None
    except NotPossible as wrong:
        raise Rejected(reasons.WRONG_STATE, str(wrong)) from None
    except OSError as wrong:
        raise Rejected(reasons.UNSPECIFIED, wrong.strerror or "") from None
    return Answer(202, headers={"Location": "/ctrl/backup"})


def check_backup(cabinet: Cabinet, request: Request) -> Answer:
    if not is_backup(path_of(cabinet, unit_path(request.given("backup")))):
        raise Rejected(reasons.BAD_ARGUMENT, "no backup")
    return DONE
