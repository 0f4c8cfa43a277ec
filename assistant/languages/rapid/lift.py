"""From the typed tree to the pseudo-program; what that has no word for stays verbatim."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid import syntax as s
from assistant.languages.rapid import verbatim
from assistant.languages.rapid.gather import literal_number, plain_move
from assistant.languages.rapid.header import Header, opening
from assistant.languages.rapid.lift_data import DataLift, is_module_data
from assistant.languages.rapid.lift_expressions import LANGUAGE
from assistant.languages.rapid.lift_expressions import lift as lift_expression
from assistant.languages.rapid.lift_paths import PathLift
from assistant.languages.rapid.loops import apart, ascends
from assistant.languages.rapid.messages import with_values
from assistant.languages.rapid.motions import speed_name, zone_name
from assistant.languages.rapid.sequences import with_paths
from assistant.languages.rapid.standard import INSTRUCTIONS, OF_OPTIONS
from assistant.languages.rapid.tables import (
    GRIPPER_SIGNAL,
    GRIPPER_VALUE,
    LOADED_FROM,
    SPEED_CAP,
    SPEEDS,
    VALUE_OF_TYPE,
    ZONES,
)
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Refused, Span
from assistant.program.geometry import BASE, FLANGE
from assistant.program.motion import Blend, Speed
from assistant.program.program import (
    Declaration,
    Parameter,
    Procedure,
    Program,
    Signal,
    Variable,
    walk,
)

_HAND: Final = re.compile(GRIPPER_SIGNAL.format(hand="([1-9][0-9]?)"), re.IGNORECASE)
_ACTION: Final = {value: action for action, value in GRIPPER_VALUE.items()}
_STANDARD: Final = INSTRUCTIONS | OF_OPTIONS


def lift(files: Sequence[s.File]) -> Program:
    """The program that the modules of these files say together."""
    return _Lift([m for file in files for m in file.modules]).program()


def statements_of(text: str, program: Program) -> tuple[p.Statement, ...]:
    """Statements of RAPID in a program; an Opaque that is no RAPID comes back as it is."""
    try:
        read = verbatim.statements(text)
    except Refused:
        return (p.Opaque(LANGUAGE, text),)  # a finding when it is built
    if any(isinstance(n, s.Data | s.TargetRunNode) for n in read):
        return (p.Opaque(LANGUAGE, text),)
    inner = _Lift([])
    inner.procedures = {q.name.lower() for q in program.procedures}
    return tuple(inner.body(read))


def gripper(signal: str, value: e.Expression) -> p.Gripper | None:
    """The hand that setting a signal opens or closes, if it is one of a hand."""
    match = _HAND.fullmatch(signal)
    if match is None or not isinstance(value, e.Number) or value.value not in _ACTION:
        return None
    return p.Gripper(_ACTION[int(value.value)], int(match[1]))  # type: ignore[arg-type]


class _Lift:
    def __init__(self, modules: list[s.Module]) -> None:
        self.modules = modules
        self.headers = [opening(m) for m in modules]
        main = next((i for i, h in enumerate(self.headers) if not h.unit), 0)
        self.main = main
        self.names: dict[str, str] = {}
        for header in self.headers:
            self.names.update(header.names)
        self.procedures = {
            i.name.lower() for m in modules for i in m.items if isinstance(i, s.Routine)
        }
        self.data = DataLift(modules, self.original)
        self.paths = PathLift(modules, self.data, self.original)

        self.noted: dict[str, Signal] = {}
        self.signals = {self.original(n): v for h in self.headers for n, v in h.signals.items()}

    def note(self, name: str, signal: Signal) -> None:
        """How an instruction uses a signal; the first use counts."""
        if name.lower() not in {n.lower() for n in self.noted}:
            self.noted[name] = signal

    def declared(self, name: str) -> bool:
        return name.lower() in {n.lower() for n in self.signals}

    def original(self, name: str) -> str:
        return self.names.get(name.lower(), name)

    def program(self) -> Program:
        if not self.modules:
            return Program("empty", entry=None)
        header = self.headers[self.main]
        name = header.program or self.original(self.modules[self.main].name)
        procedures: list[Procedure] = []
        declarations: list[Declaration] = []
        comments = list(header.comments)
        for number, module in enumerate(self.modules):
            own = self.headers[number]
            unit = self.original(module.name) if own.unit else None
            skip = len(own.comments) + own_items(own)
            pending: list[str] = []
            for item in module.items[skip:]:
                match item:
                    case s.CommentLine(text):
                        pending.append(text)
                        continue
                    case s.Routine():
                        notes, pending = pending, []
                        lifted = self.routine(item, unit, notes)
                        if isinstance(lifted, Procedure):
                            procedures.append(lifted)
                        else:
                            comments += notes
                            declarations.append(lifted)
                    case s.Data() if is_module_data(item) and self.data.holds(item):
                        pass
                    case s.TargetRunNode():
                        pass
                    case _:
                        declarations.append(Declaration(LANGUAGE, verbatim.of_item(item)))
                comments += pending
                pending = []
            comments += pending
        entry = header.entry or ("main" if "main" in self.procedures else None)
        entry = next(
            (q.name for q in procedures if entry and q.name.lower() == entry.lower()), None
        )
        targets, joint_targets = self.paths.targets(), self.data.joint_targets
        program = Program(
            name,
            tuple(procedures),
            entry,
            header.robot,
            tuple(comments),
            self.data.frames,
            self.data.tools,
            self.data.named_speeds(),
            self.data.named_blends(),
            {},
            targets,
            joint_targets,
            self.data.variables,
            tuple(declarations),
        )
        signals = dict(self.signals)
        signals |= {n: v for n, v in self.noted.items() if not self.declared(n)}
        program = apart(replace(program, signals=_inferred(program, signals)))
        program = with_values(program)
        return with_paths(program, self.original)

    # Routines

    def routine(
        self, node: s.Routine, unit: str | None, notes: Sequence[str]
    ) -> Procedure | Declaration:
        """A procedure, or the whole text if the pseudo-program cannot say what it is."""
        parameters: list[Parameter] = []
        sayable = node.kind != "TRAP"
        for group in node.parameters:
            for q in group.alternatives:
                if (
                    isinstance(q, s.Placeholder)
                    or group.optional
                    or q.dimensions
                    or q.type.lower() not in VALUE_OF_TYPE
                ):
                    sayable = False
                    continue
                mode: Any = "inout" if q.mode else "in"
                type = VALUE_OF_TYPE[q.type.lower()]
                parameters.append(Parameter(self.original(q.name), type, mode))
        if node.kind == "FUNC" and node.type.lower() not in VALUE_OF_TYPE:
            sayable = False
        variables: dict[str, Variable] = {}
        rest: list[s.StatementNode] = []
        foreign: list[p.Opaque] = []
        for inner in node.body:
            if isinstance(inner, s.Data):
                variable = self.data.variable(inner)
                if variable is None:
                    foreign.append(self.opaque(inner))
                else:
                    variables[self.original(inner.name)] = replace(variable, local=False)
            elif isinstance(inner, s.TargetRunNode):
                sayable = False
            else:
                rest.append(inner)
        if not sayable:
            return Declaration(LANGUAGE, verbatim.of_item(node))
        return Procedure(
            self.original(node.name),
            (
                *(p.Comment(n) for n in notes),
                *foreign,
                *self.body(rest),
                *(p.Opaque(LANGUAGE, verbatim.of_handler(h), span=h.span) for h in node.handlers),
            ),
            tuple(parameters),
            variables,
            VALUE_OF_TYPE[node.type.lower()] if node.kind == "FUNC" else None,
            unit,
            node.local,
        )

    def body(self, nodes: Sequence[s.StatementNode]) -> Iterator[p.Statement]:
        at = 0
        while at < len(nodes):
            loaded = self.loaded_call(nodes[at : at + 3])
            if loaded is not None:
                yield loaded
                at += 3
                continue
            yield from self.statement(nodes[at])
            at += 1

    def block(self, nodes: Sequence[s.StatementNode] | None) -> tuple[p.Statement, ...]:
        return tuple(self.body(nodes or ()))

    def loaded_call(self, nodes: Sequence[s.StatementNode]) -> p.Call | None:
        r"""`Load \Dynamic, "HOME:/u.mod"; %"name"% …; UnLoad "HOME:/u.mod";` as one call."""
        if len(nodes) != 3 or not all(isinstance(n, s.ProcedureCall) for n in nodes):
            return None
        load, call, unload = nodes
        assert isinstance(load, s.ProcedureCall)
        assert isinstance(call, s.ProcedureCall)
        assert isinstance(unload, s.ProcedureCall)
        if (str(load.name).lower(), str(unload.name).lower()) != ("load", "unload"):
            return None
        match load.arguments, unload.arguments, call.name:
            case (
                (s.Option(option, None), s.Positional(s.StringLiteral(file), None)),
                (s.Positional(s.StringLiteral(same), None),),
                s.StringLiteral(name),
            ) if file == same and option.lower() == "dynamic":
                plain = _plain(call)
                module = file.removeprefix(LOADED_FROM).removesuffix(".mod")
                if plain is None or LOADED_FROM + module + ".mod" != file:
                    return None
                if not re.fullmatch(r"[A-Za-z]\w*", module) or not re.fullmatch(
                    r"[A-Za-z]\w*", name
                ):
                    return None
                given = tuple(self.expression(a) for a in plain)
                unit = self.original(module)
                return p.Call(self.original(name), given, unit, span=_over(load, unload))
        return None

    def expression(self, node: s.Expression) -> e.Expression:
        return lift_expression(node, self.original)

    def statement(self, node: s.StatementNode) -> Iterator[p.Statement]:
        span = node.span
        match node:
            case s.CommentLine(text):
                yield p.Comment(text, span=span)
            case s.MoveRunNode():
                yield from self.paths.statements(node, self.motion)
            case s.Assignment(target, value) if not isinstance(target, s.Placeholder):
                yield p.Assign(self.expression(target), self.expression(value), span=span)
            case s.GotoLabel(label):
                yield p.Goto(self.original(label), span=span)
            case s.LabelMark(name):
                yield p.Label(self.original(name), span=span)
            case s.ReturnFrom(value):
                yield p.Return(None if value is None else self.expression(value), span=span)
            case s.Word("EXIT"):
                yield p.Stop(end=True, span=span)
            case s.IfThen(branches, otherwise) if all(b.condition is not None for b in branches):
                lifted = [
                    p.Branch(self.expression(b.condition), self.block(b.body))
                    for b in branches
                    if b.condition is not None
                ]
                yield p.If(tuple(lifted), self.block(otherwise), span=span)
            case s.CompactIf(condition, inner):
                body = tuple(self.statement(inner))
                yield p.If((p.Branch(self.expression(condition), body),), span=span)
            case s.ForLoop(variable, first, last, step, inner):
                bounds = self.expression(first), self.expression(last)
                upwards = {True: p.ONE, False: e.Number(-1), None: None}[ascends(*bounds)]
                by = upwards if step is None else self.expression(step)
                yield p.For(self.original(variable), *bounds, self.block(inner), by, span=span)
            case s.WhileLoop(condition, inner):
                yield p.While(self.expression(condition), self.block(inner), span=span)
            case s.TestOf(subject, cases, otherwise) if all(c.values for c in cases):
                chosen = tuple(
                    p.Case(tuple(map(self.expression, c.values)), self.block(c.body)) for c in cases
                )
                yield p.Switch(self.expression(subject), chosen, self.block(otherwise), span=span)
            case s.ProcedureCall(name=str()):
                yield replace(self.call(node), span=span)
            case _:
                yield self.opaque(node)

    def opaque(self, node: s.StatementNode) -> p.Opaque:
        return p.Opaque(LANGUAGE, verbatim.of_statement(node), span=node.span)

    # Instructions

    def call(self, node: s.ProcedureCall) -> p.Statement:
        name = str(node.name).lower()
        if name in self.procedures:
            return self.own_call(node)
        known = INSTRUCTION.get(name)
        if known is not None:
            return known(self, node) or self.opaque(node)
        return self.opaque(node) if name in _STANDARD else self.own_call(node)

    def own_call(self, node: s.ProcedureCall) -> p.Statement:
        plain = _plain(node)
        if plain is None:
            return self.opaque(node)
        given = tuple(self.expression(a) for a in plain)
        return p.Call(self.original(str(node.name)), given)

    def motion(self, speed: str, zone: str, tool: str, frame: str) -> p.Motion:
        return p.Motion(
            self.speed(speed),
            self.blend(zone),
            FLANGE if tool.lower() == FLANGE else self.original(tool),
            BASE if frame.lower() in ("", "wobj0") else self.original(frame),
        )

    def speed(self, name: str) -> Speed | e.Name:
        value = self.data.speeds.get(name.lower())
        if value is not None:
            return value if name.lower() == speed_name(value) else e.Name(self.original(name))
        return SPEEDS.get(name.lower(), e.Name(self.original(name)))

    def blend(self, name: str) -> Blend | e.Name:
        value = self.data.blends.get(name.lower())
        if value is not None:
            return value if name.lower() == zone_name(value) else e.Name(self.original(name))
        return ZONES.get(name.lower(), e.Name(self.original(name)))

    def moved(
        self, node: s.ProcedureCall, points: int
    ) -> tuple[list[e.Expression], p.Motion] | None:
        plain = _plain(node, "wobj")
        if plain is None or len(plain) != points + 3:
            return None
        names = [n.name for n in plain[points:] if isinstance(n, s.NameRef)]
        frame = _option(node, "wobj")
        if len(names) != 3 or not (frame is None or isinstance(frame, s.NameRef)):
            return None
        named = frame.name if isinstance(frame, s.NameRef) else ""
        motion = self.motion(names[0], names[1], names[2], named)
        return [self.expression(n) for n in plain[:points]], motion


def own_items(header: Header) -> int:
    """How many lines of the header are items."""
    one = (header.program, header.robot, header.entry, header.unit)
    return sum(1 for x in one if x) + len(header.signals) + len(header.names)


def _inferred(program: Program, signals: dict[str, Signal]) -> dict[str, Signal]:
    """The signals of the header, and those that statements use as they use them."""
    known = {n.lower() for n in signals}
    for statement in program.statements():
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


def _plain(node: s.ProcedureCall, *options: str) -> list[s.Expression] | None:
    """The positional arguments, None if there are others than those and the options."""
    plain = []
    for argument in node.arguments:
        match argument:
            case s.Positional(value, None):
                plain.append(value)
            case s.Option(name) if name.lower() in options:
                pass
            case _:
                return None
    return plain


def _option(node: s.ProcedureCall, name: str) -> s.Expression | None:
    for argument in node.arguments:
        if isinstance(argument, s.Option) and argument.name.lower() == name:
            return argument.value
    return None


def _over(first: s.Node, last: s.Node) -> Span | None:
    return Span(first.span.start, last.span.end) if first.span and last.span else None


def _move(kind: Any) -> Any:
    def lifted(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
        moved = a.moved(node, 1)
        return None if moved is None else p.Move(kind, moved[0][0], moved[1])

    return lifted


def _circular(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    moved = a.moved(node, 2)
    return None if moved is None else p.MoveCircular(moved[0][0], moved[0][1], moved[1])


def _joints(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    moved = a.moved(node, 1)
    return None if moved is None else p.MoveJoints(moved[0][0], moved[1])


def _wait(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    plain = _plain(node)
    return p.Wait(a.expression(plain[0])) if plain and len(plain) == 1 else None


def _timeout(a: _Lift, node: s.ProcedureCall) -> e.Expression | None:
    value = _option(node, "maxtime")
    return None if value is None else a.expression(value)


def _wait_signal(kind: Any, direction: Any) -> Any:
    def lifted(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
        plain = _plain(node, "maxtime")
        if plain is None or len(plain) != 2 or not isinstance(plain[0], s.NameRef):
            return None
        name = a.original(plain[0].name)
        a.note(name, Signal(kind, direction))
        return p.WaitSignal(name, a.expression(plain[1]), _timeout(a, node))

    return lifted


def _wait_until(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    plain = _plain(node, "maxtime")
    if plain is None or len(plain) != 1:
        return None
    return p.WaitUntil(a.expression(plain[0]), _timeout(a, node))


def _set(kind: Any) -> Any:
    def lifted(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
        plain = _plain(node)
        if plain is None or len(plain) != 2 or not isinstance(plain[0], s.NameRef):
            return None
        name, value = a.original(plain[0].name), a.expression(plain[1])
        if kind == "digital" and (hand := gripper(name, value)):
            return hand
        a.note(name, Signal(kind, "output"))
        return p.SetSignal(name, value)

    return lifted


def _set_to(value: int) -> Any:
    def lifted(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
        plain = _plain(node)
        if plain is None or len(plain) != 1 or not isinstance(plain[0], s.NameRef):
            return None
        name = a.original(plain[0].name)
        return gripper(name, e.Number(value)) or p.SetSignal(name, e.Number(value))

    return lifted


def _pulse(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    plain = _plain(node, "high", "plength")
    high = any(isinstance(x, s.Option) and x.name.lower() == "high" for x in node.arguments)
    if plain is None or len(plain) != 1 or not isinstance(plain[0], s.NameRef) or not high:
        return None
    length = _option(node, "plength")
    seconds = e.Number(0.2) if length is None else a.expression(length)
    return p.SetSignal(a.original(plain[0].name), e.Number(1), seconds)


def _acceleration(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    plain = _plain(node)
    if plain is None or len(plain) != 2 or literal_number(plain[1]) != 100:
        return None
    percent = a.expression(plain[0])
    return p.SetAcceleration(percent, percent)


def _override(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    plain = _plain(node)
    if plain is None or len(plain) != 2 or literal_number(plain[1]) != SPEED_CAP:
        return None
    return p.SetOverride(a.expression(plain[0]))


def _stop(_: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    return None if node.arguments else p.Stop()


def _message(a: _Lift, node: s.ProcedureCall) -> p.Statement | None:
    plain = _plain(node, "num")
    if plain is None or len(plain) != 1:
        return None
    parts: list[e.Expression] = []
    pending = [plain[0]]
    while pending:
        part = pending.pop()
        if isinstance(part, s.Infix) and part.operator == "+":
            pending += [part.right, part.left]
            continue
        parts.append(a.expression(part))
    value = _option(node, "num")
    return p.Message(
        (*parts, *(() if value is None else (e.Apply("text", (a.expression(value),)),)))
    )


INSTRUCTION: Final[dict[str, Any]] = {
    "movej": _move("joint"),
    "movel": _move("linear"),
    "movec": _circular,
    "moveabsj": _joints,
    "waittime": _wait,
    "waitdi": _wait_signal("digital", "input"),
    "waitdo": _wait_signal("digital", "output"),
    "waitgi": _wait_signal("group", "input"),
    "waitgo": _wait_signal("group", "output"),
    "waituntil": _wait_until,
    "setdo": _set("digital"),
    "setao": _set("analog"),
    "setgo": _set("group"),
    "set": _set_to(1),
    "reset": _set_to(0),
    "pulsedo": _pulse,
    "accset": _acceleration,
    "velset": _override,
    "stop": _stop,
    "tpwrite": _message,
}
"""Instructions that the pseudo-program has a statement for; None from one: not in this form."""

__all__ = ["gripper", "lift", "plain_move", "statements_of", "walk"]
