"""Valid MELFA-BASIC IV, V and VI: every word, function and variable of the tables of a version."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random
from typing import Final

from tests.fuzz.valid.melfa_values import DEEPEST, JOINTS, POSITIONS, Values, variables
from tests.fuzz.valid.melfa_words import FORMS, MOTIONS, commands, motions


class Melfa(Values):
    # ------------------------------------------------------------------------- the whole

    def program(self) -> str:
        rng = self.rng
        functions = self.level == 6 and rng.random() < 0.25
        if functions:
            self.functions()
        else:
            self.subs = [f"S{n}" for n in range(rng.choice((0, 0, 1, 2)))]
            self.head()
            self.body(rng.choice((2, 4, 7)))
            self.add("End" if rng.random() < 0.8 else "Hlt\nEnd")
            for name in self.subs:
                self.add(f"*{name}")
                self.body(rng.choice((1, 2)))
                self.add(rng.choice(("Return 0", "Return 1")) if name == "INT1" else "Return")
        return self.numbered()

    def functions(self) -> None:
        rng, self.in_function = self.rng, True
        self.add(f"Function M FA({rng.choice(('ByVal', 'ByRef'))} MX,ByVal PX)")
        self.body(1)
        if rng.random() < 0.4:
            self.add(f"If {self.condition()} Then Exit Function")
        self.add("FA=MX+1")
        self.add("FEnd")
        self.add("Function V FB()")
        self.body(1)
        self.add("FEnd")
        self.add("Function Main")
        self.body(rng.choice((2, 4)))
        self.add(rng.choice(("M1=FA(M2,P1)", "M1=FA(1,P1)", "FB()")))
        self.add("FEnd")

    def head(self) -> None:
        rng = self.rng
        for text in (
            "Def Inte MK,ML",
            "Def Float MF",
            "Def Char CN$",
            "Def Pos PW,PV",
            "Def Jnt JW",
            "Dim MB(5),PB(3)",
            "Def Io PORT1=Bit,6",
            "Def Io PORT2=Byte,8,&HF",
            "Def Plt 1,P1,P2,P10,,3,2,1",
            "Def Plt 2,P1,P2,P10,P11,3,2,2",
            "Def Arch 1,5,5,20,20",
            "Def FNMSUM(MX)=MX*2+1",
            "Def Act 1,M_In(8)=1 GoSub *INT1",
            "Def Act 2,M_In(9)=1 GoTo *ACT2",
            "FPrm M1,P1",
            "Def Inte MB",
            *(
                ("Def Double MD", "Def Long MLONG", "Const MC=5", "Def MoTrg 1,1,1")
                if self.level >= 5
                else ()
            ),
            *(("Static Def Inte MS", "Def Work WK1") if self.level == 6 else ()),
        ):
            if rng.random() < 0.1:
                if "Act 1" in text:
                    self.subs.append("INT1")
                if "ACT2" in text:
                    self.labels.append("ACT2")
                if text.startswith("Dim"):
                    self.arrays = True
                if "FNM" in text:
                    self.formulas.append("FNMSUM")
                self.add(text)
                self.reached.add(" ".join(text.split()[:2]).lower())

    def numbered(self) -> str:
        rng, level = self.rng, self.level
        for label in self.labels:
            self.lines.insert(self._end(), f"*{label}")
        step = 10 if level == 4 or rng.random() < 0.2 else 1
        made = []
        lines = [one for line in self.lines for one in line.split("\n")]
        upper = level == 4 or rng.random() < 0.1
        for at, line in enumerate(lines, 1):
            text = self.spelled(line, upper)
            if rng.random() < 0.05 and not text.startswith("*") and " Rem" not in text:
                text += rng.choice((" 'move", " '", ' \' "a" *b'))
            blank = rng.choice(("", "  ", "\t")) if rng.random() < 0.1 else ""
            made.append(f"{at * step} {blank}{text}")
        text = "\n".join(made + self.positions())
        return text.replace("\n", "\r\n") if rng.random() < 0.5 else text + "\n"

    def spelled(self, line: str, upper: bool) -> str:
        if not upper:
            return line
        parts = re.split(r'("[^"]*"|\'.*)', line)
        return "".join(part if n % 2 else part.upper() for n, part in enumerate(parts))

    def _end(self) -> int:
        """Where the main part ends."""
        for at, line in enumerate(self.lines):
            if line.split("\n")[-1] in ("End", "FEnd") and (
                not self.in_function or "Main" in "".join(self.lines[:at])
            ):
                return at
        return len(self.lines)

    def positions(self) -> list[str]:
        rng = self.rng
        text = "\n".join(self.lines)
        made = []
        words = set(re.findall(r"\b[PJ][A-Z0-9]+\b", text.upper()))
        for name in (*POSITIONS, *JOINTS):
            if name in words and (name[1].isdigit() or rng.random() < 0.85):
                made += [f"{name}={self.constant() if name[0] == 'P' else self.joints()}"]
        if rng.random() < 0.1:
            made += [f"P{n}={self.constant()}" for n in range(30, 30 + rng.randint(3, 20))]
        return made

    # ------------------------------------------------------------------------ statements

    def add(self, text: str) -> None:
        self.lines.append(text)

    def body(self, most: int, depth: int = 0) -> None:
        for _ in range(most):
            table = (*PLAIN, *BLOCKS) if depth < DEEPEST else PLAIN
            draw = self.rng.choices([k for k, _ in table], [w for _, w in table])[0]
            draw(self, depth)

    def command(self, depth: int) -> None:
        rng = self.rng
        one = rng.choice(commands(self.level))
        self.reached.add(one.word.lower())
        if one.word in FORMS:
            given = rng.choice(FORMS[one.word])
            if self.level == 4:
                given = {"Fine": "100", "Wait": "M_In(1)=1", "XLoad": '2,"JOB"'}.get(
                    one.word, given
                )
        elif one.most == 0:
            given = ""
        else:
            count = rng.randint(one.least, one.most or max(3, one.least))
            parts = [rng.choice(("{m}", "{p}", "1", '"COM2:"', "2", "{v}")) for _ in range(count)]
            if one.words and parts:
                parts[0] = rng.choice(one.words)
            given = ",".join(parts)
        self.add(f"{one.word} {self.filled(given)}".rstrip())

    def motion(self, depth: int) -> None:
        rng = self.rng
        word = rng.choice(("Mov", "Mvs", "Mov", "Mvs", "Mvr", rng.choice(motions(self.level)).word))
        if word == "Mva":
            self.reached.add("def arch")
        self.reached.add(word.lower())
        given = rng.choice(MOTIONS.get(word, ("{a}",)))
        text = f"{word} {self.filled(given)}"
        if rng.random() < 0.1 and word != "Mva":
            text += rng.choice((" Type 0,0", " Type 1,0", " Type 0,1"))
        if rng.random() < 0.2:
            what = rng.choice(
                ("M_Out(1)=1", "M_Out(2)=0 Dly 0.5", "M1=1", "HOpen 1", "M_Outb(8)=3")
            )
            place = rng.choice(("M_In(1)=1", "M_Ratio>50", "M_RDst<=20", self.condition()))
            text += rng.choice((f" Wth {what}", f" WthIf {place},{what}", f" WthIf {place},Skip"))
        self.add(text)

    def assign(self, depth: int) -> None:
        rng = self.rng
        type = rng.choice("MMMPPCJ")
        draw = rng.random()
        if draw < 0.12:
            found = variables(self.level, type, writable=True)
            if found:
                self.add(f"{self.status(rng.choice(found))}={self.expression(type)}")
                return
        if draw < 0.2 and type == "P":
            self.add(f"P1.{rng.choice(('X', 'Y', 'Z', 'C', 'L1'))}={self.expression('M')}")
            return
        if draw < 0.25 and type == "J":
            self.add(f"J1.J{rng.randint(1, 6)}={self.expression('M')}")
            return
        self.add(f"{self.variable(type)}={self.expression(type)}")

    def output(self, depth: int) -> None:
        rng = self.rng
        self.add(
            rng.choice(
                (
                    f"M_Out({rng.randint(0, 31)})={rng.randrange(2)}",
                    f"M_Outb(16)={self.expression('M')}",
                    f"M_Outw(32)={self.expression('M')}",
                    "M_Out(5)=1 Dly 0.5",
                    f"M_Out({self.leaf('M')})=1",
                    "M_Out(3)=M_In(3)",
                    "M_Timer(1)=0",
                    f"Dly {rng.choice(('0.1', '1', '0.5'))}",
                )
            )
        )

    def file(self, depth: int) -> None:
        rng = self.rng
        self.reached |= {"open", "print", "input", "close"}
        self.add(f'Open "COM{rng.randint(1, 3)}:" As #1')
        self.add(
            rng.choice(
                (
                    'Print #1,"a",M1',
                    "Print #1,C1$;M1",
                    "Input #1,M1,C1$",
                    "Input #1,P1",
                    f"Print #1,{self.expression('M')}",
                )
            )
        )
        self.add(rng.choice(("Close #1", "Close")))

    def call(self, depth: int) -> None:
        rng = self.rng
        if self.in_function or depth > 0 or not self.subs:
            self.reached.add("callp")
            self.add(
                rng.choice(('CallP "20"', 'CallP "JOB",M1,P1', 'CallP "JOB",1,(1,2,3,4,5,6)(7,0)'))
            )
            return
        name = rng.choice(self.subs)
        self.reached |= {"gosub"}
        self.add(
            rng.choice(
                (
                    f"GoSub *{name}",
                    f"GoSub *{name}",
                    f"On M1 GoSub *{name}",
                    f"On M1 GoSub ,*{name},*{name}",
                )
            )
        )

    def com(self, depth: int) -> None:
        if "INT1" in self.subs and not self.in_function:
            self.add(
                self.rng.choice(("On Com(1) GoSub *INT1", "Com(1) On", "Com(1) Off", "Com(1) Stop"))
            )

    def comment(self, depth: int) -> None:
        self.add(self.rng.choice(("'a comment", "Rem again", "'", '\' "x" = 3')))

    def if_(self, depth: int) -> None:
        rng, condition = self.rng, self.condition()
        if self.level == 4 or rng.random() < 0.4:
            text = f"If {condition} Then {self.short()}"
            self.add(text + (f" Else {self.short()}" if rng.random() < 0.4 else ""))
            return
        self.add(f"If {condition} Then")
        self.body(rng.choice((0, 1, 2)), depth + 1)
        if rng.random() < 0.2:
            self.add(f"ElseIf {self.condition()} Then")
            self.body(rng.choice((0, 1)), depth + 1)
        if rng.random() < 0.4:
            self.add("Else")
            self.body(rng.choice((0, 1)), depth + 1)
        self.add("EndIf")

    def for_(self, depth: int) -> None:
        rng = self.rng
        self.loops += 1
        name = f"MZ{self.loops}"
        step = rng.choice(("", "", " Step 2", " Step -1", f" Step {self.leaf('M')}"))
        self.add(f"For {name}={self.leaf('M')} To {self.expression('M', 1)}{step}")
        self.body(rng.choice((1, 2)), depth + 1)
        if rng.random() < 0.1 and self.level > 4:
            self.add("Break")
        self.add(rng.choice((f"Next {name}", f"Next {name}", "Next")))

    def while_(self, depth: int) -> None:
        self.add(f"While {self.condition()}")
        self.body(self.rng.choice((1, 2)), depth + 1)
        self.add("WEnd")

    def select(self, depth: int) -> None:
        rng = self.rng
        if self.level == 4 and depth:
            return
        type = "M" if rng.random() < 0.85 else "C"
        self.add(f"Select {self.expression(type, 1)}")
        for at in range(rng.choice((1, 2))):
            if type == "C":
                self.add(f'Case "t{at}"')
            else:
                self.add(
                    "Case "
                    + rng.choice(
                        (str(at), f"{at},{at + 10}", f"Is >{at + 50}", f"1{at} To 1{at + 1}")
                    )
                )
            self.body(rng.choice((0, 1, 2)), depth + 1)
            if rng.random() < 0.9:
                self.add("Break")
        if rng.random() < 0.4:
            self.add("Default")
            self.body(1, depth + 1)
        self.add("End Select")

    def jump(self, depth: int) -> None:
        rng = self.rng
        self.count += 1
        name = f"L{self.count}"
        if depth == 0 and rng.random() < 0.5:
            self.add(f"*{name}")
            self.body(1, 1)
            self.add(
                rng.choice(
                    (
                        f"If {self.condition()} Then *{name}",
                        f"If {self.condition()} Then GoTo *{name}",
                        f"If {self.condition()} GoTo *{name}",
                    )
                )
            )
        elif depth == 0:
            self.add(
                rng.choice(
                    (
                        f"If {self.condition()} Then *{name}",
                        f"On M1 GoTo *{name},*{name}",
                        f"If {self.condition()} Then GoTo *{name} Else M1=1",
                    )
                )
            )
            self.body(1, 1)
            self.add(f"*{name}")

    def short(self) -> str:
        rng = self.rng
        lines, self.lines = self.lines, []
        rng.choice((Melfa.assign, Melfa.output, Melfa.command))(self, 1)
        made, self.lines = self.lines, lines
        text = made[0]
        return text if "\n" not in text and "Title" not in text else "Hlt"


Draw = Callable[[Melfa, int], None]
PLAIN: Final[tuple[tuple[Draw, int], ...]] = (
    (Melfa.command, 14),
    (Melfa.motion, 10),
    (Melfa.assign, 10),
    (Melfa.output, 4),
    (Melfa.file, 1),
    (Melfa.call, 3),
    (Melfa.com, 1),
    (Melfa.comment, 1),
)
BLOCKS: Final[tuple[tuple[Draw, int], ...]] = (
    (Melfa.if_, 4),
    (Melfa.for_, 2),
    (Melfa.while_, 2),
    (Melfa.select, 2),
    (Melfa.jump, 3),
)


def program(level: int, rng: Random) -> tuple[str, set[str]]:
    made = Melfa(rng, level)
    return made.program(), made.reached
