"""A program as MELFA-BASIC will say it: what is said differently is a finding."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from assistant.languages.language import Adapted
from assistant.languages.melfa_basic import poses, rules
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.adapt.expressions import plain_expression, plain_statement
from assistant.languages.melfa_basic.adapt.paths import (
    MOST_TARGETS,
    joint_percent,
    plain_path,
    plain_speed,
    split,
)
from assistant.languages.melfa_basic.dialects import DIALECTS, LAST_STEP, Dialect
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.diagnostics import Diagnostic, Findings
from assistant.program.geometry import BASE, FLANGE, IDENTITY, Frame, JointTarget, Target, Tool
from assistant.program.motion import Blend, Speed
from assistant.program.path import configuration_of, configuration_row
from assistant.program.program import Procedure, Program

if TYPE_CHECKING:
    from assistant.robots import Robot

MOST_COMMENT: Final = 100
"""Characters of a comment line that is written."""

FARTHEST: Final = 1e6
"""mm or degrees; no robot reaches there, and a controller refuses the number."""


class Context:
    """What the steps of adapting share."""

    def __init__(self, program: Program, dialect: Dialect, robot: Robot | None) -> None:
        self.program, self.dialect, self.robot = program, dialect, robot
        self.findings = Findings()
        self.unstated = 0
        self.named = 0

    @property
    def five_axis(self) -> bool:
        return self.robot is not None and self.robot.five_axis

    def speed(self, speed: Speed | e.Name, joint_move: bool) -> Speed | e.Name:
        """The speed by value, with its percentage for joint moves only."""
        if isinstance(speed, e.Name):
            found: Speed | None = _find(self.program.speeds, speed.name)
            if found is None:
                self.findings.append(rules.UNKNOWN(what="the speed", name=speed.name))
                return Speed(100.0, joint=1.0) if joint_move else Speed(100.0)
            self.named += 1
            speed = found
        speed, parts = plain_speed(speed)
        self.findings += [rules.SPEED_PARTS(part=part) for part in parts]
        if not joint_move:
            return replace(speed, joint=None)
        if speed.joint is None:
            percent = joint_percent(speed.tcp, self.robot)
            tcp = "the most" if math.isinf(speed.tcp) else f"{speed.tcp:g}"
            self.findings.append(rules.JOINT_PERCENT(tcp=tcp, percent=percent))
            return replace(speed, joint=percent)
        return replace(speed, joint=min(100.0, max(1.0, speed.joint)))

    def blend(self, blend: Blend | e.Name) -> Blend | e.Name:
        if isinstance(blend, e.Name):
            found: Blend | None = _find(self.program.blends, blend.name)
            if found is None:
                self.findings.append(rules.UNKNOWN(what="the blend", name=blend.name))
                return Blend()
            self.named += 1
            blend = found
        if blend.details is not None:
            self.findings.append(rules.BLEND_PARTS())
            blend = replace(blend, details=None)
        if blend.exit is not None and (
            blend.exit == blend.radius or blend.radius is None or math.isinf(blend.radius)
        ):
            blend = replace(blend, exit=None)
        return blend

    def motion(self, motion: p.Motion, joint_move: bool) -> p.Motion:
        tool, frame = self.tool(motion.tool), self.frame(motion.frame)
        speed, blend = self.speed(motion.speed, joint_move), self.blend(motion.blend)
        return p.Motion(speed, blend, tool, frame)

    def tool(self, name: str) -> str:
        return self._named(name, self.program.tools, FLANGE, "the tool")

    def frame(self, name: str) -> str:
        return self._named(name, self.program.frames, BASE, "the frame")

    def _named(self, name: str, given: dict[str, Any], default: str, what: str) -> str:
        if name.lower() == default:
            return default
        known = next((n for n in given if n.lower() == name.lower()), None)
        if known is None:
            self.findings.append(rules.UNKNOWN(what=what, name=name))
        return known or name

    def target(self, name: str, target: Target) -> Target:
        numbers = (*target.pose.position, *target.pose.quaternion)
        if not all(math.isfinite(v) and abs(v) < FARTHEST for v in numbers):
            self.findings.append(rules.NOT_FINITE(where=f"the target `{name}`", place=name))
            return target
        if target.configuration is None:
            self.unstated += 1
        row = np.array([configuration_row(target.configuration)], dtype=np.int8)
        configuration = configuration_of(poses.rounded_configurations(row, self.robot)[0])
        if any(v == v for v in target.external[2:]):
            self.findings.append(rules.CANNOT_SAY(
                what=f"external axes beyond the second, of `{name}`", cure="leave them out"
            ))  # fmt: skip
        if self.five_axis:
            target = self._in_reach(name, target)
        return replace(target, configuration=configuration)

    def _in_reach(self, name: str, target: Target) -> Target:
        from assistant.languages.melfa_basic.adapt.paths import MISS, SAME, over_the_back
        from assistant.robots import five_axis

        position = np.array([target.pose.position])
        quaternion = np.array([target.pose.quaternion])
        row = np.array([configuration_row(target.configuration)], dtype=np.int8)
        if over_the_back(position, quaternion, row)[0]:
            self.findings.append(rules.OVER_THE_BACK(name=name, place=name))
        miss = float(five_axis.miss(position, quaternion)[0])
        if miss > MISS:
            self.findings.append(rules.UNREACHABLE(name=name, angle=miss, place=name))
        if miss <= SAME:
            return target
        projected = five_axis.from_ab(position, five_axis.to_ab(position, quaternion))
        w, x, y, z = (float(v) for v in projected[0])
        return replace(target, pose=replace(target.pose, quaternion=(w, x, y, z)))


def adapt(
    program: Program, robot: Robot | None, dialect_name: str, most_targets: int | None = None
) -> Adapted:
    """The program in this dialect's terms; idempotent."""
    from assistant.languages.melfa_basic.lower.program import Unit, steps
    from assistant.languages.melfa_basic.names import naming

    context = Context(program, DIALECTS[dialect_name], robot)
    if context.five_axis:
        from assistant.languages.melfa_basic.adapt.paths import in_base

        program = context.program = in_base(context, program)
    adapted = _declared(context, program)
    procedures: list[Procedure] = []
    most = MOST_TARGETS if most_targets is None else max(2, most_targets)
    for procedure in _ordered(program):
        procedures += split(context, _procedure(context, procedure), most)
    adapted = replace(adapted, procedures=tuple(_grouped(procedures)))
    adapted = replace(adapted, procedures=_calls(adapted))
    context.findings += _shared(adapted)
    names = naming(adapted, context.dialect)
    for unit in dict.fromkeys([None, *(q.unit for q in adapted.procedures)]):
        writing = Unit(adapted, robot, unit, context.dialect, names)
        code = writing.code()
        count = steps(code)
        context.findings += writing.findings
        context.findings += too_long(code, context.dialect)
        if count > LAST_STEP:
            name = names.units[unit]
            context.findings.append(
                rules.TOO_MANY_STEPS(name=name, count=count, most=LAST_STEP, place=name)
            )
    if context.unstated:
        context.findings.append(rules.NO_CONFIGURATION(count=context.unstated))
    if context.named:
        context.findings.append(rules.NAMED(count=context.named))
    return Adapted(adapted, tuple(context.findings))


