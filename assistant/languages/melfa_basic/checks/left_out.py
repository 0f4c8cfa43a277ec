"""What is left out where it is needed: values of positions, arguments, steps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeGuard

from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.text import printer
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows
from assistant.languages.melfa_basic.tree.line_tables import split_name
from assistant.languages.melfa_basic.tree.walk import nodes

POSITION_ELEMENTS: Final = ("X", "Y", "Z", "A", "B", "C", "L1", "L2")
POSE_ELEMENTS: Final = 6
"""Elements that a pose has."""
LEAST_VALUES: Final = 3
"""Values of a position without flags; fewer are joints."""
LEFT_OUT_BY_FOUR_AXES: Final = ("A", "B")
"""What the positions of a horizontal arm leave out (CR1D 4.3.12)."""
LEFT_OUT_BY_FIVE_AXES: Final = ("C",)
"""Components that positions of a five-axis arm may leave out."""


def missing_coordinates(look: Look) -> Found:
    """Positions that leave out values; those that leave out all were never taught.

    An error where the program takes them as a pose, which the controller refuses.
    """
    taken = set[tuple[int, str]]()
    for lacking in incomplete_poses(look.tree):
        taken.add((id(lacking.item), lacking.name.upper()))
        yield look.at(
            rules.UNDEFINED, lacking.item, lacking.word, name=lacking.name, what=lacking.what
        )
    for item in look.data:
        if not isinstance(item, s.Data) or not isinstance(item.value, s.Constant):
            continue
        values, flags = item.value.values, item.value.flags
        if all(value is None for value in values):
            continue
        left_out = list(
            _missing_elements(item.value) if not item.variable.key.startswith("J") else ()
        )
        if flags is not None and (flags[0] is None) != (flags[1] is None):
            left_out.append("FL1" if flags[0] is None else "FL2")
        if (
            left_out
            and tuple(left_out) != LEFT_OUT_BY_FOUR_AXES
            and (id(item), item.variable.key) not in taken
        ):
            what = " and ".join(left_out)
            yield look.at(rules.GAP, item, item.variable, name=item.variable.name, what=what)
    for line, node in look.all(s.Binary):
        for constant in incomplete_summands(node):
            name, what = printer.expression(constant), " and ".join(_missing_elements(constant))
            yield look.at(rules.GAP, line, name, name=name, what=what)


def _missing_elements(constant: s.Constant) -> tuple[str, ...]:
    """The elements of a pose that a constant leaves out, and additional axes among others."""
    values = constant.values
    short = POSITION_ELEMENTS[len(values) : POSE_ELEMENTS]
    return (
        *(name for name, value in zip(POSITION_ELEMENTS, values, strict=False) if value is None),
        *short,
    )


def _is_undefined(value: object) -> TypeGuard[s.Constant]:
    """True if it is a position constant that the controller does not accept as a pose."""
    if not isinstance(value, s.Constant) or all(one is None for one in value.values):
        return False
    if value.flags is None and len(value.values) < LEAST_VALUES:
        return False
    found = tuple(
        name for name in _missing_elements(value) if name in POSITION_ELEMENTS[:POSE_ELEMENTS]
    )
    return bool(found) and found not in (LEFT_OUT_BY_FOUR_AXES, LEFT_OUT_BY_FIVE_AXES)


def incomplete_summands(node: s.Binary) -> Iterator[s.Constant]:
    """Constants of a sum or a difference of positions that leave out values."""
    if node.operator in ("+", "-"):
        yield from (one for one in (node.left, node.right) if _is_undefined(one))


@dataclass(frozen=True, slots=True)
class IncompletePose:
    """A position that is taken as a pose and has elements without a value.

    item: its line, word: what of it; the name is as it is written.
    """

    item: s.Line | s.Data
    word: s.Variable | str
    name: str
    what: str


def incomplete_poses(tree: s.File) -> Iterator[IncompletePose]:
    """Positions of a file that it takes as poses though they leave out elements of one.

    One whose elements the program sets, or that anything else may change, is left aside.
    """
    given: dict[str, tuple[s.Line | s.Data, s.Variable, s.Constant]] = {}
    for item in tree.items:
        if isinstance(item, s.Data) and item.variable.arguments is None:
            if _is_undefined(item.value) and not item.variable.key.startswith("J"):
                given[item.variable.key] = item, item.variable, item.value
    code = [item for item in tree.items if isinstance(item, s.Line) and item.statement is not None]
    changed, copies = set[str](), list[tuple[str, str]]()
    for line in code:
        for node in nodes(line.statement):
            match node:
                case s.Assign(s.Variable(component="") as target, value) if _is_undefined(value):
                    given.setdefault(target.key, (line, target, value))
                case s.Assign(s.Variable(component="", arguments=None) as target, value):
                    if isinstance(value, s.Variable) and not value.component:
                        copies.append((target.key, value.key))
                    else:
                        changed.add(target.key)
                case s.Assign(s.Variable(arguments=None) as target):
                    changed.add(target.key)
                case s.Input() | s.FPrm() | s.CallP() | s.Call() | s.DefOther():
                    changed |= {x.key for x in nodes(node) if isinstance(x, s.Variable)}
    origin = {key: key for key in given if key not in changed}
    for _ in copies:
        found = {to: origin[key] for to, key in copies if key in origin and to not in changed}
        if found.items() <= origin.items():
            break
        origin |= {to: key for to, key in found.items() if to not in origin}
    said = set[str]()
    for line in code:
        for pose in _poses(line.statement):
            if isinstance(pose, s.Constant) and _is_undefined(pose):
                text = printer.expression(pose)
                yield IncompletePose(line, text, text, _missing_words(pose))
            elif isinstance(pose, s.Variable) and pose.key in origin and not pose.component:
                said.add(origin[pose.key])
    for rows in (item for item in tree.items if isinstance(item, MoveRows)):
        for key in origin:
            named = split_name(s.Variable(key))
            if named is not None and named[0].upper() == rows.stem.upper():
                if any(named[1] in column for column in (rows.start, rows.via, rows.end)):
                    said.add(origin[key])
    for key in sorted(said, key=list(given).index):
        item, variable, constant = given[key]
        yield IncompletePose(item, variable, variable.name, _missing_words(constant))


def _missing_words(constant: s.Constant) -> str:
    return " and ".join(
        name for name in _missing_elements(constant) if name in POSITION_ELEMENTS[:POSE_ELEMENTS]
    )


def _poses(statement: s.Statement | s.Target | None) -> Iterator[s.Expression | None]:
    """Values that a statement takes as poses."""
    for node in nodes(statement):
        match node:
            case s.Motion(arguments=arguments):
                yield from arguments
            case s.Command("Tool" | "Base", arguments):
                yield from arguments
            case s.Binary("*" | "/", left, right):
                if any(map(_is_position, (left, right))):
                    yield from (left, right)
            case s.Variable(key="INV", arguments=tuple(arguments)):
                yield from arguments


def _is_position(value: s.Expression) -> bool:
    return isinstance(value, s.Constant) or (
        isinstance(value, s.Variable) and value.key.startswith("P") and not value.component
    )


NEEDED_ARGUMENTS: Final = {"Plt": 3}
"""`Def` of what → arguments behind its number that may not be left out."""


def missing_arguments(look: Look) -> Found:
    """Arguments that only stand after another one, and positions that a definition needs."""
    for line, motion in look.all(s.Motion):
        if motion.keyword != "Mvs" and motion.arguments[:1] == (None,):
            yield look.at(rules.LEFT_OUT, line, motion.keyword, word=motion.keyword, which="first")
    for line, node in look.all(s.DefOther):
        needed = node.arguments[: 1 + NEEDED_ARGUMENTS.get(node.kind, 0)]
        if None in needed:
            word = f"Def {node.kind}"
            which = ("first", "second", "third", "fourth")[needed.index(None)]
            yield look.at(rules.LEFT_OUT, line, word, word=word, which=which)
    for line, variable in look.all(s.Variable):
        if variable.arguments == () and vocabulary.status(variable.name) is not None:
            name = variable.name
            yield look.at(rules.LEFT_OUT, line, variable, word=name, which="first")


def misplaced_lines(look: Look) -> Found:
    """Steps that hold nothing, and what looks like a variable line between steps."""
    for item in before_last_step(look):
        match item:
            case s.Line(number=int(), label=None, statement=None, comment=None):
                yield look.finding(rules.EMPTY_STEP, item, number=item.number)
            case s.Data(type=""):
                yield look.at(rules.AMONG_STEPS, item, item.variable)


def before_last_step(look: Look) -> Sequence[s.Item]:
    """The lines up to the last step."""
    code = [at for at, item in enumerate(look.tree.items) if _is_step(look, item)]
    return look.tree.items[: code[-1] + 1] if code else ()


def _is_step(look: Look, item: s.Item) -> bool:
    """Whether an item is code; what has no number and is damaged may be a variable line."""
    sure = look.damage is None
    return isinstance(item, MoveRows) or (
        isinstance(item, s.Line) and (sure or item.number is not None)
    )
