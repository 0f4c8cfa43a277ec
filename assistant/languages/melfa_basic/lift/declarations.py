"""Declarations of a file: its heading, arrays and targets, and the signatures of its procedures.

`SourceFile` takes a tree apart into heading, code and positions. A file that was written here
states in its heading what its names mean; of any other file the first letters of names and the
`Def` lines tell the types. Functions get their parameters and results from the code that they
consist of.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final, cast

from assistant.languages.melfa_basic.lift.expressions import Expressions
from assistant.languages.melfa_basic.lift.paths import Runs
from assistant.languages.melfa_basic.lift.procedures import (
    Answers,
    Code,
    Region,
    called_labels,
    calls_on_interrupt,
    in_order,
    separated,
    target_name,
    without_trampolines,
)
from assistant.languages.melfa_basic.lift.settings import ALL_SETTINGS, setting_number
from assistant.languages.melfa_basic.lift.simple_statements import assigned_value, comment_text
from assistant.languages.melfa_basic.lift.symbols import (
    LETTER_TYPES,
    Inside,
    Routine,
    Scope,
    SignalNames,
    Symbols,
    Unliftable,
    changed_variables,
    letter_type,
    scope_of,
    signal_comment,
    signal_names,
)
from assistant.languages.melfa_basic.tables.variables import MARK_VALUE_TYPES
from assistant.languages.melfa_basic.text import effects, printer
from assistant.languages.melfa_basic.text import header as headers
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.control_flow import (
    exits_of,
    statement_of,
    with_labelled_jumps,
)
from assistant.languages.melfa_basic.tree.line_tables import (
    Elements,
    Plain,
    Positions,
    joints_of,
    target_of,
)
from assistant.languages.melfa_basic.tree.walk import nodes, program_stem, statements_in
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import JointTarget, Target
from assistant.program.passes.variables import elements_by_indices
from assistant.program.program import (
    Declaration,
    Parameter,
    Procedure,
    TakenNames,
    ValueType,
    Variable,
    identifier,
)


class SourceFile:
    """A tree, taken apart. own: it was written here, and its heading says what it means.

    answers: what its interrupts call; the lines that do so are not among its code.
    """

    def __init__(self, tree: s.File) -> None:
        self.tree = tree
        self.header, self.comments, code = _split_file(tree)
        self.own = self.header.program is not None
        self.answers: Answers = {}
        if self.own:
            names = signal_names(self.header.signals)
            self.code, self.answers = without_trampolines(
                [_without_signal_names(item, names) for item in code]
            )
        else:
            self.code = separated(in_order(_with_lone_labels(with_labelled_jumps(code)[0])))
        self.positions = Positions(tree)

    def touched(self) -> frozenset[int]:
        """Settings that the file makes itself."""
        made = map(setting_number, self._nodes())
        return frozenset(number for number in made if number is not None)

    def interrupts(self) -> bool:
        """True if the program has interrupts that call."""
        return any(
            calls_on_interrupt(statement)
            for item in self.code
            for statement in statements_in(item.statement)
        )

    def called(self) -> frozenset[str | None]:
        """Programs that it calls, in upper case; None for one whose name is worked out."""
        named = (node.program for node in self._nodes() if isinstance(node, s.CallP))
        return frozenset(
            identifier(program_stem(one.value)).upper() if isinstance(one, s.String) else None
            for one in named
        )

    def _nodes(self) -> Iterator[Any]:
        for item in self.code:
            yield from nodes(item.statement)


def changed_settings(files: Mapping[str, SourceFile]) -> dict[str, frozenset[int]]:
    """Settings that each program changes, by name in upper case, with what it calls."""
    found = {name: file.touched() for name, file in files.items()}
    while True:
        before = dict(found)
        for name, file in files.items():
            for other in file.called():
                found[name] |= found.get(other or "", ALL_SETTINGS)
        if found == before:
            return found


def settings_of_interrupts(
    files: Mapping[str, SourceFile], touched: Mapping[str, frozenset[int]]
) -> dict[str, frozenset[int]]:
    """Settings that interrupts of its callers may change while a program runs, by name.

    touched: what each program changes.
    """
    found = dict.fromkeys(files, frozenset[int]())
    running = {name: touched[name] for name, file in files.items() if file.interrupts()}
    before = None
    while running and found != before:
        before = dict(found)
        for name, file in files.items():
            called = file.called()
            # A computed name may be that of any program.
            for other in files if None in called else found.keys() & called:
                found[other] |= found[name] | running.get(name, frozenset())
    return found


def _with_lone_labels(code: list[s.Entry]) -> list[s.Entry]:
    """Return the code with the labels of subroutines on separate lines: `*OPEN:HOpen 1` is both."""
    wanted = called_labels(code) | {
        target_name(to) for item in code for to, _ in exits_of(statement_of(item)).handlers
    }
    made: list[s.Entry] = []
    for item in code:
        if isinstance(item, s.Line) and item.statement and (item.label or "").upper() in wanted:
            made.append(s.Line(label=item.label, number=item.number, span=item.span))
            item = replace(item, label=None)
        made.append(item)
    return made


def _split_file(tree: s.File) -> tuple[Header, tuple[str, ...], list[s.Entry]]:
    """The heading, the comments above it, and the code."""
    code = tree.code
    texts: list[str] = []
    for item in code:
        if not isinstance(item, s.Line) or item.statement or item.label or not item.comment:
            break
        texts.append(comment_text(item.comment))
    if (bounds := headers.bounds(texts)) is not None:
        start, end = bounds
        head = headers.read(texts[start + 1 : end])
        return head, tuple(texts[:start]), code[end + 1 :]
    return Header(), tuple(texts), code[len(texts) :]


def _without_signal_names(item: s.Entry, names: SignalNames) -> s.Entry:
    """A line without the names of its signals behind it, which the heading has, too."""
    if not isinstance(item, s.Line) or item.comment is None or item.statement is None:
        return item
    said = signal_comment(item.statement, names)
    return replace(item, comment=None) if said and comment_text(item.comment) == said else item


def taken_definitions(header: Header, code: list[s.Entry]) -> tuple[s.Variable, ...]:
    """Takes out the definitions of a heading's variables; gives the parameters of the program."""
    parameters: tuple[s.Variable, ...] = ()
    while code:
        statement = code[0].statement
        if not isinstance(statement, s.FPrm | s.DefNames | s.Dim):
            break
        if not all(v.key in header.variables for v in statement.variables):
            break
        if isinstance(statement, s.FPrm):
            parameters = statement.variables
        del code[0]
    return parameters


