"""Single moves: joint moves, lines, arcs and circles, with the outputs that they set on the way.

`Mvr2 start,end,reference` runs on the circle of the three points, on the side that does not hold
the reference; `Mvr3 start,end,centre` runs by less than half a turn. A full circle is two arcs.
`Wth` sets an output as the motion begins, `WthIf` where so many mm are left or so much of the path
is done.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from assistant.languages.melfa_basic.lift.computed_positions import unchanged_position
from assistant.languages.melfa_basic.lift.expressions import Expressions
from assistant.languages.melfa_basic.lift.paths import (
    Runs,
    Values,
    are_known,
    move_speed,
    robot_place,
)
from assistant.languages.melfa_basic.lift.settings import (
    BLEND,
    FRAME,
    JOINT,
    TCP,
    TOOL,
    Followed,
    mount_text,
    without_frame_product,
)
from assistant.languages.melfa_basic.lift.simple_statements import lift_assignment
from assistant.languages.melfa_basic.lift.symbols import Symbols, Unliftable
from assistant.languages.melfa_basic.lift.untranslatable_reasons import FULL_CIRCLE, MOVE_TYPE
from assistant.languages.melfa_basic.tables.equivalents import TRIGGER_MEASURES
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.line_tables import target_of
from assistant.languages.melfa_basic.tree.walk import literal, nodes
from assistant.languages.settings_flow import Computed
from assistant.languages.vendor_statements import SETTINGS_DIFFER
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Target, arc_middle_across, arc_middle_around, target_between
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.passes.trigger_positions import is_steady
from assistant.program.statements import Reason

_COMPUTED_ARC: Final = Reason(
    "the arc is told by points that the program sets, or that lie on no arc",
    "teach a point between start and end, and write Mvr",
)
_RADIUS_TOLERANCE: Final = 0.01
"""mm that start and end of `Mvr3` may differ in their distance from the centre (COSIROP help)."""


_LARGEST_CORNER_SHARE: Final = 0.1
"""Share of the radius of a circle that the corner between its two arcs has at the most."""
_LARGEST_CORNER: Final = 1.0
"""mm that this corner has at the most."""


def _taught_points(
    points: tuple[s.Expression, ...], symbols: Symbols
) -> tuple[Target, Target, Target]:
    """Three taught points that no line changes; raises Unliftable for others."""
    found = [unchanged_position(point, symbols) for point in points]
    constants = [constant for constant in found if constant is not None]
    five_axis = symbols.robot is not None and symbols.robot.five_axis
    if len(constants) != 3 or symbols.own or five_axis:
        raise Unliftable(_COMPUTED_ARC)
    first, second, third = (target_of(c, symbols.robot) for c in constants)
    return first, second, third


def _circle_of(
    points: tuple[s.Expression, ...], symbols: Symbols
) -> tuple[e.TargetValue, e.TargetValue, e.TargetValue, Blend]:
    """The circle of `Mvc` as two arcs: a point on the first, its end, a point on the second.

    Its orientation is that of the start. The corner is that between both. Raises Unliftable.
    """
    first, via, last = _taught_points(points, symbols)
    start, other, end = (np.array(t.pose.position) for t in (first, via, last))
    # The circle is halved at its third point; each half needs a point on its way.
    back = arc_middle_across(end, start, other)
    there = None if back is None else arc_middle_across(start, end, back)
    if back is None or there is None:
        raise Unliftable(_COMPUTED_ARC)
    around, half, home = (
        e.TargetValue(target_between(first, first, place)) for place in (there, end, back)
    )
    radius = float(np.linalg.norm(there - back)) / 2.0
    return around, half, home, Blend(min(_LARGEST_CORNER, _LARGEST_CORNER_SHARE * radius))


def _via_of(
    keyword: str, points: tuple[s.Expression, ...], symbols: Symbols
) -> e.TargetValue | None:
    """The point halfway on `Mvr2` or `Mvr3`, None for a straight line; raises Unliftable.

    It has the branch of the start and an orientation between those of start and end.
    """
    first, last, third = _taught_points(points, symbols)
    start, end, other = (np.array(t.pose.position) for t in (first, last, third))
    if keyword == "Mvr2":
        middle = arc_middle_across(start, end, other)
        if middle is None:
            return None
    else:
        middle = arc_middle_around(start, end, other, _RADIUS_TOLERANCE)
        if middle is None:
            raise Unliftable(_COMPUTED_ARC)
    return e.TargetValue(target_between(first, last, middle))


_MEASURES: Final = {name.upper(): place for name, place in TRIGGER_MEASURES.items()}
_TURNED_COMPARISONS: Final = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "=<": ">=", "=>": "<="}


def _lift_triggers(append: s.Append | None, lift: Expressions, runs: Runs) -> tuple[p.Trigger, ...]:
    """Lift the output assignments during a move; raises Unliftable for anything but a number
    assigned to outputs.
    """
    if append is None:
        return ()
    if not isinstance(append.statement, s.Assign):
        raise Unliftable
    measure, amount = _trigger_place(append.condition, lift)
    match lift_assignment(append.statement, lift, runs):
        # A pulse is lifted only where the move begins, the one place at which `Wth` has it.
        case [p.SetSignal(signal, e.Number() as value, (None | e.Number()) as pulse)] if (
            pulse is None or append.condition is None
        ):
            return (p.Trigger(signal, value, amount, measure, pulse),)
    raise Unliftable


def _trigger_place(
    condition: s.Expression | None, lift: Expressions
) -> tuple[p.Measure, e.Expression]:
    match condition:
        case None:
            return "start", e.Number(0)
        # `5 > M_RDst` means the same as `M_RDst < 5`.
        case s.Binary(operator, left, place) if _is_measured_place(
            place
        ) and not _is_measured_place(left):
            return _trigger_place(
                s.Binary(_TURNED_COMPARISONS.get(operator, ""), place, left), lift
            )
        case s.Binary(operator, s.Variable(arguments=None, component="") as place, bound):
            measure, reached = _MEASURES.get(place.key, (None, ""))
            amount = lift.of(bound)
            if measure is not None and operator[:1] == reached[:1] and _is_steady(bound, amount):
                return measure, amount
    raise Unliftable


def _is_steady(bound: s.Expression, amount: e.Expression) -> bool:
    """True if a bound does not change while the robot moves: it has no input, timer or state."""
    read = (x.key for x in nodes(bound) if isinstance(x, s.Variable))
    # Status variables that are read may change while the robot moves.
    return is_steady(amount) and not any(key.startswith("M_") for key in read)


def _is_measured_place(x: s.Expression) -> bool:
    return isinstance(x, s.Variable) and x.key in _MEASURES


_USUAL_TYPES: Final = {
    word: (s.Number(int(word == "Mov")), s.Number(0))
    for word in ("Mov", "Mvs", "Mvr", "Mvr2", "Mvr3")
}
"""The `Type` that a move has without one (COSIROP help, types of interpolation)."""


class Moves:
    """Lifts single moves; raises Unliftable."""

    def __init__(self, expressions: Expressions, runs: Runs) -> None:
        self.expressions, self.runs = expressions, runs

    def move(self, node: s.Motion, values: Values) -> list[p.Statement]:
        until = self.until(node.append)
        on_way = () if until else _lift_triggers(node.append, self.expressions, self.runs)
        made = self.plain(replace(node, append=None), values)
        if until is None and not on_way:
            return made
        match made:
            case [p.Move() | p.MoveCircular() | p.MoveJoints() as move]:
                self.runs.previous = None if until else self.runs.previous
                return [replace(move, triggers=on_way, until=until)]
        raise Unliftable  # it goes to the start of an arc before

    def until(self, append: s.Append | None) -> e.Expression | None:
        """Lift the condition that aborts a move, from `WthIf …, Skip`."""
        match append:
            case s.Append(s.Command(word), condition) if word.upper() == "SKIP" and condition:
                return self.expressions.condition(condition)
        return None

    def plain(self, node: s.Motion, values: Values) -> list[p.Statement]:
        """A move without what is appended to it."""
        node, values = without_frame_product(node, values, self.expressions.m.header)
        if node.type and node.type != _USUAL_TYPES.get(node.keyword):
            raise Unliftable(MOVE_TYPE)
        if not are_known(values, node.keyword == "Mov"):
            raise Unliftable(SETTINGS_DIFFER)
        match node.keyword, node.arguments:
            case ("Mov" | "Mvs") as word, (target,) if target is not None:
                return [self.to(word, target, None, values)]
            case ("Mov" | "Mvs") as word, (target, distance) if target and distance:
                return [self.to(word, target, distance, values)]
            case "Mvs", (None, distance) if distance is not None:
                return [self.along(distance, values)]
            case "Mvr", (start, via, end, *rest) if start and via and end and not any(rest):
                return self.arc(start, self.expressions.plain(via), end, values)
            case ("Mvr2" | "Mvr3") as word, (start, end, third) if start and end and third:
                middle = _via_of(word, (start, end, third), self.expressions.m)
                return self.arc(start, middle, end, values)
            case "Mvc", (start, via, last) if start and via and last:
                return self.circle((start, via, last), values)
        raise Unliftable

    def to(
        self, word: str, target: s.Expression, distance: s.Expression | None, values: Values
    ) -> p.Statement:
        self.runs.arc_pending = False
        joint = word == "Mov"
        kind = self.expressions.type_of(target)
        # A move whose target is not a plain variable leaves no known start for an arc.
        self.runs.previous = None
        if kind == "joints":
            if not joint or distance is not None:
                raise Unliftable
            return p.MoveJoints(self.expressions.plain(target), self.motion(True, values))
        if kind != "position":
            raise Unliftable
        goal = self.expressions.plain(target)
        if distance is not None:
            goal = _along_tool(goal, self.expressions.plain(distance))
            if (number := literal(distance)) is not None:
                moved = s.Constant((0.0, 0.0, float(number), 0.0, 0.0, 0.0))
                self.runs.previous = robot_place(s.Binary("*", target, moved), values)
        else:
            self.runs.previous = robot_place(target, values)
        return p.Move("joint" if joint else "linear", goal, self.motion(joint, values))

    def along(self, distance: s.Expression, values: Values) -> p.Statement:
        """From where the robot stands along the tool."""
        self.runs.arc_pending, self.runs.previous = False, None
        goal = _along_tool(self.expressions.here("P_CURR"), self.expressions.plain(distance))
        return p.Move("linear", goal, self.motion(False, values))

    def motion(self, joint: bool, values: Values) -> p.Motion:
        speed, blend = values[JOINT] if joint else values[TCP], values[BLEND]
        pace: Speed | p.ComputedSpeed
        if isinstance(speed, Computed | Followed):
            value = self._worked_out(speed)
            pace = p.ComputedSpeed(None, joint=value) if joint else p.ComputedSpeed(value)
        else:
            pace = move_speed(values, joint)
        if isinstance(blend, Computed):
            blend = p.ComputedBlend(self._worked_out(blend))
        elif isinstance(blend, Followed):
            corner = self._worked_out(blend)
            # Below 0 no corner is meant: the move stops.
            blend = p.ComputedBlend(corner, e.Binary("<", corner, e.Number(0)))
        return p.Motion(pace, blend, mount_text(values[TOOL]), mount_text(values[FRAME]))

    def _worked_out(self, setting: Computed | Followed) -> e.Expression:
        if isinstance(setting, Followed):
            return e.Name(setting.name)
        return self.expressions.plain(setting.value)

    def arc(
        self, start: s.Expression, via: e.Expression | None, end: s.Expression, values: Values
    ) -> list[p.Statement]:
        """Lift an arc; the robot moves to its start first if it is elsewhere.

        via: None for a straight line.
        """
        # Before anything is lifted, as that changes where the robot is.
        here = self.runs.is_here(start, values)
        goal, motion = self.expressions.plain(end), self.motion(False, values)
        made: p.Statement = p.Move("linear", goal, motion)
        if via is not None:
            made = p.MoveCircular(via, goal, motion)
        before = [] if here else [self.to("Mvs", start, None, values)]
        self.runs.arc_pending, self.runs.previous = False, robot_place(end, values)
        return [*before, made]

    def circle(
        self, points: tuple[s.Expression, s.Expression, s.Expression], values: Values
    ) -> list[p.Statement]:
        """A whole circle: two arcs, between which the robot does not stop."""
        if not self.expressions.m.telling:
            raise Unliftable(FULL_CIRCLE)
        start, motion = points[0], self.motion(False, values)
        around, half, home, corner = _circle_of(points, self.expressions.m)
        here = self.runs.is_here(start, values)
        before = [] if here else [self.to("Mvs", start, None, values)]
        self.runs.arc_pending, self.runs.previous = False, robot_place(start, values)
        # Between the halves of a circle the robot must not stop.
        passing = motion if motion.blend != FINE else replace(motion, blend=corner)
        return [
            *before,
            p.MoveCircular(around, half, passing),
            p.MoveCircular(home, self.expressions.plain(start), motion),
        ]


def _along_tool(goal: e.Expression, distance: e.Expression) -> e.Expression:
    return e.Apply("relative", (goal, e.Number(0), e.Number(0), distance))
