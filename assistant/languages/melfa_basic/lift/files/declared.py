"""What a file declares: variables of its heading, arrays and targets."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, cast

from assistant.languages.melfa_basic.lift.files.parts import SourceFile
from assistant.languages.melfa_basic.lift.statements.data import assigned_value
from assistant.languages.melfa_basic.lift.statements.paths import Runs
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import Symbols
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import Elements, Plain, joints_of, target_of
from assistant.program import expressions as e
from assistant.program.geometry import JointTarget, Target
from assistant.program.passes.variables import elements_by_indices
from assistant.program.program import Variable, identifier


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
        made = Variable(
            declared.type, initial, declared.size, cast(Any, declared.storage), declared.local
        )
        if declared.owner:
            local[declared.owner, declared.name] = made
        else:
            lift.m.variables[declared.name] = made
    return local


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
