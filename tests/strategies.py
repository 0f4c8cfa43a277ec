"""Random programs for property tests: everything that a program can say, edge values included.

`programs()`, `paths()`, `statements()` and `expressions()` give parts that are sound in form
(unit quaternions, arcs of two rows, names without case clashes within one kind) but make no
sense as a whole: a name may refer to nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any, get_args

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from assistant.base import rotations
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
    Verbatim,
)
from assistant.program.geometry import (
    BASE,
    FLANGE,
    NO_EXTERNAL,
    Configuration,
    Frame,
    JointTarget,
    Load,
    Pose,
    Quaternion,
    Target,
    Tool,
)
from assistant.program.motion import (
    FINE,
    FULL_BLEND,
    MAXIMUM_SPEED,
    Blend,
    Kind,
    Path,
    Speed,
    configuration_row,
)
from assistant.program.program import (
    Declaration,
    Parameter,
    Procedure,
    Program,
    Signal,
    ValueType,
    Variable,
)
from assistant.program.statements import (
    Assign,
    Attach,
    Branch,
    Call,
    Case,
    ChannelKind,
    ChannelMode,
    Comment,
    ComputedBlend,
    ComputedSpeed,
    Detach,
    Follow,
    For,
    Goto,
    Gripper,
    If,
    Interrupt,
    Label,
    Measure,
    Message,
    Motion,
    Move,
    MoveCircular,
    MoveJoints,
    Opaque,
    Return,
    Send,
    SetAcceleration,
    SetOverride,
    SetSignal,
    StartTimer,
    Statement,
    Stop,
    Switch,
    SwitchInterrupt,
    SwitchInterrupts,
    Travel,
    Trigger,
    Wait,
    WaitSignal,
    WaitUntil,
    While,
)

APPLIED = [name for name in FUNCTIONS if name not in ("elapsed", "here")]
"""Functions that `Apply` calls; a timer is read by `Elapsed`, the position by `Here`."""
LANGUAGES = ("rapid", "melfa-basic-4", "melfa-basic-5", "melfa-basic-6")
ROBOTS = ("irb1200-7-0.7", "rv-2aj", "an unknown arm")
TRICKY_NAMES = (
    "end",
    "fine",
    "target",
    "to",
    "speed",
    "tool",
    "s",
    "not",
    "inf",
    "p1",
    "p10",
    "p2",
)
HOSTILE_TEXTS = (
    *("", " ", "end", "end\nend", '"', '\\"', "\\", "`", "#", "# no", '#"', "|", "| x", "\\n"),
    *("a\nb", "a\r\nb", "\n", "\t", "tab\tin", " ahead", "behind ", "\x00", "\x1b[31m", "\\x41"),
    *("\u2028", "\x85", "\ufeff", "ü", "日本", "\U0001f916", "\ud800", "\u202eevil", "x" * 300),
    *('TPWrite "a;b"; ! c', "MOV P1 'home"),
)


# ------------------------------------------------------------------------------ small things


@cache
def names() -> st.SearchStrategy[str]:
    """Identifiers, keywords among them."""
    plain = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,8}", fullmatch=True)
    return plain | st.sampled_from(TRICKY_NAMES)


@cache
def texts() -> st.SearchStrategy[str]:
    """Any text at all, the hostile ones often."""
    return st.sampled_from(HOSTILE_TEXTS) | st.text(max_size=20)


@cache
def comment_texts() -> st.SearchStrategy[str]:
    return st.text(st.characters(categories=("L", "N", "P", "S")), max_size=20) | texts()


@cache
def lengths() -> st.SearchStrategy[float]:
    """Millimetres or degrees: measured values, and the edges of a float."""
    return st.one_of(
        st.integers(-3000, 3000).map(float),
        st.floats(-5000, 5000),
        st.floats(allow_nan=False, allow_infinity=False),
        st.sampled_from([0.0, -0.0, 1e-300, 5e-324, 0.1 + 0.2, 1e16, 1.7976931348623157e308]),
    )


@cache
def amounts() -> st.SearchStrategy[float]:
    """Speeds, radii, masses: not negative."""
    return lengths().map(abs)


@cache
def quaternions() -> st.SearchStrategy[Quaternion]:
    """Unit quaternions: usual ones, random ones, and ones rounded to five decimals."""
    half = math.sqrt(0.5)
    usual = st.sampled_from(
        [(1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (half, 0.0, half, 0.0), (-0.0, 1.0, -0.0, 0.0)]
    )
    four = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
    exact = four.map(lambda q: tuple(float(v) for v in rotations.canonical(q)))
    rounded = exact.map(lambda q: tuple(round(v, 5) for v in q))
    return usual | exact | rounded  # type: ignore[return-value]


@cache
def vectors() -> st.SearchStrategy[tuple[float, float, float]]:
    return st.just((0.0, 0.0, 0.0)) | st.tuples(lengths(), lengths(), lengths())


@cache
def poses() -> st.SearchStrategy[Pose]:
    return st.builds(Pose, vectors(), quaternions())


@cache
def configurations() -> st.SearchStrategy[Configuration]:
    quadrant = st.integers(-4, 3) | st.sampled_from([-128, 127])
    flag = st.booleans()
    return st.builds(Configuration, flag, flag, flag, st.tuples(quadrant, quadrant, quadrant))


@cache
def externals() -> st.SearchStrategy[tuple[float, ...]]:
    axis = lengths() | st.just(math.nan) | st.just(math.inf)
    return st.just(NO_EXTERNAL) | st.tuples(*[axis] * 6)


@cache
def targets() -> st.SearchStrategy[Target]:
    return st.builds(Target, poses(), st.none() | configurations(), externals())


@cache
def joint_targets() -> st.SearchStrategy[JointTarget]:
    joints = st.lists(lengths() | st.just(math.nan), min_size=1, max_size=7).map(tuple)
    return st.builds(JointTarget, joints, externals())


@cache
def speeds() -> st.SearchStrategy[Speed]:
    usual = st.builds(Speed, amounts())
    whole = st.builds(Speed, amounts(), amounts(), amounts(), amounts(), st.none() | amounts())
    return usual | whole | st.just(MAXIMUM_SPEED)


@cache
def blends() -> st.SearchStrategy[Blend]:
    radius = st.none() | amounts() | st.just(math.inf)
    details = st.none() | st.tuples(*[amounts()] * 5)
    return st.sampled_from([FINE, FULL_BLEND]) | st.builds(Blend, radius, radius, details)


@cache
def tools() -> st.SearchStrategy[Tool]:
    load = st.builds(Load, amounts(), vectors(), quaternions(), vectors())
    return st.builds(Tool, poses(), st.none() | load, st.booleans(), st.booleans())


@cache
def frames() -> st.SearchStrategy[Frame]:
    seldom = st.just("") | names()
    return st.builds(Frame, poses(), poses(), st.booleans(), seldom, seldom)


@cache
def motions() -> st.SearchStrategy[Motion]:
    named = names().map(Name)
    parts = expressions(3)
    speed = st.builds(ComputedSpeed, st.none() | parts, parts, parts, parts, st.none() | parts)
    details = st.none() | st.tuples(*[parts] * 5)
    blend = st.builds(ComputedBlend, parts, st.none() | parts, details)
    return st.builds(
        Motion,
        speeds() | speed | named,
        blends() | blend | named,
        st.just(FLANGE) | names(),
        st.just(BASE) | names(),
    )


# ------------------------------------------------------------------------------- expressions


@cache
def routines() -> st.SearchStrategy[str]:
    """Names of what a program declares itself: no function, which has one name in any case."""
    return names().filter(lambda name: name.lower() not in FUNCTIONS)


def expressions(most: int = 8) -> st.SearchStrategy[Expression]:
    """Expressions of every kind; `most` leaves."""
    numbers = st.one_of(
        st.integers(-(10**20), 10**20),
        lengths(),
        st.sampled_from([math.inf, -math.inf, -0.0, -5, 0, 1.0]),
    )
    leaves: st.SearchStrategy[Expression] = st.one_of(
        numbers.map(Number),
        names().map(Name),
        names().map(Elapsed),
        st.builds(Here, names(), names()),
        st.booleans().map(Truth),
        texts().map(Text),
        targets().map(TargetValue),
        joint_targets().map(JointValue),
        poses().map(PoseValue),
        st.builds(Verbatim, st.sampled_from(LANGUAGES), texts()),
    )
    return st.recursive(leaves, _composed, max_leaves=most)


def _composed(part: st.SearchStrategy[Expression]) -> st.SearchStrategy[Expression]:
    several = st.lists(part, max_size=3).map(tuple)
    return st.one_of(
        st.builds(Aggregate, several),
        st.builds(Member, part, names()),
        st.builds(Index, part, several),
        st.builds(Unary, st.sampled_from(["-", "not"]), part),
        st.builds(Binary, st.sampled_from(get_args(BinaryOperator)), part, part),
        st.builds(Apply, st.sampled_from(APPLIED) | routines(), several),
    )


# ------------------------------------------------------------------------------------- paths


@st.composite
def paths(draw: st.DrawFn, most: int = 12) -> Path:
    """Paths of up to `most` rows, arcs, unstated branches and unused axes among them."""
    n = draw(st.integers(0, most))
    kinds: list[Kind] = []
    while len(kinds) < n:
        arc = n - len(kinds) > 1 and draw(st.booleans())
        kinds += [Kind.VIA, Kind.END] if arc else [draw(st.sampled_from([Kind.JOINT, Kind.LINEAR]))]
    few_turns = draw(st.lists(quaternions(), min_size=1, max_size=3))
    few_branches = draw(st.lists(st.none() | configurations(), min_size=1, max_size=3))
    few_axes = draw(st.lists(externals(), min_size=1, max_size=3))

    def rows(values: list[Any]) -> Any:
        chosen = draw(hnp.arrays(np.int32, n, elements=st.integers(0, len(values) - 1)))
        return np.array(values, dtype=np.float64)[chosen]

    def index(table: list[Any]) -> Any:
        return draw(hnp.arrays(np.int32, n, elements=st.integers(0, len(table) - 1)))

    named = names().map(Name)
    tables: dict[str, list[Any]] = {
        "speed": draw(st.lists(speeds() | named, min_size=1, max_size=3)),
        "blend": draw(st.lists(blends() | named, min_size=1, max_size=3)),
        "tool": draw(st.lists(st.just(FLANGE) | names(), min_size=1, max_size=3)),
        "frame": draw(st.lists(st.just(BASE) | names(), min_size=1, max_size=3)),
    }
    return Path.of(
        draw(names()),
        draw(hnp.arrays(np.float64, (n, 3), elements=lengths())),
        rows(few_turns),
        kinds=np.array(kinds, dtype=np.uint8),
        configurations=rows([configuration_row(b) for b in few_branches]).astype(np.int8),
        external=rows(few_axes),
        **{word: index(table) for word, table in tables.items()},
        **{word + "s": table for word, table in tables.items()},
    )


# -------------------------------------------------------------------------------- statements


@cache
def statements(most: int = 4) -> st.SearchStrategy[Statement]:
    """Statements of every kind; those that hold others hold about `most` in all."""
    return st.recursive(_simple(), _holding, max_leaves=most)


@cache
def bodies(most: int = 3) -> st.SearchStrategy[tuple[Statement, ...]]:
    return st.lists(statements(), max_size=most).map(tuple)


def triggers_of(value: st.SearchStrategy[Expression]) -> st.SearchStrategy[Trigger]:
    """Outputs on the way of a move, whose numbers are such expressions."""
    perhaps = st.none() | value
    measure = st.sampled_from(get_args(Measure))
    return st.builds(Trigger, names(), value, value, measure, perhaps, perhaps)


@cache
def _simple() -> st.SearchStrategy[Statement]:
    value = expressions(4)
    maybe = st.none() | value
    several = st.lists(value, max_size=3).map(tuple)
    trigger = triggers_of(st.integers(0, 9).map(Number) | names().map(Name))
    triggers = st.just(()) | trigger.map(lambda one: (one,)) | st.tuples(trigger, trigger)
    field = names()
    place = st.one_of(
        names().map(Name),
        st.builds(Member, names().map(Name), field),
        st.builds(Index, names().map(Name), several),
    )
    return st.one_of(
        st.builds(Move, st.sampled_from(["joint", "linear"]), value, motions(), triggers, maybe),
        st.builds(MoveCircular, value, value, motions(), triggers, maybe),
        st.builds(MoveJoints, value, motions(), triggers, maybe),
        st.builds(Travel, value, motions(), maybe, maybe),
        st.builds(Follow, paths()),
        st.builds(Wait, value),
        st.builds(WaitSignal, names(), value, maybe),
        st.builds(WaitUntil, value, maybe),
        st.builds(StartTimer, names()),
        st.builds(Interrupt, names(), value, st.builds(Call, names()), maybe),
        st.builds(SwitchInterrupt, names(), st.sampled_from(["on", "off"])),
        st.builds(SwitchInterrupts, st.sampled_from(["on", "off"])),
        st.builds(SetSignal, names(), value, maybe),
        st.builds(Gripper, st.sampled_from(["open", "close"]), st.integers(1, 8)),
        st.builds(SetAcceleration, value, value),
        st.builds(SetOverride, value),
        st.builds(Call, names(), several, st.none() | names()),
        st.builds(Assign, place, value),
        st.builds(Stop, st.booleans()),
        st.builds(Return, maybe),
        st.builds(Comment, comment_texts()),
        st.builds(Label, names()),
        st.builds(Goto, names()),
        st.builds(Message, several),
        st.builds(
            Attach,
            names(),
            st.sampled_from(get_args(ChannelKind)),
            several,
            st.sampled_from(get_args(ChannelMode)),
        ),
        st.builds(Detach, names()),
        st.builds(Send, names(), st.sampled_from(["line", "piece"]), several),
        st.builds(Opaque, st.sampled_from(LANGUAGES), texts()),
    )


def _holding(part: st.SearchStrategy[Statement]) -> st.SearchStrategy[Statement]:
    body = st.lists(part, max_size=3).map(tuple)
    value = expressions(3)
    branches = st.lists(st.builds(Branch, value, body), min_size=1, max_size=3).map(tuple)
    values = st.lists(value, max_size=3).map(tuple)
    cases = st.lists(st.builds(Case, values, body), max_size=3).map(tuple)
    step = st.just(Number(1)) | st.none() | value
    return st.one_of(
        st.builds(If, branches, body),
        st.builds(While, value, body),
        st.builds(For, names(), value, value, body, step),
        st.builds(Switch, value, cases, body),
    )


# ---------------------------------------------------------------------------------- programs


@cache
def programs(most: int = 3) -> st.SearchStrategy[Program]:
    """Whole programs of up to `most` procedures."""
    return st.builds(
        Program,
        name=names(),
        procedures=_once(procedures(), most).map(
            lambda given: tuple(_renamed(p, name) for name, p in given.items())
        ),
        entry=st.just("main") | st.none() | names(),
        robot=st.none() | st.sampled_from(ROBOTS),
        comments=st.lists(comment_texts(), max_size=3).map(tuple),
        frames=_once(frames()),
        tools=_once(tools()),
        speeds=_once(speeds()),
        blends=_once(blends()),
        signals=_once(signals()),
        targets=_once(targets()),
        joint_targets=_once(joint_targets()),
        variables=_once(variables()),
        declarations=st.lists(
            st.builds(Declaration, st.sampled_from(LANGUAGES), texts()), max_size=2
        ).map(tuple),
    )


@st.composite
def procedures(draw: st.DrawFn) -> Procedure:
    modes = st.sampled_from(["in", "inout"])
    parameters = draw(_once(st.tuples(_types(), modes, st.integers(0, 3))))
    taken = {name.lower() for name in parameters}
    local = {n: v for n, v in draw(_once(variables())).items() if n.lower() not in taken}
    return Procedure(
        draw(names()),
        draw(bodies()),
        tuple(Parameter(name, *rest) for name, rest in parameters.items()),
        local,
        draw(st.none() | _types()),
        draw(st.none() | names()),
        draw(st.booleans()),
    )


@cache
def signals() -> st.SearchStrategy[Signal]:
    return st.builds(
        Signal,
        st.sampled_from(["digital", "analog", "group"]),
        st.sampled_from(["input", "output"]),
        st.none() | st.integers(0, 10000),
        st.integers(1, 32),
    )


@cache
def variables() -> st.SearchStrategy[Variable]:
    return st.builds(
        Variable,
        _types(),
        st.none() | expressions(4),
        st.lists(st.integers(1, 100), max_size=3).map(tuple),
        st.sampled_from(["constant", "variable", "persistent"]),
        st.booleans(),
    )


@cache
def _types() -> st.SearchStrategy[ValueType]:
    return st.sampled_from(get_args(ValueType))


def _once(values: st.SearchStrategy[Any], most: int = 3) -> st.SearchStrategy[dict[str, Any]]:
    """A table whose names differ in more than case."""
    pairs = st.tuples(names(), values)
    return st.lists(pairs, max_size=most, unique_by=lambda pair: pair[0].lower()).map(dict)


def _renamed(procedure: Procedure, name: str) -> Procedure:
    return replace(procedure, name=name)
