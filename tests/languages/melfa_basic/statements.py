"""Random statements of MELFA-BASIC: one strategy a form, commands by the table of words."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Final

from hypothesis import strategies as st

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tree import syntax as s
from tests.languages.melfa_basic.values import (
    LEVELS,
    SMALL,
    STRINGS,
    Strategy,
    conditions,
    expressions,
    labels,
    or_none,
    some,
    targets,
    variables,
)

# ------------------------------------------------------------------------------- commands

IN_BLOCKS: Final = ("While", "WEnd", "Else", "EndIf", "Default", "FEnd", "Break", "Skip", "Act")
"""Commands that stand only where something else does, or have a form of their own."""

TYPED: Final[Mapping[str, str]] = {
    "Tool": "P", "Base": "P", "XLoad": "MC", "XRun": "MCM", "Torq": "MM", "ChrSrch": "cCm",
    "Wait": "?", "Dly": "M", "Title": "C", "FsGChg": "MMM",
}  # fmt: skip
"""Types of a command's arguments: ? a condition, c and m variables; of all others numbers."""

OFTEN: Final = 8
"""Times that a command is drawn which opens a line: no other one has nodes of that kind."""

MOST: Final = 4
"""Arguments of a command at most, where it takes more."""


def command(word: str) -> Strategy:
    return st.just(s.Command(word))


@cache
def commands(level: int) -> Strategy:
    """Statements that are a word and a list of arguments: all that the version has."""
    rows = [
        row
        for row in vocabulary.statements().values()
        if row.role == "command" and level in row.dialects and row.word not in IN_BLOCKS
    ]
    opening = [row for row in rows if _opens(row)]
    return st.sampled_from(rows + OFTEN * opening).flatmap(lambda row: _command(row, level))


def _opens(row: vocabulary.Statement) -> bool:
    return "lines" in row.effects and row.word.endswith("Open")


@cache
def _command(row: vocabulary.Statement, level: int) -> Strategy:
    most = min(MOST if row.most is None else row.most, MOST)
    counts = range(row.least, max(most, row.least) + 1)
    lists = [st.tuples(*(_argument(row, k, level) for k in range(count))) for count in counts]
    return st.builds(s.Command, st.just(row.word), st.one_of(lists))


def _argument(row: vocabulary.Statement, at: int, level: int) -> Strategy:
    if at == 0 and row.words:
        return st.sampled_from([word_node(word) for word in row.words])
    if at == 0 and "lines" in row.effects:
        name = st.builds(s.Opening, expressions("C", level, 1), SMALL)
        other = name if _opens(row) else expressions("M", level, 1)
        return st.builds(s.Channel, SMALL) | other
    kinds = TYPED.get(row.word, "")
    kind = kinds[at] if at < len(kinds) else "M"
    if kind == "?":
        return _waits(level)
    if kind == "c":
        return targets("C", level, 0)
    if kind == "m":
        return variables("M", level)
    return expressions(kind, level, 1)


def word_node(word: str) -> s.Expression:
    """The node of a bare word among the arguments of a command."""
    return s.Word(word) if word == "On" else s.Variable(word)


def _waits(level: int) -> Strategy:
    if LEVELS[level].wide_wait:
        return conditions(level)
    return st.builds(s.Binary, st.just("="), variables("M", level), SMALL)


# -------------------------------------------------------------------------------- motions


@cache
def motions(level: int) -> Strategy:
    """Moves with distance, type and what happens on the way."""
    number, place = expressions("M", level, 1), expressions("P", level, 1)
    joints, distance = expressions("J", level, 0), or_none(number)
    goal = st.one_of(
        st.builds(_given, place, distance),
        st.builds(_given, place, distance),
        joints.map(lambda one: (one,)),
    )
    from_here = number.map(lambda one: (None, one))
    arc = st.tuples(place, place, place)
    shared = {
        "type": or_none(st.tuples(SMALL, SMALL)),
        "append": or_none(_appends(level)),
    }
    made = [
        st.builds(s.Motion, st.just("Mov"), goal, **shared),
        st.builds(s.Motion, st.just("Mvs"), goal | from_here, **shared),
        st.builds(s.Motion, st.sampled_from(("Mvr", "Mvr2", "Mvr3", "Mvc")), arc, **shared),
        st.builds(s.Motion, st.just("Mva"), st.builds(_given, place, distance)),
    ]
    if level > 4:
        late = st.sampled_from(("EMvs", "MvSpl", "EMvSpl"))
        arcs = st.sampled_from(("EMvr", "EMvr2", "EMvr3", "EMvc"))
        made.append(st.builds(s.Motion, late, goal))
        made.append(st.builds(s.Motion, arcs, arc))
    return st.one_of(made)


