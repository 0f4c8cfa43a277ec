"""Interrupts, and moves that are broken off, as trap routines.

An interrupt of RAPID comes when a signal changes. The pseudo-program watches a condition: a
procedure answers it again and again while it holds. The trap routine of the signal calls that
procedure, and so does the statement that switches the interrupt on, as the condition may hold by
then. A timer asks for any other condition. The arm is stopped meanwhile, and released afterwards.

RAPID has no condition beside a move. `ISignalDI` with `Single` interrupts as the signal changes;
the trap routine stops the arm, clears the rest of its path and lets the program go on after the
move. A timer asks for a condition of several signals. If it holds before the move, the move is not
begun.

Kernel manual, Interrupts; reference manual of instructions: ISignalDI, ITimer, StopMove, ClearPath,
StartMove, IDelete.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

from assistant.languages.rapid.lower.expressions import NAMES
from assistant.languages.rapid.tables.constants import LONGEST_NAME
from assistant.languages.rapid.text import verbatim
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called, declared, locals_of
from assistant.program.passes.legalisation import Legalisation
from assistant.program.passes.positions import taken_names, with_named_positions
from assistant.program.program import (
    Declaration,
    Procedure,
    Program,
    TakenNames,
    Variable,
    identifier,
    walk,
)
from assistant.program.rewriting import Body, map_bodies, map_expressions, records
from assistant.program.statement_index import records_in_procedures
from assistant.program.undeclared_names import interrupts
from assistant.program.vendor_statements import effect_of

_TIMER_PERIOD: Final = 0.1
"""Seconds from one asking to the next, the least of a timer that interrupts."""
_NAME_SUFFIXES: Final = ("", "_on", "_answer", "_trap")


def with_interrupts(job: Legalisation) -> Program:
    """The program with what RAPID has for its interrupts."""
    found = {one.name.lower(): one for one in interrupts(job.program)}
    if not found:
        return job.program
    return _InterruptLowering(job, found).said()


class _InterruptLowering:
    """names: of the variable, the flag, the answer and the trap routine of each interrupt."""

    def __init__(self, job: Legalisation, found: dict[str, p.Interrupt]) -> None:
        self.job, self.found = job, found
        program = job.program
        self.naming = NAMES.naming(program)
        taken = TakenNames(declared(program))
        self.names: dict[str, list[str]] = {}
        for key, node in found.items():
            # Room for the longest suffix, and for two digits that make the name unique.
            short = identifier(node.name, taken)[: LONGEST_NAME - len("_answer") - 2]
            made = [identifier(short + suffix, taken) for suffix in _NAME_SUFFIXES]
            taken.update(made)
            self.names[key] = made
        self.signals = {name.lower(): one for name, one in program.signals.items()}

    def said(self) -> Program:
        program = self.job.program
        procedures = [replace(q, body=self.body(q.body)) for q in program.procedures]
        procedures += map(self.answer, self.found.values())
        flags = {names[1]: Variable("truth", e.Truth(False)) for names in self.names.values()}
        return replace(
            program,
            procedures=tuple(procedures),
            variables={**program.variables, **flags},
            declarations=(*self.declarations(), *program.declarations, *self.traps()),
        )

    def declarations(self) -> Iterator[Declaration]:
        for variable, *_ in self.names.values():
            yield _vendor_declaration(f"VAR intnum {variable};")

    def traps(self) -> Iterator[Declaration]:
        for _, _, answer, trap in self.names.values():
            yield _vendor_declaration(f"TRAP {trap}\n{answer};\nENDTRAP")

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            said = (
                self.statement(node)
                if isinstance(node, p.Interrupt | p.SwitchInterrupt | p.SwitchInterrupts)
                else (map_bodies(node, self.body),)
            )
            # The statements that replace an interrupt stand for its source line in findings.
            made += (one if one.span else replace(one, span=node.span) for one in said)
        return tuple(made)

    def statement(
        self, node: p.Interrupt | p.SwitchInterrupt | p.SwitchInterrupts
    ) -> Iterator[p.Statement]:
        with self.job.findings.at(node.span):
            if isinstance(node, p.SwitchInterrupts):
                cure = "switch them one by one"
                self.job.cannot(what="that all interrupts are switched at once", cure=cure)
                return
            key = node.name.lower()
            if key not in self.names:
                self.job.cannot(what=f"the interrupt `{node.name}`", cure="define it")
                return
            variable, flag, answer, trap = self.names[key]
            if isinstance(node, p.Interrupt):
                self.job.changed(
                    f"the interrupt `{node.name}`", f"a trap routine {self.asked(node)}",
                    "see on the robot where it comes, and how soon",
                )  # fmt: skip
                # CONNECT fails for a variable that is connected already, as when the program passes
                # here again.
                yield _vendor_statement(f"IDelete {variable};")
                yield _vendor_statement(f"CONNECT {variable} WITH {trap};")
                yield _vendor_statement(f"{self.order(node, variable)};")
                # An interrupt of the pseudo-program is off until the program switches it on.
                yield _vendor_statement(f"ISleep {variable};")
                yield p.Assign(e.Name(flag), e.Truth(False))
            elif node.state == "on":
                yield _vendor_statement(f"IWatch {variable};")
                yield p.Assign(e.Name(flag), e.Truth(True))
                # The signal interrupts only when it changes; the condition may hold by now.
                yield p.Call(answer)
            else:
                yield _vendor_statement(f"ISleep {variable};")
                yield p.Assign(e.Name(flag), e.Truth(False))

    def signal(self, node: p.Interrupt) -> tuple[str, int] | None:
        """The digital signal whose value alone the condition asks for, and that value."""
        match node.condition:
            case e.Binary("=", e.Name(name), e.Number(0 | 1 as value)):
                signal = self.signals.get(name.lower())
                if signal is not None and signal.kind == "digital":
                    return name, int(value)
        return None

    def asked(self, node: p.Interrupt) -> str:
        if self.signal(node) is not None:
            return "that comes when the signal changes, and is called when it is switched on"
        return f"that asks for its condition every {_TIMER_PERIOD:g} s"

    def order(self, node: p.Interrupt, variable: str) -> str:
        found = self.signal(node)
        if found is None:
            return f"ITimer {_TIMER_PERIOD:g},{variable}"
        name, value = found
        word = "ISignalDI" if self.signals[name.lower()].direction == "input" else "ISignalDO"
        return f"{word} {self.naming.get('signals', name)},{value},{variable}"

    def answer(self, node: p.Interrupt) -> Procedure:
        """The procedure that answers an interrupt while its condition holds."""
        _, flag, answer, _ = self.names[node.name.lower()]
        # The trap may run after the interrupt was switched off, so it asks for the flag as well.
        holds = e.Binary("and", e.Name(flag), node.condition)
        stop, clear, start = (
            _vendor_statement(f"{word};") for word in ("StopMove", "ClearPath", "StartMove")
        )
        leave: Body = (clear, start, _vendor_statement("ExitCycle;"))
        body: Body
        # The rest of the path is cleared before the call: the program does not return to the move.
        if node.ends == e.Truth(True):
            left = (p.Branch(holds, (stop, clear, start, node.call, leave[-1])),)
            body = (p.If(left),)
        else:
            ends = () if node.ends is None else (p.If((p.Branch(node.ends, leave),)),)
            inner: Body = (node.call,)
            # Moves of the answer need a path level of their own, or they would replace the stopped
            # move.
            if self.moves(node.call.procedure):
                inner = (
                    _vendor_statement("StorePath;"),
                    node.call,
                    _vendor_statement("RestoPath;"),
                )
            # A signal that stays does not interrupt again, so the loop asks for it.
            body = (p.While(holds, (stop, *inner, *ends, start)),)
        return with_named_positions(
            Procedure(answer, body, span=node.span), taken_names(self.job.program)
        )

    def moves(self, name: str) -> bool:
        """True if a procedure, or one that it calls, moves the arm, which must then return."""
        known = {q.name.lower(): q for q in self.job.program.procedures}
        pending, seen = [name.lower()], set[str]()
        while pending:
            procedure = known.get(key := pending.pop())
            if procedure is not None and key not in seen:
                seen.add(key)
                pending += called(procedure)
                for node in walk(procedure.body):
                    moves = isinstance(node, p.Opaque) and effect_of(node).moves
                    if moves or isinstance(node, p.Moving):
                        return True
        return False


def _vendor_statement(text: str) -> p.Opaque:
    """A statement of RAPID alone."""
    return p.Opaque(verbatim.LANGUAGE, text, effect=verbatim.effect_of_text(text, "statement"))


def _vendor_declaration(text: str) -> Declaration:
    """A declaration of RAPID alone."""
    (item,) = verbatim.items(text)
    return Declaration(verbatim.LANGUAGE, verbatim.of_node(item, "items"))


_BREAK_FLAG: Final = "broken_off"
_STOPPING_STATEMENTS: Final = ("StopMove;", "ClearPath;", "StartMove;")


def with_breaks(job: Legalisation) -> Program:
    """The program with what RAPID has for its moves that are broken off."""
    program = job.program
    moves = records_in_procedures(program, p.Move, p.MoveCircular, p.MoveJoints)
    if any(_break_condition(one) is not None for one in moves) or any(
        map(_asks_for_break, _applied_functions(program))
    ):
        return _BreakLowering(job).said()
    return program


def _applied_functions(program: Program) -> Iterator[e.Apply]:
    return records_in_procedures(program, e.Apply)


def _break_condition(node: object) -> e.Expression | None:
    return node.until if isinstance(node, p.MoveStatement) else None


def _asks_for_break(part: Any) -> bool:
    return isinstance(part, e.Apply) and part.function.lower() == _BREAK_FLAG


class _BreakLowering:
    """traps: by condition, the variable of its interrupt and its trap routine. flag: tells whether
    the last move was broken off, None where nothing asks for it.
    """

    def __init__(self, job: Legalisation) -> None:
        self.job, program = job, job.program
        self.naming = NAMES.naming(program)
        self.taken = TakenNames(declared(program))
        self.signals = {name.lower(): one for name, one in program.signals.items()}
        self.traps: dict[e.Expression, tuple[str, str]] = {}
        self.procedures: list[Procedure] = []
        self.declared: list[Declaration] = []
        asked = any(map(_asks_for_break, _applied_functions(program)))
        self.flag = e.Name(self._free(_BREAK_FLAG)) if asked else None
        self.inside = _interrupt_procedures(program)

    def _free(self, name: str) -> str:
        made = identifier(name, self.taken)
        self.taken.add(made)
        return made

    def said(self) -> Program:
        program = self.job.program
        procedures = [
            replace(q, body=self.body(q, q.body)) for q in program.procedures
        ] + self.procedures
        variables = dict(program.variables)
        if self.flag is not None:
            variables[self.flag.name] = Variable("number", e.Number(0))
        numbers = (
            _vendor_declaration(f"VAR intnum {variable};") for variable, _ in self.traps.values()
        )
        return replace(
            program,
            procedures=tuple(procedures),
            variables=variables,
            declarations=(*numbers, *program.declarations, *self.declared),
        )

    def body(self, owner: Procedure, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            if self.flag is not None:
                node = map_expressions(node, self.read)
            until = _break_condition(node)
            if until is None or not isinstance(node, p.MoveStatement):
                made.append(map_bodies(node, lambda inner: self.body(owner, inner)))
                continue
            with self.job.findings.at(node.span):
                said = tuple(self.move(owner, replace(node, until=None), until))
            made += (one if one.span else replace(one, span=node.span) for one in said)
        return tuple(made)

    def read(self, x: e.Expression) -> e.Expression:
        return self.flag if _asks_for_break(x) and self.flag is not None else x

    def move(
        self, owner: Procedure, move: p.MoveStatement, until: e.Expression
    ) -> Iterator[p.Statement]:
        if owner.name.lower() in self.inside:
            cure = "break it off in the program itself"
            self.job.cannot("that a move of an interrupt is broken off", cure)
        order = self.order(owner, until)
        variable, trap = self.trap(until, move)
        # An earlier pass may have left the variable connected.
        yield _vendor_statement(f"IDelete {variable};")
        yield _vendor_statement(f"CONNECT {variable} WITH {trap};")
        # Ordered before the condition is asked, so that a change between the two is not missed.
        yield _vendor_statement(f"{order},{variable};")
        # The signal interrupts only when it changes: with a condition that holds already the move
        # must not begin.
        if self.flag is None:
            yield p.If((p.Branch(_negated(until), (move,)),))
        else:
            came = p.Branch(until, (p.Assign(self.flag, e.Number(1)),))
            yield p.If((came,), (p.Assign(self.flag, e.Number(0)), move))
        # Otherwise the trap would stop a later move.
        yield _vendor_statement(f"IDelete {variable};")

    def order(self, owner: Procedure, until: e.Expression) -> str:
        """Return the instruction that orders the interrupt, without its variable."""
        found = self.signal(until)
        if found is not None:
            name, value = found
            word = "ISignalDI" if self.signals[name.lower()].direction == "input" else "ISignalDO"
            return rf"{word}\Single,{self.naming.get('signals', name)},{value}"
        names = {one.name.lower() for one in records(until) if isinstance(one, e.Name)}
        # The trap routine cannot see the data of the routine that moves.
        if own := sorted(names & locals_of(owner)):
            cure = "keep that in a variable of the program"
            self.job.cannot(f"a move that `{own[0]}` of `{owner.name}` breaks off", cure)
        return f"ITimer {_TIMER_PERIOD:g}"

    def signal(self, until: e.Expression) -> tuple[str, int] | None:
        """Return the digital signal that is the only condition, and its value."""
        match until:
            case e.Binary("=", e.Name(name), e.Number(0 | 1 as value)):
                signal = self.signals.get(name.lower())
                if signal is not None and signal.kind == "digital":
                    return name, int(value)
        return None

    def trap(self, until: e.Expression, move: p.MoveStatement) -> tuple[str, str]:
        """The variable and the trap routine of a condition, made where it is met first."""
        # The same condition breaks off several moves with one trap routine.
        if until not in self.traps:
            names = self._free("break_move"), self._free("break_move_trap")
            self.traps[until] = names
            self.make(until, names[1], move)
        return self.traps[until]

    def make(self, until: e.Expression, trap: str, move: p.MoveStatement) -> None:
        plain = self.signal(until) is not None
        how = "as the signal changes" if plain else f"that asks for it every {_TIMER_PERIOD:g} s"
        self.job.changed(
            "a move that is broken off", f"a trap routine {how}",
            "see on the robot how far it comes",
        )  # fmt: skip
        if plain:
            lines = [*_STOPPING_STATEMENTS]
            if self.flag is not None:
                lines.append(f"{self.flag.name}:=1;")
        else:
            answer = self._free("break_move_now")
            told = () if self.flag is None else (p.Assign(self.flag, e.Number(1)),)
            branch = p.Branch(until, (*map(_vendor_statement, _STOPPING_STATEMENTS), *told))
            self.procedures.append(Procedure(answer, (p.If((branch,)),), span=move.span))
            lines = [f"{answer};"]
        text = "\n".join((f"TRAP {trap}", *lines, "ENDTRAP"))
        self.declared.append(_vendor_declaration(text))


def _negated(x: e.Expression) -> e.Expression:
    match x:
        case e.Binary("=", left, right):
            return e.Binary("<>", left, right)
        case e.Binary("<>", left, right):
            return e.Binary("=", left, right)
        case e.Unary("not", operand):
            return operand
    return e.Unary("not", x)


def _interrupt_procedures(program: Program) -> set[str]:
    """The procedures that interrupts call, with those that these call, in lower case."""
    known = {q.name.lower(): q for q in program.procedures}
    pending, found = [one.call.procedure.lower() for one in interrupts(program)], set[str]()
    while pending:
        key = pending.pop()
        if key in known and key not in found:
            found.add(key)
            pending += called(known[key])
    return found
