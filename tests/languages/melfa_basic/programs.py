"""Random programs that MELFA-BASIC can say, and what their poses may be off by."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from hypothesis import strategies as st

from assistant.base import rotations
from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Configuration, Frame, JointTarget, Pose, Target, Tool
from assistant.program.motion import FINE, FULL_BLEND, Blend, Kind, Path, Speed
from assistant.program.program import Parameter, Procedure, Program, Signal, Variable

speeds = st.builds(
    Speed,
    st.sampled_from([5.0, 12.5, 150.0, 2000.0, math.inf]),
    joint=st.sampled_from([None, 5.0, 12.5, 100.0]),
)
blends = st.sampled_from([FINE, FULL_BLEND, Blend(3.0), Blend(2.5, 4.0), Blend(0.0)])
motions = st.builds(
    p.Motion,
    speeds,
    blends,
    st.sampled_from(["tool0", "gripper", "Torch_2"]),
    st.sampled_from(["base", "table"]),
)
numbers = st.one_of(
    st.integers(-9999, 9999), st.sampled_from([0.5, -2.25, 1e-7, 3.3333333333333335])
).map(e.Number)


def target(seed: int) -> Target:
    rng = np.random.default_rng(seed)
    quaternion = rotations.canonical(rng.normal(size=4))
    stated = Configuration(
        bool(seed & 1), bool(seed & 2), bool(seed & 4), (0, int(rng.integers(-2, 3)) * 4, 4)
    )
    return Target(Pose.of(rng.uniform(-900, 900, 3), quaternion), stated if seed % 3 else None)


in_base = st.builds(dataclasses.replace, motions, frame=st.just("base"))
"""Of joint targets, which are in no frame."""
targets = st.integers(0, 99).map(target)
positions = st.one_of(
    st.sampled_from([e.Name("home"), e.Name("park_position")]),
    targets.map(e.TargetValue),
    st.builds(
        lambda name, z: e.Apply("offset", (name, e.Number(1), e.Number(0), z)),
        st.just(e.Name("home")),
        numbers,
    ),
    st.builds(
        lambda z: e.Apply("relative", (e.Name("HOME"), e.Number(0), e.Number(0), z)), numbers
    ),
)
places = st.sampled_from(
    [e.Number(1), e.Name("count"), e.Binary("+", e.Name("count"), e.Number(1))]
)
elements = st.builds(lambda at: e.Index(e.Name("row"), (at,)), places)


def fitting(value: e.Expression) -> e.Expression:
    """The value; a number that each group has the bits for."""
    while isinstance(value, e.Unary) and value.operator == "-":
        value = value.operand
    return e.Number(abs(int(value.value)) % 256) if isinstance(value, e.Number) else value


def whole(value: e.Expression) -> e.Expression:
    """The value; a number without fraction, which no register of an output holds."""
    if isinstance(value, e.Unary) and value.operator == "-":
        return e.Unary("-", whole(value.operand))
    return e.Number(int(value.value)) if isinstance(value, e.Number) else value


def waits_for_signal(condition: e.Expression) -> bool:
    """Whether the wait for it is read as `WaitSignal`, which the programs have as well."""
    match condition:
        case e.Binary("=", e.Name("sensor" | "dial"), e.Number() | e.Unary("-", e.Number())):
            return True
    return False


values = st.recursive(
    st.one_of(
        *(elements, numbers),
        st.sampled_from([e.Name("count"), e.Name("limit"), e.Name("ok")]),
        st.sampled_from([e.Name("sensor"), e.Name("dial")]),
    ),
    lambda inner: st.one_of(
        st.builds(e.Binary, st.sampled_from(["+", "-", "*", "/", "mod", "div", "^"]), inner, inner),
        st.builds(lambda v: e.Apply("abs", (v,)), inner),
        st.builds(lambda v: e.Apply("sin", (v,)), inner),
        st.builds(lambda a, b: e.Apply("larger", (a, b)), inner, inner),
        st.builds(lambda v: e.Unary("-", v), inner),
    ),
    max_leaves=5,
)
conditions = st.recursive(
    st.builds(e.Binary, st.sampled_from(["=", "<>", "<", "<=", ">", ">="]), values, values),
    lambda inner: st.one_of(
        st.builds(e.Binary, st.sampled_from(["and", "or"]), inner, inner),
        st.builds(lambda v: e.Unary("not", v), inner),
    ),
    max_leaves=3,
)
awaited = conditions.filter(lambda c: not waits_for_signal(c))
seconds = st.sampled_from([e.Number(2), e.Number(0.25), e.Name("limit")])


@st.composite
def paths(draw: st.DrawFn) -> p.Follow:
    n = draw(st.integers(1, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    kinds: list[int] = []
    while len(kinds) < n:
        kinds += [[Kind.JOINT], [Kind.LINEAR], [Kind.VIA, Kind.END]][int(rng.integers(3))]
    n = len(kinds)
    external = None
    if draw(st.booleans()):
        external = np.full((n, 6), np.nan)
        external[:, 0] = rng.uniform(-90, 90, n)
    table = draw(st.lists(speeds, min_size=1, max_size=3))
    corners = draw(st.lists(blends, min_size=1, max_size=3))
    return p.Follow(
        Path.of(
            draw(st.sampled_from(["seam", "cut_2"])),
            rng.uniform(-800, 800, (n, 3)),
            rotations.canonical(rng.normal(size=(n, 4))),
            kinds=kinds,
            external=external,
            speeds=table,
            blends=corners,
            tools=["gripper", "tool0"],
            frames=["base", "table"],
            speed=rng.integers(0, len(table), n),
            blend=rng.integers(0, len(corners), n),
            tool=rng.integers(0, 2, n),
            frame=rng.integers(0, 2, n),
        )
    )


simple = st.one_of(
    paths(),
    st.builds(p.Move, st.sampled_from(["joint", "linear"]), positions, motions),
    st.builds(p.MoveCircular, positions, positions, motions),
    st.builds(p.MoveJoints, st.just(e.Name("ready")), in_base),
    st.builds(p.MoveJoints, st.just(e.JointValue(JointTarget((1.5, 2, 3, 4, 5, 6)))), in_base),
    st.builds(p.Wait, st.sampled_from([e.Number(0.5), e.Name("limit")])),
    st.builds(p.WaitSignal, st.just("ok"), st.sampled_from([e.Truth(True), e.Number(0)])),
    st.builds(p.WaitSignal, st.just("ok"), st.just(e.Truth(True)), seconds),
    st.builds(p.WaitUntil, awaited),
    st.builds(p.WaitUntil, awaited.filter(lambda c: "larger" not in repr(c)), seconds),
    st.builds(p.StartTimer, st.sampled_from(["lap", "timer_3"])),
    st.builds(
        p.Assign,
        st.just(e.Name("limit")),
        st.sampled_from([e.Elapsed("lap"), e.Binary("*", e.Elapsed("Lap"), e.Number(1000))]),
    ),
    st.builds(
        lambda limit: p.If((p.Branch(e.Binary("<", e.Elapsed("timer_3"), limit), (p.Stop(),)),)),
        numbers,
    ),
    st.builds(
        p.SetSignal,
        st.just("glue"),
        st.sampled_from([e.Truth(True), e.Number(0)]),
        st.sampled_from([None, e.Number(0.25)]),
    ),
    st.builds(p.SetSignal, st.just("level"), values.map(whole)),
    st.builds(p.SetSignal, st.sampled_from(["mode", "answer"]), values.map(fitting)),
    st.builds(p.Gripper, st.sampled_from(["open", "close"]), st.integers(1, 8)),
    st.builds(p.SetAcceleration, st.just(e.Number(50)), st.just(e.Number(80))),
    st.builds(p.SetOverride, st.just(e.Number(40))),
    st.builds(p.Assign, st.sampled_from([e.Name("count"), e.Name("limit")]), values),
    st.builds(p.Assign, elements, values),
    st.sampled_from([e.Here("tool0", "base"), e.Here("Gripper", "Base"), e.Name("home")]).map(
        lambda v: p.Assign(e.Name("place"), v)
    ),
    st.just(p.Assign(e.Name("count"), e.Member(e.Here("gripper", "base"), "x"))),
    st.builds(lambda v: p.Call("show", (v, e.Name("count"))), values),
    st.builds(p.Comment, st.text(max_size=150)),
    st.builds(p.Message, st.just((e.Text("hello"),))),
    st.sampled_from([p.Call("weld"), p.Call("far"), p.Stop(), p.Return(), p.Goto("again")]),
)


def nested(inner: st.SearchStrategy[p.Statement]) -> st.SearchStrategy[p.Statement]:
    bodies = st.lists(inner, max_size=3).map(tuple)
    branches = st.lists(st.builds(p.Branch, conditions, bodies), min_size=1, max_size=3)
    cases = st.lists(
        st.builds(p.Case, st.lists(numbers, min_size=1, max_size=2).map(tuple), bodies),
        min_size=1,
        max_size=3,
    )
    return st.one_of(
        st.builds(p.If, branches.map(tuple), bodies),
        st.builds(p.While, conditions, bodies),
        st.builds(p.For, st.just("i"), numbers, numbers, bodies),
        st.builds(p.For, st.just("i"), numbers, numbers, bodies, st.just(e.Number(2))),
        st.builds(p.Switch, st.just(e.Name("count")), cases.map(tuple), bodies),
    )


statements = st.recursive(simple, nested, max_leaves=6)
bodies = st.lists(statements, max_size=8).map(tuple)


def alone(statement: p.Statement) -> bool:
    """Whether a called program can say it: it has no variables of the main one."""
    told = repr(statement)
    main = ("count", "row", "larger", "place")
    return not isinstance(statement, p.Call | p.Goto) and not any(name in told for name in main)


def unaliased(statement: p.Statement) -> bool:
    """Whether `show` can say it: it is given `count` to change, and may not name it besides."""
    return not isinstance(statement, p.Call | p.Goto) and "count" not in repr(statement)


larger = Procedure(
    "larger",
    (
        p.If((p.Branch(e.Binary(">", e.Name("a"), e.Name("b")), (p.Return(e.Name("a")),)),)),
        p.Return(e.Name("b")),
    ),
    (Parameter("a", "number"), Parameter("b", "number")),
    result="number",
)


def show(body: tuple[p.Statement, ...]) -> Procedure:
    """A procedure with a parameter of each mode and a variable of its own."""
    own = p.Assign(e.Name("own"), e.Binary("+", e.Name("v"), e.Name("kept")))
    kept = p.Assign(e.Name("kept"), e.Name("own"))
    return Procedure(
        "show",
        (own, *body, kept),
        (Parameter("v", "number"), Parameter("kept", "number", "inout")),
        {"own": Variable("number", e.Number(1))},
    )


programs = st.builds(
    lambda main, weld, shown, far, comments: Program(
        "my_long_program_name",
        (
            Procedure("weld", (p.Label("again"), *weld)),
            Procedure("main", (p.Label("again"), *main)),
            show(shown),
            larger,
            Procedure("far", far, unit="far_away_unit"),
        ),
        comments=tuple(comments),
        tools={
            "gripper": Tool(Pose((0.0, 0.0, 120.0))),
            "Torch_2": Tool(Pose((10.123, 0.0, 250.5), (0.8, 0.0, 0.6, 0.0))),
        },
        frames={"table": Frame(target(7).pose)},
        signals={
            "glue": Signal("digital", "output", 5),
            "ok": Signal("digital", "input", 7),
            "mode": Signal("group", "output", 32, 8),
            "answer": Signal("group", "output", 48, 12),
            "level": Signal("analog", "output", 6010),
            "sensor": Signal("analog", "input", 6020),
            "dial": Signal("group", "input", 64, 12),
            "spare": Signal("digital", "input"),
        },
        targets={"home": target(3), "park_position": target(4), "P7": target(5)},
        joint_targets={"ready": JointTarget((0.0, 10.0, 80.0, 0.0, 90.0, 0.0))},
        variables={
            "count": Variable("integer", e.Number(3)),
            "limit": Variable("number", storage="constant", initial=e.Number(1.5)),
            "row": Variable("number", e.Aggregate((e.Number(4), e.Number(5))), (2,)),
            "unset": Variable("truth", storage="persistent"),
            "place": Variable("position", e.TargetValue(target(8))),
            "word": Variable("text", e.Text("a word")),
        },
    ),
    bodies,
    bodies.map(lambda body: tuple(s for s in body if s != p.Call("weld"))),
    st.lists(simple.filter(unaliased), max_size=3).map(tuple),
    st.lists(simple.filter(alone), max_size=5).map(tuple),
    st.lists(st.text(max_size=60), max_size=2),
)


def differences(left: object, right: object, where: str = "") -> list[str]:
    """What two programs differ in beyond the printed decimals."""
    if isinstance(left, np.ndarray) and isinstance(right, np.ndarray):
        if left.shape != right.shape:
            return [f"{where}: {left.shape} {right.shape}"]
        same = np.allclose(left, right, atol=0.00501, rtol=0, equal_nan=True)
        return [] if same else [f"{where}: {left} {right}"]
    if isinstance(left, Path) and isinstance(right, Path):
        found = [
            f"{where}.{column} {left.differing_rows(right, column)}"
            for column in ("speed", "blend", "tool", "frame")
            if len(left) == len(right) and left.differing_rows(right, column).size
        ]
        if left.name != right.name or len(left) != len(right):
            return [f"{where}: {left.name} {len(left)} {right.name} {len(right)}"]
        turned = rotations.angle_between(left.quaternions, right.quaternions)
        found += [f"{where} turned {turned.max()}"] if turned.max() > 0.0151 else []
        for column in ("kinds", "positions", "configurations", "external"):
            found += differences(getattr(left, column), getattr(right, column), f"{where}.{column}")
        return found
    if isinstance(left, Pose) and isinstance(right, Pose):
        turned = float(rotations.angle_between(left.quaternion, right.quaternion))
        moved = math.dist(left.position, right.position)
        return [] if turned < 0.0151 and moved < 0.01 else [f"{where}: {left} {right}"]
    if type(left) is not type(right) and not isinstance(left, int | float):
        return [f"{where}: {left!r} {right!r}"]
    if dataclasses.is_dataclass(left):
        return [
            difference
            for f in dataclasses.fields(left)
            if f.compare
            for difference in differences(
                getattr(left, f.name), getattr(right, f.name), f"{where}.{f.name}"
            )
        ]
    if isinstance(left, dict) and isinstance(right, dict):
        if list(left) != list(right):
            return [f"{where}: {list(left)} {list(right)}"]
        return [d for k in left for d in differences(left[k], right[k], f"{where}[{k}]")]
    if isinstance(left, tuple) and isinstance(right, tuple):
        if len(left) != len(right):
            return [f"{where}: {len(left)} {len(right)} entries: {left} {right}"]
        pairs = zip(left, right, strict=True)
        return [d for i, (a, b) in enumerate(pairs) for d in differences(a, b, f"{where}[{i}]")]
    if isinstance(left, float) and isinstance(right, float | int):
        same = left == right or abs(left - right) < 0.00501 or (left != left and right != right)
        return [] if same else [f"{where}: {left} {right}"]
    return [] if left == right else [f"{where}: {left!r} {right!r}"]
