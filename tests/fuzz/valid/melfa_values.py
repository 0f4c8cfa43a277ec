"""Valid MELFA-BASIC: expressions, conditions and constants, whatever a statement needs."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from random import Random
from typing import Final

from assistant.languages.melfa_basic.tables import vocabulary
from assistant.languages.melfa_basic.tables.vocabulary import Function, Status

DEEPEST: Final = 2
OPERATORS: Final = ("+", "-", "*", "/", " Mod ", "\\", "^", " And ", " Or ", " Xor ", "<<", ">>")
RELATIONS: Final = ("=", "<>", "<", ">", "<=", ">=", "><", "=<", "=>")
POSITIONS: Final = ("P1", "P2", "P10", "P11", "PA", "PHOME")
JOINTS: Final = ("J1", "JA")
NUMBERS: Final = ("M1", "M2", "M10", "MA", "MCOUNT")
TEXTS: Final = ("C1$", "C2$", "CA$")


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


class Values:
    """Draws values of a program, and keeps what of it is there.

    reached: words of the tables that it has, in lower case.
    """

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

    def filled(self, text: str) -> str:
        return re.sub(r"\{(\w)\}", lambda m: PARTS[m[1]](self), text)

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


PARTS: Final[dict[str, Callable[[Values], str]]] = {
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