def too_long(code: Iterable[s.Item], dialect: Dialect) -> Iterable[Diagnostic]:
    """Lines that a step cannot hold, such as long conditions."""
    from assistant.languages.melfa_basic import printer

    most = dialect.line - len(f"{LAST_STEP} ")
    for item in code:
        if isinstance(item, s.Line) and (text := printer.line(item, dialect.upper)):
            length = len(text.encode("utf-8"))
            if length > most:
                place = text[:40] + "..."
                yield rules.LONG_LINE(length=length, most=most, place=place)


def _find(table: dict[str, Any], name: str) -> Any:
    return next((v for k, v in table.items() if k.lower() == name.lower()), None)


def _declared(context: Context, program: Program) -> Program:
    """Everything but the procedures."""
    joint_targets = {n: _joints(context, n, t) for n, t in program.joint_targets.items()}
    return replace(
        program,
        robot=context.robot.name if context.robot is not None else program.robot,
        entry=_entry(program),
        comments=tuple(line for text in program.comments for line in comment_lines(text)),
        tools=dict(_tools(context, program)),
        frames=dict(_frames(context, program)),
        speeds={},
        blends={},
        targets={n: context.target(n, t) for n, t in program.targets.items()},
        joint_targets=joint_targets,
        variables={
            n: replace(
                v, initial=None if v.initial is None else plain_expression(context, v.initial)
            )
            for n, v in program.variables.items()
        },
        declarations=tuple(_declarations(context, program)),
    )


def _entry(program: Program) -> str | None:
    procedure = program.procedure(program.entry) if program.entry else None
    return procedure.name if procedure else None


def _declarations(context: Context, program: Program) -> Iterable[Any]:
    for declaration in program.declarations:
        context.findings.append(rules.CANNOT_SAY(
            what=f"the {declaration.language} declaration `{declaration.text[:40]}`",
            cure="leave it out or say it in plain statements",
        ))  # fmt: skip
        yield declaration


