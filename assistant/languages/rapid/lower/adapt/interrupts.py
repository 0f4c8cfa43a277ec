"""Interrupts as trap routines.

An interrupt of RAPID comes when a signal changes. What is watched for is that a condition holds: a
procedure answers it again and again while that is so. The trap routine of the signal calls it, and
so does whoever switches the interrupt on, as the condition may hold by then. Any other condition is
asked by a timer. The arm is stopped meanwhile, and let go behind it.

Kernel manual, Interrupts; reference manual of instructions, ISignalDI, ITimer, StopMove, ClearPath.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from assistant.languages.rapid.lower.names import NAMES
from assistant.languages.rapid.tables.words import LONGEST_NAME
from assistant.languages.rapid.text import effects, verbatim
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import called, declared
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
from assistant.program.rewriting import Body, map_bodies
from assistant.program.undeclared_names import interrupts
from assistant.program.vendor_statements import effect_of

TIMER_PERIOD: Final = 0.1
"""Seconds from one asking to the next, the least of a timer that interrupts."""
NAME_SUFFIXES: Final = ("", "_on", "_answer", "_trap")


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
            short = identifier(node.name, taken)[: LONGEST_NAME - len("_answer") - 2]
            made = [identifier(short + suffix, taken) for suffix in NAME_SUFFIXES]
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
            yield vendor_declaration(f"VAR intnum {variable};")

    def traps(self) -> Iterator[Declaration]:
        for _, _, answer, trap in self.names.values():
            yield vendor_declaration(f"TRAP {trap}\n{answer};\nENDTRAP")

    def body(self, body: Body) -> Body:
        made: list[p.Statement] = []
        for node in body:
            said = (
                self.statement(node)
                if isinstance(node, p.Interrupt | p.SwitchInterrupt | p.SwitchInterrupts)
                else (map_bodies(node, self.body),)
            )
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
                yield vendor_statement(f"IDelete {variable};")
                yield vendor_statement(f"CONNECT {variable} WITH {trap};")
                yield vendor_statement(f"{self.order(node, variable)};")
                yield vendor_statement(f"ISleep {variable};")
                yield p.Assign(e.Name(flag), e.Truth(False))
            elif node.state == "on":
                yield vendor_statement(f"IWatch {variable};")
                yield p.Assign(e.Name(flag), e.Truth(True))
                yield p.Call(answer)
            else:
                yield vendor_statement(f"ISleep {variable};")
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
        return f"that asks for its condition every {TIMER_PERIOD:g} s"

    def order(self, node: p.Interrupt, variable: str) -> str:
        found = self.signal(node)
        if found is None:
            return f"ITimer {TIMER_PERIOD:g},{variable}"
        name, value = found
        word = "ISignalDI" if self.signals[name.lower()].direction == "input" else "ISignalDO"
        return f"{word} {self.naming.get('signals', name)},{value},{variable}"

    def answer(self, node: p.Interrupt) -> Procedure:
        """The procedure that answers an interrupt while its condition holds."""
        _, flag, answer, _ = self.names[node.name.lower()]
        holds = e.Binary("and", e.Name(flag), node.condition)
        stop, clear, start = (
            vendor_statement(f"{word};") for word in ("StopMove", "ClearPath", "StartMove")
        )
        leave: Body = (clear, start, vendor_statement("ExitCycle;"))
        body: Body
        if node.ends == e.Truth(True):
            left = (p.Branch(holds, (stop, clear, start, node.call, leave[-1])),)
            body = (p.If(left),)
        else:
            ends = () if node.ends is None else (p.If((p.Branch(node.ends, leave),)),)
            inner: Body = (node.call,)
            if self.moves(node.call.procedure):
                inner = (vendor_statement("StorePath;"), node.call, vendor_statement("RestoPath;"))
            body = (p.While(holds, (stop, *inner, *ends, start)),)
        return with_named_positions(
            Procedure(answer, body, span=node.span), taken_names(self.job.program)
        )

    def moves(self, name: str) -> bool:
        """Whether a procedure, or what it calls, moves the arm, which goes back for that."""
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


def vendor_statement(text: str) -> p.Opaque:
    """A statement of RAPID alone."""
    return p.Opaque(verbatim.LANGUAGE, text, effect=effects.effect_of_text(text, "statement"))


def vendor_declaration(text: str) -> Declaration:
    """A declaration of RAPID alone."""
    (item,) = verbatim.items(text)
    return Declaration(verbatim.LANGUAGE, verbatim.of_node(item, "items"))
