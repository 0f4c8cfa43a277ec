"""From the pseudo-program to the typed tree: one module a unit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final
from weakref import ReferenceType, ref

import numpy as np

from assistant.languages.rapid import rules, verbatim
from assistant.languages.rapid import syntax as s
from assistant.languages.rapid.gather import gathered, literal_target, names_of
from assistant.languages.rapid.header import header_lines
from assistant.languages.rapid.loops import ascends
from assistant.languages.rapid.lower_expressions import (
    OR,
    SUM,
    TERM,
    Expressions,
    finite,
    joints_node,
    numbers_node,
    pose_node,
    refuse,
    target_node,
)
from assistant.languages.rapid.messages import is_value, kinds, parts
from assistant.languages.rapid.motions import speed_name, speed_values, zone_name, zone_values
from assistant.languages.rapid.naming import Naming, naming
from assistant.languages.rapid.runs import (
    JOINT_PLACES,
    POSITION_PLACES,
    QUATERNION_PLACES,
    MotionNames,
    MoveRun,
    Names,
    TargetRun,
)
from assistant.languages.rapid.tables import (
    GRIPPER_SIGNAL,
    GRIPPER_VALUE,
    LEAST_CENTRE,
    LEAST_MASS,
    LOADED_FROM,
    SPEED_CAP,
    SPEEDS,
    TYPE_OF_VALUE,
    UNUSED,
    ZONES,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import BASE, FLANGE, Frame, Load, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.path import Kind, Path
from assistant.program.program import Procedure, Program, Variable, walk
from assistant.robots.configurations import to_confdata

SIZES_PLACES: Final = 6
"""Decimals of masses, inertias, speeds and zone sizes."""


def build(program: Program, unit: str | None = None) -> s.File:
    """The tree of one unit of an adapted program; raises Refused for what RAPID cannot say."""
    return s.File((_Unit(program, unit).module(),))


def module_name(program: Program, unit: str | None = None) -> str:
    return program_naming(program).get("modules", unit or program.name)


_latest: list[tuple[ReferenceType[Program], Naming]] = []
"""The program that was named last: every unit of a long one asks for the same names."""


def program_naming(program: Program) -> Naming:
    for known, names in _latest:
        if known() is program:
            return names
    names = _named(program)
    _latest[:] = [(ref(program), names)]
    return names


def _named(program: Program) -> Naming:
    fixed: list[str] = []
    for declaration in program.declarations:
        if declaration.language == "rapid":
            fixed += [i.name for i in verbatim.items(declaration.text) if hasattr(i, "name")]
    return naming(program, fixed)


class _Unit:
    def __init__(self, program: Program, unit: str | None) -> None:
        self.program, self.unit = program, unit
        self.names = program_naming(program)
        self.here = [q for q in program.procedures if q.unit == unit]
        self.expressions = Expressions(
            lambda n: self.names.get("values", self.names.get("signals", n)),
            lambda n: self.names.get("procedures", n),
            lambda n: self.names.get("tools", n),
            lambda n: self.names.get("frames", n),
        )

    def module(self) -> s.Module:
        names = self.names
        short = names.get("modules", self.unit or self.program.name)
        lines = header_lines(self.program, self.unit, names.changed)
        items: list[Any] = [s.CommentLine(line) for line in lines]
        declared: list[s.Item] = []
        if self.unit is None:
            for declaration in self.program.declarations:
                if declaration.language != "rapid":
                    raise refuse(
                        rules.OTHER_LANGUAGE,
                        language=declaration.language,
                        text=declaration.text[:60],
                    )
                declared += verbatim.items(declaration.text)
        items += [i for i in declared if isinstance(i, s.Record | s.Alias)]
        if self.unit is None:
            items += self.data()
        items += [i for i in declared if not isinstance(i, s.Record | s.Alias | s.Routine)]
        for procedure in self.here:
            items += self.path_targets(procedure)
        items += [self.routine(procedure) for procedure in self.here]
        items += [i for i in declared if isinstance(i, s.Routine)]
        return s.Module(short, (), gathered(items))

    # Data

    def data(self) -> Iterator[s.Data]:
        program, names = self.program, self.names
        for name, tool in program.tools.items():
            if name != FLANGE:
                yield s.Data("", "PERS", "tooldata", names.get("tools", name), (), tool_node(tool))
        for name, frame in program.frames.items():
            if name != BASE:
                yield s.Data(
                    "", "PERS", "wobjdata", names.get("frames", name), (), frame_node(frame)
                )
        speeds = {names.get("speeds", n): v for n, v in program.speeds.items()}
        blends = {names.get("blends", n): v for n, v in program.blends.items()}
        for speed, blend in motions(program):
            if isinstance(speed, Speed) and (name := speed_name(speed)) not in SPEEDS:
                speeds[name] = speed
            if isinstance(blend, Blend) and (name := zone_name(blend)) not in ZONES:
                blends[name] = blend
        for name, speed in speeds.items():
            finite(speed_values(speed), f"the speed `{name}`")
            sizes = numbers_node(speed_values(speed), SIZES_PLACES)
            yield s.Data("", "CONST", "speeddata", name, (), sizes)
        for name, blend in blends.items():
            finite(zone_values(blend), f"the zone `{name}`")
            sizes = numbers_node(zone_values(blend), SIZES_PLACES)
            zone = s.AggregateNode((s.BoolLiteral(blend.fine), *sizes.items))
            yield s.Data("", "CONST", "zonedata", name, (), zone)
        for name, joints in program.joint_targets.items():
            short = names.get("values", name)
            yield s.Data("", "CONST", "jointtarget", short, (), joints_node(joints))
        for name, variable in program.variables.items():
            yield self.variable(names.get("values", name), variable, self.expressions)
        for name, target in program.targets.items():
            short = names.get("values", name)
            yield s.Data("", "CONST", "robtarget", short, (), target_node(target))

    def variable(self, name: str, variable: Variable, expressions: Expressions) -> s.Data:
        storage = {"constant": "CONST", "variable": "VAR", "persistent": "PERS"}[variable.storage]
        value = None if variable.initial is None else expressions.lower(variable.initial)
        return s.Data(
            "LOCAL" if variable.local else "",
            storage,
            TYPE_OF_VALUE[variable.type],
            name,
            tuple(s.NumberLiteral(str(extent)) for extent in variable.size),
            value,
        )

    def path_targets(self, procedure: Procedure) -> Iterator[s.TargetRunNode | s.Data]:
        for statement in walk(procedure.body):
            if isinstance(statement, p.Follow):
                stem = self.names.rows[id(statement)]
                yield from few_targets(path_run(statement.path, stem))

    # Routines

    def routine(self, procedure: Procedure) -> s.Routine:
        key = procedure.name.lower()
        inner, counters = self.names.inner[key], self.names.counters[key]
        counting: list[str] = []

        def known(name: str) -> str:
            return spelt(inner, name)

        def value(name: str) -> str:
            if name.lower() in counting:
                return spelt(counters, name)
            if name.lower() in inner:
                return known(name)
            return self.names.get("values", self.names.get("signals", name))

        expressions = Expressions(
            value,
            lambda n: self.names.get("procedures", n),
            lambda n: self.names.get("tools", n),
            lambda n: self.names.get("frames", n),
        )
        statements, handlers = _apart(procedure.body)
        body = _Body(self.program, self.names, expressions, counting, procedure)
        variables = [
            self.variable(known(n), v, expressions) for n, v in procedure.variables.items()
        ]
        parameters = tuple(
            s.ParameterGroup(
                False,
                (
                    s.ParameterNode(
                        "INOUT" if q.mode == "inout" else "", TYPE_OF_VALUE[q.type], known(q.name)
                    ),
                ),
            )
            for q in procedure.parameters
        )
        return s.Routine(
            "PROC" if procedure.result is None else "FUNC",
            procedure.local,
            self.names.get("procedures", procedure.name),
            gathered([*variables, *body.statements(statements)]),
            "" if procedure.result is None else TYPE_OF_VALUE[procedure.result],
            parameters,
            handlers,
        )


def _apart(
    body: tuple[p.Statement, ...],
) -> tuple[tuple[p.Statement, ...], tuple[s.Handler, ...]]:
    """The statements of a body, and the error handlers that stand verbatim at its end."""
    found: list[s.Handler] = []
    for statement in reversed(body):
        if not isinstance(statement, p.Opaque) or statement.language != verbatim.LANGUAGE:
            break
        handlers = verbatim.handlers(statement.text)
        if handlers is None:
            break
        found[:0] = handlers
        body = body[:-1]
    return body, tuple(found)


def spelt(names: Mapping[str, str], name: str) -> str:
    """RAPID's name of something; its own case where only that differs."""
    short = names.get(name.lower(), name)
    return name if short.lower() == name.lower() else short


