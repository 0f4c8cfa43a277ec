"""Programs of the pseudo-language that use everything RAPID can say."""

from __future__ import annotations

import numpy as np

from assistant.program import expressions as e
from assistant.program import statements as p
from assistant.program.geometry import Configuration, Frame, JointTarget, Load, Pose, Target, Tool
from assistant.program.motion import FINE, FULL_BLEND, MAXIMUM_SPEED, Blend, Kind, Path, Speed
from assistant.program.program import Parameter, Procedure, Program, Signal, Variable

MOTION = p.Motion(Speed(150.0), Blend(100.0), "GRIPPER", "part")
ODD = p.Motion(Speed(147.0), Blend(3.0), "tool0", "base")
NAMED = p.Motion(e.Name("slow"), e.Name("round"), "GRIPPER", "base")
X = e.Name("x")


def number(value: float) -> e.Number:
    return e.Number(value)


def path(name: str, n: int, arcs: bool = False) -> Path:
    turns = np.linspace(0, 3, n)
    kinds = np.full(n, Kind.LINEAR, dtype=np.uint8)
    kinds[0] = Kind.JOINT
    if arcs:
        kinds[2:-1:2], kinds[3::2] = Kind.VIA, Kind.END
        kinds[-1] = Kind.END if kinds[-2] == Kind.VIA else Kind.LINEAR
    return Path.of(
        name,
        np.column_stack([100 + 10 * turns, -turns, np.full(n, 500.12345)]),
        np.column_stack([np.cos(turns / 2), np.zeros(n), np.sin(turns / 2), np.zeros(n)]),
        kinds=kinds,
        configurations=[0, 1, 0, 0, -1, 1],
        speeds=(Speed(150.0), Speed(12.5)),
        blends=(FINE, Blend(1.0)),
        tools=("GRIPPER",),
        frames=("part",),
        speed=(np.arange(n) // 2) % 2,
        blend=(np.arange(n) // 2) % 2,
    )


def full() -> Program:
    target = Target(
        Pose((1.5, -2.0, 3.25), (0.5, 0.5, -0.5, 0.5)),
        Configuration(False, True, False, (0, -1, 2)),
    )
    body: tuple[p.Statement, ...] = (
        p.Comment("a comment"),
        p.MoveJoints(e.Name("home"), MOTION),
        p.Move("joint", e.Name("above"), ODD),
        p.Move(
            "linear", e.Apply("offset", (e.Name("above"), number(0), number(0), number(50))), MOTION
        ),
        p.Move(
            "linear",
            e.Apply("relative", (e.Name("above"), *map(number, (1, 2, -3, 0, 90, 0)))),
            NAMED,
        ),
        p.MoveCircular(e.Name("above"), e.TargetValue(target), MOTION),
        p.Follow(path("seam", 40)),
        p.Follow(path("short", 3)),
        p.Follow(path("arc", 15, arcs=True)),
        p.Wait(number(0.5)),
        p.WaitSignal("ready", number(1), number(3)),
        p.WaitSignal("code", number(12)),
        p.WaitUntil(
            e.Binary(
                "and", e.Binary("=", e.Name("ready"), number(1)), e.Unary("not", e.Name("flag"))
            )
        ),
        p.SetSignal("glue", number(1)),
        p.SetSignal("glue", number(1), number(0.25)),
        p.SetSignal("pressure", number(2.5)),
        p.SetSignal("nozzle", number(5)),
        p.Gripper("open"),
        p.Gripper("close", 2),
        p.SetAcceleration(number(50), number(50)),
        p.SetOverride(number(80)),
        p.Assign(X, e.Binary("*", e.Binary("+", X, number(1)), number(-2))),
        p.Assign(e.Index(e.Name("list"), (number(2),)), e.Member(e.Name("above"), "x")),
        p.If(
            (
                p.Branch(e.Binary(">", X, number(3)), (p.Call("other", (X,)),)),
                p.Branch(e.Truth(True), (p.Stop(),)),
            ),
            (p.Goto("again"),),
        ),
        p.Label("again"),
        p.While(e.Binary("<", X, number(5)), (p.Assign(X, e.Binary("+", X, number(1))),)),
        p.For("i", number(1), number(9), (p.Message((e.Text("row "), e.Name("i"))),), number(2)),
        p.Switch(X, (p.Case((number(1), number(2)), (p.Wait(number(1)),)),), (p.Stop(end=True),)),
        p.Message((e.Text('say "hi" \\ \n'), e.Name("title"))),
        p.Opaque("rapid", "ConfL\\Off;"),
        p.Return(),
    )
    other = Procedure(
        "other",
        (p.Assign(e.Name("n"), e.Binary("-", e.Name("n"), e.Name("local_value"))),),
        (Parameter("n", "number", "inout"),),
        {"local_value": Variable("number", number(3))},
    )
    return Program(
        "cell",
        (Procedure("main", body), other),
        "main",
        "irb1200-7-0.7",
        ("first line", "robot: said someone", ": odd"),
        {"part": Frame(Pose((500.0, 0.0, 0.0)), Pose((1.0, 2.0, 3.0), (0.0, 1.0, 0.0, 0.0)))},
        {"GRIPPER": Tool(Pose((0.0, 0.0, 120.5)), Load(1.23456789, (0.0, 1e-7, 40.123456)))},
        {"slow": Speed(33.0, 100.0)},
        {"round": Blend(7.0)},
        {
            "ready": Signal("digital", "input", 3),
            "code": Signal("group", "input", 8, 4),
            "glue": Signal("digital", "output"),
            "pressure": Signal("analog", "output"),
            "nozzle": Signal("group", "output", None, 8),
        },
        {"above": target},
        {"home": JointTarget((0.0, 8.00527e-05, -2.14434321, 0.0, 30.0, 0.0))},
        {
            "x": Variable("number", number(0)),
            "flag": Variable("truth", e.Truth(False), (), "persistent"),
            "title": Variable("text", e.Text("abc"), (), "constant"),
            "list": Variable("number", None, (5,), "variable", True),
        },
    )


__all__ = ["FULL_BLEND", "MAXIMUM_SPEED", "full", "path"]
