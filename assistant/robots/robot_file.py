"""Robot files and the catalogue of them.

A robot file is the TOML of a robot, or a URDF with what it lacks in a TOML; each field that is
wrong gives a finding. The catalogue is the folder `catalogue` beside this module, one file a robot;
`load` reads a file of the user.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.base.arrays import Floats
from assistant.base.budgets import SETTINGS_FILE
from assistant.base.diagnostics import Refused, UnknownName, Unreadable, error
from assistant.base.near_names import did_you_mean
from assistant.base.source_text import read_bytes
from assistant.base.toml_text import parse_toml
from assistant.robots import urdf
from assistant.robots.arms.arm import Arm, Link
from assistant.robots.arms.closed_form import FiveAxis, Lengths, Scara, SixAxis
from assistant.robots.arms.serial import Serial
from assistant.robots.robot import Robot, usual_radii

_NO_TOML = error(
    "RB001", "the robot file is no TOML: {reason}", "compare it with a file of the catalogue"
)
_WRONG_FIELD = error(
    "RB002", "`{field}` of the robot file {reason}", "compare it with a file of the catalogue"
)
_UNKNOWN_ROBOT = error("CO002", "there is no robot `{name}`", "{cure}")
_LONGEST_NAME: Final = 80

_AXIS_NAMES: Final = {
    FiveAxis.kind: FiveAxis.axes,
    SixAxis.kind: SixAxis.axes,
    Scara.kind: Scara.axes,
}
"""Kind of arm → the names of its axes; an arm of five has no axis 4."""
LENGTH_NAMES: Final = {
    FiveAxis.kind: ("d1", "a1", "a2", "a3", "d4", "d6"),
    SixAxis.kind: ("d1", "a1", "a2", "a3", "d4", "d6"),
    Scara.kind: ("l1", "l2"),
}
"""Kind of arm → the names of its lengths."""


def read(data: bytes, path: str | None = None) -> Robot:
    """A robot from the bytes of a TOML or URDF file; raises Unreadable or Refused with findings.

    The key `urdf` of a TOML file names a URDF beside it, which says what the TOML does not.
    """
    if data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        drawn = urdf.read(data, path)
        return replace(_over({}, drawn, path), findings=drawn.findings)
    try:
        table = parse_toml(data.decode("utf-8"), path)
    except Refused:
        raise
    except ValueError as error:  # also what is no UTF-8, and an integer of thousands of digits
        raise Unreadable(_NO_TOML(path=path, reason=str(error))) from None
    except RecursionError:
        raise Unreadable(_NO_TOML(path=path, reason="its values are too deep")) from None
    drawing = table.pop("urdf", None)
    if drawing is None:
        return _finished(_Reader(table, path))
    if not isinstance(drawing, str):
        raise Refused(_WRONG_FIELD(path=path, place="urdf", field="urdf", reason="is no text"))
    file = FilePath(path or "robot.toml").parent / drawing
    return _over(table, urdf.read(read_bytes(file, most=SETTINGS_FILE), str(file)), path)


def _over(table: dict[str, Any], drawn: urdf.Drawn, path: str | None) -> Robot:
    """Return the robot of a URDF, with the values of a TOML table taking precedence."""
    merged = drawn.table | table
    for key in ("axes_deg", "axes_mm"):
        known, mine = drawn.table[key], table.get(key, {})
        if isinstance(mine, dict):
            merged[key] = known | {k: known.get(k, {}) | v for k, v in mine.items() if _is_table(v)}
            merged[key] |= {k: v for k, v in mine.items() if not _is_table(v)}
            for entry in filter(_is_table, merged[key].values()):
                entry.setdefault("home", _home(entry.get("limits")))
    reader = _Reader(merged, path, drawn)
    return _finished(reader)


def _home(limits: Any) -> float:
    """0, or the limit that is nearest to it."""
    if isinstance(limits, list) and len(limits) == 2 and all(map(_is_number, limits)):
        return float(min(max(0.0, limits[0]), limits[1]))
    return 0.0


def _finished(reader: _Reader) -> Robot:
    robot = reader.robot()
    if reader.findings:
        raise Refused(*reader.findings)
    assert robot is not None
    return robot


class _Reader:
    """Takes fields out of a table and collects what is wrong with them."""

    def __init__(
        self, table: dict[str, Any], path: str | None, drawn: urdf.Drawn | None = None
    ) -> None:
        self.table, self.path, self.drawn = table, path, drawn
        self.findings: list[Any] = []

    def robot(self) -> Robot | None:
        self.unknown(self.table, "", FIELDS)
        texts = {k: self.text(k) for k in ("name", "title", "maker", "controller", "source")}
        reach = self.number(self.table, "reach_mm", "reach_mm", least=1e-9)
        payload = self.optional(self.table, "payload_kg", "payload_kg")
        if self.drawn is None and payload is None:
            self.wrong("payload_kg", "is missing")
        fastest = self.optional(self.table, "tcp_speed_mm_s", "tcp_speed_mm_s")
        repeatability = self.optional(self.table, "repeatability_mm", "repeatability_mm")
        quick = self.optional(self.table, "time_to_speed_s", "time_to_speed_s")
        light = self.optional(self.table, "time_to_speed_kg", "time_to_speed_kg")
        counts = self.text("configuration")
        if counts not in ("quadrants", "turns"):
            self.wrong("configuration", "is neither `quadrants` nor `turns`")
        axes = self.axes()
        arm = self.moving(axes)
        if self.findings or arm is None:
            return None
        rows = [axes[name] for name in arm.axes]
        column = {k: np.array([axis[k] for axis in rows]) for k in ("zero", "speed", "home")}
        limits = np.array([axis["limits"] for axis in rows], dtype=np.float64)
        rates = self.accelerations(arm, axes)
        coupling = self.coupling(arm)
        if self.findings:
            return None
        for values in (limits, *column.values()):
            values.setflags(write=False)
        return Robot(
            name=texts["name"],
            title=texts["title"],
            maker=texts["maker"],
            controller=texts["controller"],
            source=texts["source"],
            languages=self.texts("languages"),
            unconfirmed=self.texts("unconfirmed", needed=False),
            arm=arm,
            zero=column["zero"],
            limits=limits,
            speeds=column["speed"],
            accelerations=rates,
            home=column["home"],
            tcp_speed=fastest,
            repeatability=repeatability,
            time_to_speed=quick,
            light=light or 0.0,
            coupling=coupling,
            payload=payload,
            reach=reach,
            radii=self.radii(arm, reach),
            counts="quadrants" if counts == "quadrants" else "turns",
            outlines=None if self.drawn is None else self.drawn.outlines,
        )

    def moving(self, axes: dict[str, dict[str, Any]]) -> Arm | None:
        """The arm: of the URDF, of the links of a chain, or of the lengths of its kind."""
        if self.drawn is not None:
            self.not_with_a_urdf()
            self.fitting(self.drawn.arm)
            return self.drawn.arm
        if self.table.get("arm") == Serial.kind:
            arm = self.serial(axes)
            if arm is not None:
                self.fitting(arm)
            return arm
        if "links" in self.table:
            self.wrong("links", f"belongs to arm `{Serial.kind}`")
        return self.arm(self.kind(tuple(axes)))

    def not_with_a_urdf(self) -> None:
        for key in ("arm", "lengths_mm", "links"):
            if key in self.table:
                self.wrong(key, "is what the URDF says")

    def fitting(self, arm: Arm) -> None:
        """Report tables that do not hold the axes of a chain; sliding axes belong in the one in
        mm.
        """
        for key, slides in (("axes_deg", False), ("axes_mm", True)):
            wanted = [n for n, s in zip(arm.axes, arm.sliding, strict=True) if bool(s) == slides]
            table = self.table.get(key, {})
            if isinstance(table, dict) and set(table) != set(wanted):
                self.wrong(key, f"does not hold the axes {' '.join(wanted) or '(none)'} of the arm")

    def serial(self, axes: dict[str, dict[str, Any]]) -> Serial | None:
        """A chain out of `[[links]]`, a row of standard Denavit-Hartenberg parameters an axis."""
        if "lengths_mm" in self.table:
            self.wrong("lengths_mm", "is what the links say")
        rows = self.table.get("links")
        if not isinstance(rows, list) or not rows or not all(map(_is_table, rows)):
            self.wrong("links", "is no list of tables: `[[links]]` with a, d, alpha, theta")
            return None
        if len(rows) > urdf.MOST_AXES:
            self.wrong("links", f"has {len(rows)} axes, more than {urdf.MOST_AXES}")
            return None
        sliding = self.table.get("axes_mm", {})
        links, ranges = [], []
        for number, row in enumerate(rows, 1):
            where = f"links[{number}]"
            self.unknown(row, f"{where}.", _LINK_FIELDS)
            values = {
                k: self.number(row, k, f"{where}.{k}") if k in row else 0.0 for k in _LINK_FIELDS
            }
            slides = isinstance(sliding, dict) and f"J{number}" in sliding
            alpha, theta = math.radians(values["alpha"]), math.radians(values["theta"])
            links.append(Link(values["a"], values["d"], alpha, theta, slides))
            low, high = axes.get(f"J{number}", {}).get("limits", [-180.0, 180.0])
            ranges.append((low, high) if slides else (math.radians(low), math.radians(high)))
        return Serial.of_links(links, ranges)

    def kind(self, axes: tuple[str, ...]) -> str:
        """Return the kind that `arm` states, or the one that the axes imply."""
        said = self.table.get("arm")
        usual = FiveAxis.kind if set(axes) == set(FiveAxis.axes) else SixAxis.kind
        kind = usual if said is None else said
        if not isinstance(kind, str) or kind not in _AXIS_NAMES:
            self.wrong("arm", f"is none of {', '.join((*_AXIS_NAMES, Serial.kind))}")
            return usual
        sliding = self.table.get("axes_mm", {})
        sliding = tuple(sliding) if isinstance(sliding, dict) else ()
        if set(axes) != set(_AXIS_NAMES[kind]) or sliding != _SLIDING_AXES.get(kind, ()):
            turning = [
                name for name in _AXIS_NAMES[kind] if name not in _SLIDING_AXES.get(kind, ())
            ]
            self.wrong("axes_deg", f"does not hold the axes {' '.join(turning)} of arm `{kind}`")
            if kind in _SLIDING_AXES:
                self.wrong("axes_mm", f"does not hold the axis {' '.join(_SLIDING_AXES[kind])}")
        return kind

    def arm(self, kind: str) -> Arm | None:
        lengths = self.table.get("lengths_mm")
        if not isinstance(lengths, dict):
            self.wrong("lengths_mm", "is missing")
            lengths = {}
        self.unknown(lengths, "lengths_mm.", LENGTH_NAMES[kind])
        values = {k: self.number(lengths, k, f"lengths_mm.{k}") for k in LENGTH_NAMES[kind]}
        for link in ("a2", "d4", "l1", "l2"):
            if not values.get(link, 1.0) > 0:
                self.wrong(f"lengths_mm.{link}", "is not above 0")
        if kind == Scara.kind:
            return Scara(**values)
        if kind == FiveAxis.kind and (values["a1"] or values["a3"]):
            self.wrong("lengths_mm", "has an a1 or a3, which an arm of five axes cannot have")
        return (FiveAxis if kind == FiveAxis.kind else SixAxis)(Lengths(**values))

    def radii(self, arm: Arm, reach: float) -> Floats:
        """Return (a + 1,) mm of the capsules around base and links; by the reach if the file states
        none.
        """
        values = usual_radii(len(arm.axes), reach)
        table = self.table.get("radii_mm", {})
        names = ("base", *arm.axes)
        if not isinstance(table, dict):
            self.wrong("radii_mm", "is no table of base and axes")
            table = {}
        self.unknown(table, "radii_mm.", names)
        for place, name in enumerate(names):
            if name in table:
                values[place] = self.number(table, name, f"radii_mm.{name}", least=1e-9)
        values.setflags(write=False)
        return values

    def coupling(self, arm: Arm) -> float:
        """Return how axis 3 turns with J2; 0 if the file does not state it."""
        if "coupling" not in self.table:
            return 0.0
        if not isinstance(arm, SixAxis | FiveAxis):
            self.wrong(
                "coupling", f"is of arms `{SixAxis.kind}` and `{FiveAxis.kind}` with lengths"
            )
        return self.number(self.table, "coupling", "coupling")

    def accelerations(self, arm: Arm, axes: dict[str, dict[str, Any]]) -> Floats | None:
        """Return (a,) a second squared, None if no axis has one; values for some axes alone are not
        usable.
        """
        rates = [axes[name]["acceleration"] for name in arm.axes]
        known = [rate for rate in rates if rate is not None]
        if not known:
            return None
        if len(known) < len(rates):
            for name, rate in zip(arm.axes, rates, strict=True):
                if rate is None:
                    table = "axes_mm" if name in _SLIDING_AXES.get(arm.kind, ()) else "axes_deg"
                    self.wrong(f"{table}.{name}.acceleration", "is missing; other axes have one")
        values = np.array(known, dtype=np.float64)
        values.setflags(write=False)
        return values

    def axes(self) -> dict[str, dict[str, Any]]:
        """The axes in degrees and, of an arm that has such, those in mm, by name."""
        found: dict[str, dict[str, Any]] = {}
        for key in ("axes_deg", "axes_mm"):
            table = self.table.get(key, {})
            if not isinstance(table, dict):
                self.wrong(key, "is no table of axes")
                continue
            found |= {name: self.axis(name, entry, key) for name, entry in table.items()}
        return found

    def axis(self, name: str, entry: Any, table: str) -> dict[str, Any]:
        where = f"{table}.{name}"
        if not isinstance(entry, dict):
            self.wrong(where, "is no table of limits, speed, zero and home")
            return {}
        self.unknown(entry, f"{where}.", ("limits", "speed", "acceleration", "zero", "home"))
        limits = self.limits(where, entry)
        home = self.number(entry, "home", f"{where}.home")
        if not limits[0] <= home <= limits[1]:
            self.wrong(f"{where}.home", "is outside the limits")
        return {
            "limits": limits,
            "speed": self.speed(where, entry),
            "acceleration": self.optional(entry, "acceleration", f"{where}.acceleration"),
            "zero": self.number(entry, "zero", f"{where}.zero") if "zero" in entry else 0.0,
            "home": home,
        }

    def limits(self, where: str, entry: dict[str, Any]) -> list[float]:
        limits = entry.get("limits")
        if limits is None and self.left_out(where, "limits"):
            return [-1.0, 1.0]
        if not (
            isinstance(limits, list)
            and len(limits) == 2
            and all(_is_number(v) for v in limits)
            and limits[0] < limits[1]
        ):
            self.wrong(f"{where}.limits", "is not [lowest, highest]")
            return [-1.0, 1.0]
        return limits

    def speed(self, where: str, entry: dict[str, Any]) -> float:
        if "speed" not in entry and self.left_out(where, "speed"):
            return 1.0
        return self.number(entry, "speed", f"{where}.speed", least=1e-9)

    def left_out(self, where: str, field: str) -> bool:
        """True if the URDF is the file that leaves out a field of an axis; a finding reports it."""
        axis = where.split(".")[1]
        missing = None if self.drawn is None else self.drawn.missing.get((axis, field))
        if missing is not None:
            self.findings.append(missing)
        return missing is not None

    def number(
        self, table: dict[str, Any], key: str, where: str, least: float | None = None
    ) -> float:
        value = table.get(key)
        if value is None or not _is_number(value):
            self.wrong(
                where, "is missing" if value is None else f"is no number up to {_LARGEST_NUMBER:g}"
            )
            return 0.0
        if least is not None and value < least:
            self.wrong(where, "is not above 0")
        return float(value)

    def optional(self, table: dict[str, Any], key: str, where: str) -> float | None:
        """A number above 0 that not every robot's source tells."""
        return self.number(table, key, where, least=1e-9) if key in table else None

    def text(self, key: str) -> str:
        value = self.table.get(key)
        if not isinstance(value, str) or not value.strip():
            self.wrong(key, "is missing" if value is None else "is no text")
            return ""
        if not value.isprintable():
            self.wrong(key, "is no text of one line")
        if key == "name" and not ROBOT_NAME.fullmatch(value):
            self.wrong(key, "is not of up to 64 letters A to Z, digits, `.`, `_` and `-`")
        return value

    def texts(self, key: str, *, needed: bool = True) -> tuple[str, ...]:
        value = self.table.get(key, [] if not needed else None)
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            self.wrong(key, "is missing" if value is None else "is no list of texts")
            return ()
        return tuple(value)

    def unknown(self, table: dict[str, Any], prefix: str, known: tuple[str, ...]) -> None:
        for key in table:
            if key not in known:
                self.wrong(prefix + key, f"is not known; there are {', '.join(known)}")

    def wrong(self, field: str, reason: str) -> None:
        self.findings.append(_WRONG_FIELD(path=self.path, place=field, field=field, reason=reason))


