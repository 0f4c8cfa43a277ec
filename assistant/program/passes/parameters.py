"""Parameters and results of procedures, for a language without them.

There they become variables of the program. A call becomes assignments to the parameters and the
call, a parameter that is the caller's own variable is copied back, and a function is called before
the statement that needs its result. Where a procedure may use the caller's variable by another name
as well, a copy of the procedure works on that variable itself. What cannot be expressed in this way
is an error.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import field, replace
from itertools import zip_longest
from typing import Any, Final

from assistant.base.data_classes import dataclass
from assistant.base.diagnostics import Declared, Rule
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.uses import (
    along_calls,
    altered,
    base_variable,
    called_by,
    declared,
    handed_over,
    locals_of,
    mentioned_variables,
    names_in,
    names_in_procedure,
    read_before,
    unordered,
)
from assistant.program.expressions import unknown_effect
from assistant.program.passes.hoisted_statements import Taken, hoisted
from assistant.program.passes.legalisation import Legalisation
from assistant.program.passes.line_lengths import LineWidths, procedures_too_long
from assistant.program.passes.procedure_forms import has_form, is_called_with_arguments
from assistant.program.program import (
    Parameter,
    Procedure,
    Program,
    TakenNames,
    Variable,
    identifier,
    walk,
)
from assistant.program.rewriting import Body, head, map_head, records, rewrite


def _refuse_kept_texts(job: Legalisation, procedure: Procedure) -> None:
    """Report an error for each vendor text that names a parameter: it would name another variable
    then.
    """
    own = {parameter.name.lower(): parameter.name for parameter in procedure.parameters}
    for node in walk(procedure.body):
        for part in records(head(node)) if own else ():
            # Vendor text whose effect is unknown may name anything in it.
            if isinstance(part, p.Opaque | e.Verbatim):
                effect = unknown_effect(part.text) if part.effect is None else part.effect
                for name in sorted(effect.names & own.keys()):
                    what = f"`{part.text}`, which names the parameter `{own[name]}`"
                    with job.findings.at(node.span):
                        job.cannot(what, "say it in plain statements")


def _refuse_other_order(
    job: Legalisation,
    body: Body,
    called: Mapping[str, Procedure],
    alters: Mapping[str, frozenset[str]],
) -> None:
    """An error at each statement that would say another thing with its calls in front of it.

    called: procedures with parameters or a result. alters: what each procedure changes beyond its
    own variables. Names are in lower case.
    """
    for node in walk(body):
        if isinstance(node, p.WaitUntil) and node.timeout is not None:
            _refuse_once(job, node, called)
        alone = [b.condition for b in node.branches] if isinstance(node, p.If) else [head(node)]
        read = [pair for x in alone for pair in read_before(x, called, alters)]
        with job.findings.at(node.span):
            for name, function in dict.fromkeys(read):
                job.cannot(
                    what=f"that {called_by(name)} is read before `{function}` changes it",
                    cure="assign it to a variable in a statement before, and read that",
                )


def _refuse_once(job: Legalisation, node: p.WaitUntil, called: Mapping[str, Procedure]) -> None:
    """An error at a wait with a limit for what a call tells: it would be called once only."""
    for record in records(node.condition):
        if isinstance(record, e.Apply) and record.function.lower() in called:
            with job.findings.at(node.span):
                job.cannot(
                    what=f"a wait with a limit that calls `{record.function}` again and again",
                    cure="call it in a loop that waits a little and reads a clock",
                )


_MOST_COPIES: Final = 200
"""Procedures that are made of one with parameters; more is no program that anybody reads."""


def with_sayable_procedures(job: Legalisation) -> Program:
    """The program with procedures that the language has; in one with functions all of them are."""
    can = job.can.procedures
    if can is not None and not can.functions:
        return _without_parameters(job, can.as_variables)
    program = job.program
    long = (
        procedures_too_long(program, LineWidths(can.longest, can.longest_name))
        if can is not None
        else ()
    )
    if can is not None and long:
        program = _without_parameters(job, can.as_variables, long)
    job.findings.extend(unordered(program, job.can.cannot_say))
    return program


def _without_parameters(
    job: Legalisation, told: Rule, only: Container[str] | None = None
) -> Program:
    """The program with variables for the parameters and results of its procedures.

    None of those that have some may call itself. The procedure that a called program begins
    with keeps parameters that are copies: such calls take arguments. only: lower-case names of
    those that lose theirs, None for all.
    """
    program = job.program
    formed = [
        q for q in program.procedures
        if has_form(q) and not is_called_with_arguments(q, program)
        and (only is None or q.name.lower() in only)
    ]  # fmt: skip
    for procedure in formed:
        about = Declared(procedure.name, "procedures")
        with job.findings.at(procedure.span):
            job.findings.append(told(name=procedure.name, about=about))
        _refuse_kept_texts(job, procedure)
    return _Forms(job, formed).program() if formed else program


@dataclass(frozen=True, slots=True)
class _Form:
    """A procedure without parameters.

    procedure: what it is made of. name: that it is called by. names: what each parameter is in
    its body, by lower-case name: a variable, or the place that it works on itself.
    """

    procedure: Procedure
    name: str
    names: Mapping[str, e.Expression] = field(default_factory=dict)


class _Forms:
    """Forms of the procedures of a program.

    called: those with parameters or a result, by lower-case name. variables: of the program.
    reaches: procedures that run during a procedure, including itself.
    """

    def __init__(self, job: Legalisation, formed: Iterable[Procedure]) -> None:
        self.job, self.whole = job, job.program
        program = job.program
        self.called = {q.name.lower(): q for q in formed}
        self.variables = dict(program.variables)
        self.spelled = {name.lower(): name for name in program.variables}
        counters = (x.variable for x in program.statements() if isinstance(x, p.For))
        self.taken = TakenNames((*declared(program), *counters))
        self.declarations = Counter(self._all_names())
        self.titles = TakenNames(q.name for q in program.procedures)
        self.alters, self.mentions = altered(program), mentioned_variables(program)
        alone = {q.name.lower(): frozenset([q.name.lower()]) for q in program.procedures}
        self.reaches = along_calls(program, alone)
        self.unsteady = {name.lower() for name in program.signals}
        self.made: dict[tuple[Any, ...], _Form] = {}
        self.named: dict[tuple[str, ...], str] = {}
        self.keeping: dict[tuple[str, int], str] = {}

    def program(self) -> Program:
        """The program in which every procedure has its form, each behind what it is made of."""
        written: dict[str, list[Procedure]] = {q.name.lower(): [] for q in self.whole.procedures}
        waiting = [q for key, q in self._by_name() if key not in self.called]
        rest = [q for key, q in self._by_name() if key in self.called]
        forms = [_Form(q, q.name) for q in waiting]
        # A form may need further forms: until no new one is made.
        done = 0
        while True:
            for form in forms:
                written[form.procedure.name.lower()].append(self._written(form))
            forms = [*self.made.values()][done:]
            done += len(forms)
            if not forms:
                # Procedures that nothing calls are written as well.
                uncalled = [q for q in rest if not written[q.name.lower()]]
                if not uncalled:
                    break
                self.form(uncalled[0], ())
        procedures = tuple(q for of_one in written.values() for q in of_one)
        return replace(self.whole, procedures=procedures, variables=self.variables)

    def _by_name(self) -> Iterator[tuple[str, Procedure]]:
        return ((q.name.lower(), q) for q in self.whole.procedures)

    def _all_names(self) -> Iterator[str]:
        """Names in lower case that mean something, once for each declaration or place of use.

        A procedure that uses what it declares counts once.
        """
        program = self.whole
        yield from declared(replace(program, procedures=()))
        others = (program.declarations, program.variables, program.speeds, program.blends)
        yield from set(map(str.lower, names_in(others)))
        yield from (name.lower() for name in (*program.speeds, *program.blends))
        for procedure in program.procedures:
            yield procedure.name.lower()
            yield from names_in_procedure(procedure) | locals_of(procedure)

    def variable(self, kind: str, *stem: str, of: Variable) -> str:
        """Return a variable of the program, the same one for each request.

        kind: its purpose, so that two with one stem are not the same. It has the last name of the
        stem if nothing else in the program has that name, else the whole stem.
        """
        key = kind, *stem
        if key not in self.named:
            name, last = identifier("_".join(stem), self.taken), stem[-1]
            alone = self.declarations[last.lower()] == 1 and identifier(last) == last
            if kind == "parameter" and alone:
                name = last
            self.taken.add(name)
            self.named[key] = name
            self.variables[name] = of
        return self.named[key]

    def parameter(self, procedure: Procedure, parameter: Parameter) -> str:
        of = Variable(parameter.type)
        return self.variable("parameter", procedure.name, parameter.name, of=of)

    def stays(self, parameter: Parameter) -> bool:
        """True if a parameter remains one: an array, where the language has parameters."""
        can = self.job.can.procedures
        return bool(parameter.dimensions) and can is not None and can.functions

    def result(self, procedure: Procedure) -> str:
        of = Variable(procedure.result or "number")
        name = self.variable("result", procedure.name, "result", of=of)
        self.unsteady.add(name.lower())
        return name

    def keeper(self, callee: Procedure, number: int) -> str:
        """The name of the variable in which a procedure keeps a result."""
        key = callee.name.lower(), number
        if key not in self.keeping:
            self.keeping[key] = identifier(f"{self.result(callee)}_{number}", self.taken)
            self.taken.add(self.keeping[key])
        return self.keeping[key]

    def form(self, procedure: Procedure, places: tuple[e.Expression | None, ...]) -> _Form:
        """The form of a procedure that works on places of the caller's.

        places: of each parameter, None for one that is a copy; none at all if all are copies.
        """
        # Copies need no form of their own.
        key = procedure.name.lower(), places if any(places) else ()
        if key not in self.made and len(self.made) >= _MOST_COPIES:
            key = key[0], ()
            with self.job.findings.at(procedure.span):
                self.job.cannot(
                    what=f"so many calls of `{procedure.name}` with variables that it uses by "
                    "another name as well",
                    cure="hand over variables of their own, and assign them after the call",
                    about=Declared(procedure.name, "procedures"),
                )
        if key not in self.made:
            # The first form keeps the name of the procedure.
            again = any(made.procedure is procedure for made in self.made.values())
            name = identifier(procedure.name, self.titles) if again else procedure.name
            self.titles.add(name)
            given = zip_longest(procedure.parameters, key[1])
            names = {
                q.name.lower(): place or e.Name(self.parameter(procedure, q))
                for q, place in given
                if not self.stays(q)
            }
            self.made[key] = _Form(procedure, name, names)
        return self.made[key]

    def _written(self, form: _Form) -> Procedure:
        """Return the form as the program contains it."""
        procedure = form.procedure
        moved = self._moved(form)
        names = {**form.names, **{key: e.Name(name) for key, name in moved.items()}}
        with self.job.findings.at(procedure.span):
            body = self._renamed(procedure.body, names)
        has = procedure.name.lower() in self.called
        kept = {n: v for n, v in procedure.variables.items() if n.lower() not in moved}
        own = frozenset(name.lower() for name in kept)
        alters = {key: names - own for key, names in self.alters.items()}
        _refuse_other_order(self.job, body, self.called, alters)
        take = _Calls(self, own, self.result(procedure) if has and procedure.result else "")
        body = hoisted(body, take)
        return replace(
            procedure,
            name=form.name,
            body=body,
            parameters=tuple(q for q in procedure.parameters if not has or self.stays(q)),
            result=None if has else procedure.result,
            variables={**kept, **take.variables},
        )

    def _moved(self, form: _Form) -> dict[str, str]:
        """Variables of a procedure that have to be the program's: their names there.

        Those that a call hands over twice, and those that hide what the procedure works on.
        """
        procedure = form.procedure
        wanted = set(map(base_variable, form.names.values()))
        for record in records(procedure.body):
            match record:
                case p.Call(name, arguments) | e.Apply(name, arguments):
                    callee = self.called.get(name.lower())
                    handed = (
                        [base_variable(x) for x in handed_over(callee, arguments)] if callee else []
                    )
                    wanted |= {name for name in handed if handed.count(name) > 1}
        return {
            name.lower(): self.variable("variable", procedure.name, name, of=variable)
            for name, variable in procedure.variables.items()
            if name.lower() in wanted
        }

    def _renamed(self, body: Body, names: Mapping[str, e.Expression]) -> Body:
        def visit(node: Any) -> Any:
            match node:
                case e.Name(name) if name.lower() in names:
                    return names[name.lower()]
                case p.For(variable) if variable.lower() in names:
                    counted = names[variable.lower()]
                    if isinstance(counted, e.Name):
                        return replace(node, variable=counted.name)
                    self.job.cannot(
                        what=f"a loop that counts `{variable}`, a part of the caller's variable",
                        cure="count a variable of its own",
                    )
            return node

        return rewrite(body, visit)


class _Calls:
    """Takes calls out of the statements of one procedure.

    own: its variables, in lower case. result: the variable that its result goes to, if any.
    variables: those that it needs.
    """

    def __init__(self, forms: _Forms, own: frozenset[str], result: str) -> None:
        self.forms, self.own, self.result = forms, own, result
        self.variables: dict[str, Variable] = {}

    def __call__(self, node: p.Statement) -> Taken:
        made = Taken(node)
        applied = (r.function.lower() for r in records(head(node)) if isinstance(r, e.Apply))
        functions = Counter(key for key in applied if key in self.forms.called)
        number = 0

        def visit(value: e.Expression) -> e.Expression:
            nonlocal number
            if not isinstance(value, e.Apply) or value.function.lower() not in functions:
                return value
            key = value.function.lower()
            callee = self.forms.called[key]
            before, call, after = self.call(callee, value.arguments)
            made.before += (*before, call, *after)
            result = e.Name(self.forms.result(callee))
            again = functions - Counter([key])
            # No other call in the statement runs this function again: its result stays in the
            # variable.
            if not any(key in self.forms.reaches[other] for other in again):
                return result
            number += 1
            kept = self.kept(callee, number)
            made.before.append(p.Assign(kept, result))
            return kept

        made.statement = map_head(node, visit)
        match made.statement:
            case p.Call(name, arguments) if name.lower() in self.forms.called:
                before, call, after = self.call(self.forms.called[name.lower()], arguments)
                made.before += before
                made.statement = replace(call, span=node.span)
                made.after += after
            case p.Return(value) if value is not None and self.result:
                made.before.append(p.Assign(e.Name(self.result), value))
                made.statement = replace(made.statement, value=None)
        return made

    def call(
        self, callee: Procedure, arguments: tuple[e.Expression, ...]
    ) -> tuple[list[p.Statement], p.Call, list[p.Statement]]:
        """Return the statements before a call, the call itself, and those that copy changed values
        back.

        A copy is sufficient unless the variable can be used by another name meanwhile.
        """
        mentions = self.forms.mentions[callee.name.lower()]
        handed = [base_variable(place) for place in handed_over(callee, arguments)]
        fixed: list[p.Statement] = []
        copies: list[p.Statement] = []
        back: list[p.Statement] = []
        places: list[e.Expression | None] = []
        arrays: list[e.Expression] = []
        # Everything that the call may change: an index that names it is stored before.
        changing = self.forms.alters[callee.name.lower()] | {*handed, *self.forms.unsteady}
        for q, value in zip(callee.parameters, arguments, strict=False):
            if self.forms.stays(q):
                arrays.append(value)
                places.append(None)
                continue
            name = base_variable(value) if q.mode == "inout" else ""
            # The variable is reachable by two names during the call: a copy would miss changes.
            itself = handed.count(name) > 1 or (name in mentions and name not in self.own)
            if name:
                stem = callee.name, q.name
                value, kept = self.fixed(stem, value, None if itself else changing)
                fixed += kept
            places.append(value if itself else None)
            if not itself:
                variable = e.Name(self.forms.parameter(callee, q))
                # Copied in before the call, and back after it if the parameter is `inout`.
                copies.append(p.Assign(variable, value))
                if name:
                    back.append(p.Assign(value, variable))
        form = self.forms.form(callee, tuple(places))
        return [*fixed, *copies], p.Call(form.name, tuple(arrays), unit=callee.unit), back

    def fixed(
        self, stem: tuple[str, ...], place: e.Expression, changing: frozenset[str] | None
    ) -> tuple[e.Expression, list[p.Statement]]:
        """A place whose indices stay what they are, and what keeps them.

        changing: variables in lower case that an index may not name, None if all are kept.
        """
        kept: list[p.Statement] = []

        def index(value: e.Expression) -> e.Expression:
            if isinstance(value, e.Number) or (
                changing is not None and _is_steady(value, changing)
            ):
                return value
            made = (*stem, "index", str(len(kept) + 1))
            name = e.Name(self.forms.variable("index", *made, of=Variable("number")))
            kept.append(p.Assign(name, value))
            return name

        def walk(value: e.Expression) -> e.Expression:
            match value:
                case e.Member(inner, part):
                    return e.Member(walk(inner), part)
                case e.Index(inner, indices):
                    array = walk(inner)
                    return e.Index(array, tuple(map(index, indices)))
                case e.Name(name):
                    return e.Name(self.forms.spelled.get(name.lower(), name))
            return value

        return walk(place), kept

    def kept(self, callee: Procedure, number: int) -> e.Name:
        """A variable that keeps a result while other functions are called."""
        name = self.forms.keeper(callee, number)
        self.variables[name] = Variable(callee.result or "number")
        return e.Name(name)


def _is_steady(index: e.Expression, changing: frozenset[str]) -> bool:
    """True if an index consists of numbers and variables that a call leaves unchanged."""
    parts = list(records(index))
    plain = all(isinstance(x, e.Number | e.Name | e.Unary | e.Binary) for x in parts)
    return plain and not any(isinstance(x, e.Name) and x.name.lower() in changing for x in parts)
