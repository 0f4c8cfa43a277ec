"""Valid MELFA-BASIC IV, V and VI: every word, function and variable of the tables of a version."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from random import Random
from typing import Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.vocabulary import Function, Statement, Status

DEEPEST: Final = 2
FORMS: Final[dict[str, tuple[str, ...]]] = {
    "Accel": ("", "50,50", "80,80,100,100", "{v},{v}"),
    "Base": ("{p}", "P_NBase", "{c}"),
    "Cnt": ("0", "1", "1,5,5", "1,10"),
    "Fine": ("100", "0", "30,1", "0.5,P"),
    "JOvrd": ("50", "100", "{v}"),
    "JRC": ("1,1", "+1", "-1", "+1,2"),
    "LoadSet": ("1", "1,1", "0,0"),
    "MvTune": ("1", "2"),
    "Mxt": ("1,1", "2,0,50"),
    "Oadl": ("On", "Off"),
    "Ovrd": ("50", "100", "{v}", "80,50"),
    "Prec": ("On", "Off"),
    "Servo": ("On", "Off", "On,1"),
    "Spd": ("100", "{v}", "M_NSpd", "250.5"),
    "SpdOpt": ("On", "Off"),
    "Tool": ("{p}", "P_NTool", "{c}"),
    "Torq": ("1,50", "4,10"),
    "CavChk": ("On", "Off", "On,1"),
    "Cmp": ("Off", "Pos,&B1", "Tool,&B11", "Jnt,&B100011"),
    "CmpG": ("", "1,1,1", ",,0.5"),
    "ColChk": ("On", "Off", "On,NoErr"),
    "ColLvl": ("", "100,80", ",80"),
    "HClose": ("1", "{h}"),
    "HOpen": ("1", "2", "1,30,20,0.5"),
    "EHMov": ("1,{p}", "1,10"),
    "EHServo": ("On,1", "Off,1"),
    "Fsc": ("On,0,1,1", "Off"),
    "FsHndEst": ("On", "Off"),
    "FsLog": ("On,1", "Off"),
    "FsTest": ("On", "Off"),
    "FsGChg": ("1,2,1", "0,10,101"),
    "Act": ("1=1", "1=0", "0=1"),
    "Dly": ("0.1", "1", "{v}"),
    "Error": ("9000", "9100"),
    "GetM": ("1",),
    "RelM": ("",),
    "Priority": ("1", "3,2"),
    "Wait": ("{q}", "M_In(1)=1", "{q} And {q}"),
    "XClr": ("2",),
    "XLoad": ('2,"JOB"',),
    "XRst": ("2",),
    "XRun": ("2", '2,"JOB"', '3,"JOB",1'),
    "XStp": ("2",),
    "ChrSrch": ('C1$,"a",3',),
    "Clr": ("1", "0"),
    "GpsChk": ("On,1", "Off,1"),
    "Trk": ("On,{p}", "Off"),
    "TrkMv": ("On,{p}", "Off"),
    "TrkFine": ("On,1", "Off"),
    "Title": ('"job"',),
}
"""Word → arguments that it may have: {m} number, {v} numeric variable, {p} position variable,
{c} position constant, {q} condition, {h} hand, {a} three points of an arc."""
LEFT_OUT: Final = frozenset(
    *(("While", "WEnd", "Break", "Default", "Else", "EndIf", "End", "FEnd", "Return", "Skip"),)
)
MOTIONS: Final = {
    "Mov": ("{t}", "{t},{d}", "{j}", "{t}"),
    "Mvs": ("{t}", "{t},{d}", ",{d}", "{t}"),
    "Mvr": ("{a}",),
    "EMvr": ("{a}",),
    "EMvr2": ("{a}",),
    "EMvr3": ("{a}",),
    "EMvc": ("{a}",),
    "EMvSpl": ("{p},50,2",),
    "EMvs": ("{p}",),
    "MvSpl": ("{p},50,2",),
    "Mvr2": ("{a}",),
    "Mvr3": ("{a}",),
    "Mvc": ("{a}",),
    "Mva": ("{p},1", "{p}"),
}
OPERATORS: Final = ("+", "-", "*", "/", " Mod ", "\\", "^", " And ", " Or ", " Xor ", "<<", ">>")
RELATIONS: Final = ("=", "<>", "<", ">", "<=", ">=", "><", "=<", "=>")
POSITIONS: Final = ("P1", "P2", "P10", "P11", "PA", "PHOME")
JOINTS: Final = ("J1", "JA")
NUMBERS: Final = ("M1", "M2", "M10", "MA", "MCOUNT")
TEXTS: Final = ("C1$", "C2$", "CA$")


@cache
def commands(level: int) -> tuple[Statement, ...]:
    return tuple(
        one
        for one in vocabulary.statements().values()
        if one.role == "command" and level in one.dialects and one.word not in LEFT_OUT
    )


@cache
def motions(level: int) -> tuple[Statement, ...]:
    return tuple(
        one
        for one in vocabulary.statements().values()
        if one.role == "motion" and level in one.dialects
    )


@cache
def functions(level: int, type: str) -> tuple[Function, ...]:
    return tuple(
        one
        for one in vocabulary.functions().values()
        if level in one.dialects and type in one.result
    )


@cache
def variables(level: int, type: str, *, writable: bool = False) -> tuple[Status, ...]:
    return tuple(
        one
        for one in vocabulary.variables().values()
        if level in one.dialects
        and one.type == type
        and (one.writable if writable else one.readable)
    )


class Melfa:
    def __init__(self, rng: Random, level: int) -> None:
        self.rng, self.level = rng, level
        self.reached: set[str] = set()
        self.lines: list[str] = []
        self.labels: list[str] = []
        self.behind: list[str] = []
        self.count = 0
        self.loops = 0
        self.formulas: list[str] = []
        self.arrays = False
        self.subs: list[str] = []
        self.in_function = False

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

    def filled(self, text: str) -> str:
        return re.sub(r"\{(\w)\}", lambda m: PARTS[m[1]](self), text)

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

    # ----------------------------------------------------------------------- expressions

    def expression(self, type: str, depth: int = 0) -> str:
        rng = self.rng
        draw = rng.random()
        if depth >= DEEPEST or draw < 0.35:
            return self.leaf(type)
        if type == "M":
            if draw < 0.6:
                sign = rng.choice(OPERATORS)
                return f"{self.term('M', depth)}{sign}{self.term('M', depth)}"
            if draw < 0.65:
                return f"-{self.term('M', depth)}"
        if type == "P" and draw < 0.6:
            right = self.leaf("P") if draw < 0.5 else self.constant_or()
            return f"{self.leaf('P')}{rng.choice('+*-/')}{right}"
        if type == "P" and draw < 0.64 and self.level:
            return f"(Plt 1,{self.leaf('M')})"
        if type == "J" and draw < 0.6:
            return f"{self.leaf('J')}{rng.choice('+-')}{self.leaf('J')}"
        if type == "C" and draw < 0.6:
            return f"{self.leaf('C')}+{self.leaf('C')}"
        found = functions(self.level, type)
        if found and draw < 0.9:
            return self.called(rng.choice(found), depth)
        if self.formulas and type == "M":
            return f"FNMSUM({self.leaf('M')})"
        known = variables(self.level, type)
        return self.status(rng.choice(known)) if known else self.leaf(type)

    def constant_or(self) -> str:
        return self.rng.choice((self.constant(), "(0,0,10,0,0,0)", "(0,0,-5.5,0,0,0)(0,0)"))

    def called(self, one: Function, depth: int) -> str:
        rng = self.rng
        self.reached.add(one.name.lower())
        given = []
        for argument in one.arguments:
            if argument.optional and rng.random() < 0.3:
                break
            type = rng.choice(argument.types.replace("?", "M") or "M")
            if argument.assigned:
                given.append(self.variable(type))
            else:
                given.append(self.expression(type, depth + 1))
        if one.open and rng.random() < 0.4:
            given.append(self.leaf("M" if one.result == "M" else "P"))
        return f"{one.name}({','.join(given)})"

    def status(self, one: Status) -> str:
        self.reached.add(one.name.lower())
        index = [self.rng.choice(("1", "2")) for part in one.index if part != "-"]
        needs = any(word in ("input", "output", "register", "file", "timer") for word in one.index)
        if not index or (not needs and self.rng.random() < 0.5 and len(index) == 1):
            return one.name if not needs else f"{one.name}({','.join(index)})"
        return f"{one.name}({','.join(index)})"

    def term(self, type: str, depth: int) -> str:
        text = self.expression(type, depth + 1)
        return text if re.fullmatch(r"\w+|[\w$]+\([\w,]*\)", text) else f"({text})"

    def variable(self, type: str) -> str:
        rng = self.rng
        if self.arrays and type in "MP" and rng.random() < 0.3:
            return f"{'MB' if type == 'M' else 'PB'}({rng.choice(('1', '2', 'M1', 'M1+1'))})"
        return rng.choice({"M": NUMBERS, "P": POSITIONS, "C": TEXTS, "J": JOINTS}[type])

    def leaf(self, type: str) -> str:
        rng = self.rng
        draw = rng.random()
        if type == "M":
            if draw < 0.4:
                return rng.choice(
                    ("0", "1", "2", "3", "10", "0.5", "12.25", "&HF", "&B101", "1E2", "7")
                )
            if draw < 0.5:
                return rng.choice(
                    ("M_In(1)", "M_Inb(8)", "P1.X", "P2.Z", "M_PI", "J1.J1", "M_Timer(1)")
                )
        if type == "C" and draw < 0.5:
            return rng.choice(('"abc"', '""', '"a\'b"', '"*x"'))
        if type == "P" and draw < 0.1:
            return rng.choice(("P_Curr", "P_NTool", "P_Zero"))
        return self.variable(type)

    def condition(self) -> str:
        rng = self.rng
        draw = rng.random()
        if draw < 0.3:
            return f"M_In({rng.randint(1, 9)})={rng.randrange(2)}"
        if draw < 0.45:
            return f"{self.condition()} {rng.choice(('And', 'Or'))} {self.condition()}"
        if draw < 0.55:
            return f'{self.leaf("C")}{rng.choice(("=", "<>"))}"x"'
        if draw < 0.62:
            return f"Not ({self.condition()})"
        return f"{self.term('M', 1)}{rng.choice(RELATIONS)}{self.term('M', 1)}"

    def constant(self) -> str:
        rng = self.rng
        x, y, z = rng.randint(150, 300), rng.randint(-100, 100), rng.choice((200, 300.5, 250.25))
        flags = rng.choice(("(7,0)", "(7,0)", "(7,1048576)", "(7,15728640)"))
        turns = rng.choice(("180,0,180", "0,0,180", "-179.5,10,45.5", "180,10,0"))
        return f"({x},{y},{z},{turns}){flags}"

    def joints(self) -> str:
        rng = self.rng
        return "(" + ",".join(str(rng.choice((0, 10, -20.5, 90))) for _ in range(6)) + ")"


PARTS: Final[dict[str, Callable[[Melfa], str]]] = {
    "m": lambda w: w.leaf("M"),
    "v": lambda w: w.variable("M"),
    "p": lambda w: w.variable("P"),
    "a": lambda w: ",".join(w.rng.sample(("P1", "P2", "P10", "P11"), 3)),
    "c": lambda w: w.constant(),
    "t": lambda w: w.expression("P", 1),
    "j": lambda w: w.variable("J"),
    "q": lambda w: w.condition(),
    "d": lambda w: w.rng.choice(("-20", "10", "-50.5", "M1")),
    "h": lambda w: str(w.rng.randint(1, 3)),
}
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
