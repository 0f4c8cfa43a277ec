"""Expressions of MELFA-BASIC as the pseudo-program says them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

from assistant.languages.melfa_basic import printer
from assistant.languages.melfa_basic import syntax as s
from assistant.languages.melfa_basic.header import Header
from assistant.languages.melfa_basic.lift.positions import Positions, joints_of, target_of
from assistant.languages.melfa_basic.functions import OF_ANGLE, PLAIN, TO_ANGLE
from assistant.program import expressions as e
from assistant.program.program import Signal, ValueType, Variable

if TYPE_CHECKING:
    from assistant.robots import Robot

_PLAIN: Final = {melfa.upper(): name for name, melfa in PLAIN.items()}
_OF_ANGLE: Final = {melfa.upper(): name for name, melfa in OF_ANGLE.items()}
_TO_ANGLE: Final = {melfa.upper(): name for name, melfa in TO_ANGLE.items()}
_OPERATORS: Final = {
    "\\": "div", "MOD": "mod", "AND": "and", "OR": "or", "XOR": "xor", "><": "<>", "=<": "<=",
    "=>": ">=",
}  # fmt: skip

SIGNALS: Final[dict[str, tuple[str, str, int]]] = {
    "M_IN": ("digital", "input", 1), "M_OUT": ("digital", "output", 1),
    "M_INB": ("group", "input", 8), "M_IN8": ("group", "input", 8),
    "M_OUTB": ("group", "output", 8), "M_OUT8": ("group", "output", 8),
    "M_INW": ("group", "input", 16), "M_IN16": ("group", "input", 16),
    "M_OUTW": ("group", "output", 16), "M_OUT16": ("group", "output", 16),
    "M_IN32": ("group", "input", 32), "M_OUT32": ("group", "output", 32),
}  # fmt: skip
"""Status variable → kind, direction and bits of the signal that it addresses."""


class Unliftable(Exception):
    """The pseudo-program has no words for it."""


class Meanings:
    """What the names of one file mean; it notes those that it meets.

    variables, signals: of the whole program. owner: the procedure whose body is read.
    """

    def __init__(
        self,
        header: Header,
        positions: Positions,
        robot: Robot | None,
        dialect: str,
        signals: dict[str, Signal],
        variables: dict[str, Variable],
        targets: set[str],
    ) -> None:
        self.header, self.positions, self.robot, self.dialect = header, positions, robot, dialect
        self.signals, self.variables, self.targets = signals, variables, targets
        self.types: dict[str, ValueType] = {}
        self.spelling = {name.upper(): name for name in variables}
        self.by_address = {
            (s_.kind, s_.direction, s_.bits, s_.number): n for n, s_ in signals.items()
        }

    def of(self, node: s.Expression) -> e.Expression:
        """Any value; what the pseudo-program cannot say stays as its text."""
        try:
            return self.plain(node)
        except Unliftable:
            return e.Verbatim(self.dialect, printer.expression(node, self.dialect.endswith("-4")))

    def plain(self, node: s.Expression) -> e.Expression:
        match node:
            case s.Number(value=value):
                return e.Number(value)
            case s.String(value=text):
                return e.Text(text)
            case s.Variable():
                return self.variable(node)
            case s.Unary(operator="-", operand=s.Number(value=value)):
                return e.Number(-value)
            case s.Unary(operator="-", operand=operand):
                return e.Unary("-", self.plain(operand))
            case s.Unary(operator="+", operand=operand):
                return self.plain(operand)
            case s.Binary(operator=operator, left=left, right=right):
                return self.binary(operator, left, right)
            case s.Constant(flags=flags):
                if flags is None:
                    raise Unliftable
                return e.TargetValue(target_of(node, self.robot))
        raise Unliftable

    def binary(self, operator: str, left: s.Expression, right: s.Expression) -> e.Expression:
        if isinstance(right, s.Constant) and operator in "+*":
            return self.moved(operator, left, right)
        if operator == "*" and self.is_position(left) and self.is_position(right):
            return e.Binary("@", self.plain(left), self.plain(right))
        if operator in ("<<", ">>"):
            raise Unliftable
        name = _OPERATORS.get(operator, operator)
        return e.Binary(name, self.plain(left), self.plain(right))  # type: ignore[arg-type]

    def is_position(self, node: s.Expression) -> bool:
        return isinstance(node, s.Variable) and node.key.startswith("P") and not node.component

    def moved(self, operator: str, left: s.Expression, shift: s.Constant) -> e.Expression:
        values = [0.0 if v is None else v for v in shift.values]
        values += [0.0] * (6 - len(values))
        if shift.flags is not None or any(values[6:]):
            raise Unliftable
        turned = values[3:6]
        if sum(v != 0.0 for v in turned) > (1 if operator == "*" else 0):
            raise Unliftable
        used = values[:6] if any(turned) else values[:3]
        while len(used) > 3 and used[-1] == 0.0:
            used.pop()
        name = "offset" if operator == "+" else "relative"
        return e.Apply(name, (self.plain(left), *(e.Number(v) for v in used)))

    def variable(self, node: s.Variable) -> e.Expression:
        if node.component:
            return self.component(node)
        key = node.key
        if node.arguments is not None:
            return self.called(node, key)
        if key == "P_CURR":
            return e.Apply("here")
        if key == "J_CURR":
            return e.Apply("joints_here")
        if key in ("M_ON", "M_OFF"):
            return e.Number(int(key == "M_ON"))
        return self.name(node)

    def name(self, node: s.Variable) -> e.Expression:
        """A variable by its original name; inline positions by their value."""
        key, names = node.key, self.header.names
        if key in self.header.inline:
            constant = self.positions.constant(key)
            if constant is None:
                raise Unliftable
            if key[0] == "J":
                return e.JointValue(joints_of(constant, self.robot))
            return e.TargetValue(target_of(constant, self.robot))
        for kind in ("target", "joints", "loop"):
            if key in names[kind]:
                return e.Name(names[kind][key])
        if key in self.header.variables:
            return e.Name(self.header.variables[key].name)
        if key[1:2] == "_":
            raise Unliftable
        if self.positions.constant(key) is not None:
            self.targets.add(key)
            return e.Name(node.name)
        if key not in self.spelling:
            self.spelling[key] = node.name
            self.variables[node.name] = Variable(self.type_of(node))
        return e.Name(self.spelling[key])

    def type_of(self, node: s.Variable) -> ValueType:
        if node.key in self.types:
            return self.types[node.key]
        if node.suffix == "$":
            return "text"
        if node.suffix in ("%", "&"):
            return "integer"
        letters: dict[str, ValueType] = {"P": "position", "J": "joints"}
        return letters.get(node.key[0], "number")

    def component(self, node: s.Variable) -> e.Expression:
        if node.component in ("X", "Y", "Z"):
            whole = s.Variable(node.name, node.suffix, node.arguments)
            return e.Member(self.variable(whole), node.component.lower())
        raise Unliftable

    def called(self, node: s.Variable, key: str) -> e.Expression:
        arguments = node.arguments or ()
        if any(a is None for a in arguments):
            raise Unliftable
        values = [a for a in arguments if a is not None]
        if key in SIGNALS and len(values) == 1 and isinstance(values[0], s.Number):
            return e.Name(self.signal(key, int(values[0].value)))
        if key in _OF_ANGLE and len(values) == 1:
            match values[0]:
                case s.Variable(arguments=(inner,)) as rad if (
                    rad.key == "RAD" and inner is not None
                ):
                    return e.Apply(_OF_ANGLE[key], (self.plain(inner),))
            raise Unliftable
        if key == "DEG" and len(values) == 1 and isinstance(values[0], s.Variable):
            return self.degrees(values[0])
        if key in _PLAIN:
            return e.Apply(_PLAIN[key], tuple(self.plain(v) for v in values))
        raise Unliftable

    def degrees(self, inner: s.Variable) -> e.Expression:
        if inner.key in _TO_ANGLE and inner.arguments:
            values = tuple(self.plain(a) for a in inner.arguments if a is not None)
            return e.Apply(_TO_ANGLE[inner.key], values)
        if inner.component[:1] == "J":
            whole = s.Variable(inner.name, inner.suffix, inner.arguments)
            return e.Member(self.variable(whole), inner.component.lower())
        raise Unliftable

    def signal(self, key: str, number: int) -> str:
        """The name of a signal by its address."""
        kind, direction, bits = SIGNALS[key]
        address = (cast(Any, kind), cast(Any, direction), bits, number)
        if address not in self.by_address:
            letter = {"digital": "d", "group": "g"}[kind]
            width = f"{bits}_" if kind == "group" else ""
            name = f"{letter}{'o' if direction == 'output' else 'i'}_{width}{number}"
            self.signals[name] = Signal(address[0], address[1], number, bits)
            self.by_address[address] = name
        return self.by_address[address]
