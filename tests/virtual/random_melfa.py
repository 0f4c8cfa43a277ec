"""Random programs of MELFA-BASIC IV, V and VI that a controller would run to their end.

The same seed gives the same program everywhere. Every variable has a value before it is read,
every loop ends, and nothing is used that the manuals leave open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Final

from tests.virtual import random_melfa_cells as cells
from tests.virtual import random_melfa_parts as parts
from tests.virtual.random_melfa_parts import CALLED
from tests.virtual.random_melfa_values import (
    BASES,
    DATA,
    JOINTS,
    NUMBERS,
    POSITIONS,
    RARE,
    SHIFTS,
    TOOLS,
    WHOLE,
    WORKING,
    Values,
)

SUBROUTINES: Final = ("SA", "SB", "SC")
FUNCTIONS: Final = ("FA", "FB")
DEEPEST: Final = 3


def program(level: int, seed: int, arms: bool = False) -> str:
    """The text of a program of MELFA-BASIC IV, V or VI (level 4, 5 or 6).

    arms: with moves to joints and by joints, whose speed only an arm tells.
    """
    rng = Random(f"{level} {seed} {arms}")
    return _Writer(rng, level=level, arms=arms).program()


def drawn(level: int, seed: int) -> dict[str, str]:
    """The texts of a program by their names, the first of which calls the others.

    It has what `random_melfa_parts` draws, and every subroutine may stay without a call. No input
    is read twice in one comparison, and none by a wait: inputs may change at each read.
    """
    rng = Random(f"more {level} {seed}")
    writer = _Writer(rng, level=level, more=True)
    writer.programs = CALLED[: rng.choice((0, 0, 1, 2, 3))]
    texts = {"MAIN": writer.program()}
    for at, name in enumerate(writer.programs):
        lines, places = parts.called(rng, name, writer.programs[at + 1 :])
        texts[name] = numbered(lines, level) + "\n" + places
    return texts


@dataclass
class _Writer(Values):
    """callable: subroutines that the lines at hand may call. sub: whether they are one. more: with
    `random_melfa_parts`; it may call programs then.
    """

    level: int = 5
    arms: bool = False
    lines: list[str] = field(default_factory=list)
    callable: tuple[str, ...] = ()
    functions: tuple[str, ...] = ()
    sub: bool = False
    count: int = 0
    more: bool = False
    programs: tuple[str, ...] = ()

    # ------------------------------------------------------------------------- the whole

    def program(self) -> str:
        rng = self.rng
        self.rare = {one for one in RARE if rng.random() < 0.2}
        if self.more:
            self.rare -= {"waits", "truths"}
        functions = self.level == 6 and rng.random() < 0.5
        subroutines = SUBROUTINES[: rng.randrange(0, 4)]
        if functions:
            self._with_functions()
        else:
            self.head()
            self.callable = subroutines
            head, self.lines = self.lines, []
            self.body(rng.randrange(5, 12))
            for name in subroutines:
                if f"GoSub *{name}" not in self.lines and not self.more:
                    self.add(f"GoSub *{name}")
            behind: list[str] = []
            if self.more and rng.random() < 0.4:
                calls, behind = cells.odd_subroutines(rng, self.fresh())
                for line in calls:
                    self.add(line)
            self.add("End")
            main, self.lines = self.lines, []
            for at, name in enumerate(subroutines):
                self.sub, self.callable = True, subroutines[at + 1 :]
                self.add(f"*{name}")
                self.body(rng.randrange(2, 6))
                self.add("Return")
            for line in behind:
                self.add(line)
            if subroutines and rng.random() < 0.3:  # the main part behind them
                self.lines = [*head, "GoTo *MAIN", *self.lines, "*MAIN", *main]
            else:
                self.lines = [*head, *main, *self.lines]
        return self._numbered() + DATA + (JOINTS if self.arms else "")

    def _with_functions(self) -> None:
        """Two functions, and what the program does in `Main`."""
        rng = self.rng
        self.add("Def Float " + ",".join(NUMBERS))
        self.add("Def Inte " + ",".join(WHOLE))
        self.add("Def Char C1$,C2$")
        self.add("Def Pos " + ",".join(WORKING))
        self.add("Dim MA(4),PA(3)")
        for at, name in enumerate(FUNCTIONS):
            self.numbers, self.functions = (*NUMBERS, "MX", "MY"), FUNCTIONS[:at]
            by = rng.choice(("ByRef", "ByVal"))
            if name == "FA":
                self.add(f"Function M {name}({by} MX,ByVal MY)")
            else:
                self.add(f"Function V {name}({by} MX,ByRef MY)")
            self.body(rng.randrange(1, 4))
            self.add(f"MX=MX+{rng.randrange(1, 5)}")
            if name == "FA":
                if rng.random() < 0.5:
                    self.add(f"FA={self.number(1)}")
                    self.add(f"If {self.condition()} Then Exit Function")
                self.add(f"FA={self.number(1)}")
            else:
                self.add(f"MY=MY-{rng.randrange(1, 5)}")
            self.add("FEnd")
        self.numbers, self.functions = NUMBERS, FUNCTIONS
        self.add("Function Main")
        self.first_values()
        self.body(rng.randrange(5, 12))
        for name, call in (("FA", "M1=FA(M2,1)"), ("FB", "FB(M1,M2)")):
            if sum(f"{name}(" in line for line in self.lines) == 1:  # its head
                self.add(call)
        self.add("FEnd")

    def head(self) -> None:
        self.add("Def Inte " + ",".join(WHOLE))
        self.add("Dim MA(4),PA(3)")
        self.first_values()

    def first_values(self) -> None:
        rng = self.rng
        for name in NUMBERS:
            self.add(f"{name}={rng.choice((0, 1, 2, 3.3, 7.6, -2, 12))}")
        for name in WHOLE:
            self.add(f"{name}={rng.choice((0, 1, 2, 5, 12))}")
        self.add('C1$="ab"')
        self.add('C2$="c"')
        for name in WORKING:
            self.add(f"{name}={rng.choice(POSITIONS)}")
        if rng.random() < 0.5:
            for at in range(1, 5):
                self.add(f"MA({at})={at * rng.choice((1, 3, 0.7))}")
        else:
            self.add("For MZ=1 To 4")
            self.add(f"MA(MZ)=MZ*{rng.choice((1, 2.3, 5))}")
            self.add("Next MZ")
        for at in range(1, 4):
            self.add(f"PA({at})={rng.choice(POSITIONS)}")
        if rng.random() < 0.2 and not self.functions:
            self.add("Def FNMSUM(MX)=MX*2+M1")
            self.formulas = ("FNMSUM",)
        if rng.random() < 0.3:
            self.add(f"Def Plt 1,PQ1,PQ2,PQ3,,3,2,{rng.choice((1, 2))}")
            self.count += 1000
        self.add(f"Spd {rng.choice((50, 100, 250))}")
        self.add(f"Mvs {rng.choice(POSITIONS)}")

    def add(self, text: str) -> None:
        self.lines.append(text)

    def _numbered(self) -> str:
        return numbered(self.lines, self.level)

    def fresh(self) -> int:
        """A number that no other loop or label has."""
        self.count += 1
        return self.count % 1000

    # ------------------------------------------------------------------------ statements

    def body(self, most: int, depth: int = 0) -> None:
        for _ in range(most):
            kinds = [*PLAIN] * 3 if depth >= DEEPEST else [*PLAIN, *PLAIN, *BLOCKS]
            if self.more:
                kinds += MORE
            self.rng.choice(kinds)(self, depth)

    def move(self, depth: int) -> None:
        rng = self.rng
        word = "Mov" if self.arms and rng.random() < 0.4 else "Mvs"
        if self.arms and rng.random() < 0.1:
            self.add(f"Mov {rng.choice(('JA', 'JB'))}{self.on_way()}")
            return
        target = self.place()
        if rng.random() < 0.2:
            target += f",{rng.choice((-20, -35, 10))}"
        self.add(f"{word} {target}{self.on_way()}")

    def on_way(self) -> str:
        """What a motion may set on its way; a share of it is only told where its length is."""
        rng = self.rng
        if "on way" not in self.rare or rng.random() < 0.5:
            return ""
        output = rng.choice((f"M_Out({rng.randrange(1, 8)})=1", "M_Out(3)=0", "M_Outb(16)=9"))
        left, done = rng.choice((0, 5, 20, 37.5)), rng.choice((0, 30, 80, 100))
        place = rng.choice(
            (
                *("", "", f"M_RDst<={left}", f"M_RDst<{left}", f"{left}>=M_RDst"),
                *(f"M_RDst=<{left}", "M_RDst<M1", "M1<M2", "M_In(1)=1"),
                f"M_Ratio>={done if rng.random() < 0.2 else 100 * rng.randrange(2)}",
            )
            if rng.random() < 0.1
            else ("", f"M_RDst<={left}", f"{left}>=M_RDst", "M_Ratio>=0", "M_Ratio>=100")
        )
        return f" WthIf {place},{output}" if place else f" Wth {output}"

    def arc(self, depth: int) -> None:
        rng = self.rng
        if rng.random() < 0.3:
            self.add("Mvs P1")
            arcs = ("Mvr P1,P2,P3", "Mvr P1,P2,P3", "Mvr2 P1,P3,P2", "Mvr3 P1,P3,P6")
            self.add(rng.choice(arcs) + self.on_way())
            if "on way" in self.rare:
                share = f"M_Ratio>={rng.choice((30, 75, 80.5))}"
                self.add(f"Mvs P1 WthIf {share},M_Out({rng.randrange(1, 8)})={rng.randrange(2)}")

    def tool(self, depth: int) -> None:
        if self.settles(depth):
            self.add(f"Tool {self.rng.choice((*TOOLS, 'P_NTool'))}")

    def base(self, depth: int) -> None:
        if self.settles(depth):
            self.add(f"Base {self.rng.choice((*BASES, 'P_NBase'))}")

    def speed(self, depth: int) -> None:
        rng = self.rng
        if not self.settles(depth):
            return
        choices = [
            f"Spd {rng.choice((20, 80, 300))}",
            f"Cnt {rng.choice(('0', '1,10,10', '1,5,5'))}",
        ]
        if self.arms:
            choices.append(f"JOvrd {rng.choice((20, 50, 100))}")
        self.add(rng.choice(choices))

    def override(self, depth: int) -> None:
        if self.settles(depth):
            self.add(self.rng.choice(("Ovrd 50", "Ovrd 100", "Accel 50,50", "Accel 100,100")))

    def settles(self, depth: int) -> bool:
        """Whether a setting is changed: in branches and subroutines less often."""
        return self.rng.random() < (
            0.5 if depth == 0 and not self.sub else 0.15 if "settings" in self.rare else 0.04
        )

    def here(self, depth: int) -> None:
        """Where the arm stands, read and gone to between changes of tool and base."""
        rng, name = self.rng, self.rng.choice(WORKING)
        free = depth == 0 and not self.sub
        if free and rng.random() < 0.5:
            self.add(self.setting())
        self.add(f"{name}=P_Curr")
        if free and rng.random() < 0.5:
            self.add(self.setting())
        if rng.random() < 0.7:
            self.add(f"{name}.Z={name}.Z+{rng.choice((5, 10))}")
        self.add(rng.choice((f"Mvs {name}", f"Mvs {name}", f"Mvs {name},-15", "Mvs ,-10")))

    def assign(self, depth: int) -> None:
        rng = self.rng
        kind = rng.randrange(4)
        if kind == 0:
            self.add(f"{rng.choice(self.numbers)}={self.number(2)}")
        elif kind == 1:
            self.add(f"{rng.choice(WHOLE)}={self.natural()} Mod 100")
        elif kind == 2:
            self.add(f"MA({self.subscript(4)})={self.number(1)}")
        else:
            self.add(f"PA({self.subscript(3)})={self.place()}")

    def set_position(self, depth: int) -> None:
        rng = self.rng
        name, kind = rng.choice(WORKING), rng.random()
        if kind < 0.35:
            component = rng.choice("XYZ")
            self.add(f"{name}={rng.choice(POSITIONS)}")
            self.add(f"{name}.{component}={name}.{component}+{self.small()}")
        elif kind < 0.6:
            self.add(f"{name}={rng.choice(POSITIONS)}*{rng.choice(SHIFTS)}")
        elif kind < 0.8:
            self.add(f"{name}={rng.choice(POSITIONS)}+(0,{rng.choice((5, -12))},8,0,0,0)")
        elif "positions" in self.rare:
            self.add(
                rng.choice(
                    (
                        f"{name}=Inv(PB1)*{rng.choice(POSITIONS)}",
                        f"{name}=(P1+P2)/2",
                        f"{name}={rng.choice(POSITIONS)}+PS1",
                        f"{name}=P1\n{name}.C={name}.C+Rad(10)",
                    )
                ).replace("\n", "\0")
            )
            if "\0" in self.lines[-1]:
                self.lines[-1:] = self.lines[-1].split("\0")

    def output(self, depth: int) -> None:
        rng = self.rng
        kind = rng.random()
        if kind < 0.4:
            self.add(f"M_Out({rng.randrange(1, 8)})={rng.randrange(2)}")
        elif kind < 0.7:
            self.add(f"M_Outb(16)={self.natural()} Mod 256")
        elif kind < 0.8:
            self.add(f"M_Out({rng.randrange(8, 12)})=M_In({rng.randrange(1, 5)})")
        elif kind < 0.9:
            self.add(rng.choice(("HOpen 1", "HClose 1", f"M_Out(20)=1 Dly {rng.choice((0.2, 1))}")))
        else:
            self.add(f"Dly {rng.choice((0.1, 0.5))}")

    def wait(self, depth: int) -> None:
        """For an input, for ever or for a time."""
        if "waits" not in self.rare or self.rng.random() < 0.5:
            return
        rng, signal = self.rng, self.rng.randrange(1, 5)
        if rng.random() < 0.5:
            self.add(f"Wait M_In({signal})={rng.randrange(2)}")
            return
        number = self.fresh()
        self.add("M_Timer(1)=0")
        self.add(f"*W{number}")
        self.add(f"If M_In({signal})=1 Then *X{number}")
        self.add(f"If M_Timer(1)<{rng.choice((50, 100))} Then *W{number}")
        self.add(f"M_Out({rng.randrange(8, 12)})=1")
        self.add(f"*X{number}")

    def text(self, depth: int) -> None:
        rng = self.rng
        if rng.random() < 0.3:
            self.add(rng.choice(('C1$=C2$+"x"', 'C2$="y"', "C1$=C1$+C2$")))
            self.add(
                f'If C1$="{rng.choice(("cx", "yx", "abc"))}" Then M_Out(12)=1 Else M_Out(12)=0'
            )

    def call(self, depth: int) -> None:
        rng = self.rng
        if self.callable and depth < DEEPEST:
            if rng.random() < 0.15:
                listed = ",".join(f"*{name}" for name in self.callable)
                self.add(f"On {self.natural()} Mod 3 GoSub {listed}")
            else:
                self.add(f"GoSub *{rng.choice(self.callable)}")
        elif self.functions:
            name = rng.choice(self.functions)
            first, second = (
                rng.choice(self.numbers),
                rng.choice(("M2", f"MA({rng.randrange(1, 5)})")),
            )
            if first == second:
                second = "M3" if first != "M3" else "M1"
            if name == "FA":
                self.add(f"M1=FA({rng.choice(('M2', 'M3'))},{self.number(1)})")
            else:
                self.add(f"FB({first},{second})")

    def pallet(self, depth: int) -> None:
        if self.count >= 1000:
            self.add(f"Mvs (Plt 1,{self.subscript(6)})")

    def angle(self, depth: int) -> None:
        lines = parts.angle(self.rng)
        if self.level > 4 or not any(line.endswith("Then") for line in lines):
            self.lines += lines

    def turning(self, depth: int) -> None:
        if not depth and not self.sub and self.rng.random() < 0.3:
            self.lines += parts.turning(self.rng, self.fresh())

    def constant_tool(self, depth: int) -> None:
        if not depth and not self.sub and self.rng.random() < 0.4:
            self.lines += parts.tool(self.rng)

    def call_program(self, depth: int) -> None:
        if self.programs and not self.sub:
            self.add(parts.call(self.rng, self.rng.choice(self.programs)))
            self.lines += ["Tool PT1", "Base P_NBase", "Spd 100", "Cnt 0"]

    # ---------------------------------------------------------------------------- blocks

    def cell(self, depth: int) -> None:
        """Constructs of real programs; IV has no `Select` inside another one."""
        piece = self.rng.choice(cells.CELLS)
        lines = piece(self.rng, self.fresh())
        if not (self.level == 4 and depth):
            for line in lines:
                self.add(line)

    def branch(self, depth: int) -> None:
        rng, condition = self.rng, self.condition()
        if self.sub and rng.random() < 0.25:
            self.add(f"If {condition} Then Return")
        elif self.level == 4 or rng.random() < 0.3:
            self.add(
                f"If {condition} Then {self.short()}"
                + (f" Else {self.short()}" if rng.random() < 0.5 else "")
            )
        else:
            self.add(f"If {condition} Then")
            self.body(rng.randrange(1, 3), depth + 1)
            if rng.random() < 0.3:
                self.add(f"ElseIf {self.condition()} Then")
                self.body(rng.randrange(1, 3), depth + 1)
            if rng.random() < 0.5:
                self.add("Else")
                self.body(rng.randrange(1, 3), depth + 1)
            self.add("EndIf")

    def for_(self, depth: int) -> None:
        """Bounds are numbers, or worked out before the loop and left alone in it."""
        rng, name = self.rng, f"ML{self.fresh()}"
        first, last, step = rng.choice(
            (("1", "3", ""), ("3", "1", "-1"), ("0", "1", "0.5"), ("2", "1", ""), ("1", "5", "2"))
        )
        if rng.random() < 0.5:
            low, high = f"MB{self.fresh()}", f"ME{self.fresh()}"
            self.add(f"{low}={self.natural()} Mod 3")
            self.add(f"{high}={self.natural()} Mod 4")
            first, last = low, high
            if rng.random() < 0.4:
                step = f"MS{self.fresh()}"
                self.add(f"{step}={rng.choice((1, -1, 2, 0.5))}")
        self.add(f"For {name}={first} To {last}" + (f" Step {step}" if step else ""))
        self.body(rng.randrange(1, 3), depth + 1)
        if rng.random() < 0.5:
            self.add(f"MA(1)=MA(1)+{name}")
        self.add(f"Next {name}")

    def while_(self, depth: int) -> None:
        name = f"MW{self.fresh()}"
        self.add(f"{name}=0")
        self.add(f"While {name}<{self.rng.randrange(1, 4)}")
        self.add(f"{name}={name}+1")
        self.body(self.rng.randrange(1, 3), depth + 1)
        self.add("WEnd")

    def again(self, depth: int) -> None:
        """A loop by a jump back."""
        number = self.fresh()
        name, label = f"MG{number}", f"L{number}"
        self.add(f"{name}=0")
        self.add(f"*{label}")
        self.add(f"{name}={name}+1")
        self.body(self.rng.randrange(1, 3), depth + 1)
        self.add(
            f"If {name}<{self.rng.randrange(1, 4)} Then {self.rng.choice(('', 'GoTo '))}*{label}"
        )

    def select(self, depth: int) -> None:
        rng = self.rng
        if self.level == 4 and depth:
            return
        self.add(f"Select {self.natural()} Mod 5")
        for case in ("0", rng.choice(("1", "3", "1 To 2", "Is >3")), "2"):
            self.add(f"Case {case}")
            self.inner(depth)
            if rng.random() < 0.5:
                self.add("Break")
        if rng.random() < 0.5:
            self.add("Default")
            self.inner(depth)
        self.add("End Select")

    def inner(self, depth: int) -> None:
        """The lines of a case: in IV without a Select of their own."""
        self.body(self.rng.randrange(1, 3), max(depth + 1, DEEPEST if self.level == 4 else 0))


def numbered(lines: Sequence[str], level: int) -> str:
    """Lines with their step numbers, as a version writes them."""
    step = 10 if level == 4 else 1
    texts = (line.upper() if level == 4 else line for line in lines)
    return "\n".join(f"{at * step} {text}" for at, text in enumerate(texts, 1))


PLAIN: Final[tuple[Callable[[_Writer, int], None], ...]] = (
    _Writer.move, _Writer.move, _Writer.arc, _Writer.tool, _Writer.base, _Writer.speed,
    _Writer.override, _Writer.here, _Writer.assign, _Writer.assign, _Writer.set_position,
    _Writer.output, _Writer.output, _Writer.wait, _Writer.text, _Writer.call, _Writer.call,
    _Writer.pallet,
)  # fmt: skip
BLOCKS: Final[tuple[Callable[[_Writer, int], None], ...]] = (
    _Writer.branch, _Writer.branch, _Writer.branch, _Writer.for_, _Writer.for_, _Writer.while_,
    _Writer.again, _Writer.select,
)  # fmt: skip
MORE: Final[tuple[Callable[[_Writer, int], None], ...]] = (
    *(_Writer.angle, _Writer.angle, _Writer.angle, _Writer.turning, _Writer.constant_tool),
    *(_Writer.call_program, _Writer.call_program, _Writer.cell, _Writer.cell, _Writer.cell),
)