class _Body:
    """counting: lower-case names that the loops around a statement count; filled as it goes."""

    def __init__(
        self,
        program: Program,
        names: Naming,
        expressions: Expressions,
        counting: list[str],
        procedure: Procedure,
    ) -> None:
        self.program, self.names, self.lower = program, names, expressions.lower
        self.counting = counting
        self.counters = names.counters[procedure.name.lower()]
        self.labels = names.labels[procedure.name.lower()]
        self.known = kinds(program, procedure)
        self.kinds = {n.lower(): g.kind for n, g in program.signals.items()}

    def block(self, body: tuple[p.Statement, ...]) -> tuple[Any, ...]:
        return gathered(self.statements(body))

    def statements(self, body: tuple[p.Statement, ...]) -> Iterator[s.StatementNode]:
        for statement in body:
            yield from STATEMENTS[type(statement)](self, statement)

    def motion(self, m: p.Motion) -> MotionNames:
        return motion_names(self.names, m.speed, m.blend, m.tool, m.frame)

    def move(self, word: str, points: list[e.Expression], m: p.Motion) -> s.ProcedureCall:
        names = self.motion(m)
        given = [self.lower(point) for point in points]
        given += [s.NameRef(n) for n in (names.speed, names.zone, names.tool)]
        arguments: list[s.Argument] = [s.Positional(g) for g in given]
        if names.frame:
            arguments.append(s.Option("WObj", s.NameRef(names.frame)))
        return s.ProcedureCall(word, tuple(arguments))

    def call(self, word: str, *given: s.Expression, **options: s.Expression) -> s.ProcedureCall:
        arguments: list[s.Argument] = [s.Positional(g) for g in given]
        arguments += [s.Option(n, v) for n, v in options.items()]
        return s.ProcedureCall(word, tuple(arguments))

    def signal(self, name: str) -> s.NameRef:
        return s.NameRef(self.names.get("signals", name))


