"""What a file declares: variables of its heading, arrays and targets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, cast

from assistant.languages.melfa_basic.lift.settings.held import Settings
from assistant.languages.melfa_basic.lift.statements.data import value_of
from assistant.languages.melfa_basic.lift.statements.paths import Runs
from assistant.languages.melfa_basic.lift.values.expressions import Expressions
from assistant.languages.melfa_basic.lift.values.symbols import Symbols
from assistant.languages.melfa_basic.text.header import Header
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.positions import (
    Elements,
    Plain,
    Positions,
    joints_of,
    target_of,
)
from assistant.program import expressions as e
from assistant.program.geometry import JointTarget, Target
from assistant.program.passes.arrays import nested
from assistant.program.program import Variable, identifier


class Holding(Protocol):
    """A file with a heading and positions."""

    own: bool
    header: Header
    positions: Positions


class OwnVariables:
    """Variables of a heading; their lines are taken out of the code. moved: any was."""

    def __init__(self, header: Header, code: list[s.Entry]) -> None:
        self.header, self.code, self.moved = header, code, False

    def definitions(self) -> tuple[s.Variable, ...]:
        """Takes out the definitions at the start; gives the parameters of the program."""
        parameters: tuple[s.Variable, ...] = ()
        while self.code:
            statement = self.code[0].statement
            if not isinstance(statement, s.FPrm | s.DefNames | s.Dim):
                break
            if not all(v.key in self.header.variables for v in statement.variables):
                break
            if isinstance(statement, s.FPrm):
                parameters = statement.variables
            del self.code[0]
        return parameters

    def values(self, lift: Expressions) -> dict[tuple[str, str], Variable]:
        """Declares them, with the first values that the code begins with; gives local ones."""
        local: dict[tuple[str, str], Variable] = {}
        for short, declared in self.header.variables.items():
            if declared.storage == "parameter":
                continue
            initial: e.Expression | None = None
            if declared.initial:
                found = self._first_value(short)
                if found is not None:
                    initial = value_of(found, lift)
            made = Variable(
                declared.type, initial, declared.size, cast(Any, declared.storage), declared.local
            )
            if declared.owner:
                local[declared.owner, declared.name] = made
            else:
                lift.m.variables[declared.name] = made
        return local

    def _first_value(self, short: str) -> s.Assign | None:
        """Takes out the first line of the program if it gives that variable a value."""
        inner = bool(self.code) and isinstance(self.code[0].statement, s.Function)
        at = 1 if inner else 0
        statement = self.code[at].statement if at < len(self.code) else None
        if isinstance(statement, s.Assign) and statement.target.key == short:
            del self.code[at]
            self.moved = True
            return statement
        return None


def parameters_of(code: list[s.Entry]) -> tuple[s.Variable, ...]:
    """Those of a program that is called with arguments: `FPrm` is its first statement."""
    for item in code:
        if not isinstance(item, s.Line) or item.label is not None:
            return ()
        if item.statement is not None:
            found = item.statement.variables if isinstance(item.statement, s.FPrm) else ()
            plain = all(v.arguments is None for v in found)
            return found if plain and len({v.key for v in found}) == len(found) else ()
    return ()


def first_parameters(code: list[s.Entry]) -> tuple[s.Variable, ...]:
    """The same, with the line taken out."""
    found = parameters_of(code)
    for at, item in enumerate(code):
        if found and item.statement is not None:
            code[at] = s.Line(comment=item.comment, span=item.span)
            break
    return found


def elements(file: Holding, symbols: Symbols) -> None:
    """First values of arrays; of joints, one that only some have values of is not understood."""
    for key, (written, found) in file.positions.elements.items():
        size = symbols.scope.sizes.get(key)
        if file.own or size is None:
            continue
        values = _all_elements(size, found, symbols)
        if values is None:
            del symbols.scope.sizes[key]
            continue
        _keep(written, values, symbols)
    for key, (written, given) in file.positions.plain.items():
        size = symbols.scope.sizes.get(key)
        if not file.own and size is not None:
            _keep(written, nested(size, _others_empty(given)), symbols)


def _others_empty(given: Plain) -> Callable[[tuple[int, ...]], e.Expression]:
    texts = any(isinstance(value, e.Text) for value in given.values())
    return lambda at: given.get(at, e.Text("") if texts else e.Number(0))


def _keep(written: str, values: e.Expression | None, symbols: Symbols) -> None:
    """Declares an array with the first values that its file has for it."""
    name = symbols.declared(s.Variable(written))
    known = symbols.variables[name]
    symbols.variables[name] = Variable(known.type, values, known.size, "persistent")


def _all_elements(size: tuple[int, ...], found: Elements, symbols: Symbols) -> e.Expression | None:
    placed = all(constant.flags is not None for constant in found.values())

    def value(at: tuple[int, ...]) -> e.Expression | None:
        constant = found.get(at)
        if constant is None:
            return e.NEVER_GIVEN if placed else None
        return symbols.value_of(constant, "joints" if constant.flags is None else "position")

    return nested(size, value)


class Declared:
    """Targets of a file that has been read."""

    def __init__(self, file: Holding, symbols: Symbols, settings: Settings, runs: Runs) -> None:
        self.own, self.header, self.positions = file.own, file.header, file.positions
        self.symbols, self.settings, self.runs = symbols, settings, runs
        self.robot = symbols.robot

    def targets(self) -> dict[str, Target]:
        """Named targets; of a foreign file all positions that are part of no path."""
        return self._own_targets() if self.own else self._all_targets()

    def _own_targets(self) -> dict[str, Target]:
        names = {**self.header.names["target"]}
        names.update({k: k for k in sorted(self.symbols.targets) if k[0] != "J"})
        made = {}
        for short, name in names.items():
            constant = self.positions.constant(short)
            if constant is not None:
                made[name] = target_of(constant, self.robot)
        return made

    def _all_targets(self) -> dict[str, Target]:
        placed = self.settings.placed
        made = {}
        for written in self.positions.all_names():
            key = written.upper()
            if key[0] == "J" or identifier(written) != written or self.runs.holds(key):
                continue
            if key in placed and key not in self.symbols.targets:
                continue
            if key in self.symbols.constants.assigned:
                self.symbols.declared(s.Variable(written))
                continue
            constant = self.positions.constant(written)
            if constant is not None:
                made[self.symbols.target_name(written)] = target_of(constant, self.robot)
        return made

    def joints(self) -> dict[str, JointTarget]:
        names = self.header.names["joints"]
        made = {}
        for written, (given, constant) in self.positions.names.items():
            if written[0] != "J" or written in self.header.inline:
                continue
            if self.own:
                if written in names:
                    made[names[written]] = joints_of(constant, self.robot)
            elif written in self.symbols.constants.assigned:
                self.symbols.declared(s.Variable(given))
            else:
                made[self.symbols.target_name(given)] = joints_of(constant, self.robot)
        return made
