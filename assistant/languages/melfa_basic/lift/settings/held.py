"""What holds for the moves that follow: speed, percentage, corner, tool and base."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping
from typing import Any, Final, TypeVar

from assistant.languages.melfa_basic.lift.values.constants import Constants
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import PARAMETERS, parameter_position
from assistant.languages.melfa_basic.tables.vocabulary import function, status
from assistant.languages.melfa_basic.tables.words import OPTIMUM_SPEED
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import Positions
from assistant.languages.melfa_basic.tree.walk import literal, nodes
from assistant.languages.settings.flow import UNKNOWN, Computed, Held, SettingText, State
from assistant.program.geometry import BASE, FLANGE, Frame, Tool
from assistant.program.motion import FINE, Blend

T = TypeVar("T", Tool, Frame)

TCP, JOINT, BLEND, TOOL, FRAME = range(5)
"""Settings by number: mm/s, percent, corner, and names."""


INITIAL_SETTINGS: Final[State] = tuple(Held(v) for v in (math.inf, 100.0, FINE, FLANGE, BASE))
"""What holds when a program starts (COSIROP help; tool and base as the controller has them)."""
ALL_SETTINGS: Final = frozenset(range(len(INITIAL_SETTINGS)))
"""Of a program that nothing is known of."""


class Settings:
    """Reads the setting that a statement makes.

    own: it was written here. names: those of tools and frames by short name, of a heading.
    tools, frames: of the whole program, with those that `Tool` and `Base` name. placed: position
    variables (upper case) that are such. functions: of the file, in upper case. computes: a value
    may be worked out, as nothing changes variables but the lines that lead to a move.
    """

    def __init__(
        self,
        positions: Positions,
        constants: Constants,
        header: Header,
        tools: Mapping[str, Tool],
        frames: Mapping[str, Frame],
        *,
        own: bool,
        functions: Collection[str] = (),
        computes: bool = True,
    ) -> None:
        self.own, self.functions, self.computes = own, frozenset(functions), computes
        self.positions, self.constants, self.names = positions, constants, header.names
        self.products = header.products
        self.tools, self.frames = dict(tools), dict(frames)
        self.placed: set[str] = set()
        for short, name in self.names["tool"].items():
            if (constant := positions.constant(short)) is not None:
                self.tools.setdefault(name, self._tool(constant.values))
        for short, name in self.names["frame"].items():
            if (constant := positions.constant(short)) is not None:
                plain = PARAMETER_OF_BASE.fullmatch(short) is not None
                seen = plain_frame if plain else self._frame
                self.frames.setdefault(name, seen(constant.values))

    def effect(self, node: s.Statement | None) -> tuple[int, Any] | None:
        """Which setting a statement makes, and the value: UNKNOWN if the program works it out."""
        number = setting_number(node)
        if number is None:
            return None
        if isinstance(node, s.Command):
            return number, SETTING_COMMANDS[node.keyword][1](self, node.arguments)
        if isinstance(node, s.Assign) and node.target.arguments in (None, (s.Number(1),)):
            return number, self.tool((node.value,)) if node.delay is None else UNKNOWN
        return number, UNKNOWN

    def _number(self, node: Any) -> float | None:
        value = self.constants.value(node)
        return value if isinstance(value, float) else None

    def speed(self, arguments: tuple[Any, ...]) -> Any:
        match arguments:
            case (s.Variable(key="M_NSPD"),):
                return math.inf
            case (value,):
                speed = self._above_zero(value)
                fixed = isinstance(speed, int | float) and not self.own
                return min(speed, OPTIMUM_SPEED) if fixed else speed
        return UNKNOWN

    def joint(self, arguments: tuple[Any, ...]) -> Any:
        return self._above_zero(arguments[0]) if len(arguments) == 1 else UNKNOWN

    def _above_zero(self, node: Any) -> Any:
        written = literal(node)
        if written is None and self.own:  # what is fixed is written as a number here
            return self._computed(node)
        number = self._number(node)
        if number is None:
            return self._computed(node)
        return UNKNOWN if number <= 0 else number

    def _computed(self, node: Any) -> Any:
        """What the program works out of its own variables, UNKNOWN if anything else is in it."""
        found = [part for part in nodes(node) if isinstance(part, s.Variable)]
        names = {part.key for part in found if part.arguments is None or not function(part.key)}
        if not self.computes or not names.isdisjoint(self.functions):
            return UNKNOWN
        if not self.own and any(map(_is_set_elsewhere, names)):
            return UNKNOWN
        return Computed(node, frozenset(names))

    def blend(self, arguments: tuple[Any, ...]) -> Any:
        if self.own and len(arguments) == 3 and literal(arguments[1]) is None:
            return self._computed(arguments[1]) if arguments[1] == arguments[2] else UNKNOWN
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
        return self._placed(arguments, "tool", "P_NTOOL", FLANGE, self.tools, self._tool)

    def frame(self, arguments: tuple[Any, ...]) -> Any:
        return self._placed(arguments, "frame", "P_NBASE", BASE, self.frames, self._frame)

    def _tool(self, values: tuple[float | None, ...]) -> Tool:
        return Tool(poses.plain_pose(values))

    def _frame(self, values: tuple[float | None, ...]) -> Frame:
        pose = poses.plain_pose(values)
        return Frame(pose if self.products else pose.inverse())

    def _placed(
        self,
        arguments: tuple[Any, ...],
        kind: str,
        initial: str,
        default: str,
        known: dict[str, T],
        made: Callable[[tuple[float | None, ...]], T],
    ) -> Any:
        """The name of a tool or frame that `Tool` or `Base` names."""
        match arguments:
            case (s.Variable(arguments=None, component="") as variable,):
                key = variable.key
                if key == initial:
                    return default
                constant = self.positions.constant(key)
                changed = kind == "tool" or not self.products
                if constant is not None and key in self.names[kind] and self.own and changed:
                    return self.names[kind][key]  # whatever the program gives it
                if not self.own and (given := self.constants.placed.get(key)) is not None:
                    return _mount_name(f"{variable.name}_{kind}", made(given.values), known)
                if key in self.constants.assigned or constant is None:
                    return UNKNOWN
                if key in self.names[kind]:
                    return self.names[kind][key]
                self.placed.add(key)
                return _mount_name(key, made(constant.values), known)
            case (s.Constant(values=values),):
                return _mount_name(f"{kind}_1", made(values), known)
            case (s.Number(value=0),):
                return default
            case (s.Number(value=number),):
                parameter = PARAMETERS["Base" if kind == "frame" else "Tool"].format(
                    number=round(number)
                )
                key = parameter_position(parameter).upper()
                if (constant := self.positions.constant(key)) is not None:
                    if key in self.names[kind]:
                        return self.names[kind][key]
                    # as the cell states it: work coordinates are seen from the robot
                    seen: Any = plain_frame if kind == "frame" else made
                    return _mount_name(parameter, seen(constant.values), known)
        return UNKNOWN


PARAMETER_OF_BASE: Final = re.compile(parameter_position(PARAMETERS["Base"].format(number=r"\d+")))
"""What work coordinates of a number are called among positions."""


def plain_frame(values: tuple[float | None, ...]) -> Frame:
    """Work coordinates of a parameter."""
    return Frame(poses.plain_pose(values))


def _mount_name(wanted: str, value: T, known: dict[str, T]) -> str:
    """The name of a tool or frame, another one where a program before has it for another value."""
    stem, name, count = wanted.removesuffix("_1"), wanted, 1
    while True:
        there = next((other for other in known if other.lower() == name.lower()), None)
        if there is None or known[there] == value:
            known[there or name] = value
            return there or name
        name, count = f"{stem}_{count + 1}", count + 1


SETTING_COMMANDS: Final[dict[str, tuple[int, Callable[[Settings, tuple[Any, ...]], Any]]]] = {
    "Spd": (TCP, Settings.speed),
    "JOvrd": (JOINT, Settings.joint),
    "Cnt": (BLEND, Settings.blend),
    "Tool": (TOOL, Settings.tool),
    "Base": (FRAME, Settings.frame),
}


def setting_number(node: s.Statement | None) -> int | None:
    """The number of the setting that a statement makes, None if it makes none."""
    match node:
        case s.Command(keyword=keyword) if keyword in SETTING_COMMANDS:
            return SETTING_COMMANDS[keyword][0]
        case s.Assign(target=target) if target.key == "M_TOOL":
            return TOOL
    return None


def _is_set_elsewhere(key: str) -> bool:
    """Whether others may change a variable: the controller, or other programs."""
    return key[1:2] == "_" or status(key) is not None


def _value_text(text: Callable[[Any], str]) -> Callable[[Any], str]:
    return lambda value: "what is worked out" if isinstance(value, Computed) else text(value)


def _speed_text(value: float) -> str:
    return f"{value:g} mm/s" if value < math.inf else "the robot's own"


def _blend_text(value: Blend) -> str:
    if value.radius is None:
        return "none"
    return f"{value.radius:g} mm" if value.radius < math.inf else "the controller's own"


SETTING_WORDS: Final = (
    SettingText("speed", "Spd", _value_text(_speed_text)),
    SettingText("speed of joint moves", "JOvrd", _value_text(lambda value: f"{value:g} %")),
    SettingText("corner", "Cnt", _value_text(_blend_text)),
    SettingText("tool", "Tool", lambda value: f"`{value}`"),
    SettingText("frame", "Base", lambda value: f"`{value}`"),
)
"""By number."""