def taken_values(header: Header, code: list[s.Entry]) -> dict[str, s.Assign]:
    """Takes out the lines that give a heading's variables their first values, by short name."""
    found: dict[str, s.Assign] = {}
    for short, declared in header.variables.items():
        if not declared.initial or declared.storage == "parameter":
            continue
        at = next((k for k, item in enumerate(code) if item.statement is not None), len(code))
        if at < len(code) and isinstance(code[at].statement, s.Function):
            at += 1  # the comments of a function stand above it
        else:
            at = 0
        statement = code[at].statement if at < len(code) else None
        if isinstance(statement, s.Assign) and statement.target.key == short:
            found[short] = statement
            del code[at]
    return found


def taken_parameters(code: list[s.Entry]) -> tuple[s.Variable, ...]:
    """Those of a program that is called with arguments: `FPrm` is its first statement.

    It is taken out.
    """
    for at, item in enumerate(code):
        if not isinstance(item, s.Line) or item.label is not None:
            return ()
        if item.statement is not None:
            found = item.statement.variables if isinstance(item.statement, s.FPrm) else ()
            # Arrays and repeated names have no equivalent: the `FPrm` stays vendor text.
            if any(v.arguments is not None for v in found) or len({v.key for v in found}) < len(
                found
            ):
                return ()
            if found:
                code[at] = s.Line(comment=item.comment, span=item.span)
            return found
    return ()


