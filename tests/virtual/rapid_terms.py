"""Expressions of random RAPID programs: whole numbers, numbers, truths and targets."""

from __future__ import annotations

import re
from collections.abc import Sequence
from random import Random

from tests.virtual import rapid_words as w
from tests.virtual.rapid_names import Data, Parameter, Routine, Scope

DEEPEST = 3
CHANGING = re.compile(
    rf"\b({'|'.join([*w.INPUTS, *w.GROUP_INPUTS, *w.FUNCTIONS, 'DInput', 'TestDI'])})\b"
)
"""Terms that read an input, or may do so."""


class Terms:
    """Draws expressions from what is known in a scope.

    pure: functions that change nothing and can stand anywhere.
    """

    def __init__(self, rng: Random, scope: Scope, later: Sequence[Routine]) -> None:
        self.rng = rng
        self.scope = scope
        self.later = later
        self.pure = [routine for routine in later if routine.pure]

    def pick(self, kind: str, changes: bool = False, storage: str = "") -> str | None:
        """A variable of a kind, perhaps an element of an array."""
        found = self.scope.those(
            lambda d: (
                d.kind == kind
                and (d.changes or not changes)
                and (not storage or d.storage == storage)
            )
        )
        return self.variable(self.rng.choice(found)) if found else None

    def variable(self, datum: Data) -> str:
        return f"{datum.name}{{{self.index(datum)}}}" if datum.size else datum.name

    def index(self, datum: Data) -> str:
        """An index that is there, whatever the data holds."""
        size = f"Dim({datum.name},1)" if datum.size < 0 else str(datum.size)
        plain = self.scope.those(lambda d: d.kind == "whole" and not d.size)
        if self.rng.random() < 0.5 or not plain or datum.size < 0:
            return str(self.rng.randint(1, 2))
        return f"1+Abs({self.rng.choice(plain).name}) MOD {size}"

    # --------------------------------------------------------------------------------- numbers

    def whole(self, depth: int = 0) -> str:
        rng = self.rng
        draw = rng.random()
        if depth >= DEEPEST or draw < 0.35:
            return self.pick("whole") or str(rng.randint(0, 9))
        if draw < 0.55:
            return str(rng.randint(0, 20))
        if draw < 0.75:
            return f"{self.whole(depth + 1)}{rng.choice('+-')}{self.term(depth + 1)}"
        if draw < 0.82:
            return f"{self.term(depth + 1)}*{rng.randint(2, 3)}"
        if draw < 0.9:
            return f"Abs({self.whole(depth + 1)}) {rng.choice(['DIV', 'MOD'])} {rng.randint(2, 7)}"
        if draw < 0.95 and self.pure:
            return self.called(rng.choice(self.pure), depth + 1)
        if self.scope.has("groups"):
            return rng.choice(["giOrder", "GInput(giOrder)"])
        return f"({self.whole(depth + 1)})"

    def term(self, depth: int = 0) -> str:
        """A whole number that an operator can stand beside."""
        text = self.whole(depth)
        return text if text.isalnum() else f"({text})"

    def small(self) -> str:
        """A whole number from 0 to 9, small enough for a loop."""
        if self.rng.random() < 0.4:
            return str(self.rng.randint(0, 5))
        return f"Abs({self.whole(2)}) MOD {self.rng.randint(2, 5)}"

    def real(self, depth: int = 0) -> str:
        rng = self.rng
        draw = rng.random()
        if depth >= DEEPEST or draw < 0.3:
            return self.pick("real") or "2.5"
        if draw < 0.5:
            return rng.choice(["10", "-15", "0.5", "22.25", "-7.5", "100"])
        if draw < 0.7:
            return self.whole(depth + 1)
        if draw < 0.85:
            return f"({self.real(depth + 1)}){rng.choice('+-')}({self.real(depth + 1)})"
        if draw < 0.93:
            return f"({self.whole(depth + 1)}){rng.choice(['*0.5', '/2', '/4', '*1.5'])}"
        changing = self.pick("target") if self.scope.has("components") else None
        if changing and "{" not in changing:
            return f"{changing}.trans.{rng.choice('xyz')}"
        return f"Round({self.real(depth + 1)})"

    # ---------------------------------------------------------------------------------- truths

    def truth(self, depth: int = 0) -> str:
        rng = self.rng
        draw = rng.random()
        if draw < 0.45 or depth >= 2:
            sign = rng.choice(["=", "<>", "<", ">", "<=", ">="])
            return f"{self.whole(2)}{sign}{self.whole(2)}"
        if draw < 0.65:
            name = self.pick("truth")
            if name:
                return rng.choice([name, f"{name}=TRUE", f"(NOT {name})"])
        if draw < 0.8 and self.scope.has("signals"):
            signal = rng.choice(list(w.INPUTS))
            return rng.choice([f"{signal}=1", f"DInput({signal})=0", f"TestDI({signal})"])
        word = rng.choice(["AND", "OR", "XOR"])
        return f"({self.truth(depth + 1)}) {word} ({self.steady(depth + 1)})"

    def steady(self, depth: int = 0) -> str:
        """A truth that may be left unread: of changing inputs, one that reads none."""
        found = self.truth(depth)
        if self.scope.has("changing") and CHANGING.search(found):
            return f"{self.pick('real') or '2.5'}<{self.rng.choice(['3', '10'])}"
        return found

    # --------------------------------------------------------------------------------- targets

    def target(self, depth: int = 0) -> str:
        rng = self.rng
        named = self.pick("target") or "p10"
        draw = rng.random()
        if draw < 0.45 or depth:
            return named
        if draw < 0.8:
            return f"Offs({named},{self.shift()},{self.shift()},{self.shift()})"
        turn = rng.choice(["", "", "\\Rz:=30", "\\Rx:=15", "\\Ry:=-10", "\\Rx:=15\\Rz:=30"])
        beside = self.shift() if rng.random() < 0.3 else "0"
        return f"RelTool({named},{self.shift()},{beside},{self.shift()}{turn})"

    def shift(self) -> str:
        return self.rng.choice(
            ["0", "0", self.real(1), self.whole(2), str(self.rng.randint(-30, 60))]
        )

    # ----------------------------------------------------------------------------------- calls

    def called(self, routine: Routine, depth: int = 0) -> str:
        return f"{routine.name}({','.join(self.arguments(routine, depth))})"

    def arguments(self, routine: Routine, depth: int = 0) -> list[str]:
        return [self.argument(one, depth) for one in routine.parameters if one.kind != "switch"]

    def argument(self, one: Parameter, depth: int) -> str:
        if one.mode:
            return self.reference(one)
        if one.size:
            return self.array(one)
        match one.kind:
            case "whole":
                return self.whole(depth + 1)
            case "real":
                return self.real(depth + 1)
            case "truth":
                return self.rng.choice(["TRUE", "FALSE", self.pick("truth") or "TRUE"])
        return self.pick("target") or "p10"

    def reference(self, one: Parameter) -> str:
        """Data that a parameter may refer to; `can_call` says whether there is any."""
        if one.size:
            return self.array(one)
        storage = one.mode if one.mode in ("VAR", "PERS") else ""
        return self.pick(one.kind, True, storage) or ""

    def array(self, one: Parameter) -> str:
        return self.rng.choice(self.arrays(one)).name

    def arrays(self, one: Parameter) -> list[Data]:
        return self.scope.those(lambda d: d.size != 0 and d.kind == one.kind and d.storage == "VAR")

    def can_call(self, routine: Routine) -> bool:
        """Whether there is data for each of its references."""
        return all(
            bool(self.arrays(one)) if one.size else not one.mode or bool(self.reference(one))
            for one in routine.parameters
        )
