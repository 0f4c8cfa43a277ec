"""The catalogue: one TOML file a robot, in the folder of this module's name."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np

from assistant.program.diagnostics import Refused, Rule, Severity, Unreadable
from assistant.program.text import read_bytes
from assistant.robots.arms.arm import Arm
from assistant.robots.arms.five_axis import FiveAxis
from assistant.robots.arms.lengths import Lengths
from assistant.robots.arms.scara import Scara
from assistant.robots.arms.six_axis import SixAxis
from assistant.robots.robot import Robot

NO_TOML = Rule(
    "RB001",
    Severity.ERROR,
    "the robot file is no TOML: {reason}",
    "compare it with a file of the catalogue",
)
WRONG_FIELD = Rule(
    "RB002",
    Severity.ERROR,
    "`{field}` of the robot file {reason}",
    "compare it with a file of the catalogue",
)

AXES: Final = {
    FiveAxis.kind: FiveAxis.axes,
    SixAxis.kind: SixAxis.axes,
    Scara.kind: Scara.axes,
}
"""Kind of arm → the names of its axes; an arm of five has no axis 4."""
LENGTHS: Final = {
    FiveAxis.kind: ("d1", "a1", "a2", "a3", "d4", "d6"),
    SixAxis.kind: ("d1", "a1", "a2", "a3", "d4", "d6"),
    Scara.kind: ("l1", "l2"),
}
"""Kind of arm → the names of its lengths."""


def names() -> tuple[str, ...]:
    """The robots of the catalogue, in order of the alphabet."""
    return tuple(sorted(f.name[: -len(".toml")] for f in _folder().iterdir() if _is_robot(f)))


def get(name: str) -> Robot:
    """The robot of that name; raises KeyError, with the names there are, if there is none."""
    known = {n.lower(): n for n in names()}
    if name.lower() not in known:
        raise KeyError(f"no robot {name!r}; there are {', '.join(known.values())}")
    return _of_catalogue(known[name.lower()])


@cache
def _of_catalogue(name: str) -> Robot:
    file = _folder() / f"{name}.toml"
    return read(file.read_bytes(), file.name)


def load(path: str | FilePath) -> Robot:
    """A robot from a file of the user's own; raises Unreadable or Refused."""
    return read(read_bytes(path), str(path))


