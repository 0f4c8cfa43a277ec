"""A pseudo-program as RAPID can say it: what is rewritten, and a finding for each change."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final, Literal, TypeVar

import numpy as np

from assistant.languages.language import Adapted
from assistant.languages.rapid import rules, verbatim
from assistant.languages.rapid.lift_expressions import aggregate, lift, negative
from assistant.languages.rapid.lift_statements import statements_of
from assistant.languages.rapid.loops import counted
from assistant.languages.rapid.lower import build
from assistant.languages.rapid.lower_data import SIZES_PLACES
from assistant.languages.rapid.messages import Kinds, kinds, parts
from assistant.languages.rapid.motions import sayable_blend, sayable_speed, speed_name, zone_name
from assistant.languages.rapid.naming import naming, units
from assistant.languages.rapid.runs import JOINT_PLACES, POSITION_PLACES, QUATERNION_PLACES
from assistant.languages.rapid.sequences import with_paths
from assistant.languages.rapid.signals import gripper
from assistant.languages.rapid.tables import (
    LEAST_ACCELERATION,
    LEAST_CENTRE,
    LEAST_MASS,
    LONGEST_NAME,
    LONGEST_STRING,
    MOST_TARGETS,
    SPEEDS,
    UNUSED,
    ZONES,
)
from assistant.program import expressions as e
from assistant.program import rotations
from assistant.program import statements as p
from assistant.program.diagnostics import Diagnostic, Refused, fold, has_errors
from assistant.program.geometry import (
    BASE,
    FLANGE,
    Configuration,
    Frame,
    JointTarget,
    Load,
    Pose,
    Target,
    Tool,
)
from assistant.program.motion import Blend, Speed
from assistant.program.path import UNSTATED, Kind, Path
from assistant.program.program import Procedure, Program, Signal, Variable, identifier, walk
from assistant.program.rewriting import map_bodies, map_expressions, map_head


def adapt(program: Program, most_targets: int | None = None) -> Adapted:
    """most_targets: of one module, None for MOST_TARGETS."""
    adapter = _Adapter(program)
    try:
        adapted, loops = counted(adapter.program())
        adapter.findings += loops
        adapted = with_paths(adapted)
        most = max(most_targets or MOST_TARGETS, LEAST_PIECE)
        adapted = adapter.split(adapted, most)
        adapter.name_findings(adapted)
        if not has_errors(adapter.findings):
            adapter.sayable(adapted)
    except Refused as refused:
        adapter.findings += refused.findings
        adapted = program
    return Adapted(adapted, fold(adapter.findings))


T = TypeVar("T")


class _Adapter:
    def __init__(self, program: Program) -> None:
        self.given = program
        self.findings: list[Diagnostic] = []
        self.speeds: dict[str, Speed] = {}
        self.blends: dict[str, Blend] = {}
        self.extra: dict[str, Target] = {}
        self.known: Kinds = {}

    def changed(self, what: str, instead: str, hint: str, place: str | None = None) -> None:
        self.findings.append(rules.CHANGED(what=what, instead=instead, hint=hint, place=place))

    def cannot(self, what: str, hint: str, place: str | None = None) -> None:
        self.findings.append(rules.NO_MEANING(what=what, hint=hint, place=place))

    def program(self) -> Program:
        given = self.given
        self.speeds = {n: self.speed(v, n) for n, v in given.speeds.items()}
        self.blends = {n: self.blend(v, n) for n, v in given.blends.items()}
        targets = {n: self.target(t, n) for n, t in given.targets.items()}
        joints = {n: self.joints(t, n) for n, t in given.joint_targets.items()}
        variables = {n: self.variable(v, n) for n, v in given.variables.items()}
        for name, variable in list(variables.items()):
            fixed = variable.storage == "constant" and not (variable.size or variable.local)
            if fixed and isinstance(variable.initial, e.TargetValue):
                targets[name] = variable.initial.target
                del variables[name]
            elif fixed and isinstance(variable.initial, e.JointValue):
                joints[name] = variable.initial.target
                del variables[name]
        procedures = tuple(self.procedure(q) for q in given.procedures)
        # A named one that is called as its own value would be is that value.
        named_speeds = {n: v for n, v in self.speeds.items() if n.lower() != speed_name(v)}
        named_blends = {n: v for n, v in self.blends.items() if n.lower() != zone_name(v)}
        entry = given.entry
        if entry is not None and given.procedure(entry) is None:
            entry = None
        return replace(
            given,
            entry=entry,
            comments=tuple(self.line(c) for c in given.comments),
            frames={n: self.frame(f) for n, f in given.frames.items() if n.lower() != BASE},
            tools={n: self.tool(t, n) for n, t in given.tools.items() if n.lower() != FLANGE},
            speeds=named_speeds,
            blends=named_blends,
            signals=self.signals(procedures),
            targets={**targets, **self.extra},
            joint_targets=joints,
            variables=variables,
            procedures=procedures,
        )

    # Data

    def pose(self, pose: Pose) -> Pose:
        quaternion = np.array(pose.quaternion)
        if not np.isfinite(quaternion).all() or np.linalg.norm(quaternion) < 0.5:
            self.findings.append(rules.NOT_FINITE(what="an orientation"))
            return pose
        return Pose.of(np.array(pose.position), rotations.canonical(quaternion))

    def tool(self, tool: Tool, name: str) -> Tool:
        load = tool.load
        if load is None:
            self.findings.append(rules.NO_LOAD(name=name, place=name))
            load = Load(LEAST_MASS, LEAST_CENTRE)
        if load.mass < LEAST_MASS:
            self.changed(
                f"the mass of tool `{name}`", f"{LEAST_MASS} kg", "state the tool's mass", name
            )
            load = replace(load, mass=LEAST_MASS)
        if not any(load.centre):
            self.changed(
                f"the centre of gravity of tool `{name}`, which is none",
                "0.001 mm before the flange",
                "state the tool's centre of gravity",
                name,
            )
            load = replace(load, centre=LEAST_CENTRE)
        return replace(tool, tip=self.pose(tool.tip), load=_printed(load))

    def frame(self, frame: Frame) -> Frame:
        return replace(frame, user=self.pose(frame.user), object=self.pose(frame.object))

    def target(self, target: Target, place: str) -> Target:
        configuration = target.configuration
        if configuration is None:
            self.findings.append(rules.NO_CONFIGURATION(place=place))
            configuration = Configuration()
        return Target(self.pose(target.pose), configuration, _axes(target.external))

    def joints(self, target: JointTarget, place: str) -> JointTarget:
        joints = target.joints
        if len(joints) > 6:
            self.cannot(f"{len(joints)} joints", "use six; further axes are external", place)
        if len(joints) < 6 or any(j != j for j in joints):
            self.changed("a joint that is not stated", "0 degrees", "state every joint", place)
            joints = tuple(0.0 if j != j else j for j in joints) + (0.0,) * (6 - len(joints))
        joints = tuple(round(j, JOINT_PLACES) + 0.0 for j in joints)
        return JointTarget(joints, _axes(target.external))

    def variable(self, variable: Variable, name: str) -> Variable:
        if variable.type == "integer":
            variable = replace(variable, type="number")
        if variable.storage == "constant" and variable.initial is None:
            self.cannot(f"the constant `{name}` without a value", "give it one", name)
        return replace(variable, initial=self.expressions(variable.initial))

    def signals(self, procedures: tuple[Procedure, ...]) -> dict[str, Signal]:
        """The declared ones, and those that statements use as they use them."""
        signals = dict(self.given.signals)
        known = {n.lower() for n in signals}
        for procedure in procedures:
            for statement in walk(procedure.body):
                match statement:
                    case p.SetSignal(name):
                        signal = Signal("digital", "output")
                    case p.WaitSignal(name):
                        signal = Signal("digital", "input")
                    case _:
                        continue
                if name.lower() not in known:
                    known.add(name.lower())
                    signals[name] = signal
        return signals

    def speed(self, speed: Speed, place: str | None = None) -> Speed:
        said, changed = sayable_speed(speed)
        if changed:
            self.changed(changed, f"{speed_name(said)}", "state a speed in mm/s", place)
        if not all(v > 0 for v in (said.tcp, said.rotation)) or said.tcp != said.tcp:
            self.cannot(f"a speed of {said.tcp} mm/s", "state a speed above 0", place)
        return said

    def blend(self, blend: Blend, place: str | None = None) -> Blend:
        said, changed = sayable_blend(blend)
        if changed:
            self.changed(changed, f"{zone_name(said)}", "state one radius in mm", place)
        if said.radius is not None and not said.radius >= 0:
            self.cannot(f"a corner radius of {said.radius} mm", "state 0 or more", place)
        return said

    def any_speed(self, speed: Speed | e.Name) -> Speed | e.Name:
        if isinstance(speed, Speed):
            return self._named(self.speed(speed), self.speeds, speed_name, "speed")
        for name, value in self.speeds.items():
            if name.lower() == speed.name.lower():
                return value if name.lower() == speed_name(value) else speed
        return SPEEDS.get(speed.name.lower(), speed)

    def any_blend(self, blend: Blend | e.Name) -> Blend | e.Name:
        if isinstance(blend, Blend):
            return self._named(self.blend(blend), self.blends, zone_name, "blend")
        for name, value in self.blends.items():
            if name.lower() == blend.name.lower():
                return value if name.lower() == zone_name(value) else blend
        return ZONES.get(blend.name.lower(), blend)

    def _named(
        self, value: T, table: dict[str, T], name_of: Callable[[T], str], kind: str
    ) -> T | e.Name:
        """The value, or its name if its own would be too long."""
        if len(name_of(value)) <= LONGEST_NAME:
            return value
        for name, known in table.items():
            if known == value:
                return e.Name(name)
        name = identifier(f"{kind}_1", {*table})
        table[name] = value
        return e.Name(name)

    def motion(self, motion: p.Motion) -> p.Motion:
        speed, blend = self.any_speed(motion.speed), self.any_blend(motion.blend)
        frame = BASE if motion.frame.lower() == BASE else motion.frame
        tool = FLANGE if motion.tool.lower() == FLANGE else motion.tool
        return p.Motion(speed, blend, tool, frame)

    def path(self, path: Path) -> Path:
        via = path.kinds == Kind.VIA
        if (via[:-1] != (path.kinds[1:] == Kind.END)).any() or (
            len(path) and (via[-1] or path.kinds[0] == Kind.END)
        ):
            self.cannot(f"an arc of path `{path.name}` without its end", "give both points")
        bad = ~np.isfinite(path.positions).all(axis=1) | ~np.isfinite(path.quaternions).all(axis=1)
        bad |= ~(np.linalg.norm(path.quaternions, axis=1) > 0.5)
        if bad.any():
            row = int(np.flatnonzero(bad)[0]) + 1
            self.findings.append(
                rules.NOT_FINITE(what=f"target {row} of path `{path.name}`", place=path.name)
            )
            return path
        configurations = path.configurations
        unstated = configurations[:, 0] == UNSTATED
        if unstated.any():
            self.findings.append(
                rules.NO_CONFIGURATION(place=f"{int(unstated.sum())} targets of `{path.name}`")
            )
            configurations = np.where(unstated[:, None], np.int8(0), configurations)
        rows = np.arange(len(path)) + via  # an arc has the motion of its end
        rows = np.minimum(rows, len(path) - 1)
        external = np.array(path.external)
        np.round(external, JOINT_PLACES, out=external)
        external[external >= UNUSED] = np.nan
        return replace(
            path,
            quaternions=rotations.canonical(path.quaternions),
            configurations=configurations,
            external=external,
            speed=path.speed[rows],
            blend=path.blend[rows],
            tool=path.tool[rows],
            frame=path.frame[rows],
            speeds=tuple(self.any_speed(v) for v in path.speeds),
            blends=tuple(self.any_blend(v) for v in path.blends),
            tools=tuple(FLANGE if t.lower() == FLANGE else t for t in path.tools),
            frames=tuple(BASE if f.lower() == BASE else f for f in path.frames),
        )

    # Texts and expressions

    def line(self, text: str) -> str:
        """One line of ASCII."""
        letters = (c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
        plain = "".join(letters).encode("ascii", "replace").decode("ascii")
        plain = "".join(c if c.isprintable() else " " for c in plain).strip()
        if plain != text.strip():
            self.changed("a comment", f"`{plain[:40]}`", "use one line of ASCII")
        return plain

    def expressions(self, node: Any) -> Any:
        return map_expressions(node, self.expression)

    def expression(self, x: e.Expression) -> e.Expression:
        """An expression in the form that its text is read back as."""
        match x:
            case e.Unary("-", operand):
                return negative(operand)
            case e.Number(value) if value == 0:
                return e.Number(0)
            case e.Aggregate(items):
                made = aggregate(items)
                return x if isinstance(made, e.Aggregate) else self.expression(made)
            case e.TargetValue(target):
                return e.TargetValue(self.target(target, "a written out target"))
            case e.JointValue(target):
                return e.JointValue(self.joints(target, "a written out joint target"))
            case e.PoseValue(pose):
                return e.PoseValue(self.pose(pose))
            case e.Apply("relative", given) if 4 < len(given) < 7:
                return e.Apply("relative", given + (e.Number(0),) * (7 - len(given)))
            case e.Verbatim("rapid", text):
                return self.verbatim(text)
        return x

    def verbatim(self, text: str) -> e.Expression:
        try:
            return lift(verbatim.expression(text), lambda name: name)
        except Refused:
            return e.Verbatim("rapid", text)  # a finding when it is built

    # Statements

    def procedure(self, procedure: Procedure) -> Procedure:
        self.known = kinds(self.given, procedure)
        variables = {n: self.variable(v, n) for n, v in procedure.variables.items()}
        for name, variable in variables.items():
            if variable.storage == "persistent":
                self.cannot(f"the persistent `{name}` inside a procedure", "declare it outside")
            if variable.local:
                variables[name] = replace(variable, local=False)
        parameters = tuple(
            replace(q, type="number") if q.type == "integer" else q for q in procedure.parameters
        )
        result = "number" if procedure.result == "integer" else procedure.result
        return replace(
            procedure,
            body=self.body(procedure.body),
            variables=variables,
            parameters=parameters,
            result=result,
        )

    def body(self, body: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
        out: list[p.Statement] = []
        for statement in body:
            change = CHANGES.get(type(statement))
            statement = map_head(map_bodies(statement, self.body), self.expression)
            out += [statement] if change is None else change(self, statement)
        return tuple(out)

    # Splitting

    def split(self, program: Program, most: int) -> Program:
        """Paths that fill a module over the limit, in modules of their own."""
        count: dict[str | None, int] = {None: len(program.targets)}
        for procedure in program.procedures:
            for statement in walk(procedure.body):
                if isinstance(statement, p.Follow) and len(statement.path) <= most:
                    count[procedure.unit] = count.get(procedure.unit, 0) + len(statement.path)
        taken = {q.name for q in program.procedures} | set(units(program)) | {program.name}
        taken |= {*program.targets, *program.variables, *program.signals, *program.tools}
        new: list[Procedure] = []

        def body(statements: tuple[p.Statement, ...], unit: str | None) -> tuple[p.Statement, ...]:
            out: list[p.Statement] = []
            for statement in statements:
                statement = map_bodies(statement, lambda b: body(b, unit))
                if not isinstance(statement, p.Follow) or (
                    len(statement.path) <= most and count[unit] <= most
                ):
                    out.append(statement)
                    continue
                if len(statement.path) <= most:
                    count[unit] -= len(statement.path)
                    if unit is not None and count[unit] == 0:
                        count[unit] += len(statement.path)
                        out.append(statement)
                        continue
                pieces = _pieces(statement.path, most)
                self.findings.append(
                    rules.SPLIT(
                        name=statement.path.name, count=len(statement.path), parts=len(pieces)
                    )
                )
                for number, piece in enumerate(pieces, 1):
                    name = statement.path.name[:20]
                    procedure = identifier(f"{name}_part{number}", taken)
                    module = identifier(f"{name}_unit{number}", taken | {procedure})
                    taken.update((procedure, module))
                    path = replace(piece, name=f"{procedure}_p")
                    new.append(Procedure(procedure, (p.Follow(path),), unit=module))
                    out.append(p.Call(procedure, (), module))
            return tuple(out)

        procedures = tuple(replace(q, body=body(q.body, q.unit)) for q in program.procedures)
        return replace(program, procedures=(*procedures, *new)) if new else program

    # Findings

    def name_findings(self, program: Program) -> None:
        for short, name in naming(program).changed:
            why = "it has more than 32 characters" if len(name) > LONGEST_NAME else "it is taken"
            self.findings.append(rules.SHORTENED(name=name, short=short, why=why, place=name))

    def sayable(self, program: Program) -> None:
        """A finding for each procedure or declaration that cannot be built."""
        empty = replace(program, procedures=())
        for tried in (empty, *(self._alone(program, q) for q in program.procedures)):
            try:
                for unit in (None, *units(tried)):
                    build(tried, unit)
            except Refused as refused:
                self.findings += refused.findings

    def _alone(self, program: Program, procedure: Procedure) -> Program:
        def few(body: tuple[p.Statement, ...]) -> tuple[p.Statement, ...]:
            return tuple(map_bodies(x, few) for x in body if not isinstance(x, p.Follow))

        one = replace(procedure, body=few(procedure.body))
        return Program(program.name, (one,), procedure.name, signals=program.signals)


LEAST_PIECE: Final = 5
"""Targets of a piece at least, whatever is asked for: room to cut between arcs."""


def _pieces(path: Path, most: int) -> list[Path]:
    pieces, start = [], 0
    most = max(most, LEAST_PIECE)
    while start < len(path):
        stop = min(start + most, len(path))
        if stop < len(path) and len(path) - stop < 2:
            stop -= 2  # a piece of one target would be no path
        if stop < len(path) and path.kinds[stop] == Kind.END:
            stop -= 1
        pieces.append(path.rows(start, stop))
        start = stop
    return pieces


def _axes(values: tuple[float, ...]) -> tuple[float, ...]:
    """External axes as they are printed, NaN for an unused one."""
    return tuple(float("nan") if v >= UNUSED else round(v, JOINT_PLACES) + 0.0 for v in values)


def _printed(load: Load) -> Load:
    """A load as it is printed."""
    x, y, z = (round(v, POSITION_PLACES) + 0.0 for v in load.centre)
    a, b, c, d = (round(v, QUATERNION_PLACES) + 0.0 for v in load.axes)
    i, j, k = (round(v, SIZES_PLACES) + 0.0 for v in load.inertia)
    return Load(round(load.mass, SIZES_PLACES), (x, y, z), (a, b, c, d), (i, j, k))


Changed = list[p.Statement]


def _motion(a: _Adapter, x: Any) -> Changed:
    return [replace(x, motion=a.motion(x.motion))]


def _follow(a: _Adapter, x: p.Follow) -> Changed:
    if not len(x.path):
        a.changed(f"the path `{x.path.name}`, which has no targets", "nothing", "leave it out")
        return []
    path = a.path(x.path)
    if len(path) > 1 or has_errors(a.findings):
        return [replace(x, path=path)]
    name = identifier(f"{path.name}_1", {*a.given.targets, *a.extra, *a.given.variables})
    a.extra[name] = path.target(0)
    kind: Literal["joint", "linear"] = "joint" if path.kinds[0] == Kind.JOINT else "linear"
    speed, blend = path.speeds[path.speed[0]], path.blends[path.blend[0]]
    motion = p.Motion(speed, blend, path.tools[path.tool[0]], path.frames[path.frame[0]])
    return [p.Move(kind, e.Name(name), motion, span=x.span)]


def _wait_signal(a: _Adapter, x: p.WaitSignal) -> Changed:
    value = _bit(x.value)
    kind = next((g.kind for n, g in a.given.signals.items() if n.lower() == x.signal.lower()), "")
    if kind == "analog":
        condition = e.Binary("=", e.Name(x.signal), value)
        return [p.WaitUntil(condition, x.timeout, span=x.span)]
    return [replace(x, value=value)]


def _bit(value: e.Expression) -> e.Expression:
    return e.Number(int(value.value)) if isinstance(value, e.Truth) else value


def _set_signal(_: _Adapter, x: p.SetSignal) -> Changed:
    value = _bit(x.value)
    hand = gripper(x.signal, value) if x.pulse is None else None
    if hand is not None:
        return [replace(hand, span=x.span)]
    return [replace(x, value=value)]


def _acceleration(a: _Adapter, x: p.SetAcceleration) -> Changed:
    one, two = x.acceleration, x.deceleration
    if isinstance(one, e.Number) and isinstance(two, e.Number):
        least = max(min(one.value, two.value), LEAST_ACCELERATION)
        if (least, least) != (one.value, two.value):
            a.changed(
                f"acceleration {one.value} and deceleration {two.value} percent",
                f"{least} percent for both",
                "AccSet has one value of 20 percent or more",
            )
        value: e.Expression = e.Number(least)
    else:
        if one != two:
            a.changed("the deceleration", "the acceleration", "AccSet has one value for both")
        value = one
    return [replace(x, acceleration=value, deceleration=value)]


def _comment(a: _Adapter, x: p.Comment) -> Changed:
    return [replace(x, text=a.line(x.text))]


def _message(a: _Adapter, x: p.Message) -> Changed:
    """As many messages as it takes for 80 characters each."""
    flat = parts(x, a.known) or (e.Text(""),)
    rows: list[list[e.Expression]] = [[]]
    room = LONGEST_STRING
    for part in flat:
        pieces: list[e.Expression] = [part]
        if isinstance(part, e.Text):
            size = LONGEST_STRING
            text = part.value
            pieces = [e.Text(text[i : i + size]) for i in range(0, len(text), size)] or [part]
        for piece in pieces:
            length = len(piece.value) if isinstance(piece, e.Text) else 10
            if rows[-1] and length > room:
                rows.append([])
                room = LONGEST_STRING
            rows[-1].append(piece)
            room -= length
    if len(rows) > 1:
        a.changed(
            "a message of more than 80 characters", f"{len(rows)} messages", "write a shorter one"
        )
    return [p.Message(tuple(row), span=x.span) for row in rows]


def _opaque(a: _Adapter, x: p.Opaque) -> Changed:
    if x.language != "rapid":
        a.findings.append(rules.OTHER_LANGUAGE(language=x.language, text=x.text[:60]))
        return [x]
    return list(statements_of(x.text, a.given))


CHANGES: Final[dict[type, Callable[[_Adapter, Any], Changed]]] = {
    p.Move: _motion,
    p.MoveCircular: _motion,
    p.MoveJoints: _motion,
    p.Follow: _follow,
    p.WaitSignal: _wait_signal,
    p.SetSignal: _set_signal,
    p.SetAcceleration: _acceleration,
    p.Comment: _comment,
    p.Message: _message,
    p.Opaque: _opaque,
}
