"""Parameters, results and variables of procedures as a language without them has to say them.

In MELFA-BASIC IV and V a subroutine has no parameters, no result and no variables of its own:
they become variables of the program. A call becomes assignments to the parameters and the
call, a parameter that is the caller's own variable is copied back, and a function is called
before the statement that needs its result.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

from assistant.languages.melfa_basic import rules
from assistant.languages.melfa_basic.adapt.evaluation import altered, read_before, shared
from assistant.languages.melfa_basic.adapt.hoisting import Taken, hoisted
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.diagnostics import Findings
from assistant.program.program import (
    Procedure,
    Program,
    ValueType,
    Variable,
    bodies,
    identifier,
)
from assistant.program.rewriting import Body, head, map_head, records, rewrite

NOTHING: Final[dict[ValueType, e.Expression]] = {
    "number": e.Number(0), "integer": e.Number(0), "truth": e.Number(0), "text": e.Text(""),
}  # fmt: skip
"""What a variable holds that was given no value, where a type has such a value."""


@dataclass(frozen=True, slots=True)
class _Form:
    """parameters: names of the variables that stand for them, in order. result: of its variable."""

    procedure: Procedure
    parameters: tuple[str, ...]
    result: str


def with_fresh_variables(procedure: Procedure) -> Procedure:
    """Variables of a procedure that begin anew with each call are given their first value there."""
    first: list[p.Statement] = []
    variables = dict(procedure.variables)
    for name, variable in procedure.variables.items():
        if variable.storage != "variable" or variable.size:
            continue
        value = variable.initial
        if value is None and not _is_set_first(name, procedure.body):
            value = NOTHING.get(variable.type)
        if value is not None:
            variables[name] = replace(variable, initial=None)
            first.append(p.Assign(e.Name(name), value, span=variable.span))
    if not first:
        return procedure
    return replace(procedure, variables=variables, body=(*first, *procedure.body))


def _is_set_first(name: str, body: Body) -> bool:
    """Whether each way through the body sets a variable before it is used; if in doubt, not."""
    key = name.lower()
    for node in body:
        match node:
            case p.Assign(e.Name(target), value) if target.lower() == key:
                return not _mentions(value, key)
            case p.For(variable, first, last) if variable.lower() == key:
                return not _mentions((first, last), key)
            case p.Opaque():
                return False
        if _mentions(head(node), key):
            return False
        if not all(_is_set_first(name, inner) for inner in bodies(node)):
            return False
    return True


def _mentions(value: Any, key: str) -> bool:
    return any(isinstance(r, e.Name) and r.name.lower() == key for r in records(value))


def without_parameters(program: Program, findings: Findings) -> Program:
    """The program with variables for the parameters and results of its procedures.

    The procedure that a called program begins with keeps parameters that are copies: `CallP`
    takes arguments.
    """
    taken = _names(program)
    forms: dict[str, _Form] = {}
    variables = dict(program.variables)
    for procedure in program.procedures:
        if is_called_with_arguments(procedure, program) or not has_form(procedure):
            continue
        made = {}
        for q in procedure.parameters:
            made[q.name] = _fresh(f"{procedure.name}_{q.name}", taken)
            variables[made[q.name]] = Variable(q.type)
        result = ""
        if procedure.result is not None:
            result = _fresh(f"{procedure.name}_result", taken)
            variables[result] = Variable(procedure.result)
        forms[procedure.name.lower()] = _Form(procedure, tuple(made.values()), result)
        place = procedure.name
        with findings.at(procedure.span):
            findings.append(rules.AS_VARIABLES(name=procedure.name, place=place))
    if not forms:
        return program
    _refuse_other_order(program, forms, findings)
    procedures = tuple(_plain(q, forms, taken) for q in program.procedures)
    return replace(program, procedures=procedures, variables=variables)


def _refuse_other_order(program: Program, forms: dict[str, _Form], findings: Findings) -> None:
    """An error at each statement that would say another thing with its calls in front of it."""
    changed = altered(program.procedures)
    alters = {key: changed[key] for key in forms}
    for node in program.statements():
        alone = [b.condition for b in node.branches] if isinstance(node, p.If) else [head(node)]
        read = [pair for value in alone for pair in read_before(value, alters)]
        with findings.at(node.span):
            for name, function in dict.fromkeys(read):
                findings.append(rules.CANNOT_SAY(
                    what=f"that `{name}` is read before `{function}` changes it",
                    cure="call it in an assignment of its own, and keep the value before it",
                ))  # fmt: skip
            if isinstance(node, p.Call) and node.procedure.lower() in forms:
                callee = forms[node.procedure.lower()].procedure
                for name in dict.fromkeys(shared(node, callee, changed)):
                    findings.append(rules.CANNOT_SAY(
                        what=f"that `{name}` changes in two ways in the call of `{callee.name}`",
                        cure="hand over a variable of its own, and assign it after the call",
                    ))  # fmt: skip


def has_form(procedure: Procedure) -> bool:
    return bool(procedure.parameters) or procedure.result is not None


def is_called_with_arguments(procedure: Procedure, program: Program) -> bool:
    """Whether `CallP` hands a procedure its arguments: it begins a unit, and takes copies."""
    if procedure.unit is None or procedure.result is not None:
        return False
    first = next(q for q in program.procedures if q.unit == procedure.unit)
    return first.name == procedure.name and all(q.mode == "in" for q in procedure.parameters)


def recursive(program: Program) -> Iterator[Procedure]:
    """Procedures with parameters, a result or variables that call themselves, in the end."""
    calls = {q.name.lower(): set(_called(q.body)) for q in program.procedures}
    for procedure in program.procedures:
        if not has_form(procedure) and not procedure.variables:
            continue
        name = procedure.name.lower()
        reached: set[str] = set()
        pending = list(calls[name])
        while pending:
            callee = pending.pop()
            if callee in calls and callee not in reached:
                reached.add(callee)
                pending += calls[callee]
        if name in reached:
            yield procedure


def _called(body: Body) -> Iterator[str]:
    for record in records(body):
        match record:
            case p.Call(name) | e.Apply(name):
                yield name.lower()


def _plain(procedure: Procedure, forms: dict[str, _Form], taken: set[str]) -> Procedure:
    form = forms.get(procedure.name.lower())
    body = procedure.body
    parameters, result = procedure.parameters, procedure.result
    if form is not None:
        given = zip(parameters, form.parameters, strict=True)
        body = _renamed(body, {q.name.lower(): name for q, name in given})
        parameters, result = (), None
    take = _Calls(forms, form.result if form else "", taken)
    body = hoisted(body, take)
    return replace(
        procedure,
        body=body,
        parameters=parameters,
        result=result,
        variables={**procedure.variables, **take.variables},
    )


def _renamed(body: Body, names: dict[str, str]) -> Body:
    def visit(node: Any) -> Any:
        match node:
            case e.Name(name) if name.lower() in names:
                return e.Name(names[name.lower()])
            case p.For(variable) if variable.lower() in names:
                return replace(node, variable=names[variable.lower()])
        return node

    return rewrite(body, visit)


class _Calls:
    """Takes calls out of the statements of one procedure.

    result: the variable that its own result goes to. variables: those that it needed.
    """

    def __init__(self, forms: dict[str, _Form], result: str, taken: set[str]) -> None:
        self.forms, self.result, self.taken = forms, result, taken
        self.variables: dict[str, Variable] = {}

    def __call__(self, node: p.Statement) -> Taken:
        made = Taken(node)
        functions = (r.function.lower() for r in records(head(node)) if isinstance(r, e.Apply))
        often = Counter(functions)
        number = 0

        def visit(value: e.Expression) -> e.Expression:
            nonlocal number
            if not isinstance(value, e.Apply) or value.function.lower() not in self.forms:
                return value
            form = self.forms[value.function.lower()]
            self.call(made.before, form, value.arguments)
            if often[value.function.lower()] == 1:
                return e.Name(form.result)
            number += 1
            kept = self.kept(form, number)
            made.before.append(p.Assign(kept, e.Name(form.result)))
            return kept

        made.statement = map_head(node, visit)
        match made.statement:
            case p.Call(name, arguments) if name.lower() in self.forms:
                before: list[p.Statement] = []
                form = self.forms[name.lower()]
                self.call(before, form, arguments)
                at = next(i for i, x in enumerate(before) if isinstance(x, p.Call))
                made.before += before[:at]
                made.statement = replace(made.statement, arguments=())
                made.after += before[at + 1 :]
            case p.Return(value) if value is not None and self.result:
                made.before.append(p.Assign(e.Name(self.result), value))
                made.statement = replace(made.statement, value=None)
        return made

    def call(
        self, out: list[p.Statement], form: _Form, arguments: tuple[e.Expression, ...]
    ) -> None:
        """Copies of the arguments, the call, and what it changed copied back."""
        back: list[p.Statement] = []
        given = zip(form.procedure.parameters, form.parameters, arguments, strict=False)
        for parameter, name, value in given:
            out.append(p.Assign(e.Name(name), value))
            if parameter.mode == "inout" and isinstance(value, e.Name | e.Index | e.Member):
                back.append(p.Assign(value, e.Name(name)))
        out.append(p.Call(form.procedure.name, unit=form.procedure.unit))
        out += back

    def kept(self, form: _Form, number: int) -> e.Name:
        """A variable that keeps a result while the function is called again."""
        stem = f"{form.result}_{number}"
        if stem not in self.variables:
            self.taken.add(stem)
            self.variables[stem] = Variable(form.procedure.result or "number")
        return e.Name(stem)


def _names(program: Program) -> set[str]:
    """Every name that a variable may not have."""
    names = {
        *program.targets, *program.joint_targets, *program.signals, *program.variables,
        *program.tools, *program.frames,
    }  # fmt: skip
    for procedure in program.procedures:
        names.update((*procedure.variables, *(q.name for q in procedure.parameters)))
    names.update(r.variable for r in program.statements() if isinstance(r, p.For))
    return names


def _fresh(name: str, taken: set[str]) -> str:
    made = identifier(name, taken)
    taken.add(made)
    return made