Lowered = Iterator[s.StatementNode]


def _move(b: _Body, x: p.Move) -> Lowered:
    yield b.move("MoveJ" if x.kind == "joint" else "MoveL", [x.target], x.motion)


def _circular(b: _Body, x: p.MoveCircular) -> Lowered:
    yield b.move("MoveC", [x.via, x.target], x.motion)


def _joints(b: _Body, x: p.MoveJoints) -> Lowered:
    yield b.move("MoveAbsJ", [x.target], x.motion)


def _follow(b: _Body, x: p.Follow) -> Lowered:
    yield from few_moves(path_moves(x.path, b.names.rows[id(x)], b.names))


def _wait(b: _Body, x: p.Wait) -> Lowered:
    yield b.call("WaitTime", b.lower(x.seconds))


def _wait_signal(b: _Body, x: p.WaitSignal) -> Lowered:
    signal = next((g for n, g in b.program.signals.items() if n.lower() == x.signal.lower()), None)
    group, output = (signal.kind == "group", signal.direction == "output") if signal else (0, 0)
    word = f"Wait{'G' if group else 'D'}{'O' if output else 'I'}"
    options = {} if x.timeout is None else {"MaxTime": b.lower(x.timeout)}
    yield b.call(word, b.signal(x.signal), b.lower(x.value), **options)


