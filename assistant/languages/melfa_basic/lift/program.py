"""Lift: the trees of a program's files as one pseudo-program.

`lift` reads the main file and the programs that it calls, `Unit` one file of them: its procedures,
and what they name. Where settings differ by the path that leads to a procedure, the procedure is
read once for each.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from assistant import robots
from assistant.base.data_classes import dataclass
from assistant.base.source_text import starts_of
from assistant.languages.melfa_basic.lift import declarations, procedures, simple_statements
from assistant.languages.melfa_basic.lift.computed_positions import mentions_pallet, pallets
from assistant.languages.melfa_basic.lift.declarations import (
    SourceFile,
    changed_settings,
    settings_of_interrupts,
)
from assistant.languages.melfa_basic.lift.expressions import Expressions, file_timers
from assistant.languages.melfa_basic.lift.paths import positions_used_once
from assistant.languages.melfa_basic.lift.procedure_reader import Reader
from assistant.languages.melfa_basic.lift.procedures import Region, Structure, calls_on_interrupt
from assistant.languages.melfa_basic.lift.settings import (
    INITIAL_SETTINGS,
    SettingFlow,
    Settings,
    declare_followed,
    setting_lines,
    setting_number,
)
from assistant.languages.melfa_basic.lift.statements import mo_triggers
from assistant.languages.melfa_basic.lift.symbols import (
    Constants,
    Inside,
    Routine,
    Scope,
    Symbols,
    scope_of,
    variable_keys,
)
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import statement_of
from assistant.languages.melfa_basic.tree.walk import program_name, statements_in
from assistant.languages.settings_flow import UNKNOWN, Flow, Held, State
from assistant.languages.settings_forms import CalledForms, Form, divided_flow
from assistant.program.analysis.integer_inference import without_needless_rounding
from assistant.program.passes import procedure_forms
from assistant.program.program import (
    Declaration,
    Parameter,
    Procedure,
    Program,
    TakenNames,
    Variable,
    identifier,
)
from assistant.program.rewriting import with_spans_from

if TYPE_CHECKING:
    from assistant.robots import Robot


@dataclass
class _Reading:
    """Result of one reading of a file."""

    symbols: Symbols
    reader: Reader
    local: dict[tuple[str, str], Variable]
    procedures: list[Procedure] = field(default_factory=list)
    declarations: list[Declaration] = field(default_factory=list)


class Unit:
    """Adds a file to a program. unit: its name there, None for the main one.

    touched: settings that each program changes, by its name in upper case. elsewhere: those that
    interrupts of its callers may change while it runs. programs: those that are called, by name
    in upper case, as their files spell them; no subroutine has such a name.
    """

    def __init__(
        self,
        program: Program,
        file: SourceFile,
        main: SourceFile,
        unit: str | None,
        robot: Robot | None,
        touched: Mapping[str, frozenset[int]],
        elsewhere: frozenset[int],
        programs: Mapping[str, str | None],
        following: frozenset[int] = frozenset(),
        names: dict[int, str] | None = None,
    ) -> None:
        self.program, self.file, self.main, self.unit = program, file, main, unit
        self.following, self.names = following, {} if names is None else names
        self.robot, self.touched, self.programs = robot, touched, programs
        self.own, self.header, self.grids = file.own, file.header, not file.own
        self.code = code = list(file.code)
        take = declarations.taken_parameters
        self.first = declarations.taken_definitions(file.header, code) if self.own else take(code)
        constants = Constants(code)
        if not self.own:  # given by the caller, whatever value a line of the file has for it
            constants.assigned |= {parameter.key for parameter in self.first}
        self.first_values = declarations.taken_values(file.header, code) if self.own else {}
        structure = Structure(code)
        named = file.header.names["procedure"]
        parts = procedures.procedure_regions(code, structure.depth, named, self.own)
        settings = Settings(
            file.positions, constants, file.header, program.tools, program.frames, own=self.own,
            functions=_function_keys(code),
            computes=self.own or not _is_interrupted(code),
        )  # fmt: skip
        lines = setting_lines(code, structure, parts, settings, touched, elsewhere, file.answers)
        flow = Flow(lines)
        self.ways = SettingFlow(
            constants, structure, parts, settings, self._forms(flow, parts),
            {} if self.own else positions_used_once(code), file_timers(code, file.header, self.own),
            "M_BRKCQ" in set(variable_keys(code)),
        )  # fmt: skip
        self.followed: frozenset[int] = frozenset()
        """Settings that variables hold for other languages, by number."""
        self.scope = self._scope(parts)
        """The variables of the code, as each reading begins with them."""

    @property
    def is_main(self) -> bool:
        return self.unit is None

    def added(self, divide: bool) -> Program:
        """The program with the file's procedures and what they name.

        divide: procedures in which settings differ with the way are read once for each way.
        """
        whole = self.ways
        kept, reading = self._settled(divide)
        # Vendor text calls a procedure by one name, so that procedure cannot have several forms.
        while several := self._called_in_texts(reading):
            single = several | self.ways.called.single
            called = self._forms(whole.called.flow, whole.regions, single)
            self.ways = replace(whole, called=called)
            kept, reading = self._settled(divide)
        # Vendor text that names a pallet needs its definition, which arrays replace: read again
        # without.
        if self.grids and reading.symbols.pallets and mentions_pallet(tuple(reading.procedures)):
            self.grids = False
            reading = self._read(kept)
        program, symbols, settings = self.program, reading.symbols, self.ways.settings
        entry = program.entry
        if self.is_main:
            has_entry = bool(reading.procedures) and self.header.entry != "-"
            entry = reading.procedures[0].name if has_entry else None
        runs = reading.reader.runs
        targets = declarations.named_targets(self.file, symbols, settings.placed, runs)
        joints = declarations.joint_targets(self.file, symbols)
        return replace(
            program,
            procedures=(*program.procedures, *reading.procedures),
            entry=entry,
            signals=symbols.signals,
            variables=symbols.variables,
            tools=settings.tools,
            frames=settings.frames,
            # what the programs before have stays
            targets=program.targets | targets | program.targets,
            joint_targets=program.joint_targets | joints | program.joint_targets,
            declarations=(*program.declarations, *reading.declarations),
        )

    def _settled(self, divide: bool) -> tuple[frozenset[int], _Reading]:
        """The lines of settings that are kept, and the reading with them."""
        # The first reading finds which settings vendor text depends on; the second keeps their
        # lines.
        reading = self._read(frozenset())
        if divide and not self.own and reading.reader.depending:
            reading = self._divided(reading)
        kept = self._kept(reading)
        if not self.own:
            self.followed = self.following | _uncertain_settings(reading)
            if self.following:
                kept |= self._setting_lines(self.following)
        return kept, self._read(kept) if kept or self.followed else reading

    def _setting_lines(self, slots: frozenset[int]) -> frozenset[int]:
        """Lines that make some settings."""
        return frozenset(
            at
            for at, item in enumerate(self.code)
            if any(setting_number(one) in slots for one in statements_in(statement_of(item)))
        )

    def _called_in_texts(self, reading: _Reading) -> frozenset[int]:
        """Procedures of several forms that texts call, which know of one name."""
        names, forms = reading.symbols.in_texts, self.ways.called.forms
        return frozenset(
            number
            for number, region in enumerate(self.ways.regions)
            if len(forms[number]) > 1
            and (region.function.name if region.function else region.label or "").upper() in names
        )

    def _divided(self, whole: _Reading) -> _Reading:
        """The reading with divided procedures if that leaves less as its text."""
        ways = self.ways
        undivided: frozenset[int] = frozenset()
        while True:
            flow = divided_flow(ways.called.flow, undivided)
            single = ways.called.single
            called = self._forms(flow, ways.regions, single) if flow.cuts else ways.called
            if not flow.cuts or called.too_long:
                return whole
            if not called.unread:
                break
            undivided |= called.unread  # lines that never run are kept as well
        self.ways = replace(ways, called=called)
        made = self._read(frozenset())
        # Dividing pays only if fewer lines stay vendor text, and no jump in them is torn from its
        # label.
        if not made.reader.torn and _dependent_settings(made) < _dependent_settings(whole):
            return made
        self.ways = ways
        return whole

    @staticmethod
    def _kept(reading: _Reading) -> frozenset[int]:
        """Lines that made a setting under which something runs that stays as its text."""
        reader = reading.reader
        return frozenset(
            line
            for form, at, settings in reader.depending
            for slot, held in enumerate(reader.called.at(at, form))
            if slot in settings
            for line in held.needed
        )

    def settings_that_hold(self, wanted: frozenset[int]) -> Iterator[s.Entry]:
        """Yield the lines whose setting is already active, on every path that leads to them.

        wanted: the numbers of the settings to check.
        """
        again: dict[int, bool] = {}
        for form in (form for forms in self.ways.called.forms for form in forms.values()):
            for at in form.places:
                effect = self.ways.settings.effect(statement_of(self.code[at]))
                if effect is not None and effect[0] in wanted and effect[1] is not UNKNOWN:
                    held = self.ways.called.at(at, form)[effect[0]]
                    again[at] = again.get(at, True) and held.value == effect[1]
        yield from (self.code[at] for at, held in again.items() if held)

    # ------------------------------------------------------------------------- one reading

    def _read(self, kept: frozenset[int]) -> _Reading:
        code, ways, names = self.code, self.ways, self.main.header.names
        symbols = self._meanings()
        if not self.own:
            symbols.pallets, symbols.grids = pallets(code, symbols), self.grids
            symbols.mo_triggers = mo_triggers(code, symbols)
        symbols.goes_on, symbols.opened = self._channels(symbols)
        expressions = Expressions(symbols)
        local = declarations.own_variables(self.header, self.first_values, expressions)
        declarations.array_elements(self.file, symbols)
        listed = self._routines(symbols)
        taken = self._name_forms(listed)
        units = {name: unit for name, unit in self.programs.items() if unit} | names["unit"]
        source, calls = self.file.tree.source, (units, dict(names["first"]))
        declare_followed(
            self.followed, self.names, symbols, ways.settings, set(variable_keys(code))
        )
        followed = {slot: self.names[slot] for slot in self.followed}
        reader = Reader(code, symbols, ways, listed, calls, self.is_main, kept, source, followed)
        reader.answers = self.file.answers
        reading = _Reading(symbols, reader, local)
        # Before the procedures, as a line may use a name that is defined below it.
        for item in code:
            if isinstance(node := item.statement, s.DefIo):
                if (io := simple_statements.io_bits(node, expressions)) is not None:
                    symbols.io[node.variable.key] = io
        functions = [] if self.own else declarations.defined_functions(code, symbols, taken)
        for number, forms in enumerate(ways.called.forms):
            for form in forms.values():
                self._procedure(number, form, reading)
        several = [forms.values() for forms in ways.called.forms if len(forms) > 1]
        origin = {form.name: form.procedure for forms in several for form in forms}
        # Forms that came out equal are one procedure.
        reading.procedures = procedure_forms.without_equal_procedures(reading.procedures, origin)
        reading.procedures += [replace(f, unit=self.unit) for f in functions]
        return reading

    def _channels(self, symbols: Symbols) -> tuple[bool, tuple[int, ...] | None]:
        """True if a `Print #` leaves a line unfinished, and the channels that the file opens.

        None where other programs may open some, or what is opened is no line.
        """
        made = [one for item in self.code for one in statements_in(statement_of(item))]
        goes_on = any(
            isinstance(one, s.Print) and one.items[-1:] and one.items[-1][1] is None for one in made
        )
        opened = [one for one in made if isinstance(one, s.Open)]
        numbers = [symbols.value(one.number) for one in opened]
        lines = all(isinstance(one.name, s.String) and ":" in one.name.value for one in opened)
        # Other programs may open channels as well.
        if self.touched.keys() - {next(iter(self.touched))} or not lines:
            return goes_on, None
        known = sorted({round(one) for one in numbers if isinstance(one, float)})
        return goes_on, tuple(known) if len(numbers) == sum(
            isinstance(n, float) for n in numbers
        ) else None

    def _scope(self, parts: list[Region]) -> Scope:
        """The variables that all procedures share: those of the lines outside of functions."""
        functions = {r.function.name.upper() for r in parts if r.function is not None}
        first, shared = parts[0], self.code
        if functions:
            inner = first.function is not None
            shared = shared[slice(*first.before)] if inner else shared[first.low : first.high]
        scope = scope_of(shared, functions)
        for parameter in self.first:
            scope.names.setdefault(parameter.key, parameter.name)
        return scope

    def _meanings(self) -> Symbols:
        program = self.program
        tables = (program.signals, program.variables, program.targets, program.joint_targets)
        symbols = Symbols(
            self.header, self.file.positions, self.ways.constants, self.scope.copy(), self.robot,
            self.file.tree.dialect, self.own, dict(program.signals), dict(program.variables),
            TakenNames(name.lower() for table in tables for name in table),
        )  # fmt: skip
        symbols.timers = self.ways.timers
        return symbols

    def _forms(
        self, flow: Flow, parts: Sequence[Region], single: frozenset[int] = frozenset()
    ) -> CalledForms:
        """The forms of the procedures. A file of functions alone is there for others to call."""
        alone = {number for number, part in enumerate(parts) if part.unused}
        if not self.own and any(self.code[at].statement for at in parts[0].places()):
            alone |= {number for number, part in enumerate(parts) if part.function is not None}
        return CalledForms(flow, self._initial(), single, frozenset(alone))

    def _initial(self) -> State:
        """Return the settings at the start; a called program may run under settings of its
        caller.
        """
        if self.is_main or self.own:
            return INITIAL_SETTINGS
        set_anywhere = frozenset().union(*self.touched.values())
        return tuple(
            Held(UNKNOWN) if slot in set_anywhere else held
            for slot, held in enumerate(INITIAL_SETTINGS)
        )

    # -------------------------------------------------------------------------- procedures

    def _routines(self, symbols: Symbols) -> list[Routine]:
        """Return the routine of each region, with its name; note the functions in the symbols."""
        code = self.code
        taken = TakenNames((*(q.name for q in self.program.procedures), *self.programs))
        listed = []
        for number, region in enumerate(self.ways.regions):
            if number == 0:
                name = self._first_name()
            else:
                written = region.function.name if region.function else _written_label(code, region)
                known = self.header.names["procedure"].get(written.upper())
                name = known or identifier(written, taken)
            if region.function is None:
                routine = Routine(name)
            else:
                routine = declarations.routine_of(code, region, name, symbols)
                if number:
                    symbols.routines[region.function.name.upper()] = routine
            taken.add(name)
            listed.append(routine)
        return listed

    def _name_forms(self, listed: list[Routine]) -> TakenNames:
        """Name the forms of each procedure: the first has its name, the others a number after it.

        Return the names that are taken then.
        """
        taken = TakenNames((*(r.name for r in listed), *self.programs))
        taken.update(q.name for q in self.program.procedures)
        for routine, forms in zip(listed, self.ways.called.forms, strict=True):
            for form in forms.values():
                form.name = routine.name
                if form.number > 1:
                    form.name = identifier(f"{routine.name}_{form.number}", taken)
                    taken.add(form.name)
        return taken

    def _first_name(self) -> str:
        header = self.header
        if self.is_main:
            entry = header.entry if header.entry != "-" else None
            if entry or not self.first:
                return entry or "main"
            return identifier(program_name(self.file.tree) or "unit")  # a `main` takes nothing
        known: Mapping[str, str] = header.names["first"]
        return known.get(self._short(), self.unit or "unit")

    def _short(self) -> str:
        """The short name that the main program's heading has for this unit."""
        for short, original in self.header.names["first"].items():
            return short if original else ""
        units = self.main.header.names["unit"].items()
        return next((short for short, unit in units if unit == self.header.unit), "")

    def _procedure(self, number: int, form: Form, reading: _Reading) -> None:
        """Reads a procedure in one of its forms."""
        reader, symbols = reading.reader, reading.symbols
        region, routine = reader.regions[number], reader.routines[number]
        if routine.parameters is None:
            # A function without equivalent is declared once, whatever forms it has.
            if form.number == 1:
                kept = declarations.function_text(reader.code, region, symbols.dialect)
                reading.declarations.append(kept)
            return
        variables: dict[str, Variable] = {}
        if region.function is not None:
            inside, variables = declarations.inside_function(
                reader.code, region, routine, symbols, symbols.scope
            )
            symbols.inside = inside if number or not _has_plain_names(inside) else None
        parameters = routine.parameters
        if number == 0 and self.first:
            parameters = tuple(self._parameter(v, symbols) for v in self.first)
        body = reader.read(form)
        symbols.inside = None
        if number == 0 and self._has_no_code(body):
            return
        name = form.name
        owned = {v: d for (owner, v), d in reading.local.items() if owner.lower() == name.lower()}
        # The line above the body is the head or the label.
        span = getattr(reader.code[region.low - 1], "span", None) if region.low else None
        reading.procedures.append(
            Procedure(
                name, body, parameters, owned | variables, routine.result, self.unit, span=span
            )
        )

    def _parameter(self, variable: s.Variable, symbols: Symbols) -> Parameter:
        known = self.header.variables.get(variable.key)
        if known is not None:
            return Parameter(known.name, known.type)
        kind = symbols.type_of_key(variable.key)
        name = symbols.declared(variable)
        symbols.variables.pop(name, None)
        return Parameter(name, kind)

    def _has_no_code(self, body: tuple[Any, ...]) -> bool:
        """True if a file is only a list of positions."""
        if self.header.entry == "-" and self.is_main:
            return True
        return not body and not any(
            not isinstance(i, s.Line) or i.statement or i.label for i in self.code
        )