def _tools(context: Context, program: Program) -> Iterable[tuple[str, Tool]]:
    for name, tool in program.tools.items():
        if name.lower() == FLANGE and tool.tip == IDENTITY:
            continue
        if not tool.held:
            context.findings.append(rules.HELD(name=name, place=name))
        if tool.load is not None:
            context.findings.append(rules.LOAD(name=name, place=name))
        if context.five_axis:
            turned = rotations.angle_between(tool.tip.quaternion, IDENTITY.quaternion)
            if math.hypot(*tool.tip.position[:2]) > 0.01 or turned > 0.01:
                context.findings.append(rules.FIVE_AXIS_TOOL(name=name, place=name))
        _finite(context, f"the tool `{name}`", (*tool.tip.position, *tool.tip.quaternion))
        yield name, replace(tool, load=None)


def _frames(context: Context, program: Program) -> Iterable[tuple[str, Frame]]:
    for name, frame in program.frames.items():
        if name.lower() == BASE and frame.pose == IDENTITY:
            continue
        if frame.held or frame.mechanism:
            context.findings.append(rules.HELD(name=name, place=name))
        if frame.object != IDENTITY:
            context.findings.append(rules.FRAME_JOINED(name=name, place=name))
            frame = replace(frame, user=frame.pose, object=IDENTITY)
        _finite(context, f"the frame `{name}`", (*frame.user.position, *frame.user.quaternion))
        yield name, frame


def _finite(context: Context, where: str, values: Iterable[float]) -> None:
    if not all(math.isfinite(v) and abs(v) < FARTHEST for v in values):
        context.findings.append(rules.NOT_FINITE(where=where))


def _joints(context: Context, name: str, target: JointTarget) -> JointTarget:
    joints = target.joints
    if context.five_axis and len(joints) == 6:
        fourth = joints[3]
        if fourth == fourth and abs(fourth) > 0.01:
            context.findings.append(rules.CANNOT_SAY(
                what=f"axis 4 of `{name}` for an arm of five axes", cure="teach it on this arm"
            ))  # fmt: skip
        joints = joints[:3] + joints[4:]
    if not context.five_axis and any(v != v for v in joints):
        joints = tuple(0.0 if v != v else v for v in joints)
    wanted = 5 if context.five_axis else 6
    used = tuple(v for v in target.external if v == v)
    if len(joints) != wanted or used != target.external[: len(used)] or len(used) > 2:
        context.findings.append(rules.CANNOT_SAY(
            what=f"the {len(joints)} joints and external axes of `{name}`",
            cure=f"give {wanted} joints and at most two external axes",
        ))  # fmt: skip
    _finite(context, f"the joint target `{name}`", (v for v in joints if v == v))
    return replace(target, joints=joints)


# -------------------------------------------------------------------------- procedures


def _ordered(program: Program) -> list[Procedure]:
    """The entry first, then the rest as they stand."""
    entry = (program.entry or "").lower()
    return sorted(program.procedures, key=lambda q: q.name.lower() != entry)


def _grouped(procedures: list[Procedure]) -> list[Procedure]:
    """Procedures of one unit together, the main unit first."""
    units: dict[str | None, list[Procedure]] = {None: []}
    for procedure in procedures:
        units.setdefault(procedure.unit, []).append(procedure)
    return [procedure for unit in units.values() for procedure in unit]


def _procedure(context: Context, procedure: Procedure) -> Procedure:
    entry = procedure.unit is None and (
        procedure.name.lower() == (context.program.entry or "").lower()
    )
    return replace(
        procedure,
        body=tuple(_body(context, procedure.body, entry, 0)),
        local=False,
        variables={
            n: replace(
                v, initial=None if v.initial is None else plain_expression(context, v.initial)
            )
            for n, v in procedure.variables.items()
        },
    )


def _body(
    context: Context, body: tuple[p.Statement, ...], entry: bool, selects: int
) -> Iterable[p.Statement]:
    for statement in body:
        with context.findings.at(statement.span):
            for made in _statement(context, statement, entry, selects):
                yield made if made.span else replace(made, span=statement.span)