def _given(*arguments: Any) -> tuple[Any, ...]:
    """Arguments up to the last that is there."""
    return arguments if arguments[-1] is not None else arguments[:-1]


@cache
def _appends(level: int) -> Strategy:
    done = st.sampled_from((s.Command("Hlt"), s.Command("Skip"))) | assignments(level)
    return st.builds(s.Append, done, or_none(conditions(level, 1)))


# --------------------------------------------------------------------------- assignments


@cache
def assignments(level: int) -> Strategy:
    """Of values to variables of their type, and pulses of outputs."""
    same = [st.builds(s.Assign, targets(k, level), expressions(k, level)) for k in "MCP"]
    joints = st.builds(s.Assign, variables("J", level), expressions("J", level))
    number = expressions("M", level, 1)
    rows = [
        row
        for row in vocabulary.variables().values()
        if row.type == "M" and row.writable and row.index and level in row.dialects
    ]
    output = st.builds(
        lambda row, index: s.Variable(row.name, "", (index,) * len(row.index)),
        st.sampled_from(rows),
        number,
    )
    return st.one_of(*same, joints, st.builds(s.Assign, output, number, or_none(SMALL)))


# ----------------------------------------------------------------------------------- flow

CALLED: Final = st.sampled_from(("MOVER", "1", "SUB10")).map(s.String)


@cache
def places(level: int) -> Strategy:
    """Where a jump goes; a number stands for any step and is settled later."""
    label = labels(level).map(s.Target)
    return label | st.integers(0, 99).map(s.Target) if LEVELS[level].line_targets else label


@cache
def jumps(level: int) -> Strategy:
    place, number = places(level), expressions("M", level)
    words = st.sampled_from(("GoTo", "GoSub"))
    several = st.builds(lambda one, more: (one, *more), place, some(or_none(place)))
    return st.one_of(
        st.builds(s.Jump, words, place),
        st.builds(s.OnJump, number, words, several),
        st.builds(s.OnCom, or_none(SMALL), place),
        st.builds(s.Com, or_none(SMALL), st.sampled_from(("On", "Off", "Stop"))),
        st.builds(s.DefAct, SMALL, conditions(level, 1), words, place, ACTS),
        st.builds(s.CallP, CALLED, some(expressions("M", level, 1) | variables("P", level))),
        st.builds(
            lambda number, value: s.Command("Act", (s.Binary("=", number, value),)), SMALL, SMALL
        ),
    )


ACTS: Final = st.sampled_from(("", "S", "L", "F"))
BRANCHES: Final = st.sampled_from(("Hlt", "End", "Return")).map(s.Command)


@cache
def decisions(level: int) -> Strategy:
    """`If` on one line: statements, jumps that are cut to their target, or both."""
    branch = st.one_of(BRANCHES, assignments(level), places(level), motions(level), jumps(level))
    return st.builds(s.If, conditions(level), branch, or_none(branch))


# ------------------------------------------------------------------------- communication


@cache
def communication(level: int) -> Strategy:
    """Files and lines to other computers."""
    text, number = expressions("C", level, 1), SMALL
    printed = st.one_of(text, expressions("M", level, 1), expressions("P", level, 1))
    items = st.lists(st.tuples(st.sampled_from(",;"), printed), max_size=3)
    last = st.sampled_from(((), ((",", None),), ((";", None),)))
    kinds = st.one_of(*(targets(k, level, 0) for k in "MCP"))
    return st.one_of(
        st.builds(s.Open, STRINGS | text, MODES, number),
        st.builds(s.Close, some(number)),
        st.builds(lambda n, x, y: s.Print(n, (*x, *(y if x else ()))), number, items, last),
        st.builds(s.Input, number, some(kinds, 1)),
    )


MODES: Final = st.sampled_from(("", "Input", "Output", "Append"))

# ---------------------------------------------------------------------------- definitions

NAMED_TYPES: Final = {
    4: ("Inte", "Float", "Double"),
    5: ("Inte", "Float", "Double", "Long"),
    6: ("Inte", "Float", "Double", "Long"),
}


def has(word: str, level: int) -> bool:
    return level in vocabulary.statements()[word.upper()].dialects


