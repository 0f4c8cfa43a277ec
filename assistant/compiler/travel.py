"""`travel to` as moves: each path is planned through the cell, from where the arm is then.

A statement that is reached from several positions of the arm is planned for each, at most
`_MOST_PLANS` times, and refused if the paths differ.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Diagnostic, Refused, Rule, error, has_errors, info
from assistant.base.rotations import to_matrix
from assistant.compiler.source_map import Places, at_moves
from assistant.program.analysis.uses import base_variable
from assistant.program.expressions import Expression, Name
from assistant.program.geometry import IDENTITY, Pose, Tool
from assistant.program.program import Program, walk
from assistant.program.rewriting import Body, map_bodies
from assistant.program.statements import Assign, Comment, Move, MoveJoints, Statement, Travel
from assistant.robots.program_values import Names

if TYPE_CHECKING:
    from assistant.cell.planning.planner import Planned
    from assistant.cell.scene import PlacedRobot, Scene
    from assistant.robots import Robot
    from assistant.robots.timing.program_walk import Arrival


_TRAVEL_WITHOUT_CELL = error(
    "CK470",
    "a way to `{target}` is planned through a cell, and none is told",
    "name the file of the cell: --cell cell.toml",
)
_START_UNKNOWN = error(
    "CK471",
    "where the arm is when it begins to travel to `{target}` is not known: {why}",
    "{cure}",
)
_TRAVEL_FROM_SEVERAL = error(
    "CK472",
    "the way to `{target}` is not the same each time: it {what}",
    "move to one place before it, or write a `travel to` for each of them",
)
_GOAL_UNKNOWN = error(
    "CK473",
    "only running the program tells where `{target}` is, so no way there can be planned",
    "travel to a target whose place the text tells",
)
_TRAVEL_NOT_REACHED = error(
    "CK474",
    "no way through the program leads to `travel to {target}`, so nothing tells where it begins",
    "take it out, or call its procedure from where the program begins",
)
_TRAVEL_EXTERNAL_AXES = error(
    "CK475",
    "`{target}` moves external axes, for which no way is planned",
    "move them before, and travel to a target that says nothing of them",
)
_FROM_HOME = info(
    "CK476",
    "the way to `{target}` is planned from where the robot is at home, as nothing moves before it",
    "begin the program with a move to a known place, from which the way leads",
)
_TRAVEL_UNDECLARED = error(
    "CK495",
    "no {what} `{name}` is declared, so no way to `{target}` can be planned",
    "declare it",
)
_TRAVEL_NO_NUMBER = error(
    "CK496",
    "the `{word}` of the way to `{target}` is `{value}`, which is no number above 0 that the text "
    "tells",
    "write a number above 0",
)


_SEARCH_SECONDS: Final = 30.0
"""That a search for a way takes at most."""
_MOST_PLANS: Final = 3
"""Ways that are planned for one statement, when what comes before it changes."""


@dataclass(frozen=True, slots=True)
class PlannedTravels:
    """A program whose travels are moves, or findings that tell why it is not."""

    program: Program
    findings: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class _PlannedPath:
    """A way that was planned, and for which arrival."""

    arrival: Arrival
    planned: Planned

    def fits(self, other: Arrival) -> bool:
        mine = self.arrival
        return (mine.places, mine.carried, mine.goal) == (other.places, other.carried, other.goal)


def has_travels(program: Program) -> bool:
    """True if the program has travels, which need planning."""
    return any(isinstance(statement, Travel) for statement in program.statements())


def with_planned_travels(
    program: Program, robot: Robot | None, scene: Scene | None, places: Places
) -> PlannedTravels:
    """Return the program with planned joint moves, after a comment, in place of each `travel to`.

    robot: that runs it. scene: its cell, None without one. places: of its statements. The same
    program in the same cell gives the same moves. A travel in a loop, or in a procedure that is
    called twice, has one planned motion, so it must begin and end at the same positions each time,
    with the same bodies held. Findings with an error mean that some travels are not planned.
    """
    if not has_travels(program):
        return PlannedTravels(program)
    if scene is None or robot is None:
        statements = [s for s in program.statements() if isinstance(s, Travel)]
        return PlannedTravels(
            program, tuple(_travel_finding(_TRAVEL_WITHOUT_CELL, s) for s in statements)
        )
    planning = _TravelPlanner(replace(program, robot=robot.name), robot, scene, places)
    try:
        ways = planning.ways()
    except Refused as refused:
        return PlannedTravels(program, refused.findings)
    done = _with_moves(program, lambda number, one: planning.moves(ways[number], one, said=True))
    return PlannedTravels(done, tuple(planning.findings(ways)))


@dataclass(frozen=True, slots=True)
class _TravelGoal:
    """Goal of a motion to plan. tip: in the flange. tilt: degrees. seconds: of the search."""

    arrival: Arrival
    tip: Pose
    tilt: float | None
    seconds: float

    def same(self, other: _TravelGoal) -> bool:
        """True if one planned motion serves both."""
        return replace(self, arrival=other.arrival) == other and (
            replace(self.arrival, number=0, first=False)
            == replace(other.arrival, number=0, first=False)
        )


class _TravelPlanner:
    """planned_ways: of which travels that are alike take the same."""

    def __init__(self, program: Program, robot: Robot, scene: Scene, places: Places) -> None:
        self.program, self.robot, self.scene, self.places = program, robot, scene, places
        self.statements = [s for s in program.statements() if isinstance(s, Travel)]
        self.names = Names(program)
        self.planned_ways: list[tuple[_TravelGoal, Planned]] = []

    def ways(self) -> dict[int, _PlannedPath]:
        """Return a planned motion for each travel, by its number. Raises Refused.

        Planned travels are in the program; the others are moves whose end determines the later
        configurations. Planning repeats until every travel begins where its motion does.
        """
        ways: dict[int, _PlannedPath] = {}
        plans = Counter[int]()
        while True:
            found = self.arrivals(ways)
            self.led(found)
            new = set[int]()
            for arrival in found:
                number = arrival.number
                if number in ways:
                    continue
                ways[number] = way = self.planned(arrival)
                plans[number] += 1
                new.add(number)
                if tuple(way.planned.rows[-1].tolist()) != arrival.joints:
                    break  # what comes behind it begins elsewhere
            if new:
                continue
            # All are planned: each must still begin where its motion was planned from.
            for number, statement in enumerate(self.statements):
                theirs = [arrival for arrival in found if arrival.number == number]
                if not theirs:
                    raise Refused(_travel_finding(_TRAVEL_NOT_REACHED, statement))
                self.same(statement, theirs)
                if not ways[number].fits(theirs[0]):
                    if plans[number] == _MOST_PLANS:
                        what = "begins elsewhere each time that it is planned"
                        raise Refused(_travel_finding(_TRAVEL_FROM_SEVERAL, statement, what=what))
                    del ways[number]
                    break
            else:
                return ways

    def arrivals(self, ways: Mapping[int, _PlannedPath]) -> tuple[Arrival, ...]:
        """With each travel, the moves that stand for it. Raises Refused for what is not reached."""
        from assistant import robots
        from assistant.cell.clearances import CarriedBodies
        from assistant.robots.timing.program_walk import arrivals

        def standing(number: int, one: Travel) -> Body:
            if number in ways:
                return one, *self.moves(ways[number], one)
            return one, self.straight(one)

        solution = robots.solve_program(_with_moves(self.program, standing), self.robot)
        if has_errors(solution.findings):
            raise Refused(*at_moves(solution.findings, solution.program, self.places))
        holding = CarriedBodies.at_first(self.scene, self.placed())
        return arrivals(solution, holding if holding.places else None)

    def placed(self) -> PlacedRobot:
        from assistant.cell.clearances import robot_of
        from assistant.checks.clearances import no_robot

        try:
            return robot_of(self.scene, self.robot)
        except LookupError:
            raise Refused(no_robot(self.robot, self.scene)) from None

    def straight(self, one: Travel) -> Statement:
        """The joint move that goes where a travel leads, through whatever is there."""
        if self.names.joints(one.target) is not None:
            return MoveJoints(one.target, one.motion, span=one.span)
        return Move("joint", one.target, one.motion, span=one.span)

    def open(self, number: int) -> bool:
        """True if the arm may reach a travel's target in a different configuration."""
        at = 0
        for procedure in self.program.procedures:
            at += sum(isinstance(one, Travel) for one in walk(procedure.body))
            if number < at:
                names = Names(self.program)
                names.enter(procedure)
                place = names.place(self.statements[number].target)
                return place is not None and place.target.configuration is None
        return False

    def led(self, arrivals: tuple[Arrival, ...]) -> None:
        """Raises Refused for a travel that leads to several places."""
        first: dict[int, Arrival] = {}
        for arrival in arrivals:
            if first.setdefault(arrival.number, arrival).goal != arrival.goal:
                what = "leads to several places"
                raise Refused(
                    _travel_finding(
                        _TRAVEL_FROM_SEVERAL, self.statements[arrival.number], what=what
                    )
                )

    def same(self, statement: Travel, arrivals: list[Arrival]) -> None:
        """Raises Refused unless a travel is the same each time, from a place that is known."""
        for arrival in arrivals:
            self.known(statement, arrival)
        for what, values in (
            ("begins at {count} places", [a.places for a in arrivals]),
            ("goes with other bodies held", [a.carried for a in arrivals]),
        ):
            count = len(set(values))
            if count > 1:
                raise Refused(
                    _travel_finding(_TRAVEL_FROM_SEVERAL, statement, what=what.format(count=count))
                )

    def known(self, statement: Travel, arrival: Arrival) -> None:
        target, motion = statement.target, statement.motion
        for what, name, there in (
            ("tool", motion.tool, self.names.tool(motion.tool)),
            ("frame", motion.frame, self.names.frame(motion.frame)),
        ):
            if there is None:
                raise Refused(_travel_finding(_TRAVEL_UNDECLARED, statement, what=what, name=name))
        if arrival.goal is None and isinstance(target, Name) and self.nowhere(target.name):
            raise Refused(
                _travel_finding(_TRAVEL_UNDECLARED, statement, what="target", name=target.name)
            )
        changed = {
            base_variable(s.target) for s in self.program.statements() if isinstance(s, Assign)
        }
        if arrival.goal is None or {motion.tool.lower(), motion.frame.lower()} & changed:
            raise Refused(_travel_finding(_GOAL_UNKNOWN, statement))
        if arrival.external:
            raise Refused(_travel_finding(_TRAVEL_EXTERNAL_AXES, statement))
        if arrival.doubt is not None:
            doubt = arrival.doubt
            raise Refused(
                _travel_finding(_START_UNKNOWN, statement, why=doubt.why, cure=doubt.cure)
            )
        if len(arrival.places) > 1:
            what = f"begins at {len(arrival.places)} places"
            raise Refused(_travel_finding(_TRAVEL_FROM_SEVERAL, statement, what=what))
        if not arrival.places:
            why = "only running the program tells what moves before it"
            cure = "move to a place that the text tells, right before it"
            raise Refused(_travel_finding(_START_UNKNOWN, statement, why=why, cure=cure))

    def nowhere(self, name: str) -> bool:
        """True if no data of that name are declared in the program."""
        program = self.program
        tables: list[Mapping[str, object]] = [
            program.targets,
            program.joint_targets,
            program.variables,
        ]
        for procedure in program.procedures:
            tables.append(procedure.variables)
            tables.append({parameter.name: parameter for parameter in procedure.parameters})
        return name.lower() not in {one.lower() for table in tables for one in table}

    def planned(self, arrival: Arrival) -> _PlannedPath:
        """Raises Refused if the start is not known, or if there is no way."""
        statement = self.statements[arrival.number]
        self.known(statement, arrival)
        if arrival.joints is None or arrival.goal is None:
            raise Refused(_travel_finding(_GOAL_UNKNOWN, statement))
        tool = self.names.tool(statement.motion.tool) or Tool()
        tip = tool.tip if tool.held else IDENTITY
        seconds = self.value(statement, "search", statement.search)
        tilt = self.value(statement, "tilt", statement.tilt)
        asked = _TravelGoal(arrival, tip, tilt, _SEARCH_SECONDS if seconds is None else seconds)
        same = next((way for known, way in self.planned_ways if known.same(asked)), None)
        if same is not None:
            return _PlannedPath(arrival, same)
        try:
            way = self.way(asked, free=self.open(arrival.number))
        except Refused as refused:
            raise Refused(*(_located_finding(statement, one) for one in refused.findings)) from None
        self.planned_ways.append((asked, way))
        return _PlannedPath(arrival, way)

    def way(self, asked: _TravelGoal, *, free: bool) -> Planned:
        """To the joints that suit what comes behind; free: else in any way to hold the arm there,
        with the half of the time.
        """
        from assistant.cell.clearances import CarriedBodies
        from assistant.cell.planning.planner import plan
        from assistant.cell.planning.space import Cone

        carried = asked.arrival.carried
        scene = carried.scene_now() if isinstance(carried, CarriedBodies) else self.scene
        (start,), goal = asked.arrival.places, np.array(asked.arrival.joints)
        p, q = self.robot.flange_poses(goal)
        pose = Pose.of(p[0], q[0]) @ asked.tip
        x, y, z = to_matrix(np.array([pose.quaternion]))[0, :, 2].tolist()
        found = partial(
            plan,
            scene,
            start,
            robot=self.placed().name,
            tool=asked.tip,
            cone=None if asked.tilt is None else Cone((x, y, z), asked.tilt),
            seconds=asked.seconds / 2.0 if free else asked.seconds,
        )
        try:
            return found(goal)
        except Refused:
            if not free:
                raise
        return found(pose)

    def value(self, statement: Travel, word: str, said: Expression | None) -> float | None:
        """Return the number that a travel states after a word."""
        if said is None:
            return None
        number = self.names.number(said)
        if number is None or not number > 0.0:
            raise Refused(
                _travel_finding(_TRAVEL_NO_NUMBER, statement, word=word, value=_goal_text(said))
            )
        return number

    def moves(self, way: _PlannedPath, one: Travel, *, said: bool = False) -> Body:
        """The moves of a way, the last with the blend of the travel; said: behind a comment."""
        made = way.planned.statements(tool=one.motion.tool)
        moves: list[Statement] = []
        for number, move in enumerate(made, start=1):
            blend = one.motion.blend if number == len(made) else move.motion.blend
            motion = replace(move.motion, speed=one.motion.speed, blend=blend)
            moves.append(replace(move, motion=motion, span=one.span))
        if said:
            place = None if one.span is None else self.places.of(one.span)
            line = "" if place is None else f", line {place.line}"
            many = "a planned move" if len(made) == 1 else f"{len(made)} planned moves"
            target = _goal_text(one.target)
            moves.insert(0, Comment(f"travel to {target}{line}: {many}"))
        return tuple(moves)

    def findings(self, ways: Mapping[int, _PlannedPath]) -> Iterator[Diagnostic]:
        for number, statement in enumerate(self.statements):
            way = ways[number]
            if way.arrival.first:
                yield _travel_finding(_FROM_HOME, statement)
            for finding in way.planned.findings:
                yield _located_finding(statement, finding)


def _travel_finding(rule: Rule, statement: Travel, **values: Any) -> Diagnostic:
    return rule(target=_goal_text(statement.target), span=statement.span, **values)


def _located_finding(statement: Travel, finding: Diagnostic) -> Diagnostic:
    """A finding about a way at its line; where no text has it, with what the way leads to."""
    if statement.span is not None:
        return replace(finding, span=statement.span)
    return replace(finding, about=f"travel to {_goal_text(statement.target)}")


def _with_moves(program: Program, made: Callable[[int, Travel], Body]) -> Program:
    """Return the program with each travel replaced; travels are counted in order of text.

    A travel that is part of its replacement becomes a new object, as program walks identify
    statements by object.
    """
    count = iter(range(program.size() + 1))

    def body(statements: Body) -> Body:
        return tuple(
            part
            for node in statements
            for part in (
                made(next(count), replace(node))
                if isinstance(node, Travel)
                else (map_bodies(node, body),)
            )
        )

    procedures = tuple(replace(one, body=body(one.body)) for one in program.procedures)
    return replace(program, procedures=procedures)


def _goal_text(expression: Expression) -> str:
    from assistant.program.pseudo.expressions import expression_text  # it loads the grammar

    return expression_text(expression)