FIELDS: Final = (
    "name", "title", "maker", "controller", "languages", "arm", "configuration", "payload_kg",
    "reach_mm", "tcp_speed_mm_s", "repeatability_mm", "coupling", "source", "unconfirmed",
    "lengths_mm", "axes_deg", "axes_mm", "links", "radii_mm", "time_to_speed_s", "time_to_speed_kg",
)  # fmt: skip
ROBOT_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")
"""The name of a robot, as a comment in a program of any language carries it."""
_LARGEST_NUMBER: Final = 1e9
"""mm, degrees, or these a second or second squared: the largest number taken for one of a robot."""
_LINK_FIELDS: Final = ("a", "d", "alpha", "theta")
"""mm and degrees."""
_SLIDING_AXES: Final = {Scara.kind: ("J3",)}
"""Kind of arm → the axes that slide, in `axes_mm`."""


def _is_table(value: Any) -> bool:
    return isinstance(value, dict)


def _is_number(value: Any) -> bool:
    return (
        isinstance(value, int | float)
        and not isinstance(value, bool)
        and abs(value) <= _LARGEST_NUMBER
    )


def names() -> tuple[str, ...]:
    """The robots of the catalogue, in order of the alphabet."""
    return tuple(sorted(f.name[: -len(".toml")] for f in _folder().iterdir() if _is_robot(f)))


def get(name: str) -> Robot:
    """Return the robot of that name, in any case; raises Refused, also a KeyError, without one."""
    known = {n.lower(): n for n in names()}
    given = str(name)[:_LONGEST_NAME]
    if given.lower() not in known:
        other = f"choose one of {', '.join(known.values())}, or name a robot file (TOML or URDF)"
        raise UnknownName(_UNKNOWN_ROBOT(name=given, cure=did_you_mean(given, known, other)))
    return _of_catalogue(known[given.lower()])


@cache
def _of_catalogue(name: str) -> Robot:
    file = _folder() / f"{name}.toml"
    return read(file.read_bytes(), file.name)


def load(path: str | FilePath) -> Robot:
    """A robot from a file of the user's own; raises Unreadable or Refused."""
    return read(read_bytes(path, most=SETTINGS_FILE), str(path))


def _folder() -> Traversable:
    return files(__package__).joinpath("catalogue")


def _is_robot(file: Traversable) -> bool:
    return file.name.endswith(".toml")
