"""Inputs and outputs whose number is worked out while the program runs.

`M_In(M1)` and `M_Out(M1)=1` go to any signal of the controller by its number. Other languages know
signals by their names: a procedure chooses among those that the number may come to.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final, Literal

from assistant.base.diagnostics import Findings
from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.lift.values.symbols import SIGNAL_VARIABLES
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
    identifier,
    walk,
)
from assistant.program.rewriting import Body, records
from assistant.program.statement_index import records_in_procedures
from assistant.program.vendor_statements import effect_of

HAND_STATEMENTS: Final[Mapping[str, tuple[str, Literal["open", "close"]]]] = {
    "HOPEN": ("HOpen", "open"),
    "HCLOSE": ("HClose", "close"),
}
"""Statements of hands, as they are written, and what they do."""
NUMBER: Final = "number"
VALUE: Final = "value"
"""Parameters of the procedures."""
MOST_LISTED_NUMBERS: Final = 6
"""Numbers that a finding lists; of more it says how many there are."""


class AnyNumber(Exception):
    """It is not known which numbers it may be."""


@dataclass(slots=True)
class _SignalChooser:
    """A procedure that reads or sets the signal of a number. numbers: those that it knows."""

    name: str
    signal: Signal
    write: tuple[e.Expression, ...] | None
    numbers: set[int] = field(default_factory=set)


class NumberedSignals:
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
        signal, numbers = _signal_status(key), self._numbers(number, procedure)
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
        signal, numbers = _signal_status(key), self._numbers(given[0], procedure, origin)
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
        with suppress(AnyNumber):
            numbers, which = self._numbers(given, procedure, origin), "that it may come to"
        if not numbers:
            raise AnyNumber
        listed = ", ".join(map(str, sorted(numbers)))
        self.findings.append(
            rules.NUMBERED(what="hand", name=HAND_STATEMENTS[key][0], numbers=listed, which=which)
        )
        action = HAND_STATEMENTS[key][1]
        cases = tuple(p.Case((e.Number(n),), (p.Gripper(action, n),)) for n in sorted(numbers))
        return p.Switch(given, cases, (p.Stop(end=True),))

    @cached_property
    def _hands(self) -> set[int]:
        return {one.hand for one in records_in_procedures(self.program, p.Gripper)}

    def added(self, program: Program) -> Program:
        """The program with the procedures that were asked for, and the signals that they name."""
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

    def _numbers(
        self, number: e.Expression, procedure: Procedure, origin: p.Statement | None = None
    ) -> set[int]:
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
            raise AnyNumber
        return {round(one) for one in found}

    def _counted(self, loop: p.For, procedure: Procedure) -> Mapping[str, Numbers]:
        """Values of a loop's variable inside the loop, if its bounds are plain numbers."""
        first, last, step = (e.plain_number(x) for x in (loop.first, loop.last, loop.step or p.ONE))
        name = loop.variable.lower()
        changed = written_names(loop.body, self.program, verbatim=False)
        for text in (one for one in walk(loop.body) if isinstance(one, p.Opaque) and not one.told):
            changed |= effect_of(text).writes
        if first is None or last is None or not step or name in changed:
            return {}
        count = max(int((last - first) / step) + 1, 1)
        named = (x for x in records(loop.body) if isinstance(x, p.Call | e.Apply))
        called = (x.procedure if isinstance(x, p.Call) else x.function for x in named)
        calls = any(self.program.procedure(one) for one in called)
        others = (q for q in self.program.procedures if q is not procedure)
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
        """The name of the procedure that reads or sets a signal, which is told."""
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
        listed = ", ".join(map(str, among[:MOST_LISTED_NUMBERS])) or "none"
        more = (
            f" and {len(among) - MOST_LISTED_NUMBERS} more"
            if len(among) > MOST_LISTED_NUMBERS
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
