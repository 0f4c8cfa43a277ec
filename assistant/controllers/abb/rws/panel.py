"""The panel of a controller: motors, mode, speed, what it stands still for; and the pose."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from assistant.controllers.abb.rws.answers import Answer, Row, numbers
from assistant.controllers.abb.rws.mastership import Mastership
from assistant.controllers.abb.rws.session import NotThere, Session
from assistant.controllers.states import Fault, Identity, Mode, Position, State, TaskState

OPERATING_MODES: Final[dict[str, Mode]] = {"AUTO": "automatic", "MANR": "manual", "MANF": "manual"}
"""MANR: manual at reduced speed, MANF: at full speed; others are on the way to one."""
STANDSTILLS: Final = {
    "guardstop": Fault(
        10012, "safety guard stop", cure="close the guard, then switch the motors on"
    ),
    "emergencystop": Fault(
        10013, "emergency stop", cure="release the button, then press motors on at the controller"
    ),
    "emergencystopreset": Fault(
        10013,
        "emergency stop, the button is released",
        cure="press motors on at the controller",
    ),
    "sysfail": Fault(10014, "system failure", cure="look into the event log, restart"),
}
"""Controller state → the event that the controller logs with it."""
UNUSED: Final = 8.9e9
NO_EXTERNAL_AXIS: Final = "9E+09"
"""How RAPID writes an external axis that there is not; controllers round it a little."""
AXES: Final = tuple(f"rax_{n}" for n in range(1, 7))
EXTERNAL_AXES: Final = tuple("abcdef")
CONFIGURATION: Final = ("cf1", "cf4", "cf6", "cfx")


class Panel:
    """unit: the mechanical unit whose pose is told."""

    def __init__(self, session: Session, mastership: Mastership, unit: str) -> None:
        self._session = session
        self._mastership = mastership
        self._unit = unit

    def identify(self, system: Answer) -> Identity:
        """system: what the controller said when the session was opened."""
        doing = "asking what it is"
        identity = self._one("identity", doing, "ctrl-identity-info")
        try:
            robot = self._one("robot type", doing, "sys-robottype").get("robot-type", "type")
        except NotThere:
            robot = ""
        version = next((row.get("rwversion") for row in system.rows if row.get("rwversion")), "")
        return Identity(
            robot=robot,
            controller=identity.get("ctrl-name"),
            version=version,
            serial=identity.get("ctrl-id"),
        )

    def state(self, tasks: tuple[TaskState, ...]) -> State:
        mode, motors, running, override = self.lamps()
        fault = STANDSTILLS.get(motors)
        return State(
            mode=mode,
            motors=motors == "motoron",
            running=running,
            emergency=motors.startswith("emergencystop"),
            right=self._mastership.held,
            override=override,
            tasks=tasks,
            faults=(fault,) if fault else (),
        )

    def lamps(self) -> tuple[Mode, str, bool, int | None]:
        """Mode, controller state, whether programs run, speed ratio in percent."""
        doing = "asking for its state"
        motors = self.motors()
        mode = self._one("mode", doing, "pnl-opmode").get("opmode").upper()
        ratio = self._one("override", doing, "pnl-speedratio").get("speedratio")
        return OPERATING_MODES.get(mode, ""), motors, self.running(), _whole(ratio)

    def motors(self) -> str:
        """Controller state: `motoron`, `motoroff`, `guardstop`, `emergencystop`, …"""
        return self._one("motors", "asking for its state", "pnl-ctrlstate").get("ctrlstate").lower()

    def running(self) -> bool:
        row = self._one("execution", "asking whether programs run", "rap-execution")
        state = row.get("ctrlexecstate", "excstate").lower()
        if state not in ("running", "stopped", "stop"):
            raise self._session.garbled("asking whether programs run", f"a state `{state}`")
        return state == "running"

    def set_motors(self, on: bool) -> None:
        wanted = "motoron" if on else "motoroff"
        self._mastership.ask(
            "set motors",
            doing=f"switching the motors {'on' if on else 'off'}",
            state="the motors are as they were",
            form={"ctrl-state": wanted},
        )

    def set_override(self, percent: int) -> None:
        self._mastership.ask(
            "set override",
            doing="setting the speed ratio",
            state="the speed ratio is as it was",
            form={"speed-ratio": str(percent)},
        )

    def position(self) -> Position:
        """The pose of the tool in use in the work object in use."""
        doing = "asking where the arm is"
        unit = self._one("unit", doing, "ms-mechunit", at={"unit": self._unit})
        tool, frame = unit.get("tool-name") or "tool0", unit.get("wobj-name") or "wobj0"
        joints = self._one("joints", doing, "ms-jointtarget", at={"unit": self._unit})
        query = {"tool": tool, "wobj": frame}
        pose = self._one(
            "pose", doing, "ms-robtargets", "ms-robtarget", query=query, at={"unit": self._unit}
        )
        try:
            axes = numbers(joints, AXES[: _whole(unit.get("axes")) or 6])
            outside = _external(joints, _whole(unit.get("axes-total")), len(axes))
            x, y, z = numbers(pose, ("x", "y", "z"))
            w, i, j, k = numbers(pose, ("q1", "q2", "q3", "q4"))
        except ValueError as error:
            raise self._session.garbled(doing, str(error)) from None
        padding = (None,) * (6 - len(axes)) if outside else ()
        return Position(
            joints=(*axes, *padding, *outside),
            position=(x, y, z),
            quaternion=(w, i, j, k),
            text=_robtarget(pose),
        )

    def _one(
        self,
        name: str,
        doing: str,
        *kinds: str,
        query: dict[str, str] | None = None,
        at: dict[str, str] | None = None,
    ) -> Row:
        """The row of an answer that must have one."""
        rows = self._session.ask(name, doing=doing, query=query, at=at).of(*kinds)
        if not rows:
            raise self._session.garbled(doing, f"there is no `{kinds[0]}` in it")
        return rows[0]


def _whole(text: str) -> int | None:
    return int(text) if re.fullmatch(r"\d{1,4}", text) else None


def _external(joints: Row, total: int | None, inside: int) -> tuple[float | None, ...]:
    """External axes; those that the unit lacks read 9E9, or 0 beside a number of axes."""
    if total is not None and total <= inside:
        return ()
    names = [f"eax_{axis}" for axis in EXTERNAL_AXES if f"eax_{axis}" in joints.values]
    values = [value if abs(value) < UNUSED else None for value in numbers(joints, names)]
    while values and values[-1] is None:
        values.pop()
    return tuple(values)


def _robtarget(pose: Row) -> str:
    """The pose as RAPID writes a robtarget; "" where the controller leaves something out."""
    groups = (("x", "y", "z"), ("q1", "q2", "q3", "q4"), CONFIGURATION)
    if any(name not in pose.values for group in groups for name in group):
        return ""
    told = [pose.get(f"eax{a}", f"eax_{a}", f"ej{n}") for n, a in enumerate(EXTERNAL_AXES, start=1)]
    parts = [*(",".join(pose.get(name) for name in group) for group in groups), _axes(told)]
    return f"[{','.join(f'[{part}]' for part in parts)}]"


def _axes(told: Sequence[str]) -> str:
    """External axes as RAPID writes them: 9E+09 for one that there is not."""
    found = []
    for text in told:
        try:
            used = abs(float(text)) < UNUSED
        except ValueError:
            used = False
        found.append(text if used else NO_EXTERNAL_AXIS)
    return ",".join(found)