def read(data: bytes, path: str | None = None) -> Robot:
    """A robot from the bytes of a TOML file; raises Unreadable or Refused with findings."""
    try:
        table = tomllib.loads(data.decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise Unreadable(NO_TOML(path=path, reason=str(error))) from None
    reader = _Reader(table, path)
    robot = reader.robot()
    if reader.findings:
        raise Refused(*reader.findings)
    assert robot is not None
    return robot


class _Reader:
    """Takes fields out of a table and collects what is wrong with them."""

    def __init__(self, table: dict[str, Any], path: str | None) -> None:
        self.table, self.path = table, path
        self.findings: list[Any] = []

    def robot(self) -> Robot | None:
        self.unknown(self.table, "", FIELDS)
        texts = {k: self.text(k) for k in ("name", "title", "maker", "controller", "source")}
        numbers = {k: self.number(self.table, k, k, least=1e-9) for k in ("payload_kg", "reach_mm")}
        fastest = self.optional("tcp_speed_mm_s", least=1e-9)
        counts = self.text("configuration")
        if counts not in ("quadrants", "turns"):
            self.wrong("configuration", "is neither `quadrants` nor `turns`")
        axes = self.axes()
        kind = self.kind(tuple(axes))
        arm = self.arm(kind)
        if self.findings or arm is None:
            return None
        rows = [axes[name] for name in arm.axes]
        column = {k: np.array([axis[k] for axis in rows]) for k in ("zero", "speed", "home")}
        limits = np.array([axis["limits"] for axis in rows], dtype=np.float64)
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
            home=column["home"],
            tcp_speed=fastest,
            payload=numbers["payload_kg"],
            reach=numbers["reach_mm"],
            counts="quadrants" if counts == "quadrants" else "turns",
        )

    def kind(self, axes: tuple[str, ...]) -> str:
        """What `arm` says, or what the axes tell."""
        said = self.table.get("arm")
        usual = FiveAxis.kind if set(axes) == set(FiveAxis.axes) else SixAxis.kind
        kind = usual if said is None else said
        if not isinstance(kind, str) or kind not in AXES:
            self.wrong("arm", f"is none of {', '.join(AXES)}")
            return usual
        sliding = self.table.get("axes_mm", {})
        sliding = tuple(sliding) if isinstance(sliding, dict) else ()
        if set(axes) != set(AXES[kind]) or sliding != SLIDING.get(kind, ()):
            turning = [name for name in AXES[kind] if name not in SLIDING.get(kind, ())]
            self.wrong("axes_deg", f"does not hold the axes {' '.join(turning)} of arm `{kind}`")
            if kind in SLIDING:
                self.wrong("axes_mm", f"does not hold the axis {' '.join(SLIDING[kind])}")
        return kind

    def arm(self, kind: str) -> Arm | None:
        lengths = self.table.get("lengths_mm")
        if not isinstance(lengths, dict):
            self.wrong("lengths_mm", "is missing")
            lengths = {}
        self.unknown(lengths, "lengths_mm.", LENGTHS[kind])
        values = {k: self.number(lengths, k, f"lengths_mm.{k}") for k in LENGTHS[kind]}
        for link in ("a2", "d4", "l1", "l2"):
            if not values.get(link, 1.0) > 0:
                self.wrong(f"lengths_mm.{link}", "is not above 0")
        if kind == Scara.kind:
            return Scara(**values)
        if kind == FiveAxis.kind and (values["a1"] or values["a3"]):
            self.wrong("lengths_mm", "has an a1 or a3, which an arm of five axes cannot have")
        return (FiveAxis if kind == FiveAxis.kind else SixAxis)(Lengths(**values))

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
        self.unknown(entry, f"{where}.", ("limits", "speed", "zero", "home"))
        limits = entry.get("limits")
        if not (
            isinstance(limits, list)
            and len(limits) == 2
            and all(_is_number(v) for v in limits)
            and limits[0] < limits[1]
        ):
            self.wrong(f"{where}.limits", "is not [lowest, highest]")
            limits = [-1.0, 1.0]
        home = self.number(entry, "home", f"{where}.home")
        if not limits[0] <= home <= limits[1]:
            self.wrong(f"{where}.home", "is outside the limits")
        return {
            "limits": limits,
            "speed": self.number(entry, "speed", f"{where}.speed", least=1e-9),
            "zero": self.number(entry, "zero", f"{where}.zero") if "zero" in entry else 0.0,
            "home": home,
        }

    def number(
        self, table: dict[str, Any], key: str, where: str, least: float | None = None
    ) -> float:
        value = table.get(key)
        if value is None or not _is_number(value):
            self.wrong(where, "is missing" if value is None else "is no finite number")
            return 0.0
        if least is not None and value < least:
            self.wrong(where, "is not above 0")
        return float(value)

    def optional(self, key: str, least: float) -> float | None:
        return self.number(self.table, key, key, least) if key in self.table else None

    def text(self, key: str) -> str:
        value = self.table.get(key)
        if not isinstance(value, str) or not value.strip():
            self.wrong(key, "is missing" if value is None else "is no text")
            return ""
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
        self.findings.append(WRONG_FIELD(path=self.path, place=field, field=field, reason=reason))


FIELDS: Final = (
    "name", "title", "maker", "controller", "languages", "arm", "configuration", "payload_kg",
    "reach_mm", "tcp_speed_mm_s", "source", "unconfirmed", "lengths_mm", "axes_deg", "axes_mm",
)  # fmt: skip
SLIDING: Final = {Scara.kind: ("J3",)}
"""Kind of arm → the axes that slide, in `axes_mm`."""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value)


def _folder() -> Traversable:
    return files("assistant.robots").joinpath("catalogue")


def _is_robot(file: Traversable) -> bool:
    return file.name.endswith(".toml")
