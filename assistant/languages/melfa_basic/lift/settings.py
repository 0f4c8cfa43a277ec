"""Settings of moves: speed, joint percentage, corner, tool and base that hold at each line.

MELFA-BASIC sets them in lines: `Spd` holds until the next one. `setting_lines` states what each
line does to settings and which of them it depends on; from that come the values at each line,
along every path. Where no value is certain at a move, each `Spd` that may lead there sets a
variable as well for other languages, and the move takes its speed from that. `Mvs PTABLE*P1` is a
move to P1 in a frame.

Speeds in mm/s, percentages of joint speed, corners in mm.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

from assistant.base.arrays import Ints
from assistant.base.data_classes import dataclass
from assistant.languages.melfa_basic.lift.expressions import Expressions
from assistant.languages.melfa_basic.lift.procedures import (
    Answers,
    Code,
    Region,
    Structure,
    interrupts_of,
    odd_entries,
    target_name,
)
from assistant.languages.melfa_basic.lift.symbols import (
    Constants,
    Symbols,
    Unliftable,
    changed_variables,
)
from assistant.languages.melfa_basic.tables import poses
from assistant.languages.melfa_basic.tables.variables import (
    ARC_START,
    OPTIMUM_SPEED,
    PARAMETERS,
    parameter_position,
)
from assistant.languages.melfa_basic.tables.vocabulary import commands, function, status
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MOV, MoveRows
from assistant.languages.melfa_basic.tree.control_flow import (
    exits_of,
    graph_of,
    is_block_word,
    labels_of,
    statement_of,
)
from assistant.languages.melfa_basic.tree.line_tables import Positions
from assistant.languages.melfa_basic.tree.walk import literal, nodes, program_stem, statements_in
from assistant.languages.settings_flow import (
    UNKNOWN,
    Calls,
    Changes,
    Computed,
    Either,
    Held,
    LineEffects,
    Sets,
    SettingText,
    State,
    Steps,
    calls_in,
    with_interrupts,
)
from assistant.languages.settings_forms import CalledForms
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Frame, Tool
from assistant.program.motion import FINE, Blend
from assistant.program.program import Variable, identifier

T = TypeVar("T", Tool, Frame)

TCP, JOINT, BLEND, TOOL, FRAME = range(5)
"""Settings by number: mm/s, percent, corner, and names."""


INITIAL_SETTINGS: Final[State] = tuple(Held(v) for v in (math.inf, 100.0, FINE, FLANGE, BASE))
"""Settings at the start of a program (COSIROP help; tool and base as the controller has them)."""
ALL_SETTINGS: Final = frozenset(range(len(INITIAL_SETTINGS)))
"""Numbers of all settings, for a program of unknown content."""


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
                plain = _PARAMETER_OF_BASE.fullmatch(short) is not None
                seen = _plain_frame if plain else self._frame
                self.frames.setdefault(name, seen(constant.values))

    def effect(self, node: s.Statement | None) -> tuple[int, Any] | None:
        """Which setting a statement makes, and the value: UNKNOWN if the program works it out."""
        number = setting_number(node)
        if number is None:
            return None
        if isinstance(node, s.Command):
            return number, SETTING_COMMANDS[node.keyword][1](self, node.arguments)
        # Mechanism 1 is the arm itself; the tool of any other mechanism is not followed.
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
                # A compiled text is read back with the number that it states, even above the
                # optimum speed.
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
        """Return a value that the program calculates from its variables alone; UNKNOWN if it has
        any other part.
        """
        found = [part for part in nodes(node) if isinstance(part, s.Variable)]
        names = {part.key for part in found if part.arguments is None or not function(part.key)}
        if not self.computes or not names.isdisjoint(self.functions):
            return UNKNOWN
        # Inputs and external variables may change without a line of this program.
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
        # `Base` holds the inverse of a frame, but a product names the frame itself.
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
                name = self.positions.spelling(key)
                return _mount_name(name, made(constant.values), known)
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
                    seen: Any = _plain_frame if kind == "frame" else made
                    return _mount_name(parameter, seen(constant.values), known)
        return UNKNOWN


_PARAMETER_OF_BASE: Final = re.compile(parameter_position(PARAMETERS["Base"].format(number=r"\d+")))
"""Pattern of the names that numbered work coordinates have among positions."""


def _plain_frame(values: tuple[float | None, ...]) -> Frame:
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
    """True if the controller or another program may change a variable."""
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


_NO_NAMES: Final = frozenset[str]()
_WAIT_LABELS: Final = re.compile(r"W\d+Z?", re.IGNORECASE)
"""Labels that are read together with the lines around them."""


@dataclass(frozen=True)
class SettingFlow:
    """The code independent of how its settings are lifted: the same in each reading of a file.

    single: see `positions_used_once`. breaks: True if the code asks whether `Break` has left a
    block.
    """

    constants: Constants
    structure: Structure
    regions: list[Region]
    settings: Settings
    called: CalledForms
    single: Mapping[str, Ints]
    timers: dict[int, str]
    breaks: bool


def setting_lines(
    code: Code,
    structure: Structure,
    regions: Sequence[Region],
    settings: Settings,
    touched: Mapping[str, frozenset[int]],
    elsewhere: frozenset[int],
    answers: Answers,
) -> LineEffects:
    """touched: the settings that each program sets, by its name in upper case. elsewhere: those
    that interrupts of the programs that call this one may set while it runs. answers: what those of
    this one call.
    """
    blocks, labels = structure.blocks, labels_of(code)
    by_label = {region.label: k for k, region in enumerate(regions) if region.label}
    by_name = {r.function.name.upper(): k for k, r in enumerate(regions) if r.function}

    def called(statement: s.Statement | None) -> Iterator[int | frozenset[int]]:
        match statement:
            case s.CallP(program=s.String(value=name)):
                yield touched.get(identifier(program_stem(name)).upper(), ALL_SETTINGS)
            case s.CallP():
                yield ALL_SETTINGS
            case s.Jump() | s.OnJump():
                for target in exits_of(statement).calls:
                    yield by_label.get(target_name(target), ALL_SETTINGS)
        if by_name:
            node = statement.condition if isinstance(statement, s.If) else statement
            for part in nodes(node):
                if isinstance(part, s.Variable) and part.key in by_name:
                    # Assigned in its own body, a function's name is its result, not a call.
                    if part is not getattr(statement, "target", None):
                        yield by_name[part.key]

    watched = _setting_variables(code, settings)

    def steps(statement: s.Statement | s.Target | None, own: frozenset[str] = _NO_NAMES) -> Steps:
        """own: variables of its function alone, which nothing that it calls can change."""
        if statement is None or isinstance(statement, s.Target):
            return ()
        made = does(statement)
        if not watched or (len(made) == 1 and isinstance(made[0], Sets)):
            return made
        # A called procedure may change any variable, before or after it makes settings. By-value
        # parameters that the call does not name stay as they are.
        if any(True for _ in calls_in(made)):
            named = frozenset(x.key for x in nodes(statement) if isinstance(x, s.Variable))
            any_other = Changes(None, own - named)
            return (any_other, *made, any_other)
        names = watched.intersection(changed_variables(statement, settings.constants.kept))
        return (*made, Changes(frozenset(names))) if names else made

    def does(statement: s.Statement) -> Steps:
        effect = settings.effect(statement)
        if effect is not None:
            return (Sets(*effect),)
        calls = tuple(called(statement))
        inside = isinstance(statement, s.Jump | s.OnJump)
        # A number without a target leads to none of the calls.
        if isinstance(statement, s.OnJump):
            return (Either((*((Calls((one,), inside),) for one in calls), ())),)
        before: Steps = (Calls(calls, inside),) if calls else ()
        if isinstance(statement, s.If) and statement.then is not None:
            return (*before, Either((steps(statement.then), steps(statement.otherwise))))
        if isinstance(statement, s.Motion) and statement.append is not None:
            return (*before, Either((steps(statement.append.statement), ())))
        return before

    places = [region.places() for region in regions]
    calls = {
        k: {one for at in inside for one in called(statement_of(code[at]))}
        for k, inside in enumerate(places if watched else ())
    }

    def own(number: int) -> frozenset[str]:
        """Parameters of a function by value, while it does not run twice at once."""
        function, names = regions[number].function, _NO_NAMES
        if watched and function is not None and number not in _reached_calls(number, calls):
            given = function.parameters or ()
            names = watched & {f"{q.name}{q.suffix}".upper() for q in given if q.mode == "ByVal"}
        return names

    loose = {
        at for at, item in enumerate(code)
        if is_block_word(statement_of(item)) and at not in blocks.words
    }  # fmt: skip
    # A call leads to the first line of a procedure, which is not the line of its label.
    first = {label: places[number][0] for label, number in by_label.items() if places[number]}
    entries = labels | first
    for label, (call, _) in answers.items():
        number = by_name.get(call.function.key) if isinstance(call, s.Call) else None
        if isinstance(call, s.Jump):
            number = by_label.get(target_name(call.target))
        if number is not None and places[number]:
            entries[label] = places[number][0]
    lines = LineEffects(
        len(ALL_SETTINGS),
        places,
        [graph_of(code, inside, blocks).after for inside in places],
        {
            at: made
            for inside, kept in zip(places, map(own, range(len(places))), strict=True)
            for at in inside
            if (made := steps(statement_of(code[at]), kept))
        },
        lambda at: _used_settings(code[at]),
        lambda at: exits_of(statement_of(code[at])).on,
        frozenset(labels.values()),
        frozenset(at for at, depth in enumerate(structure.depth) if depth)
        | {at for label, at in labels.items() if _WAIT_LABELS.fullmatch(label)},
        frozenset(loose | {entries[to] for to in odd_entries(code, regions) if to in entries}),
    )
    answering = {region.label: k for k, region in enumerate(regions) if region.answers}
    found = interrupts_of(code, entries, {label: k for label, k in answering.items() if label})
    return with_interrupts(lines, found, elsewhere)


def _reached_calls(number: int, calls: Mapping[int, set[int | frozenset[int]]]) -> set[int]:
    """Return the procedures that a procedure calls, directly or not; all of them if a call is
    unknown.
    """
    pending, found = [*calls[number]], set[int]()
    while pending:
        one = pending.pop()
        if not isinstance(one, int):
            return set(calls)
        if one not in found:
            found.add(one)
            pending += calls[one]
    return found


def _setting_variables(code: Code, settings: Settings) -> frozenset[str]:
    """Variables that values of settings are worked out of, in upper case."""
    effects = (settings.effect(one) for item in code for one in statements_in(statement_of(item)))
    values = [effect[1] for effect in effects if effect is not None]
    return frozenset().union(*(one.names for one in values if isinstance(one, Computed)))


_READ_SETTINGS: Final = {
    **dict.fromkeys(("P_CURR", "P_FBC", "P_CURRR", "PTOJ", "JTOP"), frozenset({TOOL, FRAME})),
    **dict.fromkeys(("P_TOOL", "M_TOOL"), frozenset({TOOL})),
    **dict.fromkeys(("P_BASE", "M_BSNO"), frozenset({FRAME})),
    "M_SPD": frozenset({TCP}),
    "M_JOVRD": frozenset({JOINT}),
    "M_RSPD": ALL_SETTINGS,
}
"""Settings that status variables and functions tell, or depend on."""
_SPARED_SETTINGS: Final[dict[str, frozenset[int]]] = {"Mov": frozenset({TCP}), "Mva": frozenset()}
"""Settings that a move does not depend on; others are at no percentage of joint speed."""


def _used_settings(item: s.Entry) -> frozenset[int]:
    """Settings that a line depends on: a joint move on no speed of the tool, others on no other."""
    match item:
        case MoveRows(kinds=kinds):
            joint = kinds == MOV
            return ALL_SETTINGS - ({TCP} if joint.all() else {JOINT} if not joint.any() else set())
        case s.Line(statement=statement) if statement is not None:
            return needed_settings(statement)
    return frozenset()


def needed_settings(statement: s.Statement) -> frozenset[int]:
    """The settings that what a statement does depends on."""
    found: frozenset[int] = frozenset()
    for part in nodes(statement):
        match part:
            case s.Motion(keyword=keyword):
                found |= ALL_SETTINGS - _SPARED_SETTINGS.get(keyword, frozenset({JOINT}))
            case s.Variable(key=key) if key in _READ_SETTINGS:
                found |= _READ_SETTINGS[key]
            case s.Command(keyword=keyword) if keyword in commands("needs"):
                found |= ALL_SETTINGS
    return found


_NO_CORNER: Final = -1.0
"""No corner: the move ends at its target."""
_OPEN_CORNER: Final = 10.0
"""mm of a corner whose size the controller chooses (`Cnt 1`)."""
_FOLLOWED_NAMES: Final = {
    TCP: "current_speed",
    JOINT: "current_percent",
    BLEND: "current_corner",
    TOOL: "current_tool",
    FRAME: "current_base",
}
_FIRST_VALUES: Final = {TCP: OPTIMUM_SPEED, JOINT: 100.0, BLEND: _NO_CORNER}
"""Settings at the start of a program."""


@dataclass(frozen=True, slots=True)
class Followed:
    """A setting that a variable, or a tool or frame of that name, holds."""

    name: str


def with_followed_settings(values: tuple[Any, ...], names: Mapping[int, str]) -> tuple[Any, ...]:
    """The settings of a move with the names of those that are followed for the unknown ones."""
    return tuple(
        Followed(names[k]) if value is UNKNOWN and k in names else value
        for k, value in enumerate(values)
    )


def mount_text(value: Any) -> Any:
    """The name of a tool or frame."""
    return value.name if isinstance(value, Followed) else value


def declare_followed(
    slots: Collection[int],
    known: dict[int, str],
    symbols: Symbols,
    settings: Settings,
    written: Collection[str],
) -> None:
    """Declares what holds some settings.

    known: takes their names, the same in all files of a program. written: names of the file, in
    upper case, which none of them gets.
    """
    for slot in sorted(slots):
        if slot not in known:
            wanted, number = _FOLLOWED_NAMES[slot], 2
            while wanted.upper() in written:
                wanted, number = f"{_FOLLOWED_NAMES[slot]}_{number}", number + 1
            known[slot] = symbols.free(wanted)
        name = known[slot]
        symbols.taken.add(name.lower())
        if slot == TOOL:
            settings.tools.setdefault(name, Tool())
        elif slot == FRAME:
            settings.frames.setdefault(name, Frame())
        else:
            symbols.variables.setdefault(name, Variable("number", e.number_of(_FIRST_VALUES[slot])))


def followed_assignment(
    node: s.Statement, value: Any, names: Mapping[int, str], lift: Expressions
) -> p.Assign | None:
    """Return the value that a setting statement gives its variable, None if that is not followed.

    value: what is known of it. Raises Unliftable where it has no other words.
    """
    slot = setting_number(node)
    if slot is None or slot not in names:
        return None
    arguments: tuple[Any, ...] = (node.value,) if isinstance(node, s.Assign) else ()
    arguments = node.arguments if isinstance(node, s.Command) else arguments
    target = e.Name(names[slot])
    if slot in (TOOL, FRAME):
        return p.Assign(target, _followed_mount(slot, arguments, value, lift))
    if slot == BLEND:
        return p.Assign(target, _followed_corner(arguments, value, lift))
    return p.Assign(target, _followed_number(arguments, value, lift))


def _followed_number(arguments: tuple[Any, ...], value: Any, lift: Expressions) -> e.Expression:
    if isinstance(value, float):
        return e.number_of(OPTIMUM_SPEED if math.isinf(value) else value)
    if len(arguments) != 1 or arguments[0] is None:
        raise Unliftable
    return lift.number(arguments[0])


def _followed_corner(arguments: tuple[Any, ...], value: Any, lift: Expressions) -> e.Expression:
    if value == FINE:
        return e.number_of(_NO_CORNER)
    if isinstance(value, Blend) and value.radius is not None:
        # One number has to do for both sides of the corner: the smaller one cuts off no more than
        # either.
        radius = min(value.radius, math.inf if value.exit is None else value.exit)
        return e.number_of(_OPEN_CORNER if math.isinf(radius) else radius)
    match arguments:
        case (s.Number(1), near) if near is not None:
            return lift.number(near)
        case (s.Number(1), near, far) if near is not None and near == far:
            return lift.number(near)
    raise Unliftable


def _followed_mount(
    slot: int, arguments: tuple[Any, ...], value: Any, lift: Expressions
) -> e.Expression:
    if value in (FLANGE, BASE):
        return e.PoseValue(IDENTITY)
    if isinstance(value, str):
        return e.Name(value)
    (argument,) = arguments
    if argument is None or lift.type_of(argument) != "position":
        raise Unliftable
    place = lift.plain(argument)
    return place if slot == TOOL else e.inverse(place)


def without_frame_product(
    node: s.Motion, values: tuple[Any, ...], header: Header
) -> tuple[s.Motion, tuple[Any, ...]]:
    """The move with plain targets, and its settings with their frame, where a heading says so."""
    if not header.products:
        return node, values
    frames = set()
    plain: list[s.Expression | None] = []
    # A second argument of other moves is a distance along the tool, not a target.
    targets = 3 if node.keyword == "Mvr" else 1
    for at, argument in enumerate(node.arguments):
        key, target = _frame_and_target(argument, header)
        if at < targets and not _is_arc_start(argument):
            frames.add(key)
        plain.append(target if at < targets else argument)
    if len(frames) != 1 or (frame := frames.pop()) is None:
        return node, values
    name = header.names["frame"][frame]
    made = (*values[:FRAME], name, *values[FRAME + 1 :])
    return replace(node, arguments=tuple(plain)), made


def _frame_and_target(
    argument: s.Expression | None, header: Header
) -> tuple[str | None, s.Expression | None]:
    match argument:
        case s.Binary("*", s.Variable(arguments=None, component="") as frame, target) if (
            frame.key in header.names["frame"]
        ):
            return frame.key, target
    return None, argument


def _is_arc_start(argument: s.Expression | None) -> bool:
    """True for the start position of an arc, as read from the robot."""
    return isinstance(argument, s.Variable) and argument.key == ARC_START
