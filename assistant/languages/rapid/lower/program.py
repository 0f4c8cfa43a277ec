"""Lower the pseudo-program to the typed tree: modules, routines and statements.

Each unit becomes one module. A file that another language calls by its name becomes a separate
module, as it was a separate file there; the task loads all modules, and the call is a plain one.
Long programs, split into units for lack of room, are loaded when they are called.

Each statement is a row of `tables.equivalents` or has a function in `_STATEMENTS`. An output that a
move sets on its path becomes an instruction that sets up a triggdata, and a move that takes it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from assistant.base.diagnostics import Findings, Refused
from assistant.languages.patterns import Slot, Write
from assistant.languages.rapid import rules
from assistant.languages.rapid.lower.data import (
    blend_name_in,
    controller_data_nodes,
    data_nodes,
    frame_name_in,
    path_moves,
    path_targets,
    scope_of_paths,
    speed_name_in,
    variable_node,
)
from assistant.languages.rapid.lower.expressions import NAMES, Expressions, not_expressible
from assistant.languages.rapid.tables.constants import (
    LOADED_FROM,
    LONGEST_PULSE,
    SHORTEST_PULSE,
    TYPE_OF_VALUE,
)
from assistant.languages.rapid.tables.equivalents import (
    OR,
    STATEMENT_ROWS,
    SUM,
    TERM,
    usual_details,
)
from assistant.languages.rapid.tables.signals import (
    FURTHER_TRIGGERS,
    LONGEST_TRIGGER_TIME,
    MOST_TRIGGERS,
    TRIGG_EQUIP,
    TRIGG_IO,
    TRIGGER_MEASURES,
    TRIGGER_MOVES,
    TRIGGER_OUTPUTS,
    hand_signal,
)
from assistant.languages.rapid.text import verbatim
from assistant.languages.rapid.text.header import header_declaration, header_lines
from assistant.languages.rapid.tree import syntax as s
from assistant.languages.rapid.tree.literals import gathered
from assistant.languages.rapid.tree.walk import arguments
from assistant.languages.scoped_names import Naming, spelt
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.declared_types import is_value, known_types
from assistant.program.analysis.io_use import hands_used, with_used_signals
from assistant.program.motion import Blend, Speed
from assistant.program.passes.loops import ascends
from assistant.program.passes.operator_texts import message_parts
from assistant.program.program import Parameter, Procedure, Program, Signal, walk
from assistant.program.rewriting import records

_TARGET_TABLES: Final = ("targets", "joint_targets")
_DATA_TABLES: Final = (
    "tools", "frames", "speeds", "blends", "signals", "targets", "joint_targets", "variables",
)  # fmt: skip


def resident_units(program: Program) -> frozenset[str | None]:
    """The units that a task holds: those that the source in another language had."""
    origin = program.origin
    if origin is None or origin.language == verbatim.LANGUAGE:
        return frozenset()
    return frozenset(q.unit for q in origin.lifted.procedures) - {None}


def with_own_targets(program: Program, unit: str | None, held: Collection[str | None]) -> Program:
    """A program with the data of one module: of one beside the main one places that it alone uses.

    held: the units that are modules of the task.
    """
    if not held:
        return program
    users: dict[str, set[str | None]] = {}
    for procedure in program.procedures:
        home = procedure.unit if procedure.unit in held else None
        for part in records(procedure):
            if isinstance(part, e.Name):
                users.setdefault(part.name.lower(), set()).add(home)
    for part in records(tuple(program.variables.values())):
        if isinstance(part, e.Name):
            users.setdefault(part.name.lower(), set()).add(None)
    # Vendor declarations belong to the main module and may name any target there.
    texts = " ".join(one.text for one in program.declarations).lower()

    def home_of(name: str) -> str | None:
        found = users.get(name.lower(), {None})
        return next(iter(found)) if len(found) == 1 and name.lower() not in texts else None

    tables: dict[str, Any] = {}
    if unit is not None:
        tables = {table: {} for table in _DATA_TABLES} | {"procedures": ()}
    for table in _TARGET_TABLES:
        places = getattr(program, table)
        tables[table] = {n: place for n, place in places.items() if home_of(n) == unit}
    return replace(program, **tables)


_TRIGGER_MOVES: Final = {move.plain: move for move in TRIGGER_MOVES.values()}
_MEASURE_OPTIONS: Final = {measure: option for option, measure in TRIGGER_MEASURES.items()}
_OUTPUT_OPTIONS: Final[Mapping[str, str]] = {
    kind: option for option, kind in TRIGGER_OUTPUTS.items()
}
_SPELLED_OPTIONS: Final = {
    "start": "Start",
    "time": "Time",
    "dop": "DOp",
    "gop": "GOp",
    "aop": "AOp",
}


def with_triggers(
    move: s.ProcedureCall,
    triggers: tuple[p.Trigger, ...],
    names: Mapping[p.Trigger, str],
    set_up: Callable[[p.Trigger], Iterator[s.ProcedureCall]],
) -> Iterator[s.ProcedureCall]:
    """A plain move, as one that sets outputs; in front of it what sets up their data.

    names: of the variables. set_up: yields nothing for data that is set up before.
    """
    for what, cure in _untranslatable_triggers(str(move.name), triggers):
        raise not_expressible(what, cure)
    kind = _TRIGGER_MOVES[str(move.name)]
    variables = [s.NameRef(names[trigger]) for trigger in triggers]
    for trigger in triggers:
        yield from set_up(trigger)
    first, *others = variables
    more = (
        s.Option(name.upper(), one) for name, one in zip(FURTHER_TRIGGERS, others, strict=False)
    )
    # The first triggdata is positional, the further ones are options directly behind it.
    before, after = move.arguments[: kind.place], move.arguments[kind.place :]
    taking: tuple[s.Argument, ...] = (*before, s.Positional(first), *more, *after)
    yield replace(move, name=kind.word, arguments=taking)


def trigger_set_up(
    x: p.Trigger,
    variable: s.NameRef,
    signal: s.NameRef,
    kind: str,
    lower: Callable[[e.Expression], s.Expression],
) -> s.ProcedureCall:
    """Return the call that sets up the data of one output. kind: of the signal."""
    measure = _MEASURE_OPTIONS[x.measure]
    arguments: list[s.Argument] = [s.Positional(variable), s.Positional(lower(x.amount))]
    if measure:
        arguments.append(s.Option(_SPELLED_OPTIONS[measure]))
    if x.ahead is not None:
        arguments.append(s.Positional(lower(x.ahead)))
    arguments += (
        s.Option(_SPELLED_OPTIONS[_OUTPUT_OPTIONS[kind]], signal),
        s.Positional(lower(x.value)),
    )
    return s.ProcedureCall((TRIGG_IO if x.ahead is None else TRIGG_EQUIP).word, tuple(arguments))


def shared_triggers(program: Program) -> dict[p.Trigger, str]:
    """Outputs whose data several moves take and that is set up once: at the start of which
    procedure, in lower case.

    That is the one from which alone all these moves are reached, such as that of a layer. What is
    computed is set up anew before each move, as all is where vendor statements or interrupts may
    call procedures.
    """
    users: dict[p.Trigger, list[str]] = {}
    callers: dict[str, set[str]] = {}
    for procedure in program.procedures:
        key = procedure.name.lower()
        for node in walk(procedure.body):
            if isinstance(node, p.Opaque | p.Interrupt):
                return {}
            if isinstance(node, p.Call):
                callers.setdefault(node.procedure.lower(), set()).add(key)
            for trigger in node.triggers if isinstance(node, p.MoveStatement) else ():
                users.setdefault(trigger, []).append(key)
    entry = (program.entry or "").lower()

    def way_up(key: str) -> list[str]:
        way = [key]
        while key != entry and len(above := callers.get(key, set())) == 1:
            (key,) = above
            if key in way:
                break
            way.append(key)
        return way

    found: dict[p.Trigger, str] = {}
    for trigger, keys in users.items():
        numbers = (trigger.value, trigger.amount, trigger.ahead)
        computed = any(x is not None and e.plain_number(x) is None for x in numbers)
        if computed or len(keys) == 1:
            continue
        ways = [way_up(key) for key in dict.fromkeys(keys)]
        common = [key for key in ways[0] if all(key in way for way in ways)]
        if common:
            found[trigger] = common[0]
    return found


def _untranslatable_triggers(
    word: str, triggers: tuple[p.Trigger, ...]
) -> Iterator[tuple[str, str]]:
    """Yield the triggers without a RAPID instruction, each with its cure."""
    if word not in _TRIGGER_MOVES:
        yield (
            f"outputs on the way of a {word}",
            "move to a target, or set them before or after the move",
        )
    if len(triggers) > MOST_TRIGGERS:
        yield (
            f"more than {MOST_TRIGGERS} outputs on the way of one move",
            "divide the move, or set some before or after it",
        )
    for one in triggers:
        yield from _untranslatable_trigger(one)


def _untranslatable_trigger(x: p.Trigger) -> Iterator[tuple[str, str]]:
    name = f"`{x.signal}`"
    if x.pulse is not None:
        cure = "set it there, and set it back at another place of the way"
        yield f"a pulse of {name} on the way of a move", cure
    if x.measure == "share":
        cure = "give the place in mm, from the start or before the end"
        yield f"that {name} is set when a share of a way of unknown length is done", cure
    if x.measure == "time":
        if x.ahead is not None:
            cure = "give the sum of both times"
            yield f"a delay of what {name} sets beside a time before the end", cure
        if isinstance(x.amount, e.Number) and x.amount.value > LONGEST_TRIGGER_TIME:
            cure = "give a distance, or a shorter time"
            yield f"that {name} is set more than {LONGEST_TRIGGER_TIME:g} s before the end", cure


_Lowered = Iterator[s.StatementNode]


class BodyLowering:
    """Context for lowering the statements of one procedure.

    names: of the complete program. expressions: with the names visible in the procedure.
    set_up_before: outputs whose data is set up at the start of a procedure. findings: reasons for
    omitted statements.
    """

    def __init__(
        self,
        program: Program,
        names: Naming,
        procedure: Procedure,
        set_up_before: Collection[p.Trigger],
    ) -> None:
        self.set_up_before = set_up_before
        key = procedure.name.lower()
        self.names, self.labels = names, names.labels[key]
        self._inner, self._counters = names.inner[key], names.counters[key]
        self._counting: list[str] = []
        self.expressions = Expressions(names, self._value)
        self.lower = self.expressions.lower
        writers: dict[str, Write[s.Expression]] = {
            **self.expressions.writing.kinds,
            **dict.fromkeys(("signal", "digital", "analog", "group"), self.signal),
            "hand": lambda hand, _: s.NameRef(hand_signal(hand)),
            "speed": lambda speed, _: self._speed(speed),
            "blend": lambda blend, _: self._blend(blend),
            "other": lambda frame, _: s.NameRef(n) if (n := frame_name_in(names, frame)) else None,
        }
        self.writing = replace(self.expressions.writing, kinds=writers)
        self.known = known_types(program, procedure)
        self.signals = {n.lower(): g for n, g in program.signals.items()}
        self.resident = resident_units(program)
        self.findings = Findings()

    def statements(self, body: tuple[p.Statement, ...]) -> Iterator[s.StatementNode]:
        before: p.Statement | None = None
        for statement in body:
            # A comment stands at the end of the line of the statement before it, also if that was
            # refused.
            above, before = before, statement
            if isinstance(statement, p.Comment):
                yield s.CommentLine(statement.text, statement.stands_at_end_of(above))
                continue
            with self.findings.at(statement.span):
                try:
                    if (lower := _STATEMENTS.get(type(statement))) is None:
                        what = f"a {type(statement).__name__} statement"
                        raise not_expressible(what, "say it in other statements")
                    yield from lower(self, statement)
                # The other statements are lowered all the same, so that one build reports every
                # fault.
                except Refused as refused:
                    self.findings += refused.findings

    def block(self, body: tuple[p.Statement, ...]) -> tuple[Any, ...]:
        return gathered(self.statements(body))

    def counted(self, variable: str, body: tuple[p.Statement, ...]) -> tuple[str, tuple[Any, ...]]:
        """RAPID's name of the variable of a loop, and the loop's body."""
        self._counting.append(variable.lower())
        block = self.block(body)
        self._counting.pop()
        return spelt(self._counters, variable), block

    def _value(self, name: str) -> str:
        # A loop variable hides data of the routine, which hides data of the module.
        if name.lower() in self._counting:
            return spelt(self._counters, name)
        if name.lower() in self._inner:
            return spelt(self._inner, name)
        return self.names.value(name)

    def _speed(self, speed: Speed | p.ComputedSpeed | e.Name) -> s.Expression:
        if not isinstance(speed, p.ComputedSpeed):
            return s.NameRef(speed_name_in(self.names, speed))
        parts = (speed.tcp, speed.rotation, speed.external_linear, speed.external_rotary)
        return s.AggregateNode(tuple(self.lower(part) for part in parts if part is not None))

    def _blend(self, blend: Blend | p.ComputedBlend | e.Name) -> s.Expression:
        if not isinstance(blend, p.ComputedBlend):
            return s.NameRef(blend_name_in(self.names, blend))
        details = usual_details(blend.radius) if blend.details is None else blend.details
        parts = (blend.stops or e.Truth(False), blend.radius, *details)
        return s.AggregateNode(tuple(map(self.lower, parts)))

    def set_up(self, x: p.Trigger) -> Iterator[s.ProcedureCall]:
        """The call that sets up the data of one output, unless that is set up before."""
        if x not in self.set_up_before:
            yield self.trigger_set_up(x)

    def trigger_set_up(self, x: p.Trigger) -> s.ProcedureCall:
        variable = s.NameRef(self.names.triggers[x])
        signal = self.signals.get(x.signal.lower())
        kind = signal.kind if signal else "digital"
        named = s.NameRef(self.names.get("signals", x.signal))
        return trigger_set_up(x, variable, named, kind, self.lower)

    def call(self, word: str, *given: s.Expression, **options: s.Expression) -> s.ProcedureCall:
        arguments: list[s.Argument] = [s.Positional(g) for g in given]
        arguments += [s.Option(n, v) for n, v in options.items()]
        return s.ProcedureCall(word, tuple(arguments))

    def signal(self, name: str, slot: Slot) -> s.NameRef | None:
        """A signal, if it is of the kind and direction that the slot tells."""
        signal = self.signals.get(name.lower(), Signal("digital", "input"))
        fits = slot.kind in ("signal", signal.kind) and slot.of in ("", signal.direction)
        return s.NameRef(self.names.get("signals", name)) if fits else None


def _move(b: BodyLowering, x: p.MoveStatement) -> _Lowered:
    (move,) = _table_row(b, replace(x, triggers=()))
    if x.triggers:
        yield from with_triggers(move, x.triggers, b.names.triggers, b.set_up)
    else:
        yield move


def _follow(b: BodyLowering, x: p.Follow) -> _Lowered:
    yield from path_moves(x.path, b.names.rows[id(x)], b.names)


def _table_row(b: BodyLowering, x: p.Statement) -> Iterator[s.ProcedureCall]:
    """A statement that is a row of `tables.equivalents`."""
    call = STATEMENT_ROWS.write(x, b.writing)
    if call is None:
        raise not_expressible(f"such a {type(x).__name__}", "say it otherwise")
    yield s.ProcedureCall(call.word, arguments(call))


def _start_timer(b: BodyLowering, x: p.StartTimer) -> _Lowered:
    clock = s.NameRef(b.names.get("timers", x.timer))
    yield b.call("ClkReset", clock)
    yield b.call("ClkStart", clock)


def _set_signal(b: BodyLowering, x: p.SetSignal) -> _Lowered:
    if x.pulse is not None:
        _check_pulse(b, x, x.pulse)
    yield from _table_row(b, x)


def _check_pulse(b: BodyLowering, x: p.SetSignal, seconds: e.Expression) -> None:
    signal = b.signals.get(x.signal.lower())
    if isinstance(seconds, e.Number) and not SHORTEST_PULSE <= seconds.value <= LONGEST_PULSE:
        what = f"a pulse of `{x.signal}` that is not {SHORTEST_PULSE} to {LONGEST_PULSE} s"
        raise not_expressible(what, "give a time in that range")
    if x.value != e.Number(1) or (signal is not None and signal.kind != "digital"):
        group = signal is not None and signal.kind != "digital"
        what = f"a pulse of the group `{x.signal}`" if group else f"such a pulse of `{x.signal}`"
        raise not_expressible(what, "set the signal, wait and set it back")


def _call(b: BodyLowering, x: p.Call) -> _Lowered:
    name = b.names.get("procedures", x.procedure)
    given = tuple(s.Positional(b.lower(a)) for a in x.arguments)
    if x.unit is None or x.unit in b.resident:
        yield s.ProcedureCall(name, given)
        return
    # The routine is not in memory when the program is linked, so it is called by its name as a
    # text.
    file = s.StringLiteral(LOADED_FROM + b.names.get("modules", x.unit) + ".mod")
    yield s.ProcedureCall("Load", (s.Option("Dynamic"), s.Positional(file)))
    yield s.ProcedureCall(s.StringLiteral(name), given)
    yield s.ProcedureCall("UnLoad", (s.Positional(file),))


def _assign(b: BodyLowering, x: p.Assign) -> _Lowered:
    match x:
        # An orientation is assigned to the component `rot` of its target.
        case p.Assign(place, e.Apply("oriented", (base, *angles))) if place == base and len(
            angles
        ) == len(e.ANGLES):
            turn = b.expressions.orientation(place)
            first = angles[0]
            # All three angles of one value are its quaternion, which is copied without rounding.
            if isinstance(first, e.Member) and angles == [
                e.Member(first.value, name) for name in e.ANGLES
            ]:
                yield s.Assignment(turn, b.expressions.orientation(first.value))
                return
            yield s.Assignment(turn, b.expressions.oriented(tuple(angles)))
            return
    target = b.lower(x.target)
    if not isinstance(target, s.NameRef | s.Component | s.Element):
        raise not_expressible("an assignment to an expression", "name a variable")
    yield s.Assignment(target, b.lower(x.value))


def _if(b: BodyLowering, x: p.If) -> _Lowered:
    branches = tuple(s.IfBranch(b.lower(c.condition), b.block(c.body)) for c in x.branches)
    yield s.IfThen(branches, b.block(x.otherwise) if x.otherwise else None)


def _while(b: BodyLowering, x: p.While) -> _Lowered:
    yield s.WhileLoop(b.lower(x.condition), b.block(x.body))


def _for(b: BodyLowering, x: p.For) -> _Lowered:
    # Without STEP a loop counts downwards where its bounds do (RAPID kernel manual, FOR).
    upwards = x.step == p.ONE and ascends(x.first, x.last)
    step = None if upwards or x.step is None else b.lower(x.step)
    first, last = b.lower(x.first), b.lower(x.last)
    variable, body = b.counted(x.variable, x.body)
    yield s.ForLoop(variable, first, last, step, body)


def _switch(b: BodyLowering, x: p.Switch) -> _Lowered:
    cases = tuple(s.TestCase(tuple(map(b.lower, c.values)), b.block(c.body)) for c in x.cases)
    yield s.TestOf(b.lower(x.subject), cases, b.block(x.otherwise) if x.otherwise else None)


def _stop(b: BodyLowering, x: p.Stop) -> _Lowered:
    if x.end:
        yield s.Word("EXIT")
    else:
        yield from _table_row(b, x)


def _return(b: BodyLowering, x: p.Return) -> _Lowered:
    yield s.ReturnFrom(None if x.value is None else b.lower(x.value))


def _label(b: BodyLowering, x: p.Label) -> _Lowered:
    yield s.LabelMark(spelt(b.labels, x.name))


def _goto(b: BodyLowering, x: p.Goto) -> _Lowered:
    yield s.GotoLabel(spelt(b.labels, x.label))


def _message(b: BodyLowering, x: p.Message) -> _Lowered:
    whole: s.Expression | None = None
    for part in message_parts(x, b.known) or (e.Text(""),):
        # ValToStr takes any value; in parentheses the lowest level needs none of its own.
        if is_value(part, b.known):
            own: s.Expression = s.FunctionCall("ValToStr", (s.Positional(b.lower(part, OR)),))
        else:
            # On the right of `+` an operand binds tighter than a sum.
            own = b.lower(part, TERM if whole is not None else SUM)
        whole = own if whole is None else s.Infix("+", whole, own)
    assert whole is not None
    yield b.call("TPWrite", whole)


def _opaque(_: BodyLowering, x: p.Opaque) -> _Lowered:
    if x.language != verbatim.LANGUAGE:
        raise Refused(rules.OTHER_LANGUAGE(**verbatim.foreign(x)))
    yield from verbatim.statements(x.text)


_STATEMENTS: Final[dict[type, Callable[[BodyLowering, Any], _Lowered]]] = {
    **dict.fromkeys(STATEMENT_ROWS.records, _table_row),
    **dict.fromkeys((p.Move, p.MoveCircular, p.MoveJoints), _move),
    p.Follow: _follow,
    p.StartTimer: _start_timer,
    p.SetSignal: _set_signal,
    p.Call: _call,
    p.Assign: _assign,
    p.If: _if,
    p.While: _while,
    p.For: _for,
    p.Switch: _switch,
    p.Stop: _stop,
    p.Return: _return,
    p.Label: _label,
    p.Goto: _goto,
    p.Message: _message,
    p.Opaque: _opaque,
}


def build(program: Program, unit: str | None = None) -> s.File:
    """Build the tree of one unit of an adapted program; raises Refused for constructs that RAPID
    cannot express.
    """
    names = NAMES.naming(program)
    here = [q for q in program.procedures if q.unit == unit]
    held = resident_units(program)
    there = (
        [header_declaration(one) for one in controller_data_nodes(program, names)]
        if unit is None
        else ()
    )
    # The controller's configuration must have the outputs of hands, so the heading lists them, too.
    hands = [(hand_signal(hand), Signal("digital", "output")) for hand in hands_used(program)]
    listed = replace(program, signals=with_used_signals(program.signals, hands))
    head = header_lines(listed, unit, names.changed, resident=unit in held, there=there)
    items: list[Any] = [s.CommentLine(x) for x in head]
    # A module has types first, then data, then routines, or the controller refuses to load it.
    declared = _declared_items(program) if unit is None else []
    items += [i for i in declared if isinstance(i, s.Record | s.Alias)]
    data: list[s.Data] = []
    if unit is None or unit in held:
        data = list(data_nodes(with_own_targets(program, unit, held), names))
    verbatim_data = [i for i in declared if not isinstance(i, s.Record | s.Alias | s.Routine)]
    # Vendor declarations may name any target: then all of them come first.
    by_use = {} if verbatim_data else _targets_in_use(here, program, names)
    items += [node for node in data if node.name not in by_use]
    items += verbatim_data
    waiting = {by_use[node.name]: node for node in data if node.name in by_use}
    for procedure in here:
        items += _targets_by_use(procedure, names, scope_of_paths(program), waiting)
    items += waiting.values()
    shared = shared_triggers(program)
    items += [_routine_node(procedure, program, names, shared) for procedure in here]
    items += [i for i in declared if isinstance(i, s.Routine)]
    return s.File((s.Module(module_name(program, unit), (), gathered(items)),))


def module_name(program: Program, unit: str | None = None) -> str:
    return NAMES.naming(program).get("modules", unit or program.name)


def _declared_items(program: Program) -> list[s.Item]:
    """Return the items of a program's declarations that only RAPID can express."""
    found: list[s.Item] = []
    for declaration in program.declarations:
        if declaration.language != verbatim.LANGUAGE:
            raise Refused(rules.OTHER_LANGUAGE(**verbatim.foreign(declaration)))
        found += verbatim.items(declaration.text)
    return found