def own_variables(
    header: Header, first: Mapping[str, s.Assign], lift: Expressions
) -> dict[tuple[str, str], Variable]:
    """Declares the variables of a heading; gives those of procedures, by owner and name.

    first: their first values by short name.
    """
    local: dict[tuple[str, str], Variable] = {}
    for short, declared in header.variables.items():
        if declared.storage == "parameter":
            continue
        initial = assigned_value(first[short], lift) if short in first else None
        storage: Any = declared.storage
        if declared.listed:
            initial = _listed_values(short, declared, lift.m)
            # Lines that were added to the program may change it.
            storage = "persistent" if short in lift.m.constants.assigned else storage
        made = Variable(declared.type, initial, declared.size, storage, declared.local)
        if declared.owner:
            local[declared.owner, declared.name] = made
        else:
            lift.m.variables[declared.name] = made
    return local


def _listed_values(short: str, array: headers.Declared, symbols: Symbols) -> e.Expression | None:
    """The values that the list of positions has for an array, None without any."""
    _, found = symbols.positions.elements.get(short, ("", {}))
    if not found:
        return None

    def value(at: tuple[int, ...]) -> e.Expression:
        return symbols.value_of(found[at], array.type) if at in found else e.NEVER_GIVEN

    return elements_by_indices(array.size, value)


def array_elements(file: SourceFile, symbols: Symbols) -> None:
    """First values of arrays; of joints, one that only some have values of is not understood."""
    for key, (written, found) in file.positions.elements.items():
        size = symbols.scope.sizes.get(key)
        if file.own or size is None:
            continue
        values = _all_elements(size, found, symbols, symbols.type_of_key(key) == "joints")
        if values is None:
            del symbols.scope.sizes[key]
            continue
        _declare_array(written, values, symbols)
    for key, (written, given) in file.positions.plain.items():
        size = symbols.scope.sizes.get(key)
        if not file.own and size is not None:
            _declare_array(written, elements_by_indices(size, _filled_up(given)), symbols)


def _filled_up(given: Plain) -> Callable[[tuple[int, ...]], e.Expression]:
    texts = any(isinstance(value, e.Text) for value in given.values())
    return lambda at: given.get(at, e.Text("") if texts else e.Number(0))


def _declare_array(written: str, values: e.Expression | None, symbols: Symbols) -> None:
    """Declares an array with the first values that its file has for it."""
    name = symbols.declared(s.Variable(written))
    known = symbols.variables[name]
    symbols.variables[name] = Variable(known.type, values, known.size, "persistent")


def _all_elements(
    size: tuple[int, ...], found: Elements, symbols: Symbols, joints: bool
) -> e.Expression | None:
    """Zeros without flags are what stands for a place that was never taught."""

    def value(at: tuple[int, ...]) -> e.Expression | None:
        constant = found.get(at)
        if joints:
            return None if constant is None else symbols.value_of(constant, "joints")
        if constant is None or (constant.flags is None and not any(constant.values)):
            return e.NEVER_GIVEN
        return symbols.value_of(constant, "position")

    return elements_by_indices(size, value)


def named_targets(
    file: SourceFile, symbols: Symbols, placed: Collection[str], runs: Runs
) -> dict[str, Target]:
    """Named targets; of a foreign file all positions that are part of no path.

    placed: position variables, upper case, that are tools and frames.
    """
    return _stated_targets(file, symbols) if file.own else _all_targets(file, symbols, placed, runs)


def _stated_targets(file: SourceFile, symbols: Symbols) -> dict[str, Target]:
    names = {**file.header.names["target"]}
    names.update({k: k for k in sorted(symbols.targets) if k[0] != "J"})
    found = ((name, file.positions.constant(short)) for short, name in names.items())
    return {name: target_of(one, symbols.robot) for name, one in found if one is not None}


def _all_targets(
    file: SourceFile, symbols: Symbols, placed: Collection[str], runs: Runs
) -> dict[str, Target]:
    made = {}
    for written in file.positions.all_names():
        key = written.upper()
        # Rows of paths are no targets; neither are names that the pseudo-program would respell.
        if key[0] == "J" or identifier(written) != written or runs.holds(key):
            continue
        if key in placed and key not in symbols.targets:
            continue
        if key in symbols.constants.assigned:
            symbols.declared(s.Variable(written))
            continue
        constant = file.positions.constant(written)
        if constant is not None:
            made[symbols.target_name(written)] = target_of(constant, symbols.robot)
    return made


