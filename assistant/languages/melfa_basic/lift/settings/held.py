"""What holds for the moves that follow: speed, percentage, corner, tool and base."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from assistant.languages.melfa_basic.lift.values.constants import Constants
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import Positions
from assistant.program.geometry import BASE, FLANGE, Pose
from assistant.program.motion import FINE, Blend

TCP, JOINT, BLEND, TOOL, FRAME = range(5)


class Unknown:
    """A setting that is not known, or that differs with the way that leads here."""

    def __repr__(self) -> str:
        return "UNKNOWN"


UNKNOWN: Final = Unknown()


@dataclass(frozen=True, slots=True)
class Held:
    """The value of a setting at a place, and the lines that may have given it."""

    value: Any
    by: frozenset[int] = frozenset()


State = tuple[Held, ...]
"""By TCP (mm/s), JOINT (percent), BLEND, TOOL and FRAME (names)."""

INITIAL: Final[State] = tuple(Held(v) for v in (math.inf, 100.0, FINE, FLANGE, BASE))
"""What holds when a program starts (COSIROP help; tool and base as the controller has them)."""
ALL_SETTINGS: Final = frozenset(range(len(INITIAL)))
"""Of a program that nothing is known of."""


class Settings:
    """Reads the setting that a statement makes.

    own: it was written here. names: tools and frames by short name, of a heading. tools, frames:
    position variables (upper case) that `Tool` and `Base` name; tool_values, frame_values: those
    given as constants.
    """

    def __init__(
        self,
        positions: Positions,
        constants: Constants,
        names: dict[str, dict[str, str]],
        *,
        own: bool,
    ) -> None:
        self.own = own
        self.positions, self.constants, self.names = positions, constants, names
        self.tools: set[str] = set()
        self.frames: set[str] = set()
        self.tool_values: dict[str, Pose] = {}
        self.frame_values: dict[str, Pose] = {}

    def effect(self, node: s.Statement | None) -> tuple[int, Any] | None:
        """Which setting a statement makes, and the value: UNKNOWN if the program works it out."""
        match node:
            case s.Command(keyword=keyword, arguments=arguments) if keyword in SETTINGS:
                slot, read = SETTINGS[keyword]
                return slot, read(self, arguments)
            case s.Assign(target=target) if target.key == "M_TOOL":
                return TOOL, UNKNOWN
        return None

    def _number(self, node: Any) -> float | None:
        value = self.constants.value(node)
        return value if isinstance(value, float) else None

    def speed(self, arguments: tuple[Any, ...]) -> Any:
        match arguments:
            case (s.Variable(key="M_NSPD"),):
                return math.inf
            case (value,):
                number = self._number(value)
                return UNKNOWN if number is None or number <= 0 else number
        return UNKNOWN

    def joint(self, arguments: tuple[Any, ...]) -> Any:
        number = self._number(arguments[0]) if len(arguments) == 1 else None
        return UNKNOWN if number is None or number <= 0 else number

    def blend(self, arguments: tuple[Any, ...]) -> Any:
        numbers = [self._number(a) for a in arguments]
        match numbers:
            case [0.0, *_]:
                return FINE
            case [1.0, 0.0, *_] | [1.0, float(), 0.0] if not self.own:
                return FINE  # no distance on one side of the point: no corner is cut
            case [1.0]:
                return Blend(math.inf)
            case [1.0, float(radius)]:
                return Blend(radius)
            case [1.0, float(radius), float(leave)]:
                return Blend(radius, None if leave == radius else leave)
        return UNKNOWN

    def tool(self, arguments: tuple[Any, ...]) -> Any:
        return self._placed(arguments, "tool", "P_NTOOL", FLANGE, self.tools, self.tool_values)

    def frame(self, arguments: tuple[Any, ...]) -> Any:
        return self._placed(arguments, "frame", "P_NBASE", BASE, self.frames, self.frame_values)

    def _placed(
        self,
        arguments: tuple[Any, ...],
        kind: str,
        initial: str,
        default: str,
        used: set[str],
        values: dict[str, Pose],
    ) -> Any:
        """The name of a tool or frame that `Tool` or `Base` names."""
        match arguments:
            case (s.Variable(arguments=None, component="") as variable,):
                if variable.key == initial:
                    return default
                if variable.key in self.constants.assigned or not self._known(variable.name):
                    return UNKNOWN
                used.add(variable.key)
                return self.names[kind].get(variable.key, variable.key)
            case (s.Constant(values=numbers),):
                pose = poses.plain_pose(numbers)
                pose = pose if kind == "tool" else pose.inverse()
                known = next((n for n, v in values.items() if v == pose), None)
                name = known or f"{kind}_{len(values) + 1}"
                values[name] = pose
                return name
            case (s.Number(value=0),):
                return default
        return UNKNOWN

    def _known(self, name: str) -> bool:
        return self.positions.constant(name) is not None


SETTINGS: Final[dict[str, tuple[int, Callable[[Settings, tuple[Any, ...]], Any]]]] = {
    "Spd": (TCP, Settings.speed),
    "JOvrd": (JOINT, Settings.joint),
    "Cnt": (BLEND, Settings.blend),
    "Tool": (TOOL, Settings.tool),
    "Base": (FRAME, Settings.frame),
}
