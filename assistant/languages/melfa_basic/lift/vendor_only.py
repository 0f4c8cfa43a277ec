"""Statements and values that only MELFA-BASIC has, in terms of other languages.

`M_In(M1)` and `M_Out(M1)=1` address a signal by a computed number. Other languages know signals by
names: a procedure chooses among those that the number may be. Functions of `tables/library.txt`
are added to the program as procedures.

`Mvs P1+(0,0,5,0,0,30)` moves to a position whose angles are computed one by one: the position is
computed in an assignment before the statement that names it.

`End` inside a subroutine ends the cycle or the called program: each call of a subroutine that may
reach it is followed by a question, and where the flag is set, the caller returns as well, up to
the first procedure of the program.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import cached_property
from typing import Any, Final, Literal, TypeGuard

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lift.computed_positions import ANGLE_DIVIDING
from assistant.languages.melfa_basic.lift.statements import CAUTIONS
from assistant.languages.melfa_basic.lift.symbols import (
    SIGNAL_VARIABLES,
    VENDOR_ONLY_END,
    VENDOR_ONLY_NAME,
)
from assistant.languages.melfa_basic.tables.equivalents import library, library_calls
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.io_use import AddressedSignals
from assistant.program.analysis.possible_values import (
    MOST_VALUES,
    Numbers,
    PossibleValues,
    numbers_at,
)
from assistant.program.analysis.uses import declared
from assistant.program.passes.loops import written_names
from assistant.program.program import (
    Parameter,
    Procedure,
    Program,
    Signal,
    TakenNames,
    Variable,
    identifier,
    walk,
)
from assistant.program.rewriting import (
    Body,
    head,
    map_bodies,
    map_expressions,
    map_head,
    records,
    rewrite,
)
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

_HAND_STATEMENTS: Final[Mapping[str, tuple[str, Literal["open", "close"]]]] = {
    "HOPEN": ("HOpen", "open"),
    "HCLOSE": ("HClose", "close"),
}
"""Statements of hands, as they are written, and what they do."""
NUMBER: Final = "number"
VALUE: Final = "value"
"""Parameters of the procedures."""
_MOST_LISTED_NUMBERS: Final = 6
"""Numbers that a finding lists; of more it says how many there are."""


class _AnyNumber(Exception):
    """It is not known which numbers it may be."""


@dataclass(slots=True)
class _SignalChooser:
    """A procedure that reads or sets the signal of a number. numbers: those that it knows."""

    name: str
    signal: Signal
    write: tuple[e.Expression, ...] | None
    numbers: set[int] = field(default_factory=set)


class _NumberedSignals:
    """Signals by worked-out numbers in a program, and the procedures that choose among them."""

    def __init__(self, program: Program, findings: Findings) -> None:
        self.program, self.findings = program, findings
        self.possible = PossibleValues(program)
        self.signals = dict(program.signals)
        self.taken = TakenNames(declared(program))
        self.addressed = AddressedSignals(self.signals, self.free)
        self.choosers: dict[Any, _SignalChooser] = {}
        self.counting: tuple[p.For, ...] = ()
        """The loops around the statement at hand, the outer one first."""

    def read(self, key: str, number: e.Expression, procedure: Procedure) -> e.Expression:
        """The value of a signal. key: of SIGNALS. Raises AnyNumber."""
        signal, numbers = _signal_status(key), self.numbers(number, procedure)
        if len(numbers) == 1:
            return e.Name(self._name(signal, *numbers))
        name = self._chooser(f"{signal.direction}_value", signal, None, numbers)
        return e.Apply(name, (number,))

    def switched(
        self, key: str, given: Sequence[e.Expression], procedure: Procedure, origin: p.Statement
    ) -> p.Statement:
        """An output that is set, or pulsed. given: its number and value, the seconds of a pulse.

        origin: the statement that says so. Raises AnyNumber.
        """
        signal, numbers = _signal_status(key), self.numbers(given[0], procedure, origin)
        rest = [self._plain(one, procedure) for one in given[1:]]
        if len(numbers) == 1:
            return p.SetSignal(self._name(signal, *numbers), *rest)
        if len(rest) == 1:
            name = self._chooser("set_output", signal, (e.Name(VALUE),), numbers)
            return p.Call(name, (given[0], rest[0]))
        return p.Call(self._chooser("pulse_output", signal, tuple(rest), numbers), (given[0],))

    def gripped(
        self, key: str, given: e.Expression, procedure: Procedure, origin: p.Statement
    ) -> p.Statement:
        """A hand that is opened or closed by its number, among those of the program. key: of HANDS.

        Raises AnyNumber where no hand is known.
        """
        numbers = self._hands
        which = "that the program names elsewhere"
        with suppress(_AnyNumber):
            numbers, which = self.numbers(given, procedure, origin), "that it may come to"
        if not numbers:
            raise _AnyNumber
        listed = ", ".join(map(str, sorted(numbers)))
        self.findings.append(
            rules.NUMBERED(what="hand", name=_HAND_STATEMENTS[key][0], numbers=listed, which=which)
        )
        action = _HAND_STATEMENTS[key][1]
        cases = tuple(p.Case((e.Number(n),), (p.Gripper(action, n),)) for n in sorted(numbers))
        return p.Switch(given, cases, (p.Stop(end=True),))

    @cached_property
    def _hands(self) -> set[int]:
        return {one.hand for one in records_in_procedures(self.program, p.Gripper)}

    def added(self, program: Program) -> Program:
        """Return the program with the requested procedures and the signals that they name."""
        made = tuple(self._procedure(one) for one in self.choosers.values())
        return replace(program, signals=self.signals, procedures=(*program.procedures, *made))

    # -------------------------------------------------------------------------- choosing

    def free(self, wanted: str) -> str:
        """A name that nothing has yet, and that is taken then."""
        name = identifier(wanted, self.taken)
        self.taken.add(name.lower())
        return name

    def _name(self, signal: Signal, number: int) -> str:
        return self.addressed.name(replace(signal, number=number))

    def numbers(
        self, number: e.Expression, procedure: Procedure, origin: p.Statement | None = None
    ) -> set[int]:
        """The values that a number may have. Raises AnyNumber."""
        named = {x.name.lower() for x in records(number) if isinstance(x, e.Name)}
        counted = [
            self._counted(loop, procedure)
            for loop in self.counting
            if loop.variable.lower() in named
        ]
        known = {name: numbers for one in counted for name, numbers in one.items()}
        found = self.possible.of(number, procedure, known)
        if found is None and origin is not None:
            found = numbers_at(self.possible, number, procedure, origin)
        if found is None:
            raise _AnyNumber
        return {round(one) for one in found}

    def _counted(self, loop: p.For, procedure: Procedure) -> Mapping[str, Numbers]:
        """Values of a loop's variable inside the loop, if its bounds are plain numbers."""
        first, last, step = (e.plain_number(x) for x in (loop.first, loop.last, loop.step or p.ONE))
        name = loop.variable.lower()
        changed = written_names(loop.body, self.program, verbatim=False)
        for text in (one for one in walk(loop.body) if isinstance(one, p.Opaque) and not one.told):
            changed |= effect_of(text).writes
        # A body that changes its own loop variable makes the values unknown.
        if first is None or last is None or not step or name in changed:
            return {}
        count = max(int((last - first) / step) + 1, 1)
        named = (x for x in records(loop.body) if isinstance(x, p.Call | e.Apply))
        called = (x.procedure if isinstance(x, p.Call) else x.function for x in named)
        calls = any(self.program.procedure(one) for one in called)
        others = (q for q in self.program.procedures if q is not procedure)
        # A called procedure may count with the same variable.
        if count > MOST_VALUES or (
            calls and any(name in written_names(q.body, self.program) for q in others)
        ):
            return {}
        return {name: frozenset(first + turn * step for turn in range(count))}

    def _plain(self, value: e.Expression, procedure: Procedure) -> e.Expression:
        """A value that is always the same as that one."""
        found = self.possible.of(value, procedure)
        return value if found is None or len(found) != 1 else e.number_of(*found)

    def _chooser(
        self,
        stem: str,
        signal: Signal,
        write: tuple[e.Expression, ...] | None,
        numbers: set[int],
    ) -> str:
        """Return the name of the procedure that reads or sets a signal, and report it."""
        key = signal, write
        if key not in self.choosers:
            width = f"_{signal.bits}" if signal.kind == "group" else ""
            self.choosers[key] = _SignalChooser(self.free(stem + width), signal, write)
        chooser = self.choosers[key]
        known = {
            one.number
            for one in self.program.signals.values()
            if one.number is not None and replace(one, number=signal.number) == signal
        }
        chooser.numbers |= numbers or known
        among = sorted(numbers or known)
        listed = ", ".join(map(str, among[:_MOST_LISTED_NUMBERS])) or "none"
        more = (
            f" and {len(among) - _MOST_LISTED_NUMBERS} more"
            if len(among) > _MOST_LISTED_NUMBERS
            else ""
        )
        found = rules.NUMBERED(
            what=signal.direction, name=chooser.name, numbers=listed + more,
            which="that it may come to" if numbers else "that the program names elsewhere",
        )  # fmt: skip
        self.findings.append(found)
        return chooser.name

    def _procedure(self, chooser: _SignalChooser) -> Procedure:
        number, numbers = e.Name(NUMBER), sorted(chooser.numbers)
        end: Body = (p.Stop(end=True),)
        cases = tuple(p.Case((e.Number(one),), (self._act(chooser, one),)) for one in numbers)
        body: Body = (p.Switch(number, cases, end),) if cases else end
        if chooser.write is None:
            # The return below is never reached, but a function has to have one.
            return Procedure(
                chooser.name, (*body, p.Return(e.Number(0))), (Parameter(NUMBER, "integer"),),
                result="number" if chooser.signal.kind == "analog" else "integer",
            )  # fmt: skip
        parameters = [Parameter(NUMBER, "integer")]
        if e.Name(VALUE) in chooser.write:
            kind: Any = "number" if chooser.signal.kind == "analog" else "integer"
            parameters.append(Parameter(VALUE, kind))
        return Procedure(chooser.name, body, tuple(parameters))

    def _act(self, chooser: _SignalChooser, number: int) -> p.Statement:
        name = self._name(chooser.signal, number)
        if chooser.write is None:
            return p.Return(e.Name(name))
        return p.SetSignal(name, *chooser.write)


