"""Values of the statements of a drawn task: what it has declared, and expressions of it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from random import Random
from typing import Final

LEAST_MARK: Final = 1001
"""The first of the numbers by which a statement is found again; no other number is as large."""
UNUSED: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
DOWN: Final = ("[0,0,1,0]", "[0,0.991444861,0.130526192,0]", "[0,0.707106781,0.707106781,0]")


FORMS: Final[Mapping[str, Mapping[str, float]]] = {
    "small": {"{0..7}": 3, "(Abs({name int}) MOD 8)": 7},
    "int": {
        "{0..9}": 12,
        "{name int}": 18,
        "{small}+{small}": 12,
        "({name int}-{small})": 6,
        "{small}*{2..3}": 6,
        "{small} DIV {2..4}": 6,
        "Abs({name int}-{1..20})": 6,
        "Trunc({num})": 6,
        "Round({num})": 6,
        "StrLen({name string})": 6,
        "{element}": 6,
        "{name record}.number": 6,
        "{call int}": 6,
        "Dim({row},1)": 6,
    },
    "num": {
        "{1..9}.25": 5,
        "{name num}": 5,
        "{small}/4": 5,
        "{name pos}.{x|y|z}": 5,
        "{name robtarget}.trans.{x|y|z}": 5,
        "{name num}/2": 4,
        "Min({name num},20)": 1,
        "Sqrt({4|9|16})": 5,
    },
    "bool": {"TRUE": 1, "FALSE": 1, "{condition}": 1},
    "condition": {"{truth}": 6, "{truth} AND {truth}": 1, "{truth} OR {truth}": 1},
    "truth": {
        "{int}{=|<>|<|>|<=|>=}{int}": 4,
        "{name bool}": 0.5,
        "(NOT {name bool})": 0.5,
        "{name bool}=TRUE": 1,
        "diPart={0..1}": 1,
        "DInput(diReady)={0..1}": 1,
        "giOrder{=|>|<}{0..7}": 1,
        "DOutput(doLamp)={0..1}": 1,
        '{name string}="part {0..20}"': 1,
    },
    "string": {
        '"part {0..20}"': 2,
        'StrPart({name string}+"abcd",1,{1..3})': 1,
        '"no "+NumToStr({small},0)': 1,
        'ValToStr({small})+" parts"': 1,
        'StrPart({name string}+"....",1,4)+"{1..99}"': 1,
    },
    "robtarget": {
        "p1": 0,
        "{name robtarget}": 2,
        "Offs({name robtarget},{offsets})": 2,
        "RelTool({name robtarget},{offsets})": 1,
        "RelTool({name robtarget},{offsets}\\Rz:={-40..40})": 1,
        "{call robtarget}": 1,
    },
    "offsets": {"{offset},{offset},{offset}": 1},
    "offset": {"0": 1, "{-20..20}": 1, "{small}": 1},
    "pos": {"[{small},{small},{0..90}]": 1},
}
"""Expressions of a type, and how often each is drawn; the first needs nothing that is declared.

A whole number (`int`) stays below some thousands, a `small` one from 0 to 7; no move to a
position leaves the reach of a middling arm. Fields: `{1..9}` a number, `{x|y}` one of these words,
`{name T}` a name of that type, `{call T}` a call of a function of it, `{row}` an array, `{element}`
an element of one, other words an expression of that row.
"""
FIELD: Final = re.compile(r"\{(.*?)\}")


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

    def small(self) -> str:
        """A whole number from 0 to 7."""
        return self.value("small")

    def condition(self) -> str:
        return self.value("condition")

    def value(self, kind: str) -> str:
        """An expression of a type, or of what `FORMS` has more; empty where there is none."""
        if kind not in FORMS:
            return self.any(kind) or ""
        forms = FORMS[kind]
        (drawn,) = self.rng.choices(tuple(forms), tuple(forms.values()))
        said = self.filled(drawn)
        return self.filled(next(iter(forms))) or "" if said is None else said

    def filled(self, form: str) -> str | None:
        """A form with what stands for its fields; None if there is nothing for one of them."""
        parts = FIELD.split(form)
        for place in range(1, len(parts), 2):
            said = self.field(parts[place])
            if said is None:
                return None
            parts[place] = said
        return "".join(parts)

    def field(self, field: str) -> str | None:
        rng = self.rng
        if ".." in field:
            least, most = map(int, field.split(".."))
            return str(rng.randint(least, most))
        if "|" in field:
            return rng.choice(field.split("|"))
        word, _, kind = field.partition(" ")
        match word:
            case "name":
                return self.any(kind)
            case "call":
                functions = self.functions(kind)
                return self.called(rng.choice(functions)) if functions else None
            case "row":
                return rng.choice(self.rows)[0] if self.rows else None
            case "element":
                if not self.rows:
                    return None
                name, size = rng.choice(self.rows)
                return f"{name}{{{rng.randint(1, size)}}}"
        return self.value(word)

    def called(self, one: Routine) -> str:
        """A call of a function, without functions of its own in it."""
        kept, self.routines = self.routines, []
        try:
            return f"{one.name}({','.join(self.value(kind) for kind in one.types)})"
        finally:
            self.routines = kept
