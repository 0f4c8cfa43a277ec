"""Expressions of random programs of MELFA-BASIC: numbers, subscripts, conditions, positions."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random
from typing import Final

NUMBERS: Final = ("M1", "M2", "M3")
WHOLE: Final = ("MK1", "MK2")
POSITIONS: Final = ("P1", "P2", "P3", "P4", "P5")
"""Taught; never set by the program."""
WORKING: Final = ("P7", "P8", "P9")
"""Set at the head, and changed by the program."""

TOOLS: Final = ("PT1", "PT2", "PT3")
BASES: Final = ("PB1", "PB2", "PB3")
SHIFTS: Final = ("PS1", "PS2")
DATA: Final = """
P1=(+400.00,+0.00,+450.00,+180.00,+0.00,+180.00)(7,0)
P2=(+380.00,+60.00,+430.00,+180.00,+0.00,+180.00)(7,0)
P3=(+400.00,+120.00,+450.00,+180.00,+0.00,+180.00)(7,0)
P4=(+360.00,-80.00,+440.00,+180.00,+0.00,+150.00)(7,0)
P5=(+390.00,-40.00,+420.00,+175.00,+5.00,+180.00)(7,0)
P6=(+420.00,+60.00,+450.00,+180.00,+0.00,+180.00)(7,0)
PQ1=(+350.00,-60.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PQ2=(+410.00,-60.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PQ3=(+350.00,+20.00,+400.00,+180.00,+0.00,+180.00)(7,0)
PT1=(+0.00,+0.00,+100.00,+0.00,+0.00,+0.00)(0,0)
PT2=(+10.00,-5.00,+60.00,+0.00,+0.00,+30.00)(0,0)
PB1=(+20.00,+10.00,-30.00,+0.00,+0.00,+0.00)(0,0)
PB2=(-15.00,+25.00,+10.00,+0.00,+0.00,+10.00)(0,0)
PT3=(+12.35,-8.21,+143.62,+9.11,-18.73,+13.37)(0,0)
PB3=(-21.34,+17.13,+63.72,+3.31,-4.77,+11.13)(0,0)
PS1=(+5.00,-8.00,+12.00,+0.00,+0.00,+20.00)(0,0)
PS2=(+0.00,+0.00,-25.00,+0.00,+10.00,+0.00)(0,0)
"""
JOINTS: Final = """JA=(+10.00,+5.00,+85.00,+10.00,+80.00,-15.00)
JB=(-20.00,+15.00,+80.00,+0.00,+75.00,+30.00)
"""
RARE: Final = ("bits", "floor", "on way", "positions", "settings", "truths", "waits")
"""Operators on bits, Int, outputs on the way of moves, sums and halves of positions, settings in
branches, numbers as truths, waits for inputs."""


@dataclass
class Values:
    """numbers: variables that may be read and set where the line stands.

    formulas: names of functions of one number. rare: of RARE, what the program uses that has no
    plain word in other languages.
    """

    rng: Random
    numbers: tuple[str, ...] = NUMBERS
    formulas: tuple[str, ...] = ()
    rare: set[str] = field(default_factory=set)

    def number(self, depth: int) -> str:
        """Any number."""
        rng = self.rng
        kind = rng.randrange(9) if depth else rng.randrange(3)
        if kind == 0:
            return str(rng.choice((1, 2, 5, 0.3, 7.6, -4)))
        if kind == 1:
            return rng.choice(self.numbers)
        if kind == 2:
            return rng.choice((*WHOLE, f"MA({rng.randrange(1, 5)})"))
        if kind == 3:
            return self.natural()
        if kind == 4:
            return (
                rng.choice(("Abs", "CInt", "Fix", "Int" if "floor" in self.rare else "Abs"))
                + f"({self.number(depth - 1)})"
            )
        if kind == 5:
            return (
                f"{rng.choice(('Max', 'Min'))}({self.number(depth - 1)},{self.number(depth - 1)})"
            )
        if kind == 6 and self.formulas:
            return f"{rng.choice(self.formulas)}({self.number(depth - 1)})"
        if kind == 6:
            return f"({self.number(depth - 1)})/{rng.choice((2, 3, 4.4))}"
        return f"({self.number(depth - 1)}{rng.choice('+-')}{self.number(depth - 1)})"

    def natural(self) -> str:
        """A number that is not negative; the operand of `Mod` is rounded where it is not whole."""
        rng = self.rng
        kind = rng.randrange(6)
        if kind == 0:
            return f"(Abs({self.number(0)})+1)\\{rng.choice((2, 3, 2.7))}"
        if kind == 1 and "bits" in self.rare:
            sign = rng.choice(("And", "Or", "Xor"))
            return f"(Abs({rng.choice(WHOLE)}) {sign} {rng.choice(('7', '&HF', '&B101'))})"
        if kind == 2:
            return f"M_Inb({rng.choice((8, 24))})"
        if kind == 3:
            return f"Abs({self.number(0)}+0.2)"
        return f"Abs({self.number(0)})"

    def subscript(self, most: int) -> str:
        """From 1 to the most, by a number that may not be whole."""
        rng = self.rng
        kind = rng.randrange(4)
        if kind == 0:
            return str(rng.randrange(1, most + 1))
        if kind == 1:
            return f"({self.natural()} Mod {most})+1"
        if kind == 2:
            return str(rng.choice((1.2, 1.8)))
        return f"Min(Abs({self.number(0)})+1,{most})"

    def small(self) -> str:
        return f"({self.natural()} Mod {self.rng.choice((10, 20))})"

    def place(self) -> str:
        """A position that the arm can go to."""
        rng = self.rng
        kind = rng.random()
        if kind < 0.4:
            return rng.choice(POSITIONS)
        if kind < 0.6:
            return rng.choice(WORKING)
        if kind < 0.75:
            return f"PA({self.subscript(3)})"
        if kind < 0.9:
            return f"{rng.choice(POSITIONS)}*(0,0,{rng.choice((-10, 15))},0,0,0)"
        return f"{rng.choice(POSITIONS)}+({rng.choice((-10, 15))},0,5,0,0,0)"

    def condition(self) -> str:
        rng = self.rng
        kind = rng.randrange(7)
        if kind == 0:
            return f"M_In({rng.randrange(1, 5)})=1"
        if kind == 1:
            return f"M_Inb(8)>{rng.choice((0, 3, 9))}"
        if kind == 2 and "bits" in self.rare:
            sign, mask = rng.choice(("And", "Or", "Xor")), rng.choice((1, 2, 3))
            what = rng.choice((*WHOLE, "M_Inb(8)", "M_Inb(24)", f"Abs({rng.choice(self.numbers)})"))
            bits = f"({what} {sign} {mask})"
            return rng.choice((f"{bits}={rng.choice((0, 1, 2))}", f"{what} And {mask}"))
        if kind == 3:
            sign = rng.choice(("And", "Or"))
            return (
                f"M_In({rng.randrange(1, 5)})=0 {sign} {rng.choice(self.numbers)}<{self.number(0)}"
            )
        if kind == 4 and "truths" in self.rare:
            return rng.choice(
                ("M_In(2)", f"Not ({rng.choice(WHOLE)}=1)", "M_In(1) And M_In(2)", "MK1")
            )
        return f"{self.number(1)}{rng.choice(('>', '<', '>=', '<>'))}{self.number(0)}"

    def setting(self) -> str:
        rng = self.rng
        if rng.random() < 0.6:
            return f"Tool {rng.choice((*TOOLS, 'P_NTool'))}"
        return f"Base {rng.choice((*BASES, 'P_NBase'))}"

    def short(self) -> str:
        rng = self.rng
        return rng.choice(
            (
                f"{rng.choice(self.numbers)}={self.number(1)}",
                f"M_Out({rng.randrange(1, 8)})=1",
                f"MK1={rng.randrange(9)}",
                f"Dly {rng.choice((0.1, 0.2))}",
            )
        )