def _signal_status(key: str) -> Signal:
    kind, direction, bits = SIGNAL_VARIABLES[key]
    return Signal(kind, direction, 0, bits)  # type: ignore[arg-type]


class _LibraryProcedures:
    """The procedures of the library that a program calls, under names that it has free.

    free: gives a name that nothing has yet.
    """

    def __init__(self, free: Callable[[str], str]) -> None:
        self._free = free
        self._names: dict[str, str] = {}

    def name(self, key: str) -> str:
        """Return the program's name for a procedure of the library, and add the procedure to the
        program.
        """
        if key not in self._names:
            self._names[key] = self._free(key)
            for other in sorted(library_calls(library()[key])):
                self.name(other)
        return self._names[key]

    def added(self, program: Program) -> Program:
        """Return the program with the requested procedures."""
        if not self._names:
            return program

        def named(node: Any) -> Any:
            match node:
                case e.Apply(function, given) if function in self._names:
                    return e.Apply(self._names[function], given)
            return node

        made = tuple(
            rewrite(replace(library()[key], name=name), named, ())
            for key, name in self._names.items()
        )
        return replace(program, procedures=(*program.procedures, *made))


def _with_turned_positions(
    statements: Sequence[p.Statement], held: Callable[[], e.Name]
) -> Body | None:
    """The statements with such positions in assignments.

    held: a position that nothing else names. None where a statement names several such positions,
    or one in a condition.
    """
    made: list[p.Statement] = []
    for one in statements:
        turned = [x for x in records(head(one)) if _is_turned(x)]
        if not turned:
            made.append(one)
        elif len(turned) > 1 or not isinstance(one, p.Assign | p.Move | p.MoveCircular):
            return None
        else:
            made += _in_two_statements(one, turned[0], held)
    return tuple(made)


