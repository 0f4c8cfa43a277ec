"""The code of one file as procedures and statements of the pseudo-program."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any, Final

from assistant.languages.melfa_basic import poses, printer
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.columnar import MoveRows
from assistant.languages.melfa_basic.lift import blocks
from assistant.languages.melfa_basic.lift.expressions import SIGNALS, Meanings, Unliftable
from assistant.languages.melfa_basic.lift.paths import Runs
from assistant.languages.melfa_basic.lift.positions import joints_of, target_of
from assistant.languages.melfa_basic.names import ARC_START
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, Pose
from assistant.program.motion import FINE, Blend, Speed
from assistant.program.program import identifier

Entry = s.Line | MoveRows

DEEPEST: Final = 50
"""Blocks inside one another that are read as such; controllers stop at 16."""


class Reader:
    """Reads the code of one file.

    tools, frames: position variables (upper case) that `Tool` and `Base` name; tool_values,
    frame_values: those given as constants. state: what holds where the reading is.
    """

    def __init__(
        self,
        code: list[Entry],
        meanings: Meanings,
        own: bool,
        main: bool,
        calls: tuple[dict[str, str], dict[str, str]],
    ) -> None:
        self.code, self.meanings, self.own, self.main = code, meanings, own, main
        self.units, self.firsts = calls
        self.structure = blocks.structure(code)
        self.tools: set[str] = set()
        self.frames: set[str] = set()
        self.tool_values: dict[str, Pose] = {}
        self.frame_values: dict[str, Pose] = {}
        self.tcp: float | e.Name = math.inf
        self.joint = 100.0
        self.blend = FINE
        self.tool, self.frame = FLANGE, BASE
        self.arc_pending = False
        self.runs = Runs(self)
        self.labels: set[str] = set()
        self.first = True
        self.depth = 0
        self.at_call: dict[str | None, tuple[Any, ...]] = {}

    def in_path(self, key: str) -> bool:
        return self.runs.holds(key)

    # ---------------------------------------------------------------------- procedures

    def procedures(self) -> Iterator[tuple[str | None, tuple[p.Statement, ...]]]:
        """Label (upper case, None for the first) and body of each procedure."""
        starts = blocks.procedure_starts(
            self.code, self.structure, self.meanings.header.names["procedure"], self.own
        )
        self.called = {label for _, label in starts}
        edges = [(0, None), *starts]
        for i, (start, label) in enumerate(edges):
            stop = edges[i + 1][0] if i + 1 < len(edges) else len(self.code)
            self.first = label is None
            if label in self.at_call:  # what held where it was first called from
                held = self.at_call[label]
                self.tcp, self.joint, self.blend, self.tool, self.frame = held
            low = start if label is None else start + 1
            self.labels = blocks.labels_in(self.code, low, stop)
            word = "End" if label is None else "Return"
            high = stop
            while high > low and blocks.is_blank(self.code[high - 1]):
                high -= 1
            if high > low and blocks.is_command(self.code[high - 1], word):
                high -= 1
            yield label, tuple(self.statements(low, high))
            if label is not None and i == 0:
                break

    def statements(self, low: int, high: int) -> list[p.Statement]:
        """The statements of a range of the code."""
        made: list[p.Statement] = []
        at = low
        while at < high:
            at = self.entry(at, high, made)
        self.runs.flush(made)
        return made

    def entry(self, at: int, high: int, made: list[p.Statement]) -> int:
        """Reads one entry, or a whole block; gives the place after it."""
        item = self.code[at]
        self.runs.at = item.span
        if isinstance(item, MoveRows):
            self.runs.rows(item, made)
            return at + 1
        if item.comment is not None and not (item.statement is None and item.label is None):
            self.runs.flush(made)
            made.append(p.Comment(_comment(item.comment), span=item.span))
        if item.label is not None:
            waited = self.waited(at, high, made)
            if waited:
                return waited
            self.runs.flush(made)
            made.append(p.Label(self.label_name(item.label), span=item.span))
        if item.statement is None:
            if item.comment is not None and item.label is None:
                self.runs.flush(made)
                made.append(p.Comment(_comment(item.comment), span=item.span))
            return at + 1
        if self.setting(item.statement):
            return at + 1
        if isinstance(item.statement, s.Motion) and self.runs.motion(item.statement, made):
            return at + 1
        self.runs.flush(made)
        after = self.block(at, high, made)
        if after:
            return after
        try:
            lifted = STATEMENTS[type(item.statement)](self, item.statement)
        except (Unliftable, KeyError):
            lifted = [self.opaque(item.statement)]
        made += [_with_span(statement, item.span) for statement in lifted]
        return at + 1

    def opaque(self, statement: s.Statement) -> p.Opaque:
        self.arc_pending = False
        upper = self.meanings.dialect.endswith("-4")
        return p.Opaque(self.meanings.dialect, printer.statement(statement, upper))

    def label_name(self, label: str) -> str:
        given = self.meanings.header.names["label"].get(label.upper())
        return given or identifier(label)

    # ------------------------------------------------------------------------ settings

    def setting(self, node: s.Statement) -> bool:
        """Takes in a modal setting of the moves that follow; False for anything else."""
        if isinstance(node, s.Assign) and node.target.key == ARC_START:
            here = isinstance(node.value, s.Variable) and node.value.key == "P_CURR"
            self.arc_pending = here
            return here
        if not isinstance(node, s.Command) or node.keyword not in SETTINGS:
            return False
        before = self.now()
        if not SETTINGS[node.keyword](self, node.arguments):
            return False
        if self.now() != before:
            self.runs.changed = True
        return True

    def now(self) -> tuple[Any, ...]:
        return self.tcp, self.joint, self.blend, self.tool, self.frame

    def set_speed(self, arguments: tuple[Any, ...]) -> bool:
        match arguments:
            case (s.Number(value=value),):
                self.tcp = float(value)
            case (s.Variable() as variable,) if variable.key == "M_NSPD":
                self.tcp = math.inf
            case (s.Variable(arguments=None, component="") as variable,) if (
                variable.key[1:2] != "_"
            ):
                try:
                    name = self.meanings.plain(variable)
                except Unliftable:
                    return False
                self.tcp = name if isinstance(name, e.Name) else math.inf
            case _:
                return False
        return True

    def set_joint(self, arguments: tuple[Any, ...]) -> bool:
        if len(arguments) != 1 or not isinstance(arguments[0], s.Number):
            return False
        self.joint = float(arguments[0].value)
        return True

    def set_blend(self, arguments: tuple[Any, ...]) -> bool:
        if not all(isinstance(a, s.Number) for a in arguments):
            return False
        match [float(a.value) for a in arguments]:
            case [0.0]:
                self.blend = FINE
            case [1.0]:
                self.blend = Blend(math.inf)
            case [1.0, radius]:
                self.blend = Blend(radius)
            case [1.0, radius, leave]:
                self.blend = Blend(radius, None if leave == radius else leave)
            case _:
                return False
        return True

    def set_tool(self, arguments: tuple[Any, ...]) -> bool:
        name = self.placed(arguments, "tool", "P_NTOOL", FLANGE, self.tools, self.tool_values)
        self.tool = name or self.tool
        return name is not None

    def set_frame(self, arguments: tuple[Any, ...]) -> bool:
        name = self.placed(arguments, "frame", "P_NBASE", BASE, self.frames, self.frame_values)
        self.frame = name or self.frame
        return name is not None

    def placed(
        self,
        arguments: tuple[Any, ...],
        kind: str,
        initial: str,
        default: str,
        used: set[str],
        values: dict[str, Pose],
    ) -> str | None:
        """The name of a tool or frame that `Tool` or `Base` names."""
        match arguments:
            case (s.Variable(arguments=None, component="") as variable,):
                if variable.key == initial:
                    return default
                if self.meanings.positions.constant(variable.name) is None:
                    return None
                used.add(variable.key)
                return self.meanings.header.names[kind].get(variable.key, variable.key)
            case (s.Constant(values=numbers),):
                pose = poses.plain_pose(numbers)
                pose = pose if kind == "tool" else pose.inverse()
                known = next((n for n, v in values.items() if v == pose), None)
                name = known or f"{kind}_{len(values) + 1}"
                values[name] = pose
                return name
            case (s.Number(value=0),):
                return default
        return None

    # --------------------------------------------------------------------------- moves

    def speed(self, joint_move: bool) -> Speed | e.Name:
        if isinstance(self.tcp, e.Name):
            return self.tcp
        return Speed(self.tcp, joint=self.joint if joint_move else None)

    def motion(self, joint_move: bool) -> p.Motion:
        return p.Motion(self.speed(joint_move), self.blend, self.tool, self.frame)

    def move(self, node: s.Motion) -> list[p.Statement]:
        """A move that is part of no path."""
        if node.type or node.append:
            raise Unliftable
        match node.keyword, node.arguments:
            case ("Mov" | "Mvs") as word, (target,) if target is not None:
                return [self.to(word, target, None)]
            case ("Mov" | "Mvs") as word, (target, distance) if target and distance:
                return [self.to(word, target, distance)]
            case "Mvr", (start, via, end) if start and via and end:
                return self.arc(start, via, end)
        raise Unliftable

    def to(self, word: str, target: s.Expression, distance: s.Expression | None) -> p.Statement:
        self.arc_pending = False
        joint_move = word == "Mov"
        if isinstance(target, s.Variable) and target.key[0] == "J" and not target.component:
            if not joint_move or distance is not None:
                raise Unliftable
            self.runs.previous = None
            return p.MoveJoints(self.meanings.plain(target), self.motion(True))
        goal = self.meanings.plain(target)
        if distance is not None:
            depth = self.meanings.plain(distance)
            goal = e.Apply("relative", (goal, e.Number(0), e.Number(0), depth))
        plain = isinstance(target, s.Variable) and distance is None
        self.runs.previous = target.key if plain and isinstance(target, s.Variable) else None
        return p.Move("joint" if joint_move else "linear", goal, self.motion(joint_move))

    def arc(self, start: s.Expression, via: s.Expression, end: s.Expression) -> list[p.Statement]:
        key = start.key if isinstance(start, s.Variable) else None
        here = (key == ARC_START and self.arc_pending) or (
            key is not None and key == self.runs.previous
        )
        before = [] if here else [self.to("Mvs", start, None)]
        made = p.MoveCircular(
            self.meanings.plain(via), self.meanings.plain(end), self.motion(False)
        )
        self.arc_pending = False
        self.runs.previous = end.key if isinstance(end, s.Variable) else None
        return [*before, made]

    # ------------------------------------------------------------------------- control

    def body(self, low: int, high: int) -> tuple[p.Statement, ...]:
        self.runs.forget()
        self.depth += 1
        made = tuple(self.statements(low, high))
        self.depth -= 1
        self.runs.forget()
        return made

    def block(self, at: int, high: int, made: list[p.Statement]) -> int:
        """A whole block that begins here; gives the place after it, 0 if there is none."""
        found = self.structure.get(at)
        if found is None or found[-1] >= high or self.depth > DEEPEST:
            return 0
        item = self.code[at]
        if not isinstance(item, s.Line):
            return 0
        try:
            statement = self.whole(item.statement, found)
        except Unliftable:
            return 0
        if statement is None:
            return 0
        made.append(_with_span(statement, item.span))
        return found[-1] + 1

    def whole(self, node: s.Statement | None, places: list[int]) -> p.Statement | None:
        """A block from the places of its keywords."""
        match node:
            case s.If(then=s.Target()):
                return self.jumping_if(places)
            case s.If():
                return self.if_block(places)
            case s.Command(keyword="While", arguments=(condition,)) if condition is not None:
                test = self.meanings.of(condition)
                return p.While(test, self.body(places[0] + 1, places[-1]))
            case s.For(variable=variable, first=first, last=last, step=step):
                name = self.meanings.plain(variable)
                if not isinstance(name, e.Name):
                    raise Unliftable
                counted = p.ONE if step is None else self.meanings.of(step)
                limits = self.meanings.of(first), self.meanings.of(last)
                inside = self.body(places[0] + 1, places[-1])
                return p.For(name.name, *limits, inside, counted)
            case s.Select(subject=subject):
                return self.select(subject, places)
        return None

    def if_block(self, places: list[int]) -> p.If:
        branches: list[p.Branch] = []
        otherwise: tuple[p.Statement, ...] = ()
        for place, following in itertools.pairwise(places):
            node = self.statement_at(place)
            if isinstance(node, s.If | s.ElseIf):
                condition = self.meanings.of(node.condition)
                branches.append(p.Branch(condition, self.body(place + 1, following)))
            else:
                otherwise = self.body(place + 1, following)
        return p.If(tuple(branches), otherwise)

    def jumping_if(self, places: list[int]) -> p.If:
        """`If` and jumps to made labels: condition, then, jump and next label by turns, end."""
        branches = []
        for i in range(0, len(places) - 1, 3):
            test, jump, _ = places[i : i + 3]
            node = self.statement_at(test)
            if not isinstance(node, s.If):
                raise Unliftable
            condition = self.meanings.of(node.condition)
            branches.append(p.Branch(condition, self.body(test + 2, jump)))
        otherwise = self.body(places[-2] + 1, places[-1])
        return p.If(tuple(branches), otherwise)

    def statement_at(self, place: int) -> s.Statement | None:
        item = self.code[place]
        return item.statement if isinstance(item, s.Line) else None

    def select(self, subject: s.Expression, places: list[int]) -> p.Switch | p.If:
        value = self.meanings.of(subject)
        cases: list[tuple[s.Case, tuple[p.Statement, ...]]] = []
        otherwise: tuple[p.Statement, ...] = ()
        for place, following in itertools.pairwise(places):
            node = self.statement_at(place)
            end = following
            while end > place + 1 and blocks.is_command(self.code[end - 1], "Break"):
                end -= 1
            inside = self.body(place + 1, end)
            if isinstance(node, s.Case):
                cases.append((node, inside))
            else:
                otherwise = inside
        tests = [self.tests(value, case) for case, _ in cases]
        if all(isinstance(t, tuple) for t in tests):
            listed = [(t, b) for t, (_, b) in zip(tests, cases, strict=True)]
            made = tuple(p.Case(t, b) for t, b in listed if isinstance(t, tuple))
            return p.Switch(value, made, otherwise)
        branches = []
        for case, inside in cases:
            condition = None
            for item in case.items:
                test = self.test(value, item)
                condition = test if condition is None else e.Binary("or", condition, test)
            if condition is None:
                raise Unliftable
            branches.append(p.Branch(condition, inside))
        return p.If(tuple(branches), otherwise)

    def tests(self, _: e.Expression, case: s.Case) -> tuple[e.Expression, ...] | None:
        """The single values of a case, None if it has ranges."""
        if all(isinstance(i, s.CaseRange) and i.last is None for i in case.items):
            firsts = [i.first for i in case.items if isinstance(i, s.CaseRange)]
            return tuple(self.meanings.plain(f) for f in firsts)
        return None

    def test(self, value: e.Expression, item: s.CaseRange | s.CaseIs) -> e.Expression:
        if isinstance(item, s.CaseIs):
            operator: Any = {"><": "<>", "=<": "<=", "=>": ">="}.get(item.operator, item.operator)
            return e.Binary(operator, value, self.meanings.plain(item.value))
        first = self.meanings.plain(item.first)
        if item.last is None:
            return e.Binary("=", value, first)
        last = self.meanings.plain(item.last)
        return e.Binary("and", e.Binary(">=", value, first), e.Binary("<=", value, last))

    def waited(self, at: int, high: int, made: list[p.Statement]) -> int:
        """`*W1`, `If condition Then *W1Z Else *W1`, `*W1Z`: a wait for a condition."""
        if at + 2 >= high:
            return 0
        label, test, end = self.code[at : at + 3]
        match label, test, end:
            case (
                s.Line(label=str() as name, statement=None),
                s.Line(
                    label=None,
                    statement=s.If(
                        condition=condition,
                        then=s.Target(place=out),
                        otherwise=s.Target(place=again),
                    ),
                ),
                s.Line(label=str() as last, statement=None),
            ) if name[:1] == "W" and name[1:].isdigit() and again == name and out == last:
                if last != name + "Z":
                    return 0
                self.runs.flush(made)
                made.append(p.WaitUntil(self.meanings.of(condition)))
                return at + 3
        return 0

    def one_line_if(self, node: s.If) -> list[p.Statement]:
        if node.then is None:
            raise Unliftable
        condition = self.meanings.of(node.condition)
        then = self.branch(node.then)
        otherwise = () if node.otherwise is None else self.branch(node.otherwise)
        return [p.If((p.Branch(condition, then),), otherwise)]

    def branch(self, node: s.Statement | s.Target) -> tuple[p.Statement, ...]:
        if isinstance(node, s.Target):
            node = s.Jump("GoTo", node)
        if isinstance(node, s.Command) and node.keyword in SETTINGS:
            raise Unliftable
        made = STATEMENTS[type(node)](self, node) if type(node) in STATEMENTS else None
        if made is None:
            raise Unliftable
        self.runs.forget()
        return tuple(made)

    def jump(self, node: s.Jump) -> list[p.Statement]:
        place = node.target.place
        if isinstance(place, int):
            raise Unliftable
        if node.keyword == "GoSub":
            if place.upper() not in self.called:
                raise Unliftable
            name = self.meanings.header.names["procedure"].get(place.upper()) or identifier(place)
            self.at_call.setdefault(place.upper(), self.now())
            self.runs.forget()
            return [p.Call(name)]
        if place.upper() not in self.labels:
            raise Unliftable
        return [p.Goto(self.label_name(place))]

    def callp(self, node: s.CallP) -> list[p.Statement]:
        if not isinstance(node.program, s.String):
            raise Unliftable
        short = node.program.value.upper()
        unit = self.units.get(short) or identifier(node.program.value)
        first = self.firsts.get(short) or unit
        self.runs.forget()
        return [p.Call(first, tuple(self.meanings.plain(a) for a in node.arguments), unit)]

    def assign(self, node: s.Assign) -> list[p.Statement]:
        target = node.target
        if target.key in SIGNALS and target.arguments and not target.component:
            name = self.meanings.plain(target)
            if not isinstance(name, e.Name):
                raise Unliftable
            pulse = None if node.delay is None else self.meanings.of(node.delay)
            return [p.SetSignal(name.name, self.meanings.of(node.value), pulse)]
        if node.delay is not None or target.suffix in ("!", "#"):
            raise Unliftable
        name = self.meanings.plain(target)
        self.runs.previous = None
        if isinstance(node.value, s.Constant):
            robot = self.meanings.robot
            if target.key[0] == "J":
                return [p.Assign(name, e.JointValue(joints_of(node.value, robot)))]
            return [p.Assign(name, e.TargetValue(target_of(node.value, robot)))]
        return [p.Assign(name, self.meanings.of(node.value))]

    def define(self, node: s.DefNames) -> list[p.Statement]:
        kinds: dict[str, Any] = {
            "Inte": "integer", "Long": "integer", "Float": "number", "Double": "number",
            "Char": "text", "Pos": "position", "Jnt": "joints",
        }  # fmt: skip
        if node.type not in kinds or any(v.arguments or v.key[1:2] == "_" for v in node.variables):
            raise Unliftable
        for variable in node.variables:
            self.meanings.types[variable.key] = kinds[node.type]
            self.meanings.name(variable)
        return []

    def command(self, node: s.Command) -> list[p.Statement]:
        if node.keyword not in COMMANDS:
            raise Unliftable
        return [COMMANDS[node.keyword](self, node.arguments)]

    def wait(self, arguments: tuple[Any, ...]) -> p.Statement:
        (condition,) = _exactly(arguments, 1)
        match condition:
            case s.Binary(
                operator="=", left=s.Variable() as variable, right=s.Number() as value
            ) if variable.key in SIGNALS:
                name = self.meanings.plain(variable)
                if isinstance(name, e.Name):
                    return p.WaitSignal(name.name, e.Number(value.value))
        return p.WaitUntil(self.meanings.of(condition))

    def hand(self, action: Any, arguments: tuple[Any, ...]) -> p.Statement:
        (hand,) = _exactly(arguments, 1)
        if not isinstance(hand, s.Number):
            raise Unliftable
        return p.Gripper(action, int(hand.value))

    def end(self, arguments: tuple[Any, ...]) -> p.Statement:
        _exactly(arguments, 0)
        return p.Return() if self.first and not self.main else p.Stop(end=True)

    def acceleration(self, arguments: tuple[Any, ...]) -> p.Statement:
        full: tuple[Any, ...] = (s.Number(100), s.Number(100))
        given = (*arguments, *full[len(arguments) :]) if len(arguments) <= 2 else ()
        up, down = _exactly(given, 2)
        return p.SetAcceleration(self.meanings.of(up or full[0]), self.meanings.of(down or full[1]))

    def value(self, arguments: tuple[Any, ...]) -> e.Expression:
        (value,) = _exactly(arguments, 1)
        return self.meanings.of(value)

    def returned(self, arguments: tuple[Any, ...]) -> p.Statement:
        _exactly(arguments, 0)
        if self.first:
            raise Unliftable
        return p.Return()

    def stopped(self, arguments: tuple[Any, ...]) -> p.Statement:
        _exactly(arguments, 0)
        return p.Stop()


def _exactly(arguments: tuple[Any, ...], count: int) -> tuple[Any, ...]:
    if len(arguments) != count or (count and arguments[0] is None and count == 1):
        raise Unliftable
    return arguments


def _comment(text: str) -> str:
    return text[1:].strip() if text.startswith("'") else text[3:].strip()


def _with_span(statement: p.Statement, span: Any) -> p.Statement:
    from dataclasses import replace

    return replace(statement, span=span)


SETTINGS: Final[dict[str, Callable[[Reader, tuple[Any, ...]], bool]]] = {
    "Spd": Reader.set_speed,
    "JOvrd": Reader.set_joint,
    "Cnt": Reader.set_blend,
    "Tool": Reader.set_tool,
    "Base": Reader.set_frame,
}

COMMANDS: Final[dict[str, Callable[[Reader, tuple[Any, ...]], p.Statement]]] = {
    "Dly": lambda reader, a: p.Wait(reader.value(a)),
    "Wait": Reader.wait,
    "Ovrd": lambda reader, a: p.SetOverride(reader.value(a)),
    "Accel": Reader.acceleration,
    "HOpen": lambda reader, a: reader.hand("open", a),
    "HClose": lambda reader, a: reader.hand("close", a),
    "Hlt": Reader.stopped,
    "End": Reader.end,
    "Return": Reader.returned,
}

STATEMENTS: Final[dict[type, Callable[[Reader, Any], list[p.Statement]]]] = {
    s.Motion: Reader.move,
    s.Command: Reader.command,
    s.Assign: Reader.assign,
    s.If: Reader.one_line_if,
    s.Jump: Reader.jump,
    s.CallP: Reader.callp,
    s.DefNames: Reader.define,
}