def _wait_until(b: _Body, x: p.WaitUntil) -> Lowered:
    options = {} if x.timeout is None else {"MaxTime": b.lower(x.timeout)}
    yield b.call("WaitUntil", b.lower(x.condition), **options)


def _set_signal(b: _Body, x: p.SetSignal) -> Lowered:
    if x.pulse is not None:
        if x.value != e.Number(1):
            raise refuse(
                rules.NO_MEANING,
                what=f"a pulse of `{x.signal}` to anything but 1",
                hint="set the signal, wait and set it back",
            )
        high: tuple[s.Argument, ...] = (s.Option("High"), s.Option("PLength", b.lower(x.pulse)))
        yield s.ProcedureCall("PulseDO", (*high, s.Positional(b.signal(x.signal))))
        return
    word = {"analog": "SetAO", "group": "SetGO"}.get(b.kinds.get(x.signal.lower(), ""), "SetDO")
    yield b.call(word, b.signal(x.signal), b.lower(x.value))


def _gripper(b: _Body, x: p.Gripper) -> Lowered:
    signal = s.NameRef(GRIPPER_SIGNAL.format(hand=x.hand))
    yield b.call("SetDO", signal, s.NumberLiteral(str(GRIPPER_VALUE[x.action])))


def _acceleration(b: _Body, x: p.SetAcceleration) -> Lowered:
    yield b.call("AccSet", b.lower(x.acceleration), s.NumberLiteral("100"))


def _override(b: _Body, x: p.SetOverride) -> Lowered:
    yield b.call("VelSet", b.lower(x.percent), s.NumberLiteral(str(SPEED_CAP)))


def _call(b: _Body, x: p.Call) -> Lowered:
    name = b.names.get("procedures", x.procedure)
    given = tuple(s.Positional(b.lower(a)) for a in x.arguments)
    if x.unit is None:
        yield s.ProcedureCall(name, given)
        return
    file = s.StringLiteral(LOADED_FROM + b.names.get("modules", x.unit) + ".mod")
    yield s.ProcedureCall("Load", (s.Option("Dynamic"), s.Positional(file)))
    yield s.ProcedureCall(s.StringLiteral(name), given)
    yield s.ProcedureCall("UnLoad", (s.Positional(file),))


def _assign(b: _Body, x: p.Assign) -> Lowered:
    target = b.lower(x.target)
    if not isinstance(target, s.NameRef | s.Component | s.Element):
        raise refuse(
            rules.NO_MEANING, what="an assignment to an expression", hint="name a variable"
        )
    yield s.Assignment(target, b.lower(x.value))


def _if(b: _Body, x: p.If) -> Lowered:
    branches = tuple(s.IfBranch(b.lower(c.condition), b.block(c.body)) for c in x.branches)
    yield s.IfThen(branches, b.block(x.otherwise) if x.otherwise else None)


def _while(b: _Body, x: p.While) -> Lowered:
    yield s.WhileLoop(b.lower(x.condition), b.block(x.body))


def _for(b: _Body, x: p.For) -> Lowered:
    # Without STEP a loop counts downwards where its bounds do (RAPID kernel manual, FOR).
    upwards = x.step == p.ONE and ascends(x.first, x.last)
    step = None if upwards or x.step is None else b.lower(x.step)
    first, last = b.lower(x.first), b.lower(x.last)
    b.counting.append(x.variable.lower())
    body = b.block(x.body)
    b.counting.pop()
    yield s.ForLoop(spelt(b.counters, x.variable), first, last, step, body)


