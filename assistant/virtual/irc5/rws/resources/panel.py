"""`/rw/panel`: motors, operating mode, speed ratio, emergency stop."""

from __future__ import annotations

from typing import Final, get_args

from assistant.virtual.irc5.cabinet import Cabinet
from assistant.virtual.irc5.panel import Mode
from assistant.virtual.irc5.rws import reasons
from assistant.virtual.irc5.rws.answers import DONE, Answer, Item, Rejected
from assistant.virtual.irc5.rws.request import Request

OPERATING_MODES: Final[dict[str, Mode]] = {
    "auto": "AUTO",
    "man": "MANR",
    "manfs": "MANF",
    "manf": "MANF",
    **{mode.lower(): mode for mode in get_args(Mode)},
}


def motor_state(cabinet: Cabinet, request: Request) -> Answer:
    title = request.either("ctrlstate", "ctrl-state")
    return Answer(items=[Item("pnl-ctrlstate", title, {"ctrlstate": cabinet.panel.state})])


def set_motor_state(cabinet: Cabinet, request: Request) -> Answer:
    wanted = request.given("ctrl-state")
    if wanted not in ("motoron", "motoroff"):
        raise Rejected(reasons.BAD_ARGUMENT, f"ctrl-state {wanted}")
    try:
        if wanted == "motoroff":
            cabinet.do(lambda programs: programs.fail("the motors were switched off"))
        cabinet.panel.set_motors(wanted == "motoron")
    except ValueError as wrong:
        raise Rejected(reasons.WRONG_STATE, str(wrong)) from None
    return DONE


def operating_mode(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(items=[Item("pnl-opmode", "opmode", {"opmode": cabinet.panel.mode})])


def set_operating_mode(cabinet: Cabinet, request: Request) -> Answer:
    """As virtual controllers let one do it; of a real one only its key does."""
    wanted = OPERATING_MODES.get(request.given("opmode").lower())
    if wanted is None:
        raise Rejected(reasons.BAD_ARGUMENT, "opmode")
    cabinet.panel.set_mode(wanted)
    return DONE


def speed_ratio(cabinet: Cabinet, request: Request) -> Answer:
    fields = {"speedratio": str(cabinet.panel.speed)}
    return Answer(items=[Item("pnl-speedratio", "speedratio", fields)])


def set_speed_ratio(cabinet: Cabinet, request: Request) -> Answer:
    text = request.given("speed-ratio")
    try:
        ratio = round(float(text))
    except (ValueError, OverflowError):
        ratio = -1
    if not 0 <= ratio <= 100:
        raise Rejected(reasons.BAD_ARGUMENT, f"speed-ratio {text}")
    if cabinet.panel.mode != "AUTO":
        raise Rejected(reasons.WRONG_STATE, "only in automatic mode")
    cabinet.panel.speed = ratio
    return DONE


def collision_detection(cabinet: Cabinet, request: Request) -> Answer:
    return Answer(items=[Item("pnl-coldetstate", "collisiondetectstate", {"coldetstate": "INIT"})])


def emergency_stop(cabinet: Cabinet, request: Request) -> Answer:
    """`off` presses it, as on virtual controllers of RobotWare 7 (abb-rws-client, panel.ts)."""
    wanted = request.given("state").lower()
    if wanted not in ("on", "off"):
        raise Rejected(reasons.BAD_ARGUMENT, "state")
    if wanted == "off":
        cabinet.press_emergency_stop()
    else:
        cabinet.release_emergency_stop()
    return DONE