def _statement(
    context: Context, node: p.Statement, entry: bool, selects: int
) -> Iterable[p.Statement]:
    node = plain_statement(context, node)

    def inside(body: tuple[p.Statement, ...], more: int = 0) -> tuple[p.Statement, ...]:
        return tuple(_body(context, body, entry, selects + more))

    match node:
        case p.Move(kind=kind, motion=motion):
            yield replace(node, motion=context.motion(motion, kind == "joint"))
        case p.MoveJoints(motion=motion):
            yield replace(node, motion=context.motion(motion, True))
        case p.MoveCircular(motion=motion):
            yield replace(node, motion=context.motion(motion, False))
        case p.Follow(path=path):
            if len(path):
                yield replace(node, path=plain_path(context, path))
        case p.If(branches=branches, otherwise=otherwise):
            made = tuple(replace(b, body=inside(b.body)) for b in branches)
            yield replace(node, branches=made, otherwise=inside(otherwise))
        case p.While(body=body) | p.For(body=body):
            yield replace(node, body=inside(body))
        case p.Switch():
            if (selects and not context.dialect.nested_select) or not _selectable(node):
                yield from _statement(context, _as_if(node), entry, selects)
                return
            cases = tuple(replace(c, body=inside(c.body, 1)) for c in node.cases)
            yield replace(node, cases=cases, otherwise=inside(node.otherwise, 1))
        case p.Comment(text=text):
            for line in comment_lines(text):
                yield replace(node, text=line)
        case p.Message(parts=parts):
            text = "".join(q.value if isinstance(q, e.Text) else "..." for q in parts)
            line = next(iter(comment_lines("message: " + text)))
            context.findings.append(rules.MESSAGE(text=line))
            yield p.Comment(line)
        case p.Return(value=None) if entry:
            yield p.Stop(end=True)
        case _:
            yield node


def _selectable(node: p.Switch) -> bool:
    """Whether each case is one number, all that `Case` can say."""
    return bool(node.cases) and all(
        len(c.values) == 1 and isinstance(c.values[0], e.Number) for c in node.cases
    )


def _as_if(node: p.Switch) -> p.If:
    branches = []
    for case in node.cases:
        tests: list[e.Expression] = [e.Binary("=", node.subject, v) for v in case.values]
        condition = tests[0]
        for test in tests[1:]:
            condition = e.Binary("or", condition, test)
        branches.append(p.Branch(condition, case.body))
    return p.If(tuple(branches), node.otherwise)


def comment_lines(text: str) -> list[str]:
    """A comment in lines that fit a step; control characters become blanks."""
    plain = "".join(c if c.isprintable() else " " for c in text).strip()
    lines: list[str] = []
    while len(plain.encode("utf-8")) > MOST_COMMENT:
        most = MOST_COMMENT
        while len(plain[:most].encode("utf-8")) > MOST_COMMENT:
            most -= 1
        cut = plain.rfind(" ", most // 2, most)
        cut = most if cut < 0 else cut
        lines.append(plain[:cut].strip())
        plain = plain[cut:].strip()
    return [*lines, plain]


def _calls(program: Program) -> tuple[Procedure, ...]:
    """Calls say the unit of what they call, if that is another one."""

    def called_from(unit: str | None) -> Callable[[p.Call], p.Call]:
        def call(node: p.Call) -> p.Call:
            callee = program.procedure(node.procedure)
            if callee is None:
                return node
            other = None if callee.unit == unit else callee.unit
            return replace(node, procedure=callee.name, unit=other)

        return call

    return tuple(
        replace(q, body=mapped(q.body, p.Call, called_from(q.unit))) for q in program.procedures
    )


def mapped(
    body: tuple[p.Statement, ...], kind: type, change: Callable[[Any], p.Statement]
) -> tuple[p.Statement, ...]:
    """The body with every statement of a kind changed, nested ones too."""

    def one(node: p.Statement) -> p.Statement:
        if isinstance(node, kind):
            return change(node)
        match node:
            case p.If(branches=branches, otherwise=otherwise):
                made = tuple(replace(b, body=mapped(b.body, kind, change)) for b in branches)
                return replace(node, branches=made, otherwise=mapped(otherwise, kind, change))
            case p.While(body=inner) | p.For(body=inner):
                return replace(node, body=mapped(inner, kind, change))
            case p.Switch(cases=cases, otherwise=otherwise):
                cases = tuple(replace(c, body=mapped(c.body, kind, change)) for c in cases)
                return replace(node, cases=cases, otherwise=mapped(otherwise, kind, change))
        return node

    return tuple(one(node) for node in body)


def _shared(program: Program) -> Iterable[Diagnostic]:
    """Variables that several programs use, which each of them would have for itself."""
    from assistant.languages.melfa_basic.lower.statements import mentioned

    units: dict[str | None, set[str]] = {}
    for procedure in program.procedures:
        if procedure.unit is not None:
            units.setdefault(procedure.unit, set()).update(mentioned(procedure.body))
    for name, variable in program.variables.items():
        if variable.storage != "constant" and any(name.lower() in w for w in units.values()):
            yield rules.LOCAL_DATA(name=name, place=name)