def _switch(b: _Body, x: p.Switch) -> Lowered:
    cases = tuple(s.TestCase(tuple(map(b.lower, c.values)), b.block(c.body)) for c in x.cases)
    yield s.TestOf(b.lower(x.subject), cases, b.block(x.otherwise) if x.otherwise else None)


def _stop(b: _Body, x: p.Stop) -> Lowered:
    yield s.Word("EXIT") if x.end else b.call("Stop")


def _return(b: _Body, x: p.Return) -> Lowered:
    yield s.ReturnFrom(None if x.value is None else b.lower(x.value))


def _comment(_: _Body, x: p.Comment) -> Lowered:
    yield s.CommentLine(x.text)


def _label(b: _Body, x: p.Label) -> Lowered:
    yield s.LabelMark(spelt(b.labels, x.name))


def _goto(b: _Body, x: p.Goto) -> Lowered:
    yield s.GotoLabel(spelt(b.labels, x.label))


def _message(b: _Body, x: p.Message) -> Lowered:
    whole: s.Expression | None = None
    for part in parts(x, b.known) or (e.Text(""),):
        if is_value(part, b.known):
            own: s.Expression = s.FunctionCall("ValToStr", (s.Positional(b.lower(part, OR)),))
        else:
            own = b.lower(part, TERM if whole is not None else SUM)
        whole = own if whole is None else s.Infix("+", whole, own)
    assert whole is not None
    yield b.call("TPWrite", whole)


def _opaque(_: _Body, x: p.Opaque) -> Lowered:
    if x.language != verbatim.LANGUAGE:
        raise refuse(rules.OTHER_LANGUAGE, language=x.language, text=x.text[:60])
    yield from verbatim.statements(x.text)


STATEMENTS: Final[dict[type, Callable[[_Body, Any], Lowered]]] = {
    p.Move: _move,
    p.MoveCircular: _circular,
    p.MoveJoints: _joints,
    p.Follow: _follow,
    p.Wait: _wait,
    p.WaitSignal: _wait_signal,
    p.WaitUntil: _wait_until,
    p.SetSignal: _set_signal,
    p.Gripper: _gripper,
    p.SetAcceleration: _acceleration,
    p.SetOverride: _override,
    p.Call: _call,
    p.Assign: _assign,
    p.If: _if,
    p.While: _while,
    p.For: _for,
    p.Switch: _switch,
    p.Stop: _stop,
    p.Return: _return,
    p.Comment: _comment,
    p.Label: _label,
    p.Goto: _goto,
    p.Message: _message,
    p.Opaque: _opaque,
}


# Columns


def path_run(path: Path, stem: str) -> TargetRun:
    """The targets of a path, rounded as they are printed."""
    if not (np.isfinite(path.positions).all() and np.isfinite(path.quaternions).all()):
        raise refuse(rules.NOT_FINITE, what=f"the path `{path.name}`")
    values = np.empty((len(path), 17))
    np.round(path.positions, POSITION_PLACES, out=values[:, 0:3])
    np.round(path.quaternions, QUATERNION_PLACES, out=values[:, 3:7])
    values[:, 7:11] = to_confdata(path.configurations)
    external = np.where(np.isnan(path.external), UNUSED, path.external)
    np.round(external, JOINT_PLACES, out=values[:, 11:17])
    return TargetRun(Names.numbered(f"{stem}_", len(path)), values + 0.0)