def _targets_in_use(
    procedures: Iterable[Procedure], program: Program, names: Naming
) -> dict[str, str]:
    """The targets that are declared as procedures use them: by RAPID's names, in lower case as
    statements name them.

    A program that was read keeps its order of targets, but for those beside paths.
    """
    used: set[str] = set()
    for procedure in procedures:
        if program.origin is None or any(isinstance(x, p.Follow) for x in walk(procedure.body)):
            used |= {x.name.lower() for x in records(procedure.body) if isinstance(x, e.Name)}
    return {names.get("values", n): n.lower() for n in program.targets if n.lower() in used}


def _targets_by_use(
    procedure: Procedure, names: Naming, scope: str, waiting: dict[str, s.Data]
) -> Iterator[s.TargetRunNode | s.Data]:
    """Targets of a procedure as its moves use them, so that those of a contour stand together:
    those of its paths, and of the others the ones that are waiting, which it takes.
    """
    for statement in walk(procedure.body):
        if isinstance(statement, p.Follow):
            yield from path_targets(statement.path, names.rows[id(statement)], scope)
        elif waiting and isinstance(statement, p.MoveStatement):
            parts = reversed([*records(statement)])  # the via point of an arc before its end
            named = [x.name.lower() for x in parts if isinstance(x, e.Name)]
            yield from (waiting.pop(name) for name in named if name in waiting)


