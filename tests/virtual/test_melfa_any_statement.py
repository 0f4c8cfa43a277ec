"""Whatever a statement is given, a run of MELFA-BASIC ends in one of its ways."""

from __future__ import annotations

import random

import pytest

from assistant import languages, robots
from assistant.virtual import melfa
from assistant.virtual.melfa import Options
from tests.virtual.melfa_cell import POSITIONS, START

VALUES = (
    "1", "-1", "0", "2.5", "1E20", "1E300", "-1E-9", '"A"', '""', '"ABCDEFGH"', "P1", "P2", "P9",
    "J1", "(1,2,3,4,5,6)", "(0,0,0,,,)(7,0)", "P1*P2", "M_PI", "127", "-32769", "&HFFFF", "65536",
)  # fmt: skip
SIGNS = ("+", "-", "*", "/", "\\", "Mod", "^", "<<", ">>", "=", "<", "And", "Or", "Xor")
STATEMENTS = (
    "Cnt {},{}", "Spd {}", "Ovrd {}", "Accel {},{}", "Tool {}", "Base {}", "Dly {}", "Mov {}",
    "Mvs {},{}", "Mvr {},{},{}", "Mvr2 {},{},{}", "Mvr3 {},{},{}", "Mvc {},{},{}", "HOpen {}",
    "Error {}", "Clr {}", "JRC {}", "M_Out({})={}", "M_Outb({})={}", "M_Out16({})={}",
    "M_Timer({})={}", "P9={}", "P9=P1\nP9.X={}", "P9=P1\nP9.C={}", "P9=P1\nP9.FL1={}",
    "P9=P1\nP9.FL2={}", "J1={}", "J1.J8={}", "M1%={}", "M1(1)={}", "C1$={}", "Wait {}", "CallP {}",
    "Def Plt {},{},{},P3,,{},{},2", "P9=(Plt {},{})", "Def Plt 1,P1,P2,P3,,2,2,1\nMov (Plt 1,{})",
    "For M5={} To {} Step {}\nNext M5", "Select {}\nCase {}\nEnd Select", "On {} GoTo *L1",
    "M9=M_In({})", "M9=M_In32({})", "M_Tool={}", "M_Hnd({})={}", "M9=M_HndCq({})", "Mov J1,{}",
    "M_Out(3)=1 Dly {}", "Torq {},{}", "Cmp Pos,{}", "If {} Then M9=1", "ChrSrch C1$({}),{},M9",
)  # fmt: skip
FUNCTIONS = """
Abs Sgn Sqr Exp Ln Log Fix Int CInt Max Min Deg Rad Sin Cos Tan Atn Atn2 ASin ACos
Asc Len Val StrPos CkSum Cvi Cvs Cvd Chr$ Str$ Bin$ Hex$ Left$ Right$ Mid$ Mirror$ Mki$ Mks$ Mkd$
Dist Inv Align Fram PosMid PosCq Zone Zone2 Zone3 JtoP PtoJ RdFl1 RdFl2 SetFl1 SetFl2 SetPos SetJnt
Rnd Dot CalArc
"""
WAYS = (
    Options(),
    Options(quotients="floor", bits=32, digits=6, overflow="wrap", slides=True, unset="zero"),
    Options(conversions="all", signed=True, power="rounded", truth=-1, pulses="timed"),
    Options(degrees=True, slides=False, bits=16, quotients="zero", overflow="error", nested=False),
)


def drawn(rng: random.Random) -> str:
    """A statement, most of them with values that it does not take."""

    def value() -> str:
        one = rng.choice(VALUES)
        return one if rng.random() < 0.7 else f"{one} {rng.choice(SIGNS)} {rng.choice(VALUES)}"

    if rng.random() < 0.5:
        target = rng.choice(("P9", "C1$", "M9", "M9", "J1"))
        given = ",".join(value() for _ in range(rng.randint(1, 4)))
        return f"{target}={rng.choice(FUNCTIONS.split())}({given})"
    statement = rng.choice(STATEMENTS)
    return statement.format(*(value() for _ in range(statement.count("{}"))))


def end(statement: str, rng: random.Random) -> str:
    text = f"Dim M1(3),C1$(2)\nJ1=(0,0,90,0,90,0)\n{statement}\n*L1\nEnd{POSITIONS}"
    robot = rng.choice((None, robots.get("RV-4FR"), robots.get("RV-2AJ")))
    tree = languages.get("melfa-basic-6").parse(text)
    options = rng.choice(WAYS)
    return melfa.run(tree, robot=robot, start=START, options=options, most_steps=200).ended


@pytest.mark.parametrize("seed", range(4))
def test_every_run_ends_in_one_of_its_ways(seed: int) -> None:
    rng = random.Random(seed)
    ends = {end(drawn(rng), rng) for _ in range(50)}
    assert {"end", "error"} <= ends <= {"end", "error", "unknown", "stopped", "steps"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
def test_many_runs_end_in_one_of_their_ways(seed: int) -> None:
    rng = random.Random(100 + seed)
    assert {end(drawn(rng), rng) for _ in range(1000)} >= {"end", "error", "unknown"}