@cache
def definition(level: int) -> Strategy:
    """Definitions that may stand anywhere."""
    position, number = expressions("P", level, 0), SMALL
    numbers = st.builds(
        s.DefNames, st.sampled_from(NAMED_TYPES[level]), some(variables("M", level), 1)
    )
    sizes = some(st.integers(1, 99).map(s.Number), 1)
    arrays = st.builds(
        lambda variable, size: s.Variable(variable.name, variable.suffix, size),
        st.one_of(*(variables(k, level) for k in "MCPJ")),
        sizes,
    )
    dim = st.builds(s.Dim, some(arrays, 1))
    made = [
        numbers,
        st.builds(s.DefNames, st.just("Pos"), some(variables("P", level), 1)),
        st.builds(s.DefNames, st.just("Jnt"), some(variables("J", level), 1)),
        st.builds(s.DefNames, st.just("Char"), some(st.just(s.Variable("CWORD")), 1)),
        st.builds(s.DefIo, st.just(s.Variable("PORT")), IO_TYPES[level], number, or_none(number)),
        st.builds(
            lambda plate, diagonal, a, b, way: s.DefOther("Plt", (plate, *diagonal, a, b, way)),
            number,
            st.tuples(position, position, position, or_none(position)),
            number,
            number,
            st.integers(1, 3).map(s.Number),
        ),
        st.builds(lambda given: s.DefOther("Arch", given), some(number, 1, 8)),
        dim,
    ]
    if has("Const", level):
        variable, value = variables("M", level), expressions("M", level, 0)
        made.append(st.builds(s.Const, st.sampled_from(("", "Inte")), variable, value))
    if level > 4:
        kinds = st.sampled_from(("MoTrg", "Gps", "Map"))
        made.append(st.builds(s.DefOther, kinds, some(number, 1)))
    if has("Static", level):
        made.append(st.builds(s.Static, numbers | dim))
        made.append(st.builds(s.DefNames, st.just("Work"), some(variables("P", level), 1)))
    return st.one_of(made)


IO_TYPES: Final = {
    4: st.sampled_from(("Bit", "Byte", "Word", "Integer")),
    5: st.sampled_from(("Bit", "Byte", "Word", "Dword")),
    6: st.sampled_from(("Bit", "Byte", "Word", "Dword")),
}


@cache
def definitions(level: int) -> Strategy:
    """What stands at the head of a program."""
    parameters = some(variables("M", level) | variables("P", level), 1).map(s.FPrm)
    heads = [parameters]
    if has("#Include", level):
        heads.append(st.just(s.Include("BASE")))
    first = st.lists(st.one_of(heads), max_size=1)
    return st.builds(lambda a, b: (*a, *b), first, st.lists(definition(level), max_size=2))


# ------------------------------------------------------------------------------ functions

PARAMETERS: Final = (
    s.FunctionParameter("ByVal", "PWhere"),
    s.FunctionParameter("ByRef", "MUp", "%"),
    s.FunctionParameter("", "MList", "", True),
)
FUNCTIONS: Final[Mapping[str, tuple[s.Function, tuple[s.Statement, ...]]]] = {
    "Lift": (
        s.Function("V", "Lift", "", PARAMETERS[:2]),
        (s.Motion("Mov", (s.Variable("PWhere"),)), s.Command("Exit Function")),
    ),
    "Total": (
        s.Function("M%", "Total", "", PARAMETERS[2:]),
        (s.Assign(s.Variable("Total"), s.Number(1)),),
    ),
    "Greet": (s.Function("", "Greet", "", ()), ()),
}
"""Functions that stand behind a program that calls them: their heads and bodies."""


@cache
def _calls(level: int) -> Strategy:
    number, place = expressions("M", level, 1), expressions("P", level, 1)
    return st.one_of(
        st.builds(lambda p, m: _call("Lift", p, m), place, variables("M", level)),
        st.just(_call("Greet")),
        st.builds(
            lambda target, _: s.Assign(target, s.Variable("Total", "", (s.Variable("MLIST"),))),
            targets("M", level),
            number,
        ),
    )


def _call(name: str, *arguments: s.Expression) -> s.Call:
    return s.Call(s.Variable(name, "", arguments))


@cache
def simple(level: int) -> Strategy:
    """Any statement that may stand alone, blocks aside."""
    made = [
        commands(level),
        commands(level),
        motions(level),
        motions(level),
        assignments(level),
        jumps(level),
        decisions(level),
        communication(level),
        definition(level),
    ]
    if LEVELS[level].functions:
        made.append(_calls(level))
    return st.one_of(made)