def _in_two_statements(
    one: p.Assign | p.Move | p.MoveCircular, turned: e.Apply, held: Callable[[], e.Name]
) -> list[p.Statement]:
    place, *angles = turned.arguments
    if isinstance(one, p.Assign) and one.value == turned:
        base = place.arguments[0] if isinstance(place, e.Apply) else place
        # A shift leaves the angles as they are, so angles of the base may still be read after it.
        if base == one.target and _names_in(tuple(angles)) <= _names_in(base):
            moved = [] if place == one.target else [replace(one, value=place)]
            return [*moved, replace(one, value=e.Apply("oriented", (one.target, *angles)))]
        # The target is overwritten before the angles are read, so none of them may come from it.
        if _names_in(one.target).isdisjoint(_names_in(turned)):
            turned = e.Apply("oriented", (one.target, *angles))
            return [replace(one, value=place), replace(one, value=turned)]
    name = held()

    def named(x: e.Expression) -> e.Expression:
        return name if x == turned else x

    return [
        p.Assign(name, place, span=one.span),
        p.Assign(name, e.Apply("oriented", (name, *angles)), span=one.span),
        map_head(one, named),
    ]


def _names_in(value: object) -> set[str]:
    return {x.name.lower() for x in records(value) if isinstance(x, e.Name)}