def joint_targets(file: SourceFile, symbols: Symbols) -> dict[str, JointTarget]:
    names = file.header.names["joints"]
    made = {}
    for key, (written, constant) in file.positions.names.items():
        if key[0] != "J" or key in file.header.inline or (file.own and key not in names):
            continue
        if not file.own and key in symbols.constants.assigned:
            symbols.declared(s.Variable(written))
        else:
            name = names[key] if file.own else symbols.target_name(written)
            made[name] = joints_of(constant, symbols.robot)
    return made


_EXIT_FUNCTION: Final = s.Command("Exit Function")


def routine_of(code: Code, region: Region, name: str, symbols: Symbols) -> Routine:
    """Return the signature of a function. If a parameter has several extents, or changes in an
    unknown manner, `parameters` has the value None.
    """
    function = region.function
    assert function is not None
    kept = symbols.constants.kept
    assigned = {
        key
        for item in code[region.low : region.high]
        if item.statement is not None
        for key in changed_variables(item.statement, kept)
    }
    parameters: list[Parameter] = []
    extents = _subscript_counts(code[region.low : region.high])
    for given in function.parameters or ():
        key = given.name.upper()
        whole = extents.get(key, set()) <= {1}  # no other number of subscripts than one
        # Without `ByVal` or `ByRef` it is not certain whether the caller's variable changes as
        # well.
        if (not given.mode and key in assigned) or (given.array and not whole):
            return Routine(name, _result_type(function, symbols), None)
        mode: Any = "inout" if given.mode == "ByRef" else "in"
        known = symbols.header.variables.get(key) if symbols.own else None
        kind = known.type if known else MARK_VALUE_TYPES.get(given.suffix, letter_type(key))
        spelled = known.name if known else given.name
        parameters.append(Parameter(spelled, kind, mode, int(given.array)))
    return Routine(name, _result_type(function, symbols), tuple(parameters))


def _subscript_counts(code: Code) -> dict[str, set[int]]:
    """Numbers of subscripts that names stand with, in upper case."""
    found: dict[str, set[int]] = {}
    for item in code:
        for part in nodes(item.statement):
            if isinstance(part, s.Variable) and part.arguments is not None:
                found.setdefault(part.key, set()).add(len(part.arguments))
    return found


def _result_type(function: s.Function, symbols: Symbols) -> ValueType | None:
    """The type of a function's result, None for none."""
    written = function.result.upper()
    if written in ("", "V"):
        return None
    stated = symbols.header.names["result"].get(function.name.upper()) if symbols.own else None
    if stated in ("truth", "integer", "pose"):
        return cast(ValueType, stated)
    return MARK_VALUE_TYPES.get(written[-1], LETTER_TYPES.get(written[0], "number"))


def inside_function(
    code: Code, region: Region, routine: Routine, symbols: Symbols, globals_: Scope
) -> tuple[Inside, dict[str, Variable]]:
    """A function's own names, and the variables that it declares."""
    function = region.function
    assert function is not None
    key = function.name.upper()
    inside = Inside(key, {}, {}, {})
    local: dict[str, Variable] = {}
    if symbols.own:
        return inside, {}
    for parameter in routine.parameters or ():
        inside.names[parameter.name.upper()] = parameter.name
        inside.types[parameter.name.upper()] = parameter.type
        inside.sizes[parameter.name.upper()] = (0,) * parameter.dimensions
    scope = scope_of(code[region.low : region.high], (*symbols.routines, key))
    taken = TakenNames(inside.names)
    defined = _declared_keys(code[region.low : region.high])
    for name_key, written in scope.names.items():
        declared = name_key in scope.types and name_key in defined
        # A name that the file has elsewhere is that variable, unless the function declares its own.
        known = name_key in globals_.names or symbols.positions.constant(written) is not None
        if name_key in inside.names or name_key[1:2] == "_" or (known and not declared):
            continue
        if name_key in symbols.io:
            continue
        name = identifier(written, taken)
        kind = scope.types.get(name_key, letter_type(name_key))
        size = scope.sizes.get(name_key, ())
        if name_key in scope.static:  # outlives the function
            name = symbols.static(routine.name, name_key, name)
            symbols.variables.setdefault(name, Variable(kind, None, size))
        else:
            local[name] = Variable(kind, None, size)
        taken.add(name)
        inside.names[name_key], inside.types[name_key] = name, kind
        inside.sizes[name_key] = size
    if routine.result is not None and not _returns_directly(code, region, key):
        inside.result = identifier("result", taken | {n.upper() for n in symbols.spelling})
        local[inside.result] = Variable(routine.result)
    return inside, local


