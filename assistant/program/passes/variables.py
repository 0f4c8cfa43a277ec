"""Variables: first values, values kept between cycles, arrays, and predefined names.

First values are given at the top of the program, and so again at each cycle, for controllers that
begin the next cycle at the first line. Where a cycle may read what the one before left, a loop
without end goes around it; where that cannot be, that is another program, and a finding says so.
An array whose declaration gives no values gets them one by one, or by loops.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from assistant.base.diagnostics import Declared
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.analysis.definite_assignment import AssignmentAnalysis
from assistant.program.analysis.motion_use import Setting, left_settings
from assistant.program.analysis.uses import changed_locals, changed_variables, declared
from assistant.program.expressions import Name
from assistant.program.passes.procedure_forms import NOTHING
from assistant.program.program import Procedure, Program, ValueType, Variable, identifier
from assistant.program.rewriting import Body, map_bodies, records, rewrite
from assistant.program.statement_index import (
    names_in_procedures,
    records_in_body,
    records_in_procedures,
)
from assistant.program.undeclared_names import interrupts

if TYPE_CHECKING:
    from assistant.program.passes.legalisation import Legalisation

SCALAR: Final = frozenset({"number", "integer", "truth", "text"})
"""Types of persistent data that begin with nothing where no text gives them a value."""


def with_first_values(job: Legalisation) -> Program:
    """Return the program with values for the variables that it reads before it assigns one.

    In a program of the same kin, a variable without a value keeps its value on the controller.
    """
    program, findings, can = job.program, job.findings, job.can.variables
    entry = program.procedure(program.entry) if program.entry else None
    if entry is None or can is None:
        return program
    assigning = AssignmentAnalysis(program)
    run = assigning.run(entry)
    # A program of the same kin keeps its values on the controller.
    kept = program.origin is not None and program.origin.language in job.can.kin
    variables: dict[str, Variable] = {}
    for name, variable in program.variables.items():
        key = name.lower()
        variables[name] = variable
        # Constants, and what is assigned before it is read, need no value here.
        if variable.storage == "constant" or key not in run.read:
            continue
        # All programs of the controller share it: its value comes from elsewhere.
        if variable.initial is None and can.external(name, variable):
            continue
        place = variable.storage == "persistent" and variable.type not in SCALAR
        if variable.initial is None and not kept and not place:  # which nothing says: no move there
            variable = replace(variable, initial=NOTHING[variable.type])
            variables[name] = variable
        if variable.initial is not None:
            about = Declared(name, "variables")
            changes = key in assigning.written and run.ends
            with findings.at(variable.span):
                if variable.storage == "persistent":
                    findings.append(can.persistent(name=name, about=about))
                if changes:
                    findings.append(can.carried(name=name, about=about))
    return replace(program, variables=_by_dependency(variables))


def with_taught_positions(job: Legalisation) -> Program:
    """Return the program with a target for each persistent position that nothing in it changes.

    Such a controller keeps targets beside the program, where a person may teach them: a first value
    in the program would overwrite what was taught. For the same reason arrays of places that
    nothing changes are constants from here on, see `with_filled_arrays`.
    """
    program, can = _with_constant_arrays(job), job.can.variables
    kept = program.origin is not None and program.origin.language in job.can.kin
    positions = {
        name: variable.initial.target
        for name, variable in program.variables.items()
        if variable.storage == "persistent" and isinstance(variable.initial, e.TargetValue)
    }
    if can is None or kept or not positions:
        return program
    changed = changed_variables(program)
    targets = {name: x for name, x in positions.items() if name.lower() not in changed}
    variables = {name: one for name, one in program.variables.items() if name not in targets}
    return replace(program, targets={**program.targets, **targets}, variables=variables)


def _with_constant_arrays(job: Legalisation) -> Program:
    """Return the program whose arrays of stated places are constants if nothing changes them."""
    program, can = job.program, job.can.variables

    def stored(
        variables: Mapping[str, Variable], changed: Callable[[], frozenset[str]]
    ) -> dict[str, Variable]:
        made = dict(variables)
        for name, one in variables.items():
            if not _is_taught(one, job) or (can is not None and can.external(name, one)):
                continue
            if name.lower() not in changed():
                made[name] = replace(one, storage="constant")
            elif one.storage == "constant":
                made[name] = replace(one, storage="variable")
        return made

    procedures = tuple(
        replace(q, variables=stored(q.variables, partial(changed_locals, program, q)))
        for q in program.procedures
    )
    variables = stored(program.variables, partial(changed_variables, program))
    return replace(program, variables=variables, procedures=procedures)


def _is_taught(variable: Variable, job: Legalisation) -> bool:
    """True for an array of stated places, which the language can keep beside the program."""
    can = job.can.arrays
    if can is None or variable.type not in can.listed or not variable.size:
        return False
    if len(variable.size) > can.dimensions or max(variable.size) > can.elements:
        return False
    if not _has_all_values(variable.initial, variable.size):
        return False
    given = [one for _, one in values_by_place(variable) if one != e.NEVER_GIVEN]
    return bool(given) and all(isinstance(one, e.TargetValue | e.JointValue) for one in given)


def values_by_place(variable: Variable) -> Iterator[tuple[tuple[int, ...], e.Expression]]:
    """The indices and first values of the elements of an array that has one for each."""
    for place in itertools.product(*(range(1, n + 1) for n in variable.size)):
        value = variable.initial
        for index in place:
            assert isinstance(value, e.Aggregate)
            value = value.items[index - 1]
        if value is not None:
            yield place, value


def _by_dependency(variables: dict[str, Variable]) -> dict[str, Variable]:
    """Variables behind those that their first values name, else as they are declared."""
    spelled = {name.lower(): name for name in variables}
    ordered: dict[str, Variable] = {}
    for name in variables:
        pending = [name]
        # Depth first without recursion; names that wait for each other stay as declared.
        while pending:
            first = pending[-1]
            named = (
                x.name.lower() for x in records(variables[first].initial) if isinstance(x, Name)
            )
            needed = [
                spelled[low]
                for low in named
                if low in spelled and spelled[low] not in ordered and spelled[low] not in pending
            ]
            if needed:
                pending += needed[:1]
            else:
                ordered.setdefault(first, variables[first])
                pending.pop()
    return ordered


_CYCLE: Final = "cycle"
"""Name of the procedure that becomes of the one that a program begins with."""
_FOR_EVER: Final = e.Number(1)
_FEW_NAMES: Final = 2
"""Names that a comment in the program tells."""
_MOST_NAMES_REPORTED: Final = 5
"""Names that a finding tells."""
_SETTING_WORDS: Final[Mapping[type[Setting], str]] = {
    p.SetOverride: "the override of speeds",
    p.SetAcceleration: "the acceleration",
}


def with_kept_values(job: Legalisation) -> Program:
    """Return the program with an endless loop around its cycle, if a cycle leaves values to the
    next one.

    Such a controller gives variables their first values at the first line, to which it returns
    after each cycle, and resets the speed. A program of the same kin has no such values and stays
    unchanged.
    """
    program, can = job.program, job.can.variables
    entry = program.procedure(program.entry) if program.entry else None
    kept = program.origin is not None and program.origin.language in job.can.kin
    if entry is None or can is None or kept or _is_called(program, entry):
        return program
    if any(one.ends is not None for one in interrupts(program)):  # which lead out of the loop
        return program
    assigning = AssignmentAnalysis(program)
    run = assigning.run(entry)
    left = [
        name
        for name, variable in program.variables.items()
        if variable.storage != "constant"
        and name.lower() in run.read & assigning.written
        and (variable.initial is not None or not can.external(name, variable))
    ]
    told = [_SETTING_WORDS[type(one)] for one in left_settings(program, entry)]
    if not (left or told) or not run.ends:
        return program
    with job.findings.at(entry.span):
        about = Declared(entry.name, "procedures")
        job.findings.append(can.repeated(names=_names_in_words(left, told), about=about))
    # The cycle gets a new name: the loop takes the name by which the program is started.
    taken = {*(q.name for q in program.procedures), *program.variables, *program.targets}
    cycle = replace(entry, name=identifier(_CYCLE, taken))
    first = ", ".join([*left, *told][:_FEW_NAMES]) + (", ..." if len(left) > _FEW_NAMES else "")
    why = p.Comment(f"{first}: kept from cycle to cycle; a cycle stop does not end this loop")
    again = p.While(_FOR_EVER, (p.Call(cycle.name),))
    loop = Procedure(entry.name, (why, again), span=entry.span)
    others = tuple(q for q in program.procedures if q is not entry)
    return replace(program, procedures=(loop, cycle, *others))


def repeats_cycle(program: Program) -> bool:
    """True if the cycle of a program is in a separate loop, after first values."""
    entry = program.procedure(program.entry) if program.entry else None
    match entry.body if entry is not None else ():
        case (*_, p.While(condition, (p.Call(arguments=()),))):
            return condition == _FOR_EVER
    return False


def _is_called(program: Program, entry: Procedure) -> bool:
    key = entry.name.lower()
    return any(
        (isinstance(one, p.Call) and one.procedure.lower() == key)
        or (isinstance(one, e.Apply) and one.function.lower() == key)
        for procedure in program.procedures
        for one in records_in_body(procedure, p.Call, e.Apply)
    )


def _names_in_words(names: Sequence[str], more: Sequence[str]) -> str:
    told = [f"`{name}`" for name in names[:_MOST_NAMES_REPORTED]] + list(more)
    others = len(names) - _MOST_NAMES_REPORTED
    return ", ".join(told) if others <= 0 else f"{', '.join(told)} and {others} more"


_MOST_ALIKE: Final = 4
"""Elements that are given the same value one by one: a loop takes no more steps."""


def with_filled_arrays(job: Legalisation) -> Program:
    """The program with the first values of its arrays as assignments.

    Those of the program stand at the head of its entry, which one without is given; those of a
    procedure at its own. Constant arrays of places keep their values, if the language lists them.
    """
    program = job.program
    taken = {q.name for q in program.procedures} | _used_names(program)
    counters = [identifier(name, taken) for name in "ijk"]
    # Values of the program go to the entry, values of a procedure to its own top.
    variables, first = _filled(program.variables, "", counters, job)
    if first and program.entry is None:
        entry = Procedure(identifier("main", taken), ())
        program = replace(program, procedures=(entry, *program.procedures), entry=entry.name)
    procedures = []
    for procedure in program.procedures:
        own, filling = _filled(procedure.variables, procedure.name, counters, job)
        if procedure.name == program.entry and procedure.unit is None:
            filling = [*first, *filling]
        if filling:
            procedure = replace(procedure, body=(*filling, *procedure.body))
        procedures.append(
            procedure if own == procedure.variables else _with_variables(procedure, own)
        )
    return replace(program, variables=variables, procedures=tuple(procedures))


def with_copied_arrays(job: Legalisation) -> Program:
    """The program that assigns arrays element by element, as the language has to."""
    program = job.program
    taken = {q.name for q in program.procedures} | _used_names(program)
    counters = [identifier(name, taken) for name in "ijk"]
    shared = {name.lower(): v.size for name, v in program.variables.items()}
    procedures = []
    for procedure in program.procedures:
        own = {q.name.lower(): (0,) * q.dimensions for q in procedure.parameters}
        own |= {name.lower(): v.size for name, v in procedure.variables.items()}
        body = _copied(procedure.body, {**shared, **own}, counters, job)
        procedures.append(replace(procedure, body=body))
    return replace(program, procedures=tuple(procedures))


def _copied(
    body: Body, sizes: Mapping[str, tuple[int, ...]], counters: Sequence[str], job: Legalisation
) -> Body:
    """sizes: of variables by lower-case name, 0 for extents that are not known."""
    made: list[p.Statement] = []
    for node in body:
        match node:
            case p.Assign(e.Name(name) as target, value) if size := sizes.get(name.lower(), ()):
                if given := tuple(_one_by_one(target, value, size)):
                    made += (replace(node, target=place, value=one) for place, one in given)
                    continue
                # Arrays of one size are copied element by element, in loops.
                other = sizes.get(value.name.lower()) if isinstance(value, e.Name) else None
                if other != size or 0 in size:
                    with job.findings.at(node.span):
                        job.cannot(
                            what=f"what the whole array `{name}` is given here",
                            cure="assign its elements, in a loop",
                        )
                    made.append(node)
                    continue

                def give(
                    at: tuple[e.Expression, ...], node: p.Assign = node, to: e.Name = target
                ) -> p.Statement:
                    return replace(node, target=e.Index(to, at), value=e.Index(node.value, at))

                made += _for_each_element(size, counters, give)
            case _:
                made.append(map_bodies(node, lambda b: _copied(b, sizes, counters, job)))
    return tuple(made)


def _one_by_one(
    array: e.Name, value: e.Expression, size: tuple[int, ...]
) -> Iterator[tuple[e.Index, e.Expression]]:
    """The elements of an array and what values in brackets give them, if none needs the others."""

    # Values in brackets have to fill the array exactly.
    def filled(value: e.Expression, rest: tuple[int, ...]) -> bool:
        if not rest:
            return True
        inner = value.items if isinstance(value, e.Aggregate) else ()
        return len(inner) == rest[0] and all(filled(one, rest[1:]) for one in inner)

    def each(
        value: Any, rest: tuple[int, ...], at: tuple[e.Expression, ...]
    ) -> Iterator[tuple[e.Index, e.Expression]]:
        if not rest:
            yield e.Index(array, at), value
            return
        for k, one in enumerate(value.items, 1):
            yield from each(one, rest[1:], (*at, e.Number(k)))

    if 0 in size or not filled(value, size):
        return
    # A value that reads the array would see elements that are assigned already.
    if any(isinstance(r, e.Name) and r.name.lower() == array.name.lower() for r in records(value)):
        return
    yield from each(value, size, ())


def with_array_parameters(job: Legalisation) -> Program:
    """The program with the types of its array parameters that arrays have.

    A language without functions hands over no arrays, a call of another program no whole ones.
    """
    program = job.program
    # Reversed, so that the first procedure of each unit wins.
    firsts = {q.unit: q.name for q in reversed(program.procedures)}
    has_functions = job.can.procedures is None or job.can.procedures.functions
    procedures = []
    for procedure in program.procedures:
        first = procedure.unit is not None and firsts[procedure.unit] == procedure.name
        called = first or not has_functions
        for q in procedure.parameters:
            if not q.dimensions or (q.dimensions == 1 and not called):
                continue
            with job.findings.at(procedure.span):
                job.cannot(
                    what=f"the array parameter `{q.name}` of `{procedure.name}`",
                    cure="use an array of the program" if called else "give it one dimension",
                    about=Declared(procedure.name, "procedures"),
                )
        parameters = tuple(
            replace(q, type="number") if q.dimensions and q.type == "integer" else q
            for q in procedure.parameters
        )
        procedures.append(replace(procedure, parameters=parameters))
    return replace(program, procedures=tuple(procedures))


def elements_by_indices(
    size: tuple[int, ...], value: Callable[[tuple[int, ...]], e.Expression | None]
) -> e.Expression | None:
    """The elements of an array by their indices, None if one of them has no value."""

    def inside(rest: tuple[int, ...], at: tuple[int, ...]) -> e.Expression | None:
        if not rest:
            return value(at)
        inner = [inside(rest[1:], (*at, k)) for k in range(1, rest[0] + 1)]
        if any(v is None for v in inner):
            return None
        return e.Aggregate(tuple(v for v in inner if v is not None))

    return inside(size, ())


def _with_variables(procedure: Procedure, variables: dict[str, Variable]) -> Procedure:
    return replace(procedure, variables=variables)


def _used_names(program: Program) -> set[str]:
    """Every name that a counter may not have."""
    names = {*program.variables, *program.targets, *program.joint_targets, *program.signals}
    for procedure in program.procedures:
        names |= {*procedure.variables, *(q.name for q in procedure.parameters)}
    return names | {r.variable for r in program.statements() if isinstance(r, p.For)}


def _filled(
    variables: Mapping[str, Variable], owner: str, counters: Sequence[str], job: Legalisation
) -> tuple[dict[str, Variable], list[p.Statement]]:
    """owner: procedure whose own variables they are, empty for those of the program."""
    made: dict[str, Variable] = {}
    first: list[p.Statement] = []
    for name, variable in variables.items():
        made[name] = variable
        if not variable.size or (variable.storage == "constant" and _is_taught(variable, job)):
            continue
        can = job.can.arrays
        if can and (len(variable.size) > can.dimensions or max(variable.size) > can.elements):
            extents = " x ".join(map(str, variable.size))
            job.cannot(
                what=f"the array `{name}` of {extents} elements",
                cure=f"use at most {can.dimensions} dimensions of {can.elements} elements",
                about=Declared(name, "variables", owner),
            )
            continue
        values = list(_elements(name, variable, counters))
        if variable.initial is not None and not values:
            job.cannot(
                what=f"the first values of the array `{name}`{_misfit_text(variable)}",
                cure="write one for each element, or change the declared size",
                about=Declared(name, "variables", owner),
            )
        first += values
        # Arrays have numbers of one type, and get their values by assignment: none stays constant.
        type = "number" if variable.type == "integer" else variable.type
        storage = "variable" if variable.storage == "constant" else variable.storage
        made[name] = replace(variable, type=type, initial=None, storage=storage)
    return made, first


def _elements(name: str, variable: Variable, counters: Sequence[str]) -> Iterator[p.Statement]:
    """The assignments, none if the first value is no list for each dimension."""
    if variable.initial is not None and variable.initial == NOTHING[variable.type]:
        yield from _assign_alike(name, variable, variable.initial, counters)
        return
    if not _has_all_values(variable.initial, variable.size):
        return
    for place, value in values_by_place(variable):
        # Elements that no text gives a value stay as they are.
        if value != e.NEVER_GIVEN:
            indices = tuple(e.Number(i) for i in place)
            yield p.Assign(e.Index(e.Name(name), indices), value, span=variable.span)


def _has_all_values(value: e.Expression | None, size: tuple[int, ...]) -> bool:
    """True if a value has one part for each element: extents may exceed what a text can hold."""
    if not size:
        return True
    if not isinstance(value, e.Aggregate) or len(value.items) != size[0]:
        return False
    return all(_has_all_values(item, size[1:]) for item in value.items)


def _misfit_text(variable: Variable) -> str:
    """Describe first values whose number does not fit an array; empty if it fits."""
    unfit = None if variable.initial is None else _first_misfit(variable.initial, variable.size)
    return "" if unfit is None else f", {unfit[0]} elements written for an array of {unfit[1]}"


def _first_misfit(value: e.Expression, size: tuple[int, ...]) -> tuple[int, int] | None:
    """Numbers of elements of the first list that does not fit: stated and expected."""
    if not size or not isinstance(value, e.Aggregate):
        return None
    if len(value.items) != size[0]:
        return len(value.items), size[0]
    return next((found for item in value.items if (found := _first_misfit(item, size[1:]))), None)


def _assign_alike(
    name: str, variable: Variable, value: e.Expression, counters: Sequence[str]
) -> Iterator[p.Statement]:
    """Every element given the same value, by loops where there are many."""

    def give(element: tuple[e.Expression, ...]) -> p.Statement:
        return p.Assign(e.Index(e.Name(name), element), value, span=variable.span)

    yield from _for_each_element(variable.size, counters, give)


def _for_each_element(
    size: tuple[int, ...],
    counters: Sequence[str],
    give: Callable[[tuple[e.Expression, ...]], p.Statement],
) -> Iterator[p.Statement]:
    """Yield the statement for every element, with loops if there are many. give: returns it from
    its indices.
    """
    if math.prod(size) <= _MOST_ALIKE:
        for place in itertools.product(*(range(1, n + 1) for n in size)):
            yield give(tuple(map(e.Number, place)))
        return
    used = counters[: len(size)]
    # The last index is the innermost loop.
    inner = give(tuple(map(e.Name, used)))
    for counter, extent in reversed(list(zip(used, size, strict=True))):
        inner = p.For(counter, e.Number(1), e.Number(extent), (inner,), span=inner.span)
    yield inner


def with_constants(program: Program, predefined: Mapping[str, float | str]) -> Program:
    """The program with the values instead of the names, where these mean nothing else in it.

    predefined: by lower-case name.
    """
    loops = (x.variable.lower() for x in program.statements() if isinstance(x, p.For))
    taken = {*declared(program), *loops}
    values = {
        name: e.Text(value) if isinstance(value, str) else e.Number(value)
        for name, value in predefined.items()
        if name not in taken
    }
    used = chain(records_in_procedures(program, e.Name), records(program.variables))
    if not any(isinstance(one, e.Name) and one.name.lower() in values for one in used):
        return program

    def meant(part: Any) -> Any:
        return values.get(part.name.lower(), part) if isinstance(part, e.Name) else part

    return rewrite(program, meant)


def with_predefined(program: Program, types: Mapping[str, tuple[str, ValueType]]) -> Program:
    """The program with the variables that every controller has, where it declares none.

    types: by lower-case name the name as it is spelled, and the type.
    """
    taken = set(declared(program))
    used = (name.lower() for name in names_in_procedures(program))
    found = dict(types[name] for name in used if name in types and name not in taken)
    made = {name: Variable(type) for name, type in found.items()}
    return replace(program, variables={**program.variables, **made}) if made else program
