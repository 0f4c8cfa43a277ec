"""Angles, tools by constants and programs that call programs, in random MELFA-BASIC.

Statements for `random_melfa`, which its programs have where they are drawn with all of it.
"""

from __future__ import annotations

from random import Random
from typing import Final

from tests.virtual.random_melfa_values import POSITIONS, WORKING

ANGLES: Final = "ABC"
STEPS: Final = (10, 30, 60, 100, -45, 150)
CALLED: Final = ("WELD", "LIFT2", "GRIP")
"""Programs that others call; the second one takes a number."""


def angle(rng: Random, names: tuple[str, ...] = WORKING) -> list[str]:
    """Lines that read, compare, set or calculate with the angles of a position."""
    name, part, step = rng.choice(names), rng.choice(ANGLES), rng.choice(STEPS)
    own = f"{name}.{part}"
    kind = rng.randrange(9)
    if kind == 0:
        return [f"{own}={own}+Rad({step})"]
    if kind == 1:
        return [f"{own}=Rad({rng.choice((0, 20, -35, 90, 175))})"]
    if kind == 2:
        return [f"M1=Deg({own})", "M_Outb(16)=Abs(CInt(M1)) Mod 200"]
    if kind == 3:
        sign = rng.choice(("<", ">", ">="))
        return [
            f"If {own}{sign}Rad({rng.choice((0, 100, 180, -170))}) Then",
            f"M_Out({rng.randrange(1, 8)})=1",
            *([f"{own}={own}-Rad(360)"] if rng.random() < 0.4 else []),
            "EndIf",
        ]
    if kind == 4:
        other = rng.choice(POSITIONS)
        return [f"{own}={other}.{rng.choice(ANGLES)}", f"Mvs {name}"]
    if kind == 5:
        return [f"{name}={rng.choice(POSITIONS)}+(0,0,{rng.choice((5, -8))},0,0,{step})"]
    if kind == 6:
        return [f"{name}={rng.choice(POSITIONS)}*(0,0,{rng.choice((5, -8))},0,0,{step})"]
    if kind == 7:
        one, two = rng.choice(POSITIONS), rng.choice(POSITIONS)
        return [f"{name}.{part}={one}.{part}+({two}.{part}-{one}.{part})/2", f"Mvs {name}"]
    return [f"{name}={rng.choice(POSITIONS)}", f"{own}={own}+Rad({step})", f"Mvs {name}"]


def turning(rng: Random, number: int) -> list[str]:
    """A loop that ends once an angle has grown enough."""
    name, end = rng.choice(WORKING), rng.choice((150, 200, 300))
    return [
        f"{name}=P1",
        f"{name}.C=Rad({rng.choice((0, -30, 45))})",
        f"MT{number}=0",
        f"While {name}.C<Rad({end}) And MT{number}<12",
        f"Mvs {name}",
        f"{name}.C={name}.C+Rad({rng.choice((40, 70, 110))})",
        f"MT{number}=MT{number}+1",
        "WEnd",
    ]


def tool(rng: Random) -> list[str]:
    """A tool that numbers give, at once or by a variable."""
    height, turn = rng.choice((45, 87.5, 120)), rng.choice((0, 0, 30))
    if rng.random() < 0.5:
        return [f"Tool (0,0,{height},0,0,{turn},0,0)(0,0)"]
    return [f"PTW=(5,0,{height},0,0,{turn},0,0)(0,0)", "Tool PTW"]


def called(rng: Random, name: str, others: tuple[str, ...]) -> tuple[list[str], str]:
    """The lines and the positions of a program that is called; it calls others."""
    lines = ["Tool PT1", "Base P_NBase", f"Spd {rng.choice((50, 120))}", "Cnt 0"]
    height = "-20"
    if name == CALLED[1]:
        lines.insert(0, "FPrm MH")
        height = "-MH"
    lines.append(f"Mvs P1,{height}")
    if rng.random() < 0.5:
        lines += [f"If M_In({rng.randrange(1, 5)})=1 Then", f"M_Out({rng.randrange(1, 8)})=1"]
        lines += ["Else", "Mvs P2", "EndIf"]
    lines += [call(rng, other) for other in others if rng.random() < 0.6]
    lines += [f"M_Out({rng.randrange(1, 8)})={rng.randrange(2)}", "End"]
    places = (
        f"P1=(+{rng.choice((340, 372.5))},+20.00,+410.00,+180.00,+0.00,+160.00)(7,0)\n"
        "P2=(+390.00,-30.00,+433.00,+180.00,+0.00,+180.00)(7,0)\n"
        "PT1=(+0.00,+0.00,+90.00,+0.00,+0.00,+0.00)(0,0)\n"
    )
    return lines, places


def call(rng: Random, name: str) -> str:
    """`CallP`, in the case of its file or another one."""
    spelled = rng.choice((name, name, name.lower()))
    given = f",{rng.choice((15, 'M1-M1+25'))}" if name == CALLED[1] else ""
    return f'CallP "{spelled}"{given}'