def _declared_keys(code: Code) -> set[str]:
    """Variables that some lines declare, in upper case."""
    found: set[str] = set()
    for item in code:
        statement = item.statement
        if isinstance(statement, s.Static):
            statement = statement.definition
        if isinstance(statement, s.DefNames | s.Dim):
            found.update(v.key for v in statement.variables)
    return found


def _returns_directly(code: Code, region: Region, key: str) -> bool:
    """True if each result is assigned right before the function ends, so that it becomes
    `return`.
    """
    left: set[int] = set()
    for at in range(region.low, region.high):
        statement = code[at].statement
        if statement is None:
            continue
        if isinstance(statement, s.Assign) and _is_result(statement.target, key):
            following = code[at + 1]
            if not isinstance(following, s.Line) or following.label is not None:
                return False
            if following.statement != _EXIT_FUNCTION and at + 1 != region.high:
                return False
            left.add(at + 1)
            # Only the value may still name the result; any statement can hold it for the search
            # below.
            statement = s.Command("Hlt", (statement.value,))
        elif statement == _EXIT_FUNCTION and at not in left:
            return False
        for part in nodes(statement):
            if isinstance(part, s.Variable) and _is_result(part, key):
                return False
            if part == _EXIT_FUNCTION and part is not statement:
                return False
    return region.high in left  # else it may end without one, and gives back what it began with


def _is_result(variable: s.Variable, key: str) -> bool:
    return variable.key == key and variable.arguments is None


def defined_functions(code: Code, symbols: Symbols, taken: TakenNames) -> list[Procedure]:
    """Return functions of one expression (`Def FN`) as procedures; those that can be translated get
    routines.

    taken: names of procedures; the new names are added to it.
    """
    made = []
    for item in code:
        node = item.statement
        if not isinstance(node, s.DefFunction) or node.name.upper() in symbols.routines:
            continue
        name = identifier(node.name, taken)
        key = node.name.upper()
        kind = MARK_VALUE_TYPES.get(node.suffix, LETTER_TYPES.get(key[2:3], "number"))
        parameters = tuple(
            Parameter(v.name, MARK_VALUE_TYPES.get(v.suffix, letter_type(v.key)))
            for v in node.parameters
        )
        names = {q.name.upper(): q.name for q in parameters}
        # The parameters hide variables of the same names while the expression is read.
        symbols.inside = Inside(key, names, {q.name.upper(): q.type for q in parameters}, {})
        try:
            value = Expressions(symbols).number(node.value)
        except Unliftable:
            continue
        finally:
            symbols.inside = None
        body = (p.Return(value, span=item.span),)
        made.append(Procedure(name, body, parameters, result=kind, span=item.span))
        symbols.routines[key] = Routine(name, kind, parameters)
        taken.add(name)
    return made


def function_text(code: Code, region: Region, dialect: str) -> Declaration:
    """A whole function as its text."""
    upper = dialect.endswith("-4")
    items = code[region.low - 1 : region.high + 1]
    text = "\n".join(
        printer.line(replace(item, number=None), upper)
        for item in items
        if isinstance(item, s.Line)
    )
    return Declaration(dialect, text, effect=effects.of_text(text, "declaration"))