def _routine_node(
    procedure: Procedure,
    program: Program,
    names: Naming,
    shared: Mapping[p.Trigger, str],
) -> s.Routine:
    inner = names.inner[procedure.name.lower()]
    statements, handlers = _without_handlers(procedure.body)
    body = BodyLowering(program, names, procedure, shared)
    variables = [
        variable_node(spelt(inner, n), v, body.expressions) for n, v in procedure.variables.items()
    ]
    here = [body.trigger_set_up(one) for one, at in shared.items() if at == procedure.name.lower()]
    first = next(
        (row for row, one in enumerate(statements) if not isinstance(one, p.Comment)),
        len(statements),
    )
    # Below the comment that says what the procedure does.
    title = body.statements(statements[:first]) if here else ()
    below = statements[first:] if here else statements
    made = gathered([*variables, *title, *here, *body.statements(below)])
    if body.findings:
        raise Refused(*body.findings)
    return s.Routine(
        "PROC" if procedure.result is None else "FUNC",
        procedure.local,
        names.get("procedures", procedure.name),
        made,
        "" if procedure.result is None else TYPE_OF_VALUE[procedure.result],
        tuple(_parameter_group(q, spelt(inner, q.name)) for q in procedure.parameters),
        handlers,
    )


def _parameter_group(parameter: Parameter, name: str) -> s.ParameterGroup:
    mode = "INOUT" if parameter.mode == "inout" else ""
    node = s.ParameterNode(mode, TYPE_OF_VALUE[parameter.type], name, parameter.dimensions)
    return s.ParameterGroup(False, (node,))


def _without_handlers(
    body: tuple[p.Statement, ...],
) -> tuple[tuple[p.Statement, ...], tuple[s.Handler, ...]]:
    """The statements of a body, and the error handlers that stand verbatim at its end."""
    found: list[s.Handler] = []
    # Handlers are the last statements of a body; any other statement ends the search.
    for statement in reversed(body):
        if not isinstance(statement, p.Opaque) or statement.language != verbatim.LANGUAGE:
            break
        handlers = verbatim.error_handlers(statement.text)
        if handlers is None:
            break
        found[:0] = handlers
        body = body[:-1]
    return body, tuple(found)