def _is_turned(x: object) -> TypeGuard[e.Apply]:
    return isinstance(x, e.Apply) and x.function == "oriented"


_STATE_EQUIVALENTS: Final[Mapping[str, tuple[str, e.Expression, str, str]]] = {
    "M_SVO": (
        "M_Svo", e.Number(1),
        "the motors are taken to be on, as a program of the other controller only runs then",
        "none is needed",
    ),
    "M_OPOVRD": (
        "M_OPovrd", e.Number(100),
        "the speed that the operator has set on the panel is taken to be 100 %",
        "let the program ask for it as the other controller tells it, if it has to make up for it",
    ),
}  # fmt: skip
"""States of the controller: as they are written, what they are elsewhere, what is lost, a cure."""
_OVERRIDE_STATUS: Final = "M_OVRD"
"""The percentage of speed that `Ovrd` has set."""
_DIVIDED_ANGLES: Final = (
    "the angles of its places are divided between its corners, as the manual CR1D states alone"
)
_UNDIVIDED_CURE: Final = "teach all corners with one posture, or give direction 11, 12 or 13"
_VENDOR_ONLY_PREFIX: Final = VENDOR_ONLY_NAME.format("")


def with_told(program: Program, findings: Findings) -> Program:
    """The program with other words for texts, where there are some; tells what they leave out."""
    if not any(
        isinstance(one, e.Verbatim | p.Opaque) and one.told for one in records(program.procedures)
    ):
        return program
    telling = _VendorLowering(_NumberedSignals(program, findings), findings)
    procedures = tuple(map(telling.procedure, program.procedures))
    program = telling.numbered.added(replace(program, procedures=procedures))
    if telling.override:
        program = _with_override(program, telling.override)
    if telling.held:
        variables = {**program.variables, telling.held: Variable("position")}
        program = replace(program, variables=variables)
    return telling.supplied.added(program)


def _with_override(program: Program, name: str) -> Program:
    """With a variable that each statement sets which sets the percentage, and a cycle's begin."""

    def body(statements: Body) -> Body:
        return tuple(made for one in statements for made in told(map_bodies(one, body)))

    def told(one: p.Statement) -> Body:
        if isinstance(one, p.SetOverride):
            return one, p.Assign(e.Name(name), one.percent, span=one.span)
        return (one,)

    full = e.Number(100)
    begun: Body = (p.Assign(e.Name(name), full),)
    procedures = tuple(
        replace(one, body=(*(begun if one.name == program.entry else ()), *body(one.body)))
        for one in program.procedures
    )
    variables = {**program.variables, name: Variable("number", full)}
    return replace(program, procedures=procedures, variables=variables)


