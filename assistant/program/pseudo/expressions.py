"""Expressions as text and back, with brackets only where the priorities ask for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, assert_never, cast

from lark import Token, Tree

from assistant.program.diagnostics import Refused
from assistant.program.expressions import (
    FUNCTIONS,
    Aggregate,
    Apply,
    Binary,
    BinaryOperator,
    Elapsed,
    Expression,
    Here,
    Index,
    JointValue,
    Member,
    Name,
    Number,
    PoseValue,
    TargetValue,
    Text,
    Truth,
    Unary,
    UnaryOperator,
    Verbatim,
)
from assistant.program.pseudo.findings import MOST_DEEP, NO_PLACE, TOO_DEEP, Wrong
from assistant.program.pseudo.values import (
    joints_text,
    pose_text,
    read_joints,
    read_pose,
    read_target,
    target_text,
)
from assistant.program.pseudo.words import (
    Node,
    name_text,
    quoted,
    read_integer,
    read_name,
    read_number,
    read_word,
    unquoted,
    word_text,
)

COMPARISON, MINUS, POWER, LITERAL, ATOM = 5, 8, 9, 10, 11

PRIORITIES: Final[dict[str, int]] = {
    "or": 1, "xor": 2, "and": 3, "not": 4,
    "=": COMPARISON, "<>": COMPARISON, "<": COMPARISON, "<=": COMPARISON,
    ">": COMPARISON, ">=": COMPARISON,
    "+": 6, "-": 6, "*": 7, "/": 7, "@": 7, "div": 7, "mod": 7, "^": POWER,
}  # fmt: skip
"""Operators, the loosest first. `^` groups from the right, comparisons not at all, the rest
from the left. A sign binds looser than `^`."""


def expression_text(expression: Expression, least: int = 0) -> str:
    """Raises Refused for an expression of more levels than can be read back."""
    try:
        text = _text(expression, least)
    except RecursionError:
        text = None
    if text is None or (len(text) > MOST_DEEP and _is_deeper(expression, MOST_DEEP - 10)):
        raise Refused(TOO_DEEP(what="expression", cure="split it into several"))
    return text


def assignable_text(expression: Expression) -> str:
    """An expression as it stands on the left of `=`."""
    return expression_text(expression, ATOM)


def arguments_text(items: tuple[Expression, ...]) -> str:
    return ", ".join(map(expression_text, items))


def read_expression(tree: object) -> Expression:
    """The expression of a tree; raises Wrong."""
    assert isinstance(tree, Tree)
    return _READERS[tree.data](tree)


def read_arguments(tree: object) -> tuple[Expression, ...]:
    assert isinstance(tree, Tree)
    return tuple(read_expression(child) for child in tree.children if child is not None)


# ------------------------------------------------------------------------------------- to text


def _text(expression: Expression, least: int) -> str:
    """In brackets if the expression binds looser than `least`."""
    text, priority = _text_and_priority(expression)
    return f"({text})" if priority < least else text


def _text_and_priority(expression: Expression) -> tuple[str, int]:
    match expression:
        case Number(value):
            text = _number_text(value)
            return text, MINUS if text.startswith("-") else LITERAL
        case Truth(value):
            return "true" if value else "false", ATOM
        case Text(value):
            return quoted(value), ATOM
        case Name(name):
            return name_text(name), ATOM
        case TargetValue(target):
            return f"target {target_text(target)}", LITERAL
        case JointValue(joints):
            return f"joints {joints_text(joints)}", LITERAL
        case PoseValue(pose):
            return f"pose {pose_text(pose)}", LITERAL
        case Aggregate(items):
            return f"[{_list(items)}]", ATOM
        case Member(value, field):
            return f"{_text(value, ATOM)}.{name_text(field)}", ATOM
        case Index(value, indices):
            return f"{_text(value, ATOM)}[{_list(indices)}]", ATOM
        case Unary(operator, operand):
            return _unary_text(operator, operand)
        case Binary(operator, left, right):
            return _binary_text(operator, left, right)
        case Apply(function, arguments):
            return f"{name_text(function)}({_list(arguments)})", ATOM
        case Elapsed(timer):
            return f"elapsed({name_text(timer)})", ATOM
        case Here(tool, frame):
            return f"here({name_text(tool)}, {name_text(frame)})", ATOM
        case Verbatim(language, text):
            return f"verbatim {word_text(language)} {quoted(text)}", ATOM
    assert_never(expression)


def _list(items: tuple[Expression, ...]) -> str:
    return ", ".join(_text(item, 0) for item in items)


def _is_deeper(expression: Expression, most: int) -> bool:
    """Whether there are more levels; looked at without recursion."""
    level: list[Expression] = [expression]
    for _ in range(most):
        level = [part for whole in level for part in _parts(whole)]
        if not level:
            return False
    return True


def _parts(expression: Expression) -> tuple[Expression, ...]:
    match expression:
        case Aggregate(items) | Apply(arguments=items):
            return items
        case Member(value):
            return (value,)
        case Index(value, indices):
            return (value, *indices)
        case Unary(operand=operand):
            return (operand,)
        case Binary(left=left, right=right):
            return (left, right)
    return ()


def _number_text(value: float) -> str:
    """An int as digits, a float with its point, so that either comes back as what it was."""
    return str(int(value)) if isinstance(value, int) else repr(float(value))


def _unary_text(operator: UnaryOperator, operand: Expression) -> tuple[str, int]:
    if operator == "not":
        return f"not {_text(operand, PRIORITIES['not'])}", PRIORITIES["not"]
    text = _text(operand, MINUS)
    bare = isinstance(operand, Number) and not text.startswith("-")
    return (f"-({text})" if bare else f"-{text}"), MINUS  # `-5` is the number, `-(5)` its sign


def _binary_text(operator: BinaryOperator, left: Expression, right: Expression) -> tuple[str, int]:
    priority = PRIORITIES[operator]
    if operator == "^":
        first, second = LITERAL, MINUS
    else:
        first, second = priority + (priority == COMPARISON), priority + 1
    return f"{_text(left, first)} {operator} {_text(right, second)}", priority


# ----------------------------------------------------------------------------------- from text


def _read_number(tree: Node) -> Expression:
    token = cast(Token, tree.children[0])
    return Number(read_integer(token) if token.isdigit() else read_number(token))


def _read_unary(tree: Node) -> Expression:
    operator, operand = tree.children
    inner = read_expression(operand)
    if operator == "-" and cast(Node, operand).data == "number":
        return Number(-cast(Number, inner).value)
    return Unary(cast(UnaryOperator, str(operator)), inner)


def _read_binary(tree: Node) -> Expression:
    left, operator, right = tree.children
    return Binary(
        cast(BinaryOperator, str(operator)), read_expression(left), read_expression(right)
    )


def _read_apply(tree: Node) -> Expression:
    function, given = read_name(_child(tree)), read_arguments(_child(tree, 1))
    function = function.lower() if function.lower() in FUNCTIONS else function
    match function, given:
        case "elapsed", (Name(timer),):
            return Elapsed(timer)
        case "here", (Name(tool), Name(frame)):
            return Here(tool, frame)
        case "here", _:
            raise Wrong(NO_PLACE, tree)
    return Apply(function, given)


def _child(tree: Node, index: int = 0) -> Any:
    return tree.children[index]


_READERS: Final[dict[str, Callable[[Node], Expression]]] = {
    "number": _read_number,
    "truth": lambda tree: Truth(_child(tree) == "true"),
    "text": lambda tree: Text(unquoted(_child(tree))),
    "variable_value": lambda tree: Name(read_name(_child(tree))),
    "target_value": lambda tree: TargetValue(read_target(_child(tree))),
    "joint_value": lambda tree: JointValue(read_joints(_child(tree))),
    "pose_value": lambda tree: PoseValue(read_pose(_child(tree))),
    "aggregate": lambda tree: Aggregate(read_arguments(_child(tree))),
    "group": lambda tree: read_expression(_child(tree)),
    "member": lambda tree: Member(read_expression(_child(tree)), read_name(_child(tree, 1))),
    "index": lambda tree: Index(read_expression(_child(tree)), read_arguments(_child(tree, 1))),
    "unary": _read_unary,
    "binary": _read_binary,
    "apply": _read_apply,
    "verbatim": lambda tree: Verbatim(read_word(_child(tree)), unquoted(_child(tree, 1))),
}