def _function_keys(code: list[s.Entry]) -> frozenset[str]:
    """Those of a file, in upper case."""
    kinds = s.Function | s.DefFunction
    return frozenset(i.statement.name.upper() for i in code if isinstance(i.statement, kinds))


def _is_interrupted(code: list[s.Entry]) -> bool:
    return any(calls_on_interrupt(one) for i in code for one in statements_in(statement_of(i)))


def _uncertain_settings(reading: _Reading) -> frozenset[int]:
    """Settings that are not certain where something depends on them."""
    return frozenset(
        slot
        for form, at, settings in reading.reader.depending
        for slot in settings
        if reading.reader.called.at(at, form)[slot].value is UNKNOWN
    )


def _dependent_settings(reading: _Reading) -> set[int]:
    return {at for _, at, _ in reading.reader.depending}


def _has_plain_names(inside: Inside) -> bool:
    return not inside.names and inside.result is None


def _written_label(code: list[s.Entry], region: Region) -> str:
    """The label of a subroutine as it is written."""
    for at in (region.low - 1, region.low):
        label = code[at].label if at >= 0 else None
        if label and label.upper() == region.label:
            return label
    return region.label or "unnamed"


def lift(trees: Sequence[s.File], robot: Robot | None = None, *, divide: bool = True) -> Program:
    """The pseudo-program of a main program and the programs that it calls.

    divide: procedures in which settings differ with the way are read once for each way.
    """
    program, followed = _lifted_files(trees, robot, divide, frozenset())
    if followed and len(trees) > 1:  # what one file needs to know of a setting, all have to tell
        program, _ = _lifted_files(trees, robot, divide, followed)
    return program