class _VendorLowering:
    """The procedures of a program."""

    def __init__(self, numbered: _NumberedSignals, findings: Findings) -> None:
        self.numbered, self.findings = numbered, findings
        self.supplied = _LibraryProcedures(numbered.free)
        self.held = self.override = ""
        self.divided = False

    def procedure(self, procedure: Procedure) -> Procedure:
        def told(x: e.Expression) -> e.Expression:
            match x:
                case e.Verbatim(told=meant) if meant is not None:
                    try:
                        return map_expressions(meant, told)
                    # A number that is not known leaves the vendor text in place.
                    except _AnyNumber:
                        return x
                case e.Apply(function, given) if function.startswith(_VENDOR_ONLY_PREFIX):
                    return self._state(function.removeprefix(_VENDOR_ONLY_PREFIX), given, procedure)
            return x

        def body(statements: Body) -> Body:
            return tuple(one for node in statements for one in said(node))

        def inside(node: p.Statement) -> p.Statement:
            """A statement with what it holds, in which a loop counts through known numbers."""
            counting = self.numbered.counting
            if isinstance(node, p.For):
                self.numbered.counting = (*counting, node)
            made: p.Statement = map_bodies(node, body)
            self.numbered.counting = counting
            return made

        def said(node: p.Statement) -> Body:
            with self.findings.at(node.span):
                made: Body = (node,)
                # An `End` that is still here has no other meaning: see `with_endings`.
                if isinstance(node, p.Opaque) and node.told and not is_end(node):
                    made = self._error(node, procedure) or node.told
                if made != (node,) and (loss := _lost_effects(node, made)) is not None:
                    what, cure = loss
                    text = getattr(node, "text", "").strip()
                    self.findings.append(rules.LEFT_OUT(what=text, loss=what, cure=cure))
                try:
                    made = tuple(whole(one, node, told) for one in made)
                except _AnyNumber:
                    made = (node,)
                turned = _with_turned_positions(made, self._held)
                made = (node,) if turned is None else turned
                if any(map(_counts_axis, made)):
                    self.findings.append(rules.SLIDES())
                return tuple(map(inside, made))

        def whole(
            node: p.Statement, origin: p.Statement, change: Callable[[e.Expression], e.Expression]
        ) -> p.Statement:
            node = map_head(replace(node, span=origin.span), change)
            match node:
                case p.Call(name, (hand,)) if (
                    name.removeprefix(_VENDOR_ONLY_PREFIX) in _HAND_STATEMENTS
                ):
                    key = name.removeprefix(_VENDOR_ONLY_PREFIX)
                    gripped = self.numbered.gripped(key, hand, procedure, origin)
                    return replace(gripped, span=origin.span)
                case p.Call(name, given) if name.startswith(_VENDOR_ONLY_PREFIX):
                    made = self.numbered.switched(
                        name.removeprefix(_VENDOR_ONLY_PREFIX), given, procedure, origin
                    )
                    return replace(made, span=origin.span)
            return node

        return replace(procedure, body=body(procedure.body))

    def _error(self, node: p.Opaque, procedure: Procedure) -> Body:
        """The equivalent of `Error` with a number that has known values; empty for any other."""
        match node.told:
            case (p.Message((text, number)), p.If((p.Branch(_, end),))) if _RAISED.match(node.text):
                with suppress(_AnyNumber):
                    found = self.numbered.numbers(number, procedure, node)
                    first, last = CAUTIONS
                    if not any(first <= one <= last for one in found):
                        plain = number.arguments[0] if isinstance(number, e.Apply) else number
                        return (p.Message((text, plain)), *end)
        return ()

    def _held(self) -> e.Name:
        """A position that is worked out in front of the statement that names it."""
        if not self.held:
            self.held = self.numbered.free("worked_out")
        return e.Name(self.held)

    def _override(self) -> str:
        """The variable that holds the percentage of speed that the program has set last."""
        self.override = self.override or self.numbered.free("current_override")
        return self.override

    def _state(
        self, key: str, given: tuple[e.Expression, ...], procedure: Procedure
    ) -> e.Expression:
        if key in SIGNAL_VARIABLES:
            return self.numbered.read(key, given[0], procedure)
        if key in ANGLE_DIVIDING and not self.divided:
            self.divided = True
            self.findings.append(
                rules.LEFT_OUT(what="Plt", loss=_DIVIDED_ANGLES, cure=_UNDIVIDED_CURE)
            )
        if key in library():
            return e.Apply(self.supplied.name(key), given)
        if key == _OVERRIDE_STATUS:
            return e.Name(self._override())
        what, value, loss, cure = _STATE_EQUIVALENTS[key]
        self.findings.append(rules.LEFT_OUT(what=what, loss=loss, cure=cure))
        return value


_RAISED: Final = re.compile(r"\s*Error\b", re.IGNORECASE)
_FORCED_HAND: Final = re.compile(r"HOpen\s+[^,]+,", re.IGNORECASE)
_OPEN_CORNER: Final = re.compile(r"Cnt\s+1", re.IGNORECASE)


def _lost_effects(node: p.Statement, made: Body) -> tuple[str, str] | None:
    """Effects that the replacement of a text loses, with their cures."""
    text = getattr(node, "text", "").strip()
    if text.upper() == "RETURN":
        return (
            "the program ends there for good, and no error (3840) is on the controller",
            "end the lines above the subroutine with End",
        )
    if _RAISED.match(text):
        return (
            "the number is a message on the pendant, and no error on the controller",
            "tell people or the cell's controller by an output above it",
        )
    if _FORCED_HAND.match(text):
        return (
            "the hand is opened, with no force and no time of its own",
            "set both on the gripper, and wait for it below",
        )
    if _OPEN_CORNER.fullmatch(text):
        radius = next((one.value for one in made if isinstance(one, p.Assign)), None)
        value = radius.value if isinstance(radius, e.Number) else 0
        return (
            f"the size of the corner, which the controller chooses, is {value:g} mm",
            "state it: Cnt 1,10,10",
        )
    return None


