"""Errors of RAPID and their handlers, as tests behind what may raise them.

Errors that are said: the longest time of a wait, and those that a program raises itself; a
procedure that leaves one to its callers sets a number and goes back. `ExitCycle` leads out of all
procedures in the same way. Any other error stops the program, as it does without a handler.
"""

from __future__ import annotations

from dataclasses import replace

from assistant.base.diagnostics import Findings
from assistant.languages.rapid import rules
from assistant.languages.rapid.lift.statements import StatementLift
from assistant.languages.rapid.lift.told import handlers as h
from assistant.languages.rapid.lift.told import searching
from assistant.languages.rapid.lift.told.handled import ErrorLowering
from assistant.languages.rapid.lift.told.interrupts import with_interrupt_errors
from assistant.languages.rapid.lift.told.raising import ZERO, RaisedErrors
from assistant.program import statements as p
from assistant.program.analysis.io_use import with_used_signals
from assistant.program.program import Procedure, Program, Variable
from assistant.program.rewriting import Body, records


def with_errors(program: Program, lift: StatementLift, findings: Findings) -> Program:
    """The program with its handlers where their errors may happen. lift: of what stands in them."""
    if not any(_involves_errors(node) for node in program.statements()):
        return program
    return _with_error_tests(RaisedErrors(program, lift, findings))


def _involves_errors(node: p.Statement) -> bool:
    if h.handlers_of(node) or searching.is_search(node):
        return True
    return h.raised_error(node) is not None or h.exit_word(node) == "EXITCYCLE"


def _with_error_tests(errors: RaisedErrors) -> Program:
    procedures = tuple(_tested_procedure(errors, key) for key in errors.known)
    signals = with_used_signals(errors.program.signals, errors.meaning.used)
    program = replace(errors.program, procedures=procedures, signals=signals)
    program = with_interrupt_errors(program, errors.error)
    procedures = program.procedures
    if not any(record == errors.error for record in records(procedures)):
        return program
    first: Body = (p.Assign(errors.error, ZERO),)
    procedures = tuple(
        replace(q, body=first + q.body) if q.name.lower() == errors.entry else q for q in procedures
    )
    variables = {**program.variables, errors.error.name: Variable("number")}
    return replace(program, procedures=procedures, variables=variables)


def _tested_procedure(errors: RaisedErrors, key: str) -> Procedure:
    one = errors.known[key]
    if one.text is not None:
        said = sorted(x for x in errors.raised(key) if errors.left(key, x) is not None)
        with errors.findings.at(one.text.span):
            errors.findings.append(rules.HANDLED(
                name=one.procedure.name, errors=", ".join(said) or "none of its errors"
            ))  # fmt: skip
    making = ErrorLowering(errors, key)
    body = making.body(one.procedure.body)
    return replace(one.procedure, body=body, variables={**one.procedure.variables, **making.own})
