"""Constructs of real cells in random MELFA-BASIC: pallets, texts, states, choices.

Lines for `random_melfa`, which its programs have where they are drawn with all of it. Each piece
has its number in its names.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Final

from tests.virtual.random_melfa_values import POSITIONS, WORKING

CORNERS: Final = (*POSITIONS, "PQ1", "PQ2", "PQ3", *WORKING)


def pallet(rng: Random, number: int) -> list[str]:
    """A pallet with computed corners or counts, and moves to its places."""
    key = 2 + number % 6
    corners = rng.sample(CORNERS, 4)
    columns, rows = rng.choice((2, 3, 4)), rng.choice((1, 2, 3))
    fourth = corners[3] if rng.random() < 0.4 else ""
    count = rng.choice((str(columns), f"MC{number}", "M_In(3)+2"))
    last = 2 * rows if count == "M_In(3)+2" else columns * rows
    direction = rng.choice((1, 2, 11, 12, 3))
    if direction == 3:
        last = 2 if count == "M_In(3)+2" else columns
    lines = [f"MC{number}={columns}"]
    lines.append(
        f"Def Plt {key},{corners[0]},{corners[1]},{corners[2]},{fourth},{count},{rows},{direction}"
    )
    name = rng.choice(WORKING)
    lines += [f"For MN{number}=1 To {last}", f"{name}=(Plt {key},MN{number})"]
    if rng.random() < 0.4:
        lines.append(f"{name}.Z={name}.Z+{rng.choice((2, 5))}")
    lines.append(rng.choice((f"Mvs {name}", f"Mvs {name},-10", f"Mvs (Plt {key},MN{number})")))
    return [*lines, f"Next MN{number}"]


def texts(rng: Random, number: int) -> list[str]:
    """A text that is put together and taken apart, and a choice by it."""
    word = rng.choice(("PICK", "DROP", "HOME"))
    value = rng.choice((12, 7, 345))
    return [
        f'C1$="{word}"+Str$({value})',
        f"C2$=Left$(C1$,{rng.choice((1, 4))})",
        f"MV{number}=Val(Mid$(C1$,5,Len(C1$)-4))",
        f'If C2$="{rng.choice(("PICK", "DROP", "P"))}" Then M_Out(5)=1 Else M_Out(6)=1',
        "Select C2$",
        'Case "PICK"',
        f"M_Outb(16)=MV{number} Mod 200",
        "Break",
        'Case "DROP"',
        "M_Out(4)=1",
        "Break",
        "Default",
        "M_Out(3)=1",
        "End Select",
        f"Dly MV{number}/100",
    ]


def choice(rng: Random, number: int) -> list[str]:
    """`On … GoTo` over labels, and a number that there is none for."""
    subject = rng.choice(("M_In(1)+M_In(2)", "Abs(CInt(M1)) Mod 4", "MK1 Mod 3"))
    return [
        f"MO{number}={subject}",
        f"On MO{number} GoTo *O{number}A,*O{number}B",
        "M_Out(1)=1",
        f"GoTo *O{number}Z",
        f"*O{number}A",
        f"Mvs {rng.choice(POSITIONS)}",
        f"GoTo *O{number}Z",
        f"*O{number}B",
        "M_Out(2)=1",
        f"*O{number}Z",
    ]


def states(rng: Random, number: int) -> list[str]:
    """A machine of states in a loop that a state ends."""
    key = f"MS{number}X"
    return [
        f"{key}=1",
        f"While {key}<9",
        f"Select {key}",
        "Case 1",
        f"Mvs {rng.choice(POSITIONS)}",
        f"{key}=2",
        "Break",
        "Case 2",
        f"If {rng.choice(('M_In(1)=1', 'M1>2', 'MK1<5'))} Then",
        f"{key}=3",
        "Else",
        f"{key}=9",
        "EndIf",
        "Break",
        "Case 3",
        f"M_Out({rng.randrange(1, 8)})=1",
        f"{key}=9",
        "End Select",
        "WEnd",
    ]


def timer(rng: Random, number: int) -> list[str]:
    """A wait for a time by a timer."""
    return [
        "M_Timer(1)=0",
        f"*T{number}",
        "Dly 0.2",
        f"If M_Timer(1)<{rng.choice((300, 500))} Then GoTo *T{number}",
    ]


def built(rng: Random, number: int) -> list[str]:
    """Positions of numbers, sums, distances and areas."""
    name, other = rng.sample(WORKING, 2)
    one, two = rng.sample(POSITIONS, 2)
    return rng.choice(
        (
            [
                f"{name}=SetPos({one}.X+{rng.choice((5, 'MK1'))},{one}.Y,{two}.Z,"
                f"Rad(180),0,{two}.C+Rad({rng.choice((10, 200))}))",
                f"Mvs {name}",
            ],
            [f"If Dist(P_Curr,{one})<{rng.choice((60, 100))} Then M_Out(7)=1 Else M_Out(7)=0"],
            [f"MZ{number}=Dist({one},{two})", f"Dly MZ{number}/100"],
            [f"If Zone({two},{one},{name}) Then M_Out(6)=1 Else M_Out(6)=0"],
            [f"{name}=P_Curr", f"{name}.Z={one}.Z", f"Mvs {name}", f"Mvs {one}"],
            [f"{name}={one}", f"{other}={name}", f"{other}.X={other}.X-MK1", f"Mvs {other}"],
            [f"{name}={one}*PS1*PS2", f"Mvs {name}", "Mvs P_Curr*(0,0,-5,0,0,0)"],
            [f"{name}=Inv(PB2)*{one}", f"Dly Abs({name}.X)/200"],
        )
    )


def counted(rng: Random, number: int) -> list[str]:
    """Outputs by what a loop counts, and an array that it fills."""
    name = f"MI{number}"
    return [
        f"For {name}=1 To {rng.choice((2, 3))}",
        f"M_Out({name}+{rng.choice((0, 3))})={rng.choice(('1', '0', f'{name} Mod 2'))}",
        f"MA({name})=M_In({name})*{name}",
        rng.choice((f"Mvs P1,-{name}*5", f"Dly {name}/10", f"PA({name})=P{number % 5 + 1}")),
        f"Next {name}",
    ]


def hands(rng: Random, number: int) -> list[str]:
    """A part that is picked and placed."""
    one = rng.choice(POSITIONS)
    return [f"Mvs {one},-30", f"Mvs {one}", "Dly 0.1", "HClose 1", "Dly 0.1", f"Mvs {one},-30",
            *(["HOpen 1"] if rng.random() < 0.6 else [])]  # fmt: skip


def asked(rng: Random, number: int) -> list[str]:
    """Names of inputs and outputs, and speeds that are asked for."""
    return rng.choice(
        (
            ["Spd 90", f"Dly M_Spd/{rng.choice((100, 300))}"],
            [f"Ovrd {rng.choice((40, 80))}", "Dly M_Ovrd/100", "Ovrd 100"],
            [f"If M_In({rng.randrange(1, 5)})=0 Then *Q{number}", "M_Out(2)=1", f"*Q{number}"],
            [f"M_Out(9)={rng.choice(('M_In(2)', '1', 'M_Out(9)'))}", "Dly 0.1"],
        )
    )


CELLS: Final[tuple[Callable[[Random, int], list[str]], ...]] = (
    pallet, pallet, texts, choice, states, timer, built, built, counted, hands, asked,
)  # fmt: skip


def odd_subroutines(rng: Random, number: int) -> tuple[list[str], list[str]]:
    """Calls, and subroutines in pieces, that share lines, leave by `End` or jump out."""
    a, b, out = f"X{number}A", f"X{number}B", f"X{number}O"
    key = f"MX{number}"
    condition = rng.choice(("M_In(1)=1", "M_In(2)=1", f"{key}>2", "MK1>4"))
    call = [f"{key}=0", f"*{out}", f"{key}={key}+1", f"If {key}<4 Then GoSub *{a}"]
    leave = rng.choice(
        (
            f"If {condition} Then GoTo *{b}",
            f"If {condition} Then GoTo *X{number}P",
            f"If {condition} Then Return",
            f"If {condition} And {key}<3 Then GoTo *{out}",
            f"If {condition} Then End",
        )
    )
    subroutines = [
        f"*{a}",
        f"Mvs {rng.choice(POSITIONS)}",
        leave,
        f"M_Out({rng.randrange(1, 8)})=1",
        *([f"GoSub *{b}"] if rng.random() < 0.6 else []),
        *(["Return"] if rng.random() < 0.7 else []),  # else it runs on into the next one
        f"*{b}",
        f"{key}={key}+1",
        f"Dly {key}/10",
        "Return",
        f"*X{number}P",
        f"M_Out({rng.randrange(1, 8)})=0",
        f"GoTo *{b}",
    ]
    return call, subroutines