def _counts_axis(statement: p.Statement) -> bool:
    """True if the value of an additional axis is more than copied: in mm, or in radian."""
    if isinstance(statement, p.Assign) and _is_axis(statement.value):
        return False
    return any(map(_is_axis, records(head(statement))))


def _is_axis(record: Any) -> bool:
    return isinstance(record, e.Member) and record.field in e.EXTERNAL


def with_endings(program: Program) -> Program:
    """The program with flags for each `End` in a subroutine."""
    ending = {q.name for q in program.procedures if any(map(is_end, walk(q.body)))}
    if not ending:
        return program
    firsts = _first_procedures(program)
    unit_of = {q.name: q.unit for q in program.procedures}
    callers: dict[str, set[str]] = {}
    for procedure in program.procedures:
        for node in walk(procedure.body):
            if isinstance(node, p.Call):
                callers.setdefault(node.procedure, set()).add(procedure.name)
    loose = _called_otherwise(program)
    reached, pending = set[str](), sorted(ending)
    # From each `End` up through the callers of the same program, to its first procedure.
    while pending:
        name = pending.pop()
        if name in reached or name in firsts:
            continue
        reached.add(name)
        pending += [c for c in callers.get(name, ()) if unit_of[c] == unit_of[name]]
    units = {unit_of[name] for name in reached}
    # A call inside an expression or an interrupt cannot be followed by a question.
    bad = {unit_of[q.name] for q in program.procedures if q.name in reached and q.result}
    bad |= {unit_of[name] for name in reached if name.lower() in loose}
    taken = TakenNames(declared(program))
    flags: dict[str | None, str] = {}
    for unit in sorted(units - bad, key=str):
        flags[unit] = identifier("cycle_ended" if unit is None else f"{unit}_ended", taken)
        taken.add(flags[unit])
    made = [
        _with_end_flag(q, flags[q.unit], reached, q.name in firsts) if q.unit in flags else q
        for q in program.procedures
    ]
    variables = {name: Variable("truth", e.Truth(False)) for name in flags.values()}
    return replace(program, procedures=tuple(made), variables={**program.variables, **variables})


def _first_procedures(program: Program) -> set[str]:
    """The procedures that programs of the controller begin with."""
    called = (x for q in program.procedures for x in walk(q.body) if isinstance(x, p.Call))
    found = {x.procedure for x in called if x.unit is not None}
    begun: set[str | None] = set()
    for procedure in program.procedures:
        if procedure.unit not in begun:
            begun.add(procedure.unit)
            found.add(procedure.name)
    return found


def is_end(node: p.Statement) -> bool:
    """True for an `End` in a subroutine, which `with_endings` replaces."""
    return isinstance(node, p.Opaque) and any(
        isinstance(one, p.Call) and one.procedure == VENDOR_ONLY_END for one in node.told
    )


def _called_otherwise(program: Program) -> set[str]:
    """Names of procedures, in lower case, that more than plain calls name."""
    found: set[str] = set()
    for record in records(program.procedures):
        match record:
            case e.Apply(name):
                found.add(name.lower())
            case p.Interrupt():
                found |= {x.procedure.lower() for x in records(record) if isinstance(x, p.Call)}
    for text in records_in_procedures(program, p.Opaque):
        if not is_end(text):
            found |= {name.lower() for name in effect_of(text).names}
    return found


def _with_end_flag(procedure: Procedure, flag: str, reached: set[str], first: bool) -> Procedure:
    """A procedure of a program that has the flag. first: the program begins with it."""
    asked = e.Name(flag)

    def body(statements: Body) -> Body:
        return tuple(made for one in statements for made in told(map_bodies(one, body)))

    def told(node: p.Statement) -> Body:
        if is_end(node):
            ended = p.Assign(asked, e.Truth(True), span=node.span)
            return ended, p.Return(span=node.span)
        if isinstance(node, p.Call) and node.procedure in reached:
            back = p.If((p.Branch(asked, (p.Return(),)),), span=node.span)
            return node, back
        return (node,)

    made = body(procedure.body)
    # A program may be called again, and has not ended then.
    begun: Body = (p.Assign(asked, e.Truth(False)),) if first else ()
    return replace(procedure, body=(*begun, *made))
