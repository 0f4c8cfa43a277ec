"""What is left out where it is needed: values of positions, arguments, steps."""

from __future__ import annotations

from typing import Final

from assistant.languages.checks.registry import Found
from assistant.languages.melfa_basic.checks import value_rules as rules
from assistant.languages.melfa_basic.checks.file_view import Look
from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from assistant.languages.melfa_basic.tree.columnar import MoveRows

ELEMENTS: Final = ("X", "Y", "Z", "A", "B", "C", "L1", "L2")
FOUR_AXES: Final = ("A", "B")
"""What the positions of a horizontal arm leave out (CR1D 4.3.12)."""


def positions(look: Look) -> Found:
    """Position lines that leave out one value among others; those that leave out all are new."""
    for item in look.data:
        if not isinstance(item, s.Data) or not isinstance(item.value, s.Constant):
            continue
        values, flags = item.value.values, item.value.flags
        if all(value is None for value in values):
            continue
        known = dict(zip(ELEMENTS, values, strict=False))
        left_out = [name for name, value in known.items() if value is None]
        if flags is not None and (flags[0] is None) != (flags[1] is None):
            left_out.append("FL1" if flags[0] is None else "FL2")
        if left_out and tuple(left_out) != FOUR_AXES:
            what = " and ".join(left_out)
            yield look.at(rules.GAP, item, item.variable, what=what)


NEEDED: Final = {"Plt": 3}
"""`Def` of what → arguments behind its number that may not be left out."""


def arguments(look: Look) -> Found:
    """Arguments that only stand after another one, and positions that a definition needs."""
    for line, motion in look.all(s.Motion):
        if motion.keyword != "Mvs" and motion.arguments[:1] == (None,):
            yield look.at(rules.LEFT_OUT, line, motion.keyword, word=motion.keyword, which="first")
    for line, node in look.all(s.DefOther):
        needed = node.arguments[: 1 + NEEDED.get(node.kind, 0)]
        if None in needed:
            word = f"Def {node.kind}"
            which = ("first", "second", "third", "fourth")[needed.index(None)]
            yield look.at(rules.LEFT_OUT, line, word, word=word, which=which)
    for line, variable in look.all(s.Variable):
        if variable.arguments == () and vocabulary.status(variable.name) is not None:
            name = variable.name
            yield look.at(rules.LEFT_OUT, line, variable, word=name, which="first")


def lines(look: Look) -> Found:
    """Steps that hold nothing, and what looks like a variable line between steps."""
    code = [at for at, item in enumerate(look.tree.items) if _is_step(look, item)]
    last = code[-1] if code else -1
    for item in look.tree.items[: last + 1]:
        match item:
            case s.Line(number=int(), label=None, statement=None, comment=None):
                yield look.finding(rules.EMPTY_STEP, item, number=item.number)
            case s.Data(type=""):
                yield look.at(rules.AMONG_STEPS, item, item.variable)


def _is_step(look: Look, item: s.Item) -> bool:
    """Whether an item is code; what has no number and is damaged may be a variable line."""
    sure = look.damage is None
    return isinstance(item, MoveRows) or (
        isinstance(item, s.Line) and (sure or item.number is not None)
    )