def _lifted_files(
    trees: Sequence[s.File], robot: Robot | None, divide: bool, following: frozenset[int]
) -> tuple[Program, frozenset[int]]:
    """The program, and the settings that some of its files follow. following: that all follow."""
    files = [SourceFile(tree) for tree in trees]
    if not files:
        return Program("empty", entry=None), following
    main = next((f for f in files if f.header.unit is None), files[0])
    if robot is None:
        robot = _robot_named(main.header.robot)
    order = list(main.header.names["unit"].values())
    rest = [f for f in files if f is not main]
    rest.sort(key=lambda f: order.index(f.header.unit) if f.header.unit in order else len(order))
    name = main.header.program or file_stem(main.tree) or "program"
    comments = (*main.comments, *(text for file in rest for text in _comments_of(file)))
    program = Program(
        name, robot=main.header.robot, comments=comments, signals=dict(main.header.signals)
    )
    names = [(file_stem(f.tree) or f"-{k}").upper() for k, f in enumerate(files)]
    named = dict(zip(names, files, strict=True))
    touched = changed_settings(named)
    interrupted = settings_of_interrupts(named, touched)
    elsewhere = {id(f): interrupted[name] for name, f in zip(names, files, strict=True)}
    called = frozenset(name for f in files for name in f.called() if name is not None)
    programs = {name: file_stem(named[name].tree) if name in named else None for name in called}
    starts = dict(zip(map(id, files), starts_of(f.tree.source for f in files), strict=True))
    followed: dict[int, str] = {}
    for file in [main, *rest]:
        known = program.procedures
        unit = None if file is main else (file.header.unit or file_stem(file.tree) or "unit")
        program = Unit(
            program, file, main, unit, robot, touched, elsewhere[id(file)], programs,
            following, followed,
        ).added(divide)  # fmt: skip
        added = program.procedures[len(known) :]
        counted = (with_spans_from(procedure, starts[id(file)]) for procedure in added)
        program = replace(program, procedures=(*known, *counted))
    if not any(file.own for file in files):
        program = without_needless_rounding(program)
    return program, frozenset(followed)


def _comments_of(file: SourceFile) -> Iterator[str]:
    """The comments that a called program begins with, the first one behind its name."""
    named = file.own
    for text in file.comments:
        if not named and any(map(str.isalnum, text)):
            named = True
            yield f"{file_stem(file.tree)}: {text}"
        else:
            yield text


def settings_already_set(tree: s.File, wanted: frozenset[int]) -> Iterator[s.Entry]:
    """Yield the lines of a program in one file whose setting is already active, see `Unit`."""
    file, name = SourceFile(tree), "-"
    program = Program(name, signals=dict(file.header.signals))
    touched = changed_settings({name: file})
    robot = _robot_named(file.header.robot)
    called = {name: None for name in file.called() if name is not None}
    unit = Unit(program, file, file, None, robot, touched, frozenset(), called)
    return unit.settings_that_hold(wanted)


def _robot_named(name: str | None) -> Robot | None:
    try:
        return None if name is None else robots.get(name)
    except KeyError:
        return None


def file_stem(tree: s.File) -> str | None:
    path = tree.source.path if tree.source else None
    return identifier(PurePath(path).stem) if path and path != "-" else None
