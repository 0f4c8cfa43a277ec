"""Controller state by Robot Web Services: panel, pose, event log, signals, and system parameters.

The panel gives motors, mode, speed, and what keeps the controller from moving. Inputs and outputs
go by name. System parameters are instances of the configuration database, by domain, type and name:
`EIO/EIO_SIGNAL/doGripper/Access` is an attribute of an instance, a shorter name all below it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from datetime import datetime
from typing import Final, Literal

from assistant.base.diagnostics import Refused
from assistant.controllers import rules
from assistant.controllers.abb.rws.protocol import Answer, Row, numbers
from assistant.controllers.abb.rws.session import Mastership, NotThere, Session
from assistant.controllers.states import Fault, Identity, Mode, Position, State, TaskState

_OPERATING_MODES: Final[dict[str, Mode]] = {"AUTO": "automatic", "MANR": "manual", "MANF": "manual"}
"""MANR: manual at reduced speed, MANF: at full speed; others are on the way to one."""
_STANDSTILLS: Final = {
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
_UNUSED: Final = 8.9e9
_NO_EXTERNAL_AXIS: Final = "9E+09"
"""Text of a missing external axis in RAPID; controllers round it a little."""
AXES: Final = tuple(f"rax_{n}" for n in range(1, 7))
_EXTERNAL_AXES: Final = tuple("abcdef")
CONFIGURATION: Final = ("cf1", "cf4", "cf6", "cfx")


class Panel:
    """unit: the mechanical unit whose pose is reported."""

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
        fault = _STANDSTILLS.get(motors)
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
        return _OPERATING_MODES.get(mode, ""), motors, self.running(), _whole(ratio)

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
        # External axes are J7 and on: axes that the robot lacks are filled in before them.
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
    names = [f"eax_{axis}" for axis in _EXTERNAL_AXES if f"eax_{axis}" in joints.values]
    values = [value if abs(value) < _UNUSED else None for value in numbers(joints, names)]
    # Trailing axes that are missing are left out; those in between keep their place.
    while values and values[-1] is None:
        values.pop()
    return tuple(values)


def _robtarget(pose: Row) -> str:
    """The pose as RAPID writes a robtarget; "" where the controller leaves something out."""
    groups = (("x", "y", "z"), ("q1", "q2", "q3", "q4"), CONFIGURATION)
    if any(name not in pose.values for group in groups for name in group):
        return ""
    told = [
        pose.get(f"eax{a}", f"eax_{a}", f"ej{n}") for n, a in enumerate(_EXTERNAL_AXES, start=1)
    ]
    parts = [*(",".join(pose.get(name) for name in group) for group in groups), _axes(told)]
    return f"[{','.join(f'[{part}]' for part in parts)}]"


def _axes(told: Sequence[str]) -> str:
    """External axes as RAPID writes them: 9E+09 for one that there is not."""
    found = []
    for text in told:
        try:
            used = abs(float(text)) < _UNUSED
        except ValueError:
            used = False
        found.append(text if used else _NO_EXTERNAL_AXIS)
    return ",".join(found)


_COMMON_LOG: Final = "0"
"""Domain of the log that holds the events of all others."""
_EVENT_LEVELS: Final[dict[str, Literal["error", "warning", "info"]]] = {
    "1": "info",
    "2": "warning",
    "3": "error",
}
_EVENT_TIME: Final = re.compile(r"(\d{4}-\d\d-\d\d)\s*T\s*(\d\d:\d\d:\d\d)")


def latest_events(session: Session, most: int) -> tuple[Fault, ...]:
    """The latest events, the newest first."""
    rows = [row for page in _event_pages(session, most) for row in page.of("elog-message")]
    newest = sorted(rows, key=_event_number, reverse=True)
    return tuple(_event_fault(row) for row in newest[: max(most, 0)])


def _event_pages(session: Session, most: int) -> list[Answer]:
    doing, at = "reading the event log", {"path": _COMMON_LOG}
    if "newest events" in session.dialect.operations:
        try:
            return session.pages("newest events", doing=doing, at=at, enough=most)
        except rules.Lost:
            raise
        except Refused:  # an older system lists the oldest first
            return session.pages("events", doing=doing, at=at)
    return session.pages("events", doing=doing, at=at)


def _event_number(row: Row) -> int:
    """The number that events are counted with, from `/rw/elog/0/14073`."""
    last = (row.title or row.href.partition("?")[0]).rpartition("/")[2]
    return int(last) if last.isdecimal() else 0


def _event_fault(row: Row) -> Fault:
    code = row.get("code")
    told = _EVENT_TIME.search(row.get("tstamp"))
    parts = (row.get("title"), row.get("desc"))
    return Fault(
        number=int(code) if code.isdecimal() else 0,
        text=": ".join(part for part in parts if part),
        level=_EVENT_LEVELS.get(row.get("msgtype"), "info"),
        cure=row.get("actions"),
        time=_event_time(*told.groups()) if told else None,
    )


def _event_time(day: str, clock: str) -> datetime | None:
    try:
        return datetime.fromisoformat(f"{day} {clock}")
    except ValueError:
        return None


_SIGNAL_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")
INPUTS: Final = frozenset({"DI", "AI", "GI"})
OUTPUTS: Final = frozenset({"DO", "AO", "GO"})
_LARGEST_GROUP: Final = 2**32 - 1


class Signals:
    def __init__(self, session: Session, mastership: Mastership) -> None:
        self._session = session
        self._mastership = mastership
        self._places: dict[str, tuple[str, str]] = {}

    def values(self, names: Sequence[str], kinds: frozenset[str]) -> dict[str, float]:
        """Return the values of signals; without names, of all signals of these kinds.

        A named signal of another kind is reported as well: its value is valid.
        """
        if not names:
            return self._all(kinds)
        return {name: self._value(name) for name in names}

    def place(self, name: str) -> str:
        """Network, device and name of a signal, as its address has them."""
        return self._place(name)[0]

    def known(self, name: str) -> str:
        """The name, if there is such a signal."""
        self._place(name)
        return name

    def set(self, name: str, value: float) -> None:
        path, kind = self._place(name)
        if kind not in OUTPUTS:
            raise self._session.refusal(
                f"set `{name}`", f"it is no output but a {kind}", "name an output"
            )
        whole = math.isfinite(value) and value == int(value)
        good = {
            "DO": value in (0, 1),
            "GO": whole and 0 <= value <= _LARGEST_GROUP,
            "AO": math.isfinite(value),
        }
        if not good[kind]:
            form = {"DO": "0 or 1", "GO": "a whole number from 0", "AO": "a number"}[kind]
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=f"{value:g}", what=f"the value of `{name}`",
                    reason=f"it is a {kind}", form=form,
                )
            )  # fmt: skip
        self._mastership.ask(
            "set signal",
            doing=f"setting `{name}`",
            state=f"`{name}` is as it was",
            form={"lvalue": str(int(value)) if whole else repr(value)},
            at={"path": path},
        )

    def _all(self, kinds: frozenset[str]) -> dict[str, float]:
        doing = "listing the signals"
        pages = self._session.pages("signals", doing=doing)
        rows = [row for page in pages for row in page.of("ios-signal")]
        wanted = [row for row in rows if row.get("type") in kinds]
        return {_checked_signal_name(row): self._number(row, doing) for row in wanted}

    def _value(self, name: str) -> float:
        doing = f"reading `{name}`"
        path, _ = self._place(name)
        rows = self._session.ask("signal", doing=doing, at={"path": path}).of("ios-signal")
        if not rows:
            raise self._session.garbled(doing, "there is no signal in it")
        return self._number(rows[0], doing)

    def _number(self, row: Row, doing: str) -> float:
        try:
            return float(row.get("lvalue"))
        except ValueError:
            raise self._session.garbled(doing, f"a value `{row.get('lvalue')}`") from None

    def _named(self, name: str) -> list[Row]:
        """Signals of a name; the controller looks for names that it is a part of."""
        doing = f"looking for the signal `{name}`"
        found = self._session.ask("find signal", doing=doing, form={"name": name})
        pages = [found]
        # The search is by a part of the name: its first page may lack the exact one.
        if found.next and not any(
            _checked_signal_name(r).lower() == name.lower() for r in found.rows
        ):
            pages = self._session.pages("signals", doing=doing)
        rows = [row for page in pages for row in page.of("ios-signal")]
        return [row for row in rows if _checked_signal_name(row).lower() == name.lower()]

    def _place(self, name: str) -> tuple[str, str]:
        """Address and type of a signal; looked for once, for they stay until a restart."""
        if not _SIGNAL_NAME.fullmatch(name):
            reason = "a letter, then letters, digits and `_`, 32 at most"
            raise Refused(
                rules.BAD_VALUE(
                    place=name,
                    value=name,
                    what="the name of a signal",
                    reason=reason,
                    form="`doGripper`",
                )
            )
        if name not in self._places:
            same = self._named(name)
            if not same:
                raise self._session.refusal(
                    f"find the signal `{name}`", "there is none", "check its name"
                )
            self._places[name] = (
                same[0].title or _checked_signal_name(same[0]),
                same[0].get("type"),
            )
        return self._places[name]


def _checked_signal_name(row: Row) -> str:
    return row.get("name") or row.title.rpartition("/")[2]


_PARAMETER_PART: Final = re.compile(r"[A-Za-z0-9_.\- ]+")
_UNSAFE_IN_VALUE: Final = re.compile(r"[\x00-\x1f\x7f&%+\[\]\"]")
"""Characters that would start another attribute, or end the value, in the form of RWS 2.0."""


class Configuration:
    def __init__(self, session: Session, mastership: Mastership) -> None:
        self._session = session
        self._mastership = mastership

    def values(self, names: Sequence[str]) -> dict[str, str]:
        """Attributes by `DOMAIN/TYPE/INSTANCE/ATTRIBUTE`, of names of two to four parts."""
        if not names:
            raise self._session.refusal(
                "tell which parameters have been changed",
                "it does not keep account of that",
                "name them, as in `EIO/EIO_SIGNAL`, or make a backup",
            )
        found: dict[str, str] = {}
        for name in names:
            parts = self._parts(name, 2)
            here = {
                full: value
                for full, value in self._of_type(parts[0], parts[1]).items()
                if full.lower().split("/")[: len(parts)] == [part.lower() for part in parts]
            }
            if not here:
                raise self._session.refusal(
                    f"tell `{name}`", "there is no such parameter", "check domain, type and name"
                )
            found.update(here)
        return found

    def set(self, name: str, value: str) -> None:
        """Sets an attribute; most take hold after the controller has been restarted."""
        domain, kind, instance, attribute = self._parts(name, 4)
        if _UNSAFE_IN_VALUE.search(value):
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=value, what=f"the value of `{name}`",
                    reason="it holds a character that is not sent", form="text without `& % + [ ]`",
                )
            )  # fmt: skip
        if name.lower() not in {known.lower() for known in self.values((name,))}:
            raise self._session.refusal(f"set `{name}`", "there is none", "check its name")
        doing = f"setting `{name}`"
        # RWS 2.0 takes a list of value and index.
        written = f"[{value},1]" if self._session.dialect.secure else value
        self._mastership.ask(
            "set instance",
            doing=doing,
            state=f"`{name}` is as it was",
            form={attribute: written},
            at={"domain": domain, "type": kind, "instance": instance},
        )

    def _parts(self, name: str, least: int) -> list[str]:
        parts = name.split("/")
        if not least <= len(parts) <= 4 or not all(
            _PARAMETER_PART.fullmatch(part) for part in parts
        ):
            raise Refused(
                rules.BAD_VALUE(
                    place=name, value=name, what="the name of a parameter",
                    reason="it is DOMAIN/TYPE/INSTANCE/ATTRIBUTE",
                    form="`EIO/EIO_SIGNAL/doGripper/Access`",
                )
            )  # fmt: skip
        return parts

    def _of_type(self, domain: str, kind: str) -> dict[str, str]:
        doing = f"reading the parameters `{domain}/{kind}`"
        pages = self._session.pages("instances", doing=doing, at={"domain": domain, "type": kind})
        return {
            f"{domain}/{kind}/{name}": value
            for page in pages
            for name, value in _attributes(page).items()
        }


def _attributes(page: Answer) -> dict[str, str]:
    """`INSTANCE/ATTRIBUTE` → value; the rows of attributes follow that of their instance."""
    found: dict[str, str] = {}
    instance = ""
    for row in page.rows:
        if row.kind.startswith("cfg-dt-instance"):
            # Rows of attributes follow the row of their instance.
            instance = _checked_parameter_part(row)
        elif row.kind.startswith("cfg-ia-t") and instance:
            found[f"{instance}/{row.title}"] = row.get("value")
    return found


def _checked_parameter_part(row: Row) -> str:
    return row.title.rpartition("/")[2] or row.get("name")
