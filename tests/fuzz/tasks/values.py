"""Values of the statements of a drawn task: what it has declared, and expressions of it."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Final

LEAST_MARK: Final = 1001
"""The first of the numbers by which a statement is found again; no other number is as large."""
UNUSED: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
DOWN: Final = ("[0,0,1,0]", "[0,0.991444861,0.130526192,0]", "[0,0.707106781,0.707106781,0]")


@dataclass(frozen=True, slots=True)
class Routine:
    """types: of its parameters. result: empty of a procedure."""

    name: str
    types: tuple[str, ...]
    result: str = ""


class Values:
    """known: names that may be read, by their types; a whole number is an `int`.

    written: those that may be assigned. rows: arrays of whole numbers with their sizes.
    routines: those that may be called.
    """

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.next_mark = LEAST_MARK
        self.count = 0
        self.known: dict[str, list[str]] = {}
        self.written: dict[str, list[str]] = {}
        self.rows: list[tuple[str, int]] = []
        self.routines: list[Routine] = []

    def mark(self) -> int:
        """A number that nothing else has."""
        self.next_mark += 1
        return self.next_mark - 1

    def name(self, stem: str) -> str:
        self.count += 1
        return f"{stem}{self.count}"

    def any(self, kind: str, *, written: bool = False) -> str | None:
        """A name of a type, None if there is none."""
        names = (self.written if written else self.known).get(kind, [])
        return self.rng.choice(names) if names else None

    def functions(self, result: str) -> list[Routine]:
        return [one for one in self.routines if one.result == result]

    # ---------------------------------------------------------------------------- numbers

    def whole(self, depth: int = 0) -> str:
        """A whole number that stays below some thousands."""
        rng = self.rng
        draw = rng.random()
        one = self.any("int")
        if depth > 1 or draw < 0.3 or one is None:
            return one if one is not None and rng.random() < 0.6 else str(rng.randint(0, 9))
        match rng.randint(0, 11):
            case 0 | 1:
                return f"{self.small(depth + 1)}+{self.small(depth + 1)}"
            case 2:
                return f"{self.small(depth + 1)}*{rng.randint(2, 3)}"
            case 3:
                return f"{self.small(depth + 1)} DIV {rng.randint(2, 4)}"
            case 4:
                return f"Abs({one}-{rng.randint(1, 20)})"
            case 5:
                return f"Trunc({self.real()})"
            case 6:
                return f"Round({self.real()})"
            case 7 if self.any("string"):
                return f"StrLen({self.any('string')})"
            case 8 if self.rows:
                name, size = rng.choice(self.rows)
                return f"{name}{{{rng.randint(1, size)}}}"
            case 9 if self.any("record"):
                return f"{self.any('record')}.number"
            case 10 if self.functions("int"):
                return self.called(rng.choice(self.functions("int")))
            case 11 if self.rows:
                return f"Dim({rng.choice(self.rows)[0]},1)"
        return f"({one}-{self.small(depth + 1)})"

    def small(self, depth: int = 0) -> str:
        """A whole number from 0 to 7."""
        if depth > 1 or self.rng.random() < 0.3:
            return str(self.rng.randint(0, 7))
        return f"(Abs({self.any('int') or 5}) MOD 8)"

    def real(self) -> str:
        rng = self.rng
        one = self.any("num") or "1.5"
        place = self.any("pos")
        match rng.randint(0, 6):
            case 0:
                return f"{self.small()}/4"
            case 1:
                return f"{rng.randint(1, 9)}.25"
            case 2 if place:
                return f"{place}.{rng.choice('xyz')}"
            case 3 if self.any("robtarget"):
                return f"{self.any('robtarget')}.trans.{rng.choice('xyz')}"
            case 4:
                return f"Min({one},20)" if rng.random() < 0.2 else f"{one}/2"
            case 5:
                return f"Sqrt({rng.choice((4, 9, 16))})"
        return one

    # ----------------------------------------------------------------------------- truths

    def condition(self, depth: int = 0) -> str:
        rng = self.rng
        if depth < 1 and rng.random() < 0.25:
            word = rng.choice((" AND ", " OR "))
            return f"{self.condition(depth + 1)}{word}{self.condition(depth + 1)}"
        match rng.randint(0, 9):
            case 0 if self.any("bool"):
                return rng.choice(("{}", "(NOT {})")).replace("{}", self.any("bool") or "")
            case 1:
                return f"diPart={rng.randint(0, 1)}"
            case 2:
                return f"DInput(diReady)={rng.randint(0, 1)}"
            case 3:
                return f"giOrder{rng.choice(('=', '>', '<'))}{rng.randint(0, 7)}"
            case 4:
                return f"DOutput(doLamp)={rng.randint(0, 1)}"
            case 5 if self.any("string"):
                return f'{self.any("string")}="part {rng.randint(0, 20)}"'
            case 6 if self.any("bool"):
                return f"{self.any('bool')}=TRUE"
        relation = rng.choice(("=", "<>", "<", ">", "<=", ">="))
        return f"{self.whole(1)}{relation}{self.whole(1)}"

    # ------------------------------------------------------------------------------ others

    def text(self) -> str:
        rng = self.rng
        one = self.any("string")
        match rng.randint(0, 5):
            case 0 if one:
                return f'StrPart({one}+"abcd",1,{rng.randint(1, 3)})'
            case 1:
                return f'"no "+NumToStr({self.small()},0)'
            case 2:
                return f'ValToStr({self.small()})+" parts"'
            case 3 if one:
                return f'StrPart({one}+"....",1,4)+"{rng.randint(1, 99)}"'
        return f'"part {rng.randint(0, 20)}"'

    def place(self) -> str:
        """A position, which no move to it leaves the reach of a middling arm."""
        rng = self.rng
        one = self.any("robtarget") or "p1"
        offsets = ",".join(
            rng.choice(("0", str(rng.randint(-20, 20)), self.small())) for _ in "xyz"
        )
        match rng.randint(0, 6):
            case 0 | 1:
                return f"Offs({one},{offsets})"
            case 2:
                return f"RelTool({one},{offsets})"
            case 3:
                return f"RelTool({one},{offsets}\\Rz:={rng.randint(-40, 40)})"
            case 4 if self.functions("robtarget"):
                return self.called(rng.choice(self.functions("robtarget")))
        return one

    def value(self, kind: str) -> str:
        match kind:
            case "int":
                return self.whole()
            case "num":
                return self.real()
            case "bool":
                return self.rng.choice(("TRUE", "FALSE", self.condition()))
            case "string":
                return self.text()
            case "robtarget":
                return self.place()
            case "pos":
                return f"[{self.small()},{self.small()},{self.rng.randint(0, 90)}]"
        return self.any(kind) or ""

    def called(self, one: Routine) -> str:
        """A call of a function, without functions of its own in it."""
        kept, self.routines = self.routines, []
        try:
            return f"{one.name}({','.join(self.value(kind) for kind in one.types)})"
        finally:
            self.routines = kept
