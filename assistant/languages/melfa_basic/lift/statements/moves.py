"""Moves that are part of no path."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from assistant.languages.melfa_basic.lift.settings.followed import Followed, mount_text
from assistant.languages.melfa_basic.lift.settings.framed_targets import without_frame_product
from assistant.languages.melfa_basic.lift.settings.held import BLEND, FRAME, JOINT, TCP, TOOL
from assistant.languages.melfa_basic.lift.statements.arcs import circle_of, via_of
from assistant.languages.melfa_basic.lift.statements.paths import (
    Runs,
    Values,
    are_known,
    move_speed,
    robot_place,
)
from assistant.languages.melfa_basic.lift.statements.triggers import lift_triggers
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.reasons import FULL_CIRCLE, MOVE_TYPE
from assistant.languages.melfa_basic.lift.values.symbols import Unliftable
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.settings.flow import Computed
from assistant.languages.vendor_statements import SETTINGS_DIFFER
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.motion import FINE, Speed

USUAL_TYPES: Final = {
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
        on_way = () if until else lift_triggers(node.append, self.expressions, self.runs)
        made = self.plain(replace(node, append=None), values)
        if until is None and not on_way:
            return made
        match made:
            case [p.Move() | p.MoveCircular() | p.MoveJoints() as move]:
                self.runs.previous = None if until else self.runs.previous
                return [replace(move, triggers=on_way, until=until)]
        raise Unliftable  # it goes to the start of an arc before

    def until(self, append: s.Append | None) -> e.Expression | None:
        """What breaks a move off, by `WthIf …, Skip`."""
        match append:
            case s.Append(s.Command(word), condition) if word.upper() == "SKIP" and condition:
                return self.expressions.condition(condition)
        return None

    def plain(self, node: s.Motion, values: Values) -> list[p.Statement]:
        """A move without what is appended to it."""
        node, values = without_frame_product(node, values, self.expressions.m.header)
        if node.type and node.type != USUAL_TYPES.get(node.keyword):
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
                middle = via_of(word, (start, end, third), self.expressions.m)
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
            blend = p.ComputedBlend(corner, e.Binary("<", corner, e.Number(0)))
        return p.Motion(pace, blend, mount_text(values[TOOL]), mount_text(values[FRAME]))

    def _worked_out(self, setting: Computed | Followed) -> e.Expression:
        if isinstance(setting, Followed):
            return e.Name(setting.name)
        return self.expressions.plain(setting.value)

    def arc(
        self, start: s.Expression, via: e.Expression | None, end: s.Expression, values: Values
    ) -> list[p.Statement]:
        """An arc; the robot goes to its start first if it does not stand there.

        via: None for a straight line.
        """
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
        around, half, home, corner = circle_of(points, self.expressions.m)
        here = self.runs.is_here(start, values)
        before = [] if here else [self.to("Mvs", start, None, values)]
        self.runs.arc_pending, self.runs.previous = False, robot_place(start, values)
        passing = motion if motion.blend != FINE else replace(motion, blend=corner)
        return [
            *before,
            p.MoveCircular(around, half, passing),
            p.MoveCircular(home, self.expressions.plain(start), motion),
        ]


def _along_tool(goal: e.Expression, distance: e.Expression) -> e.Expression:
    return e.Apply("relative", (goal, e.Number(0), e.Number(0), distance))