def path_moves(path: Path, stem: str, names: Naming) -> MoveRun:
    via = path.kinds == Kind.VIA
    ends = np.flatnonzero(~via)
    sizes = (len(path.blends), len(path.tools), len(path.frames))
    code = path.speed[ends].astype(np.int64)
    for column, size in zip((path.blend, path.tool, path.frame), sizes, strict=True):
        code = code * size + column[ends]
    different, index = np.unique(code, return_inverse=True)
    table: dict[MotionNames, int] = {}
    rows = []
    for value in different:
        rest, frame = divmod(int(value), sizes[2])
        rest, tool = divmod(rest, sizes[1])
        speed, blend = divmod(rest, sizes[0])
        motion = motion_names(
            names, path.speeds[speed], path.blends[blend], path.tools[tool], path.frames[frame]
        )
        rows.append(table.setdefault(motion, len(table)))
    kinds = np.array([0, 1, 0, 2], dtype=np.uint8)[path.kinds[ends]]
    whole = Names.numbered(f"{stem}_", len(path))
    return MoveRun(
        kinds,
        whole.rows(ends),
        whole.rows(np.flatnonzero(via)),
        np.array(rows, dtype=np.int32)[index],
        tuple(table),
    )


def few_targets(run: TargetRun) -> list[s.TargetRunNode | s.Data]:
    """A run as a node, or as single declarations if it is too short for one."""
    if len(run) >= 8:
        return [s.TargetRunNode("", run)]
    from assistant.languages.rapid.parser import parse_items
    from assistant.languages.rapid.runs import targets_text

    read = parse_items(targets_text(run, "", "", "\n"))
    assert isinstance(read, tuple)
    return list(read)  # type: ignore[arg-type]


def few_moves(run: MoveRun) -> list[s.StatementNode]:
    if len(run) >= 8:
        return [s.MoveRunNode(run)]
    from assistant.languages.rapid.parser import parse_statements
    from assistant.languages.rapid.runs import moves_text

    read = parse_statements(moves_text(run, "", "\n"))
    assert isinstance(read, tuple)
    return list(read)


def motion_names(
    names: Naming, speed: Speed | e.Name, blend: Blend | e.Name, tool: str, frame: str
) -> MotionNames:
    return MotionNames(
        names.get("speeds", speed.name) if isinstance(speed, e.Name) else speed_name(speed),
        names.get("blends", blend.name) if isinstance(blend, e.Name) else zone_name(blend),
        names.get("tools", tool),
        "" if frame.lower() == BASE else names.get("frames", frame),
    )


def motions(program: Program) -> Iterator[tuple[Speed | e.Name, Blend | e.Name]]:
    """Every speed and blend that a move states, each table entry of a path once."""
    for statement in program.statements():
        if isinstance(statement, p.Move | p.MoveCircular | p.MoveJoints):
            yield statement.motion.speed, statement.motion.blend
        elif isinstance(statement, p.Follow):
            path = statement.path
            used = (
                [path.speeds[i] for i in np.unique(path.speed)],
                [path.blends[i] for i in np.unique(path.blend)],
            )
            most = max(len(u) for u in used)
            for i in range(most):
                yield used[0][min(i, len(used[0]) - 1)], used[1][min(i, len(used[1]) - 1)]


def tool_node(tool: Tool) -> s.AggregateNode:
    load = tool.load or Load(LEAST_MASS, LEAST_CENTRE)
    return s.AggregateNode((s.BoolLiteral(tool.held), pose_node(tool.tip), load_node(load)))


def load_node(load: Load) -> s.AggregateNode:
    numbers = [load.mass, *load.centre, *load.axes, *load.inertia]
    finite(numbers, "the load of a tool")
    return s.AggregateNode(
        (
            *numbers_node([load.mass], SIZES_PLACES).items,
            numbers_node(list(load.centre), POSITION_PLACES),
            numbers_node(list(load.axes), QUATERNION_PLACES),
            *numbers_node(list(load.inertia), SIZES_PLACES).items,
        )
    )


def frame_node(frame: Frame) -> s.AggregateNode:
    return s.AggregateNode(
        (
            s.BoolLiteral(frame.held),
            s.BoolLiteral(not frame.mechanism),
            s.StringLiteral(frame.mechanism),
            pose_node(frame.user),
            pose_node(frame.object),
        )
    )


__all__ = ["build", "literal_target", "module_name", "names_of", "replace"]
